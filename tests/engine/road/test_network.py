"""Laws of every network that can be built."""

import math
from dataclasses import asdict, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given

from engine.maps import RoadSpec
from engine.road import Lane, LaneRole, Maneuver, Network, RoadError, build_network
from engine.road.grid import planned_grid
from engine.road.linking import meeting_turns
from engine.road.paths import Primitive
from engine.vocabulary import ManeuverType
from tests.engine.interchange.opendrive.reading_back import specs
from tests.engine.road.conflict_areas import Strip, conflict_areas
from tests.laws import examples

STRAIGHT, LEFT, RIGHT = ManeuverType.STRAIGHT, ManeuverType.LEFT_TURN, ManeuverType.RIGHT_TURN


few = examples(25)


def turn_of(network: Network, lane: Lane) -> float:
    """How far a lane turns left from its start to its end [rad]."""
    paths = network.paths
    return paths.pose(lane.path, lane.length).heading - paths.pose(lane.path, 0.0).heading


def by_name(network: Network, name: str) -> Maneuver:
    return next(maneuver for maneuver in network.maneuvers if maneuver.name == name)


def names(maneuvers: tuple[Maneuver, ...]) -> set[str]:
    return {maneuver.name for maneuver in maneuvers}


@few
@given(specs())
def test_lanes_meet_end_to_start(spec: RoadSpec) -> None:
    """Every lane starts where and as each of its predecessors ends."""
    network = build_network(spec)
    paths = network.paths
    for lane in network.lanes:
        for after in lane.successors:
            assert lane in after.predecessors
            end, start = paths.pose(lane.path, lane.length), paths.pose(after.path, 0.0)
            assert end[:2] == pytest.approx(start[:2], abs=1e-9)
            assert math.remainder(end.heading - start.heading, math.tau) == pytest.approx(0.0, abs=1e-9)


@few
@given(specs())
def test_routes_are_tangent_continuous(spec: RoadSpec) -> None:
    """At every joint inside every maneuver's trajectory position and heading agree to 1e-9."""
    network = build_network(spec)
    for maneuver in network.maneuvers:
        path = network.paths.join([lane.path for lane in maneuver.lanes])
        primitives = network.paths.primitives(path)
        for before, after in pairwise(primitives):
            end = before.pose(before.length)
            assert end[:2] == pytest.approx((after.x, after.y), abs=1e-9)
            assert math.remainder(end.heading - after.heading, math.tau) == pytest.approx(0.0, abs=1e-9)


@few
@given(specs())
def test_turns_turn_to_their_side_as_wide_as_fits(spec: RoadSpec) -> None:
    """Straight is a line; a turn is a quarter circle whose tangents end at the stop lines."""
    network = build_network(spec)
    half = spec.lanes * spec.lane_width
    for maneuver in network.maneuvers:
        turn = turn_of(network, maneuver.connecting_lane)
        primitives = network.paths.primitives(maneuver.connecting_lane.path)
        if maneuver.type is STRAIGHT:
            assert [p.curvature for p in primitives] == [0.0]
            assert maneuver.connecting_lane.length == pytest.approx(2.0 * (half + spec.corner_radius))
            continue
        assert turn == pytest.approx(math.pi / 2 if maneuver.type is LEFT else -math.pi / 2)
        from_kerb = (maneuver.start_lane.number - 0.5) * spec.lane_width
        is_near = (maneuver.type is LEFT) == spec.left_hand
        radius = spec.corner_radius + (from_kerb if is_near else 2.0 * half - from_kerb)
        assert [1.0 / abs(p.curvature) for p in primitives if p.curvature] == pytest.approx([radius])


@few
@given(specs())
def test_traffic_keeps_to_its_side(spec: RoadSpec) -> None:
    """Seen from an incoming lane, the outgoing lanes of its arm lie left in right-hand traffic, right in left-hand."""
    network = build_network(spec)
    for leg in (leg for intersection in network.intersections for leg in intersection.legs):
        for lane in leg.incoming_lanes:
            pose = network.paths.pose(lane.path, lane.length)
            for other in leg.outgoing_lanes:
                x, y, _ = network.paths.pose(other.path, 0.0)
                left = (y - pose.y) * math.cos(pose.heading) - (x - pose.x) * math.sin(pose.heading)
                assert (left > 0.0) != spec.left_hand


@few
@given(specs())
def test_every_lane_leads_somewhere_and_is_reached(spec: RoadSpec) -> None:
    """Incoming lanes have maneuvers; no maneuver leads back; every lane that leaves an intersection can be entered."""
    network = build_network(spec)
    for intersection in network.intersections:
        assert all(lane.maneuvers for lane in intersection.incoming_lanes)
        assert all(maneuver.intersection is intersection for maneuver in intersection.maneuvers)
        assert all(m.start_lane.road != m.end_lane.road for m in intersection.maneuvers)
    for lane in network.lanes:
        if lane.role is not LaneRole.INCOMING:
            assert lane.predecessors


