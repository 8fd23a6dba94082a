"""Methods held against the baseline, run by run. The unit of analysis is one run, as what lies inside one is not
independent.

Two-sided Mann-Whitney tests, corrected by Holm over each family (all scenarios and contenders together); A12 of Vargha
and Delaney with a 95 % interval (bootstrap, and no narrower than Newcombe's, which stays honest where every run of one
method beats every run of the other), oriented so that above 0.5 the contender is better. *Beats* means: at least 30
runs of each, better median, Holm's p below 0.05, and A12 above 0.64 (their "medium"). *Loses* is the same the other way
round. With fewer runs nothing is decided.

A run without the number, such as one that never collided and so has no first collision, is not left out, which would
reward a method for failing: it ranks behind every run that has one, in medians, tests and A12 alike. What is meant by
worst is known for ranks only, so that there is no mean then.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.search.statistics import Interval, a12, a12_bounds, holm, mann_whitney
from engine.study.measures import FIRST, Measure, measures_of
from engine.study.plan import RUNS, Plan
from engine.study.records import RunRecord
from engine.tables import Floats

LEVEL = 0.05
MEDIUM = 0.64
STARS = ((0.001, "***"), (0.01, "**"), (LEVEL, "*"))


@dataclass(frozen=True)
class Spread:
    """One measure over the runs of one method on one scenario; runs without the number rank last."""

    runs: int
    median: float
    """Infinite where the run in the middle has no number; minus infinity if larger is better."""
    quartiles: Interval
    mean: float
    """NaN where a run has no number."""
    deviation: float
    """Standard deviation, n - 1; NaN under two runs, and where a run has no number."""
    missing: int = 0
    """Runs without the number."""


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
    budget: int = 0
    """Simulations of each run, at most."""

    @property
    def title(self) -> str:
        """The measure's name; it says so where its last ten generations are all of them."""
        return self.measure.told(self.generations)

    @property
    def stars(self) -> str:
        """*** < 0.001, ** < 0.01, * < 0.05, by Holm's p."""
        return next((stars for limit, stars in STARS if self.p_holm < limit), "")

    @property
    def marks(self) -> str:
        """The stars behind ▲ where the method is better, ▼ where it is worse; nothing without a star."""
        return f"{'▲' if self.a12 > 0.5 else '▼'}{self.stars}" if self.stars else ""

    @property
    def runs(self) -> int:
        """Of the method with fewer of them."""
        return min(self.spread.runs, self.baseline_spread.runs)

    @property
    def decided(self) -> bool:
        """Whether there are runs enough to say that one beats the other, or that no difference is clear."""
        return self.runs >= RUNS

    @property
    def beats(self) -> bool:
        return self.decided and self._better and self.p_holm < LEVEL and self.a12 > MEDIUM

    @property
    def loses(self) -> bool:
        return self.decided and self._worse and self.p_holm < LEVEL and self.a12 < 1.0 - MEDIUM

    @property
    def words(self) -> str:
        """What may be said in a word or two."""
        if not self.decided:
            return f"undecided at {self.runs} run{'' if self.runs == 1 else 's'}"
        return "better" if self.beats else "worse" if self.loses else "no clear difference"

    @property
    def missing(self) -> str:
        """`22 of 30 never collided`, the baseline's behind it; empty where every run has its number."""
        spreads = ((self.method, self.spread), (self.baseline, self.baseline_spread))
        why = "never collided" if self.measure.name == FIRST else "have no such number"
        told = [f"{name}: {each.missing} of {each.runs} {why}" for name, each in spreads if each.missing]
        return "; ".join(told)

    @property
    def _better(self) -> bool:
        """Whether the contender's median is."""
        sign = self.measure.orientation
        return sign * self.spread.median > sign * self.baseline_spread.median

    @property
    def _worse(self) -> bool:
        sign = self.measure.orientation
        return sign * self.spread.median < sign * self.baseline_spread.median


def sample(records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Floats:
    """One number for each finished run of a cell that has one: to be drawn. Whatever compares takes `ranked`."""
    values = ranked(records, scenario, method, measure)
    return values[np.isfinite(values)]


def ranked(records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Floats:
    """One number for each finished run of a cell; a run without one has the worst there can be, an infinite one."""
    chosen = [record for record in records if record.address[:2] == (scenario, method)]
    values = np.array([measure.of(record.figures) for record in chosen], dtype=np.float64)
    return np.where(np.isnan(values), -measure.orientation * np.inf, values)


def spread(values: Floats) -> Spread:
    """Of values as `ranked` gives them; NaN where there are none."""
    nan = float("nan")
    if not len(values):
        return Spread(0, nan, Interval(nan, nan), nan, nan)
    missing = int((~np.isfinite(values)).sum())
    low, median, high = (_quantile(values, level) for level in (0.25, 0.5, 0.75))
    mean = nan if missing else float(values.mean())
    deviation = nan if missing or len(values) < 2 else float(values.std(ddof=1))
    return Spread(len(values), median, Interval(low, high), mean, deviation, missing)


def _quantile(values: Floats, level: float) -> float:
    """numpy's; between a number and an infinite one it is infinite."""
    place = level * (len(values) - 1)
    ends = np.sort(values)[[math.floor(place), math.ceil(place)]]
    if np.isfinite(ends).all():
        return float(np.quantile(np.where(np.isfinite(values), values, np.sign(values) * 1e300), level))
    return float(ends[~np.isfinite(ends)][0])


def compare_all(
    plan: Plan, records: Sequence[RunRecord], measures: Sequence[Measure] | None = None
) -> tuple[Comparison, ...]:
    """Every measure (None: all that say something of their own) on every scenario for every contender, corrected by
    families.
    """
    if measures is None:
        measures = measures_of(plan.subjects[0].config.search.rollouts)
    rows = [
        _compare(plan, records, scenario, method, measure)
        for scenario in range(len(plan.subjects))
        for method in plan.contenders
        for measure in measures
    ]
    return corrected(rows)


def _compare(plan: Plan, records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Comparison:
    ours = ranked(records, scenario, method, measure)
    baseline = ranked(records, scenario, plan.baseline, measure)
    sign, search = measure.orientation, plan.subjects[scenario].config.search
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
        generations=search.generations,
        budget=search.generations * search.population * search.rollouts,
    )


def corrected(rows: Sequence[Comparison]) -> tuple[Comparison, ...]:
    """Each row with its Holm p within its family."""
    adjusted: dict[int, float] = {}
    for family in dict.fromkeys(row.measure.family for row in rows):
        members = [number for number, row in enumerate(rows) if row.measure.family == family]
        adjusted |= dict(zip(members, holm([rows[number].p for number in members]), strict=True))
    return tuple(replace(row, p_holm=adjusted[number]) for number, row in enumerate(rows))
