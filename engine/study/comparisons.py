"""Measures of the runs of a study, and comparisons of methods with the baseline. The unit of analysis is one run, as
the individuals of a run are not independent.

Each measure is one number per run, and belongs to one family of tests. Four primary outcomes are tested as one family:
collisions that a competent driver avoids and the kinds of these, different genomes that collided, which is the yield,
and kinds of all collisions, which is its variety. The paper's other four metrics over the whole run, counted by
individual as the paper does, are the second family (twenty-four tests for six scenarios and one contender). All other
measures are exploratory: each further family is corrected within itself, but the choice of one family out of many is
not.

Two-sided Mann-Whitney tests, corrected by Holm over each family (all scenarios and contenders together); A12 of Vargha
and Delaney with a 95 % interval (bootstrap, and no narrower than Newcombe's, which has a width even if every run of one
method beats every run of the other method), oriented so that the contender is better above 0.5. *Beats* means: at least
30 runs of each, better median, Holm's p below 0.05, and A12 above 0.64 (their "medium"). *Loses* is the reverse. With
fewer runs the result is undecided.

A run without the number, such as a run without a first collision, is included, as its omission would reward a method
for failing: it ranks behind every run with a number, in medians, tests and A12. The worst value is defined for ranks
only, so there is no mean in this case.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.display import counted
from engine.search.statistics import Interval, a12, a12_bounds, holm, mann_whitney
from engine.study.plan import RUNS, Plan
from engine.study.run_records import LAST, RunFigures, RunRecord
from engine.tables import Floats

# -- measures ----------------------------------------------------------------------------------------------------------

PRIMARY_FAMILY, SECONDARY_FAMILY = "primary", "secondary"


@dataclass(frozen=True)
class Measure:
    """One number per run; NaN if a run has none, which is worse than any number."""

    name: str
    meaning: str
    family: str
    larger_is_better: bool
    of: Callable[[RunFigures], float]
    decimals: int = 0
    unit: str = ""

    @property
    def exploratory(self) -> bool:
        """Return True if the measure is exploratory: it is reported, but confirms nothing by itself."""
        return self.family not in (PRIMARY_FAMILY, SECONDARY_FAMILY)

    @property
    def orientation(self) -> float:
        """Return 1 if larger is better, else -1."""
        return 1.0 if self.larger_is_better else -1.0

    def counted(self, generations: int) -> int:
        """Return the number of generations that the measure counts, for runs of `generations`."""
        return min(LAST, generations) if f"last {LAST}" in self.name else generations

    def title_for(self, generations: int) -> str:
        """Return the name for runs of `generations`: in runs of up to ten, the last ten are all generations."""
        return self.name if generations > LAST else self.name.replace(f"last {LAST}", f"all {generations}")


def _figure(group: str, field: str) -> Callable[[RunFigures], float]:
    def read(figures: RunFigures) -> float:
        return float(getattr(getattr(figures, group), field))

    return read


def _own(field: str) -> Callable[[RunFigures], float]:
    def read(figures: RunFigures) -> float:
        return float(getattr(figures, field))

    return read


_FIVE = (
    ("RL", "mean risk of valid runs", "rl", True, 2, ""),
    ("NC", "collisions", "nc", True, 0, ""),
    ("MDG", "mean least distance", "mdg", False, 2, "m"),
    ("MDEC", "the same without collisions", "mdec", False, 2, "m"),
    ("NIS", "invalid", "nis", False, 0, ""),
)


def _five(group: str, where: str, family: str, leave_out: tuple[str, ...] = ()) -> tuple[Measure, ...]:
    """Return the paper's metrics over one group of figures."""
    return tuple(
        Measure(f"{name}{where}", meaning, family, larger, _figure(group, field), decimals, unit)
        for name, meaning, field, larger, decimals, unit in _FIVE
        if name not in leave_out
    )


PRIMARY = Measure(
    "colliding genomes", "different genomes that collided", PRIMARY_FAMILY, True, _own("distinct_collisions")
)
"""Genomes count as different if a single bit differs: a yield, not a variety."""
KINDS = Measure("kinds", "kinds of collisions", PRIMARY_FAMILY, True, _own("kinds"))
AVOIDABLE = Measure("avoidable", "collisions that a competent driver avoids", PRIMARY_FAMILY, True, _own("avoidable"))
AVOIDABLE_KINDS = Measure(
    "avoidable kinds", "kinds of avoidable collisions", PRIMARY_FAMILY, True, _own("avoidable_kinds")
)
NAMED_FIRST = (AVOIDABLE, AVOIDABLE_KINDS, PRIMARY, KINDS)
"""Outcomes that a verdict reports."""
FAILING_CELLS = Measure(
    "failing cells", "cells of descriptor grids with a collision", "failing cells", True, _own("failing_cells")
)
NC = Measure("NC", "collisions, as the paper counts", "as the paper counts", True, _figure("individuals", "nc"))
FIRST = "first collision"
MEASURES = (
    *NAMED_FIRST,
    FAILING_CELLS,
    *_five("individuals", "", SECONDARY_FAMILY, leave_out=("NC",)),
    NC,
    *_five("last_individuals", ", last 10", "last ten generations"),
    *_five("simulations", ", by simulation", "by simulation"),
    *_five("last_simulations", ", last 10 by simulation", "last ten, by simulation"),
    Measure(FIRST, "simulations until the first", FIRST, False, _own("first_collision")),
)
SAME_AS_GENOMES = "NC, by simulation"
"""Measure that equals `PRIMARY` with one simulation per genome."""


def measures_of(rollouts: int) -> tuple[Measure, ...]:
    """Return the measures without duplicates for this number of simulations per genome."""
    return tuple(measure for measure in MEASURES if rollouts > 1 or measure.name != SAME_AS_GENOMES)


