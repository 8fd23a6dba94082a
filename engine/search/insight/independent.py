"""Rates from the independent draws of a search: the genomes that its method drew uniformly, whatever it had learnt.

Random search draws all its genomes so, the genetic algorithm its first generation, others some in every generation
(individuals of `Operator.RANDOM`). Given all earlier results, each such
run has one probability of each event, so the confidence sequence of the event holds whenever a search ends or is looked
at. The share among the other runs is not a probability: the method goes where it found danger.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.assessment import take
from engine.outcomes import Assessment
from engine.search.evaluations import Evaluations
from engine.search.insight.kinds import codes_of_draws
from engine.search.methods.table import SEARCHERS
from engine.search.probability.confidence_sequence import sequence_interval
from engine.search.probability.unseen import Unseen, labels, unseen_kinds
from engine.search.protocol import Operator
from engine.search.statistics import Interval
from engine.tables import Ints
from engine.vocabulary import Verdict

COLLISION = "collision"
LEVEL = 0.95
FIXED = ("random", "ga")
"""Methods whose number of independent draws does not depend on results, as the bound of unseen kinds requires."""


@dataclass(frozen=True)
class EventRate:
    """Probability of one event in a valid run, params uniform over their ranges."""

    name: str
    """`collision`, or the name of an expectation that is broken."""
    count: int
    interval: Interval
    """Confidence sequence at `LEVEL`, for this event alone."""


@dataclass(frozen=True)
class IndependentDraws:
    """Statement on the independent draws of a search."""

    valid: int
    lost: int
    """Draws in which the driver failed: each end of an interval takes them for the worse."""
    events: tuple[EventRate, ...]
    unseen: Unseen
    """Kinds of collisions that none of these draws showed."""


def draws_independently(method: str) -> bool:
    """Return True if some runs of a method are independent draws."""
    return method in SEARCHERS and SEARCHERS[method].draws_independently


def rows_of_draws(evaluations: Evaluations, method: str) -> Ints:
    """Return (n,) the individuals of the independent draws, none of a method without any."""
    drawn = evaluations.simulated & (evaluations.operator == Operator.RANDOM)
    return np.flatnonzero(drawn & draws_independently(method))


def runs_of_draws(evaluations: Evaluations, method: str) -> Assessment:
    """Return the runs of `rows_of_draws`; with several rollouts for each genome the first counts."""
    rows = rows_of_draws(evaluations, method)
    return take(evaluations.rollouts, (rows, np.zeros_like(rows)))


@dataclass
class DrawsSoFar:
    """Counts of the independent draws of a search that goes on."""

    method: str
    valid: int = 0
    lost: int = 0
    collisions: int = 0

    def add(self, evaluations: Evaluations) -> Interval:
        """Count more draws; return the confidence sequence of the probability of a collision, NaN without draws."""
        runs = runs_of_draws(evaluations, self.method)
        valid = runs.verdict == Verdict.VALID
        self.valid += int(valid.sum())
        self.lost += int((runs.verdict == Verdict.CONTROLLER).sum())
        self.collisions += int(runs.collided[valid].sum())
        return sequence_interval(self.collisions, self.valid, LEVEL, self.lost)


def independent_draws(evaluations: Evaluations, method: str, expectations: Sequence[str]) -> IndependentDraws | None:
    """Return the rates of the independent draws; None if none of them is valid."""
    runs = runs_of_draws(evaluations, method)
    valid = runs.verdict == Verdict.VALID
    if not valid.any():
        return None
    lost, broken = int((runs.verdict == Verdict.CONTROLLER).sum()), runs.broken[valid]
    counts = {COLLISION: runs.collided[valid].sum()}
    counts |= {name: (column > 0.0).sum() for name, column in zip(expectations, broken.T, strict=True)}
    events = [
        EventRate(name, int(count), sequence_interval(int(count), len(broken), LEVEL, lost))
        for name, count in counts.items()
    ]
    unseen = unseen_kinds(labels(codes_of_draws(runs, runs.collided)), LEVEL, lost)
    unseen = unseen if method in FIXED else replace(unseen, bound=math.nan)
    return IndependentDraws(len(broken), lost, tuple(events), unseen)
