"""Scenic's operators that join two places: `relative to`, `angle`, `apparent heading`, `relative position`, `distance
past`, `follow`, the edges of outlines, and `distance from … to …` and `intersects`.

Source: Scenic 3 reference, "Operators", and their definitions in its `scenic.syntax.veneer`.
"""

import math
from collections.abc import Callable, Mapping

from cortex_dsl.semantics.errors.names import NOT_SUPPORTED
from cortex_dsl.semantics.errors.scene import NO_RELATION, NOT_A_FIELD
from cortex_dsl.semantics.errors.values import NO_FIELD_AT
from cortex_dsl.semantics.evaluation import geometry
from cortex_dsl.semantics.evaluation.geometry import as_meant, as_written, between, ego_of, outline, position, region_of
from cortex_dsl.semantics.evaluation.lanes import of_each
from cortex_dsl.semantics.evaluation.numbers import adopt
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.areas import Area, Velocity
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Centerline, DirectionField, Pose, Quantity, Truth, Value, Vector
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    box_distance,
    ceil,
    cos,
    maximum,
    path_distance,
    region_box_distance,
    region_distance,
    road_follow,
    sin,
    where,
    wrapped,
)
from cortex_dsl.semantics.quantities.units import ANGLE, ANGULAR_SPEED, LENGTH
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

# -- relative to -------------------------------------------------------------------------------------------------------


def relative_to(ev: Evaluator, node: nodes.RelativeTo) -> Value:
    """Return a field or heading turned by another one, or a place in the frame of another one."""
    value, base = ev.evaluate_all((node.value, node.base))
    spans = node.value.span, node.base.span
    if isinstance(value, DirectionField) or isinstance(base, DirectionField):
        return _turned_field(ev, value, base, spans)
    poses = [geometry.pose_of(ev, each) for each in (value, base)]
    if None not in poses:
        raise NO_RELATION.mistake(node.span, left=kind_name(value), right=kind_name(base))
    if isinstance(value, Quantity) or isinstance(base, Quantity):
        return Quantity(_written(ev, value, spans[0]) + _written(ev, base, spans[1]), ANGLE)
    if poses[0] is not None:
        value, base, spans = base, value, spans[::-1]
    return geometry.displaced(ev, base, geometry.position(ev, value, spans[0], "an offset"), spans[1])


def _turned_field(ev: Evaluator, value: Value, base: Value, spans: tuple[Span, Span]) -> DirectionField:
    """The sum of two fields, or of a field and an angle, at each place; of two, one counts from the file's zero."""
    both = isinstance(value, DirectionField) and isinstance(base, DirectionField)

    def part(each: Value, span: Span) -> Callable[[Vector], Term]:
        if isinstance(each, DirectionField):
            return lambda point: geometry.direction_at(each, point)
        turned = _written(ev, each, span)
        return lambda _point: turned

    one, other = (part(each, span) for each, span in zip((value, base), spans, strict=True))
    return DirectionField(lambda point: one(point) + (as_written(ev, other(point)) if both else other(point)))


def _written(ev: Evaluator, value: Value, span: Span) -> Term:
    """A heading as the file counts it."""
    pose = geometry.pose_of(ev, value)
    return adopt(ev, value, ANGLE, span, "a heading") if pose is None else as_written(ev, pose.heading)


def field_at(ev: Evaluator, node: nodes.FieldAt) -> Value:
    """The heading of a field at a place, as the file counts headings."""
    field, place = ev.evaluate_all((node.field, node.place))
    if not isinstance(field, DirectionField):
        raise NO_FIELD_AT.mistake(node.field.span, actual=kind_name(field))
    point = geometry.position(ev, place, node.place.span, "what follows `at`")
    if field.at is None:
        network_of(ev)
    return Quantity(as_written(ev, geometry.direction_at(field, point)), ANGLE)


# -- from one place to another -----------------------------------------------------------------------------------------


def _place(ev: Evaluator, node: nodes.Expression | None, span: Span, what: str) -> tuple[Value, Span]:
    """Return the value and the place of an operand; the ego and the place of the whole expression if it is omitted."""
    return (geometry.ego_of(ev, span, what), span) if node is None else (ev.evaluate(node), node.span)


def angle(ev: Evaluator, node: nodes.Angle) -> Value:
    """Return the heading from one place to another, in the convention of the file [rad]."""
    start, end = (
        geometry.position(ev, *_place(ev, each, node.span, "an `angle`")) for each in (node.origin, node.target)
    )
    return Quantity(wrapped(as_written(ev, geometry.bearing(start, end))), ANGLE)


def seen_from(ev: Evaluator, node: nodes.SeenFrom) -> Value:
    of = ev.evaluate(node.of)
    origin, origin_span = _place(ev, node.origin, node.span, f"`{node.operator}`")
    return _RELATIONS[node.operator](ev, of, node.of.span, origin, origin_span)


