"""The compiled region functions against brute force, and the statistics of uniform sampling."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.geometry import Box
from engine.kernels.nearest_lane import lane_nearest
from engine.kernels.path import path_pose
from engine.kernels.region import (
    region_box_distance,
    region_contains,
    region_contains_box,
    region_depth,
    region_distance,
    region_sample,
)
from engine.maps import RoadSpec
from engine.program import ParamSpace, Settings, program_digest
from engine.road import LaneRole, Network, build_network, road_tables
from engine.road.opendrive.network import map_file
from engine.tables import ROAD_REGION, CodeTables, RoadTables
from tests.laws import examples

VILLAGE = Path(__file__).parents[3] / "examples" / "roads" / "village.xodr"

PLACES: list[tuple[Network, RoadTables]] = [
    (network, road_tables(network))
    for network in map(
        build_network, [RoadSpec(approach=20.0), RoadSpec(ways=3, lanes=2, cols=2, block=60.0, approach=20.0)]
    )
]
"""The first call compiles."""
places = st.sampled_from([0, 1])
"""Indices into `PLACES`."""
coordinates = st.floats(-35.0, 90.0)


@given(places, st.data(), coordinates, coordinates)
def test_containment_and_distance_are_those_of_the_book(place: int, data: st.DataObject, x: float, y: float) -> None:
    """The cores and the hull are shortcuts: the answer is that of the whole boundary."""
    network, road = PLACES[place]
    x, y = x + 1.2345e-7, y + 2.3456e-7  # round numbers lie on a rim, where either answer is right
    region = data.draw(st.integers(0, len(network.regions) - 1))
    assert region_contains(road, region, x, y) == network.regions.contains(region, x, y)
    assert region_distance(road, region, x, y) == pytest.approx(network.regions.distance(region, x, y), abs=1e-9)


@pytest.mark.parametrize("place", [0, 1])
def test_hull_is_a_shortcut_only_where_it_is_the_region(place: int) -> None:
    """All around junctions and turns, whose hulls bridge fillets and inner bends, distances are those to every edge."""
    network, road = PLACES[place]
    turns = [lane.region for lane in network.lanes if lane.role is LaneRole.CONNECTING]
    for region in [intersection.region for intersection in network.intersections] + turns[:6]:
        centre = network.regions.shape(region).edges[:, :2].mean(axis=0)
        for x, y in centre + np.random.default_rng(region).uniform(-20.0, 20.0, (120, 2)):
            assert region_distance(road, region, x, y) == pytest.approx(
                network.regions.distance(region, x, y), abs=1e-9
            )


@given(places, st.data(), st.floats(0.01, 19.9), st.floats(-1.7, 1.7))
def test_distance_in_an_approach_is_that_to_the_stop_line(
    place: int, data: st.DataObject, gap: float, offset: float
) -> None:
    """A point of an incoming lane is as far from the junction as from the lane's end, to rounding."""
    network, road = PLACES[place]
    lane = data.draw(st.sampled_from([lane for lane in network.lanes if lane.role is LaneRole.INCOMING]))
    intersection = lane.intersection
    assert intersection is not None
    x, y, heading = network.paths.pose(lane.path, lane.length - gap)
    x, y = x - offset * math.sin(heading), y + offset * math.cos(heading)
    assert region_distance(road, intersection.region, x, y) == pytest.approx(gap, abs=1e-9)


@given(places, coordinates, coordinates, st.floats(-4.0, 4.0), st.floats(0.5, 9.0), st.floats(0.3, 3.0))
def test_outline_is_inside_when_all_its_points_are(
    place: int, x: float, y: float, heading: float, length: float, width: float
) -> None:
    """Against a fine grid of points of the box; where only its very rim decides, either answer may stand."""
    network, road = PLACES[place]
    along, across = np.meshgrid(np.linspace(-0.5, 0.5, 33), np.linspace(-0.5, 0.5, 33))

    def all_inside(scale: float) -> bool:
        a, b = scale * length * along, scale * width * across
        xs = x + a * math.cos(heading) - b * math.sin(heading)
        ys = y + a * math.sin(heading) + b * math.cos(heading)
        return all(network.regions.contains(ROAD_REGION, px, py) for px, py in zip(xs.flat, ys.flat, strict=True))

    inside = region_contains_box(road, ROAD_REGION, Box(x, y, heading, length, width))
    if inside:
        assert all_inside(1.0 - 1e-9)
    elif all_inside(1.02):
        # Two boxes a kerb corner can reach into between the points of the grid would be found at a finer one.
        assert not all_inside(1.0 + 2.0 / 33)


