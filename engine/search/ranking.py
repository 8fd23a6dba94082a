"""The worst cases of a campaign: by risk, those that a competent driver would have avoided before others of the same
risk, then by continuous risk, then age, and of many kinds. Where something else than the risk is sought, contacts come
first: avoidable collisions, other collisions, then near misses, each by what is sought.

Of the collisions in that order (of all valid simulations, where there are fewer than asked for) the worst is taken,
then one case of each partner, then one of each kind (`insight.kinds`), then a second of some; of each, one that a
competent driver would have avoided goes before one that it would not. Where something else is sought, no near miss is
taken before the last collision. In a search for failures of a controller these come before all collisions.
"""

from dataclasses import dataclass

import numpy as np

from engine.search.evaluations import Evaluations, is_aimed
from engine.search.insight.kinds import codes
from engine.streams import StreamKey
from engine.tables import Ints
from engine.vocabulary import Blame, Verdict


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

    @property
    def lost(self) -> bool:
        """Whether a controller failed over it: there is a scene, and nothing is known of its run."""
        return self.score < 0


def order_of_risk(evaluations: Evaluations, blame: Ints | None = None) -> Ints:
    """Return the simulated rows that have a fitness, worst first: integer risk, then those that a competent driver
    would have avoided, where `blame` (n, k) tells; then continuous risk, then birth. Where something else is sought,
    contact stands for the integer risk, and what is sought for the continuous one.
    """
    rows = np.flatnonzero(evaluations.scored & evaluations.simulated)
    first = _contact_order(evaluations, rows) if is_aimed(evaluations.rollouts) else -evaluations.score[rows]
    avoidable = np.zeros(len(rows), dtype=bool)
    if blame is not None:
        avoidable = blame[rows, evaluations.worst_rollout[rows]] == Blame.AVOIDABLE
    return rows[np.lexsort((rows, -evaluations.continuous[rows], ~avoidable, first))]


def _contact_order(evaluations: Evaluations, rows: Ints) -> Ints:
    """(m,) of the worst rollout of rows: 0 where a controller failed, 1 with contact, 2 without."""
    place = rows, evaluations.worst_rollout[rows]
    runs = evaluations.rollouts
    return np.where(runs.verdict[place] == Verdict.CONTROLLER, 0, np.where(runs.collided[place], 1, 2))


def worst_cases(evaluations: Evaluations, count: int = 10, blame: Ints | None = None) -> tuple[Case, ...]:
    """Return the worst rollouts of up to `count` different genomes, worst first; with what the reference driver says of
    each rollout (n, k), of many kinds.
    """
    rows = _different(evaluations, order_of_risk(evaluations, blame))
    if blame is not None:
        aimed = is_aimed(evaluations.rollouts)
        first = _contact_order(evaluations, rows) < 2 if aimed else evaluations.found[rows]
        if aimed and count > np.count_nonzero(first):
            others = _of_each_kind(evaluations, rows[~first], count - int(np.count_nonzero(first)), blame)
            rows = np.concatenate([rows[first], others])
        else:
            rows = _of_each_kind(evaluations, rows[first] if np.count_nonzero(first) >= count else rows, count, blame)
    worst = evaluations.worst_rollout
    return tuple(
        _case(evaluations, row, int(worst[row]), rank) for rank, row in enumerate(rows[:count].tolist(), start=1)
    )


def worst_runs(evaluations: Evaluations, count: int = 10) -> tuple[Case, ...]:
    """Return so many of the worst cases of which there is a run, where some of the worst have none; else nothing more
    than `worst_cases` does.
    """
    if not any(case.lost for case in worst_cases(evaluations, count)):
        return ()
    every = worst_cases(evaluations, len(evaluations))
    return tuple(case for case in every if not case.lost)[:count]


def lost_cases(evaluations: Evaluations, count: int = 10) -> tuple[Case, ...]:
    """Return the first simulations over which a controller failed."""
    lost = (evaluations.rollouts.verdict == Verdict.CONTROLLER) & evaluations.simulated[:, np.newaxis]
    places = np.argwhere(lost)[:count].tolist()
    return tuple(_case(evaluations, row, rollout, rank) for rank, (row, rollout) in enumerate(places, start=1))


def _of_each_kind(evaluations: Evaluations, pool: Ints, count: int, blame: Ints) -> Ints:
    """Return up to `count` rows of a pool in their order: the first, then one of each partner, then of each kind."""
    kind = codes(evaluations, blame)[pool, evaluations.worst_rollout[pool]]
    order = np.argsort(kind[:, -1] != Blame.AVOIDABLE, kind="stable")
    partners, kinds = (order[_firsts(kind[order, :columns])] for columns in (1, kind.shape[1]))
    turns = dict.fromkeys([*range(min(1, len(pool))), *partners.tolist(), *kinds.tolist(), *range(len(pool))])
    return pool[sorted(list(turns)[:count])]


def _firsts(codes: Ints) -> Ints:
    """Rows that are unlike all before, in their order."""
    return np.sort(np.unique(codes, axis=0, return_index=True)[1])


def _different(evaluations: Evaluations, rows: Ints) -> Ints:
    """The rows without those whose genome came before."""
    seen: set[bytes] = set()
    new = [genome not in seen and not seen.add(genome) for genome in map(bytes, evaluations.genomes[rows])]
    return rows[np.array(new, dtype=bool)]


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
