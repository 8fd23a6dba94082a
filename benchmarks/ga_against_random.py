"""Does the genetic algorithm beat chance? Many runs of both on each scenario, compared run by run.

    python -m benchmarks.ga_against_random --runs 30 --jobs 2

The table of `cortexc study` in Markdown, by the same code: what is compared, the families of tests and what "beats"
means stand in `engine.study.comparisons` and `engine.study.comparisons`.
"""

import sys
from collections.abc import Sequence
from typing import Any

from benchmarks.campaigns import carried_out, parser, plan_of
from cortex_dsl.report.findings.study_report import yields_text
from engine.strict_json import json_text
from engine.study.comparisons import MEASURES, NAMED_FIRST, Comparison, compare_all
from engine.study.study_files import test_row

SHOWN = (*(measure.name for measure in NAMED_FIRST), "RL", "NC", "MDG", "MDEC", "NIS", "NIS, last 10")


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    plan = plan_of(options, ("random", "ga"))
    records, seconds = carried_out(plan, options.jobs, options.keep)
    rows = compare_all(plan, records, [measure for measure in MEASURES if measure.name in SHOWN])
    settings = {
        "runs": options.runs,
        "generations": options.generations,
        "population": options.population,
        "preset": options.preset,
        "seed": options.seed,
        "seconds": round(seconds, 1),
    }
    layout = as_json if options.json else as_short_markdown if options.short else as_markdown
    print(layout(settings, rows))
    if not options.json:
        print("", *(f"- {text}." for text in yields_text(plan, records)), sep="\n")
    return 0


def parse(arguments: Sequence[str] | None) -> Any:
    made = parser(__doc__, runs=30)
    made.add_argument("--short", action="store_true", help="print one line a scenario, medians only")
    return made.parse_args(arguments)


def as_json(settings: dict[str, Any], rows: Sequence[Comparison]) -> str:
    document = {"benchmark": "ga_against_random", **settings, "comparisons": [test_row(row) for row in rows]}
    return json_text(document, indent=2)


def as_markdown(settings: dict[str, Any], rows: Sequence[Comparison]) -> str:
    """One line a scenario and measure: medians, Holm p, A12 with its interval."""
    head = (
        "| scenario | measure | GA | random | p (Holm) | A12 (95 %) | GA beats random |\n|---|---|---|---|---|---|---|"
    )
    return "\n".join([title(settings), "", head, *map(markdown_row, rows)])


def as_short_markdown(settings: dict[str, Any], rows: Sequence[Comparison]) -> str:
    """One line a scenario: the medians of both methods, in bold where one beats the other."""
    names = [name for name in SHOWN if any(row.measure.name == name for row in rows)]
    lines = [
        f"{title(settings)} Each cell: GA / random; bold where one beats the other.",
        "",
        f"| scenario | {' | '.join(names)} |",
        f"|---|{'---|' * len(names)}",
    ]
    for scenario in dict.fromkeys(row.scenario for row in rows):
        cells = {row.measure.name: short_cell(row) for row in rows if row.scenario == scenario}
        lines.append(f"| {scenario} | {' | '.join(cells[name] for name in names)} |")
    return "\n".join(lines)


def short_cell(row: Comparison) -> str:
    ga, random = (short(value, row) for value in (row.spread.median, row.baseline_spread.median))
    return f"{bold(ga, row.beats)} / {bold(random, row.loses)}"


def bold(text: str, really: bool) -> str:
    return f"**{text}**" if really else text


def title(settings: dict[str, Any]) -> str:
    return (
        f"Medians over {settings['runs']} runs of {settings['generations']} x {settings['population']} individuals, "
        f"preset `{settings['preset']}` against random (seed {settings['seed']})."
    )


def markdown_row(row: Comparison) -> str:
    p = "< 0.0001" if row.p_holm < 1e-4 else f"{row.p_holm:.4f}"
    low, high = row.interval
    medians = f"{short(row.spread.median, row)} | {short(row.baseline_spread.median, row)}"
    verdict = {"better": "yes", "worse": "loses", "no clear difference": "no"}.get(row.words, row.words)
    effect = f"{row.a12:.2f} ({low:.2f} .. {high:.2f})"
    return f"| {row.scenario} | {row.measure.name} | {medians} | {p} | {effect} | {verdict} |"


def short(value: float, row: Comparison) -> str:
    if abs(value) == float("inf"):  # the run in the middle has no such number
        return "none"
    return f"{value:.{row.measure.decimals}f}" if row.measure.decimals else f"{value:g}"


if __name__ == "__main__":
    sys.exit(main())
