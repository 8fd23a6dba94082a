"""The batch host: rows are independent, threads change nothing, and physics knows no direction."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.outcomes import Outcomes
from engine.vocabulary import Column, EndReason, ManeuverType, State, Verdict
from tests.laws import examples


def assert_same(one: Outcomes, other: Outcomes) -> None:
    for field in fields(Outcomes):
        assert np.array_equal(getattr(one, field.name), getattr(other, field.name), equal_nan=True), field.name


def rows_of(scenes, rows):
    return replace(scenes, **{f.name: getattr(scenes, f.name)[rows] for f in fields(scenes)})


def test_threads_change_nothing(hand, crossing, crossing_scenes) -> None:
    """One thread and two give the same outcomes, bit for bit."""
    scenes = crossing_scenes(60)
    assert_same(hand.outcome(crossing, scenes, jobs=1), hand.outcome(crossing, scenes, jobs=2))


def test_rows_are_independent(hand, crossing, crossing_scenes) -> None:
    """A scene's outcome depends neither on its neighbours nor on their order."""
    scenes = crossing_scenes(40)
    order = np.random.default_rng(1).permutation(40)[:15]
    all_rows, some = hand.outcome(crossing, scenes), hand.outcome(crossing, rows_of(scenes, order))
    assert_same(some, Outcomes(**{f.name: getattr(all_rows, f.name)[order] for f in fields(Outcomes)}))


def test_invalid_scenes_are_skipped(hand, crossing, crossing_scenes) -> None:
    """They keep their verdict; numbers are NaN and everything counted is -1."""
    scenes = crossing_scenes(3)
    verdict = np.array([Verdict.VALID, Verdict.EXHAUSTED, Verdict.INFEASIBLE], dtype=np.int32)
    values = scenes.values.copy()
    values[1:] = math.nan
    outcome = hand.outcome(crossing, replace(scenes, verdict=verdict, values=values))
    assert list(outcome.verdict) == list(verdict)
    assert np.isnan(outcome.min_distance[1:]).all()
    assert np.isnan(outcome.end_time[1:]).all()
    assert list(outcome.end_reason[1:]) == [-1, -1]
    assert outcome.end_reason[0] >= 0


def test_no_scenes_no_outcomes(hand, crossing, crossing_scenes) -> None:
    """An empty batch is a batch."""
    assert len(hand.outcome(crossing, rows_of(crossing_scenes(1), slice(0, 0)))) == 0


def test_trajectory_is_the_run_of_the_batch(hand, crossing, crossing_scenes) -> None:
    """Its last sample is the end of the run, or the last one before contact."""
    scenes = crossing_scenes(30, seed=5)
    outcome = hand.outcome(crossing, scenes)
    assert outcome.collided.any()
    assert not outcome.collided.all()
    for row in range(30):
        states = hand.states(crossing, scenes, row)
        last = (len(states) - 1) * 0.05
        if outcome.collided[row]:
            assert last < outcome.end_time[row] <= last + 0.05
        else:
            assert last == pytest.approx(outcome.end_time[row])


def test_an_invalid_scene_has_no_trajectory(hand, crossing, crossing_scenes) -> None:
    """Asking for one says so."""
    scenes = replace(crossing_scenes(1), verdict=np.array([Verdict.EXHAUSTED], dtype=np.int32))
    with pytest.raises(ValueError, match="scene 0 is not valid"):
        hand.states(crossing, scenes)


def turned(program, scenes, angle: float, dx: float, dy: float, side: float):
    """Everything mirrored (side = -1), turned about the origin and shifted."""

    def points(x, y):
        y = side * y
        return math.cos(angle) * x - math.sin(angle) * y + dx, math.sin(angle) * x + math.cos(angle) * y + dy

    road = program.road
    primitives, edges = road.primitives.copy(), road.edges.copy()
    primitives[:, 1], primitives[:, 2] = points(road.primitives[:, 1], road.primitives[:, 2])
    primitives[:, 3] = side * primitives[:, 3] + angle
    primitives[:, 4] *= side
    primitives[:, 6], primitives[:, 7] = np.cos(primitives[:, 3]), np.sin(primitives[:, 3])
    for x in (0, 2):
        edges[:, x], edges[:, x + 1] = points(road.edges[:, x], road.edges[:, x + 1])
    no_cores = {"cores": np.zeros((0, 4)), "core_start": np.zeros_like(road.core_start)}
    no_cells = {"cell_edges": np.zeros((0, 4)), "cell_start": np.zeros(1, dtype=np.int32)}
    values = scenes.values.copy()
    for first in (0, len(Column)):
        values[:, first], values[:, first + 1] = points(scenes.values[:, first], scenes.values[:, first + 1])
        values[:, first + Column.HEADING] = side * values[:, first + Column.HEADING] + angle
    values[:, -2], values[:, -1] = points(scenes.values[:, -2], scenes.values[:, -1])
    moved_road = road._replace(primitives=primitives, edges=edges, **no_cores, **no_cells)
    return replace(program, road=moved_road), replace(scenes, values=values)


@given(
    angle=st.floats(-math.pi, math.pi),
    dx=st.floats(-100, 100),
    dy=st.floats(-100, 100),
    side=st.sampled_from([1.0, -1.0]),
)
@settings(examples(12), suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_physics_knows_no_direction(hand, turning, crossing_scenes, angle, dx, dy, side) -> None:
    """A mirrored, turned and shifted world gives the same outcomes and the moved states."""
    routes = {"ego": hand.route("south", ManeuverType.STRAIGHT), "other": hand.route("north", ManeuverType.LEFT_TURN)}
    scenes = crossing_scenes(12, seed=7, **routes)
    program, moved = turned(turning, scenes, angle, dx, dy, side)
    here, there = hand.outcome(turning, scenes), hand.outcome(program, moved)
    assert np.array_equal(here.collided, there.collided)
    assert np.array_equal(here.end_reason, there.end_reason)
    for name in ("end_time", "min_distance", "max_closing_speed", "left_road_time", "lateral_grip", "combined_grip"):
        assert getattr(there, name) == pytest.approx(getattr(here, name), abs=1e-5, nan_ok=True), name
    for row in range(3):
        a, b = hand.states(turning, scenes, row), hand.states(program, moved, row)
        assert b[..., State.SPEED] == pytest.approx(a[..., State.SPEED], abs=1e-8)
        assert b[..., State.STEER] == pytest.approx(side * a[..., State.STEER], abs=1e-8)


def test_all_ends_occur(hand, turning, crossing_scenes) -> None:
    """The paper's kind of scenario ends in collisions, by rules and by time: none is dead."""
    routes = {"ego": hand.route("south", ManeuverType.STRAIGHT), "other": hand.route("north", ManeuverType.LEFT_TURN)}
    outcome = hand.outcome(turning, crossing_scenes(200, seed=2, **routes))
    assert {EndReason.COLLISION, EndReason.RULE} <= set(outcome.end_reason.tolist())
    assert set(outcome.end_rule[outcome.end_reason == EndReason.RULE].tolist()) == {0, 1}
    assert np.all(outcome.verdict == Verdict.VALID)