@few
@given(specs())
def test_conflicts_are_symmetric_and_between_different_lanes(spec: RoadSpec) -> None:
    """If one maneuver is in the way of another, so is the other in its way; a lane is never in its own."""
    network = build_network(spec)
    for maneuver in network.maneuvers:
        for other in maneuver.conflicting_maneuvers:
            assert maneuver in other.conflicting_maneuvers
            assert other.start_lane is not maneuver.start_lane
            assert other.intersection is maneuver.intersection


@few
@given(specs())
def test_conflicting_strips_overlap(spec: RoadSpec) -> None:
    """Two maneuvers whose centre lines meet have a conflict area, however narrow the cars."""
    network = build_network(replace(spec, rows=1, cols=1))
    for maneuver in network.maneuvers[:4]:
        for other in maneuver.conflicting_maneuvers:
            assert conflict_areas(
                network.paths, Strip(maneuver.connecting_lane.path, 0.5), Strip(other.connecting_lane.path, 0.5)
            )


@few
@given(specs())
def test_straights_conflict_with_all_crossing_straights(spec: RoadSpec) -> None:
    """Of the straight maneuvers exactly those square to one's own conflict with it."""
    network = build_network(spec)
    for intersection in network.intersections:
        straight = [maneuver for maneuver in intersection.maneuvers if maneuver.type is STRAIGHT]
        headings = {m: network.paths.pose(m.connecting_lane.path, 0.0).heading for m in straight}
        for maneuver in straight:
            crossing = {m for m in straight if abs(math.cos(headings[m] - headings[maneuver])) < 0.5}
            assert crossing == {m for m in maneuver.conflicting_maneuvers if m.type is STRAIGHT}


@few
@given(specs())
def test_reverse_of_reverse(spec: RoadSpec) -> None:
    """Reversing swaps the roads of start and end, and is symmetric."""
    for maneuver in build_network(spec).maneuvers:
        for other in maneuver.reverse_maneuvers:
            assert (other.start_lane.road, other.end_lane.road) == (maneuver.end_lane.road, maneuver.start_lane.road)
            assert maneuver in other.reverse_maneuvers


@few
@given(specs())
def test_left_hand_traffic_is_the_mirror_image(spec: RoadSpec) -> None:
    """Mirrored at the y axis, each lane's centre line is one of the other hand's network (of one intersection)."""
    spec = replace(spec, rows=1, cols=1)
    one, other = build_network(spec), build_network(replace(spec, left_hand=not spec.left_hand))

    def signature(network: Network, lane: Lane, mirror: float) -> tuple[float, ...]:
        poses = [network.paths.pose(lane.path, share * lane.length) for share in (0.0, 0.5, 1.0)]
        return tuple(round(value, 6) + 0.0 for pose in poses for value in (mirror * pose.x, pose.y))

    assert sorted(signature(one, lane, -1.0) for lane in one.lanes) == sorted(
        signature(other, lane, 1.0) for lane in other.lanes
    )
    assert sum(m.type is LEFT for m in one.maneuvers) == sum(m.type is RIGHT for m in other.maneuvers)


@few
@given(specs())
def test_shared_roads_are_one_lane(spec: RoadSpec) -> None:
    """Between two intersections the lane that leaves the one is the very lane that enters the other."""
    network = build_network(spec)
    links = [lane for lane in network.lanes if lane.role is LaneRole.LINK]
    for lane in links:
        assert sum(lane in place.incoming_lanes for place in network.intersections) == 1
        assert sum(lane in place.outgoing_lanes for place in network.intersections) == 1
    horizontal, vertical = spec.rows * (spec.cols - 1), (spec.rows - 1) * spec.cols
    assert len(links) == 2 * spec.lanes * (horizontal + (vertical if spec.ways == 4 else 0))


@few
@given(specs())
def test_names_and_sources_are_unique_and_lead_back(spec: RoadSpec) -> None:
    """`network.lanes[12]` is lane 12; a maneuver's text names the same maneuver; names never repeat."""
    network = build_network(spec)
    for elements in (network.lanes, network.maneuvers, network.intersections):
        assert len({element.name for element in elements}) == len(elements)
        assert all(eval(element.source, {"network": network}) is element for element in elements)


