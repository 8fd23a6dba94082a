"""Scores: measures of the distance of a run to a failure, on which the levels of a rare event are based."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from engine.outcomes import Assessment
from engine.tables import Bools, Floats


@dataclass(frozen=True)
class Score:
    """One score. Both functions take runs and return (n,) values, which are meaningless for invalid runs."""

    name: str
    sentence: str
    unit: str
    nearness: Callable[[Assessment], Floats]
    """Minus the distance to a failure, so larger values are nearer; not read for a failure."""
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
    """Return (n,) nearness by the score; infinite for a failure, minus infinite if unknown."""
    near = np.where(score.failed(runs), np.inf, np.minimum(score.nearness(runs), 0.0))
    return np.where(np.isnan(near), -np.inf, near)
