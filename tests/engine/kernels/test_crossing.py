"""Where ways cross and when two are there, against closed forms and against looking everywhere."""

import itertools
import math

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text
from engine.host import memory, plan, requested
from engine.kernels.crossing import CLEARANCE, Crossing, Foresight, crossing
from engine.kernels.geometry import Box, box_distance
from engine.kernels.path import chain_pose
from engine.kernels.rollout import advance, begin
from engine.kernels.run_state import RUNNING, Status

LENGTH, WIDTH, TO_CENTER = 4.508, 1.61, 1.423
ALL_AROUND = Foresight(-1, math.inf, math.tau, 0.0, 10.0, 0.0, 3.0, math.inf, math.inf)

CROSS = """
map intersection(approach=300 m)
ego = new Car at ({x}, 120), facing 0 deg, with speed {speed}, with regionContainedIn None
other = new {kind} at (120, {y}), facing {heading} deg, with speed {theirs}, with regionContainedIn None
terminate after 5 s
"""


def foreseen(scenario: Scenario, *looks: Foresight, sample: int = 0) -> Crossing:
    """What the ego foresees of the other at a sample of the only scene, with the last of several looks."""
    scenes = scenario.sample(1, seed=3)
    assert scenes.valid[0]
    shared, rows = plan(scenario.program, scenario.config.simulation), requested(scenario.program, scenes)
    run = memory(scenario.program, 200)
    begin(shared, run, int(rows.variant[0]), rows.values[0], rows.keys[0], rows.actions[0])
    advance(shared, run, sample, run.status[Status.END] == RUNNING)
    return [crossing(shared, run, sample, 0, 1, look) for look in looks or (ALL_AROUND,)][-1]


def test_a_kept_search_gives_what_a_new_one_gives() -> None:
    """For each order of distances, on both sides of the distance at which the area begins."""
    scenario, near = at_right_angles(), (0.0, 30.0, 36.5, 37.5, 40.0, math.inf)
    enter = foreseen(scenario).enter
    assert near[2] < enter < near[3]
    for first, second in itertools.permutations(near, 2):
        looks = [ALL_AROUND._replace(near=each, oncoming=each) for each in (first, second)]
        assert foreseen(scenario, *looks) == foreseen(scenario, looks[1])


def at_right_angles(kind: str = "Car", **numbers: float) -> Scenario:
    given = {"x": 80.0, "y": 70.0, "speed": 10.0, "theirs": 8.0, "heading": 90.0} | numbers
    return compile_text(CROSS.format(kind=kind, **given))


def test_two_straight_ways_at_right_angles() -> None:
    """40 m and 50 m from where they cross, less half of a length and of a width and the clearance."""
    found = foreseen(at_right_angles())
    reach = 0.5 * (LENGTH + WIDTH) + CLEARANCE
    assert found.enter == pytest.approx(40.0 - reach, abs=0.05)
    assert found.leave == pytest.approx(40.0 + reach, abs=0.05)
    assert found.their_enter == pytest.approx(50.0 - reach, abs=0.05)
    assert found.their_leave == pytest.approx(50.0 + reach, abs=0.05)
    assert found.along == pytest.approx(0.0, abs=1e-9)
    assert found.arrives == pytest.approx(found.enter / 10.0)
    assert found.clears == pytest.approx(found.leave / 10.0)
    assert found.their_arrival == pytest.approx(found.their_enter / 8.0)
    assert found.their_clearing == pytest.approx(found.their_leave / 8.0)
    # s = v t + a t^2 / 2
    soonest = (-8.0 + math.sqrt(64.0 + 2.0 * 3.0 * found.their_enter)) / 3.0
    assert found.earliest == pytest.approx(soonest)


@pytest.mark.parametrize(("inside", "back"), [(-1.0, 0.0), (0.5, 0.5), (2.5, 2.5), (3.5, math.inf)])
def test_the_way_back_out_of_the_area(inside: float, back: float) -> None:
    """As far as the nose is in it, up to three metres."""
    edge = 120.0 - 0.5 * (LENGTH + WIDTH) - CLEARANCE
    assert foreseen(at_right_angles(x=edge + inside)).back == pytest.approx(back, abs=0.1)


def test_who_accelerates_to_a_target_is_there_sooner() -> None:
    """From 10 m/s at 2 m/s^2 up to 14 m/s: 2 s and 24 m for that, the rest at 14 m/s."""
    found = foreseen(at_right_angles(), ALL_AROUND._replace(target=14.0, acceleration=2.0))
    # The way is gone through in pieces of 1.5 m, of which one has the target speed in its middle.
    assert found.clears == pytest.approx(2.0 + (found.leave - 24.0) / 14.0, abs=0.02)


@pytest.mark.parametrize("change", [{"heading": 270.0}, {"heading": 0.0}, {"y": 130.0}])
def test_ways_that_do_not_cross(change: dict[str, float]) -> None:
    """The other drives away, alongside, or has passed."""
    found = foreseen(at_right_angles("Car", **change))
    assert found.enter == math.inf
    assert found.earliest == math.inf


