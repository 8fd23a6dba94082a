"""Roads as OpenDRIVE lie where ours do."""

import cmath
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import fresnel

from engine.interchange import InterchangeError
from engine.interchange.opendrive import road_map, write_opendrive
from engine.maps import RoadSpec
from engine.opendrive.curves import CURVES, Pose, arc, clothoid, read_piece
from engine.opendrive.read import read_opendrive
from engine.road import LaneRole
from engine.road.opendrive.network import map_file
from engine.xml import Node
from tests.engine.interchange.opendrive.reading_back import Document, number, only, specs
from tests.laws import examples

VILLAGE = Path(__file__).parents[4] / "examples" / "roads" / "village.xodr"

few = examples(25)


def written(spec: RoadSpec) -> Document:
    return Document(write_opendrive(spec, None, "road"))


@few
@given(specs())
def test_lane_centres_are_our_paths(spec: RoadSpec) -> None:
    """Every lane, evaluated as the standard says, runs along our path, with its traffic; `place` says where."""
    document, roads = written(spec), road_map(spec)
    for lane in roads.network.lanes:
        for along in np.linspace(0.0, lane.length, 7).tolist():
            pose, place = roads.network.paths.pose(lane.path, along), roads.place(lane.id, along)
            read = document.place(*place)
            assert abs(read.point - complex(pose.x, pose.y)) < 1e-9
            assert abs(math.remainder(read.heading - pose.heading, math.tau)) < 1e-9


@few
@given(specs())
def test_every_lane_is_one_of_ours(spec: RoadSpec) -> None:
    """No lane of the document is left over, none stands for two."""
    document, roads = written(spec), road_map(spec)
    ours = [(place.road, place.lane) for place in roads.places]
    assert len(set(ours)) == len(ours)
    assert set(ours) == {(road, lane) for road in document.roads for lane in document.lane_ids(road) if lane}


@few
@given(specs())
def test_reference_lines_are_continuous(spec: RoadSpec) -> None:
    """Each piece starts at the length and pose at which the one before it ends; the last ends with the road."""
    document = written(spec)
    for name, road in document.roads.items():
        pieces = road.findall("planView/geometry")
        assert number(pieces[0], "s") == 0.0
        for piece, following in pairwise(pieces):
            end = number(piece, "s") + number(piece, "length")
            assert end == number(following, "s")
            point, heading = document.reference(name, np.nextafter(end, 0.0))
            assert abs(point - complex(number(following, "x"), number(following, "y"))) < 1e-9
            assert abs(math.remainder(heading - number(following, "hdg"), math.tau)) < 1e-9
        assert abs(number(pieces[-1], "s") + number(pieces[-1], "length") - number(road, "length")) < 1e-9
        assert {shape.tag for piece in pieces for shape in piece} <= {"line", "arc"}


@few
@given(specs())
def test_lanes_meet_where_they_are_linked(spec: RoadSpec) -> None:
    """A turn begins and ends at the middle of the lanes that it links, with their headings and widths."""
    document = written(spec)
    for name, road in document.roads.items():
        if road.attrib["junction"] == "-1":
            continue
        (lane,) = (lane for lane in document.lane_ids(name) if lane)
        for end, s in (("predecessor", 0.0), ("successor", number(road, "length"))):
            other, neighbour = (
                only(road, f"link/{end}"),
                int(number(only(document.lane(name, lane), f"link/{end}"), "id")),
            )
            at_end = other.attrib["contactPoint"] == "end"
            there = other.attrib["elementId"]
            met = document.place(there, neighbour, number(document.roads[there], "length") if at_end else 0.0)
            here = document.place(name, lane, s)
            assert abs(met.point - here.point) < 1e-9
            assert abs(cmath.exp(1j * met.heading) - cmath.exp(1j * here.heading)) < 1e-9


@few
@given(specs())
def test_bounds_hold_the_road(spec: RoadSpec) -> None:
    """The header says how far the road reaches."""
    document, roads = written(spec), road_map(spec)
    header = only(document.root, "header")
    corners = np.vstack([roads.network.paths.points(lane.path) for lane in roads.network.lanes])
    west, south, east, north = (number(header, side) for side in ("west", "south", "east", "north"))
    assert (corners >= np.array([west, south]) - 1e-9).all()
    assert (corners <= np.array([east, north]) + 1e-9).all()


