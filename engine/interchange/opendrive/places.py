"""Where things lie in OpenDRIVE: which road and lane there each of our lanes is, and the curves that reference lines
are made of. Metres and radians.

A road outside the junctions has its two directions to either side of its reference line, which runs in the middle and
with the traffic of its first lane. A turn is a road of one lane with the reference line on the lane's own centre. On
straight roads and turns arc length along our lane is arc length along the reference line, or what is left of it; a lane
that curves beside its reference line is longer or shorter, primitive by primitive.

Source of the curves: ASAM OpenDRIVE 1.7.0, chapter 8, "Geometry".
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from engine.interchange.xml import LARGEST, Node
from engine.maps import MapSpec
from engine.road import Lane, Maneuver, Network, Road, build_network


class RoadPlace(NamedTuple):
    """A place as others say it: road, lane, arc length along the road's reference line [m]."""

    road: str
    lane: int
    s: float


@dataclass(frozen=True)
class LanePlace:
    """One of our lanes in OpenDRIVE's terms."""

    road: str
    lane: int
    """Positive to the left of the reference line, negative to its right, counted from the middle."""
    forward: bool
    """Whether traffic runs the way that s grows."""
    length: float
    """[m]"""

    knots: tuple[tuple[float, float], ...] = ()
    """Where both run as arcs of other lengths: arc lengths along the lane and on the road, at the ends of each [m]."""

    def s(self, along: float) -> float:
        """Arc length on the road, of a point `along` the lane [m]."""
        if self.knots:
            lane, road = zip(*self.knots, strict=True)
            return float(np.interp(along, lane, road))
        return along if self.forward else self.length - along


@dataclass(frozen=True)
class Carriageway:
    """A road outside the junctions."""

    id: str
    road: Road

    @property
    def name(self) -> str:
        return self.road.name

    @property
    def forward(self) -> tuple[Lane, ...]:
        """Lanes that run the way that s grows, from the kerb to the middle."""
        return self.road.forward.lanes

    @property
    def backward(self) -> tuple[Lane, ...]:
        return self.road.backward.lanes

    @property
    def lanes(self) -> tuple[Lane, ...]:
        return self.road.lanes

    @property
    def length(self) -> float:
        return sum(each.length for each in self.road.middle)

    def place(self, lane: Lane) -> LanePlace:
        """One of its lanes, numbered from the middle outwards."""
        side = 1 if lane.network.left_hand else -1
        beside = self.forward if lane.forward else self.backward
        from_middle = len(beside) + 1 - lane.number
        number = (side if lane.forward else -side) * from_middle
        return LanePlace(self.id, number, lane.forward, lane.length, self._knots(lane))

    def _knots(self, lane: Lane) -> tuple[tuple[float, float], ...]:
        if all(each.curvature == 0.0 for each in self.road.middle):
            return ()
        ends = [0.0, *accumulate(each.length for each in self.road.middle)]
        starts = lane.network.paths.starts(lane.path)
        return tuple(zip(starts, ends if lane.forward else ends[::-1], strict=True))


@dataclass(frozen=True)
class RoadMap:
    """A network with the names that its parts have in OpenDRIVE: numbers from 1, none used twice in a document."""

    network: Network

    @cached_property
    def roads(self) -> tuple[Carriageway, ...]:
        """All roads outside the junctions, in the order of their lanes."""
        return tuple(Carriageway(str(number), road) for number, road in enumerate(self.network.roads, 1))

    def turn_id(self, maneuver: Maneuver) -> str:
        """The road that runs through the junction along a maneuver."""
        return str(len(self.roads) + 1 + maneuver.id)

    def junction_id(self, intersection: int) -> str:
        return str(len(self.roads) + len(self.network.maneuvers) + 1 + intersection)

    @cached_property
    def places(self) -> tuple[LanePlace, ...]:
        """By lane id."""
        places: dict[int, LanePlace] = {}
        for road in self.roads:
            for lane in road.lanes:
                places[lane.id] = road.place(lane)
        for maneuver in self.network.maneuvers:
            lane = maneuver.connecting_lane
            places[lane.id] = LanePlace(self.turn_id(maneuver), self.side, True, lane.length)
        return tuple(places[lane.id] for lane in self.network.lanes)

    def place(self, lane: int, s: float) -> RoadPlace:
        """Where a point `s` along one of our lanes [m] lies; `lane` is its id."""
        there = self.places[lane]
        return RoadPlace(there.road, there.lane, there.s(s))

    @property
    def side(self) -> int:
        """Sign of the lanes that run the way that s grows."""
        return 1 if self.network.left_hand else -1


