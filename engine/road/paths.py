"""Paths as chains of lines and circular arcs, addressed by arc length.

A path is tangent-continuous: each primitive starts at the end of the primitive before it, with the same heading;
curvature may jump. Positions in metres, headings anticlockwise from +x in radians, curvature 1/m and positive to the
left.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from engine.portable import arctan2
from engine.tables import Floats

JOINT_TOLERANCE = 1e-6
"""Largest distance and difference of heading between joined paths [m, rad]; files allow more."""

STRAIGHT = 1e-3
"""Largest distance of a line from the line that it continues [m]."""


class Pose(NamedTuple):
    x: float
    y: float
    heading: float


class Primitive(NamedTuple):
    """A line (curvature 0) or an arc of at most half a turn, from a pose on for a length."""

    x: float
    y: float
    heading: float
    curvature: float
    length: float

    def pose(self, s: float) -> Pose:
        """Return the pose at arc length `s` from the start; beyond the ends the line or circle continues."""
        angle = self.curvature * s
        if self.curvature == 0.0:
            ahead, left = s, 0.0
        else:
            # 1 - cos would cancel for gentle curves
            ahead, left = math.sin(angle) / self.curvature, 2.0 * math.sin(0.5 * angle) ** 2 / self.curvature
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Pose(self.x + ahead * cos - left * sin, self.y + ahead * sin + left * cos, self.heading + angle)

    def moved(self, dx: float, dy: float) -> "Primitive":
        return self._replace(x=self.x + dx, y=self.y + dy)

    def beside(self, left: float) -> "Primitive":
        """Return the parallel line or arc to the left; `left` is less than the radius of a left-hand arc."""
        x, y, heading = self.pose(0.0)
        share = 1.0 - self.curvature * left
        shifted = x - left * math.sin(heading), y + left * math.cos(heading)
        return Primitive(*shifted, heading, self.curvature / share, self.length * share)

    def turned(self) -> "Primitive":
        """Return the same line or arc in the opposite direction."""
        x, y, heading = self.pose(self.length)
        return Primitive(x, y, heading + math.pi, -self.curvature, self.length)


class Foot(NamedTuple):
    """Nearest points of a path to given points; arrays of the points' shape."""

    s: Floats
    """Arc length [m]."""
    distance: Floats
    """[m]"""


class PathBook:
    """All paths of a program: lanes first, then joined paths. Ids are consecutive and never change."""

    def __init__(self, gap: float = JOINT_TOLERANCE, turn: float = JOINT_TOLERANCE) -> None:
        """Create an empty book; `gap` [m] and `turn` [rad] limit distance and heading difference of joined paths."""
        self._gap, self._turn = gap, turn
        self._paths: list[tuple[Primitive, ...]] = []
        self._starts: list[tuple[float, ...]] = []
        self._joined: dict[tuple[int, ...], int] = {}
        self._reversed: dict[int, int] = {}
        self._drawn: dict[tuple[Primitive, ...], int] = {}

    def __len__(self) -> int:
        return len(self._paths)

    def filled(self, paths: Sequence[tuple[Primitive, ...]], joined: Mapping[tuple[int, ...], int]) -> "PathBook":
        """Take over the paths of another book; `joined` gives the ids of joined paths by their parts."""
        self._paths = list(paths)
        self._starts = [_starts(path) for path in paths]
        self._joined = dict(joined)
        return self

    def add(self, primitives: Sequence[Primitive]) -> int:
        """Add a path and return its id. Adjacent primitives of one line become one."""
        merged = _merge(primitives)
        self._paths.append(merged)
        self._starts.append(_starts(merged))
        return len(self._paths) - 1

    def draw(self, primitives: tuple[Primitive, ...]) -> int:
        """Return the path of a chain; equal chains have equal ids."""
        if primitives not in self._drawn:
            self._drawn[primitives] = self.add(primitives)
        return self._drawn[primitives]

    def join(self, path_ids: Sequence[int]) -> int:
        """Return the path through all given paths; equal sequences have equal ids.

        Raises:
            ValueError: empty, or a path does not start at the end of the path before (see `continues`).
        """
        key = tuple(path_ids)
        if not key:
            raise ValueError("an empty sequence of paths cannot be joined")
        if len(key) == 1:
            return key[0]
        if key not in self._joined:
            for before, after in pairwise(key):
                if not self.continues(before, after):
                    raise ValueError(f"path {after} does not start where path {before} ends")
            self._joined[key] = self.add([primitive for path in key for primitive in self._paths[path]])
        return self._joined[key]

    def parts(self, path: int) -> tuple[int, ...]:
        """Return the paths that a joined path consists of; for any other path, the path itself."""
        return next((parts for parts, joined in self._joined.items() if joined == path), (path,))

    def reverse(self, path: int) -> int:
        """Return the path in the opposite direction; equal paths have equal ids."""
        if path not in self._reversed:
            self._reversed[path] = self.add([primitive.turned() for primitive in reversed(self._paths[path])])
        return self._reversed[path]

    def continues(self, before: int, after: int) -> bool:
        """Return True if path `after` starts at the end of path `before`, in the same direction."""
        end, start = self.pose(before, self.length(before)), self.pose(after, 0.0)
        turn = math.remainder(end.heading - start.heading, math.tau)
        return max(abs(end.x - start.x), abs(end.y - start.y)) <= self._gap and abs(turn) <= self._turn

    def primitives(self, path: int) -> tuple[Primitive, ...]:
        return self._paths[path]

    def starts(self, path: int) -> tuple[float, ...]:
        """Return the arc length at which each primitive starts, and last the path's length."""
        return self._starts[path]

    def length(self, path: int) -> float:
        return self._starts[path][-1]

    def pose(self, path: int, s: float) -> Pose:
        """Return the pose at arc length `s`, clipped to the path."""
        index, start = self._find(path, s)
        primitive = self._paths[path][index]
        return primitive.pose(min(max(s - start, 0.0), primitive.length))

    def curvature(self, path: int, s: float) -> float:
        return self._paths[path][self._find(path, s)[0]].curvature

    def project(self, path: int, x: float, y: float) -> float:
        """Return the arc length of the path's point nearest to (x, y)."""
        return float(self.feet(path, np.array(x), np.array(y)).s)

    def distance(self, path: int, x: float, y: float) -> float:
        return float(self.feet(path, np.array(x), np.array(y)).distance)

    def feet(self, path: int, x: Floats, y: Floats) -> Foot:
        """Return the path's nearest points to many points; among equally near points the first along the path."""
        best = Foot(np.zeros(np.shape(x)), np.full(np.shape(x), np.inf))
        for primitive, start in zip(self._paths[path], self._starts[path], strict=False):
            foot = _feet(primitive, x, y)
            nearer = foot.distance < best.distance
            s = np.where(nearer, start + foot.s, best.s)
            best = Foot(s, np.where(nearer, foot.distance, best.distance))
        return best

    def points(self, path: int, tolerance: float = 0.01) -> Floats:
        """Return an (n, 2) polyline within `tolerance` [m] of the path, for drawing and strips."""
        poses = [self.pose(path, s) for s in self.stations(path, tolerance)]
        return np.array([(pose.x, pose.y) for pose in poses])

    def stations(self, path: int, tolerance: float = 0.01) -> Floats:
        """Return the arc lengths of the vertices of `points`."""
        stations = [0.0]
        for primitive, start in zip(self._paths[path], self._starts[path], strict=False):
            count = chord_count(primitive, tolerance)
            stations += [start + primitive.length * (i + 1) / count for i in range(count)]
        return np.array(stations)

    def _find(self, path: int, s: float) -> tuple[int, float]:
        """Return index and start of the primitive at arc length `s`."""
        starts = self._starts[path]
        index = 0
        while index + 2 < len(starts) and s >= starts[index + 1]:
            index += 1
        return index, starts[index]


