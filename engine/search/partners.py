"""With whom the ego collided, counted over the distinct simulations of a search."""

from dataclasses import dataclass

import numpy as np

from engine.search.evaluations import Evaluations
from engine.vocabulary import EndReason

NOBODY = -1


@dataclass(frozen=True)
class Partners:
    """Collisions by who met. The pair that decides the risk is the one that touched: contact outweighs all else."""

    with_ego: tuple[int, ...]
    """Distinct simulations in which the ego touched actor 1, actor 2, …"""
    without_ego: int
    """Distinct simulations in which two others touched first, which ends a run, too."""


NO_PARTNERS = Partners((), 0)
"""Of an ego alone."""


def partners(evaluations: Evaluations, actors: int) -> Partners:
    """The collisions of a search among so many actors."""
    new = evaluations.simulated
    met = partner_of(evaluations)[new]
    others = evaluations.rollouts.end_reason[new] == EndReason.OTHER_COLLISION
    return Partners(tuple(int((met == pair).sum()) for pair in range(actors - 1)), int(others.sum()))


def partner_of(evaluations: Evaluations) -> np.ndarray:
    """(n, k) the pair (ego, actor pair + 1) that touched, `NOBODY` where the ego did not."""
    return np.where(evaluations.rollouts.collided, evaluations.rollouts.pair, NOBODY)
