"""What the runs of a study are compared by, and methods held against the baseline, run by run. The unit of analysis is
one run, as what lies inside one is not independent.

Each measure is one number a run, and belongs to one family of tests. Four outcomes are named first, and tested as one
family: collisions that a competent driver avoids and the kinds of these, different genomes that collided, which is the
yield, and kinds of all collisions, which is its variety. The paper's other four metrics over the whole run, counted by
individual as the paper does, are the second family (twenty-four tests where six scenarios meet one contender). All else
is exploratory: each further way of counting is corrected within itself, but picking one out of many is not corrected
for.

Two-sided Mann-Whitney tests, corrected by Holm over each family (all scenarios and contenders together); A12 of Vargha
and Delaney with a 95 % interval (bootstrap, and no narrower than Newcombe's, which stays honest where every run of one
method beats every run of the other), oriented so that above 0.5 the contender is better. *Beats* means: at least 30
runs of each, better median, Holm's p below 0.05, and A12 above 0.64 (their "medium"). *Loses* is the same the other way
round. With fewer runs nothing is decided.

A run without the number, such as one that never collided and so has no first collision, is not left out, which would
reward a method for failing: it ranks behind every run that has one, in medians, tests and A12. What is meant by
worst is known for ranks only, so that there is no mean then.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.search.statistics import Interval, a12, a12_bounds, holm, mann_whitney
from engine.study.plan import RUNS, Plan
from engine.study.run_records import LAST, RunFigures, RunRecord
from engine.tables import Floats

# -- measures ----------------------------------------------------------------------------------------------------------

PRIMARY_FAMILY, SECONDARY_FAMILY = "primary", "secondary"


@dataclass(frozen=True)
class Measure:
    """One number a run; NaN where a run has none, which is worse than any number."""

    name: str
    meaning: str
    family: str
    larger_is_better: bool
    of: Callable[[RunFigures], float]
    decimals: int = 0
    unit: str = ""

    @property
    def exploratory(self) -> bool:
        """Whether the measure is exploratory: reported, but it confirms nothing by itself."""
        return self.family not in (PRIMARY_FAMILY, SECONDARY_FAMILY)

    @property
    def orientation(self) -> float:
        """1 where larger is better, else -1."""
        return 1.0 if self.larger_is_better else -1.0

    def counted(self, generations: int) -> int:
        """Over how many generations it counts, where a run has so many."""
        return min(LAST, generations) if f"last {LAST}" in self.name else generations

    def title_for(self, generations: int) -> str:
        """Return its name for runs of so many generations: of ten or fewer the last ten are all."""
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
    """The paper's metrics over one group of figures."""
    return tuple(
        Measure(f"{name}{where}", meaning, family, larger, _figure(group, field), decimals, unit)
        for name, meaning, field, larger, decimals, unit in _FIVE
        if name not in leave_out
    )


PRIMARY = Measure(
    "colliding genomes", "different genomes that collided", PRIMARY_FAMILY, True, _own("distinct_collisions")
)
"""Two genomes differ when a single bit does: yield, and no variety."""
KINDS = Measure("kinds", "kinds of collisions", PRIMARY_FAMILY, True, _own("kinds"))
AVOIDABLE = Measure("avoidable", "collisions that a competent driver avoids", PRIMARY_FAMILY, True, _own("avoidable"))
AVOIDABLE_KINDS = Measure(
    "avoidable kinds", "kinds of avoidable collisions", PRIMARY_FAMILY, True, _own("avoidable_kinds")
)
NAMED_FIRST = (AVOIDABLE, AVOIDABLE_KINDS, PRIMARY, KINDS)
"""What a verdict speaks of."""
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
"""With one simulation for each genome it is `PRIMARY` again."""


def measures_of(rollouts: int) -> tuple[Measure, ...]:
    """Those that say something of their own where each genome is simulated so many times."""
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
        return self.measure.title_for(self.generations)

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
        parts = [f"{name}: {each.missing} of {each.runs} {why}" for name, each in spreads if each.missing]
        return "; ".join(parts)

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
