"""Interval versions of the instructions about regions: containment is said only where the distance decides it."""

from collections.abc import Sequence

import numpy as np

from engine.feasibility.distances import boundary_distance, region_edges
from engine.feasibility.intervals import Bools, Interval, truth
from engine.feasibility.outline_bounds import circles, largest, outline_points
from engine.feasibility.places import SLACK, at_least_zero, by_id, centre, numbers, put, unknown
from engine.tables import Floats, RoadTables


def _off_region(road: RoadTables, region: Interval, x: Interval, y: Interval) -> tuple[Interval, Interval]:
    """Distance from outside, and from inside to the boundary (negative: depth below which nothing is known)."""
    off = at_least_zero(unknown(region, x, y))
    depth = Interval(np.full(len(x.low), -np.inf), np.full(len(x.low), np.inf), off.undefined.copy())
    for number, rows in by_id(region, numbers(region, x, y)):
        middle, reach = centre(x, y, rows)
        distance, inside = boundary_distance(region_edges(road, number), *middle)
        outward = np.where(inside, -distance, distance)
        put(off, rows, np.maximum(outward - reach, 0.0), np.maximum(outward + reach, 0.0))
        put(depth, rows, -outward - reach, -outward + reach)
    return off, depth


def distance_to_region(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    region, x, y = operands
    return [_off_region(road, region, x, y)[0]]


def contains(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    region, x, y = operands
    off, depth = _off_region(road, region, x, y)
    return [truth((depth.low > 0.0) & ~depth.undefined, off.low > 0.0)]


def contains_outline(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    region, *box = operands
    reach = 0.5 * np.hypot(largest(box[3]), largest(box[4]))
    sure, never = _in_core(road, region, box[0], box[1], reach) & numbers(*box), np.zeros(len(reach), dtype=bool)
    rows = np.flatnonzero(~sure)
    if len(rows):
        region, *box = (Interval(i.low[rows], i.high[rows], i.undefined[rows]) for i in operands)
        for x, y in outline_points(box):
            never[rows] |= _off_region(road, region, x, y)[0].low > 0.0
    return [truth(sure, never)]


def _in_core(road: RoadTables, region: Interval, x: Interval, y: Interval, reach: Floats) -> Bools:
    """Whether all within reach of the point lies in one of the rectangles that are known to be inside."""
    inside = np.zeros(len(reach), dtype=bool)
    for number, rows in by_id(region, numbers(region, x, y)):
        margin = reach[rows] + SLACK
        for x1, y1, x2, y2 in road.cores[road.core_start[number] : road.core_start[number + 1]]:
            wide = (x1 <= x.low[rows] - margin) & (x.high[rows] + margin <= x2)
            inside[rows] |= wide & (y1 <= y.low[rows] - margin) & (y.high[rows] + margin <= y2)
    return inside


def outline_to_region(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    region, *box = operands
    off = _off_region(road, region, box[0], box[1])[0]
    inner, outer = circles(box)
    high = np.maximum(off.high - inner, 0.0) + SLACK
    return [Interval(np.maximum(off.low - outer - SLACK, 0.0), high, off.undefined | ~numbers(*box))]


def sampled(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    region, share, _ = operands
    results = [unknown(*operands) for _ in range(2)]
    for number, rows in by_id(region, numbers(*operands)):
        triangles = road.triangles[road.triangle_start[number] : road.triangle_start[number + 1]]
        before = np.concatenate([[0.0], triangles[:-1, 0]])
        met = (share.high[rows, np.newaxis] >= before) & (share.low[rows, np.newaxis] <= triangles[:, 0])
        met[:, -1] |= ~met.any(axis=1)
        for result, corners in zip(results, (triangles[:, 1::2], triangles[:, 2::2]), strict=True):
            low = np.where(met, corners.min(axis=1), np.inf).min(axis=1)
            high = np.where(met, corners.max(axis=1), -np.inf).max(axis=1)
            put(result, rows, low - SLACK, high + SLACK)
    return results
