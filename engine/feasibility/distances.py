"""What bounds over boxes are made of: distances of many points from regions and paths, and boxes of places.

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
"""Pairs of point and edge that are looked at together."""
MANY = 512
"""Edges from which on it pays to leave out those far away."""
SQUARE = 24.0
"""Side of the squares in which points are looked at together [m]."""


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
    found = _by_squares if len(edges) >= MANY and len(points) else _of_every_edge
    distance, inside = found(edges, points.real, points.imag)
    return distance[place], inside[place]


def _of_every_edge(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    return _nearest(edges, x, y), _enclosed(edges, x, y)


def _by_squares(edges: Floats, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    """The same square by square of the plane: only of edges that may be the nearest of a point in it, and of those that
    a ray to the right may cross. What is left out decides nothing, so the numbers are the same to the last bit.
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
    """Edges of which one is the nearest of each of the points: an edge is no nearer to a point than to the middle of
    all, but for what lies between the two; nor is the nearest further.
    """
    middle = 0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())
    off = np.sqrt(_off_squared(edges, *middle))
    between = np.hypot(x - middle[0], y - middle[1]).max()
    return ~(off > off.min(initial=np.inf) + 2.0 * between + SLACK)  # of what is NaN nothing is known


def _may_be_crossed(edges: Floats, x: Floats, y: Floats) -> Bools:
    """Edges that a ray from one of the points to the right may cross."""
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
    """Points as columns (n, 1), so few that pairs with all edges stay in the processor's cache."""
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
    angle = arctan2(ahead, radius - left) if curvature > 0.0 else arctan2(ahead, left - radius)
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
