"""Laws of regions: areas, containment, the road against its parts."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.maps import RoadSpec
from engine.road import LaneRole, build_network, regions, road_tables
from engine.road.junction import Junction
from engine.road.outline import outline
from engine.tables import ROAD_REGION
from tests.laws import examples

few = examples(15)


@st.composite
def specs(draw: Callable) -> RoadSpec:
    return RoadSpec(
        ways=draw(st.sampled_from([3, 4])),
        lanes=draw(st.integers(1, 4)),
        corner_radius=draw(st.sampled_from([0.0, 2.0, 6.0, 12.0])),
        approach=draw(st.floats(5.0, 20.0)),
        rows=draw(st.integers(1, 2)),
        cols=draw(st.integers(1, 2)),
        left_hand=draw(st.booleans()),
    )


def junction_area(spec: RoadSpec) -> float:
    """The square between the stop lines, less the corners (on a T: less its northern strip, two corners)."""
    stop, half, radius = Junction(spec).stop, spec.lanes * spec.lane_width, spec.corner_radius
    corners = (4 if spec.ways == 4 else 2) * math.pi / 4 * radius**2
    north = 0.0 if spec.ways == 4 else 2 * stop * (stop - half)
    return 4 * stop**2 - north - corners


@given(st.lists(st.tuples(st.floats(0.5, 1.0), st.floats(0.3, 1.7)), min_size=4, max_size=30))
def test_triangles_tile_a_star_shaped_polygon(rays: list[tuple[float, float]]) -> None:
    """Ear clipping leaves no gap and no overlap: all triangles anticlockwise, and their areas add up."""
    angles = np.cumsum([step for step, _ in rays])
    angles *= 2 * math.pi / angles[-1]  # no gap as wide as half a turn: the ring is simple
    radii = np.array([radius for _, radius in rays])
    ring = regions.anticlockwise(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]))
    triangles = regions.triangulate(ring)
    areas = np.array([regions.area(triangle.reshape(3, 2)) for triangle in triangles])
    assert len(triangles) == len(ring) - 2
    assert areas.sum() == pytest.approx(regions.area(ring), rel=1e-9)
    assert (areas > -1e-12).all()


@given(st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=3, max_size=40, unique=True))
def test_convex_hull_holds_every_point(points: list[tuple[float, float]]) -> None:
    """No point lies right of any edge of the hull."""
    cloud = np.array(points)
    hull = regions.convex_hull(cloud)
    for x1, y1, x2, y2 in regions.ring_edges(hull):
        right = (cloud[:, 0] - x1) * (y2 - y1) - (cloud[:, 1] - y1) * (x2 - x1)
        assert (right <= 1e-9 * (1.0 + math.hypot(x2 - x1, y2 - y1))).all()


@few
@given(specs())
def test_areas_are_those_of_the_drawing(spec: RoadSpec) -> None:
    """Tiles of a junction add up to square less fillets, up to the chords; those of the road to all its parts."""
    network = build_network(spec)
    regions = network.regions
    for intersection in network.intersections:
        assert regions.area(intersection.region) == pytest.approx(junction_area(spec), abs=0.6)
        assert regions.area(intersection.region) >= junction_area(spec) - 1e-6
    roads = sum(
        regions.area(lane.region) for lane in network.lanes if lane.role is not LaneRole.CONNECTING
    )  # each lane's strip lies beside the others
    junctions = sum(regions.area(intersection.region) for intersection in network.intersections)
    assert regions.area(ROAD_REGION) == pytest.approx(roads + junctions)
    assert road_tables(network).triangles[:, 0].max() == 1.0


@few
@given(specs(), st.integers(0, 2**32 - 1))
def test_road_is_what_lies_in_a_lane_or_junction(spec: RoadSpec, seed: int) -> None:
    """Containment in region 0, from its boundary alone, agrees with its parts; and with distance 0."""
    network = build_network(spec)
    regions = network.regions
    parts = [place.region for place in network.intersections]
    parts += [lane.region for lane in network.lanes if lane.role is not LaneRole.CONNECTING]
    edges = regions.shape(ROAD_REGION).edges
    low, high = edges[:, :2].min() - 2.0, edges[:, :2].max() + 2.0
    for x, y in np.random.default_rng(seed).uniform(low, high, (60, 2)):
        inside = regions.contains(ROAD_REGION, x, y)
        assert inside == any(regions.contains(part, x, y) for part in parts)
        assert inside == (regions.distance(ROAD_REGION, x, y) == 0.0)


@few
@given(specs())
def test_lane_strips_lie_in_the_road(spec: RoadSpec) -> None:
    """Every corner of every strip, up to the centimetre that chords may leave the fillets."""
    network = build_network(spec)
    for lane in network.lanes:
        for x, y in network.regions.shape(lane.region).edges[:, :2]:
            assert network.regions.distance(ROAD_REGION, x, y) <= 0.0101


@few
@given(specs())
def test_cores_lie_in_their_region(spec: RoadSpec) -> None:
    """The quick yes is never wrong: just inside its corners and along its middle a core is region."""
    network = build_network(spec)
    for region in range(len(network.regions)):
        for x1, y1, x2, y2 in network.regions.shape(region).cores:
            for u in (1e-6, 0.27, 0.61, 1 - 1e-6):
                for v in (1e-6, 0.27, 0.61, 1 - 1e-6):
                    assert network.regions.contains(region, x1 + u * (x2 - x1), y1 + v * (y2 - y1))


@few
@given(specs())
def test_boundary_of_the_road_is_closed(spec: RoadSpec) -> None:
    """Every corner of the boundary belongs to an even number of edges."""
    edges = build_network(spec).regions.shape(ROAD_REGION).edges
    corners, counts = np.unique(np.round(edges.reshape(-1, 2), 6) + 0.0, axis=0, return_counts=True)
    assert len(corners) > 4
    assert (counts % 2 == 0).all()


@few
@given(specs())
def test_outline_draws_the_edge_of_the_road(spec: RoadSpec) -> None:
    """Kerbs lie on the boundary of the road; stop lines and markings inside; one centre line a lane."""
    network = build_network(spec)
    drawing = outline(network)
    x1, y1, x2, y2 = network.regions.shape(ROAD_REGION).edges.T

    def off_boundary(x: float, y: float) -> float:
        along = ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / ((x2 - x1) ** 2 + (y2 - y1) ** 2)
        along = np.clip(along, 0.0, 1.0)
        return float(np.hypot(x1 + along * (x2 - x1) - x, y1 + along * (y2 - y1) - y).min())

    assert max(off_boundary(x, y) for kerb in drawing.kerbs for x, y in kerb) < 1e-9
    for line in (*drawing.stop_lines, *drawing.lane_lines, *drawing.middle_lines):
        assert network.regions.distance(ROAD_REGION, *line.mean(axis=0)) < 1e-9
    assert len(drawing.center_lines) == len(network.lanes)
    assert len(drawing.stop_lines) == sum(len(place.incoming_lanes) for place in network.intersections)
    ends = spec.rows * spec.cols * (4 if spec.ways == 4 else 3)
    shared = sum(leg.neighbour is not None for place in network.intersections for leg in place.legs) // 2
    assert len(drawing.middle_lines) == ends - shared
