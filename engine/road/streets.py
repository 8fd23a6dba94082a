"""Strips beside the lanes of made roads, their kerbs and crossings, and the cars parked there.

From the outer lane outwards: bicycle lane, shoulder, parking row, kerb, sidewalk; a bicycle lane behind parked cars is
next to the kerb. Depths are measured from the border of the outer lane, positive towards the kerb [m].
"""

import math
from collections.abc import Callable, Iterator, Sequence
from hashlib import blake2b
from itertools import pairwise

import numpy as np

from engine.frozen import frozen
from engine.maps import Street
from engine.road.junction import CHORD_TOLERANCE
from engine.road.network import Lane, Network, Surface, SurfaceKind
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape, between, strip
from engine.road.specification import setback
from engine.tables import Floats
from engine.vehicles import CAR

KERB_STRIP = 1e-3
"""Width of the region of a kerb line [m]."""
PLACE = 6.0
"""Length of a parking place along the kerb [m]: a car and room to leave; *ours*."""
PLACE_ACROSS = 2.5
"""Width of a place of cars that stand at a right angle to the kerb [m]; *ours*."""
CLEAR = 5.0
"""Length of kerb without parked cars beside an intersection, and on both sides of a crossing [m]: StVO, section 12 (3)
and Annex 2, sign 293."""

# -- strips ------------------------------------------------------------------------------------------------------------


@frozen
class Layer:
    """One strip beside the lanes."""

    kind: SurfaceKind
    inner: float
    """Depth of its border towards the lanes [m]."""
    width: float

    @property
    def middle(self) -> float:
        return self.inner + 0.5 * self.width


def layers(spec: Street) -> tuple[Layer, ...]:
    """Return the strips from the outer lane to the kerb, and the sidewalk behind it."""
    bike = (SurfaceKind.BIKE_LANE, spec.bike_lane)
    rows = [(SurfaceKind.SHOULDER, spec.shoulder), (SurfaceKind.PARKING, spec.parking)]
    rows.insert(len(rows) if spec.bike_lane_behind_parking else 0, bike)
    found: list[Layer] = []
    depth = 0.0
    for kind, width in (*rows, (SurfaceKind.SIDEWALK, spec.sidewalk)):
        if width is not None:
            found.append(Layer(kind, depth, width))
            depth += width
    return tuple(found)


def lay_street(network: Network, lay: Callable[[Network], tuple[Surface, ...]]) -> None:
    """Let a network make its surfaces by `lay` when they are first used, but parked cars at once."""
    network.lay = lay
    if isinstance(network.spec, Street) and network.spec.parked > 0.0:
        _ = network.surfaces


def is_beside(surface: Surface, lane: Lane) -> bool:
    """Return True if a strip is beside the lanes of a lane's direction."""
    return surface.road == lane.road and surface.forward == lane.forward and surface.intersection_id is None


