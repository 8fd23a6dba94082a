"""The worst cases of a campaign, of many kinds.

The order in a search for risk: by risk; among equal risks, those that all reference drivers avoid first, then those
that some avoid; then by continuous risk; then by age. The order in a search for any other objective: failures of a
controller, collisions that all reference drivers avoid, that some avoid, other collisions and finds, then all others;
each by the objective, then by age. So a near miss never precedes a collision, for any values of the objective.

From the collisions and finds in that order (from all valid simulations, if there are fewer than requested) the worst is
chosen, then one case of each partner, then one of each kind (`insight.kinds`), then second cases; within each group,
cases that a competent driver would have avoided come first. In a search for failures of a controller these are finds,
too.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from engine.search.evaluations import Evaluations, is_aimed
from engine.search.insight.kinds import blame_order, codes, numbered
from engine.streams import StreamKey
from engine.tables import Floats, Ints
from engine.vocabulary import Verdict

WORST = 10
"""Number of worst cases with a scenario in the folder of a run; they are of many kinds."""


@dataclass(frozen=True)
class Case:
    """One simulation among the worst of a campaign; genome and key reproduce it."""

    rank: int
    """Rank from 1."""
    row: int
    """Row of the campaign's evaluations."""
    rollout: int
    genome: tuple[float, ...]
    key: StreamKey
    score: int
    continuous: float
    """Continuous risk, or the value of the first objective."""
    collided: bool
    min_distance: float
    """[m]"""
    closing_speed: float = float("nan")
    """Closing speed at contact, or at the closest approach [m/s]. Unlike the risk, it has no upper limit."""

    @property
    def lost(self) -> bool:
        """Return True if a controller failed: the scene exists, but the outcome of its run is unknown."""
        return self.score < 0


def order_of_risk(evaluations: Evaluations, blame: Ints | None = None) -> Ints:
    """Return the simulated rows that have a fitness, worst first; `blame` (n, k) are the verdicts of the reference
    drivers.
    """
    rows = np.flatnonzero(evaluations.scored & evaluations.simulated)
    order = np.zeros(len(rows), dtype=np.int64)
    if blame is not None:
        order = blame_order(blame[rows, evaluations.worst_rollout[rows]])
    first, then = severity(evaluations)
    return rows[np.lexsort((rows, then[rows], order, first[rows]))]


def severity(evaluations: Evaluations) -> tuple[Ints, Floats]:
    """Return the first and the last key of the order (n,), each least for the worst row: minus the risk (or the group,
    see `_group`), then minus the continuous risk (or the first objective).
    """
    first = _group(evaluations) if is_aimed(evaluations.rollouts) else -evaluations.score
    return first, -evaluations.continuous


def _group(evaluations: Evaluations) -> Ints:
    """Return (n,) the group of the worst rollout: 0: controller failed, 1: collision or other find, 2: the rest."""
    runs, place = evaluations.rollouts, (np.arange(len(evaluations)), evaluations.worst_rollout)
    find = evaluations.found | runs.collided[place]
    return np.where(runs.verdict[place] == Verdict.CONTROLLER, 0, np.where(find, 1, 2))


def worst_cases(evaluations: Evaluations, count: int = WORST, blame: Ints | None = None) -> tuple[Case, ...]:
    """Return the worst rollouts of up to `count` different genomes, worst first.

    With the reference driver's verdict on each rollout, `blame` (n, k), they are of many kinds.
    """
    rows = worst_rows(evaluations, count, blame).tolist()
    return tuple(case_of(evaluations, row, rank) for rank, row in enumerate(rows, start=1))


def worst_rows(evaluations: Evaluations, count: int, blame: Ints | None = None) -> Ints:
    """Return the rows of `worst_cases`."""
    rows = _different(evaluations, order_of_risk(evaluations, blame))
    if blame is not None:
        rows = np.concatenate([*_of_each_kind(evaluations, rows, count, blame), rows[:0]])
    return rows[:count]


def case_of(evaluations: Evaluations, row: int, rank: int) -> Case:
    """Return the worst rollout of an individual as a case."""
    return _case(evaluations, row, int(evaluations.worst_rollout[row]), rank)


def worst_runs(evaluations: Evaluations, count: int = WORST) -> tuple[Case, ...]:
    """Return up to `count` worst cases that have a run, if some of the worst have none; else ()."""
    if not any(case.lost for case in worst_cases(evaluations, count)):
        return ()
    every = worst_cases(evaluations, len(evaluations))
    return tuple(case for case in every if not case.lost)[:count]


def lost_cases(evaluations: Evaluations, count: int = WORST) -> tuple[Case, ...]:
    """Return the first simulations over which a controller failed."""
    lost = (evaluations.rollouts.verdict == Verdict.CONTROLLER) & evaluations.simulated[:, np.newaxis]
    places = np.argwhere(lost)[:count].tolist()
    return tuple(_case(evaluations, row, rollout, rank) for rank, (row, rollout) in enumerate(places, start=1))


def _of_each_kind(evaluations: Evaluations, rows: Ints, count: int, blame: Ints) -> Iterator[Ints]:
    """Yield up to `count` of the rows; with objectives other than the risk, one group after the other."""
    if is_aimed(evaluations.rollouts):
        pools = [rows[_group(evaluations)[rows] == group] for group in range(3)]
    else:
        finds = rows[evaluations.found[rows]]
        pools = [finds if len(finds) >= count else rows]
    for pool in pools:
        yield (chosen := _of_pool(evaluations, pool, count, blame))
        count -= len(chosen)


def _of_pool(evaluations: Evaluations, pool: Ints, count: int, blame: Ints) -> Ints:
    """Return up to `count` rows in their order: the first, then one of each partner, then of each kind."""
    if count >= len(pool):
        return pool
    kind = codes(evaluations.rollouts, blame, (pool, evaluations.worst_rollout[pool]))
    order = np.argsort(blame_order(kind[:, -1]), kind="stable")
    partners, kinds = (order[_firsts(kind[order, :columns])] for columns in (1, kind.shape[1]))
    turns = dict.fromkeys([*range(min(1, len(pool))), *partners.tolist(), *kinds.tolist(), *range(count)])
    return pool[sorted(list(turns)[:count])]


def _firsts(codes: Ints) -> Ints:
    """Return the rows that differ from all earlier rows, in their order."""
    return np.sort(np.unique(numbered(codes), return_index=True)[1])


def _different(evaluations: Evaluations, rows: Ints) -> Ints:
    """Return the rows without those with an earlier genome."""
    alike, places = evaluations.first_alike[rows], np.arange(len(rows))
    first = np.empty(len(evaluations), dtype=np.int64)
    first[alike[::-1]] = places[::-1]  # of equal indices the last one counts, here the earliest place
    return rows[first[alike] == places]


def _case(evaluations: Evaluations, row: int, rollout: int, rank: int) -> Case:
    place = row, rollout
    runs = evaluations.rollouts
    assert runs.verdict[place] in (Verdict.VALID, Verdict.CONTROLLER)
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