# -- comparisons -------------------------------------------------------------------------------------------------------

LEVEL = 0.05
MEDIUM = 0.64
STARS = ((0.001, "***"), (0.01, "**"), (LEVEL, "*"))


@dataclass(frozen=True)
class Spread:
    """One measure over the runs of one method on one scenario; runs without the number rank last."""

    runs: int
    median: float
    """Infinite if the middle run has no number; minus infinity if larger is better."""
    quartiles: Interval
    mean: float
    """NaN if a run has no number."""
    deviation: float
    """Standard deviation, n - 1; NaN for fewer than two runs, or if a run has no number."""
    missing: int = 0
    """Runs without the number."""


@dataclass(frozen=True)
class Comparison:
    """One measure of a contender, compared with the baseline on one scenario."""

    scenario: str
    method: str
    baseline: str
    measure: Measure
    spread: Spread
    baseline_spread: Spread
    p: float
    p_holm: float
    """Holm's p within the measure's family; NaN without data."""
    a12: float
    interval: Interval
    """95 %, see `a12_bounds`."""
    generations: int = 0
    """Generations per run."""
    budget: int = 0
    """Maximum number of simulations per run."""

    @property
    def title(self) -> str:
        """Return the measure's name, adapted if its last ten generations are all generations."""
        return self.measure.title_for(self.generations)

    @property
    def stars(self) -> str:
        """Return *** below 0.001, ** below 0.01, * below 0.05, by Holm's p."""
        return next((stars for limit, stars in STARS if self.p_holm < limit), "")

    @property
    def marks(self) -> str:
        """Return the stars after ▲ if the method is better, ▼ if it is worse; "" without a star."""
        return f"{'▲' if self.a12 > 0.5 else '▼'}{self.stars}" if self.stars else ""

    @property
    def runs(self) -> int:
        """Return the number of runs of the method with fewer runs."""
        return min(self.spread.runs, self.baseline_spread.runs)

    @property
    def decided(self) -> bool:
        """Return True if there are enough runs for a decision: better, worse, or no clear difference."""
        return self.runs >= RUNS

    @property
    def beats(self) -> bool:
        return self.decided and self._better and self.p_holm < LEVEL and self.a12 > MEDIUM

    @property
    def loses(self) -> bool:
        return self.decided and self._worse and self.p_holm < LEVEL and self.a12 < 1.0 - MEDIUM

    @property
    def words(self) -> str:
        """Return the result in a few words."""
        if not self.decided:
            return f"undecided at {counted(self.runs, 'run')}"
        return "better" if self.beats else "worse" if self.loses else "no clear difference"

    @property
    def missing(self) -> str:
        """Return `22 of 30 never collided`, followed by the baseline's; "" if every run has its number."""
        spreads = ((self.method, self.spread), (self.baseline, self.baseline_spread))
        why = "never collided" if self.measure.name == FIRST else "have no such number"
        parts = [f"{name}: {each.missing} of {each.runs} {why}" for name, each in spreads if each.missing]
        return "; ".join(parts)

    @property
    def _better(self) -> bool:
        """Return True if the contender's median is better."""
        sign = self.measure.orientation
        return sign * self.spread.median > sign * self.baseline_spread.median

    @property
    def _worse(self) -> bool:
        sign = self.measure.orientation
        return sign * self.spread.median < sign * self.baseline_spread.median


def sample(records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Floats:
    """Return the numbers of a cell's finished runs that have one, for plots; comparisons use `ranked`."""
    values = ranked(records, scenario, method, measure)
    return values[np.isfinite(values)]


def ranked(records: Sequence[RunRecord], scenario: int, method: str, measure: Measure) -> Floats:
    """Return one number per finished run of a cell; a run without one has the worst value, an infinite one."""
    chosen = [record for record in records if record.address[:2] == (scenario, method)]
    values = np.array([measure.of(record.figures) for record in chosen], dtype=np.float64)
    return np.where(np.isnan(values), -measure.orientation * np.inf, values)


def spread(values: Floats) -> Spread:
    """Return the spread of values of `ranked`; NaN without values."""
    nan = float("nan")
    if not len(values):
        return Spread(0, nan, Interval(nan, nan), nan, nan)
    missing = int((~np.isfinite(values)).sum())
    low, median, high = (_quantile(values, level) for level in (0.25, 0.5, 0.75))
    mean = nan if missing else float(values.mean())
    deviation = nan if missing or len(values) < 2 else float(values.std(ddof=1))
    return Spread(len(values), median, Interval(low, high), mean, deviation, missing)


def _quantile(values: Floats, level: float) -> float:
    """Return numpy's quantile; infinite if it is between a number and an infinite value."""
    place = level * (len(values) - 1)
    ends = np.sort(values)[[math.floor(place), math.ceil(place)]]
    if np.isfinite(ends).all():
        return float(np.quantile(np.where(np.isfinite(values), values, np.sign(values) * 1e300), level))
    return float(ends[~np.isfinite(ends)][0])


def compare_all(
    plan: Plan, records: Sequence[RunRecord], measures: Sequence[Measure] | None = None
) -> tuple[Comparison, ...]:
    """Return every measure on every scenario for every contender, corrected by families.

    `measures` is None for all measures without duplicates.
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
    """Return the rows with their Holm p within their families."""
    adjusted: dict[int, float] = {}
    for family in dict.fromkeys(row.measure.family for row in rows):
        members = [number for number, row in enumerate(rows) if row.measure.family == family]
        adjusted |= dict(zip(members, holm([rows[number].p for number in members]), strict=True))
    return tuple(replace(row, p_holm=adjusted[number]) for number, row in enumerate(rows))
