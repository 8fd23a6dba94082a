"""Outcomes of a condition in pairs of runs: one scene, driven by A and by B."""

from engine.frozen import frozen
from engine.search.statistics import Interval, mcnemar, tango_interval
from engine.tables import Bools


@frozen
class PairTable:
    """Numbers of pairs by the outcome of A and of B."""

    kept_kept: int = 0
    kept_broken: int = 0
    broken_kept: int = 0
    broken_broken: int = 0

    def __add__(self, other: "PairTable") -> "PairTable":
        return PairTable(*(one + two for one, two in zip(self.counts, other.counts, strict=True)))

    @property
    def counts(self) -> tuple[int, int, int, int]:
        return self.kept_kept, self.kept_broken, self.broken_kept, self.broken_broken

    @property
    def pairs(self) -> int:
        return sum(self.counts)

    @property
    def discordant(self) -> int:
        """Return the number of pairs in which one of both breaks the condition."""
        return self.kept_broken + self.broken_kept

    @property
    def rates(self) -> tuple[float, float]:
        """Return the shares of pairs in which A and B break the condition; NaN without pairs."""
        pairs = self.pairs or float("nan")
        return (self.broken_kept + self.broken_broken) / pairs, (self.kept_broken + self.broken_broken) / pairs

    @property
    def difference(self) -> float:
        """Return the rate of B less that of A: positive where B breaks the condition more often."""
        return (self.kept_broken - self.broken_kept) / (self.pairs or float("nan"))

    @property
    def interval(self) -> Interval:
        """Return the 95 % interval of the difference."""
        return tango_interval(self.kept_broken, self.broken_kept, self.pairs)

    @property
    def p(self) -> float:
        """Return the two-sided p of equal rates."""
        return mcnemar(self.kept_broken, self.broken_kept)


def pair_table(broken_a: Bools, broken_b: Bools) -> PairTable:
    """Return the table of two rows (n,) of outcomes."""
    counts = ((one, two) for one in (False, True) for two in (False, True))
    return PairTable(*(int(((broken_a == one) & (broken_b == two)).sum()) for one, two in counts))
