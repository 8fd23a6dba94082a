"""Do intervals of rare events hold the truth? Estimators on scores of which the probability is known.

    python -m benchmarks.coverage [--repetitions 2000] [--samples 10000] [--only CASE] [--method NAME] [--jobs 1]
        [--json]

Each case is a function of genes that are standard normal numbers, and of what a scene draws. In the smooth ones the
score leads to the failures; on the others it does not, and an estimator is to say so instead of giving an interval.
Asked for: intervals of smooth cases hold the truth in at least 93.5 %, their median width is at most 1.5 times that of
as many plain draws or their ends at most a factor of 3 apart, plateaus get none, and at most 1 % of all estimates lie
apart from the interval of ten million plain draws.
"""

import argparse
import json
import math
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from scipy.special import ndtr, ndtri

from engine.kernels.random_numbers import fill_uniform
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.search.probability.estimates import Probability
from engine.search.probability.functions import TINY, evaluator, uniform_space
from engine.search.probability.monte_carlo import RARE
from engine.search.statistics import clopper_pearson
from engine.tables import Floats, Ints
from engine.vocabulary import Purpose

SMOOTH, MISLEADING, PLATEAU = "smooth", "misleading", "plateau"
TRUTH = 6.0e-5
"""Of most cases."""


class Judged(Protocol):
    """Result of the estimates on one case: a data class with a verdict."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def fine(self) -> bool: ...


Measured = TypeVar("Measured", bound=Judged)


@dataclass(frozen=True)
class Case:
    """A score of known probability."""

    name: str
    genes: int
    truth: float
    left: Callable[[Floats, Floats], Floats]
    """(n, genes), (n,) what a scene draws, all standard normal -> what is left to a failure; none or less is one."""
    kind: str = SMOOTH


def _beyond(chance: float) -> float:
    """What a standard normal number exceeds with this probability."""
    return float(-ndtri(chance))


CORRIDOR, POCKET = 0.05, TRUTH / 0.05


def _near_miss(x: Floats, _noise: Floats, slope: float) -> Floats:
    """0.3 m in a corridor of every twentieth draw, in which one in 800 fails and nothing leads there."""
    outside = np.maximum(_beyond(CORRIDOR) - x[:, 0], 0.0)
    missed = 0.3 + outside + slope * ndtr(x[:, 2])
    return np.where((outside == 0.0) & (x[:, 1] > _beyond(POCKET)), 0.0, missed)


ISLANDS = float(ndtr(-4.0) + ndtr(-4.1))
CASES = (
    Case("linear", 8, TRUTH, lambda x, _: _beyond(TRUTH) - x.sum(axis=1) / math.sqrt(8.0)),
    Case("corner", 2, TRUTH, lambda x, _: _beyond(math.sqrt(TRUTH)) - x.min(axis=1)),
    Case("two islands", 4, ISLANDS, lambda x, _: 4.0 - np.maximum(x[:, 0], -x[:, 0] - 0.1)),
    Case("half of it chance", 2, TRUTH, lambda x, noise: _beyond(TRUTH) - (x[:, 0] + noise) / math.sqrt(2.0)),
    Case("near miss, sloping", 3, TRUTH, partial(_near_miss, slope=0.01), MISLEADING),
    Case("near miss, plateau", 3, TRUTH, partial(_near_miss, slope=0.0), PLATEAU),
    Case("cliff", 2, TRUTH, lambda x, _: np.where(x[:, 0] > _beyond(TRUTH), 0.0, 1.0), PLATEAU),
)


# -- one estimate ------------------------------------------------------------------------------------------------------


def space_of(case: Case) -> ParamSpace:
    """Genes that are uniform numbers."""
    return uniform_space(case.genes)


def evaluated(case: Case, genomes: Floats, keys: Ints) -> Assessment:
    """What is left to a failure as the least distance; a failure is a collision."""

    def left(uniforms: Floats, keys: Ints) -> Floats:
        noise = np.empty((len(keys), 1))
        fill_uniform(keys, int(Purpose.SCENE), 0, noise)
        return case.left(_normal(uniforms), _normal(noise)[:, 0])

    return evaluator(left)(genomes, keys)


def _normal(uniforms: Floats) -> Floats:
    return ndtri(np.clip(uniforms, TINY, 1.0 - TINY))


def estimated(case: Case, method: str, samples: int, seed: int) -> Probability:
    return RARE[method].function(space_of(case), partial(evaluated, case), samples, seed)


# -- many of them ------------------------------------------------------------------------------------------------------

PLAIN = 10**7
"""Draws of plain Monte Carlo that an interval is held against."""
LEAST_COVERAGE, MOST_APART, MOST_WIDTH, MOST_FACTOR = 0.935, 0.01, 1.5, 3.0


@dataclass(frozen=True)
class Coverage:
    """What became of one estimator on one case."""

    case: str
    kind: str
    method: str
    given: float
    """Share of the repetitions that gave an interval."""
    holds: float
    """Share of these intervals that hold the truth; NaN without any."""
    apart: float
    """Share of the repetitions whose interval lies apart from that of `PLAIN` draws."""
    width: float
    """Median width, over that of as many plain draws."""
    factor: float
    """Median quotient of both ends."""
    simulations: float
    """Median."""
    reasons: dict[str, int]

    @property
    def fine(self) -> bool:
        if self.kind == PLATEAU:
            return self.given == 0.0
        narrow = self.width <= MOST_WIDTH or self.factor <= MOST_FACTOR
        told = self.kind == MISLEADING or math.isnan(self.holds) or (self.holds >= LEAST_COVERAGE and narrow)
        return self.apart <= MOST_APART and told


def coverage(name: str, method: str, repetitions: int, samples: int) -> Coverage:
    """Of estimates from seeds 0, 1, …"""
    case = next(case for case in CASES if case.name == name)
    found = [estimated(case, method, samples, seed) for seed in range(repetitions)]
    ends = np.array([each.interval for each in found])
    given = np.isfinite(ends[:, 0])
    low, high = ends[given].T
    plain = clopper_pearson(round(PLAIN * case.truth), PLAIN)
    simulations = float(np.median([each.simulations for each in found]))
    equal = clopper_pearson(round(simulations * case.truth), round(simulations))
    some = bool(given.any())
    return Coverage(
        case.name,
        case.kind,
        method,
        given=float(given.mean()),
        holds=float(((low <= case.truth) & (case.truth <= high)).mean()) if some else math.nan,
        apart=float(((low > plain.high) | (high < plain.low)).sum()) / repetitions,
        width=float(np.median(high - low)) / (equal.high - equal.low) if some else math.nan,
        factor=float(np.median(high / np.maximum(low, 1e-300))) if some else math.nan,
        simulations=simulations,
        reasons=dict(Counter(str(each.withheld) for each in found if each.withheld)),
    )


HEAD = (
    "| case | estimator | intervals given | of them hold the truth | apart | width, plain = 1 | high / low "
    "| simulations | instead of an interval |\n|---|---|---|---|---|---|---|---|---|"
)


def row(found: Coverage) -> str:
    """Of the table."""
    reasons = ", ".join(f"{name} {count:,}" for name, count in sorted(found.reasons.items()))
    figures = f"{100 * found.given:.1f} % | {_percent(found.holds)} | {100 * found.apart:.2f} %"
    ends = "| |" if math.isnan(found.width) else f"| {found.width:.2f} | {found.factor:.2f}"
    mark = "" if found.fine else " **missed**"
    return f"| {found.case}{mark} | {found.method} | {figures} {ends} | {found.simulations:,.0f} | {reasons} |"


def _percent(share: float) -> str:
    return "" if math.isnan(share) else f"{100 * share:.1f} %"


def main(arguments: Sequence[str] | None = None) -> int:
    found = tabulated(__doc__.splitlines()[0], [case.name for case in CASES], coverage, HEAD, row, 2000, arguments)
    return 0 if all(each.fine for each in found) else 1


def tabulated(
    description: str,
    names: Sequence[str],
    measure: Callable[[str, str, int, int], Measured],
    head: str,
    row: Callable[[Measured], str],
    repetitions: int,
    arguments: Sequence[str] | None,
) -> list[Measured]:
    """Measure each estimator on each named case, in processes; print a row as soon as it is there, or one document.

    `measure`: from name, estimator, number of repetitions and of samples; `repetitions`: their usual number.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--repetitions", type=int, default=repetitions, help="of each estimator on each case")
    parser.add_argument("--samples", type=int, default=10_000, help="as of `cortexc probability`")
    parser.add_argument("--only", choices=names, help="one case")
    parser.add_argument("--method", choices=RARE, help="one estimator")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    chosen = [name for name in names if options.only in (None, name)]
    asked = [(name, method) for name in chosen for method in RARE if options.method in (None, method)]
    if not options.json:
        print(head)
    found: list[Measured] = []
    with ProcessPoolExecutor(options.jobs) as pool:
        for waiting in [pool.submit(measure, *each, options.repetitions, options.samples) for each in asked]:
            found.append(waiting.result())
            if not options.json:
                print(row(found[-1]), flush=True)
    if options.json:
        print(json.dumps([{**asdict(each), "fine": each.fine} for each in found], indent=2))
    return found


if __name__ == "__main__":
    raise SystemExit(main())
