"""The risk score: Table 2 to the letter, its consequences, and the laws of the continuous score."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.outcomes import Outcomes, blank_outcomes
from engine.risk import (
    HIGHEST_RISK,
    LITERATURE,
    PAPER,
    PAPER_MM,
    PROFILES,
    RiskProfile,
    assess,
    band_score,
    continuous_score,
)
from engine.vocabulary import EndReason, Verdict

Pair = tuple[float, float, float]
"""MD, D_MS, TTC_MS."""
FAR: Pair = (100.0, 100.0, 100.0)

METRIC = st.one_of(st.floats(0.0, 80.0), st.just(np.inf))
PAIRS = st.tuples(METRIC, METRIC, METRIC)
ANY_PROFILE = st.sampled_from(list(PROFILES.values()))


def outcomes(*runs: tuple[Pair, ...], contact: dict[int, tuple[int, int]] | None = None) -> Outcomes:
    """One row a run, one (MD, D_MS, TTC_MS) a pair; `contact`: row -> the two actors."""
    n, pairs = len(runs), len(runs[0])
    values = np.array(runs, dtype=float).reshape(n, pairs, 3)
    touching = np.full((n, 2), -1)
    for row, actors in (contact or {}).items():
        touching[row] = actors
        if actors[0] == 0:
            values[row, actors[1] - 1, 0] = 0.0
    return blank_outcomes(
        n,
        pairs + 1,
        verdict=np.zeros(n, np.int32),
        collided=touching[:, 0] == 0,
        end_reason=np.full(n, EndReason.TIMEOUT, np.int32),
        end_time=np.full(n, 20.0),
        steps=np.full(n, 400, np.int32),
        min_distance=values[..., 0],
        distance_at_ms=values[..., 1],
        ttc_at_ms=values[..., 2],
        contact_actors=touching.astype(np.int32),
    )


@pytest.mark.parametrize(
    ("place", "edges"),
    [(0, (8.20, 11.00, 13.76, 16.55)), (1, (37.80, 40.20, 42.55, 44.90)), (2, (3.59, 3.94, 4.29, 4.64))],
)
def test_bands_are_closed_below_and_open_above(place: int, edges: tuple[float, ...]) -> None:
    """At an edge the lower score holds, the smallest number below it still has the higher: nothing is rounded."""
    for points, edge in zip((3, 2, 1, 0), edges, strict=True):
        at, below = [list(FAR), list(FAR)]
        at[place], below[place] = edge, float(np.nextafter(edge, 0.0))
        scores = assess(outcomes((tuple(at),), (tuple(below),))).score  # type: ignore[arg-type]
        assert scores.tolist() == [points, points + 1]


def test_paper_mm_is_a_tenth_of_paper() -> None:
    """The rival reading has the printed numbers in millimetres and milliseconds."""
    for name in ("min_distance", "distance_at_ms", "ttc_at_ms"):
        assert getattr(PAPER_MM, name) == pytest.approx([edge / 10 for edge in getattr(PAPER, name)])


@given(st.lists(st.tuples(PAIRS, st.booleans()), min_size=1, max_size=30), ANY_PROFILE)
def test_a_collision_scores_14_or_more_and_13_does_not_occur(
    runs: list[tuple[Pair, bool]], profile: RiskProfile
) -> None:
    """MD is 0 on contact, which adds 4 to the 10; without contact 12 is the most."""
    contact = {row: (0, 1) for row, (_, touches) in enumerate(runs) if touches}
    risk = assess(outcomes(*((pair,) for pair, _ in runs), contact=contact), profile)
    collided = np.array([touches for _, touches in runs])
    assert np.all(risk.score[collided] >= 14)
    assert np.all(risk.score[~collided] <= 12)
    assert np.all((risk.score >= 0) & (risk.score <= HIGHEST_RISK))
    assert np.array_equal(risk.parts.sum(axis=1), risk.score)


@given(st.lists(METRIC, min_size=1, max_size=20), ANY_PROFILE)
def test_continuous_score_stays_near_its_band_and_never_rises_with_distance(
    values: list[float], profile: RiskProfile
) -> None:
    """Each term is within 1 of its band and non-increasing; the bands are non-increasing, too."""
    ordered = np.sort(values)
    for edges in (profile.min_distance, profile.distance_at_ms, profile.ttc_at_ms):
        smooth, bands = continuous_score(ordered, edges), band_score(ordered, edges)
        assert np.all(np.abs(smooth - bands) <= 1.0)
        assert np.all((smooth >= 0.0) & (smooth <= 4.0))
        assert np.all(np.diff(smooth) <= 0.0)
        assert np.all(np.diff(bands) <= 0)


def test_continuous_score_climbs_inside_a_band() -> None:
    """Nearer is more, even where the integer says the same."""
    risk = assess(outcomes(((6.0, 30.0, 3.0),), ((5.0, 30.0, 3.0),)))
    assert risk.score[0] == risk.score[1]
    assert risk.continuous[1] > risk.continuous[0]


def test_pairs_that_never_approach_score_by_distance_alone() -> None:
    """D_MS and TTC_MS are infinite there and add nothing."""
    risk = assess(outcomes(((1.0, np.inf, np.inf),)))
    assert risk.parts.tolist() == [[0, 4, 0, 0]]
    assert risk.continuous[0] == pytest.approx(4.0 - 1.0 / 8.2)


def test_the_riskiest_pair_decides() -> None:
    """Parts are those of the deciding pair, whoever has the least distance."""
    near, fast = (1.0, 100.0, 100.0), (9.0, 30.0, 3.0)
    risk = assess(outcomes((near, fast), (fast, near), (FAR, near)))
    assert risk.score.tolist() == [11, 11, 4]
    assert risk.pair.tolist() == [1, 0, 1]
    assert risk.parts[0].tolist() == [0, 3, 4, 4]


def test_ties_go_to_who_moves_then_to_who_comes_nearer() -> None:
    """Whatever the order of the actors: a truck in the next lane does not stand for a pedestrian in front."""
    near, nearer = (1.47, 100.0, 100.0), (0.70, 100.0, 100.0)
    for runs, best in (((near, nearer), 1), ((nearer, near), 0)):
        risk = assess(outcomes(runs))
        assert (risk.score.tolist(), risk.pair.tolist()) == ([4], [best])
        standing = replace(outcomes(runs), other_speed=np.array([[0.0, 5.0]]))
        assert assess(standing).pair.tolist() == [1]


@given(st.lists(PAIRS, min_size=2, max_size=5), st.data())
def test_the_order_of_pairs_changes_nothing(pairs: list[Pair], data: st.DataObject) -> None:
    """Score, continuous score and parts are the same, and the deciding pair is the same one, or has equal metrics."""
    order = data.draw(st.permutations(range(len(pairs))))
    speeds = data.draw(st.lists(st.sampled_from((0.0, 3.0)), min_size=len(pairs), max_size=len(pairs)))
    one = replace(outcomes(tuple(pairs)), other_speed=np.array([speeds]))
    other = replace(outcomes(tuple(pairs[k] for k in order)), other_speed=np.array([[speeds[k] for k in order]]))
    before, after = assess(one), assess(other)
    assert (before.score, before.continuous, before.parts.tolist()) == (
        after.score,
        after.continuous,
        after.parts.tolist(),
    )
    chosen, again = int(before.pair[0]), order[int(after.pair[0])]
    distance = one.min_distance[0]
    assert (chosen == again) or (speeds[chosen] > 0.1, distance[chosen]) == (speeds[again] > 0.1, distance[again])


@given(st.lists(PAIRS, min_size=2, max_size=5), st.data(), ANY_PROFILE)
def test_a_parked_object_decides_only_by_its_score(
    pairs: list[Pair], data: st.DataObject, profile: RiskProfile
) -> None:
    """Parts add up to the score, a further pair never lowers it, and among equal scores a moving partner decides."""
    speeds = data.draw(st.lists(st.sampled_from((0.0, 3.0)), min_size=len(pairs), max_size=len(pairs)))
    run = replace(outcomes(tuple(pairs)), other_speed=np.array([speeds]))
    risk, fewer = assess(run, profile), assess(outcomes(tuple(pairs[:-1])), profile)
    assert risk.parts[0].sum() == risk.score[0] >= fewer.score[0]
    assert risk.continuous[0] >= fewer.continuous[0]
    alone = [assess(outcomes((pair,)), profile).score[0] for pair in pairs]
    moving = [score for score, speed in zip(alone, speeds, strict=True) if speed > 0.0]
    assert (speeds[risk.pair[0]] == 0.0) == (max(alone) not in moving)


def test_contact_counts_for_the_egos_pair_alone() -> None:
    """The ego's contact with actor 2 is that pair's; one between actors 1 and 2 is nobody's."""
    risk = assess(outcomes((FAR, FAR), (FAR, FAR), contact={0: (0, 2), 1: (1, 2)}))
    assert risk.score.tolist() == [14, 0]
    assert risk.pair.tolist() == [1, 0]
    assert risk.parts.tolist() == [[10, 4, 0, 0], [0, 0, 0, 0]]


