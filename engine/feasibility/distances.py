"""What bounds over boxes are made of: distances of many points from regions and paths, and boxes of places.

In plain numpy.
"""

import math
from collections.abc import Iterator

import numpy as np

from engine.feasibility.arithmetic import Bools, Interval
from engine.tables import Floats, Ints, RoadTables

S0, X, Y, HEADING, CURVATURE, LENGTH, COS, SIN = range(8)
"""Columns of `RoadTables.primitives`."""
CHUNK = 1 << 16
"""Pairs of point and edge that are looked at together."""


def region_edges(road: RoadTables, region: int) -> Floats:
    """(m, 4): x1, y1, x2, y2."""
    return road.edges[road.region_start[region] : road.region_start[region + 1]]


def path_primitives(road: RoadTables, path: int) -> Floats:
    """(m, 8): the rows of `RoadTables.primitives`."""
    return road.primitives[road.path_start[path] : road.path_start[path + 1]]


def boundary_distance(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    """Distance of points (n,) from the boundary of a region, and whether they lie inside (even-odd rule).

    Equal points are looked at once: where one variable's range is sliced, most places stay as they are.
    """
    points, place = np.unique(x + 1j * y, return_inverse=True)
    distance, inside = _in_chunks(edges, points.real, points.imag)
    return distance[place], inside[place]


def _in_chunks(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    distance, inside = np.empty(len(x)), np.empty(len(x), dtype=bool)
    size = max(1, CHUNK // max(1, len(edges)))
    for start in range(0, len(x), size):
        part = slice(start, start + size)
        distance[part], inside[part] = _boundary_distance(edges, x[part, np.newaxis], y[part, np.newaxis])
    return distance, inside


def _boundary_distance(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    x1, y1, x2, y2 = edges.T
    ex, ey, dx, dy = x2 - x1, y2 - y1, x - x1, y - y1
    along = np.clip((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0, 1.0)
    square = np.square(dx - along * ex) + np.square(dy - along * ey)
    crosses = ((y1 > y) != (y2 > y)) & (x1 + dy * ex / ey > x)
    return np.sqrt(square.min(axis=1)), crosses.sum(axis=1) % 2 == 1


def path_distance(primitives: Floats, x: Floats, y: Floats) -> Floats:
    """Distance of points (n,) from a chain of lines and arcs."""
    distance = np.full(len(x), np.inf)
    for primitive in primitives:
        distance = np.minimum(distance, _primitive_distance(primitive, x, y))
    return distance


def _primitive_distance(primitive: Floats, x: Floats, y: Floats) -> Floats:
    dx, dy = x - primitive[X], y - primitive[Y]
    ahead, left = dx * primitive[COS] + dy * primitive[SIN], dy * primitive[COS] - dx * primitive[SIN]
    curvature, length = primitive[CURVATURE], primitive[LENGTH]
    if curvature == 0.0:
        return np.hypot(ahead - np.clip(ahead, 0.0, length), left)
    radius = 1.0 / curvature
    angle = np.arctan2(ahead, radius - left) if curvature > 0.0 else np.arctan2(ahead, left - radius)
    on = (angle >= 0.0) & (angle <= length * abs(curvature))
    end = radius * math.sin(curvature * length), radius * (1.0 - math.cos(curvature * length))
    to_ends: Floats = np.minimum(np.hypot(ahead, left), np.hypot(ahead - end[0], left - end[1]))
    return np.where(on, np.abs(np.hypot(ahead, radius - left) - abs(radius)), to_ends)


# -- boxes of places ---------------------------------------------------------------------------------------------------

SLACK = 1e-7
"""Far above the rounding of any of these in a road of kilometres [m]."""


def numbers(*intervals: Interval) -> Bools:
    """Boxes in which all of these are finite."""
    known = np.ones(len(intervals[0].low), dtype=bool)
    for interval in intervals:
        known &= np.isfinite(interval.low) & np.isfinite(interval.high) & ~interval.undefined
    return known


def by_id(ids: Interval, known: Bools, starts: Ints) -> Iterator[tuple[int, np.ndarray]]:
    """Each known id, and the boxes that have it; `starts` has one entry more than there are ids.

    Where a uniform number is held at its end, which it never is, a table names what is no id: nothing is known of that.
    """
    settled = known & (ids.low == ids.high)
    for value in sorted(set(ids.low[settled].tolist())):
        if value.is_integer() and 0.0 <= value < len(starts) - 1:
            yield int(value), np.flatnonzero(settled & (ids.low == value))


def unknown(*operands: Interval) -> Interval:
    """Any number; NaN only from a NaN."""
    count = len(operands[0].low)
    undefined = ~numbers(*operands)
    return Interval(np.full(count, -np.inf), np.full(count, np.inf), undefined)


def put(target: Interval, rows: np.ndarray, low: Floats, high: Floats) -> None:
    """Say in some boxes what is now known; the arrays of `target` are written to."""
    target.low[rows], target.high[rows], target.undefined[rows] = low, high, False


def at_least_zero(interval: Interval) -> Interval:
    return interval._replace(low=np.maximum(interval.low, 0.0))


def centre(x: Interval, y: Interval, rows: np.ndarray) -> tuple[tuple[Floats, Floats], Floats]:
    """Middles of boxes of points, and how far their corners are from them."""
    half_x, half_y = 0.5 * (x.high[rows] - x.low[rows]), 0.5 * (y.high[rows] - y.low[rows])
    return (x.low[rows] + half_x, y.low[rows] + half_y), np.hypot(half_x, half_y) + SLACK
