"""Laws of the strips beside the lanes: where they lie, how large they are, and what parked cars keep clear."""

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import fields, replace
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.opendrive import write_opendrive
from engine.maps import LoneRoad, MapSpec, RoadSpec, Roundabout, Street, map_content, map_from
from engine.opendrive.read import read_opendrive
from engine.road import LaneRole, Network, RoadError, build_network, road_tables
from engine.road.areas import WALKABLE, region_of_kinds, vehicle_region
from engine.road.network import Surface, SurfaceKind
from engine.road.opendrive.network import file_network, map_file
from engine.road.outline import outline
from engine.road.regions import distance
from engine.tables import ROAD_REGION
from tests.engine.road.streets import DrawnSpec, polygon, streets
from tests.laws import examples
from tests.schemas import findings

few = examples(20)
ALONG = (SurfaceKind.SIDEWALK, SurfaceKind.SHOULDER, SurfaceKind.PARKING, SurfaceKind.BIKE_LANE)
SLIVER = 0.05
"""Common area of an arc and its neighbour of other chords, both within 1 cm of the arc [m^2]."""


def of_kind(network: Network, *kinds: SurfaceKind) -> list[Surface]:
    return [each for each in network.surfaces if each.kind in kinds]


def boxes(rows: np.ndarray) -> list[shapely.Polygon]:
    """Rectangles of x, y, heading, length and width."""
    corners = np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]])
    found = []
    for x, y, heading, length, width in rows.tolist():
        turn = np.array([[math.cos(heading), math.sin(heading)], [-math.sin(heading), math.cos(heading)]])
        found.append(shapely.Polygon(corners * (length, width) @ turn + (x, y)))
    return found