def test_places_of_a_file_are_its_own() -> None:
    """Read in that file they lie on our centre lines."""
    spec = map_file(VILLAGE, "village.xodr")
    roads, read = road_map(spec), read_opendrive(VILLAGE)
    for lane in roads.network.lanes:
        for along in np.linspace(0.01, 0.99, 15) * lane.length:
            place, ours = roads.place(lane.id, along), roads.network.paths.pose(lane.path, along)
            there = read.pose(*place)
            assert (there.x, there.y) == pytest.approx((ours.x, ours.y), abs=0.006)
            assert math.cos(there.heading - ours.heading) > 0.99


def test_places_run_against_the_road_on_the_other_side() -> None:
    """Traffic that leaves an arm comes from where its road ends."""
    roads = road_map(RoadSpec(approach=50.0))
    lanes = {lane.name: lane.id for lane in roads.network.lanes}
    coming, leaving = (roads.place(lanes[f"north.{way}.1"], 10.0) for way in ("in", "out"))
    assert coming.road == leaving.road
    assert (coming.lane, coming.s) == (-1, 10.0)
    assert (leaving.lane, leaving.s) == (1, 40.0)
    assert all(roads.places[lane.id].forward for lane in roads.network.lanes if lane.role is LaneRole.CONNECTING)


# -- Curves of OpenDRIVE against what they are by definition -----------------------------------------------------------

lengths, curvatures = st.floats(0.0, 200.0), st.floats(-0.2, 0.2)
coefficients = st.floats(-0.05, 0.05)


def geometry(
    curve: str, length: float = 100.0, start: tuple[float, float, float] = (0, 0, 0), **values: float | str
) -> Node:
    attributes = {key: value if isinstance(value, str) else repr(value) for key, value in values.items()}
    x, y, heading = map(repr, start)
    places = {"s": "0", "x": x, "y": y, "hdg": heading, "length": repr(length)}
    return Node("geometry", places, "road.xodr", 1, [Node(curve, attributes, "road.xodr", 2)])


@given(lengths, curvatures, st.floats(-0.02, 0.02))
def test_a_clothoid_is_its_integral(length: float, curvature: float, rate: float) -> None:
    """The pose is the integral of a heading that grows with the square of the distance."""
    assume(length * (abs(curvature) + abs(rate) * length) < 30)

    def heading(u: float) -> float:
        return curvature * u + rate * u * u / 2.0

    pose = clothoid(length, curvature, rate)
    x, _ = quad(lambda u: math.cos(heading(u)), 0.0, length, limit=500, epsabs=1e-11, epsrel=1e-11)
    y, _ = quad(lambda u: math.sin(heading(u)), 0.0, length, limit=500, epsabs=1e-11, epsrel=1e-11)
    assert pose.x == pytest.approx(x, abs=1e-9)
    assert pose.y == pytest.approx(y, abs=1e-9)
    assert pose.heading == pytest.approx(heading(length), abs=1e-12)


@given(st.floats(0.0, 100.0), st.floats(1e-4, 0.05))
def test_a_clothoid_from_a_straight_is_fresnel_integrals(length: float, rate: float) -> None:
    """There x = a C(l / a) and y = a S(l / a) with a = sqrt(pi / rate), in scipy's normalisation."""
    scale = math.sqrt(math.pi / rate)
    sine, cosine = fresnel(length / scale)
    pose = clothoid(length, 0.0, rate)
    assert (pose.x, pose.y) == pytest.approx((scale * cosine, scale * sine), abs=1e-10)


@given(lengths, curvatures)
def test_an_arc_stays_on_its_circle(length: float, curvature: float) -> None:
    """Exact to rounding, also where the circle is a straight line; a clothoid of constant curvature is the same."""
    pose, same = arc(length, curvature), clothoid(length, curvature, 0.0)
    assert pose == pytest.approx(same, abs=1e-10)
    if abs(curvature) > 1e-6:
        radius = 1.0 / curvature
        assert math.hypot(pose.x, pose.y - radius) == pytest.approx(abs(radius), rel=1e-12, abs=1e-9)
    assert pose.heading == length * curvature