def road_map(spec: MapSpec) -> RoadMap:
    """The road of a specification with its names in OpenDRIVE.

    Raises:
        RoadError: no road fits the specification.
    """
    return RoadMap(build_network(spec))


class Beside(NamedTuple):
    """A building beside a road: its number, s and t of its centre [m], heading against the road's [rad], sizes [m]."""

    number: int
    s: float
    t: float
    heading: float
    length: float
    width: float


def buildings_by_road(roads: RoadMap) -> Mapping[str, list[Beside]]:
    """The buildings, each with the first road whose length passes its centre, by the id of the road."""
    found: dict[str, list[Beside]] = {road.id: [] for road in roads.roads}
    for number, (x, y, heading, length, width) in enumerate(roads.network.buildings.tolist()):
        for road in roads.roads:
            line = road.road.middle[0]  # makers that have buildings have straight roads
            cos, sin = round(math.cos(line.heading)), round(math.sin(line.heading))
            s, t = (x - line.x) * cos + (y - line.y) * sin, (y - line.y) * cos - (x - line.x) * sin
            if 0.0 <= s <= line.length:
                found[road.id].append(Beside(number, s, t, heading - line.heading, length, width))
                break
    return found


# -- reference lines: pieces of `planView`, each a curve from a pose ---------------------------------------------------

MOST_TURNING = 1000.0
"""More than this no road turns along one piece [rad]; it bounds the work of one point, too."""
PANEL = 2.0
"""How far a spiral turns within one panel of the quadrature [rad]: sixteen nodes are then exact to rounding."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
STEEPEST = 1e6
"""Largest coefficient of a polynomial."""


class Pose(NamedTuple):
    """x, y [m], heading anticlockwise from +x [rad]."""

    x: float
    y: float
    heading: float

    def moved(self, forward: float, left: float, turn: float = 0.0) -> "Pose":
        """The pose that far ahead and to the left, turned by an angle."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Pose(self.x + forward * cos - left * sin, self.y + forward * sin + left * cos, self.heading + turn)


class Piece(NamedTuple):
    """One `geometry`: where it begins on the road and in the plane, and its curve in its own frame."""

    s: float
    length: float
    start: Pose
    curve: Callable[[float], Pose]

    def pose(self, s: float) -> Pose:
        """The pose at the road's arc length s, which is held within the piece."""
        x, y, turn = self.curve(min(max(s - self.s, 0.0), self.length))
        return self.start.moved(x, y, turn)


def read_piece(node: Node) -> Piece:
    """One `geometry` element.

    Raises:
        InterchangeError: an unknown curve, or numbers that no road has.
    """
    start = Pose(node.number("x"), node.number("y"), node.number("hdg", high=1e4, low=-1e4))
    length = node.number("length", low=0.0)
    shapes = [child for child in node.children if child.tag in CURVES]
    if len(shapes) != 1:
        raise node.error(f"<geometry> needs one curve and has {len(shapes)}", f"write one of {', '.join(CURVES)}")
    return Piece(node.number("s", low=0.0), length, start, CURVES[shapes[0].tag](shapes[0], length))


def clothoid(distance: float, curvature: float, rate: float) -> Pose:
    """The pose after a distance along a curve whose curvature grows evenly, from the origin along +x.

    x = ∫ cos(κ u + κ' u²/2) du and y = ∫ sin(…) du, by Gauss-Legendre quadrature on panels that turn by at most two
    radians. Fresnel integrals give the same, but lose all digits where κ' is nearly nothing (Bertolazzi and Frego,
    "G1 fitting with clothoids", 2015, section 4).
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
    """The pose after a distance along a circle; the sine of half the angle keeps all digits of flat arcs."""
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
    """The cubic v = a + b u + c u² + d u³; `distance` runs along the curve, so u is searched for by Newton's method."""
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
    """Both u and v are cubics of p, which runs with arc length, or from 0 to 1."""
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
