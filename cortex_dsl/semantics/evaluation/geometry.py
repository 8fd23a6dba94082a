"""Places, and the operators between them: distances, headings, regions, offsets; where objects are and how they
move at the moment at which an expression is evaluated.

Headings are anticlockwise from +x. Local offsets are (to the right, ahead), as in Scenic.
"""

import math

from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.names import NOT_SUPPORTED
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import LATER_PLACE
from cortex_dsl.semantics.errors.scene import EGO_NEEDED
from cortex_dsl.semantics.errors.values import OUT_OF_RANGE, WRONG_KIND
from cortex_dsl.semantics.evaluation.lanes import region_of
from cortex_dsl.semantics.evaluation.numbers import adopt
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    Centerline,
    DirectionField,
    Pose,
    Sighted,
    Value,
    Vector,
    View,
)
from cortex_dsl.semantics.model.wording import kind_name, shown
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    atan2,
    cos,
    hypot,
    path_pose,
    region_contains,
    region_contains_box,
    road_heading,
    sin,
    wrapped,
)
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.errors import Signal
from engine.road.network import Intersection, Lane
from engine.vehicles import VIEW_DISTANCE
from engine.vocabulary import State

# -- objects now -------------------------------------------------------------------------------------------------------


def current_pose(ev: Evaluator, actor: Actor) -> Pose:
    """Return the pose of an object: at the start for the scene, at the present sample during the run."""
    if not ev.moment.running:
        check_settled(ev, actor)
        return actor.pose
    x, y, heading = (state(ev, actor, column) for column in (State.X, State.Y, State.HEADING))
    return Pose(x, y, heading)


class NeedsRun(Signal):
    """The place of an object depends on where others are when its scenario starts."""


def check_settled(ev: Evaluator, actor: Actor) -> None:
    """Refuse to read the start of an object for a scenario that starts later.

    Raises:
        Mistake: the scenario of this moment starts later.
    """
    scenario = ev.moment.scenario
    if actor.scenario is not None and actor.scenario is scenario and not ev.moment.later:
        return
    if scenario is not None and not scenario.present and ev.run.built.may_appear:
        raise NeedsRun
    if ev.moment.later or (scenario is not None and not scenario.present):
        started = () if scenario is None or scenario.span is None else (Label(scenario.span, "started here"),)
        raise LATER_PLACE.mistake(ev.algebra.span, name=actor.name, secondary=started)


NORTH = math.pi / 2
"""Heading of the north, counted from the east [rad]."""


def as_written(ev: Evaluator, heading: Term) -> Term:
    """Return a heading in the convention of the file [rad]: from north in Scenic's files, from east otherwise."""
    return heading - NORTH if ev.facts.from_scenic else heading


def as_meant(ev: Evaluator, written: Term) -> Term:
    """A heading that the file gives as a number, from the east."""
    return written + NORTH if ev.facts.from_scenic else written


def state(ev: Evaluator, actor: Actor, column: State) -> Term:
    return ev.algebra.state(actor.index, column)


def size_of(actor: Actor, name: str) -> Term:
    """A number among the properties of an object."""
    value = actor.properties[name]
    assert isinstance(value, Term)
    return value


def is_present(ev: Evaluator, actor: Actor) -> Term:
    return state(ev, actor, State.PRESENT)


def others(ev: Evaluator, actor: Actor) -> tuple[Actor, ...]:
    """Return all objects of the scene except `actor`."""
    return tuple(each for each in ev.run.built.actors if each is not actor)


def between(start: Vector | Pose, end: Vector | Pose) -> Term:
    """Distance of two places [m]."""
    return hypot(end.x - start.x, end.y - start.y)


def outline_of(ev: Evaluator, actor: Actor) -> Term:
    """Packed x, y, heading, length, width."""
    pose = current_pose(ev, actor)
    return ev.algebra.pack(pose.x, pose.y, pose.heading, size_of(actor, "length"), size_of(actor, "width"))


# -- places -----------------------------------------------------------------------------------------------------------
def vector(ev: Evaluator, items: tuple[Value, ...], span: Span) -> Vector:
    if len(items) == 3 and ev.facts.from_scenic:
        return _on_the_ground(ev, items, span)
    if len(items) != 2:
        raise WRONG_KIND.mistake(
            span,
            what="this",
            expected="a place",
            actual=f"a list of {len(items)}",
            cure="a place is an object, a point, or `(x, y)`",
        )
    return Vector(*(adopt(ev, item, LENGTH, span, "a coordinate") for item in items))


