"""Regions, fields and the workspace that a file makes: `CircularRegion(...)`, `VectorField(...)`, `Workspace(...)`.

A place in a circle or a sector lies at the square root of a uniform share of the radius. Combinations of two regions
are sampled by rejection, with the scene.
Source: Scenic 3 reference, "Region Types".
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from cortex_dsl.semantics.errors.values import MANY_REGIONS, WRONG_KIND
from cortex_dsl.semantics.evaluation import geometry, polygons
from cortex_dsl.semantics.evaluation.arguments import Given, no_names
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
    sin,
    sqrt,
    where,
    wrapped,
)
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH
from cortex_dsl.source import Span

CORNERS = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
"""Corners of a rectangle in order: shares of its width to the right and of its length ahead."""

# -- convex regions ----------------------------------------------------------------------------------------------------


def _length(ev: Evaluator, given: Given, what: str) -> Term:
    value = adopt(ev, given.value, LENGTH, given.span, what)
    return in_range(ev, value, Domain(what, LENGTH, 0.0, polygons.FARTHEST, above=True), given.span)


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
    return convex(replace(area, corners=corners))


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
        kept = (uniform() < 0.5) | ~(one.contains(point) & other.contains(point))
        if left.kept is not None or right.kept is not None:
            always = kept.algebra.truth(True)
            of_each = (always if each.kept is None else each.kept for each in (left, right))
            kept = kept & where(of_first, *of_each)
        return DrawnPlace(point, None, kept)

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
        return replace(spot, kept=there if spot.kept is None else spot.kept & there)

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
    "PolygonalRegion": polygons.polygon,
    "PolylineRegion": polygons.polyline,
    "VectorField": _field,
    "Workspace": _workspace,
    "Vector": _vector,
}