@given(
    st.sampled_from([0, 1, 2, 3]), st.floats(-3.5, 3.5), st.floats(-4.0, 4.0), st.floats(0.5, 6.0), st.floats(0.3, 3)
)
def test_outline_in_an_arm_is_inside_when_it_reaches_neither_kerb(
    arm: int, offset: float, heading: float, length: float, width: float
) -> None:
    """Between the kerbs 3.5 m from the road's middle the law is exact, at whatever angle the box stands."""
    network, road = PLACES[0]
    out = network.intersections[0].legs[arm].heading
    x, y = 19.5 * math.cos(out) - offset * math.sin(out), 19.5 * math.sin(out) + offset * math.cos(out)
    turn = heading - out
    room = 3.5 - abs(offset) - 0.5 * (length * abs(math.sin(turn)) + width * abs(math.cos(turn)))
    if abs(room) > 1e-9:
        assert region_contains_box(road, ROAD_REGION, Box(x, y, heading, length, width)) == (room > 0.0)


@given(places, st.floats(0.0, 1.0), st.data())
def test_a_car_in_its_lane_is_inside_the_road(place: int, share: float, data: st.DataObject) -> None:
    """A 4.5 m x 1.8 m car anywhere along any straight lane, clear of the road's ends."""
    network, road = PLACES[place]
    lane = data.draw(st.sampled_from([lane for lane in network.lanes if lane.length > 10.0]))
    x, y, heading = path_pose(road, lane.path, 2.5 + share * (lane.length - 5.0))
    assert region_contains_box(road, ROAD_REGION, Box(x, y, heading, 4.5, 1.8))


@given(places, st.data(), st.floats(0.0, 1.0, exclude_max=True), st.floats(0.0, 1.0, exclude_max=True))
def test_samples_lie_in_their_region(place: int, data: st.DataObject, u1: float, u2: float) -> None:
    """Up to rounding at the rim."""
    network, road = PLACES[place]
    region = data.draw(st.integers(0, len(network.regions) - 1))
    x, y = region_sample(road, region, u1, u2)
    assert network.regions.distance(region, x, y) < 1e-9


def test_samples_are_uniform_over_the_road() -> None:
    """Chi-square of 40,000 samples over unequal parts: junction, and each lane strip in three pieces."""
    network, road = PLACES[0]
    numbers = np.random.default_rng(7).random((40_000, 2))
    points = np.array([region_sample(road, ROAD_REGION, u1, u2) for u1, u2 in numbers])
    shares, counts = [], []
    for lane in network.lanes:
        if lane.role is LaneRole.CONNECTING:
            continue
        x1, y1, x2, y2 = network.regions.shape(lane.region).cores[0]
        longer = 0 if x2 - x1 > y2 - y1 else 1
        inside = (points[:, 0] >= x1) & (points[:, 0] < x2) & (points[:, 1] >= y1) & (points[:, 1] < y2)
        pieces = np.histogram(points[inside, longer], bins=3, range=((x1, x2), (y1, y2))[longer])[0]
        counts += list(pieces)
        shares += [network.regions.area(lane.region) / 3] * 3
    counts.append(len(points) - sum(counts))
    shares.append(network.regions.area(network.intersections[0].region))
    expected = np.array(shares) / sum(shares) * len(points)
    chi_square = float(((np.array(counts) - expected) ** 2 / expected).sum())
    # 24 degrees of freedom: mean 24, standard deviation 6.9; 51 is the 0.1 % point.
    assert chi_square < 51.0


def test_samples_are_uniform_inside_a_triangle_fan() -> None:
    """A junction has many triangles of unequal size: each quadrant gets a quarter, each with its mean radius."""
    network, road = PLACES[0]
    region = network.intersections[0].region
    numbers = np.random.default_rng(3).random((20_000, 2))
    points = np.array([region_sample(road, region, u1, u2) for u1, u2 in numbers])
    quadrants = np.bincount(2 * (points[:, 0] > 0) + (points[:, 1] > 0), minlength=4) / len(points)
    assert quadrants == pytest.approx(np.full(4, 0.25), abs=0.012)
    assert points.mean(axis=0) == pytest.approx(np.zeros(2), abs=0.15)


@given(places, st.floats(0.05, 0.95), st.floats(-1.0, 1.0), st.floats(-0.3, 0.3), st.data())
def test_nearest_lane_with_a_heading_is_the_lane_one_is_in(
    place: int, share: float, offset: float, error: float, data: st.DataObject
) -> None:
    """On a road between the junctions; without a heading too, as lanes do not overlap there."""
    network, road = PLACES[place]
    lane = data.draw(st.sampled_from([lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING]))
    x, y, heading = path_pose(road, lane.path, share * lane.length)
    x, y = x - offset * math.sin(heading), y + offset * math.cos(heading)
    assert lane_nearest(road, x, y, heading + error) == lane.id
    assert lane_nearest(road, x, y, math.nan) == lane.id


