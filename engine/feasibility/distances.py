"""Parts of the bounds over boxes: distances of many points from regions and paths, and boxes of places.

In plain numpy.
"""

import math
from collections.abc import Iterator

import numpy as np

from engine.operators.intervals import Bools, Interval
from engine.portable import arctan2
from engine.tables import Floats, Ints, RoadTables

S0, X, Y, HEADING, CURVATURE, LENGTH, COS, SIN = range(8)
"""Columns of `RoadTables.primitives`."""
CHUNK = 1 << 16
"""Pairs of point and edge that are processed together."""
MANY = 512
"""Number of edges from which on the exclusion of distant edges saves time."""
SQUARE = 24.0
"""Side of the squares in which points are processed together [m]."""


def region_edges(road: RoadTables, region: int) -> Floats:
    """Return (m, 4) x1, y1, x2, y2 of the edges of a region [m]."""
    return road.edges[road.region_start[region] : road.region_start[region + 1]]


def path_primitives(road: RoadTables, path: int) -> Floats:
    """Return (m, 8) the rows of `RoadTables.primitives` of a path."""
    return road.primitives[road.path_start[path] : road.path_start[path + 1]]


def boundary_distance(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    """Return the distance of points (n,) from the boundary of a region, and True for points inside (even-odd rule).

    Equal points are computed once: in slices of one variable's range, most places do not change.
    """
    points, place = np.unique(x + 1j * y, return_inverse=True)
    found = _by_squares if len(edges) >= MANY and len(points) else _of_every_edge
    distance, inside = found(edges, points.real, points.imag)
    return distance[place], inside[place]


def _of_every_edge(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    return _nearest(edges, x, y), _enclosed(edges, x, y)


def _by_squares(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    """Return the same as `_of_every_edge`, square by square of the plane.

    It uses only edges that may be nearest to a point of a square, and those that a ray to the right may cross. The
    omitted edges have no influence, so the numbers are the same to the last bit.
    """
    distance, inside = np.empty(len(x)), np.empty(len(x), dtype=bool)
    _, square = np.unique(np.floor(x / SQUARE) + 1j * np.floor(y / SQUARE), return_inverse=True)
    order = np.argsort(square, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(square[order])) + 1):
        there = x[rows], y[rows]
        distance[rows] = _nearest(edges[_may_be_nearest(edges, *there)], *there)
        inside[rows] = _enclosed(edges[_may_be_crossed(edges, *there)], *there)
    return distance, inside


def _may_be_nearest(edges: Floats, x: Floats, y: Floats) -> Bools:
    """Return (m,) True for edges that may be nearest to one of the points.

    By the triangle inequality, distances from a point and from the middle of all points differ by at most their
    distance.
    """
    middle = 0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())
    off = np.sqrt(_off_squared(edges, *middle))
    between = np.hypot(x - middle[0], y - middle[1]).max()
    return ~(off > off.min(initial=np.inf) + 2.0 * between + SLACK)  # NaN counts as possibly nearest


def _may_be_crossed(edges: Floats, x: Floats, y: Floats) -> Bools:
    """Return (m,) True for edges that a ray from one of the points to the right may cross."""
    x1, y1, x2, y2 = edges.T
    as_high = (np.minimum(y1, y2) <= y.max()) & (np.maximum(y1, y2) >= y.min())
    return as_high & (np.maximum(x1, x2) >= x.min() - SLACK)


def _nearest(edges: Floats, x: Floats, y: Floats) -> Floats:
    squares = (_off_squared(edges, *part).min(axis=1, initial=np.inf) for part in _in_chunks(edges, x, y))
    return np.sqrt(np.concatenate([*squares, np.zeros(0)]))


def _enclosed(edges: Floats, x: Floats, y: Floats) -> Bools:
    odd = (_crosses(edges, *part).sum(axis=1) % 2 == 1 for part in _in_chunks(edges, x, y))
    return np.concatenate([*odd, np.zeros(0, dtype=bool)])


def _in_chunks(edges: Floats, x: Floats, y: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Yield points as columns (n, 1), small enough that pairs with all edges fit into the processor's cache."""
    size = max(1, CHUNK // max(1, len(edges)))
    for start in range(0, len(x), size):
        yield x[start : start + size, np.newaxis], y[start : start + size, np.newaxis]


def _off_squared(edges: Floats, x: Floats, y: Floats) -> Floats:
    x1, y1, x2, y2 = edges.T
    ex, ey, dx, dy = x2 - x1, y2 - y1, x - x1, y - y1
    along = np.clip((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0, 1.0)
    return np.square(dx - along * ex) + np.square(dy - along * ey)


def _crosses(edges: Floats, x: Floats, y: Floats) -> Bools:
    x1, y1, x2, y2 = edges.T
    return ((y1 > y) != (y2 > y)) & (x1 + (y - y1) * (x2 - x1) / (y2 - y1) > x)


def path_distance(primitives: Floats, x: Floats, y: Floats) -> Floats:
    """Return the distance of points (n,) from a chain of lines and arcs."""
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
    angle = arctan2(ahead, radius - left) if curvature > 0.0 else arctan2(ahead, left - radius)
    on = (angle >= 0.0) & (angle <= length * abs(curvature))
    end = radius * math.sin(curvature * length), radius * (1.0 - math.cos(curvature * length))
    to_ends: Floats = np.minimum(np.hypot(ahead, left), np.hypot(ahead - end[0], left - end[1]))
    return np.where(on, np.abs(np.hypot(ahead, radius - left) - abs(radius)), to_ends)


# -- boxes of places ---------------------------------------------------------------------------------------------------

SLACK = 1e-7
"""Tolerance far above the rounding errors of these functions for roads of kilometres [m]."""


def numbers(*intervals: Interval) -> Bools:
    """Return (n,) True for boxes in which all intervals are finite and defined."""
    known = np.ones(len(intervals[0].low), dtype=bool)
    for interval in intervals:
        known &= np.isfinite(interval.low) & np.isfinite(interval.high) & ~interval.undefined
    return known


def by_id(ids: Interval, known: Bools, starts: Ints) -> Iterator[tuple[int, np.ndarray]]:
    """Yield each known id with the boxes that have it; `starts` has one entry more than there are ids.

    At the upper end of a uniform number, which the number never reaches, a table may name an invalid id; it is skipped.
    """
    settled = known & (ids.low == ids.high)
    for value in sorted(set(ids.low[settled].tolist())):
        if value.is_integer() and 0.0 <= value < len(starts) - 1:
            yield int(value), np.flatnonzero(settled & (ids.low == value))


def unknown(*operands: Interval) -> Interval:
    """Return the interval of any number; NaN only if an operand may be NaN."""
    count = len(operands[0].low)
    undefined = ~numbers(*operands)
    return Interval(np.full(count, -np.inf), np.full(count, np.inf), undefined)


def put(target: Interval, rows: np.ndarray, low: Floats, high: Floats) -> None:
    """Set the known bounds in some boxes; the arrays of `target` are modified."""
    target.low[rows], target.high[rows], target.undefined[rows] = low, high, False


def at_least_zero(interval: Interval) -> Interval:
    return interval._replace(low=np.maximum(interval.low, 0.0))


def centre(x: Interval, y: Interval, rows: np.ndarray) -> tuple[tuple[Floats, Floats], Floats]:
    """Return the centres of boxes of points, and the distances of their corners from them."""
    half_x, half_y = 0.5 * (x.high[rows] - x.low[rows]), 0.5 * (y.high[rows] - y.low[rows])
    return (x.low[rows] + half_x, y.low[rows] + half_y), np.hypot(half_x, half_y) + SLACK