def _apparent_heading(ev: Evaluator, of: Value, of_span: Span, origin: Value, span: Span) -> Value:
    """Return the heading of an object relative to the line of sight [rad], in [-pi, pi)."""
    pose = geometry.oriented(ev, of, of_span, "what has an apparent heading")
    start = geometry.position(ev, origin, span)
    return Quantity(wrapped(pose.heading - geometry.bearing(start, Vector(pose.x, pose.y))), ANGLE)


def _relative_position(ev: Evaluator, of: Value, of_span: Span, origin: Value, span: Span) -> Value:
    end, start = geometry.position(ev, of, of_span), geometry.position(ev, origin, span)
    return Vector(end.x - start.x, end.y - start.y)


def _distance_past(ev: Evaluator, of: Value, of_span: Span, origin: Value, span: Span) -> Value:
    """Return the distance of an object past a place, along its own heading; negative if the place is ahead of it."""
    point = geometry.position(ev, of, of_span)
    pose = geometry.oriented(ev, origin, span, "what is past")
    return Quantity((pose.x - point.x) * cos(pose.heading) + (pose.y - point.y) * sin(pose.heading), LENGTH)


_RELATIONS: Mapping[str, Callable[[Evaluator, Value, Span, Value, Span], Value]] = {
    "apparent heading of": _apparent_heading,
    "relative position of": _relative_position,
    "distance past": _distance_past,
}


def relative_heading(ev: Evaluator, node: nodes.RelativeHeading) -> Value:
    """`relative heading of a from b`, in [-pi, pi)."""
    origin = _place(ev, node.origin, node.span, "a relative heading")
    heading = _heading(ev, ev.evaluate(node.of), node.of.span)
    return Quantity(wrapped(heading - _heading(ev, *origin)), ANGLE)


def _heading(ev: Evaluator, value: Value, span: Span) -> Term:
    pose = geometry.pose_of(ev, value)
    return as_meant(ev, adopt(ev, value, ANGLE, span, "a heading")) if pose is None else pose.heading


# -- places ------------------------------------------------------------------------------------------------------------


def follow(ev: Evaluator, node: nodes.Follow | nodes.Following) -> Pose:
    """The oriented point at which a way along the roads ends."""
    direction = ev.evaluate(node.direction)
    if not isinstance(direction, DirectionField):
        raise NOT_A_FIELD.mistake(node.direction.span, actual=kind_name(direction))
    start = geometry.position(ev, *_place(ev, node.origin, node.span, "`following`"))
    by = adopt(ev, ev.evaluate(node.distance), LENGTH, node.distance.span, "the distance after `for`")
    if direction.at is not None:
        return _followed(ev, direction, start, by, node.distance.span)
    network_of(ev)
    return Pose(*road_follow(start.x, start.y, by))


MOST_STEPS = 100
"""Steps in which a field is followed; each asks for its heading once."""


def _followed(ev: Evaluator, field: DirectionField, start: Vector, by: Term, span: Span) -> Pose:
    """Return the pose at the end of steps of equal length along a field, as in Scenic: the explicit Euler method."""
    fewest, length = field.steps
    farthest = max(MOST_STEPS, fewest) * length
    by = in_range(ev, by, Domain("the distance along a field", LENGTH, 0.0, farthest), span)
    most = max(fewest, math.ceil(min(ev.interval(by)[1], farthest) / length))
    count = maximum(float(fewest), ceil(by / length))
    here, step, zero = start, by / count, ev.algebra.literal(0.0)
    for number in range(most):
        there = geometry.moved(here, geometry.direction_at(field, here), zero, step)
        goes_on = float(number) < count
        here = Vector(where(goes_on, there.x, here.x), where(goes_on, there.y, here.y))
    return Pose(here.x, here.y, geometry.direction_at(field, here))


_SIDES: Mapping[str, tuple[float, float]] = {
    "front": (0.0, 1.0),
    "back": (0.0, -1.0),
    "left": (-1.0, 0.0),
    "right": (1.0, 0.0),
}
"""Displacements to the right and ahead, in half widths and half lengths."""


def side_of(ev: Evaluator, node: nodes.SideOf) -> Value:
    """The middle of an edge of an outline, or a corner, heading as the object does."""
    value = ev.evaluate(node.of)
    pose = geometry.oriented(ev, value, node.of.span, f"what has a {node.side}")
    if not isinstance(value, Actor):
        return pose
    return edge_of(ev, value, node.side)


EDGES: Mapping[str, str] = {
    **{side: side for side in _SIDES},
    **{f"{end}{side.capitalize()}": f"{end} {side}" for end in ("front", "back") for side in ("left", "right")},
}
"""Attributes of objects by the words of the operator."""


def edge_of(ev: Evaluator, actor: Actor, side: str) -> Pose:
    """The middle of an edge of an object's outline, or a corner."""
    pose = geometry.current_pose(ev, actor)
    right, ahead = (math.fsum(_SIDES[word][axis] for word in side.split()) for axis in (0, 1))
    across, along = (geometry.size_of(actor, name) * 0.5 for name in ("width", "length"))
    place = geometry.moved(Vector(pose.x, pose.y), pose.heading, across * right, along * ahead)
    return Pose(place.x, place.y, pose.heading)


