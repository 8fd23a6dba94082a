"""`x.name`: what lanes, maneuvers, intersections, the network, places and objects can be asked for."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.classes import PROPERTIES, property_value
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.roads import ROAD
from cortex_dsl.semantics.units import ANGLE, LENGTH, PURE, SPEED
from cortex_dsl.semantics.values import (
    Actor,
    Centerline,
    DirectionField,
    EnumValue,
    GlobalParameters,
    Pose,
    Quantity,
    Truth,
    Value,
    Vector,
    kind_name,
)
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from engine.road.network import Intersection, Lane, Maneuver, Network
from engine.vocabulary import ManeuverType, Op, State

Entry = TypeVar("Entry")


def _length(ev: Evaluator, value: float) -> Quantity:
    return Quantity(ev.algebra.literal(value), LENGTH)


_LANE: dict[str, Callable[[Evaluator, Lane], Value]] = {
    "maneuvers": lambda _, lane: lane.maneuvers,
    "centerline": lambda _, lane: Centerline(lane),
    "width": lambda ev, lane: _length(ev, lane.width),
    "length": lambda ev, lane: _length(ev, lane.length),
    "name": lambda _, lane: lane.name,
    "intersection": lambda _, lane: lane.intersection,
    "successors": lambda _, lane: lane.successors,
    "predecessors": lambda _, lane: lane.predecessors,
}

_MANEUVER: dict[str, Callable[[Evaluator, Maneuver], Value]] = {
    "type": lambda _, maneuver: maneuver.type,
    "startLane": lambda _, maneuver: maneuver.start_lane,
    "connectingLane": lambda _, maneuver: maneuver.connecting_lane,
    "endLane": lambda _, maneuver: maneuver.end_lane,
    "intersection": lambda _, maneuver: maneuver.intersection,
    "conflictingManeuvers": lambda _, maneuver: maneuver.conflicting_maneuvers,
    "reverseManeuvers": lambda _, maneuver: maneuver.reverse_maneuvers,
    "name": lambda _, maneuver: maneuver.name,
}

_INTERSECTION: dict[str, Callable[[Evaluator, Intersection], Value]] = {
    "incomingLanes": lambda _, intersection: intersection.incoming_lanes,
    "outgoingLanes": lambda _, intersection: intersection.outgoing_lanes,
    "maneuvers": lambda _, intersection: intersection.maneuvers,
    "is3Way": lambda ev, intersection: Truth(ev.algebra.truth(intersection.is_3way)),
    "is4Way": lambda ev, intersection: Truth(ev.algebra.truth(intersection.is_4way)),
    "center": lambda ev, intersection: Vector(*map(ev.algebra.literal, intersection.center)),
    "name": lambda _, intersection: intersection.name,
}

_NETWORK: dict[str, Callable[[Evaluator, Network], Value]] = {
    "intersections": lambda _, network: network.intersections,
    "lanes": lambda _, network: network.lanes,
    "maneuvers": lambda _, network: network.maneuvers,
    "drivableRegion": lambda *_: ROAD,
    "roadDirection": lambda *_: DirectionField(),
}

_CENTERLINE: dict[str, Callable[[Evaluator, Centerline], Value]] = {
    "length": lambda ev, line: _length(ev, line.lane.length),
    "lane": lambda _, line: line.lane,
}

_VECTOR: dict[str, Callable[[Evaluator, Vector], Value]] = {
    "x": lambda _, point: Quantity(point.x, LENGTH),
    "y": lambda _, point: Quantity(point.y, LENGTH),
    "position": lambda _, point: point,
}

_POSE: dict[str, Callable[[Evaluator, Pose], Value]] = {
    "x": lambda _, pose: Quantity(pose.x, LENGTH),
    "y": lambda _, pose: Quantity(pose.y, LENGTH),
    "position": lambda _, pose: Vector(pose.x, pose.y),
    "heading": lambda _, pose: Quantity(pose.heading, ANGLE),
}

_TABLES: tuple[tuple[type, Mapping[str, Callable[..., Value]]], ...] = (
    (Lane, _LANE),
    (Maneuver, _MANEUVER),
    (Intersection, _INTERSECTION),
    (Network, _NETWORK),
    (Centerline, _CENTERLINE),
    (Vector, _VECTOR),
    (Pose, _POSE),
)

_STATES: dict[str, tuple[State, ir.Dimension]] = {
    "speed": (State.SPEED, SPEED),
    "steer": (State.STEER, ANGLE),
    "throttle": (State.THROTTLE, PURE),
    "brake": (State.BRAKE, PURE),
}
"""Attributes of objects that the run changes, beside the pose."""


def attribute_names() -> frozenset[str]:
    """Every name that may follow a dot, properties and params aside."""
    return frozenset({*_STATES, *(name for _, table in _TABLES for name in table)})


def get(ev: Evaluator, value: Value, name: str, span: Span) -> Value:
    """The attribute `name` of a value.

    Raises:
        Mistake: when there is none.
    """
    if isinstance(value, Actor):
        return _of_actor(ev, value, name, span)
    if isinstance(value, EnumValue):
        return _of(name, span, "`ManeuverType`", {member.name: member for member in ManeuverType})
    if isinstance(value, GlobalParameters):
        if name not in ev.run.params:
            raise errors.UNKNOWN_PARAM.mistake(span, name=name, suggestion=did_you_mean(name, ev.run.params))
        return ev.usable(ev.run.params[name])
    for kind, table in _TABLES:
        if isinstance(value, kind):
            getter: Callable[..., Value] = _of(name, span, kind_name(value), table)
            return getter(ev, value)
    raise errors.UNKNOWN_ATTRIBUTE.mistake(span, kind=kind_name(value), name=name, suggestion="")


def _of(name: str, span: Span, kind: str, table: Mapping[str, Entry]) -> Entry:
    if name not in table:
        raise errors.UNKNOWN_ATTRIBUTE.mistake(span, kind=kind, name=name, suggestion=did_you_mean(name, table))
    return table[name]


def current_pose(ev: Evaluator, actor: Actor) -> Pose:
    """Where an object is: at the start for the scene, at the moment during the run."""
    if not ev.moment.running:
        return actor.pose
    x, y, heading = (state(ev, actor, column) for column in (State.X, State.Y, State.HEADING))
    return Pose(x, y, heading)


def state(ev: Evaluator, actor: Actor, column: State) -> ir.Expr:
    return ev.algebra.apply(Op.STATE, immediates=(actor.index, int(column)))


def _of_actor(ev: Evaluator, actor: Actor, name: str, span: Span) -> Value:
    if name in _POSE:
        return _POSE[name](ev, current_pose(ev, actor))
    if name in _STATES and ev.moment.running:
        column, dimension = _STATES[name]
        return Quantity(state(ev, actor, column), dimension)
    if name in _STATES and name != "speed":
        raise errors.ONLY_WHILE_RUNNING.mistake(span, what=f"`{name}` of an object")
    if name in actor.properties:
        return property_value(actor.properties[name], name)
    raise errors.UNKNOWN_ATTRIBUTE.mistake(
        span, kind=kind_name(actor), name=name, suggestion=did_you_mean(name, {*_POSE, *_STATES, *PROPERTIES})
    )
