"""Cyclists keep their side, look back before they turn across their lane, and pass queues where there is room."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import compile_text
from engine import batch, world
from engine.tables import Floats
from engine.vocabulary import State
from tests.laws import examples

BIKE_WIDTH, CAR_WIDTH = 0.6, 1.61


def states(text: str) -> Floats:
    """States (samples, actors, columns) of the only scene; both hosts agree on it."""
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=5)
    assert scenes.valid[0]
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    pose = [State.X, State.Y, State.HEADING]
    np.testing.assert_allclose(slow.states[: len(fast.time), :, pose], fast.states[..., pose], rtol=0.0, atol=1e-9)
    return fast.states


@examples(6, dear=True)
@given(edge=st.floats(0.4, 1.6), width=st.floats(3.3, 4.5), left=st.booleans(), speed=st.floats(2.0, 7.0))
def test_a_cyclist_keeps_its_distance_from_the_edge(edge: float, width: float, left: bool, speed: float) -> None:
    """On either side of the road, within 5 cm after the way over."""
    text = f"""map road(length=300 m, lane_width={width} m, left_hand={left})
ego = new Bicycle following roadDirection from network.lanes[0].centerline[0] for 10 m, with speed {speed} m/s,
    with behavior CyclingBehavior({speed} m/s, edge={edge} m)
terminate after 15 s
"""
    run = states(text)
    kerb = (width if left else -width) * (1.0 if run[0, 0, State.X] < run[-1, 0, State.X] else -1.0)
    assert np.all(np.abs(np.abs(kerb - run[200:, 0, State.Y]) - edge) < 0.05)


def test_a_cyclist_rides_along_a_bicycle_lane() -> None:
    """In its middle."""
    text = """map road(length=300 m, bike_lane=1.8 m)
ego = new Bicycle at network.bikeLanes[0].centerline.start offset by (0 m, 20 m), with regionContainedIn None,
    with speed 4 m/s, with behavior CyclingBehavior(4 m/s, network.bikeLanes[0])
terminate after 15 s
"""
    run = states(text)
    np.testing.assert_allclose(run[:, 0, State.Y], -(3.5 + 0.9), atol=0.01)


TURN = """
map intersection(approach=120 m)
way = intersection.route("south", "{end}")
straight = intersection.route("south", "north")
ego = new Bicycle before intersection by 60 m along way, with speed 4 m/s, with behavior CyclingBehavior(15 km/h, way)
car = new Car before intersection by {behind} m along straight, with speed {speed} m/s,
    with behavior FollowTrajectoryBehavior({speed} m/s, straight)
terminate after 25 s
"""


def test_a_cyclist_moves_over_before_a_turn_across_its_lane() -> None:
    """Without traffic it is in the middle of the lane 8 m before the turn; for another turn it keeps its side."""
    across = states(TURN.format(end="west", behind=112, speed=0.0))
    near = states(TURN.format(end="east", behind=112, speed=0.0))
    for run, offset in ((across, 0.0), (near, 0.75)):
        at = np.argmax(run[:, 0, State.Y] > -18.0)
        assert run[at, 0, State.X] == pytest.approx(1.75 + offset, abs=0.1)


@pytest.mark.parametrize("behind", [68, 74, 80, 86, 92, 98])
def test_a_cyclist_looks_back_before_it_moves_over(behind: float) -> None:
    """No car is beside the cyclist, or reaches it within 2 s, when it leaves its side; the two never touch."""
    text = TURN.format(end="west", behind=behind, speed=6.0).replace("m/s, straight)", "m/s, straight, offset=0.6 m)")
    run = states(text)
    begins = np.argmax((run[:, 0, State.X] < 1.75 + 0.7) & (np.arange(len(run)) > 80))
    gap = run[begins, 0, State.Y] - run[begins, 1, State.Y] - 0.5 * (4.508 + 1.8)
    closing = run[begins, 1, State.SPEED] - run[begins, 0, State.SPEED]
    has_passed = gap < -(4.508 + 1.8)
    assert has_passed or gap > 2.0 * closing - 1.5
    assert np.hypot(*(run[:, 0, :2] - run[:, 1, :2]).T).min() > 0.5 * (BIKE_WIDTH + CAR_WIDTH)
    assert run[begins, 0, State.Y] > -9.5 - 31.0


@pytest.mark.parametrize(("room", "passes"), [(0.4, False), (0.6, True), (1.5, True)])
def test_a_cyclist_filters_past_a_queue_where_there_is_room(room: float, passes: bool) -> None:
    """At 0.5 m or more beside standing cars; otherwise it waits behind the first."""
    text = f"""map road(length=300 m, lane_width=6 m)
ego = new Bicycle at (-100 m, -5 m), facing 0 deg, with speed 4 m/s, with behavior CyclingBehavior(4 m/s)
first = new Car at (-40 m, {-5 + room + 0.5 * (BIKE_WIDTH + CAR_WIDTH)} m), facing 0 deg, with behavior BrakeBehavior()
second = new Car ahead of first by 3 m, with behavior BrakeBehavior()
terminate after 40 s
"""
    run = states(text)
    assert (run[-1, 0, State.X] > 0.0) == passes
    if not passes:
        assert run[-1, 0, State.X] < -40.0 - 0.5 * 4.508