@few
@given(streets())
def test_strips_lie_beside_the_lanes_and_one_another(spec: MapSpec) -> None:
    """No strip has an area in common with a lane outside the intersections, or with another strip."""
    network = build_network(spec)
    lanes = [lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
    lanes_area = shapely.union_all([polygon(network.regions.shape(lane.region)) for lane in lanes])
    areas = [(each, polygon(each.shape)) for each in of_kind(network, *ALONG)]
    for each, area in areas:
        assert area.intersection(lanes_area).area < SLIVER, each.name
    for (one, first), (other, second) in combinations(areas, 2):
        assert first.intersection(second).area < SLIVER, (one.name, other.name)


@few
@given(streets(("intersection",)))
def test_a_straight_strip_covers_its_length_times_its_width(spec: RoadSpec) -> None:
    network = build_network(spec)
    for each in of_kind(network, *ALONG, SurfaceKind.CROSSING):
        if each.kind is SurfaceKind.CROSSING or len(each.shape.triangles) == 2:
            assert each.area == pytest.approx(each.length * each.width)
    corners = [each for each in of_kind(network, SurfaceKind.SIDEWALK) if each.intersection_id is not None]
    for each in corners:  # a quarter of a ring, or the straight side of a T
        assert each.area == pytest.approx(each.length * each.width, rel=5e-3)


@few
@given(streets())
def test_roads_without_strips_keep_every_number(spec: MapSpec) -> None:
    """A sidewalk, and any use of it, changes nothing of the road; without the arguments there are kerbs only."""
    plain = replace(spec, **{each.name: each.default for each in fields(Street)})
    bare, walked = build_network(plain), build_network(replace(plain, sidewalk=2.0))
    assert {each.kind for each in bare.surfaces} == {SurfaceKind.CURB}
    assert len(walked.surfaces) > len(bare.surfaces)
    for one, other in zip(road_tables(bare), road_tables(walked), strict=True):
        assert np.array_equal(one, other)
    assert {name for name in map_content(plain) if name in {each.name for each in fields(Street)}} == set()


@few
@given(streets())
def test_a_specification_comes_back_from_its_content(spec: MapSpec) -> None:
    assert map_from(map_content(spec)) == spec


@few
@given(streets(), st.floats(0.0, 1.0))
def test_parked_cars_keep_clear(spec: DrawnSpec, share: float) -> None:
    """Of lanes, sidewalks, bicycle lanes, crossings and one another; fewer are a part of more."""
    if spec.parking is None:
        return
    network, fewer = build_network(spec), build_network(replace(spec, parked=share * spec.parked))
    cars = network.buildings[len(network.buildings) - network.parked :]
    rest = fewer.buildings[len(fewer.buildings) - fewer.parked :]
    assert {tuple(row) for row in rest.tolist()} <= {tuple(row) for row in cars.tolist()}
    others = [polygon(each.shape) for each in of_kind(network, SurfaceKind.SIDEWALK, SurfaceKind.BIKE_LANE)]
    others += [polygon(each.shape) for each in of_kind(network, SurfaceKind.CROSSING)]
    others += [polygon(network.regions.shape(lane.region)) for lane in network.lanes]
    taken, outlines = shapely.union_all(others), boxes(cars)
    assert all(each.intersection(taken).area < SLIVER for each in outlines)
    assert not any(one.intersects(other) for one, other in combinations(outlines, 2))


def test_all_places_are_taken_at_a_share_of_1_and_none_at_0() -> None:
    road = LoneRoad(length=100.0, parking=2.0)
    assert len(build_network(road).buildings) == 0
    assert len(build_network(replace(road, parked=1.0)).buildings) == 2 * 16  # places of 6 m
    across = build_network(replace(road, parked=1.0, parking=5.0))
    assert len(across.buildings) == 2 * 40  # places of 2.5 m
    assert set(np.abs(np.cos(across.buildings[:, 2])).round(9)) == {0.0}


@few
@given(streets())
def test_crossings_lead_from_sidewalk_to_sidewalk(spec: MapSpec) -> None:
    """Over the whole road, and not over the lanes at whose ends traffic waits."""
    network = build_network(spec)
    for each in of_kind(network, SurfaceKind.CROSSING):
        assert None not in each.sidewalks
        for walk, end in zip(each.sidewalks, each.ends_at, strict=True):
            assert walk is not None
            assert distance(walk.shape, end.x, end.y) < 0.02
            assert each in walk.crossings
        if each.intersection_id is not None:
            waiting = [lane for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
            area = polygon(each.shape)
            assert all(polygon(network.regions.shape(lane.region)).intersection(area).area < 1e-6 for lane in waiting)
            assert network.intersections[each.intersection_id] is each.parent


@few
@given(streets(), st.integers(0, 2**31))
def test_places_in_a_region_lie_in_an_element_of_it(spec: MapSpec, seed: int) -> None:
    """Regions of many elements have the area of all, and no border inside."""
    network, rng = build_network(spec), np.random.default_rng(seed)
    for kinds in ((SurfaceKind.SIDEWALK,), WALKABLE, (SurfaceKind.SHOULDER, SurfaceKind.PARKING)):
        found, region = of_kind(network, *kinds), region_of_kinds(network, kinds)
        assert (region is None) == (not found)
        if region is None:
            continue
        total = shapely.union_all([polygon(each.shape) for each in found]).area
        assert network.regions.area(region) == pytest.approx(total, rel=1e-5)
        triangles = network.regions.shape(region).triangles
        u, v = np.sort(rng.random((2, 50)), axis=0)
        a, b, c = triangles[rng.integers(0, len(triangles), 50)].reshape(-1, 3, 2).transpose(1, 0, 2)
        for x, y in (u[:, None] * a + (v - u)[:, None] * b + (1.0 - v)[:, None] * c).tolist():
            assert min(distance(each.shape, x, y) for each in found) < 0.02


def test_vehicles_may_start_between_the_kerbs() -> None:
    spec = RoadSpec(shoulder=1.0, parking=2.0)
    network = build_network(spec)
    region = vehicle_region(network)
    strips = sum(each.area for each in of_kind(network, SurfaceKind.SHOULDER, SurfaceKind.PARKING))
    assert network.regions.area(region) == pytest.approx(network.regions.area(ROAD_REGION) + strips, rel=1e-6)
    assert vehicle_region(build_network(RoadSpec(sidewalk=2.0))) == ROAD_REGION


# -- as OpenDRIVE ------------------------------------------------------------------------------------------------------


def areas(network: Network) -> Mapping[SurfaceKind, float]:
    found: dict[SurfaceKind, float] = defaultdict(float)
    for each in of_kind(network, *ALONG, SurfaceKind.CROSSING):
        found[each.kind] += each.area
    return found


@few
@given(spec=streets())
def test_a_street_comes_back_from_opendrive(tmp_path_factory: pytest.TempPathFactory, spec: MapSpec) -> None:
    """With all areas, crossings within 1 cm, and parked cars as walls; the document is valid by its schema."""
    path, network = tmp_path_factory.mktemp("street") / "street.xodr", build_network(spec)
    path.write_text(write_opendrive(spec, None, "street"))
    assert not findings("opendrive", "1.7", path.read_text())
    read = file_network(map_file(path, path.name))
    assert read.unread == ""
    assert areas(read) == pytest.approx(dict(areas(network)), rel=5e-3)
    crossings, known = of_kind(network, SurfaceKind.CROSSING), of_kind(read, SurfaceKind.CROSSING)
    for one in crossings:
        other = min(known, key=lambda each: shapely.hausdorff_distance(polygon(each.shape), polygon(one.shape)))
        assert shapely.hausdorff_distance(polygon(one.shape), polygon(other.shape)) < 0.01
        assert None not in (other.ends or ())
        assert (other.intersection_id is None) == (one.intersection_id is None)
    walls = read_opendrive(path).buildings
    order = [np.lexsort(rows[:, :2].round(3).T) for rows in (walls, network.buildings)]
    np.testing.assert_allclose(walls[order[0]][:, :2], network.buildings[order[1]][:, :2], atol=1e-6)


@few
@given(streets())
def test_everything_is_drawn(spec: MapSpec) -> None:
    """All strips as rings, and crossings by stripes within them."""
    network = build_network(spec)
    drawn = outline(network)
    assert len(drawn.strips) == len(of_kind(network, *ALONG))
    assert len(drawn.parked) == network.parked
    crossings = shapely.union_all([polygon(each.shape).buffer(0.5) for each in of_kind(network, SurfaceKind.CROSSING)])
    assert all(crossings.contains(shapely.Polygon(ring)) for ring in drawn.stripes)


# -- what cannot be built ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spec", "argument"),
    [
        (RoadSpec(sidewalk=0.4), "sidewalk"),
        (RoadSpec(sidewalk=math.nan), "sidewalk"),
        (RoadSpec(sidewalk=8.0, corner_radius=6.0), "sidewalk"),
        (RoadSpec(shoulder=5.1), "shoulder"),
        (RoadSpec(bike_lane=0.5), "bike_lane"),
        (RoadSpec(bike_lane=2.0, bike_lane_behind_parking=True), "bike_lane_behind_parking"),
        (RoadSpec(parking=6.0), "parking"),
        (RoadSpec(parking=2.0, parked=1.1), "parked"),
        (RoadSpec(parking=2.0, parked=math.nan), "parked"),
        (RoadSpec(parked=0.5), "parked"),
        (RoadSpec(crossings=True), "crossings"),
        (RoadSpec(sidewalk=2.0, crossings=(10.0,)), "crossings"),
        (RoadSpec(sidewalk=2.0, crossings=True, crossing_width=11.0), "crossing_width"),
        (RoadSpec(sidewalk=3.0, buildings=2.0), "buildings"),
        (LoneRoad(sidewalk=2.0, crossings=True), "crossings"),
        (LoneRoad(sidewalk=2.0, length=100.0, crossings=(99.0,)), "crossings"),
        (LoneRoad(sidewalk=2.0, length=100.0, crossings=(math.nan,)), "crossings"),
        (LoneRoad(sidewalk=2.0, length=100.0, crossings=(50.0, 52.0)), "crossings"),
        (LoneRoad(length=50.0, curve=12.0, parking=5.5), "parking"),
        (LoneRoad(length=60.0, curve=-15.0, sidewalk=9.0), "sidewalk"),
        (LoneRoad(curve=3.0, parking=2.0), "curve"),
        (Roundabout(sidewalk=2.0, crossings=True, approach=8.0), "approach"),
        (Roundabout(sidewalk=9.0, corner_radius=4.0), "sidewalk"),
        (Roundabout(radius=12.0, parking=5.5, shoulder=5.0), "radius"),
    ],
)
def test_what_does_not_fit_is_named(spec: MapSpec, argument: str) -> None:
    with pytest.raises(RoadError) as raised:
        build_network(spec)
    assert raised.value.argument == argument
    assert raised.value.cure


@pytest.mark.parametrize(
    ("spec", "argument", "fits"),
    [
        (RoadSpec(sidewalk=8.0, corner_radius=6.0), "sidewalk", 6.0),
        (LoneRoad(length=50.0, curve=12.0, parking=5.5), "parking", 3.5),
        (LoneRoad(length=60.0, curve=-14.0, sidewalk=9.0), "sidewalk", 5.5),
        (LoneRoad(sidewalk=2.0, length=100.0, crossings=(99.0,)), "crossings", (98.0,)),
    ],
)
def test_the_largest_value_that_fits_is_named(spec: MapSpec, argument: str, fits: float | tuple[float, ...]) -> None:
    """It is in the cure, fits, and no larger one does."""
    value = fits[0] if isinstance(fits, tuple) else fits
    with pytest.raises(RoadError) as raised:
        build_network(spec)
    assert f"{value:g} m" in raised.value.cure
    build_network(replace(spec, **{argument: fits}))
    with pytest.raises(RoadError):
        build_network(replace(spec, **{argument: (value + 0.11,) if isinstance(fits, tuple) else value + 0.11}))
