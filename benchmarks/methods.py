"""Which searcher is good at what? All of them at equal budget over the six examples.

    python -m benchmarks.methods --runs 30 --jobs 2

| column            | meaning, a median over runs, then over scenarios                                        |
|-------------------|-----------------------------------------------------------------------------------------|
| avoidable         | distinct simulations with a collision that a competent driver avoids                    |
| avoidable kinds   | kinds of these (see `engine.search.insight.kinds`)                                      |
| colliding genomes | different genomes that collided: the yield                                              |
| kinds             | kinds of all collisions: the variety                                                    |
| cells             | cells of the descriptor grids (see `engine.search.insight.diversity`) with a collision          |
| invalid           | share of individuals without a scene                                                    |
| first             | distinct simulations until the first collision                                          |
| simulations       | distinct simulations: an elite that is kept is not simulated again                      |
| avoidable of valid | avoidable collisions of valid simulations, (n + 1) / (N + 2)                            |
| avoidable a second | the same for the time that a run took                                                  |
| seconds           | of one run on one core                                                                  |

`+n` and `-n`: in n scenarios better or worse than random, by the rule of `engine.study.comparisons`, which asks for 30
runs. A column without them says nothing of equality.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from benchmarks.campaigns import carried_out, parser, plan_of
from engine.search.searchers import SEARCHERS
from engine.strict_json import json_text
from engine.study.comparisons import (
    AVOIDABLE,
    AVOIDABLE_KINDS,
    FAILING_CELLS,
    KINDS,
    MEASURES,
    PRIMARY,
    Comparison,
    Measure,
    compare_all,
    spread,
)
from engine.study.plan import RUNS, Plan
from engine.study.run_records import RunRecord

FIRST = next(measure for measure in MEASURES if measure.name == "first collision")
INVALID = next(measure for measure in MEASURES if measure.name == "NIS")
COMPARED = (AVOIDABLE, AVOIDABLE_KINDS, PRIMARY, KINDS, FAILING_CELLS, INVALID, FIRST)


@dataclass(frozen=True)
class Column:
    """One number of each run, and the comparison that says where it is better than random's."""

    title: str
    of: Callable[[RunRecord], float]
    compared: Measure | None = None
    decimals: int = 0
    larger_is_better: bool = True


COLUMNS = (
    Column("avoidable", lambda r: AVOIDABLE.of(r.figures), AVOIDABLE),
    Column("avoidable kinds", lambda r: AVOIDABLE_KINDS.of(r.figures), AVOIDABLE_KINDS),
    Column("colliding genomes", lambda r: PRIMARY.of(r.figures), PRIMARY),
    Column("kinds", lambda r: KINDS.of(r.figures), KINDS),
    Column("cells", lambda r: FAILING_CELLS.of(r.figures), FAILING_CELLS),
    Column(
        "invalid %", lambda r: 100.0 * r.figures.individuals.nis / r.figures.individuals.individuals, INVALID, 1, False
    ),
    Column("first", lambda r: FIRST.of(r.figures), FIRST, 0, False),
    Column("simulations", lambda r: float(r.figures.simulations.runs)),
    Column("avoidable of valid %", lambda r: 100.0 * _share(r), None, 2),
    Column("avoidable a second", lambda r: AVOIDABLE.of(r.figures) / r.seconds, None, 1),
    Column("seconds", lambda r: r.seconds, None, 2, False),
)


def _share(record: RunRecord) -> float:
    """Avoidable collisions of valid simulations: (n + 1) / (N + 2)."""
    return (AVOIDABLE.of(record.figures) + 1.0) / (record.figures.simulations.valid_runs + 2.0)


def main(arguments: Sequence[str] | None = None) -> int:
    made = parser(__doc__, runs=30)
    made.add_argument("--methods", default="all", help="names with commas between them (all that are installed)")
    made.add_argument("--each", action="store_true", help="avoidable kinds and collisions of each scenario instead")
    options = made.parse_args(arguments)
    plan = plan_of(options, methods_of(options.methods))
    records, seconds = carried_out(plan, options.jobs, options.keep)
    comparisons = compare_all(plan, records, COMPARED)
    if options.each:
        print(of_each(plan, records))
    elif options.json:
        print(as_json(plan, records, comparisons, seconds))
    else:
        print(as_markdown(plan, records, comparisons))
    return 0


def methods_of(text: str) -> list[str]:
    """The names asked for, the baseline first."""
    if text != "all":
        return text.split(",")
    here = [name for name, entry in SEARCHERS.items() if not entry.package or find_spec(entry.package)]
    return sorted(here, key=lambda name: name != "random")


