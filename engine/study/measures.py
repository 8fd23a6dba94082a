"""What runs are compared by: each measure is one number a run, and belongs to one family of tests.

Two outcomes are named first, and tested as one family: different genomes that collided, which is the yield, and
distinct failures, which is its variety. The paper's other four metrics over the whole run, counted by individual as the
paper does, are the second family (twenty-four tests where six scenarios meet one contender). All else is exploratory:
each further way of counting is corrected within itself, but who looks at many and picks one has not corrected for that.
"""

from collections.abc import Callable
from dataclasses import dataclass

from engine.study.records import LAST, RunFigures

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
        """Whether it is told beside what was to be shown, and shows nothing by itself."""
        return self.family not in (PRIMARY_FAMILY, SECONDARY_FAMILY)

    @property
    def orientation(self) -> float:
        """1 where larger is better, else -1."""
        return 1.0 if self.larger_is_better else -1.0

    def counted(self, generations: int) -> int:
        """Over how many generations it counts, where a run has so many."""
        return min(LAST, generations) if f"last {LAST}" in self.name else generations

    def told(self, generations: int) -> str:
        """Its name, where a run has so many generations: of ten or fewer the last ten are simply all."""
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
DISTINCT_FAILURES = Measure(
    "distinct failures", "collisions unlike all earlier ones", PRIMARY_FAMILY, True, _own("distinct_failures")
)
FAILING_CELLS = Measure(
    "failing cells", "cells of descriptor grids with a collision", "failing cells", True, _own("failing_cells")
)
NC = Measure("NC", "collisions, as the paper counts", "as the paper counts", True, _figure("individuals", "nc"))
FIRST = "first collision"
MEASURES = (
    PRIMARY,
    DISTINCT_FAILURES,
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