def test_what_lies_in_the_way_has_no_way_of_its_own_behind_it() -> None:
    """A thing 40 m ahead: the area begins at it, and the other is in it already."""
    found = foreseen(at_right_angles("Obstacle", y=120.0, theirs=0.0))
    assert found.enter == pytest.approx(40.0 - 0.5 * LENGTH - 0.5 - CLEARANCE, abs=0.05)
    assert found.their_enter == 0.0
    assert found.their_clearing == math.inf


@pytest.mark.parametrize(
    ("look", "seen"),
    [
        (ALL_AROUND._replace(reach=30.0), False),
        (ALL_AROUND._replace(reach=80.0), True),
        (ALL_AROUND._replace(angle=math.radians(60.0)), False),
        (ALL_AROUND._replace(angle=math.radians(120.0)), True),
        (ALL_AROUND._replace(latency=0.2), False),
    ],
)
def test_nobody_is_foreseen_who_is_not_seen(look: Foresight, seen: bool) -> None:
    """The other is 64 m away, 51 degrees to the right; at the start nothing is 0.2 s old."""
    assert (foreseen(at_right_angles(), look).enter < math.inf) == seen


TURN = """
map intersection(approach=60 m)
turn = filter(lambda m: m.type is ManeuverType.{ego}, intersection.maneuvers)[0]
other_way = Uniform(*filter(lambda m: m.type is ManeuverType.{other}, turn.conflictingManeuvers))
ego = new Car before intersection by {away} m along turn, with speed 8 m/s,
    with behavior FollowTrajectoryBehavior(8 m/s, turn)
other = new Car before intersection by {theirs} m along other_way, with speed 9 m/s,
    with behavior FollowTrajectoryBehavior(9 m/s, other_way)
terminate after 5 s
"""


@pytest.mark.parametrize(
    ("ego", "other"), [("LEFT_TURN", "STRAIGHT"), ("STRAIGHT", "LEFT_TURN"), ("LEFT_TURN", "LEFT_TURN")]
)
@pytest.mark.parametrize("away", [15, 30])
def test_ways_that_bend(ego: str, other: str, away: float) -> None:
    """The area begins and ends where all poses of one first and last touch any pose of the other."""
    scenario = compile_text(TURN.format(ego=ego, other=other, away=away, theirs=20))
    found = foreseen(scenario, sample=1)
    scenes = scenario.sample(1, seed=3)
    road = scenario.program.road
    states = np.array(scenario.watch(scenes).trajectory.states[1])
    paths = [_path_of(scenario, actor) for actor in (0, 1)]
    sweeps = [_sweep(road, path, states[actor]) for actor, path in enumerate(paths)]
    touching = np.array([[box_distance(a, b) < CLEARANCE for b in sweeps[1]] for a in sweeps[0]])
    mine, theirs = (np.flatnonzero(touching.any(axis=axis)) for axis in (1, 0))
    assert found.enter == pytest.approx(0.5 * mine[0], abs=0.75)
    assert found.their_enter == pytest.approx(0.5 * theirs[0], abs=0.75)
    if mine[-1] + 1 < len(sweeps[0]):
        assert found.leave == pytest.approx(0.5 * mine[-1], abs=1.0)


def _path_of(scenario: Scenario, actor: int) -> int:
    """The path that an actor follows: the one nearest to all of its run."""
    road, states = scenario.program.road, scenario.watch(scenario.sample(1, seed=3)).trajectory.states[:, actor]
    best = math.inf, -1
    for path in range(len(road.path_length)):
        first, last = int(road.path_start[path]), int(road.path_start[path + 1])
        places = [chain_pose(road.primitives, first, last, s) for s in np.arange(0.0, road.path_length[path], 1.0)]
        line = np.array([[pose.x, pose.y] for pose in places])
        worst = max(float(np.hypot(*(line - row[:2]).T).min()) for row in states[::10])
        best = min(best, (worst, path))
    return best[1]


def _sweep(road, path: int, state: np.ndarray) -> list[Box]:
    """Outlines every 0.5 m, from where an actor is to the end of its path."""
    first, last = int(road.path_start[path]), int(road.path_start[path + 1])
    axle = state[:2] - TO_CENTER * np.array([math.cos(state[2]), math.sin(state[2])])
    near = [
        math.hypot(*(axle - np.array(chain_pose(road.primitives, first, last, s)[:2]))) for s in np.arange(0, 60, 0.05)
    ]
    start, boxes = 0.05 * int(np.argmin(near)), []
    for s in np.arange(start, float(road.path_length[path]), 0.5):
        pose = chain_pose(road.primitives, first, last, s)
        cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        boxes.append(Box(pose.x + TO_CENTER * cos, pose.y + TO_CENTER * sin, pose.heading, LENGTH, WIDTH))
    return boxes