def test_heading_decides_where_lanes_cross() -> None:
    """In the middle of the junction a car that drives north is in a lane that leads north."""
    network, road = PLACES[0]
    for heading in (0.0, math.pi / 2, math.pi, -math.pi / 2):
        lane = network.lanes[lane_nearest(road, 0.0, 0.0, heading)]
        pose = network.paths.pose(lane.path, network.paths.project(lane.path, 0.0, 0.0))
        assert math.cos(pose.heading - heading) > 0.7


def grid(box: Box, count: int = 25) -> np.ndarray:
    """Points all over an outline, its rim and corners among them (n, 2)."""
    along, across = (
        a.ravel() for a in np.meshgrid(*(size * np.linspace(-0.5, 0.5, count) for size in (box.length, box.width)))
    )
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    return np.column_stack([box.x + along * cos - across * sin, box.y + along * sin + across * cos])


@examples(60)
@given(
    places,
    st.data(),
    coordinates,
    coordinates,
    st.floats(-3.2, 3.2),
    st.sampled_from([(4.5, 1.8), (12.0, 2.5), (0.0, 0.0), (90.0, 90.0)]),
)
def test_distance_of_an_outline_is_that_of_its_nearest_point(
    place: int, data: st.DataObject, x: float, y: float, heading: float, size: tuple[float, float]
) -> None:
    """By points all over the outline: none is nearer, and one is nearly as near. One outline holds whole regions."""
    network, road = PLACES[place]
    region = data.draw(st.integers(0, len(network.regions) - 1))
    box = Box(x, y, heading, *size)
    distance = region_box_distance(road, region, box)
    nearest = min(region_distance(road, region, px, py) for px, py in grid(box))
    spacing = math.hypot(*size) / 24.0
    assert distance - 1e-9 <= nearest <= distance + spacing + 1e-9


def test_outline_that_is_crossed_by_a_lane_touches_it() -> None:
    """No corner and no centre of the one lies in the other, yet they overlap."""
    network, road = PLACES[0]
    lane = next(lane for lane in network.lanes if lane.name == "south.in.1")
    pose = network.paths.pose(lane.path, 8.0)
    across = Box(pose.x + 2.5, pose.y, 0.0, 12.0, 2.0)
    assert not network.regions.contains(lane.region, across.x, across.y)
    assert region_box_distance(road, lane.region, across) == 0.0
    beside = Box(pose.x + 2.5, pose.y, math.pi / 2, 4.0, 1.0)
    assert region_box_distance(road, lane.region, beside) == pytest.approx(2.5 - 0.5 - 0.5 * lane.width)


MANY_EDGES = [
    build_network(RoadSpec(rows=2, cols=2, lanes=2, approach=20.0, block=60.0)),
    build_network(map_file(VILLAGE, "village.xodr")),
]


@given(st.sampled_from([0, 1]), st.floats(-1.1, 1.1), st.floats(-1.1, 1.1), st.integers(0, 10**6), st.floats(-4.0, 4.0))
def test_cells_of_edges_answer_as_all_edges_do(which: int, u: float, v: float, edge: int, heading: float) -> None:
    """For points everywhere, and for such as lie as high as a corner; for outlines, too."""
    network = MANY_EDGES[which]
    road = road_tables(network)
    bare = road._replace(cell_start=np.zeros(1, dtype=np.int32))
    assert len(road.cell_start) > 1
    ends = road.edges[: road.region_start[1]].reshape(-1, 2)
    (west, south), (east, north) = ends.min(axis=0), ends.max(axis=0)
    x, y = 0.5 * (west + east) + 0.5 * u * (east - west), 0.5 * (south + north) + 0.5 * v * (north - south)
    corner = ends[edge % len(ends)]
    for place in ((x, y), (x, float(corner[1])), (float(corner[0]) + u, float(corner[1]) + v)):
        if abs(region_depth(bare, ROAD_REGION, *place)) > 1e-9:  # on the rim either answer is right
            assert region_contains(road, ROAD_REGION, *place) == region_contains(bare, ROAD_REGION, *place)
        boxes = [region_contains_box(each, ROAD_REGION, Box(*place, heading, 4.5, 1.8)) for each in (road, bare)]
        assert boxes[0] == boxes[1]
    for place in ((math.nan, y), (x, math.nan), (math.inf, y), (x, -math.inf)):
        assert not region_contains(road, ROAD_REGION, *place)


def test_an_index_decides_nothing() -> None:
    """A program with cells has the digest of one without."""
    road = road_tables(MANY_EDGES[0])
    none, whole = np.zeros(0), np.zeros(0, dtype=np.int32)
    space = ParamSpace((), (), whole, none, none, whole, np.zeros((0, 2)), none, (), ())
    bare = road._replace(cell_edges=np.zeros((0, 4)))
    code = CodeTables._make(np.zeros(1) for _ in CodeTables._fields)
    one, other = (program_digest(space, code, each, Settings()) for each in (road, bare))
    assert one == other
