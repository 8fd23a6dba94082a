"""Polygons and lines through points that are known at compile time.

A place in a polygon lies in one of its triangles, which is sampled by area (Devroye, "Non-Uniform Random Variate
Generation", 1986, chapter XI.2).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

from cortex_dsl.semantics.errors.scene import BAD_REGION
from cortex_dsl.semantics.evaluation import geometry
from cortex_dsl.semantics.evaluation.arguments import Given, items_of
from cortex_dsl.semantics.model.areas import Area, Draw, DrawnPlace, convex
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Pose, Quantity, Value, Vector
from cortex_dsl.semantics.quantities.algebra import Term, hypot, maximum, minimum, sqrt, table, where
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.source import Span

MOST_CORNERS = 100
"""Maximum number of corners of a polygon, or points of a line: each costs some ten operations per use of the region."""
FARTHEST = 1e9
"""How far from the origin a region may reach [m]: beyond, areas are no numbers."""
ON_A_LINE = 1e-6
"""How near a line a point lies that lies on it [m]."""

Known = tuple[float, float]


def _points(ev: Evaluator, given: Given, least: int, what: str) -> list[Known]:
    found: list[Known] = []
    for item in items_of(given.value, given.span, "the points"):
        place = geometry.position(ev, item, given.span)
        x, y = (ev.constant(Quantity(each, LENGTH), given.span, "a point of a region") for each in (place.x, place.y))
        if max(abs(x), abs(y)) > FARTHEST:
            raise BAD_REGION.mistake(given.span, what=what, reason=f"a point of it lies beyond {FARTHEST:g} m")
        if not found or (x, y) != found[-1]:
            found.append((x, y))
    if not least <= len(found) <= MOST_CORNERS:
        reason = f"{what} has {least} to {MOST_CORNERS} different points, and this one {len(found)}"
        raise BAD_REGION.mistake(given.span, what=what, reason=reason)
    return found


def _turn(a: Known, b: Known, c: Known) -> float:
    """Twice the area of a triangle; positive anticlockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _crosses(a: Known, b: Known, c: Known, d: Known) -> bool:
    return _turn(a, b, c) * _turn(a, b, d) < 0.0 and _turn(c, d, a) * _turn(c, d, b) < 0.0


def _ring(ev: Evaluator, given: Given) -> list[Known]:
    """The corners of a polygon, anticlockwise."""
    what = "a polygon"
    corners = _points(ev, given, 3, what)
    if corners[0] == corners[-1]:
        corners.pop()
    count = len(corners)
    edges = [(corners[i], corners[(i + 1) % count]) for i in range(count)]
    if any(_crosses(*edges[i], *edges[j]) for i in range(count) for j in range(i)):
        raise BAD_REGION.mistake(given.span, what=what, reason="its edges cross one another")
    area = math.fsum(a[0] * b[1] - a[1] * b[0] for a, b in edges)
    if count < 3 or area == 0.0:
        raise BAD_REGION.mistake(given.span, what=what, reason="all of its corners lie on one line")
    return corners if area > 0.0 else corners[::-1]


def _triangles(corners: Sequence[Known]) -> list[tuple[Known, Known, Known]]:
    """Cut ears off until a triangle is left (Meisters, "Polygons have ears", 1975)."""
    left, found = list(corners), []
    while len(left) > 3:
        count = len(left)
        ear = next((i for i in range(count) if _is_ear(left, i)), 0)
        found.append((left[ear - 1], left[ear], left[(ear + 1) % count]))
        left.pop(ear)
    return [each for each in (*found, (left[0], left[1], left[2])) if _turn(*each) > 0.0]


def _is_ear(left: Sequence[Known], at: int) -> bool:
    a, b, c = left[at - 1], left[at], left[(at + 1) % len(left)]
    others = [each for each in left if each not in (a, b, c)]
    inside = (min(_turn(a, b, p), _turn(b, c, p), _turn(c, a, p)) >= 0.0 for p in others)
    return _turn(a, b, c) >= 0.0 and not any(inside)


def _chosen(ev: Evaluator, number: Term, weights: Sequence[float]) -> Callable[[Sequence[float]], Term]:
    """Return a function that selects an entry of a column by a uniform number, with probability by weight."""
    total, index = math.fsum(weights), ev.algebra.literal(0.0)
    for share in list(accumulate(weights))[:-1]:
        index = index + where(number < share / total, 0.0, 1.0)
    return lambda column: table(index, ev.file.pool.offset(tuple(column)))


