"""The curves that reference lines are made of: pieces of `planView`, each a curve from a pose. Metres and radians.

Source: ASAM OpenDRIVE 1.7.0, chapter 8, "Geometry".
"""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from engine.xml import LARGEST, Node

MOST_TURNING = 1000.0
"""Largest turn of one piece of a road [rad]; it also bounds the work for one point."""
PANEL = 2.0
"""Largest turn of a spiral in one panel of the quadrature [rad]: sixteen nodes are then exact to rounding."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
STEEPEST = 1e6
"""Largest coefficient of a polynomial."""


class Pose(NamedTuple):
    """x, y [m], heading anticlockwise from +x [rad]."""

    x: float
    y: float
    heading: float

    def moved(self, forward: float, left: float, turn: float = 0.0) -> "Pose":
        """Return the pose `forward` ahead and `left` to the left [m], turned by an angle [rad]."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Pose(self.x + forward * cos - left * sin, self.y + forward * sin + left * cos, self.heading + turn)


class Piece(NamedTuple):
    """One `geometry`: its beginning on the road and in the plane, and its curve in its own frame."""

    s: float
    length: float
    start: Pose
    curve: Callable[[float], Pose]
    curvature: float | None
    """Curvature of a line (0) or an arc [1/m]; None for all other curves."""

    def pose(self, s: float) -> Pose:
        """Return the pose at the road's arc length s, clipped to the piece."""
        x, y, turn = self.curve(min(max(s - self.s, 0.0), self.length))
        return self.start.moved(x, y, turn)


def read_piece(node: Node) -> Piece:
    """Return one `geometry` element.

    Raises:
        InterchangeError: an unknown curve, or impossible numbers.
    """
    start = Pose(node.number("x"), node.number("y"), node.number("hdg", high=1e4, low=-1e4))
    length = node.number("length", low=0.0)
    shapes = node.every(*CURVES)
    if len(shapes) != 1:
        raise node.error(f"<geometry> needs one curve and has {len(shapes)}", f"write one of {', '.join(CURVES)}")
    (shape,) = shapes
    bends = {"line": 0.0, "arc": _curvature(shape, "curvature", length) if shape.tag == "arc" else None}
    return Piece(node.number("s", low=0.0), length, start, CURVES[shape.tag](shape, length), bends.get(shape.tag))


def clothoid(distance: float, curvature: float, rate: float) -> Pose:
    """Return the pose after a distance along a curve of linear curvature, from the origin along +x.

    x = ∫ cos(κ u + κ' u²/2) du and y = ∫ sin(…) du, by Gauss-Legendre quadrature on panels that turn by at most two
    radians. Fresnel integrals give the same, but lose all digits if κ' is nearly zero (Bertolazzi and Frego, "G1
    fitting with clothoids", 2015, section 4).
    """
    turning = abs(distance) * max(abs(curvature), abs(curvature + rate * distance))
    edges = np.linspace(0.0, distance, max(1, math.ceil(turning / PANEL)) + 1)
    half = np.diff(edges)[:, None] / 2.0
    along = edges[:-1, None] + half * (NODES + 1.0)
    heading = along * (curvature + rate * along / 2.0)
    x, y = float(np.sum(half * WEIGHTS * np.cos(heading))), float(np.sum(half * WEIGHTS * np.sin(heading)))
    return Pose(x, y, distance * (curvature + rate * distance / 2.0))


def _line(_: Node, __: float) -> Callable[[float], Pose]:
    return lambda distance: Pose(distance, 0.0, 0.0)


def _arc(node: Node, length: float) -> Callable[[float], Pose]:
    curvature = _curvature(node, "curvature", length)
    return lambda distance: arc(distance, curvature)


def arc(distance: float, curvature: float) -> Pose:
    """Return the pose after a distance along a circle; the sine of half the angle keeps all digits of flat arcs."""
    turn = distance * curvature
    chord = distance * float(np.sinc(turn / (2.0 * math.pi)))
    return Pose(chord * math.cos(turn / 2.0), chord * math.sin(turn / 2.0), turn)


def _spiral(node: Node, length: float) -> Callable[[float], Pose]:
    start, end = _curvature(node, "curvStart", length), _curvature(node, "curvEnd", length)
    rate = (end - start) / length if length > 0.0 else 0.0
    return lambda distance: clothoid(distance, start, rate)


def _curvature(node: Node, name: str, length: float) -> float:
    most = min(LARGEST, MOST_TURNING / length) if length > 0.0 else LARGEST
    return node.number(name, low=-most, high=most)


def _poly3(node: Node, _: float) -> Callable[[float], Pose]:
    """Return the cubic v = a + b u + c u² + d u³; `distance` is along the curve, so Newton's method searches for u."""
    a, b, c, d = (node.number(name, low=-STEEPEST, high=STEEPEST) for name in "abcd")

    def curve(distance: float) -> Pose:
        u = 0.0
        for _ in range(50):
            along = u / 2.0 * (NODES + 1.0)
            length = u / 2.0 * float(np.sum(WEIGHTS * np.hypot(1.0, b + along * (2.0 * c + 3.0 * d * along))))
            change = (distance - length) / math.hypot(1.0, b + u * (2.0 * c + 3.0 * d * u))
            u += change
            if abs(change) < 1e-12:
                break
        return Pose(u, a + u * (b + u * (c + u * d)), math.atan(b + u * (2.0 * c + 3.0 * d * u)))

    return curve


def _param_poly3(node: Node, length: float) -> Callable[[float], Pose]:
    """Return the curve with u and v as cubics of p, which is the arc length, or runs from 0 to 1."""
    u, v = ([node.number(name + axis, low=-STEEPEST, high=STEEPEST) for name in "abcd"] for axis in "UV")
    normalized = node.text("pRange", "normalized") == "normalized"
    scale = 1.0 / length if normalized and length > 0.0 else 1.0

    def curve(distance: float) -> Pose:
        p = distance * scale
        du, dv = (k[1] + p * (2.0 * k[2] + 3.0 * k[3] * p) for k in (u, v))
        x, y = (k[0] + p * (k[1] + p * (k[2] + p * k[3])) for k in (u, v))
        return Pose(x, y, math.atan2(dv, du))

    return curve


CURVES: Mapping[str, Callable[[Node, float], Callable[[float], Pose]]] = MappingProxyType(
    {"line": _line, "arc": _arc, "spiral": _spiral, "poly3": _poly3, "paramPoly3": _param_poly3}
)
