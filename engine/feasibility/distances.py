"""Distances of many points from regions and paths, in plain numpy: what bounds over boxes are made of."""

import math

import numpy as np

from engine.feasibility.intervals import Bools
from engine.tables import Floats, RoadTables

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
    to_ends = np.minimum(np.hypot(ahead, left), np.hypot(ahead - end[0], left - end[1]))
    return np.where(on, np.abs(np.hypot(ahead, radius - left) - abs(radius)), to_ends)