@st.composite
def curves(draw: st.DrawFn) -> Node:
    kind = draw(st.sampled_from(sorted(CURVES)))
    names = {
        "line": (),
        "arc": ("curvature",),
        "spiral": ("curvStart", "curvEnd"),
        "poly3": ("c", "d"),
        "paramPoly3": ("cU", "dU", "cV", "dV"),
    }[kind]
    values = {name: draw(coefficients) / (1 if kind in ("arc", "spiral") else 1000) for name in names}
    fixed = {"poly3": {"a": 0.0, "b": 0.0}, "paramPoly3": {"aU": 0.0, "bU": 1.0, "aV": 0.0, "bV": 0.0}}.get(kind, {})
    extra = {"pRange": "arcLength"} if kind == "paramPoly3" else {}
    start = (draw(st.floats(-100, 100)), draw(st.floats(-100, 100)), draw(st.floats(-4, 4)))
    return geometry(kind, draw(st.floats(1.0, 40.0)), start, **fixed, **values, **extra)


@given(curves(), st.floats(0.01, 0.99))
def test_headings_are_those_of_the_way(node: Node, part: float) -> None:
    """Every curve begins at its start, is continuous, and heads where it goes."""
    piece = read_piece(node)
    assert piece.pose(0.0) == pytest.approx(piece.start)
    s, small = part * piece.length, 1e-5
    before, here, after = piece.pose(s - small), piece.pose(s), piece.pose(s + small)
    assert math.hypot(after.x - before.x, after.y - before.y) < 5 * small
    way = math.atan2(after.y - before.y, after.x - before.x)
    assert math.remainder(way - here.heading, math.tau) == pytest.approx(0.0, abs=1e-4)


@given(st.floats(-0.02, 0.02), st.floats(-0.001, 0.001), st.floats(1.0, 20.0))
def test_poly3_is_measured_along_itself(c: float, d: float, distance: float) -> None:
    """The way to a point is as long as the road says."""
    piece = read_piece(geometry("poly3", a=0.0, b=0.0, c=c, d=d))
    end = piece.pose(distance)
    length, _ = quad(lambda u: math.hypot(1.0, u * (2 * c + 3 * d * u)), 0.0, end.x)
    assert length == pytest.approx(distance, abs=1e-9)


def test_normalized_cubics_run_from_nought_to_one() -> None:
    """The same curve by arc length and from 0 to 1."""
    one = read_piece(geometry("paramPoly3", 10.0, aU=0.0, bU=10.0, cU=0.0, dU=0.0, aV=0.0, bV=0.0, cV=2.0, dV=0.0))
    values = {"aU": 0.0, "bU": 1.0, "cU": 0.0, "dU": 0.0, "aV": 0.0, "bV": 0.0, "cV": 0.02, "dV": 0.0}
    other = read_piece(geometry("paramPoly3", 10.0, (0, 0, 0), **values, pRange="arcLength"))
    for s in np.linspace(0.0, 10.0, 7):
        assert one.pose(s) == pytest.approx(other.pose(s))


def test_places_left_of_a_pose_lie_left() -> None:
    """Forward is along the heading, left a quarter turn anticlockwise."""
    assert Pose(1.0, 2.0, math.pi / 2).moved(3.0, 1.0, 0.5) == pytest.approx((0.0, 5.0, math.pi / 2 + 0.5))


@pytest.mark.parametrize(
    ("node", "said"),
    [
        (geometry("circle"), "needs one curve"),
        (geometry("arc"), "lacks the attribute `curvature`"),
        (geometry("arc", curvature=math.nan), "not a number"),
        (geometry("arc", curvature=1e6), "cannot be"),
        (geometry("line", length=-1.0), "cannot be"),
        (geometry("line", length=math.inf), "not a number"),
        (geometry("spiral", 1e8, curvStart=0.0, curvEnd=1.0), "cannot be"),
        (geometry("line", start=(1e300, 0, 0)), "cannot be"),
    ],
)
def test_absurd_curves_are_refused(node: Node, said: str) -> None:
    """Unknown curves, missing numbers, and numbers that no road has."""
    with pytest.raises(InterchangeError, match=said):
        read_piece(node)
