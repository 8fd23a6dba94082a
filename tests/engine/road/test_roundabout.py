"""Roundabouts: lanes follow one another round the ring, surfaces add up, who gives way, and what cannot be built."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from engine.maps import Roundabout, map_content, map_from
from engine.road import Lane, LaneRole, Maneuver, Network, RoadError, build_network
from engine.road.linking import NOWHERE, UPSTREAM, shortest_way, windows
from engine.road.outline import outline
from engine.road.roundabout import wrong_roundabout
from engine.road.sections import faster, opposite_group, to_left, to_right
from engine.vocabulary import ManeuverType
from tests.laws import examples


@st.composite
def specs(draw: Callable) -> Roundabout:
    spec = Roundabout(
        arms=draw(st.integers(3, 8)),
        lanes=draw(st.integers(1, 3)),
        radius=draw(st.floats(12.0, 80.0)),
        corner_radius=draw(st.floats(3.0, 25.0)),
        approach=draw(st.floats(10.0, 120.0)),
        lane_width=draw(st.floats(2.5, 4.5)),
        left_hand=draw(st.booleans()),
    )
    assume(not list(wrong_roundabout(spec)))
    return spec


# Each is a network to build.
def of_any_roundabout(test: Callable[[Roundabout], None]) -> Callable[[], None]:
    return examples(40)(given(specs())(test))


def entries(network: Network) -> list[Maneuver]:
    return [each for each in network.maneuvers if each.start_lane.role is LaneRole.INCOMING]


@of_any_roundabout
def test_lanes_go_on_in_one_another(spec: Roundabout) -> None:
    """Of an arm into the ring, past other arms or out by them; out where one came in goes all the way round."""
    network = build_network(spec)
    assert len(network.intersections) == spec.arms == spec.intersections
    assert len(network.maneuvers) == 3 * spec.arms * spec.lanes
    for lane in network.lanes:
        ways = {LaneRole.INCOMING: 1, LaneRole.LINK: 2, LaneRole.OUTGOING: 0, LaneRole.CONNECTING: 1}
        assert len(lane.successors) == ways[lane.role]
        assert all(network.paths.continues(lane.path, after.path) for after in lane.successors)
        assert all(lane in after.predecessors for after in lane.successors)
    for start in (lane for lane in network.lanes if lane.role is LaneRole.INCOMING):
        for end in (lane for lane in network.lanes if lane.role is LaneRole.OUTGOING):
            way = shortest_way(start, end)
            assert bool(way) == (start.number == end.number)
            passed = [lane for lane in way if ".ring." in lane.name]
            if way:
                round_it = (int(end.road[3:]) - int(start.road[3:])) * (1 if spec.left_hand else -1) % spec.arms
                assert len(passed) == (round_it or spec.arms) - 1


@of_any_roundabout
def test_traffic_runs_round_the_island_on_its_side(spec: Roundabout) -> None:
    """Anticlockwise where it keeps right; every ring lane at its distance from the kerb."""
    network = build_network(spec)
    for lane in network.lanes:
        if lane.road.startswith("ring") or ".ring." in lane.name:
            x, y, heading = network.paths.pose(lane.path, 0.5 * lane.length)
            assert math.hypot(x, y) == pytest.approx(spec.radius - (lane.number - 0.5) * spec.lane_width)
            turning = x * math.sin(heading) - y * math.cos(heading)
            assert (turning > 0.0) is not spec.left_hand
    (arm,) = (road for road in network.roads if road.name == "arm1")
    x, y, heading = network.paths.pose(arm.forward.lanes[0].path, 0.0)
    assert math.sin(heading) == pytest.approx(-1.0)
    assert (x < 0.0) is not spec.left_hand


@of_any_roundabout
def test_surfaces_add_up(spec: Roundabout) -> None:
    """The road is its intersections and the lanes between them; its boundary is closed; lanes lie in it."""
    network = build_network(spec)
    regions, edges = network.regions, network.regions.shape(0).edges
    parts = [each.region for each in network.intersections]
    parts += [lane.region for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
    assert sum(map(regions.area, parts)) == pytest.approx(regions.area(0), rel=2e-3)
    ends = Counter(map(tuple, np.round(np.vstack([edges[:, :2], edges[:, 2:]]), 6).tolist()))
    assert all(count == 2 for count in ends.values())
    for lane in network.lanes:
        for share in (0.02, 0.5, 0.98):
            x, y, _ = network.paths.pose(lane.path, share * lane.length)
            assert regions.contains(0, x, y)
            inside = lane.role is LaneRole.CONNECTING
            assert any(regions.contains(each.region, x, y) for each in network.intersections) == inside
    assert not regions.contains(0, 0.0, 0.0)


@of_any_roundabout
def test_who_comes_in_gives_way_to_the_ring(spec: Roundabout) -> None:
    """In it nobody waits but who leaves an inner lane; a way round meets as many lanes as it crosses, and its own."""
    network = build_network(spec)
    for maneuver in network.maneuvers:
        number, first = maneuver.start_lane.number, maneuver.gives_way_to
        assert set(first) <= set(maneuver.conflicting_maneuvers)
        assert all(maneuver not in other.gives_way_to for other in first)
        assert all(other.start_lane.role is LaneRole.LINK for other in first)
        if maneuver.start_lane.role is LaneRole.INCOMING:
            assert {other.start_lane.number for other in first} >= set(range(1, number + 1))
        elif maneuver.end_lane.role is LaneRole.LINK:
            assert first == ()
        else:
            assert {other.start_lane.number for other in first} == set(range(1, number))


@of_any_roundabout
def test_those_further_back_in_the_ring_are_seen(spec: Roundabout) -> None:
    """Up to a stated way; nobody on an arm is waited for, nor who has passed."""
    network = build_network(spec)
    for entry in entries(network):
        seen = windows(entry)
        before = [lane for lane in network.lanes if seen[lane.id] is not NOWHERE]
        assert all(lane.role in (LaneRole.LINK, LaneRole.CONNECTING) for lane in before)
        coming = [lane for lane in before if lane.role is LaneRole.LINK and entry.end_lane in reached(lane)]
        assert coming
        for lane in coming:
            for further in lane.predecessors:
                ahead = seen[lane.id].enter
                assert (seen[further.id] is NOWHERE) <= (ahead >= UPSTREAM or further.number != lane.number)


def reached(lane: Lane) -> set[Lane]:
    return {end for after in lane.successors for end in after.successors}


@of_any_roundabout
def test_it_is_drawn_whole(spec: Roundabout) -> None:
    """Lines to wait at lie across the arms alone, and kerbs round island and corners."""
    network = build_network(spec)
    drawn = outline(network)
    assert len(drawn.stop_lines) == spec.arms * spec.lanes
    assert len(drawn.middle_lines) == spec.arms
    assert len(drawn.kerbs) == 7 * spec.arms
    assert drawn.reach == pytest.approx(spec.lanes * spec.lane_width)
    points = np.vstack(drawn.kerbs)
    assert np.hypot(*points.T).min() == pytest.approx(spec.radius - drawn.reach)


@pytest.mark.parametrize("left_hand", [False, True])
def test_neighbours(left_hand: bool) -> None:
    """Faster lanes of the ring lie towards the island, and nothing comes the other way there."""
    network = build_network(Roundabout(lanes=2, radius=30.0, left_hand=left_hand))
    outer, inner = network.road_named["ring1"].forward.lanes
    inwards, outwards = (to_right, to_left) if left_hand else (to_left, to_right)
    assert faster(outer) is inwards(outer) is inner
    assert outwards(inner) is outer
    assert inwards(inner) is None
    assert opposite_group(inner) is None
    kinds = {each.type for each in entries(network)}
    assert kinds == {ManeuverType.LEFT_TURN if left_hand else ManeuverType.RIGHT_TURN}


@of_any_roundabout
def test_specifications_survive_json(spec: Roundabout) -> None:
    """Whoever saves a program can make its road again."""
    assert map_from(map_content(spec)) == spec


@pytest.mark.parametrize(
    ("spec", "argument"),
    [
        (Roundabout(arms=2), "arms"),
        (Roundabout(arms=9), "arms"),
        (Roundabout(lanes=5), "lanes"),
        (Roundabout(radius=2.0), "radius"),
        (Roundabout(radius=math.nan), "radius"),
        (Roundabout(radius=math.inf), "radius"),
        (Roundabout(corner_radius=0.0), "corner_radius"),
        (Roundabout(approach=-5.0), "approach"),
        (Roundabout(lane_width=0.5), "lane_width"),
        (Roundabout(radius=8.0, lanes=2), "radius"),
        (Roundabout(arms=8, lanes=2), "radius"),
        (Roundabout(arms=8, lanes=4, lane_width=20.0, corner_radius=100.0), "radius"),
    ],
)
def test_what_cannot_be_built(spec: Roundabout, argument: str) -> None:
    """The message names what must change; the radius that it tells is enough, and one less is not."""
    with pytest.raises(RoadError) as caught:
        build_network(spec)
    assert caught.value.argument == argument
    assert caught.value.cure
    if (told := caught.value.cure.removeprefix("write `radius=").split(" m`")[0]).isdigit():
        assert not list(wrong_roundabout(replace(spec, radius=float(told))))
        assert list(wrong_roundabout(replace(spec, radius=float(told) - 1.0)))