def _off_segment(point: Vector, a: Known, b: Known) -> Term:
    """Distance of a point from a segment [m]."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    share = ((point.x - a[0]) * dx + (point.y - a[1]) * dy) / (dx * dx + dy * dy)
    at = minimum(maximum(share, 0.0), 1.0)
    return hypot(point.x - (at * dx + a[0]), point.y - (at * dy + a[1]))


def _nearest(point: Vector, edges: Sequence[tuple[Known, Known]]) -> Term:
    result = _off_segment(point, *edges[0])
    for edge in edges[1:]:
        result = minimum(result, _off_segment(point, *edge))
    return result


def polygon(ev: Evaluator, points: Given, _span: Span) -> Value:
    corners = _ring(ev, points)
    edges = [*pairwise(corners), (corners[-1], corners[0])]
    triangles = _triangles(corners)
    sizes = [0.5 * _turn(*each) for each in triangles]
    is_convex = all(_turn(a, b, c) >= 0.0 for (a, b), (_, c) in zip(edges, [*edges[1:], edges[0]], strict=True))

    def contains(point: Vector) -> Term:
        return _left_of_all(ev, point, edges) if is_convex else _by_parity(ev, point, edges)

    def draw(uniform: Draw) -> DrawnPlace:
        of, far, across = _chosen(ev, uniform(), sizes), sqrt(uniform()), uniform()

        def coordinate(axis: int) -> Term:
            a, b, c = (of([corner[axis] for corner in each]) for each in zip(*triangles, strict=True))
            return a + far * ((b - a) + across * (c - b))

        return DrawnPlace(Vector(coordinate(0), coordinate(1)))

    area = Area(
        "a polygon",
        contains,
        draw=draw,
        weight=ev.algebra.literal(math.fsum(sizes)),
        distance=lambda point: where(contains(point), 0.0, _nearest(point, edges)),
        corners=[Vector(ev.algebra.literal(x), ev.algebra.literal(y)) for x, y in corners],
    )
    return convex(area) if is_convex else replace(area, holds=lambda outline: _held(area, edges, outline))


def _left_of_all(ev: Evaluator, point: Vector, edges: Sequence[tuple[Known, Known]]) -> Term:
    """Return whether a point lies in a convex polygon: to the left of each edge."""
    result: Term = ev.algebra.truth(True)
    for a, b in edges:
        result = result & ((point.y - a[1]) * (b[0] - a[0]) >= (point.x - a[0]) * (b[1] - a[1]))
    return result


def _by_parity(ev: Evaluator, point: Vector, edges: Sequence[tuple[Known, Known]]) -> Term:
    """Return whether a point lies in a polygon: a ray to the east crosses an odd number of its edges."""
    count: Term = ev.algebra.literal(0.0)
    for a, b in edges:
        low, high = sorted((a, b), key=lambda corner: corner[1])
        if low[1] == high[1]:
            continue
        between_ends = (point.y >= low[1]) & (point.y < high[1])
        west = (point.x - low[0]) * (high[1] - low[1]) < (point.y - low[1]) * (high[0] - low[0])
        count = count + where(between_ends & west, 1.0, 0.0)
    return count % 2.0 >= 0.5


def _held(area: Area, edges: Sequence[tuple[Known, Known]], outline: Sequence[Vector]) -> Term:
    """Return whether an outline lies in a polygon: a corner of it does, and no edges cross."""
    result = area.contains(outline[0])
    for one, other in zip(outline, (*outline[1:], outline[0]), strict=True):
        for a, b in edges:
            result = result & ~_meet(one, other, a, b)
    return result


def _meet(one: Vector, other: Vector, a: Known, b: Known) -> Term:
    """Return whether two segments cross."""

    def side(point: Vector) -> Term:
        return (point.y - a[1]) * (b[0] - a[0]) - (point.x - a[0]) * (b[1] - a[1])

    def across(corner: Known) -> Term:
        return (other.x - one.x) * (corner[1] - one.y) - (other.y - one.y) * (corner[0] - one.x)

    return (side(one) * side(other) < 0.0) & (across(a) * across(b) < 0.0)


def polyline(ev: Evaluator, points: Given, _span: Span) -> Value:
    corners = _points(ev, points, 2, "a line")
    edges = list(pairwise(corners))
    lengths = [math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in edges]
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in edges]
    literal, total = ev.algebra.literal, math.fsum(lengths)

    def draw(uniform: Draw) -> DrawnPlace:
        of, share = _chosen(ev, uniform(), lengths), uniform()
        ends = [[of([corner[axis] for corner in each]) for each in zip(*edges, strict=True)] for axis in (0, 1)]
        x, y = (start + share * (end - start) for start, end in ends)
        return DrawnPlace(Vector(x, y), of(headings))

    def end(corner: Known, heading: float) -> Pose:
        return Pose(literal(corner[0]), literal(corner[1]), literal(heading))

    return Area(
        "a line",
        lambda point: _nearest(point, edges) <= ON_A_LINE,
        holds=lambda _: ev.algebra.truth(False),
        draw=draw,
        weight=literal(total),
        distance=lambda point: _nearest(point, edges),
        attributes={
            "start": end(corners[0], headings[0]),
            "end": end(corners[-1], headings[-1]),
            "length": Quantity(literal(total), LENGTH),
        },
    )