def test_what_was_not_valid_scores_minus_one() -> None:
    """Whatever the reason; nothing else of such a row means anything."""
    rows, others = len(Verdict), len(Verdict) - 1
    run = outcomes(*([(FAR,)] * rows))
    broken = replace(run, verdict=np.array(list(Verdict), np.int32), min_distance=np.full((rows, 1), np.nan))
    risk = assess(broken)
    assert risk.score.tolist() == [0] + [-1] * others
    assert risk.continuous.tolist()[1:] == [-1.0] * others
    assert risk.pair.tolist() == [0] + [-1] * others


def test_an_ego_alone_has_no_risk() -> None:
    """Without a pair there is nothing to score."""
    alone = outcomes(((FAR),))
    alone = replace(
        alone, **{n: np.zeros((1, 0)) for n in ("min_distance", "distance_at_ms", "ttc_at_ms", "min_distance_time")}
    )
    risk = assess(alone)
    assert (risk.score.tolist(), risk.pair.tolist(), risk.parts.tolist()) == ([0], [-1], [[0, 0, 0, 0]])


def test_a_profile_needs_ascending_thresholds() -> None:
    """Anything else names the metric."""
    with pytest.raises(ValueError, match="D_MS: expected 4 positive thresholds"):
        replace(PAPER, distance_at_ms=(4.0, 3.0, 2.0, 1.0))


def test_literature_leaves_one_band_empty() -> None:
    """Two equal edges: the score steps from 4 to 2, and the continuous one stays with it."""
    values = np.array([0.90, 0.91, 1.49, 1.5, 2.0])
    assert band_score(values, LITERATURE.min_distance).tolist() == [4, 2, 2, 1, 0]
    assert np.all(np.abs(continuous_score(values, LITERATURE.min_distance) - [4, 2, 2, 1, 0]) <= 1.0)