def _on_the_ground(ev: Evaluator, items: tuple[Value, ...], span: Span) -> Vector:
    """A place that a script of Scenic gives with its height, which is 0 on a plane."""
    height = adopt(ev, items[2], LENGTH, span, "a height")
    if (value := closed_value(height)) != 0.0:
        cure = "write 0, or `(x, y)`: heights are not simulated"
        actual = "drawn or computed in the run" if value is None else shown(value, LENGTH)
        raise OUT_OF_RANGE.mistake(span, what="a height", actual=actual, expected="0 m", cure=cure)
    return vector(ev, items[:2], span)


def position(ev: Evaluator, value: Value, span: Span, what: str = "this") -> Vector:
    """The point where a place or an object is."""
    match value:
        case Vector():
            return value
        case Pose():
            return Vector(value.x, value.y)
        case Actor():
            pose = current_pose(ev, value)
            return Vector(pose.x, pose.y)
        case tuple():
            return vector(ev, value, span)
        case Intersection():
            return Vector(*map(ev.algebra.literal, value.center))
    cure = _AN_OFFSET if what == "an offset" else "a place is an object, a point, or `(x, y)`"
    raise WRONG_KIND.mistake(span, what=what, expected="a place", actual=kind_name(value), cure=cure)


def pose_of(ev: Evaluator, value: Value) -> Pose | None:
    """Return the pose of a value with place and heading; None for other values."""
    if isinstance(value, Actor):
        return current_pose(ev, value)
    return value if isinstance(value, Pose) else None


def oriented(ev: Evaluator, value: Value, span: Span, what: str = "this") -> Pose:
    if (pose := pose_of(ev, value)) is None:
        raise WRONG_KIND.mistake(
            span,
            what=what,
            expected="an object or an oriented point",
            actual=kind_name(value),
            cure=_POINT_ON_A_LANE if isinstance(value, Lane | Centerline) else "",
        )
    return pose


_POINT_ON_A_LANE = (
    "make a point of it: `p = new OrientedPoint in lane.centerline`, or `… after intersection by 5 m along T`"
)
_AN_OFFSET = "as in `(2 m, 10 m)`: so far to the right, and so far ahead"


def ego_of(ev: Evaluator, span: Span, what: str) -> Actor:
    """Return the ego, the default of an omitted operand.

    Raises:
        Mistake: there is no ego.
    """
    if ev.ego is not None:
        return ev.ego
    if ev.has("ego") or ev.moment.running:
        raise Mistake
    raise EGO_NEEDED.mistake(span, what=what)


def moved(start: Vector, heading: Term, right: Term, ahead: Term) -> Vector:
    """`start` displaced by a local offset under a heading."""
    c, s = cos(heading), sin(heading)
    return Vector(start.x + (ahead * c + right * s), start.y + (ahead * s - right * c))


def left_of_path(path: Term, s: Term, place: Pose) -> Term:
    """Return how far a place is to the left of the pose at an arc length of a path [m]."""
    x, y, heading = path_pose(path, s)
    return (place.y - y) * cos(heading) - (place.x - x) * sin(heading)


def direction_at(field: DirectionField, point: Vector) -> Term:
    """The direction of a field at a point."""
    return road_heading(point.x, point.y) if field.at is None else field.at(point)


def heading_at(ev: Evaluator, value: Value, point: Vector, span: Span) -> Term:
    """A direction given as an angle, a field, or something that has a heading."""
    if isinstance(value, DirectionField):
        return direction_at(value, point)
    if (pose := pose_of(ev, value)) is not None:
        return pose.heading
    return as_meant(ev, adopt(ev, value, ANGLE, span, "a heading"))


def bearing(origin: Vector, target: Vector) -> Term:
    """Return the heading from one point to another [rad]."""
    return atan2(target.y - origin.y, target.x - origin.x)


def outline(ev: Evaluator, value: Value, span: Span) -> Term:
    """Packed x, y, heading, length, width; a place is an outline of no size."""
    if isinstance(value, Actor):
        return outline_of(ev, value)
    point, zero = position(ev, value, span), ev.algebra.literal(0.0)
    return ev.algebra.pack(point.x, point.y, zero, zero, zero)


# -- viewers -----------------------------------------------------------------------------------------------------------


