"""The compiled path functions against their Python form in `engine.road.paths`, and the follower's local search."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.path import (
    path_curvature,
    path_distance,
    path_pose,
    path_project,
    path_project_near,
    speed_limit_ahead,
)
from engine.maps import RoadSpec
from engine.road import Network, Primitive, build_network, road_tables
from engine.tables import RoadTables


def city() -> tuple[Network, RoadTables, list[int]]:
    """A grid with all routes of its maneuvers, and one path of its own that turns both ways."""
    network = build_network(RoadSpec(rows=1, cols=2, lanes=2))
    routes = [network.paths.join([lane.path for lane in maneuver.lanes]) for maneuver in network.maneuvers]
    chain = [Primitive(-5.0, 3.0, 0.3, 0.0, 12.0)]
    for curvature, length in ((0.1, 9.0), (-0.05, 20.0), (0.0, 4.0), (-0.2, 5.0)):
        chain.append(Primitive(*chain[-1].pose(chain[-1].length), curvature, length))
    routes.append(network.paths.add(chain))
    return network, road_tables(network), routes


NETWORK, ROAD, ROUTES = city()
"""The first call compiles."""
routes = st.sampled_from(ROUTES)
shares = st.floats(0.0, 1.0)
near = st.floats(-80.0, 180.0)


@given(routes, st.floats(-0.2, 1.2))
def test_pose_and_curvature_are_those_of_the_book(path: int, share: float) -> None:
    """Also before the start and past the end, where both stay at the end."""
    s = share * NETWORK.paths.length(path)
    assert path_pose(ROAD, path, s) == pytest.approx(NETWORK.paths.pose(path, s), abs=1e-12)
    assert path_curvature(ROAD, path, s) == NETWORK.paths.curvature(path, s)


@given(routes, near, near)
def test_projection_is_that_of_the_book(path: int, x: float, y: float) -> None:
    """Distances agree; so do arc lengths, unless two places are equally near."""
    distance = path_distance(ROAD, path, x, y)
    assert distance == pytest.approx(NETWORK.paths.distance(path, x, y), abs=1e-9)
    foot_x, foot_y, _ = path_pose(ROAD, path, path_project(ROAD, path, x, y))
    assert distance == pytest.approx(math.hypot(foot_x - x, foot_y - y), abs=1e-9)


@given(routes, shares)
def test_project_undoes_pose(path: int, share: float) -> None:
    """No route of a grid crosses itself, so the arc length comes back."""
    s = share * NETWORK.paths.length(path)
    x, y, _ = path_pose(ROAD, path, s)
    assert path_project(ROAD, path, x, y) == pytest.approx(s, abs=1e-6)


@given(routes, shares, st.floats(-1.6, 1.6), st.floats(-3.0, 3.0))
def test_local_projection_finds_the_offset_point(path: int, share: float, offset: float, error: float) -> None:
    """From a guess some metres off, a point beside the path is found with its signed offset and its heading."""
    s = share * NETWORK.paths.length(path)
    x, y, heading = path_pose(ROAD, path, s)
    point = path_project_near(ROAD, path, x - offset * math.sin(heading), y + offset * math.cos(heading), s + error)
    assert point.s == pytest.approx(s, abs=1e-9)
    assert point.offset == pytest.approx(offset, abs=1e-9)
    assert point.heading == pytest.approx(heading, abs=1e-9)
    assert point.curvature in {primitive.curvature for primitive in NETWORK.paths.primitives(path)}


@given(routes, st.floats(0.0, 20.0), st.floats(-1.5, 1.5), st.booleans())
def test_local_projection_stops_at_the_ends(path: int, beyond: float, offset: float, at_end: bool) -> None:
    """Beyond an end the arc length is the end's and the offset that from the end's tangent."""
    length = NETWORK.paths.length(path)
    s, ahead = (length, beyond) if at_end else (0.0, -beyond)
    if not at_end and path == ROUTES[-1]:
        return  # starts with a line of its own; the law is about straight ends
    x, y, heading = path_pose(ROAD, path, s)
    cos, sin = math.cos(heading), math.sin(heading)
    if path == ROUTES[-1]:
        ahead = min(ahead, 2.0)  # ends in an arc: its circle turns away farther on
    x, y = x + ahead * cos - offset * sin, y + ahead * sin + offset * cos
    point = path_project_near(ROAD, path, x, y, s)
    assert point.s == pytest.approx(s, abs=1e-9)
    assert point.offset == pytest.approx(offset, abs=1e-9)


def test_local_projection_ends_where_two_primitives_meet() -> None:
    """Exactly on a joint, with a guess on either side, the search ends and agrees."""
    for path in ROUTES:
        for s in NETWORK.paths.starts(path)[1:-1]:
            x, y, _ = path_pose(ROAD, path, s)
            for guess in (s - 1e-9, s, s + 1e-9):
                assert path_project_near(ROAD, path, x, y, guess).s == pytest.approx(s, abs=1e-9)


def test_local_projection_goes_on_to_the_neighbour_primitive() -> None:
    """A metre before or behind a joint, guessed on its other side."""
    for path in ROUTES:
        for joint in NETWORK.paths.starts(path)[1:-1]:
            for step in (-1.0, 1.0):
                x, y, _ = path_pose(ROAD, path, joint + step)
                assert path_project_near(ROAD, path, x, y, joint - step).s == pytest.approx(joint + step, abs=1e-9)


@given(routes, shares, st.floats(0.5, 8.0), st.floats(0.5, 8.0))
def test_speed_limit_lets_every_curve_be_met(path: int, share: float, lateral: float, deceleration: float) -> None:
    """Braking from it as planned, the lateral acceleration never exceeds its limit; and at one place it reaches it."""
    length = NETWORK.paths.length(path)
    s = share * length
    limit = speed_limit_ahead(ROAD, path, s, lateral, deceleration)
    places = np.unique(np.concatenate([np.linspace(s, length, 50), [v for v in NETWORK.paths.starts(path) if v >= s]]))
    bends = np.array([abs(NETWORK.paths.curvature(path, place)) for place in places])
    if not bends.any():
        assert limit == math.inf
        return
    squared = limit**2 - 2.0 * deceleration * (places - s)
    assert (squared * bends).max() == pytest.approx(lateral, rel=1e-9)
