"""Interval versions of the instructions about paths.

A path's pose over an arc-length interval is exact on straight lines and held by the sagitta on arcs. The distance to it
changes no faster than the point moves (it is 1-Lipschitz), so over a box it lies within half the box's diagonal of its
value at the centre.
"""

from collections.abc import Sequence

import numpy as np

from engine.feasibility.distances import COS, CURVATURE, HEADING, LENGTH, S0, SIN, X, Y, path_distance, path_primitives
from engine.feasibility.intervals import Interval, between
from engine.feasibility.places import SLACK, at_least_zero, by_id, centre, numbers, put, unknown
from engine.tables import Floats, RoadTables


def path_pose(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    path, s = operands
    results = [unknown(*operands) for _ in range(3)]
    for number, rows in by_id(path, numbers(path) & ~s.undefined):
        for result, (low, high) in zip(results, _pose_hull(road, number, s.low[rows], s.high[rows]), strict=True):
            put(result, rows, low - SLACK, high + SLACK)
    return results


def _pose_hull(road: RoadTables, path: int, start: Floats, end: Floats) -> list[tuple[Floats, Floats]]:
    """Ends of x, y and heading over arc lengths [start, end], held inside the path."""
    primitives = path_primitives(road, path)
    start = np.clip(start, 0.0, road.path_length[path])
    end = np.clip(end, 0.0, road.path_length[path])
    hull = [(np.full(len(start), np.inf), np.full(len(start), -np.inf)) for _ in range(3)]
    for primitive in primitives:
        low = np.clip(start - primitive[S0], 0.0, primitive[LENGTH])
        high = np.clip(end - primitive[S0], 0.0, primitive[LENGTH])
        touched = (end >= primitive[S0] - SLACK) & (start <= primitive[S0] + primitive[LENGTH] + SLACK)
        touched |= len(primitives) == 1
        for axis, (least, greatest) in enumerate(_primitive_hull(primitive, low, high)):
            known = hull[axis]
            hull[axis] = (
                np.where(touched, np.minimum(known[0], least), known[0]),
                np.where(touched, np.maximum(known[1], greatest), known[1]),
            )
    return hull


def _primitive_hull(primitive: Floats, low: Floats, high: Floats) -> list[tuple[Floats, Floats]]:
    """The chord's box, widened by the arc's height above the chord."""
    x0, y0 = _place(primitive, low)
    x1, y1 = _place(primitive, high)
    curvature = primitive[CURVATURE]
    height = np.zeros(len(low))
    if curvature != 0.0:
        half = np.minimum(0.5 * abs(curvature) * (high - low), np.pi)
        height = (1.0 - np.cos(half)) / abs(curvature)
    angles = primitive[HEADING] + curvature * low, primitive[HEADING] + curvature * high
    return [
        (np.minimum(x0, x1) - height, np.maximum(x0, x1) + height),
        (np.minimum(y0, y1) - height, np.maximum(y0, y1) + height),
        (np.minimum(*angles), np.maximum(*angles)),
    ]


def _place(primitive: Floats, along: Floats) -> tuple[Floats, Floats]:
    curvature, cos, sin = primitive[CURVATURE], primitive[COS], primitive[SIN]
    ahead, left = along, np.zeros(len(along))
    if curvature != 0.0:
        angle = curvature * along
        ahead, left = np.sin(angle) / curvature, 2.0 * np.square(np.sin(0.5 * angle)) / curvature
    return primitive[X] + ahead * cos - left * sin, primitive[Y] + ahead * sin + left * cos


def path_length_of(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    (path,) = operands
    result = between(0.0, float(road.path_length.max(initial=0.0)), len(path.low))
    for number, rows in by_id(path, numbers(path)):
        put(result, rows, road.path_length[number], road.path_length[number])
    return [result]


def distance_to_path(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    path, x, y = operands
    result = at_least_zero(unknown(*operands))
    for number, rows in by_id(path, numbers(*operands)):
        middle, reach = centre(x, y, rows)
        distance = path_distance(path_primitives(road, number), *middle)
        put(result, rows, np.maximum(distance - reach, 0.0), distance + reach)
    return [result]


def projection(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    path, *point = operands
    result = between(0.0, float(road.path_length.max(initial=0.0)), len(path.low))
    for number, rows in by_id(path, numbers(path)):
        put(result, rows, np.zeros(len(rows)), np.full(len(rows), road.path_length[number]))
    return [result._replace(undefined=~numbers(*point))]
