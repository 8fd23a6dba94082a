"""Regions, fields and the workspace that a file makes: `CircularRegion(...)`, `VectorField(...)`, `Workspace(...)`.

A place in a circle or a sector lies at the square root of a uniform share of the radius. Combinations of two regions
are sampled by rejection, with the scene.
Source: Scenic 3 reference, "Region Types".
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

from cortex_dsl.semantics.errors.scene import BAD_REGION
from cortex_dsl.semantics.errors.values import MANY_REGIONS, WRONG_KIND
from cortex_dsl.semantics.evaluation import geometry
from cortex_dsl.semantics.evaluation.arguments import Given, items_of, no_names
from cortex_dsl.semantics.evaluation.functions import Meaning, whole_number
from cortex_dsl.semantics.evaluation.geometry import between, moved
from cortex_dsl.semantics.evaluation.numbers import adopt
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.model.areas import Area, Coordinates, Draw, DrawnPlace, convex
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    Closure,
    DirectionField,
    Function,
    Pose,
    Quantity,
    Truth,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    cos,
    hypot,
    maximum,
    minimum,
    region_contains_box,
    sin,
    sqrt,
    table,
    where,
    wrapped,
)
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH
from cortex_dsl.source import Span

# -- polygons ----------------------------------------------------------------------------------------------------------


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
            result = result & ~_cross(one, other, a, b)
    return result


def _cross(one: Vector, other: Vector, a: Known, b: Known) -> Term:
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


CORNERS = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
"""Corners of a rectangle in order: shares of its width to the right and of its length ahead."""

# -- convex regions ----------------------------------------------------------------------------------------------------


def _length(ev: Evaluator, given: Given, what: str) -> Term:
    value = adopt(ev, given.value, LENGTH, given.span, what)
    return in_range(ev, value, Domain(what, LENGTH, 0.0, FARTHEST, above=True), given.span)


def _circle(ev: Evaluator, center: Given, radius: Given, _span: Span) -> Value:
    middle, reach = geometry.position(ev, center.value, center.span), _length(ev, radius, "`radius`")

    def draw(uniform: Draw) -> DrawnPlace:
        far, turned = reach * sqrt(uniform()), uniform() * math.tau
        return DrawnPlace(Vector(middle.x + far * cos(turned), middle.y + far * sin(turned)))

    return convex(
        Area(
            "a circular region",
            lambda point: between(middle, point) <= reach,
            draw=draw,
            weight=reach * reach * math.pi,
            distance=lambda point: maximum(between(middle, point) - reach, 0.0),
            attributes={"center": middle, "radius": Quantity(reach, LENGTH)},
        )
    )


def _sector(ev: Evaluator, center: Given, radius: Given, heading: Given, angle: Given, _span: Span) -> Value:
    middle, reach = geometry.position(ev, center.value, center.span), _length(ev, radius, "`radius`")
    ahead = geometry.heading_at(ev, heading.value, middle, heading.span)
    opening = adopt(ev, angle.value, ANGLE, angle.span, "`angle`")
    opening = in_range(ev, opening, Domain("`angle`", ANGLE, 0.0, math.tau, above=True), angle.span)
    return _opening(ev, middle, reach, ahead, opening)


def visible_region(ev: Evaluator, viewer: Actor | Pose | Vector) -> Area:
    """Return the region that is visible from an object or a place without occlusion."""
    pose, view = geometry.looking(ev, viewer), geometry.view_of(ev, viewer)
    return _opening(ev, Vector(pose.x, pose.y), view.reach, pose.heading, view.opening)


def _opening(ev: Evaluator, middle: Vector, reach: Term, ahead: Term, opening: Term) -> Area:
    def contains(point: Vector) -> Term:
        off = abs(wrapped(geometry.bearing(middle, point) - ahead))
        return (between(middle, point) <= reach) & (off <= opening * 0.5)

    def draw(uniform: Draw) -> DrawnPlace:
        far, turned = reach * sqrt(uniform()), ahead + opening * (uniform() - 0.5)
        return DrawnPlace(Vector(middle.x + far * cos(turned), middle.y + far * sin(turned)))

    known = {"center": middle, "radius": Quantity(reach, LENGTH), "angle": Quantity(opening, ANGLE)}
    area = Area("a sector", contains, draw=draw, weight=reach * reach * opening * 0.5, attributes=known)
    least, most = ev.interval(opening)
    return convex(area) if most <= math.pi or least >= math.tau else area


def _rectangle(ev: Evaluator, position: Given, heading: Given, width: Given, length: Given, _span: Span) -> Value:
    middle = geometry.position(ev, position.value, position.span)
    ahead = geometry.heading_at(ev, heading.value, middle, heading.span)
    across, along = _length(ev, width, "`width`"), _length(ev, length, "`length`")

    def beyond(point: Vector) -> tuple[Term, Term]:
        """How far beyond the sides and the ends."""
        x, y, c, s = point.x - middle.x, point.y - middle.y, cos(ahead), sin(ahead)
        return abs(x * s - y * c) - across * 0.5, abs(x * c + y * s) - along * 0.5

    def contains(point: Vector) -> Term:
        side, end = beyond(point)
        return (side <= 0.0) & (end <= 0.0)

    def distance(point: Vector) -> Term:
        side, end = beyond(point)
        return hypot(maximum(side, 0.0), maximum(end, 0.0))

    def draw(uniform: Draw) -> DrawnPlace:
        right, forward = (uniform() - 0.5) * across, (uniform() - 0.5) * along
        return DrawnPlace(moved(middle, ahead, right, forward))

    known = {
        "position": middle,
        "heading": Quantity(geometry.as_written(ev, ahead), ANGLE),
        "width": Quantity(across, LENGTH),
        "length": Quantity(along, LENGTH),
    }
    corners = tuple(moved(middle, ahead, x * across, y * along) for x, y in CORNERS)
    area = Area("a rectangle", contains, draw=draw, weight=across * along, distance=distance, attributes=known)
    outline = ev.algebra.pack(middle.x, middle.y, ahead, along, across)
    return convex(replace(area, corners=corners, outline=outline))


MOST_PARTS = 64
"""Maximum number of regions that a region consists of."""

# -- of several --------------------------------------------------------------------------------------------------------


def _union(one: Area, other: Area) -> Area:
    joined = Area(
        "a union of regions",
        lambda point: one.contains(point) | other.contains(point),
        parts=one.parts + other.parts,
        distance=_least(one.distance, other.distance),
    )
    first, second, first_weight, second_weight = one.draw, other.draw, one.weight, other.weight
    if first is None or second is None or first_weight is None or second_weight is None:
        return joined
    weight = first_weight + second_weight

    def draw(uniform: Draw) -> DrawnPlace:
        """A place in both comes up twice as often, so that only each second of those counts."""
        of_first = uniform() * weight < first_weight
        left, right = first(uniform), second(uniform)
        point = Vector(where(of_first, left.point.x, right.point.x), where(of_first, left.point.y, right.point.y))
        accepted = (uniform() < 0.5) | ~(one.contains(point) & other.contains(point))
        if left.accepted is not None or right.accepted is not None:
            always = accepted.algebra.truth(True)
            of_each = (always if each.accepted is None else each.accepted for each in (left, right))
            accepted = accepted & where(of_first, *of_each)
        return DrawnPlace(point, None, accepted)

    return replace(joined, draw=draw, weight=weight)


def _least(
    one: Callable[[Vector], Term] | None, other: Callable[[Vector], Term] | None
) -> Callable[[Vector], Term] | None:
    if one is None or other is None:
        return None
    return lambda point: minimum(one(point), other(point))


def _within(one: Area, other: Area, *, inside: bool) -> Area:
    """Return the part of a region that lies inside another region, or outside it."""

    def contains(point: Vector) -> Term:
        there = other.contains(point)
        return one.contains(point) & (there if inside else ~there)

    def draw(uniform: Draw) -> DrawnPlace:
        assert one.draw is not None
        spot = one.draw(uniform)
        there = other.contains(spot.point) if inside else ~other.contains(spot.point)
        return replace(spot, accepted=there if spot.accepted is None else spot.accepted & there)

    first, second = one.holds, other.holds
    both = None if first is None or second is None else lambda outline: first(outline) & second(outline)
    name = "an intersection of regions" if inside else "a difference of regions"
    return Area(
        name, contains, both if inside else None, draw if one.draw else None, one.weight, parts=one.parts + other.parts
    )


_JOINED: Mapping[str, Callable[[Area, Area], Area]] = {
    "union": _union,
    "intersect": lambda one, other: (
        _within(other, one, inside=True) if one.draw is None else _within(one, other, inside=True)
    ),
    "difference": lambda one, other: _within(one, other, inside=False),
}


def attribute(ev: Evaluator, area: Area, name: str) -> Value | None:
    """`region.union` and the like; None where a region has no such attribute."""
    if name in _JOINED:

        def join(other: Value) -> Value:
            joined = _JOINED[name](area, _area(other, ev.algebra.span))
            if joined.parts > MOST_PARTS:
                raise MANY_REGIONS.mistake(ev.algebra.span, limit=MOST_PARTS)
            return joined

        return Closure(("other",), join)
    if name == "containsRegion":
        return Closure(("other",), lambda other: _contains_region(ev, area, other))
    return area.attributes.get(name)


def _contains_region(ev: Evaluator, area: Area, other: Value) -> Value:
    """Return whether a value with corners lies in a region as an outline does."""
    span = ev.algebra.span
    inner = _area(other, span)
    if area.holds is None or inner.corners is None:
        what = "the region in `containsRegion`" if inner.corners is None else "what has `containsRegion`"
        cure = "as in `CircularRegion((0, 0), 50).containsRegion(RectangularRegion((0, 0), 0, 4, 9))`"
        expected = "a rectangle" if inner.corners is None else "a circle, a rectangle or a polygon"
        raise WRONG_KIND.mistake(span, what=what, expected=expected, actual=kind_name(other), cure=cure)
    return Truth(area.holds(inner.corners))


def contains_rectangle(ev: Evaluator, region: int, other: Value) -> Value:
    """Return whether a rectangle lies in a region of the map, given by its index."""
    if not isinstance(other, Area) or other.outline is None:
        cure = "as in `road.containsRegion(RectangularRegion((0, 0), 0, 4, 9))`"
        what = "the region in `containsRegion` of a region of the map"
        raise WRONG_KIND.mistake(ev.algebra.span, what=what, expected="a rectangle", actual=kind_name(other), cure=cure)
    return Truth(region_contains_box(float(region), other.outline))


attribute_names = (*_JOINED, "containsRegion")


def _area(value: Value, span: Span) -> Area:
    if not isinstance(value, Area):
        cure = "as in `CircularRegion((0, 0), 20)`; a region of the map does not do"
        raise WRONG_KIND.mistake(span, what="this", expected="a region of the file", actual=kind_name(value), cure=cure)
    return value


# -- fields and the workspace ------------------------------------------------------------------------------------------


def _field(ev: Evaluator, _name: Given, value: Given, least: Given | None, step: Given | None, _span: Span) -> Value:
    """A heading at every point, as a function of the file gives it."""
    function = value.value

    def at(point: Vector) -> Term:
        coordinates = Coordinates(point.x, point.y)
        if isinstance(function, Closure) and len(function.parameters) == 1:
            heading = function.apply(coordinates)
        elif isinstance(function, Function) and len(function.parameters) == 1:
            heading = function.apply(ev.moment, {function.parameters[0].name: coordinates})
        else:
            heading = function
        if isinstance(heading, DirectionField):  # such as itself
            cure = "return a heading: `(FIELD at p)` of another field"
            actual = kind_name(heading)
            raise WRONG_KIND.mistake(value.span, what="this", expected="a heading", actual=actual, cure=cure)
        return geometry.heading_at(ev, heading, point, value.span)

    fewest = 4 if least is None else whole_number(ev, least.value, least.span, "`minSteps`")
    length = 5.0
    if step is not None:
        length = ev.constant(Quantity(_length(ev, step, "`defaultStepSize`"), LENGTH), step.span, "`defaultStepSize`")
    return DirectionField(at, (max(1, fewest), length))


def _workspace(_ev: Evaluator, region: Given, _span: Span) -> Value:
    area = _area(region.value, region.span)
    return replace(area, name="the workspace", attributes={**area.attributes, "region": area}, is_workspace=True)


def _vector(ev: Evaluator, given: Sequence[Given], span: Span) -> Value:
    no_names("Vector", given)
    return geometry.vector(ev, tuple(each.value for each in given), span)


MEANINGS: Mapping[str, Meaning] = {
    "CircularRegion": _circle,
    "SectorRegion": _sector,
    "RectangularRegion": _rectangle,
    "PolygonalRegion": polygon,
    "PolylineRegion": polyline,
    "VectorField": _field,
    "Workspace": _workspace,
    "Vector": _vector,
}
