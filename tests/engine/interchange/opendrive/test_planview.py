"""Curves of OpenDRIVE against what they are by definition."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import fresnel

from engine.interchange import InterchangeError
from engine.interchange.opendrive.geometry import CURVES, Pose, arc, clothoid, read_piece
from engine.interchange.xml import Node

lengths, curvatures = st.floats(0.0, 200.0), st.floats(-0.2, 0.2)
coefficients = st.floats(-0.05, 0.05)


def geometry(curve: str, length: float = 100.0, start: tuple[float, float, float] = (0, 0, 0), **values: float) -> Node:
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
    other = read_piece(geometry("paramPoly3", 10.0, **values, pRange="arcLength"))
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
