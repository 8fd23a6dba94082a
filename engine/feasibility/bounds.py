"""The interval version of every geometry instruction.

Path and region ids are known numbers in nearly every program; for an unknown id the result is unbounded.

A path's pose over an arc-length interval is exact on straight lines and bounded by the sagitta on arcs. The distance to
it is 1-Lipschitz, so over a box it differs from its value at the centre by at most half the box's diagonal. Outlines
are rectangles (x, y, heading, length, width). Containment in a region is known only if the distance decides it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from engine.feasibility.distances import (
    COS,
    CURVATURE,
    HEADING,
    LENGTH,
    S0,
    SIN,
    SLACK,
    X,
    Y,
    at_least_zero,
    boundary_distance,
    by_id,
    centre,
    numbers,
    path_distance,
    path_primitives,
    put,
    region_edges,
    unknown,
)
from engine.opcodes import Op
from engine.operators.intervals import Bools, Interval, between, either, everything, truth
from engine.tables import Floats, RoadTables

# -- paths -------------------------------------------------------------------------------------------------------------


def path_pose(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    path, s = operands
    results = [unknown(*operands) for _ in range(3)]
    for number, rows in by_id(path, numbers(path) & ~s.undefined, road.path_start):
        for result, (low, high) in zip(results, _pose_hull(road, number, s.low[rows], s.high[rows]), strict=True):
            put(result, rows, low - SLACK, high + SLACK)
    return results


def _pose_hull(road: RoadTables, path: int, start: Floats, end: Floats) -> list[tuple[Floats, Floats]]:
    """Return the ends of x, y and heading over arc lengths [start, end], clipped to the path."""
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
    """Return the box of the chord, extended by the sagitta of the arc."""
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
    for number, rows in by_id(path, numbers(path), road.path_start):
        put(result, rows, road.path_length[number], road.path_length[number])
    return [result]


def distance_to_path(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    path, x, y = operands
    result = at_least_zero(unknown(*operands))
    for number, rows in by_id(path, numbers(*operands), road.path_start):
        middle, reach = centre(x, y, rows)
        distance = path_distance(path_primitives(road, number), *middle)
        put(result, rows, np.maximum(distance - reach, 0.0), distance + reach)
    return [result]


def projection(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    path, *point = operands
    result = between(0.0, float(road.path_length.max(initial=0.0)), len(path.low))
    for number, rows in by_id(path, numbers(path), road.path_start):
        put(result, rows, np.zeros(len(rows)), np.full(len(rows), road.path_length[number]))
    return [result._replace(undefined=~numbers(*point))]


# -- outlines ----------------------------------------------------------------------------------------------------------


def outline_points(box: Sequence[Interval]) -> Iterator[tuple[Interval, Interval]]:
    """Yield boxes around the centre of an outline and around its four corners."""
    x, y, heading, length, width = box
    known = numbers(*box)
    middle, turn = 0.5 * (heading.low + heading.high), 0.5 * (heading.high - heading.low)
    half = 0.25 * (length.low + length.high), 0.25 * (width.low + width.high)
    reach = np.hypot(*half)
    # A turn moves a corner along its circle; a change of size moves it along the sides.
    moved = turn * reach + 0.25 * (length.high - length.low) + 0.25 * (width.high - width.low) + SLACK
    for along, across in ((0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        ahead, left = along * half[0], across * half[1]
        shift = ahead * np.cos(middle) - left * np.sin(middle), ahead * np.sin(middle) + left * np.cos(middle)
        margin = np.zeros(len(moved)) if along == 0.0 else moved
        yield (
            Interval(x.low + shift[0] - margin, x.high + shift[0] + margin, ~known),
            Interval(y.low + shift[1] - margin, y.high + shift[1] + margin, ~known),
        )


def largest(size: Interval) -> Floats:
    return np.maximum(np.abs(size.low), np.abs(size.high))


def circles(box: Sequence[Interval]) -> tuple[Floats, Floats]:
    """Return the radii of an inner and an outer circle of an outline."""
    least = np.maximum(np.minimum(box[3].low, box[4].low), 0.0)
    return 0.5 * least, 0.5 * np.hypot(largest(box[3]), largest(box[4]))


def _between_centres(a: Sequence[Interval], b: Sequence[Interval]) -> tuple[Floats, Floats]:
    """Return the least and greatest distance between two points."""
    gaps = [np.maximum(np.maximum(p.low - q.high, q.low - p.high), 0.0) for p, q in zip(a[:2], b[:2], strict=True)]
    spans = [np.maximum(p.high - q.low, q.high - p.low) for p, q in zip(a[:2], b[:2], strict=True)]
    return np.hypot(*gaps) - SLACK, np.hypot(*spans) + SLACK


def between_outlines(_road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    a, b = operands[:5], operands[5:]
    known = numbers(*operands)
    near, far = _between_centres(a, b)
    (inner_a, outer_a), (inner_b, outer_b) = circles(a), circles(b)
    low = np.where(known, np.maximum(near - outer_a - outer_b, 0.0), 0.0)
    high = np.where(known, np.maximum(far - inner_a - inner_b, 0.0), np.inf)
    return [Interval(low, high, ~known)]


def sees(_road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    viewer, outline = operands[:6], operands[6:]
    near = _between_centres(viewer, outline)[0] - circles(outline)[1]
    never = numbers(*operands) & (near > viewer[4].high)
    return [truth(np.zeros(len(never), dtype=bool), never, either(*operands))]


# -- regions -----------------------------------------------------------------------------------------------------------


def _off_region(road: RoadTables, region: Interval, x: Interval, y: Interval) -> tuple[Interval, Interval]:
    """Return the distance from outside, and the signed distance to the boundary (negative inside)."""
    off = at_least_zero(unknown(region, x, y))
    depth = Interval(np.full(len(x.low), -np.inf), np.full(len(x.low), np.inf), off.undefined.copy())
    for number, rows in by_id(region, numbers(region, x, y), road.region_start):
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
    return [truth((depth.low > 0.0) & ~depth.undefined, off.low > 0.0, either(x, y))]


def contains_outline(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    region, *box = operands
    reach, undefined = 0.5 * np.hypot(largest(box[3]), largest(box[4])), either(*box)
    sure, never = _in_core(road, region, box[0], box[1], reach) & numbers(*box), np.zeros(len(reach), dtype=bool)
    rows = np.flatnonzero(~sure)
    if len(rows):
        region, *box = (Interval(i.low[rows], i.high[rows], i.undefined[rows]) for i in operands)
        places = [(region, x, y) for x, y in outline_points(box)]
        together = (Interval(*map(np.concatenate, zip(*each, strict=True))) for each in zip(*places, strict=True))
        off, _ = _off_region(road, *together)
        never[rows] = (off.low > 0.0).reshape(len(places), -1).any(axis=0)
    return [truth(sure, never, undefined)]


def _in_core(road: RoadTables, region: Interval, x: Interval, y: Interval, reach: Floats) -> Bools:
    """Return (n,) True where the disc of radius `reach` is inside one of the rectangles that the region contains."""
    inside = np.zeros(len(reach), dtype=bool)
    for number, rows in by_id(region, numbers(region, x, y), road.region_start):
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
    for number, rows in by_id(region, numbers(*operands), road.region_start):
        triangles = road.triangles[road.triangle_start[number] : road.triangle_start[number + 1]]
        before = np.concatenate([[0.0], triangles[:-1, 0]])
        met = (share.high[rows, np.newaxis] >= before) & (share.low[rows, np.newaxis] <= triangles[:, 0])
        met[:, -1] |= ~met.any(axis=1)
        for result, corners in zip(results, (triangles[:, 1::2], triangles[:, 2::2]), strict=True):
            low = np.where(met, corners.min(axis=1), np.inf).min(axis=1)
            high = np.where(met, corners.max(axis=1), -np.inf).max(axis=1)
            put(result, rows, low - SLACK, high + SLACK)
    return results


# -- the tables --------------------------------------------------------------------------------------------------------

Geometry = Callable[[RoadTables, Sequence[Interval]], Sequence[Interval]]


def _one_of(count: Callable[[RoadTables], int]) -> Geometry:
    return lambda road, operands: [between(0.0, count(road) - 1.0, len(operands[0].low))]


def _heading(road: RoadTables, operands: Sequence[Interval]) -> Sequence[Interval]:
    """Return the interval of headings of all paths, at all of their points [rad]."""
    headings = np.abs(road.primitives[:, HEADING]) + np.abs(road.primitives[:, CURVATURE]) * road.primitives[:, LENGTH]
    most = float(headings.max(initial=0.0)) + SLACK
    return [between(-most, most, len(operands[0].low))._replace(undefined=either(*operands))]


def _any(width: int) -> Geometry:
    return lambda _road, operands: [everything(len(operands[0].low)) for _ in range(width)]


GEOMETRY: Mapping[Op, Geometry] = {
    Op.PATH_POSE: path_pose,
    Op.PATH_LENGTH: path_length_of,
    Op.PATH_DISTANCE: distance_to_path,
    Op.PATH_PROJECT: projection,
    Op.REGION_SAMPLE: sampled,
    Op.REGION_DISTANCE: distance_to_region,
    Op.REGION_CONTAINS: contains,
    Op.REGION_CONTAINS_BOX: contains_outline,
    Op.REGION_BOX_DISTANCE: outline_to_region,
    Op.BOX_DISTANCE: between_outlines,
    Op.CAN_SEE: sees,
    Op.ROAD_HEADING: _heading,
    Op.ROAD_FOLLOW: _any(3),
    Op.LANE_ROUTE: _one_of(lambda road: len(road.path_length)),
    Op.LANE_NEAREST: _one_of(lambda road: len(road.lane_path)),
}
