"""The worst cases of a campaign: by risk, then continuous risk, then age, and no two of them nearly the same.

Of the collisions in that order (of all valid simulations, where there are fewer than asked for), a case is taken when
at least a third of its genes differ by more than a tenth of their range from those of every case taken before, which is
the rule of `diversity`. Where fewer than asked for lie so far apart, the worst of what was passed over fill the list.
Where something else than the risk is sought, it stands for the risk, and its finds for the collisions.
"""

from dataclasses import dataclass

import numpy as np

from engine.search.evaluations import Evaluations, is_aimed
from engine.search.insight.diversity import first_apart
from engine.search.protocol import Box
from engine.streams import StreamKey
from engine.tables import Ints
from engine.vocabulary import Verdict


@dataclass(frozen=True)
class Case:
    """One simulation among the worst of a campaign; genome and key reproduce it."""

    rank: int
    """From 1."""
    row: int
    """Row of the campaign's evaluations."""
    rollout: int
    genome: tuple[float, ...]
    key: StreamKey
    score: int
    continuous: float
    """Continuous risk, or how much it has of what is sought."""
    collided: bool
    min_distance: float
    """[m]"""
    closing_speed: float = float("nan")
    """How fast the two came together at contact, or where they were closest [m/s]: risk has a top, this has none."""


def order_of_risk(evaluations: Evaluations) -> Ints:
    """Return the valid simulated rows, worst first: integer risk, then continuous risk, then birth; or by what else is
    sought.
    """
    rows = np.flatnonzero(evaluations.valid & evaluations.simulated)
    first = -evaluations.continuous if is_aimed(evaluations.rollouts) else -evaluations.score
    return rows[np.lexsort((rows, -evaluations.continuous[rows], first[rows]))]


def worst_cases(evaluations: Evaluations, count: int = 10, box: Box | None = None) -> tuple[Case, ...]:
    """Return the worst rollouts of up to `count` different genomes, worst first; with a box, of distant ones."""
    rows = _different(evaluations, order_of_risk(evaluations))
    if box is not None:
        rows = _apart(evaluations, rows, count, box)
    return tuple(_case(evaluations, row, rank) for rank, row in enumerate(rows[:count].tolist(), start=1))


def _apart(evaluations: Evaluations, rows: Ints, count: int, box: Box) -> Ints:
    """The first `count` of the rows that lie apart, filled up with the first of the others, in the rows' order."""
    finds = rows[evaluations.found[rows]]
    pool = finds if len(finds) >= count else rows
    apart = pool[first_apart(evaluations.genomes[pool], box, most=count)]
    others = pool[~np.isin(pool, apart)][: count - len(apart)]
    return rows[np.isin(rows, np.concatenate([apart, others]))]


def _different(evaluations: Evaluations, rows: Ints) -> Ints:
    """The rows without those whose genome came before."""
    seen: set[bytes] = set()
    new = [genome not in seen and not seen.add(genome) for genome in map(bytes, evaluations.genomes[rows])]
    return rows[np.array(new, dtype=bool)]


def _case(evaluations: Evaluations, row: int, rank: int) -> Case:
    rollout = int(evaluations.worst_rollout[row])
    place = row, rollout
    runs = evaluations.rollouts
    assert runs.verdict[place] == Verdict.VALID
    return Case(
        rank=rank,
        row=row,
        rollout=rollout,
        genome=tuple(evaluations.genomes[row].tolist()),
        key=StreamKey(*evaluations.keys[place].tolist()),
        score=int(runs.score[place]),
        continuous=float(evaluations.continuous[row]),
        collided=bool(runs.collided[place]),
        min_distance=float(runs.min_distance[place]),
        closing_speed=float(runs.closing_speed[place]),
    )