def viewer(ev: Evaluator, value: Value, span: Span) -> Actor | Pose | Vector:
    """Return the viewer: an object, or a place; a plain point looks in all directions and needs no heading."""
    return value if isinstance(value, Actor | Vector) else oriented(ev, value, span, "what sees")


def looking(ev: Evaluator, viewer: Actor | Pose | Vector) -> Pose:
    """Return the place and direction of view of a viewer."""
    if isinstance(viewer, Vector):
        return Pose(viewer.x, viewer.y, ev.algebra.literal(0.0))
    return current_pose(ev, viewer) if isinstance(viewer, Actor) else viewer


def view_of(ev: Evaluator, viewer: Actor | Pose | Vector) -> View:
    """Return the field of view of an object or a place without occlusion."""
    if isinstance(viewer, Actor):
        return View(size_of(viewer, "visibleDistance"), size_of(viewer, "viewAngle"))
    return viewer.view or View(ev.algebra.literal(VIEW_DISTANCE), ev.algebra.literal(math.tau))


# -- operators --------------------------------------------------------------------------------------------------------


def inside(ev: Evaluator, item: Value, container: Value, span: Span) -> Term:
    """`x in region`: the whole outline of an object, or a point."""
    if isinstance(container, Sighted):
        return inside(ev, item, container.region, span) & in_sector(ev, container, position(ev, item, span))
    if isinstance(container, Area):
        return _inside_area(ev, item, container, span)
    region = region_of(container)
    if region is None:
        raise WRONG_KIND.mistake(
            span, what="what follows `in`", expected="a list or a region", actual=kind_name(container), cure=""
        )
    if isinstance(item, Actor):
        box = outline(ev, item, span)
        return region_contains_box(float(region.id), box)
    point = position(ev, item, span)
    return region_contains(float(region.id), point.x, point.y)


def _inside_area(ev: Evaluator, item: Value, area: Area, span: Span) -> Term:
    if not isinstance(item, Actor):
        return area.contains(position(ev, item, span))
    if area.holds is None:
        what, cure = f"whether an outline lies in {area.name}", "ask for its place: `x.position in ...`"
        raise NOT_SUPPORTED.mistake(span, what=what, reason="", cure=cure)
    pose = current_pose(ev, item)
    ahead, right = size_of(item, "length") * 0.5, size_of(item, "width") * 0.5
    signs = ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))
    start = Vector(pose.x, pose.y)
    return area.holds([moved(start, pose.heading, right * across, ahead * along) for along, across in signs])


def in_sector(ev: Evaluator, sighted: Sighted, point: Vector) -> Term:
    """Return whether a point is in the field of view, or outside it if `sighted` says so; occlusion is ignored."""
    viewer = sighted.viewer
    pose = looking(ev, viewer)
    view, start = view_of(ev, viewer), Vector(pose.x, pose.y)
    off = abs(wrapped(bearing(start, point) - pose.heading))
    seen = (between(start, point) <= view.reach) & (off <= view.opening * 0.5)
    return seen if sighted.seen else ~seen


def offset_by(ev: Evaluator, node: nodes.OffsetBy) -> Value:
    base, offset = ev.evaluate_all((node.base, node.offset))
    return displaced(ev, base, position(ev, offset, node.offset.span, "an offset"), node.base.span)


def displaced(ev: Evaluator, base: Value, offset: Vector, span: Span) -> Value:
    """`base` moved by (right, ahead) in its own frame; a plain point along x and y."""
    pose = pose_of(ev, base)
    if pose is None:
        point = position(ev, base, span)
        return Vector(point.x + offset.x, point.y + offset.y)
    place = moved(Vector(pose.x, pose.y), pose.heading, offset.x, offset.y)
    return Pose(place.x, place.y, pose.heading)


def offset_along(ev: Evaluator, node: nodes.OffsetAlong) -> Value:
    base, direction, offset = ev.evaluate_all((node.base, node.direction, node.offset))
    return displaced_along(ev, base, direction, position(ev, offset, node.offset.span, "an offset"), node)


def displaced_along(ev: Evaluator, base: Value, direction: Value, offset: Vector, node: nodes.Node) -> Value:
    """`base` moved by (right, ahead) in a frame that points along a direction."""
    start = position(ev, base, node.span)
    heading = heading_at(ev, direction, start, node.span)
    place = moved(start, heading, offset.x, offset.y)
    pose = pose_of(ev, base)
    return place if pose is None else Pose(place.x, place.y, pose.heading)