@few
@given(specs())
def test_default_route_starts_with_its_lane(spec: RoadSpec) -> None:
    """It goes straight on where it can, and is the lane alone only where the network ends."""
    network = build_network(spec)
    for lane in network.lanes:
        length = network.paths.length(lane.default_route)
        assert network.paths.pose(lane.default_route, 0.0) == network.paths.pose(lane.path, 0.0)
        straight = [maneuver for maneuver in lane.maneuvers if maneuver.type is STRAIGHT]
        if straight:
            assert length == pytest.approx(sum(part.length for part in straight[0].lanes))
        assert (lane.default_route == lane.path) == (not lane.successors)


def test_arms_and_maneuvers_of_a_four_way_intersection() -> None:
    """One lane a direction: from each arm straight, left and right."""
    network = build_network(RoadSpec())
    (intersection,) = network.intersections
    assert intersection.is_4way
    assert not intersection.is_3way
    assert [lane.name for lane in intersection.incoming_lanes] == ["north.in.1", "east.in.1", "south.in.1", "west.in.1"]
    assert all([m.type for m in lane.maneuvers] == [STRAIGHT, LEFT, RIGHT] for lane in intersection.incoming_lanes)
    assert network.paths.pose(network.lanes[0].path, 0.0) == pytest.approx((-1.75, 59.5, -math.pi / 2))


@pytest.mark.parametrize("left_hand", [False, True])
def test_turns_start_at_the_side_they_lead_to(left_hand: bool) -> None:
    """Of three lanes all go straight on, the kerb's makes the near turn and the middle's the far turn."""
    near, far = (LEFT, RIGHT) if left_hand else (RIGHT, LEFT)
    for leg in build_network(RoadSpec(lanes=3, left_hand=left_hand)).intersections[0].legs:
        kinds = [{maneuver.type for maneuver in lane.maneuvers} for lane in leg.incoming_lanes]
        assert kinds == [{STRAIGHT, near}, {STRAIGHT}, {STRAIGHT, far}]
        assert all(m.end_lane.number == lane.number for lane in leg.incoming_lanes for m in lane.maneuvers)


def test_maneuvers_of_a_t_junction() -> None:
    """The through road runs west to east; its stem makes both turns."""
    network = build_network(RoadSpec(ways=3))
    (intersection,) = network.intersections
    assert intersection.is_3way
    assert [(lane.name, [m.type for m in lane.maneuvers]) for lane in intersection.incoming_lanes] == [
        ("east.in.1", [STRAIGHT, LEFT]),
        ("south.in.1", [LEFT, RIGHT]),
        ("west.in.1", [STRAIGHT, RIGHT]),
    ]


@pytest.mark.parametrize(("lanes", "turns"), [(1, "lr"), (2, "r l"), (3, "r lr l"), (4, "r r l l")])
def test_lanes_of_a_stem_share_the_turns(lanes: int, turns: str) -> None:
    """From the kerb to the middle: the kerb's half turns right, the middle's half left, one in between both."""
    stem = build_network(RoadSpec(ways=3, lanes=lanes)).intersections[0].legs[1].incoming_lanes
    assert " ".join("".join(m.type.name[0].lower() for m in lane.maneuvers) for lane in stem) == turns


def test_who_conflicts_with_a_straight_and_a_left_turn() -> None:
    """As a driver expects; two left turns from opposite arms pass in front of each other and do not meet."""
    network = build_network(RoadSpec())
    assert names(by_name(network, "south.1-north.1 straight").conflicting_maneuvers) == {
        "east.1-west.1 straight",
        "west.1-east.1 straight",
        "north.1-east.1 left_turn",
        "east.1-south.1 left_turn",
        "west.1-north.1 left_turn",
        "east.1-north.1 right_turn",
    }
    assert names(by_name(network, "south.1-west.1 left_turn").conflicting_maneuvers) == {
        "north.1-south.1 straight",
        "east.1-west.1 straight",
        "west.1-east.1 straight",
        "east.1-south.1 left_turn",
        "west.1-north.1 left_turn",
        "north.1-west.1 right_turn",
    }


@pytest.mark.parametrize("left_hand", [False, True])
@pytest.mark.parametrize("lanes", [1, 2, 3])
def test_adversaries_of_the_nhtsa_scripts(lanes: int, left_hand: bool) -> None:
    """Their filters pick the oncoming car (01, 05), the lateral ones (03, 04, 06), and those of the T (07)."""
    network = build_network(RoadSpec(lanes=lanes, left_hand=left_hand))
    for lane in network.intersections[0].incoming_lanes:
        straight = next(maneuver for maneuver in lane.maneuvers if maneuver.type is STRAIGHT)
        here, there = (straight.start_lane.road, straight.end_lane.road)
        reverse = [m for m in straight.reverse_maneuvers if m.type is STRAIGHT]
        assert {m.start_lane.road for m in reverse} == {there}
        assert len({m.start_lane for m in reverse}) == lanes
        assert any(m.type is LEFT for adversary in reverse for m in adversary.start_lane.maneuvers)
        lateral = [m for m in straight.conflicting_maneuvers if m.type is STRAIGHT]
        assert {m.start_lane.road for m in lateral} == {"north", "east", "south", "west"} - {here, there}
    fork = build_network(RoadSpec(ways=3, lanes=lanes, left_hand=left_hand))
    far = RIGHT if left_hand else LEFT
    turn = next(m for m in fork.maneuvers if m.type is far and m.start_lane.road == "south")
    assert {m.start_lane.road for m in turn.conflicting_maneuvers if m.type is STRAIGHT} == {"east", "west"}


