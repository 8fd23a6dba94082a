"""Lanes side by side, and whom a maneuver gives way to."""

import math

import pytest

from engine.maps import RoadSpec
from engine.road.build import build_network
from engine.road.linking import NOWHERE, windows
from engine.road.network import LaneRole
from engine.road.sections import faster, group_of, road_of, slower, to_left, to_right
from engine.vocabulary import ManeuverType

SPECS = [
    RoadSpec(lanes=lanes, ways=ways, left_hand=left_hand)
    for lanes in (1, 2, 3)
    for ways in (3, 4)
    for left_hand in (False, True)
]


@pytest.mark.parametrize("spec", [*SPECS, RoadSpec(lanes=2, rows=1, cols=2, block=90.0)])
def test_neighbours_are_mutual(spec: RoadSpec) -> None:
    """My left neighbour has me on its right, or on its left where it comes towards me; they lie a width apart."""
    network = build_network(spec)
    for lane in network.lanes:
        if lane.role is LaneRole.CONNECTING:
            continue
        other = to_left(lane)
        if other is not None:
            back = to_right(other) if other.forward == lane.forward else to_left(other)
            assert back is lane
            x, y, heading = network.paths.pose(lane.path, 0.5 * lane.length)
            left = (x - spec.lane_width * math.sin(heading), y + spec.lane_width * math.cos(heading))
            assert network.paths.distance(other.path, *left) < 1e-6


@pytest.mark.parametrize("spec", SPECS)
def test_faster_lanes_lie_towards_the_middle(spec: RoadSpec) -> None:
    """As many lanes in a group as the map has; faster and slower undo one another."""
    network = build_network(spec)
    for road in network.roads:
        assert len(road.forward.lanes) == len(road.backward.lanes) == spec.lanes
        for lane in road.lanes:
            assert road_of(lane) == road
            assert lane in group_of(lane).lanes
            beside = faster(lane)
            assert beside is None or (slower(beside) is lane and beside.number == lane.number + 1)


def test_a_reversed_path_runs_back() -> None:
    """The same places from the end to the start, headings turned round; asked twice, the same path."""
    network = build_network(RoadSpec())
    path = network.maneuvers[0].connecting_lane.path
    back = network.paths.reverse(path)
    assert network.paths.reverse(path) == back
    length = network.paths.length(path)
    for s in (0.0, 0.3 * length, length):
        one, other = network.paths.pose(path, s), network.paths.pose(back, length - s)
        assert (one.x, one.y) == pytest.approx((other.x, other.y))
        assert math.cos(one.heading - other.heading) == pytest.approx(-1.0)


@pytest.mark.parametrize("left_hand", [False, True])
def test_a_turn_across_gives_way_to_oncoming_traffic(left_hand: bool) -> None:
    """Not to its own lane; and of the near turn into the other lane only from where ways meet."""
    network = build_network(RoadSpec(left_hand=left_hand))
    far = ManeuverType.RIGHT_TURN if left_hand else ManeuverType.LEFT_TURN
    turn = next(m for m in network.maneuvers if m.type is far)
    found = windows(turn)
    assert found[turn.start] == NOWHERE
    oncoming = next(m for m in network.maneuvers if m in turn.conflicting_maneuvers and m.type is ManeuverType.STRAIGHT)
    start, way = found[oncoming.start], found[oncoming.connecting]
    assert oncoming.start_lane.length <= start.enter <= oncoming.start_lane.length + way.enter
    assert 0.0 <= way.enter < way.leave <= oncoming.connecting_lane.length