def heading_in_sight(ev: Evaluator, node: nodes.Facing, point: Vector) -> Term:
    """`apparently facing H from V`: H, counted from the line of sight."""
    start = geometry.position(ev, *_place(ev, node.viewer, node.span, "`apparently facing`"))
    turned = adopt(ev, ev.evaluate(node.heading), ANGLE, node.heading.span, "a heading")
    return geometry.bearing(start, point) + turned


def velocity(ev: Evaluator, actor: Actor) -> Velocity:
    """`self.velocity`: before the run that with which it starts, along its heading."""
    if ev.moment.running:
        return Velocity(*ev.algebra.velocity(actor.index)[:2])
    geometry.check_settled(ev, actor)
    heading, speed = geometry.current_pose(ev, actor).heading, geometry.size_of(actor, "speed")
    return Velocity(speed * cos(heading), speed * sin(heading))


def angular_speed(ev: Evaluator, actor: Actor) -> Quantity:
    """Return `self.angularSpeed`, anticlockwise [rad/s]; 0 before the run, as in Scenic."""
    rate = ev.algebra.velocity(actor.index)[2] if ev.moment.running else ev.algebra.literal(0.0)
    return Quantity(rate, ANGULAR_SPEED)


# -- distances and intersections ---------------------------------------------------------------------------------------


def distance(ev: Evaluator, node: nodes.Distance) -> Value:
    """Centre to centre, or centre to region; with `minimum` from outline to outline, or outline to region."""
    origin = ev.evaluate(node.origin) if node.origin is not None else ego_of(ev, node.span, "a `distance to`")
    target = ev.evaluate(node.target)
    origin_span = node.span if node.origin is None else node.origin.span
    if _is_area(origin) and not _is_area(target):
        origin, target, origin_span = target, origin, node.target.span
    if node.between_outlines:
        return Quantity(_gap(ev, origin, target, node), LENGTH)
    start = position(ev, origin, origin_span)
    if isinstance(target, Area):
        if target.distance is None:
            raise NOT_SUPPORTED.mistake(node.target.span, what=f"the distance to {target.name}", reason="", cure="")
        return Quantity(target.distance(start), LENGTH)
    if isinstance(target, Centerline):
        path = of_each(ev, target.lane, "path")
        return Quantity(path_distance(path, start.x, start.y), LENGTH)
    if (region := region_of(target)) is not None:
        return Quantity(region_distance(float(region.id), start.x, start.y), LENGTH)
    end = position(ev, target, node.target.span)
    return Quantity(between(start, end), LENGTH)


def _is_area(value: Value) -> bool:
    return isinstance(value, Centerline | Area) or region_of(value) is not None


def _gap(ev: Evaluator, origin: Value, target: Value, node: nodes.Distance) -> Term:
    if _is_area(target):
        return _gap_to_region(ev, origin, target, node.target.span, "`minimum distance`")
    return _between_outlines(ev, origin, target, node.span, node.target.span)


def _between_outlines(ev: Evaluator, one: Value, other: Value, one_span: Span, other_span: Span) -> Term:
    """Return the distance of two outlines [m]; in contact rules, 0 between the ego and an actor that it touched."""
    gap = box_distance(outline(ev, one, one_span), outline(ev, other, other_span))
    if ev.moment.judged and isinstance(one, Actor) and isinstance(other, Actor) and ev.run.ego in (one, other):
        return where(ev.algebra.touches((other if one is ev.run.ego else one).index), 0.0, gap)
    return gap


def _gap_to_region(ev: Evaluator, item: Value, area: Value, span: Span, what: str) -> Term:
    """Distance between the outline of an object, or a point, and a region; 0 where they overlap."""
    region = region_of(area)
    if region is None or _is_area(item):
        raise NOT_SUPPORTED.mistake(
            span,
            what=f"{what} is between two objects, or an object and a region",
            reason="a centerline is a line and no region" if region is None else "",
            cure="write `distance from x to lane.centerline`, from the centre of x" if region is None else "",
        )
    box = outline(ev, item, span)
    return region_box_distance(float(region.id), box)


def intersects(ev: Evaluator, node: nodes.Intersects) -> Value:
    """Return whether two outlines, or an outline and a region, have a common point."""
    left, right = ev.evaluate_all((node.left, node.right))
    if _is_area(left) or _is_area(right):
        item, area = (right, left) if _is_area(left) else (left, right)
        gap = _gap_to_region(ev, item, area, node.span, "`intersects`")
    else:
        gap = _between_outlines(ev, left, right, node.left.span, node.right.span)
    touching = gap <= 0.0
    ev.run.compared.setdefault(touching, LENGTH)
    return Truth(touching)
