"""Does the genetic algorithm beat chance? Many runs of both on each scenario, compared run by run.

    python -m benchmarks.ga_against_random --runs 30 --jobs 2

The unit of analysis is one run. The primary outcome, named first, is the number of different genomes that collided in
a run; its p values (Mann-Whitney, one a scenario) are one Holm family. RL, MDG, MDEC and NIS over the run are the
second family; NC, which counts elites again in every generation that keeps them, as the paper does, is a third; the
invalid cases of the last ten generations a fourth. A12 is oriented so that above 0.5 the genetic algorithm is better,
with a bootstrap 95 % interval. "Beats" = better median, Holm p < 0.05 and A12 > 0.64 (Vargha and Delaney's medium).
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cortex_dsl.session import Scenario, load
from engine.search.campaign import Campaign
from engine.search.figures import Figures
from engine.search.journal import finite
from engine.search.statistics import a12, bootstrap_interval, holm, mann_whitney
from engine.search.study import search
from engine.tables import Floats

EXAMPLES = Path(__file__).parent.parent / "examples"
LETTERS = (
    "left_turn",
    "left_against_crossing",
    "crossing_left_turn",
    "right_and_oncoming_left",
    "right_into_crossing",
    "three_way_left",
)
"""The paper's A to F, in its order."""
LAST = 10
MEDIUM = 0.64
LEVEL = 0.05


@dataclass(frozen=True)
class Measure:
    """One number a run."""

    name: str
    family: str
    """Tests of one family are corrected together."""
    larger_is_better: bool
    of: Callable[[Campaign], float]


def whole(attribute: str) -> Callable[[Campaign], float]:
    """A figure of the whole run, by individual."""

    def read(campaign: Campaign) -> float:
        figures: Figures = campaign.by_individual
        return float(getattr(figures, attribute))

    return read


MEASURES = (
    Measure("distinct collisions", "primary", True, lambda campaign: float(campaign.distinct_collisions)),
    Measure("RL", "secondary", True, whole("rl")),
    Measure("NC", "as the paper counts", True, whole("nc")),
    Measure("MDG", "secondary", False, whole("mdg")),
    Measure("MDEC", "secondary", False, whole("mdec")),
    Measure("NIS", "secondary", False, whole("nis")),
    Measure("NIS, last 10", "last generations", False, lambda campaign: float(campaign.last(LAST).nis)),
)


@dataclass(frozen=True)
class Comparison:
    """One measure on one scenario, over all runs of both methods."""

    scenario: str
    measure: str
    family: str
    ga: float
    """Median."""
    random: float
    """Median."""
    ga_quartiles: tuple[float, float]
    random_quartiles: tuple[float, float]
    p: float
    p_holm: float
    a12: float
    """Above 0.5: the genetic algorithm is better."""
    a12_interval: tuple[float, float]
    beats: bool


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    start = time.perf_counter()
    rows: list[Comparison] = []
    for path in options.files:
        begun = time.perf_counter()
        samples = run_scenario(load(path), options)
        rows += [compare(path.stem, measure, samples) for measure in MEASURES]
        note(f"{path.stem}: {2 * options.runs} runs in {time.perf_counter() - begun:.1f} s")
    rows = corrected(rows)
    settings = {
        "runs": options.runs,
        "generations": options.generations,
        "population": options.population,
        "preset": options.preset,
        "first_seed": options.seed,
        "seconds": round(time.perf_counter() - start, 1),
    }
    told = as_json if options.json else as_short_markdown if options.short else as_markdown
    print(told(settings, rows))
    return 0


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("files", nargs="*", type=Path, help="scenarios (the six examples)")
    parser.add_argument("--runs", type=int, default=30, help="runs of each method on each scenario (30)")
    parser.add_argument("--generations", type=int, default=30)
    parser.add_argument("--population", type=int, default=100)
    parser.add_argument("--preset", choices=("cortex", "cortex-literal"), default="cortex")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first run; the others follow (0)")
    parser.add_argument("--jobs", type=int, default=1, help="runs side by side; results never depend on it (1)")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead of a table")
    parser.add_argument("--short", action="store_true", help="print one line a scenario, medians only")
    options = parser.parse_args(arguments)
    options.files = options.files or [EXAMPLES / f"{name}.scn" for name in LETTERS]
    return options


def run_scenario(scenario: Scenario, options: argparse.Namespace) -> dict[str, dict[str, Floats]]:
    """For each method and measure, one number a run."""
    tasks = [(method, options.seed + run) for run in range(options.runs) for method in ("ga", "random")]

    def measured(task: tuple[str, int]) -> tuple[str, list[float]]:
        method, seed = task
        campaign = run_search(scenario, method, seed, options)
        return method, [measure.of(campaign) for measure in MEASURES]

    with ThreadPoolExecutor(options.jobs) as pool:
        found = list(pool.map(measured, tasks))
    return {
        method: dict(
            zip((m.name for m in MEASURES), np.array([row for name, row in found if name == method]).T, strict=True)
        )
        for method in ("ga", "random")
    }


