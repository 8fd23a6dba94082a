"""How near a run came to a failure: what levels of a rare event are made of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from engine.outcomes import Assessment
from engine.tables import Bools, Floats


@dataclass(frozen=True)
class Score:
    """One row. Both functions take runs and give (n,) values; those of invalid runs mean nothing."""

    name: str
    sentence: str
    unit: str
    nearness: Callable[[Assessment], Floats]
    """Minus what is left to a failure: the larger, the nearer; not read of a failure."""
    failed: Callable[[Assessment], Bools]


DISTANCE = Score(
    "distance",
    "the least distance between the ego and another (MD); a failure is a collision",
    "m",
    lambda runs: -runs.min_distance,
    lambda runs: runs.collided,
)
SCORES = {score.name: score for score in (DISTANCE,)}


def nearness(score: Score, runs: Assessment) -> Floats:
    """(n,) by the score; infinite for a failure, minus infinite where nothing is known."""
    near = np.where(score.failed(runs), np.inf, np.minimum(score.nearness(runs), 0.0))
    return np.where(np.isnan(near), -np.inf, near)