def test_overlap_of_two_crossing_straights_is_as_long_as_the_other_car_is_wide() -> None:
    """Two 2 m strips that cross at right angles, 1.75 m from the middle of each road."""
    network = build_network(RoadSpec())
    first, second = by_name(network, "south.1-north.1 straight"), by_name(network, "west.1-east.1 straight")
    areas = conflict_areas(
        network.paths, Strip(first.connecting_lane.path, 2.0), Strip(second.connecting_lane.path, 2.0)
    )
    ((one, other),) = areas
    assert one == pytest.approx((9.5 - 1.75 - 1.0, 9.5 - 1.75 + 1.0), abs=1e-5)
    assert other == pytest.approx((9.5 + 1.75 - 1.0, 9.5 + 1.75 + 1.0), abs=1e-5)


def test_neighbouring_lanes_do_not_overlap() -> None:
    """Strips that share a border have no area in common."""
    network = build_network(RoadSpec(lanes=2))
    first, second = network.intersections[0].legs[0].incoming_lanes
    assert conflict_areas(network.paths, Strip(first.path, 3.5), Strip(second.path, 3.5)) == []


@pytest.mark.parametrize(
    ("change", "argument"),
    [
        ({"ways": 5}, "ways"),
        ({"lanes": 0}, "lanes"),
        ({"lanes": 5}, "lanes"),
        ({"lanes": 1.5}, "lanes"),
        ({"lane_width": math.nan}, "lane_width"),
        ({"lane_width": -1.0}, "lane_width"),
        ({"corner_radius": -0.1}, "corner_radius"),
        ({"corner_radius": math.inf}, "corner_radius"),
        ({"approach": 0.0}, "approach"),
        ({"block": math.nan}, "block"),
        ({"rows": 0}, "rows"),
        ({"cols": 2.5}, "cols"),
        ({"rows": 30, "cols": 20}, "rows"),
        ({"cols": 2, "block": 19.0}, "block"),
        ({"cols": 2, "corner_radius": 60.0}, "block"),
        ({"ways": 3, "rows": 2, "approach": 95.0}, "approach"),
    ],
)
def test_what_cannot_be_built_names_its_argument_and_a_cure(change: dict, argument: str) -> None:
    """One plain sentence, the argument to blame, and what to write instead."""
    with pytest.raises(RoadError) as caught:
        build_network(replace(RoadSpec(), **change))
    assert caught.value.argument == argument
    assert caught.value.message.startswith(f"`{argument}`") or argument in ("rows", "cols")
    assert caught.value.cure


def test_the_largest_network_is_built_in_seconds() -> None:
    """Four hundred intersections with their neighbours."""
    network = build_network(RoadSpec(rows=20, cols=20))
    assert len(network.intersections) == 400
    assert len(network.maneuvers) == 400 * 12
    assert np.isfinite([network.paths.length(path) for path in range(len(network.paths))]).all()


@few
@given(specs())
def test_networks_of_one_plan_are_independent(spec: RoadSpec) -> None:
    """They share shapes; paths and regions that a scenario adds to one are in no other, whoever was built first."""
    first = build_network(spec)
    whole = contents(first)
    first.regions.add([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    first.paths.add([Primitive(0.0, 0.0, 0.0, 0.0, 5.0)])
    assert contents(build_network(spec)) == whole
    planned_grid.cache_clear()
    meeting_turns.cache_clear()
    assert contents(build_network(spec)) == whole


def contents(network: Network) -> tuple[object, ...]:
    """Return shapes, paths and links of a network, without identities."""
    shapes = [network.regions.shape(region) for region in range(len(network.regions))]
    arrays = [array.tobytes() for shape in shapes for array in (shape.edges, shape.hull, shape.triangles, shape.cores)]
    paths = [network.paths.primitives(path) for path in range(len(network.paths))]
    return network.spec, arrays, paths, asdict(network.links), repr(network.lanes), repr(network.maneuvers)