def run_search(scenario: Scenario, method: str, seed: int, options: argparse.Namespace) -> Campaign:
    """One run; genes are not probed, the comparison needs only what was searched."""
    settings = replace(
        scenario.config.search,
        seed=seed,
        generations=options.generations,
        population=options.population,
        probes=0,
    )
    config = replace(scenario.config, search=settings, ga=replace(scenario.config.ga, preset=options.preset))
    return search(scenario.program, method, config)


def compare(scenario: str, measure: Measure, samples: dict[str, dict[str, Floats]]) -> Comparison:
    """Medians, quartiles, uncorrected p and effect size; runs without the number (no valid case) are left out."""
    ga, random = (known(samples[method][measure.name]) for method in ("ga", "random"))
    sign = 1.0 if measure.larger_is_better else -1.0
    interval = bootstrap_interval(sign * ga, sign * random)
    return Comparison(
        scenario=scenario,
        measure=measure.name,
        family=measure.family,
        ga=median(ga),
        random=median(random),
        ga_quartiles=quartiles(ga),
        random_quartiles=quartiles(random),
        p=mann_whitney(ga, random),
        p_holm=float("nan"),
        a12=a12(sign * ga, sign * random),
        a12_interval=(interval.low, interval.high),
        beats=sign * median(ga) > sign * median(random),
    )


def known(values: Floats) -> Floats:
    return values[~np.isnan(values)]


def median(values: Floats) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def quartiles(values: Floats) -> tuple[float, float]:
    low, high = np.quantile(values, [0.25, 0.75]) if len(values) else (np.nan, np.nan)
    return float(low), float(high)


def corrected(rows: Sequence[Comparison]) -> list[Comparison]:
    """Each row with its Holm p within its family, and whether the genetic algorithm beats chance in it."""
    adjusted: dict[int, float] = {}
    for family in dict.fromkeys(row.family for row in rows):
        members = [number for number, row in enumerate(rows) if row.family == family]
        adjusted |= dict(zip(members, holm([rows[number].p for number in members]), strict=True))
    return [
        replace(row, p_holm=adjusted[number], beats=row.beats and adjusted[number] < LEVEL and row.a12 > MEDIUM)
        for number, row in enumerate(rows)
    ]


def as_json(settings: dict[str, Any], rows: Sequence[Comparison]) -> str:
    document = {"benchmark": "ga_against_random", **settings, "comparisons": [asdict(row) for row in rows]}
    return json.dumps(finite(document), indent=2, allow_nan=False)


def as_markdown(settings: dict[str, Any], rows: Sequence[Comparison]) -> str:
    """One line a scenario and measure: medians, Holm p, A12 with its interval."""
    head = (
        "| scenario | measure | GA | random | p (Holm) | A12 (95 %) | GA beats random |\n|---|---|---|---|---|---|---|"
    )
    return "\n".join([title(settings), "", head, *map(markdown_row, rows)])


def as_short_markdown(settings: dict[str, Any], rows: Sequence[Comparison]) -> str:
    """One line a scenario: the medians of both methods, in bold where the genetic algorithm beats chance."""
    names = [measure.name for measure in MEASURES]
    lines = [
        f"{title(settings)} Each cell: GA / random; bold where the GA beats random.",
        "",
        f"| scenario | {' | '.join(names)} |",
        f"|---|{'---|' * len(names)}",
    ]
    for scenario in dict.fromkeys(row.scenario for row in rows):
        cells = [short_cell(row) for row in rows if row.scenario == scenario]
        lines.append(f"| {scenario} | {' | '.join(cells)} |")
    return "\n".join(lines)


def short_cell(row: Comparison) -> str:
    mark = "**" if row.beats else ""
    return f"{mark}{short(row.ga)}{mark} / {short(row.random)}"


def title(settings: dict[str, Any]) -> str:
    return (
        f"Medians over {settings['runs']} runs of {settings['generations']} x {settings['population']} individuals, "
        f"preset `{settings['preset']}` against random (seeds from {settings['first_seed']})."
    )


def markdown_row(row: Comparison) -> str:
    low, high = row.a12_interval
    p = "< 0.0001" if row.p_holm < 1e-4 else f"{row.p_holm:.4f}"
    numbers = f"{short(row.ga)} | {short(row.random)} | {p} | {row.a12:.2f} ({low:.2f} .. {high:.2f})"
    return f"| {row.scenario} | {row.measure} | {numbers} | {'yes' if row.beats else 'no'} |"


def short(value: float) -> str:
    return f"{value:.0f}" if value == round(value) else f"{value:.2f}"


def note(text: str) -> None:
    """Progress goes where it disturbs no reader of the results."""
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
