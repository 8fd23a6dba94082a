"""Pictures turn so that the ego's road lies along them, and crop to everybody's tracks."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.report.findings.framing import (
    BAND,
    BAR,
    BARS,
    CARD,
    LEAST_HEIGHT,
    MARGIN,
    STAGES,
    Frame,
    alike,
    heading_of_road,
    tracks,
)
from engine.maps import RoadSpec
from engine.road import build_network
from engine.road.network import LaneRole
from engine.road.outline import outline
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State

PLACES = st.lists(st.tuples(st.floats(-400, 400), st.floats(-400, 400)), min_size=1, max_size=30)
HEADINGS = st.floats(-math.pi, math.pi)


def driven(poses: Floats, outlines: Floats) -> Trajectory:
    """Poses (samples, actors, 3); NaN for who is not there."""
    states = np.zeros((*poses.shape[:2], len(State)))
    states[..., [State.X, State.Y, State.HEADING]] = np.nan_to_num(poses)
    states[..., State.PRESENT] = np.isfinite(poses).all(axis=-1)
    return Trajectory(0.05 * np.arange(float(len(poses))), states, outlines, -1)


def turned(points: Floats, angle: float) -> Floats:
    cos, sin = math.cos(angle), math.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


@given(PLACES, HEADINGS, st.sampled_from([None, CARD, BAND]))
def test_everything_is_shown_with_a_margin(places: list[tuple[float, float]], heading: float, shape: float | None):
    """No point is nearer to the border than the margin, and one is as near as that unless the frame is the least."""
    points = np.array(places)
    frame = Frame.around(points, heading, shape)
    shown = frame.turned(points) - (frame.left, frame.bottom)
    room = np.minimum(shown, np.array([frame.width, frame.height]) - shown)
    assert room.min() >= MARGIN - 1e-9
    assert frame.height == pytest.approx(LEAST_HEIGHT) or room.min() == pytest.approx(MARGIN)
    assert min(abs(frame.shape - each) for each in ([shape] if shape else STAGES)) < 1e-9


@given(PLACES, HEADINGS, HEADINGS)
def test_a_turned_world_has_the_same_picture(places: list[tuple[float, float]], heading: float, turn: float):
    """What is turned together with its road lies in the picture as before."""
    points = np.array(places)
    one, other = Frame.around(points, heading), Frame.around(turned(points, turn), heading + turn)
    assert (other.left, other.bottom) == pytest.approx((one.left, one.bottom), abs=1e-6)
    assert (other.width, other.height) == pytest.approx((one.width, one.height), abs=1e-6)
    assert other.turned(turned(points, turn)) == pytest.approx(one.turned(points), abs=1e-6)


@given(HEADINGS)
def test_the_heading_points_to_the_right_and_north_where_the_arrow_does(heading: float):
    """A step along the heading is one to the right; +y of the world lies at the arrow's angle, clockwise from up."""
    frame = Frame.around(np.zeros((1, 2)), heading)
    along = frame.turned(np.array([[math.cos(heading), math.sin(heading)]]))[0]
    assert along == pytest.approx([1.0, 0.0], abs=1e-12)
    arrow = math.radians(frame.north_degrees)
    assert frame.turned(np.array([[0.0, 1.0]]))[0] == pytest.approx([math.sin(arrow), math.cos(arrow)], abs=1e-12)


@pytest.mark.parametrize("turn", [0.0, math.pi / 2, math.pi, 0.3])
def test_a_long_road_fills_the_picture(turn: float):
    """Whichever way a road of 200 m runs, the drive takes nine tenths of the picture's width."""
    way = turned(np.column_stack([np.linspace(0.0, 200.0, 50), np.zeros(50)]), turn)
    frame = Frame.around(way, turn)
    assert frame.shape == pytest.approx(BAND)
    assert np.ptp(frame.turned(way)[:, 0]) > 0.9 * frame.width


@given(st.floats(1.0, 500.0), st.floats(1.0, 500.0))
def test_the_shape_is_the_one_in_which_a_metre_is_largest(width: float, height: float):
    """No other shape would show the same points larger."""
    points = np.array([[0.0, 0.0], [width, height]])
    chosen = Frame.around(points)
    for shape in STAGES:
        assert chosen.pixel <= Frame.around(points, shape=shape).pixel + 1e-9 or chosen.height == LEAST_HEIGHT