class StreetBuilder:
    """The surfaces of a network under construction."""

    def __init__(self, network: Network) -> None:
        spec = network.spec
        assert isinstance(spec, Street)
        self.network, self.spec = network, spec
        self.side = 1.0 if network.left_hand else -1.0
        """Sign of a depth as a distance to the left of a line along the traffic."""
        self.surfaces: list[Surface] = []
        self.cars: list[tuple[float, float, float, float, float]] = []

    def finish(self) -> tuple[Surface, ...]:
        """Return the surfaces; the parked cars join the buildings of the network."""
        if self.cars:
            self.network.buildings = np.vstack([self.network.buildings, self.cars])
            self.network.parked = len(self.cars)
        return tuple(self.surfaces)

    def add(
        self,
        kind: SurfaceKind,
        name: str,
        line: Sequence[Primitive],
        width: float,
        road: str,
        *,
        forward: bool = True,
        shape: Shape | None = None,
        intersection: int | None = None,
        ends: tuple[int, int] | None = None,
        arm: int | None = None,
    ) -> Surface:
        """Add the surface along a centre line, by default the strip of that width along the line."""
        shape, number = shape or strip_along(line, width), len(self.surfaces)
        about = (kind, name, tuple(line), shape, width, road, forward, intersection, ends, arm)
        surface = Surface(self.network, number, *about)
        self.surfaces.append(surface)
        return surface

    def add_curb(
        self, name: str, line: Sequence[Primitive], road: str, *, forward: bool = True, at: int | None = None
    ) -> None:
        self.add(SurfaceKind.CURB, f"{name}.curb", line, KERB_STRIP, road, forward=forward, intersection=at)

    def beside(
        self,
        lane: Lane,
        clear: Sequence[tuple[float, float]] = (),
        extent: tuple[float, float] = (0.0, 0.0),
        *,
        parking: bool = True,
    ) -> None:
        """Add all strips beside the outer lane of a direction.

        `clear` lists ranges along the lane without parked cars [m]; `extent`: lengths by which the sidewalk and the
        kerb extend beyond the start and the end of the lane [m]. Without `parking` the row is a shoulder.
        """
        name, paths = lane.name.rsplit(".", 1)[0], self.network.paths
        outer = [each.beside(self.side * 0.5 * lane.width) for each in paths.primitives(lane.path)]
        for layer in layers(self.spec):
            is_sidewalk = layer.kind is SurfaceKind.SIDEWALK
            kind = layer.kind if parking or layer.kind is not SurfaceKind.PARKING else SurfaceKind.SHOULDER
            beyond = extent if is_sidewalk else (0.0, 0.0)
            line = extended(self.shifted(outer, layer.middle), *beyond)
            # The borders have the corners of the lane's border, so that strips share their borders.
            reach = self.side * (0.5 * lane.width + layer.inner)
            lefts = reach, reach + self.side * layer.width
            shape = between(*(self.edge(lane, left, beyond) for left in lefts))
            row = self.add(
                kind, f"{name}.{kind.value}", line, layer.width, lane.road, forward=lane.forward, shape=shape
            )  # fmt: skip
            if kind is SurfaceKind.PARKING:
                self._park(name, lane, row, clear)
        line = extended(self.shifted(outer, setback(self.spec)), *extent)
        self.add_curb(name, line, lane.road, forward=lane.forward)

    def edge(self, lane: Lane, left: float, extent: tuple[float, float] = (0.0, 0.0)) -> Floats:
        """Return (n, 2) a line to the left of a lane's centre line [m], with the corners of the lane's border."""
        paths = self.network.paths
        poses = np.array([paths.pose(lane.path, s) for s in paths.stations(lane.path, CHORD_TOLERANCE)])
        x, y, heading = poses.T
        points = np.column_stack([x - left * np.sin(heading), y + left * np.cos(heading)])
        ways = np.column_stack([np.cos(heading), np.sin(heading)])
        before, after = extent
        head = [points[0] - before * ways[0]] if before > 0.0 else []
        tail = [points[-1] + after * ways[-1]] if after > 0.0 else []
        return np.vstack([*head, points, *tail])

    def shifted(self, line: Sequence[Primitive], depth: float) -> list[Primitive]:
        """Return a line at a depth beside the border of an outer lane, both along the traffic."""
        return [each.beside(self.side * depth) for each in line]

    def cross(
        self,
        name: str,
        middle: Sequence[Primitive],
        reach: tuple[float, float],
        road: str,
        ends: tuple[int, int],
        *,
        intersection: int | None = None,
        arm: int | None = None,
    ) -> Surface:
        """Add the crossing along a stretch of a road's `middle`.

        `reach` has the distances of the kerbs to the right and left of that line [m]; it is walked from the right.
        """
        right, left = reach
        axis, paths = [each.beside(0.5 * (left - right)) for each in middle], PathBook()
        path, shape = paths.add(axis), strip_along(axis, left + right)
        at = paths.pose(path, 0.5 * paths.length(path))
        half, heading = 0.5 * (left + right), at.heading + 0.5 * math.pi
        start = at.x - half * math.cos(heading), at.y - half * math.sin(heading)
        line = [Primitive(*start, heading, 0.0, 2.0 * half)]
        width = self.spec.crossing_width
        return self.add(
            SurfaceKind.CROSSING, name, line, width, road, shape=shape, intersection=intersection, ends=ends, arm=arm
        )  # fmt: skip

    # -- parked cars -------------------------------------------------------------------------------------------------

    def _park(self, name: str, lane: Lane, row: Surface, clear: Sequence[tuple[float, float]]) -> None:
        """Place cars in a parking row, each place with probability `parked`; `clear` lists ranges along the lane."""
        paths, across = PathBook(), row.width >= CAR.length
        path = paths.add(row.line)
        pitch = PLACE_ACROSS if across else PLACE
        way = self.network.paths
        ends = [[way.pose(lane.path, min(max(s, 0.0), lane.length)) for s in each] for each in clear]
        taken = [tuple(paths.project(path, pose.x, pose.y) for pose in each) for each in ends]
        for first, last in free_ranges(row.length, [(a, b) for a, b in taken]):
            for number in range(int((last - first) // pitch)):
                s = first + (number + 0.5) * pitch
                if uniform_of(f"{name}.{s:.3f}") < self.spec.parked:
                    pose = paths.pose(path, s)
                    turn = 0.5 * math.pi if across else 0.0
                    self.cars.append((pose.x, pose.y, pose.heading + turn, CAR.length, CAR.width))


def uniform_of(place: str) -> float:
    """Return the uniform number of a parking place in [0, 1), from a stream of its own: it depends on the name only."""
    digest = blake2b(f"parked {place}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") / 2.0**64


def free_ranges(length: float, taken: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """Yield the ranges of [0, length] outside all taken ranges."""
    begin = 0.0
    for first, last in sorted([*taken, (length, length)]):
        if min(first, length) > begin:
            yield begin, min(first, length)
        begin = max(begin, last)


def strip_along(line: Sequence[Primitive], width: float) -> Shape:
    """Return the region within half a width [m] of a line."""
    paths = PathBook()
    return strip(paths, paths.add(line), width, CHORD_TOLERANCE)


# -- lines -------------------------------------------------------------------------------------------------------------


def extended(line: Sequence[Primitive], before: float, after: float) -> list[Primitive]:
    """Return a line with straight extensions of some lengths at its start and end [m]."""
    first, last = line[0], line[-1]
    if before > 0.0:
        x, y = first.x - before * math.cos(first.heading), first.y - before * math.sin(first.heading)
        line = [Primitive(x, y, first.heading, 0.0, before), *line]
    if after > 0.0:
        line = [*line, Primitive(*last.pose(last.length), 0.0, after)]
    return list(line)


def stretch(line: Sequence[Primitive], first: float, last: float) -> list[Primitive]:
    """Return the part of a line between two arc lengths [m]."""
    found: list[Primitive] = []
    ends = np.cumsum([0.0, *(each.length for each in line)]).tolist()
    for each, (begin, end) in zip(line, pairwise(ends), strict=True):
        low, high = max(first, begin), min(last, end)
        if high > low:
            x, y, heading = each.pose(low - begin)
            found.append(Primitive(x, y, heading, each.curvature, high - low))
    return found


def round_corner(fillet: Floats, centre: Floats, depth: float) -> Shape:
    """Return the strip of a width `depth` between a kerb (n, 2) around a centre and the arc behind the kerb."""
    away = fillet - centre
    radius = np.hypot(away[:, 0], away[:, 1])[:, None]
    return between(fillet, centre + away * ((radius - depth) / radius))