def chord_count(primitive: Primitive, tolerance: float) -> int:
    """Return the number of equal chords that stay within `tolerance` of the primitive [m]."""
    sagitta = min(tolerance * abs(primitive.curvature), 1.0)
    if sagitta == 0.0:
        return 1
    angle = 4.0 * math.asin(math.sqrt(0.5 * sagitta))  # 2 acos(1 - sagitta), which is 0 for a curvature of 1e-15
    return max(1, math.ceil(abs(primitive.curvature) * primitive.length / angle - 1e-9))


def _starts(path: Sequence[Primitive]) -> tuple[float, ...]:
    return tuple(accumulate((primitive.length for primitive in path), initial=0.0))


def _merge(primitives: Sequence[Primitive]) -> tuple[Primitive, ...]:
    merged: list[Primitive] = []
    for primitive in primitives:
        last = merged[-1] if merged else None
        # Arcs are not merged: the result could be longer than half a turn.
        if last is not None and last.curvature == primitive.curvature == 0.0 and _goes_on(last, primitive):
            merged[-1] = last._replace(length=last.length + primitive.length)
        else:
            merged.append(primitive)
    return tuple(merged)


def _goes_on(before: Primitive, after: Primitive) -> bool:
    """Return True if a line continues an earlier line; drawn lines of a file may have corners, and gaps."""
    ends = ((before.pose(before.length + s), after.pose(s)) for s in (0.0, after.length))
    return all(math.hypot(one.x - other.x, one.y - other.y) <= STRAIGHT for one, other in ends)


def _feet(primitive: Primitive, x: Floats, y: Floats) -> Foot:
    """Return nearest points of one primitive: the closed form if its normal meets the point, else an end."""
    ahead, left = _local(primitive, x, y)
    if primitive.curvature == 0.0:
        s = np.clip(ahead, 0.0, primitive.length)
        return Foot(s, np.hypot(ahead - s, left))
    radius = 1.0 / primitive.curvature
    s = arctan2(ahead, (radius - left) * np.sign(radius)) * abs(radius)
    end = primitive.pose(primitive.length)
    to_start, to_end = np.hypot(ahead, left), np.hypot(x - end.x, y - end.y)
    on_arc = (s >= 0.0) & (s <= primitive.length)
    nearest_end = np.where(to_end < to_start, primitive.length, 0.0)
    radial = np.abs(np.hypot(ahead, radius - left) - abs(radius))
    return Foot(np.where(on_arc, s, nearest_end), np.where(on_arc, radial, np.minimum(to_start, to_end)))


def _local(primitive: Primitive, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return distances of points ahead of the primitive's start, and to its left."""
    dx, dy = x - primitive.x, y - primitive.y
    cos, sin = math.cos(primitive.heading), math.sin(primitive.heading)
    return dx * cos + dy * sin, dy * cos - dx * sin
