"""The worst cases of a campaign: distinct genomes, by risk, then continuous risk, then age."""

from dataclasses import dataclass

import numpy as np

from engine.scenes import StreamKey
from engine.search.evaluations import Evaluations
from engine.tables import Floats, Ints
from engine.vocabulary import Verdict


@dataclass(frozen=True)
class Case:
    """One simulation that is worth looking at; genome and key reproduce it."""

    rank: int
    """From 1."""
    row: int
    """Row of the campaign's evaluations."""
    rollout: int
    genome: tuple[float, ...]
    key: StreamKey
    score: int
    continuous: float
    collided: bool
    min_distance: float
    """[m]"""


def order_of_risk(evaluations: Evaluations) -> Ints:
    """Valid simulated rows, worst first: integer risk, then continuous risk, then birth."""
    rows = np.flatnonzero(evaluations.valid & evaluations.simulated)
    return rows[np.lexsort((rows, -evaluations.continuous[rows], -evaluations.score[rows]))]


def worst_cases(evaluations: Evaluations, count: int = 10) -> tuple[Case, ...]:
    """The worst rollouts of up to `count` different genomes."""
    chosen: list[Case] = []
    seen: set[bytes] = set()
    for row in order_of_risk(evaluations).tolist():
        if len(chosen) == count:
            break
        genome: Floats = evaluations.genomes[row]
        if genome.tobytes() not in seen:
            seen.add(genome.tobytes())
            chosen.append(_case(evaluations, row, len(chosen) + 1))
    return tuple(chosen)


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
        continuous=float(runs.continuous[place]),
        collided=bool(runs.collided[place]),
        min_distance=float(runs.min_distance[place]),
    )
