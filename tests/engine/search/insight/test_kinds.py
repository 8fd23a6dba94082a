"""Kinds of failures, the counts that lead a summary, and the worst cases of many kinds."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.assessment import map_arrays, take
from engine.search.evaluations import Evaluations
from engine.search.insight.kinds import PACES, Kind, blamed, codes, estimated_share, failures, kinds
from engine.search.ranking import worst_cases
from engine.tables import Floats, Ints
from engine.vocabulary import Blame, Side
from tests.engine.search.conftest import assessed, evaluated

AVOIDABLE, UNAVOIDABLE, STRUCK, NONE = Blame.AVOIDABLE, Blame.UNAVOIDABLE, Blame.STRUCK, Blame.NONE
KMH = 1.0 / 3.6


def searched(distance: Floats, **changes: object) -> Evaluations:
    """Valid individuals of one rollout with these least distances; below 1 m is a collision."""
    count = len(distance)
    runs: Any = assessed(np.zeros(count, dtype=np.int32), np.asarray(distance, dtype=float))
    flat = replace(runs, **changes)
    return evaluated(np.arange(count, dtype=float)[:, np.newaxis], map_arrays(flat, lambda array: array[:, np.newaxis]))


def said(*blame: Blame) -> Ints:
    return np.array(blame, dtype=np.int32)[:, np.newaxis]


def test_a_kind_is_what_happened() -> None:
    """Partner, side, heading, how fast each was, and what the reference driver says: each of these parts kinds."""
    same: dict[str, object] = {
        "pair": np.zeros(3, dtype=np.int32),
        "side": np.full(3, Side.LEFT, dtype=np.int32),
        "approach_angle": np.full(3, -np.pi / 2.0),
        "ego_speed": np.array([0.0, 0.0, -0.05]),
        "other_speed": np.array([31.0, 49.0, 40.0]) * KMH,
    }
    table = searched(np.full(3, 0.5), **same)
    (one,) = kinds(table, said(AVOIDABLE, AVOIDABLE, AVOIDABLE))
    assert one.kind == Kind(0, Side.LEFT, 6, 0, 2, AVOIDABLE)
    assert (one.count, one.row, one.kind.heading) == (3, 0, "90° right")
    assert (PACES[one.kind.ego_speed], PACES[one.kind.other_speed]) == ("stands", "30 .. 50")
    for name, other in (
        ("pair", 1),
        ("side", Side.REAR),
        ("approach_angle", 0.0),
        ("ego_speed", 1.0),
        ("other_speed", 20.0),
    ):
        changed = np.array(same[name])
        changed[2] = other
        assert len(kinds(searched(np.full(3, 0.5), **same | {name: changed}), said(*[AVOIDABLE] * 3))) == 2, name
    found = kinds(table, said(UNAVOIDABLE, UNAVOIDABLE, AVOIDABLE))
    assert [(each.kind.blame, each.count, each.row) for each in found] == [(AVOIDABLE, 1, 2), (UNAVOIDABLE, 2, 0)]


def test_counts_lead_with_what_speaks_against_the_ego() -> None:
    """Near misses and elites that were not run again count nowhere; being struck is no failure of the ego."""
    touched = np.array([0.5, 0.5, 0.5, 0.5, 4.0, 0.5])
    table = searched(touched, others_contact_time=np.array([np.nan, 1.0, np.nan, np.nan, 2.0, np.nan]))
    table = replace(table, reused=np.arange(6) == 5)
    came = failures(table, said(AVOIDABLE, UNAVOIDABLE, STRUCK, NONE, NONE, AVOIDABLE))
    assert (came.valid, came.collisions, came.avoidable, came.struck, came.unknown) == (5, 4, 1, 1, 1)
    assert (came.kinds, came.avoidable_kinds, came.without_ego) == (4, 1, 2)
    assert estimated_share(came.avoidable, came.valid) == pytest.approx(2.0 / 7.0)
    nothing = failures(searched(np.full(3, 5.0)), said(NONE, NONE, NONE))
    assert (nothing.collisions, nothing.kinds) == (0, 0)
    assert estimated_share(0, nothing.valid) == pytest.approx(0.2), "none of three is not never"


def test_only_distinct_collisions_are_driven_again() -> None:
    """Each once, by its own genome and key; nobody asked leaves all of them open."""
    table = replace(searched(np.array([0.5, 4.0, 0.5, 0.5])), reused=np.arange(4) == 3)
    table = replace(table, keys=np.arange(24).reshape(4, 1, 6))
    asked: list[tuple[Floats, Ints]] = []

    def blaming(genomes: Floats, keys: Ints) -> Ints:
        asked.append((genomes, keys))
        return np.array([AVOIDABLE, STRUCK], dtype=np.int32)

    assert blamed(table, blaming)[:, 0].tolist() == [AVOIDABLE, NONE, STRUCK, NONE]
    ((genomes, keys),) = asked
    assert genomes[:, 0].tolist() == [0.0, 2.0]
    assert keys[:, 0].tolist() == [0, 12]
    assert (blamed(table, None) == NONE).all()


Happening = tuple[int, int, int, int, int, int, float]
"""Pair, side, sector, both speeds, blame, least distance."""
codings = st.tuples(*(st.integers(0, most) for most in (2, 3, 7, 4, 4, 2)), st.floats(0.1, 3.0))
happenings = st.lists(codings, min_size=1, max_size=40)


def table_of(rows: list[Happening]) -> tuple[Evaluations, Ints]:
    pair, side, sector, ego, other, blame, distance = (np.array(column) for column in zip(*rows, strict=True))
    speeds = np.array([0.0, 20.0, 40.0, 60.0, 90.0]) * KMH
    table = searched(
        distance,
        pair=pair.astype(np.int32),
        side=side.astype(np.int32),
        approach_angle=sector * np.pi / 4.0,
        ego_speed=speeds[ego],
        other_speed=speeds[other],
    )
    hit = table.rollouts.collided[:, 0]
    return table, np.where(hit, blame, int(NONE)).astype(np.int32)[:, np.newaxis]


@given(happenings)
def test_kinds_count_collisions_whatever_led_to_them(rows: list[Happening]) -> None:
    """Their counts sum to the collisions; order and genomes change nothing, a copy adds no kind."""
    table, blame = table_of(rows)
    found, came = kinds(table, blame), failures(table, blame)
    assert sum(each.count for each in found) == came.collisions
    assert len({each.kind for each in found}) == len(found) == came.kinds <= came.collisions
    assert came.avoidable_kinds <= min(came.kinds, came.avoidable)
    order = np.random.default_rng(len(rows)).permutation(len(rows))
    turned = replace(take(table, order), genomes=np.random.default_rng(1).random((len(rows), 1)))
    assert {(each.kind, each.count) for each in kinds(turned, blame[order])} == {(e.kind, e.count) for e in found}
    twice = np.repeat(np.arange(len(rows)), 2)
    assert len(kinds(take(table, twice), blame[twice])) == len(found)


@given(happenings, st.integers(1, 12))
def test_the_worst_hold_each_partner_and_kind_before_a_second(rows: list[Happening], count: int) -> None:
    """As many partners and kinds as fit, the very worst among them, in the order of risk."""
    table, blame = table_of(rows)
    everyone = worst_cases(table, len(rows), blame)
    chosen = worst_cases(table, count, blame)
    order = [case.row for case in everyone]
    places = [order.index(case.row) for case in chosen]
    assert places == sorted(places)
    assert places[:1] == [0]
    assert len(chosen) == min(count, len(rows))
    finds = [case.row for case in everyone if case.collided]
    pool = finds if len(finds) >= count else order
    every = codes(table.rollouts, blame)[:, 0]
    each = {row: tuple(code) for row, code in enumerate(every.tolist())}
    partners, every = {each[row][0] for row in pool}, {each[row] for row in pool}
    # The worst of all may be a second of its partner or kind: it takes a place of its own at most.
    assert len({each[case.row][0] for case in chosen}) >= min(count - 1, len(partners))
    assert len({each[case.row] for case in chosen}) >= min(count - len(partners), len(every) - 1)


def test_avoidable_cases_come_into_the_list_first() -> None:
    """Of a hundred collisions of equal kind the one that a competent driver avoids is among the ten worst: before those
    of the same risk, behind those of more.
    """
    table = searched(np.linspace(0.1, 0.9, 100))
    blame = said(*[UNAVOIDABLE] * 99, AVOIDABLE)
    assert [case.row for case in worst_cases(table, 10, blame)] == [99, *range(9)]
    assert [case.row for case in worst_cases(table, 10)] == list(range(10))
    less = searched(np.linspace(0.1, 0.9, 100), score=np.array([22] * 99 + [21], dtype=np.int32))
    assert [case.row for case in worst_cases(less, 10, blame)] == [*range(9), 99]


def test_a_near_miss_takes_no_collisions_place() -> None:
    """While there are collisions enough, the list holds nothing else."""
    table = searched(np.array([0.1, 0.2, 2.0]), pair=np.array([0, 0, 1], dtype=np.int32))
    blame = said(UNAVOIDABLE, UNAVOIDABLE, NONE)
    assert [case.row for case in worst_cases(table, 2, blame)] == [0, 1]
    assert [case.row for case in worst_cases(table, 3, blame)] == [0, 1, 2]
