"""What an estimate of the probability of a collision tells, whichever way it was made."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from engine.scenes import Bools
from engine.search.assessment import Assessment
from engine.search.statistics import Interval
from engine.tables import Floats, Ints
from engine.vocabulary import EndReason, Verdict

NOT_KNOWN = Interval(math.nan, math.nan)
PARAMS, JOINT = CONDITIONS = ("params", "joint")
"""What is drawn anew with every attempt at a scene: the scene alone, or the params too."""
MOST_DRIVEN = 5_000
"""Collisions of an estimate that the reference driver drives again."""

Judge = Callable[[Floats, Ints], Bools]
"""(genomes, stream keys) of collisions -> whether a reference driver avoids each."""


@dataclass(frozen=True)
class Probability:
    """An estimate of P(collision | valid run)."""

    method: str
    """`mc` or `subset`."""
    value: float
    interval: Interval
    """Confidence interval at `level`; NaN where none can be given."""
    level: float
    simulations: int
    """Runs that the estimate took, invalid ones included."""
    valid: int
    """Of them valid."""
    collisions: int
    """Of them with a collision; under `subset` these are not independent."""
    valid_share: float
    """Estimated probability that a draw gives a valid run."""
    aborted: int = 0
    """Of the simulations, those that a requirement on the run made invalid: they did run."""
    levels: tuple[float, ...] = ()
    """Of the first repetition: least distances at which it stopped over [m]; 0 stands for contact."""
    condition: str = PARAMS
    """`params` or `joint`."""
    max_attempts: int = 0
    """At a scene for one draw of the params; 0: not told."""
    avoidable: float = math.nan
    """P(collision that the reference driver avoids | valid run); NaN where none was driven again."""
    avoidable_interval: Interval = NOT_KNOWN
    driven: int = 0
    """Collisions that were driven again for it."""
    by_partner: tuple[int, ...] = ()
    """Collisions with actor 1, actor 2, …; those that are left out at the end were not met. Under `mc` alone."""
    without_ego: int = 0
    """Runs that a collision of two others ended. Under `mc` alone."""


class Count(NamedTuple):
    """What runs came to."""

    simulations: int = 0
    valid: int = 0
    collisions: int = 0
    aborted: int = 0
    by_partner: tuple[int, ...] = ()
    """Collisions with actor 1, actor 2, … up to the last one that was met."""
    without_ego: int = 0

    def more(self, runs: Assessment) -> "Count":
        met = np.bincount(runs.pair[runs.collided], minlength=len(self.by_partner))
        met[: len(self.by_partner)] += np.array(self.by_partner, dtype=np.int64)
        return Count(
            self.simulations + len(runs),
            self.valid + int((runs.verdict == Verdict.VALID).sum()),
            self.collisions + int(runs.collided.sum()),
            self.aborted + int((runs.verdict == Verdict.ABORTED).sum()),
            tuple(met.tolist()),
            self.without_ego + int((runs.end_reason == EndReason.OTHER_COLLISION).sum()),
        )
