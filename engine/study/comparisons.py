"""Methods held against the baseline, run by run. The unit of analysis is one run, as what lies inside one is not
independent.

Two-sided Mann-Whitney tests, corrected by Holm over each family (all scenarios and contenders together); A12 of Vargha
and Delaney with a 95 % interval (bootstrap, and no narrower than Newcombe's, which stays honest where every run of one
method beats every run of the other), oriented so that above 0.5 the contender is better. *Beats* means: better
median, Holm's p below 0.05, and A12 above 0.64 (their "medium"). *Loses* is the same the other way round.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.search.statistics import Interval, a12, a12_bounds, holm, mann_whitney
from engine.study.measures import MEASURES, Measure
from engine.study.plan import Plan
from engine.study.records import RunRecord
from engine.tables import Floats

LEVEL = 0.05
MEDIUM = 0.64
STARS = ((0.001, "***"), (0.01, "**"), (LEVEL, "*"))


@dataclass(frozen=True)
class Spread:
    """One measure over the runs of one method on one scenario; runs without the number are left out."""

    runs: int
    median: float
    quartiles: Interval
    mean: float
    deviation: float
    """Standard deviation, n - 1; NaN under two runs."""


@dataclass(frozen=True)
class Comparison:
    """One measure of a contender against the baseline on one scenario."""

    scenario: str
    method: str
    baseline: str
    measure: Measure
    spread: Spread
    baseline_spread: Spread
    p: float
    p_holm: float
    """Within the measure's family; NaN where there is nothing to compare."""
    a12: float
    interval: Interval
    """95 %, see `a12_bounds`."""
    generations: int = 0
    """Of each run."""

    @property
    def title(self) -> str:
        """The measure's name; it says so where its last ten generations are all of them."""
        return self.measure.told(self.generations)

    @property
    def stars(self) -> str:
        """*** < 0.001, ** < 0.01, * < 0.05, by Holm's p."""
        return next((stars for limit, stars in STARS if self.p_holm < limit), "")

    @property
    def beats(self) -> bool:
        return self._better > 0 and self.p_holm < LEVEL and self.a12 > MEDIUM

    @property
    def loses(self) -> bool:
        return self._better < 0 and self.p_holm < LEVEL and self.a12 < 1.0 - MEDIUM

    @property
    def _better(self) -> float:
        """Difference of medians, positive where the contender is better."""
        return self.measure.orientation * (self.spread.median - self.baseline_spread.median)


def sample(records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Floats:
    """One number for each finished run of a cell, those without one left out."""
    chosen = [record for record in records if record.address[:2] == (scenario, method)]
    values = np.array([measure.of(record.figures) for record in chosen], dtype=np.float64)
    return values[~np.isnan(values)]


def spread(values: Floats) -> Spread:
    """NaN where there are no values."""
    if not len(values):
        nan = float("nan")
        return Spread(0, nan, Interval(nan, nan), nan, nan)
    low, median, high = np.quantile(values, [0.25, 0.5, 0.75]).tolist()
    deviation = float(values.std(ddof=1)) if len(values) > 1 else float("nan")
    return Spread(len(values), median, Interval(low, high), float(values.mean()), deviation)


def compare_all(
    plan: Plan, records: Sequence[RunRecord], measures: Sequence[Measure] = MEASURES
) -> tuple[Comparison, ...]:
    """Every measure on every scenario for every contender, corrected by families."""
    rows = [
        _compare(plan, records, scenario, method, measure)
        for scenario in range(len(plan.subjects))
        for method in plan.contenders
        for measure in measures
    ]
    return corrected(rows)


def _compare(plan: Plan, records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Comparison:
    ours = sample(records, scenario, method, measure)
    baseline = sample(records, scenario, plan.baseline, measure)
    sign = measure.orientation
    return Comparison(
        scenario=plan.subjects[scenario].name,
        method=method,
        baseline=plan.baseline,
        measure=measure,
        spread=spread(ours),
        baseline_spread=spread(baseline),
        p=mann_whitney(ours, baseline),
        p_holm=float("nan"),
        a12=a12(sign * ours, sign * baseline),
        interval=a12_bounds(sign * ours, sign * baseline),
        generations=plan.subjects[scenario].config.search.generations,
    )


def corrected(rows: Sequence[Comparison]) -> tuple[Comparison, ...]:
    """Each row with its Holm p within its family."""
    adjusted: dict[int, float] = {}
    for family in dict.fromkeys(row.measure.family for row in rows):
        members = [number for number, row in enumerate(rows) if row.measure.family == family]
        adjusted |= dict(zip(members, holm([rows[number].p for number in members]), strict=True))
    return tuple(replace(row, p_holm=adjusted[number]) for number, row in enumerate(rows))