def number(plan: Plan, records: Sequence[RunRecord], method: str, column: Column) -> float:
    """The median over scenarios of the medians over runs; a run without the number counts as the worst there is."""
    worst = -np.inf if column.larger_is_better else np.inf
    medians = []
    for scenario in range(len(plan.subjects)):
        values = np.array([column.of(r) for r in records if r.address[:2] == (scenario, method)])
        medians.append(spread(np.where(np.isnan(values), worst, values)).median)
    return spread(np.array(medians)).median


def of_each(plan: Plan, records: Sequence[RunRecord]) -> str:
    """One line a scenario: medians of avoidable kinds, of avoidable collisions, and of seconds, by method."""
    columns = "".join(f" {method} |" for method in plan.methods)
    lines = [f"Medians over {plan.runs} runs: kinds (collisions), seconds.", "", f"| scenario |{columns}"]
    lines.append(f"|---|{'---|' * len(plan.methods)}")
    for number_of, subject in enumerate(plan.subjects):
        cells = []
        for method in plan.methods:
            rows = [r for r in records if r.address[:2] == (number_of, method)]
            kinds, all_of = (
                spread(np.array([m.of(r.figures) for r in rows])).median for m in (AVOIDABLE_KINDS, AVOIDABLE)
            )
            seconds = spread(np.array([row.seconds for row in rows])).median
            cells.append(f"{kinds:g} ({all_of:g}), {seconds:.2f}")
        lines.append(f"| {subject.name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def as_markdown(plan: Plan, records: Sequence[RunRecord], comparisons: Sequence[Comparison]) -> str:
    """One line a method; the best of a column is bold."""
    search = plan.subjects[0].config.search
    lines = [
        f"Medians over {plan.runs} runs of {search.generations} x {search.population}; {len(plan.subjects)} scenarios.",
        f"`+n`, `-n`: in n of them surely and not slightly better or worse than `{plan.baseline}`; bold: best of all.",
        "",
        f"| method | {' | '.join(column.title for column in COLUMNS)} |",
        f"|---|{'---|' * len(COLUMNS)}",
    ]
    table = {method: [number(plan, records, method, column) for column in COLUMNS] for method in plan.methods}
    for method, values in table.items():
        cells = [
            cell(method, column, value, [row[place] for row in table.values()], comparisons)
            for place, (column, value) in enumerate(zip(COLUMNS, values, strict=True))
        ]
        lines.append(f"| {method} | {' | '.join(cells)} |")
    few = [f"- With fewer than {RUNS} runs nothing is decided."] if plan.runs < RUNS else []
    return "\n".join([*lines, "", *few, *honest(plan, comparisons)])


def cell(
    method: str, column: Column, value: float, everyone: Sequence[float], comparisons: Sequence[Comparison]
) -> str:
    if np.isinf(value):
        return "never"
    text = f"{value:.{column.decimals}f}"
    if column.compared is not None and value == (max if column.larger_is_better else min)(everyone):
        text = f"**{text}**"
    more, fewer = tally(method, column.compared, comparisons)
    return text + (f" +{more}" if more else "") + (f" -{fewer}" if fewer else "")


def tally(method: str, measure: Measure | None, comparisons: Sequence[Comparison]) -> tuple[int, int]:
    """In how many scenarios the method beats random, and in how many it loses."""
    rows = [row for row in comparisons if row.method == method and row.measure is measure]
    return sum(row.beats for row in rows), sum(row.loses for row in rows)


def honest(plan: Plan, comparisons: Sequence[Comparison]) -> list[str]:
    """Where random sampling, or any other method, is the better choice."""
    lines = []
    for method in plan.contenders:
        worse = [m.name for m in COMPARED if tally(method, m, comparisons)[1]]
        if worse:
            lines.append(f"- `{method}` is worse than `{plan.baseline}` somewhere in: {', '.join(worse)}.")
    return lines


def as_json(plan: Plan, records: Sequence[RunRecord], comparisons: Sequence[Comparison], seconds: float) -> str:
    rows = {
        method: {column.title: number(plan, records, method, column) for column in COLUMNS} for method in plan.methods
    }
    better = {
        method: {m.name: dict(zip(("beats", "loses"), tally(method, m, comparisons), strict=True)) for m in COMPARED}
        for method in plan.contenders
    }
    document = {
        "benchmark": "methods",
        "runs": plan.runs,
        "seconds": seconds,
        "methods": rows,
        "against_random": better,
    }
    return json_text(document, indent=2)


if __name__ == "__main__":
    sys.exit(main())
