"""With whom the ego collided."""

import numpy as np

from engine.search.estimated import Count
from engine.search.partners import NOBODY, Partners, partner_of, partners
from engine.vocabulary import EndReason


class Rollouts:
    """Five individuals of one rollout among three actors: two hits of actor 2, one of others, two without contact."""

    collided = np.array([[True], [True], [False], [False], [False]])
    pair = np.array([[1], [1], [0], [1], [-1]])
    end_reason = np.array([[EndReason.COLLISION]] * 2 + [[EndReason.OTHER_COLLISION], [EndReason.TIMEOUT], [-1]])


class Table:
    rollouts = Rollouts
    simulated = np.array([True, False, True, True, True])


def test_each_partner_is_counted_once_a_simulation() -> None:
    """A repeated elite is left out; who was only near is no partner; actor 1 was missed."""
    assert partners(Table, 3) == Partners((0, 1), 1)  # type: ignore[arg-type]


def test_nobody_is_a_partner_without_contact() -> None:
    """Although a pair decides their risk, too."""
    assert partner_of(Table).ravel().tolist() == [1, 1, NOBODY, NOBODY, NOBODY]  # type: ignore[arg-type]


def test_an_ego_alone_meets_nobody() -> None:
    """There is no pair at all."""
    assert partners(Table, 1).with_ego == ()  # type: ignore[arg-type]


def test_an_estimate_counts_partners_block_by_block() -> None:
    """Blocks that met other partners add up, whoever was met first."""
    first, second = Runs([0, 0, 1], [True, True, False]), Runs([2, 0], [True, True])
    count = Count().more(first).more(second)  # type: ignore[arg-type]
    assert count.by_partner == (3, 0, 1)
    assert (count.collisions, count.without_ego) == (4, 1)


class Runs:
    """One block of runs: whom each was nearest to, and whether it touched; the others ended by a crash of others."""

    def __init__(self, pair: list[int], collided: list[bool]) -> None:
        self.pair, self.collided = np.array(pair), np.array(collided)
        self.verdict = np.zeros(len(pair), dtype=np.int64)
        self.end_reason = np.where(self.collided, EndReason.COLLISION, EndReason.OTHER_COLLISION)

    def __len__(self) -> int:
        return len(self.pair)
