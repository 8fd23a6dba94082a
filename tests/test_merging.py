"""A lane that ends beside another: where it does, who merges from it, who waits there, and who is seen behind."""

import math
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine.maps import LoneRoad, RoadSpec
from engine.road.build import build_network
from engine.road.merging import BACK, left_by, way_through
from engine.road.network import Network
from engine.road.opendrive.network import map_file
from engine.vocabulary import State
from tests.test_safety_models import states

RAMP = Path(__file__).parents[1] / "examples" / "roads" / "on_ramp.xodr"
FULL_WIDTH, NARROWS = 180.0, 60.0
"""How far the acceleration lane has its width, and over which way it loses it [m]."""


@pytest.fixture(scope="module")
def network() -> Network:
    return build_network(map_file(RAMP, RAMP.name))


def test_an_acceleration_lane_has_to_be_left_where_it_narrows(network: Network) -> None:
    """Before it is narrower than nine tenths of its width; that holds for the ramp that leads into it, too."""
    entry = next(lane for lane in network.lanes if lane.name == "road2.lane2")
    ramp = next(lane for lane in network.lanes if lane.name == "road3.lane0")
    joint = next(lane for lane in network.lanes if lane.name == "road11.lane0")
    before = ramp.length + joint.length
    assert before + FULL_WIDTH < left_by(entry) < before + FULL_WIDTH + 0.25 * NARROWS
    assert left_by(ramp) == pytest.approx(left_by(entry))
    assert [lane.name for lane in network.lanes if math.isfinite(left_by(lane))] == [
        "road2.lane2", "road3.lane0", "road11.lane0",
    ]  # fmt: skip


@pytest.mark.parametrize("spec", [RoadSpec(lanes=2), LoneRoad(lanes=3, one_way=True)])
def test_lanes_that_end_together_are_left_to_their_end(spec: RoadSpec | LoneRoad) -> None:
    """At the end of the map all lanes of a road end: nobody has to change."""
    assert all(left_by(lane) == math.inf for lane in build_network(spec).lanes)


def test_ways_begin_before_their_lanes(network: Network) -> None:
    """By what leads there, at least as far as drivers look back; a lane at the border begins with itself."""
    slow = next(lane for lane in network.lanes if lane.name == "road2.lane1")
    first = network.roads[0].lanes[0]
    assert way_through(first) == first.default_route
    whole = network.paths.length(way_through(slow))
    assert whole - network.paths.length(slow.default_route) >= BACK
    assert network.paths.pose(way_through(slow), 0.0).x == pytest.approx(-220.0)


MERGE = f"""
map opendrive("{RAMP}")
ramp, slow = network.roads[2].lanes[0], network.roads[0].lanes[0]
ego = new Car following roadDirection from ramp.centerline[0] for 100 m, with speed 20 m/s,
    with behavior LaneChoosingBehavior(20 m/s)
{{others}}
terminate after {{time}} s
"""
PLATOON = """
behavior Drive():
    do FollowLaneBehavior(20 m/s)
cars = [new Car following roadDirection from slow.centerline[0] for 8 m + 14 m * i, with speed 20 m/s,
    with behavior Drive() for i in range(14)]
"""


def test_who_is_alone_merges_at_once() -> None:
    """Without slowing down much, onto the middle of the next lane."""
    _, run = states(MERGE.format(others="", time=14))
    ego = run[:, 0]
    assert ego[:, State.SPEED].min() > 17.0
    assert ego[-1, State.X] > 150.0
    assert -7.0 < ego[-1, State.Y] < 0.0


def test_who_finds_no_gap_waits_at_the_end_and_merges_behind() -> None:
    """Cars with 14 m between them leave no gap: the ego slows down on its lane, and merges behind the last one."""
    _, run = states(MERGE.format(others=PLATOON, time=30))
    ego = run[:, 0]
    before = ego[:, State.Y] < -7.5
    assert ego[before, State.X].max() < FULL_WIDTH + 0.25 * NARROWS
    assert ego[:, State.SPEED].min() < 12.0
    assert -7.0 < ego[-1, State.Y] < 0.0
    gaps = np.hypot(*(run[:, 1:, :2] - run[:, :1, :2]).transpose(2, 0, 1))
    assert gaps.min() > 2.0


def test_who_comes_from_the_lane_before_is_seen() -> None:
    """A faster one, 10 m behind on the road that leads to the next lane's beginning, is let past."""
    others = """new Car following roadDirection from slow.centerline[0] for 96 m, with speed 24 m/s,
    with behavior FollowLaneBehavior(24 m/s)"""
    scenario = compile_text(MERGE.format(others=others, time=14))
    scenes = scenario.sample(1, seed=1)
    assert not scenario.simulate(scenes).collided.any()
    run = scenario.watch(scenes).trajectory.states
    over = int(np.argmax(run[:, 0, State.Y] > -7.0))
    assert over > 0
    assert run[over, 1, State.X] > run[over, 0, State.X] + 4.0


def test_hasty_mergers_fail_seldom() -> None:
    """The example: of 300 scenes nearly all end well, whoever pushes in."""
    scenario = compile_text((RAMP.parent / "on_ramp.scn").read_text().replace('"on_ramp.xodr"', f'"{RAMP}"'))
    scenes = scenario.sample(300, seed=2)
    assert scenes.valid.all()
    assert scenario.simulate(scenes).collided.mean() < 0.03
