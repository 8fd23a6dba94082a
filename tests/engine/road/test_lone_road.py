"""Lone roads: lanes beside the middle line, the surface that they cover, and what cannot be built."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.opendrive import road_map
from engine.maps import LoneRoad, map_content, map_from
from engine.road import Network, RoadError, build_network
from engine.road.outline import outline
from engine.road.sections import faster, opposite_group, slower, to_left, to_right


@st.composite
def specs(draw: Callable) -> LoneRoad:
    lanes, width = draw(st.integers(1, 4)), draw(st.floats(2.0, 5.0))
    curve = draw(st.none() | st.floats(1.5 * lanes * width + 5.01, 2000.0))
    turns = None if curve is None else draw(st.none() | st.floats(0.1, math.pi))
    most = 270.0 if curve is None or turns is not None else math.radians(269.0) * curve
    length = draw(st.floats(10.0, max(11.0, min(2000.0, most))))
    if curve is not None and turns is not None:
        length = max(length, curve * turns)
    side = draw(st.sampled_from((1.0, -1.0)))
    hands = {"one_way": draw(st.booleans()), "left_hand": draw(st.booleans())}
    return LoneRoad(lanes, length, None if curve is None else side * curve, turns, width, **hands)


def lateral(network: Network, lane: int, share: float) -> float:
    """How far left of the middle line of the road a point of a lane lies, as the forward lanes run [m]."""
    paths, line = network.paths, network.lanes[lane]
    pose = paths.pose(line.path, share * line.length)
    middle = paths.add(network.roads[0].middle)
    foot = paths.pose(middle, paths.project(middle, pose.x, pose.y))
    return (pose.y - foot.y) * math.cos(foot.heading) - (pose.x - foot.x) * math.sin(foot.heading)


@given(specs(), st.floats(0.0, 1.0))
def test_lanes_run_beside_the_middle_line(spec: LoneRoad, share: float) -> None:
    """Each at its distance, its neighbour towards the kerb further out; traffic keeps to its side."""
    network = build_network(spec)
    assert len(network.lanes) == spec.lanes * (1 if spec.one_way else 2)
    for lane in network.lanes:
        out = (spec.lanes - lane.number + 0.5) * spec.lane_width
        side = 1.0 if lane.forward == spec.left_hand else -1.0
        assert lateral(network, lane.id, share) == pytest.approx(side * out, abs=1e-6)


@given(specs())
def test_the_middle_lies_at_the_origin(spec: LoneRoad) -> None:
    """There the forward lanes run east; the middle line is as long as was asked for."""
    network = build_network(spec)
    paths, middle = network.paths, network.paths.add(network.roads[0].middle)
    assert paths.length(middle) == pytest.approx(spec.length)
    assert paths.pose(middle, 0.5 * spec.length) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert all(abs(each.curvature * each.length) <= math.pi + 1e-9 for each in paths.primitives(middle))


@given(specs(), st.floats(0.0, 1.0))
def test_lanes_cover_the_road(spec: LoneRoad, share: float) -> None:
    """Their areas add up to the road's, and their centres lie in it."""
    network = build_network(spec)
    whole = sum(network.regions.area(lane.region) for lane in network.lanes)
    assert whole == pytest.approx(network.regions.area(0), rel=2e-3)
    for lane in network.lanes:
        x, y, _ = network.paths.pose(lane.path, (0.01 + 0.98 * share) * lane.length)
        assert network.regions.contains(0, x, y)
        assert network.regions.contains(lane.region, x, y)


@given(specs(), st.floats(0.0, 1.0))
def test_places_of_others_are_ours(spec: LoneRoad, share: float) -> None:
    """Arc length on the road's reference line is that of the nearest point there."""
    roads = road_map(spec)
    network = roads.network
    middle = network.paths.add(network.roads[0].middle)
    for lane in network.lanes:
        pose = network.paths.pose(lane.path, share * lane.length)
        expected = network.paths.project(middle, pose.x, pose.y)
        assert roads.place(lane.id, share * lane.length).s == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("left_hand", [False, True])
def test_neighbours(left_hand: bool) -> None:
    """Faster lanes lie towards the middle; across it the other direction begins, unless the road is one-way."""
    two, one = (build_network(LoneRoad(lanes=2, left_hand=left_hand, one_way=way)) for way in (False, True))
    kerb, inner = two.lanes[:2]
    assert (faster(kerb), slower(inner), faster(inner)) == (inner, kerb, None)
    across = to_right if left_hand else to_left
    assert across(inner) is two.lanes[3]
    assert across(one.lanes[1]) is None
    assert opposite_group(one.lanes[0]) is None
    assert [len(road.groups) for road in (*two.roads, *one.roads)] == [2, 1]


@given(specs())
def test_it_is_drawn_with_two_kerbs(spec: LoneRoad) -> None:
    """And with one line between neighbouring lanes."""
    network = build_network(spec)
    drawn = outline(network)
    assert len(drawn.kerbs) == 2
    assert len(drawn.middle_lines) == (0 if spec.one_way else 1)
    assert len(drawn.lane_lines) == len(network.lanes) - len(network.roads[0].groups)
    assert len(drawn.center_lines) == len(drawn.widths)
    assert drawn.reach == pytest.approx(spec.lanes * spec.lane_width)
    apart = np.hypot(*(drawn.kerbs[0][0] - drawn.kerbs[1][[0, -1]]).T).min()
    assert apart == pytest.approx(drawn.reach * (1 if spec.one_way else 2), rel=1e-6)


@given(specs())
def test_specifications_survive_json(spec: LoneRoad) -> None:
    """Whoever saves a program can make its road again."""
    assert map_from(map_content(spec)) == spec


@pytest.mark.parametrize(
    ("spec", "argument"),
    [
        (LoneRoad(lanes=5), "lanes"),
        (LoneRoad(lane_width=0.0), "lane_width"),
        (LoneRoad(length=math.nan), "length"),
        (LoneRoad(length=5.0), "length"),
        (LoneRoad(curve=math.nan), "curve"),
        (LoneRoad(curve=math.inf), "curve"),
        (LoneRoad(curve=0.0), "curve"),
        (LoneRoad(curve=-9.0, lanes=2), "curve"),
        (LoneRoad(curve=50.0, length=400.0), "length"),
        (LoneRoad(curve=50.0, bend=1.0, length=40.0), "length"),
        (LoneRoad(curve=50.0, bend=4.0), "bend"),
        (LoneRoad(curve=50.0, bend=math.nan), "bend"),
        (LoneRoad(bend=1.0), "bend"),
    ],
)
def test_what_cannot_be_built(spec: LoneRoad, argument: str) -> None:
    """The message names what must change."""
    with pytest.raises(RoadError) as caught:
        build_network(spec)
    assert caught.value.argument == argument
    assert caught.value.cure