@given(st.floats(1.0, 5000.0), HEADINGS)
def test_the_bar_is_round_and_fits(length: float, heading: float):
    """It is one of the round lengths, and the next one would be too long."""
    frame = Frame.around(np.array([[0.0, 0.0], [length, 0.0]]), heading)
    assert frame.bar / frame.pixel <= BAR
    assert all(longer / frame.pixel > BAR for longer in BARS if longer > frame.bar)


def test_tracks_are_all_corners_of_who_is_there():
    """A car that turns around sweeps a circle of half its diagonal; who is away leaves no track."""
    poses = np.full((90, 3, 3), np.nan)
    poses[:, 0] = np.column_stack([np.full(90, 7.0), np.full(90, -3.0), np.linspace(0.0, math.tau, 90)])
    poses[3, 1] = (40.0, 2.0, math.pi / 2)
    found = tracks(driven(poses, np.array([[4.0, 3.0], [10.0, 2.0], [1.0, 1.0]])))
    assert len(found) == 4 * 91
    around = found[np.hypot(*(found - (7.0, -3.0)).T) < 10.0]
    assert np.hypot(*(around - (7.0, -3.0)).T) == pytest.approx(np.full(4 * 90, 2.5))
    other = found[np.hypot(*(found - (7.0, -3.0)).T) > 10.0]
    assert sorted(map(tuple, np.round(other, 9).tolist())) == [(39.0, -3.0), (39.0, 7.0), (41.0, -3.0), (41.0, 7.0)]


@given(st.lists(PLACES, min_size=1, max_size=4), HEADINGS)
def test_pictures_of_several_cases_are_alike(several: list[list[tuple[float, float]]], heading: float):
    """They have one size, and each still shows all of its own."""
    frames = [Frame.around(np.array(places), heading) for places in several]
    same = alike(frames)
    assert len({(round(frame.width, 6), round(frame.height, 6)) for frame in same}) == 1
    for places, frame in zip(several, same, strict=True):
        shown = frame.turned(np.array(places)) - (frame.left, frame.bottom)
        assert (shown > MARGIN - 1e-6).all()
        assert (shown < np.array([frame.width, frame.height]) - MARGIN + 1e-6).all()


# -- the ego's road ----------------------------------------------------------------------------------------------------

SPECS = [
    RoadSpec(),
    RoadSpec(ways=3, lanes=3),
    RoadSpec(lanes=4, left_hand=True, approach=200.0),
    RoadSpec(rows=2, cols=3, lanes=2),
]


@pytest.mark.parametrize("spec", SPECS)
def test_whoever_drives_in_a_lane_drives_to_the_right(spec: RoadSpec):
    """Anywhere in any lane, facing up to 40 degrees aside: the lane's direction; facing against it, the opposite."""
    network, random = build_network(spec), np.random.default_rng(5)
    road, width = outline(network), spec.lanes * spec.lane_width
    for lane in network.lanes:
        if lane.role is LaneRole.CONNECTING:
            continue
        place = network.paths.pose(lane.path, random.uniform(0.0, lane.length))
        for against in (0.0, math.pi):
            facing = place.heading + against + random.uniform(-0.7, 0.7)
            states = driven(np.array([[[place.x, place.y, facing]]]), np.ones((1, 2))).states[:, 0]
            found = heading_of_road(road, width, states)
            assert math.cos(found - place.heading - against) == pytest.approx(1.0), lane.name


def test_a_walker_across_a_road_has_the_road_along_the_picture():
    """The road, not the way somebody faces, lies along the picture."""
    road = outline(build_network(RoadSpec(approach=80.0)))
    states = driven(np.array([[[5.5, -50.0, 0.1]]]), np.ones((1, 2))).states[:, 0]
    assert abs(math.sin(heading_of_road(road, 3.5, states))) == pytest.approx(1.0)


def test_who_comes_late_or_never_turns_the_picture_by_where_it_comes():
    """The road is that of the first sample at which there is somebody; nobody has none."""
    road = outline(build_network(RoadSpec()))
    poses = np.full((5, 1, 3), np.nan)
    assert heading_of_road(road, 3.5, driven(poses, np.ones((1, 2))).states[:, 0]) == 0.0
    poses[3:, 0] = (1.75, -30.0, math.pi / 2)
    assert heading_of_road(road, 3.5, driven(poses, np.ones((1, 2))).states[:, 0]) == pytest.approx(math.pi / 2)
