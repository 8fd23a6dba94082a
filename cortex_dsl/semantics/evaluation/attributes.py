"""`x.name`: attributes of lanes, maneuvers, intersections, the network, places and objects."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import UNKNOWN_ATTRIBUTE, UNKNOWN_PARAM
from cortex_dsl.semantics.errors.problems import Rejection
from cortex_dsl.semantics.errors.runs import LANE_OF_THE_RUN, NOT_STARTED, ONLY_WHILE_RUNNING
from cortex_dsl.semantics.errors.values import LAST_ACTIONS
from cortex_dsl.semantics.evaluation import (
    alignments,
    driving,
    lanes,
    lists,
    over_run,
    regions,
    relations,
    signals,
    streets,
)
from cortex_dsl.semantics.evaluation.functions import known_truth
from cortex_dsl.semantics.evaluation.geometry import as_written, check_settled, current_pose, position, state
from cortex_dsl.semantics.evaluation.lanes import as_section, chosen, lane_at
from cortex_dsl.semantics.evaluation.roads import ROAD, network_of, region_of_intersections
from cortex_dsl.semantics.model.areas import Area, Coordinates, Elements, RoadSection, Velocity
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    Alignment,
    Centerline,
    Closure,
    DirectionField,
    EnumValue,
    GlobalParameters,
    GroupNow,
    Items,
    LaneNow,
    Namespace,
    Pose,
    Quantity,
    ScenarioCall,
    Signal,
    SimulationNow,
    Truth,
    Unfinished,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import PROPERTIES
from cortex_dsl.semantics.quantities.algebra import Term, where
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH, PURE, SPEED, TIME
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from engine.road.network import (
    TRAFFIC_LIGHT,
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Maneuver,
    Network,
    Road,
    RoadSign,
    Surface,
)
from engine.road.sections import LaneSection, group_of, road_of
from engine.vocabulary import ManeuverType, State

# -- attributes at points ----------------------------------------------------------------------------------------------


def lane_under(ev: Evaluator, place: Value) -> Value:
    """The lane at a point, whatever its direction, or on which an object or an oriented point lies."""
    if isinstance(place, Actor):
        return lane_at(ev, current_pose(ev, place))
    if isinstance(place, Pose):
        return lane_at(ev, place)
    point = position(ev, place, ev.algebra.span, "the point whose lane is needed")
    if (only := _only_lane(ev, point)) is not None:
        return only
    return lane_at(ev, Pose(point.x, point.y, ev.algebra.literal(math.nan)))


def _only_lane(ev: Evaluator, point: Vector) -> Lane | None:
    """Return the lane at a known point if no other lane covers it; all of its attributes are then available."""
    x, y = closed_value(point.x), closed_value(point.y)
    if x is None or y is None:
        return None
    network = network_of(ev)
    found = [lane for lane in network.lanes if network.regions.contains(lane.region, x, y)]
    return found[0] if len(found) == 1 else None


Point = tuple[float, float]


def _intersection(network: Network, at: Lane | Point) -> Value:
    if isinstance(at, Lane):
        return at.intersection if at.role is LaneRole.CONNECTING else None
    return next((each for each in network.intersections if network.regions.contains(each.region, *at)), None)


def _of_lane(find: Callable[[Lane], Value]) -> Callable[[Network, Lane | Point], Value]:
    def found(network: Network, at: Lane | Point) -> Value:
        if isinstance(at, Lane):
            return find(at)
        lanes = (lane for lane in network.lanes if network.regions.contains(lane.region, *at))
        return next(map(find, lanes), None)

    return found


_KINDS: Mapping[str, Callable[[Network, Lane | Point], Value]] = {
    "roadAt": _of_lane(road_of),
    "laneGroupAt": _of_lane(group_of),
    "intersectionAt": _intersection,
}


def _known(ev: Evaluator, place: Value, name: str) -> Lane | Point:
    """Return the lane on which an object was placed, or a point with known coordinates.

    Raises:
        Mistake: only the run knows it, or it is no place.
    """
    where = current_pose(ev, place) if isinstance(place, Actor) else place
    if isinstance(where, Pose) and isinstance(lane := chosen(where.lane), Lane):
        return lane
    point = position(ev, where, ev.algebra.span, f"the argument of `{name}`")
    x, y = closed_value(point.x), closed_value(point.y)
    if x is None or y is None:
        suggestion = "ask at a point that is known before the run, as in `(3 m, 40 m)`"
        raise LANE_OF_THE_RUN.mistake(ev.algebra.span, name=name, suggestion=suggestion)
    return x, y


_SURFACES: Mapping[str, Callable[[Network, float, float], Value]] = {
    "sidewalkAt": lambda network, x, y: streets.surface_at(network, streets.SIDEWALK, x, y),
    "crossingAt": lambda network, x, y: streets.surface_at(network, streets.CROSSING, x, y),
    "shoulderAt": lambda network, x, y: streets.surface_at(network, streets.SHOULDER, x, y),
    "elementAt": streets.element_at,
}


def _surface(ev: Evaluator, place: Value, name: str, reject: Value = None) -> Value:
    """Return the element at a point; with `reject`, reject the scene where there is none."""
    point = position(ev, place, ev.algebra.span, f"the argument of `{name}`")
    x, y = closed_value(point.x), closed_value(point.y)
    if x is None or y is None:
        suggestion = "ask at a point that is known before the run, as in `(3 m, 40 m)`"
        raise LANE_OF_THE_RUN.mistake(ev.algebra.span, name=name, suggestion=suggestion)
    found = _SURFACES[name](network_of(ev), x, y)
    if found is None and _is_set(ev, reject):
        raise Rejection(f"nothing is there for `{name}`", ev.algebra.span)
    return found


def _is_set(ev: Evaluator, reject: Value) -> bool:
    return known_truth(ev, reject, ev.algebra.span, "`reject`") if isinstance(reject, Truth) else bool(reject)


def _finder(ev: Evaluator, name: str) -> Closure:
    return Closure(("point", "reject"), lambda place, reject=None: _surface(ev, place, name, reject), optional=1)


def _crossing_of(ev: Evaluator, road: Road) -> Closure:
    def find(place: Value, reject: Value = None) -> Value:
        found = _surface(ev, place, "crossingAt", reject)
        return found if isinstance(found, Surface) and found.road == road.name else None

    return Closure(("point", "reject"), find, optional=1)


def _predicate(ev: Evaluator, name: str) -> Closure:
    return Closure(("point",), lambda place: _KINDS[name](network_of(ev), _known(ev, place, name)))


AT_POINTS: Mapping[str, Callable[[Evaluator, Network], Value]] = {
    "laneAt": lambda ev, _: Closure(("point",), lambda point: lane_under(ev, point)),
    "laneSectionAt": lambda ev, _: Closure(("point",), lambda point: as_section(lane_under(ev, point))),
    "roadAt": lambda ev, _: _predicate(ev, "roadAt"),
    "laneGroupAt": lambda ev, _: _predicate(ev, "laneGroupAt"),
    "intersectionAt": lambda ev, _: _predicate(ev, "intersectionAt"),
    **{name: lambda ev, _, name=name: _finder(ev, name) for name in _SURFACES},
}


# -- attributes --------------------------------------------------------------------------------------------------------


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
    "signal": lambda _, lane: signals.light_of(lane),
    **lanes.OF_LANE,
}

_MANEUVER: dict[str, Callable[[Evaluator, Maneuver], Value]] = {
    "type": lambda _, maneuver: maneuver.type,
    "startLane": lambda _, maneuver: maneuver.start_lane,
    "connectingLane": lambda _, maneuver: maneuver.connecting_lane,
    "endLane": lambda _, maneuver: maneuver.end_lane,
    "intersection": lambda _, maneuver: maneuver.intersection,
    "conflictingManeuvers": lambda _, maneuver: maneuver.conflicting_maneuvers,
    "oncomingManeuvers": lambda _, maneuver: maneuver.oncoming_maneuvers,
    "crossingManeuvers": lambda _, maneuver: maneuver.crossing_maneuvers,
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
    "signals": signals.signals_of,
    "route": lambda ev, intersection: Closure(
        ("start", "end"), lambda *arms: lanes.maneuver_by_arms(intersection, ev.algebra.span, *arms)
    ),
    "isSignalized": lambda ev, intersection: Truth(ev.algebra.truth(signals.is_signalized(ev, intersection))),
    "crossings": lambda _, intersection: streets.crossings_of(intersection),
    "roads": lambda _, intersection: tuple(dict.fromkeys(road_of(lane) for lane in intersection.incoming_lanes)),
}

_NETWORK: dict[str, Callable[[Evaluator, Network], Value]] = {
    "intersections": lambda _, network: network.intersections,
    "lanes": lambda _, network: network.lanes,
    "maneuvers": lambda _, network: network.maneuvers,
    "drivableRegion": lambda *_: ROAD,
    "intersectionRegion": lambda ev, _: region_of_intersections(ev, ev.algebra.span),
    "roadDirection": lambda *_: DirectionField(),
    "roads": lambda _, network: network.roads,
    "laneGroups": lambda _, network: tuple(group for road in network.roads for group in road.groups),
    "laneSections": lambda _, network: lanes.all_sections(network),
    "elements": lambda _, network: Elements(network),
    **streets.OF_NETWORK,
    **AT_POINTS,
}

_VECTOR: dict[str, Callable[[Evaluator, Vector], Value]] = {
    "x": lambda _, point: Quantity(point.x, None if isinstance(point, Coordinates) else LENGTH),
    "y": lambda _, point: Quantity(point.y, None if isinstance(point, Coordinates) else LENGTH),
    "z": lambda ev, _: Quantity(ev.algebra.literal(0.0), LENGTH),
    "position": lambda _, point: point,
}

_POSE: dict[str, Callable[[Evaluator, Pose], Value]] = {
    "x": lambda _, pose: Quantity(pose.x, LENGTH),
    "y": lambda _, pose: Quantity(pose.y, LENGTH),
    "position": lambda _, pose: Vector(pose.x, pose.y),
    "heading": lambda ev, pose: Quantity(as_written(ev, pose.heading), ANGLE),
}

_VELOCITY: dict[str, Callable[[Evaluator, Velocity], Value]] = {
    "x": lambda _, velocity: Quantity(velocity.x, SPEED),
    "y": lambda _, velocity: Quantity(velocity.y, SPEED),
}

_SIGNAL: dict[str, Callable[[Evaluator, Signal], Value]] = {
    "isTrafficLight": lambda ev, _: Truth(ev.algebra.truth(True)),
    "type": lambda *_: TRAFFIC_LIGHT,
    "timeToRed": lambda ev, light: Quantity(signals.time_to_red(ev, light), TIME),
    "intersection": lambda _, light: light.intersection,
    "name": lambda _, light: light.name,
}

_SIGN: dict[str, Callable[[Evaluator, RoadSign], Value]] = {
    "isTrafficLight": lambda ev, sign: Truth(ev.algebra.truth(sign.is_traffic_light)),
    "name": lambda _, sign: sign.name,
    "openDriveID": lambda _, sign: sign.id,
    "country": lambda _, sign: sign.country,
    "type": lambda _, sign: sign.type,
    "subtype": lambda _, sign: sign.subtype,
    "value": lambda ev, sign: None if sign.value is None else Quantity(ev.algebra.literal(sign.value), None),
    "position": lambda ev, sign: Vector(*map(ev.algebra.literal, (sign.x, sign.y))),
}

_OF_LISTS: dict[str, Callable[[Evaluator, Items], Value]] = {"append": lists.append}

_TABLES: tuple[tuple[type, Mapping[str, Callable[..., Value]]], ...] = (
    (LaneSection, lanes.OF_SECTION),
    (LaneGroup, {**lanes.OF_GROUP, **streets.OF_GROUP}),
    (Road, {**lanes.OF_ROAD, **streets.OF_ROAD, "crossingAt": _crossing_of}),
    (RoadSection, lanes.OF_ROAD_SECTION),
    (Signal, _SIGNAL),
    (RoadSign, _SIGN),
    (Lane, _LANE),
    (Maneuver, _MANEUVER),
    (Intersection, _INTERSECTION),
    (Network, _NETWORK),
    (Centerline, lanes.OF_CENTERLINE),
    (Alignment, alignments.OF_PATH),
    (Vector, {**_VECTOR, "visibleRegion": regions.visible_region}),
    (Pose, {**_POSE, "visibleRegion": regions.visible_region}),
    (Velocity, _VELOCITY),
)

_BY_TYPE: Mapping[type, Mapping[str, Callable[..., Value]]] = {
    kind: table for kind, table in _TABLES if kind is not LaneSection
}
"""Attributes of the types that have no others than those of their table."""

_BESIDE: tuple[tuple[type, Mapping[str, Callable[..., Value]]], ...] = (
    (SimulationNow, over_run.OF_SIMULATION),
    (Items, _OF_LISTS),
)
"""Types with attributes that are neither road elements nor places."""

_STATES: dict[str, tuple[State, ir.Dimension]] = {
    "speed": (State.SPEED, SPEED),
    "steer": (State.STEER, ANGLE),
    "throttle": (State.THROTTLE, PURE),
    "brake": (State.BRAKE, PURE),
}
"""Attributes of objects that the run changes, except the pose."""

POSE_ATTRIBUTES = frozenset(_POSE)
RUNNING_ATTRIBUTES = frozenset({*_STATES, "x", "y"} - {"speed"})
"""Attributes that a class cannot have as properties, since the run sets them."""

_OF_PLACE: Mapping[str, Callable[[Value], Value]] = {
    "lane": lambda lane: lane,
    "laneSection": lanes.as_section,
    "laneGroup": lambda lane: streets.group_now(lane, opposite=False),
    "oppositeLaneGroup": lambda lane: streets.group_now(lane, opposite=True),
}
"""Attributes of an object that concern its present lane; also with a leading `_`, as in Scenic."""

_OF_POINT: Mapping[str, str] = {"crossing": "crossingAt", "element": "elementAt"}
"""Attributes of an object that concern its present place; without a leading `_` the scene is rejected where there is
none."""


def attribute_names() -> frozenset[str]:
    """Every name that may follow a dot, properties and params aside."""
    beside = (name for name in lanes.OF_SECTION_BESIDE if not name.startswith("_"))
    own = (*relations.EDGES, *regions.attribute_names, *(name for of in streets.OF_SURFACE.values() for name in of))
    names = {
        *_STATES,
        *_OF_PLACE,
        *_OF_POINT,
        *_OF_ACTOR,
        *own,
        *beside,
        *driving.OF_OBJECTS,
        *(name for _, table in _TABLES for name in table),
    }
    return frozenset(name for name in names if not name.startswith("_"))


def get(ev: Evaluator, value: Value, name: str, span: Span) -> Value:
    """The attribute `name` of a value.

    Raises:
        Mistake: when the value has no such attribute.
    """
    if (known := _BY_TYPE.get(type(value))) is not None and name in known:  # as most are
        return known[name](ev, value)
    if isinstance(value, Actor):
        return _of_actor(ev, value, name, span)
    if isinstance(value, Unfinished):
        return value.attribute(name, span)
    if isinstance(value, Namespace):
        return ev.usable(_of(name, span, f"`{value.file}`", value.names))
    if isinstance(value, ScenarioCall):
        return _of_scenario(ev, value, name, span)
    if isinstance(value, EnumValue):
        return _of(name, span, "`ManeuverType`", {member.name: member for member in ManeuverType})
    if isinstance(value, GlobalParameters):
        if name not in ev.run.params:
            raise UNKNOWN_PARAM.mistake(span, name=name, suggestion=did_you_mean(name, ev.run.params))
        return ev.usable(ev.run.params[name])
    if isinstance(value, Area) and (found := regions.attribute(ev, value, name)) is not None:
        return found
    if name == "containsRegion" and (region := lanes.region_of(value)) is not None:
        return Closure(("other",), lambda other: regions.contains_rectangle(ev, region.id, other))
    if isinstance(value, LaneNow):
        return lanes.of_lane_now(ev, value, name, span)
    if isinstance(value, GroupNow):
        return streets.of_group_now(ev, value, name, span)
    value = lanes.chosen(value)
    if isinstance(value, Surface):
        return _of(name, span, kind_name(value), streets.OF_SURFACE[value.kind])(ev, value)
    if isinstance(value, Signal) and name in _SIGN.keys() - _SIGNAL and (sign := signals.sign_of(value)) is not None:
        return _SIGN[name](ev, sign)
    if isinstance(value, LaneSection) and name in lanes.OF_SECTION_BESIDE:
        return lanes.OF_SECTION_BESIDE[name](ev, value.lane, span)
    for kind, table in (*_TABLES, *_BESIDE):
        if isinstance(value, kind) and (name in table or kind is not Items):
            getter = table.get(name) or _of(name, span, kind_name(value), table)
            return getter(ev, value)
    cure = _of_an_item(value, name) if isinstance(value, tuple) else ""
    if isinstance(value, Area) and name in _NETWORK:
        cure = f"a region is only an area; for the map write `network.{name}`"
    raise UNKNOWN_ATTRIBUTE.mistake(span, kind=kind_name(value), name=name, suggestion=cure)


def _of_an_item(items: tuple[Value, ...], name: str) -> str:
    """Return a cure for an attribute that a list does not have; a trajectory is a list of lanes."""
    place = {"startLane": 0, "connectingLane": 1, "endLane": len(items) - 1}.get(name)
    if items and place is not None and place < len(items) and all(isinstance(item, Lane) for item in items):
        return f"it is a list of lanes; write `[{place}]` for this one"
    return "take one of its items, such as the first: `[0]`"


def _of(name: str, span: Span, kind: str, table: Mapping[str, Entry]) -> Entry:
    if name not in table:
        raise UNKNOWN_ATTRIBUTE.mistake(span, kind=kind, name=name, suggestion=did_you_mean(name, table))
    return table[name]


def _of_scenario(ev: Evaluator, call: ScenarioCall, name: str, span: Span) -> Value:
    """Return a variable of a scenario that the present one has started."""
    if call.instance is None:
        raise NOT_STARTED.mistake(span, name=call.name)
    return ev.usable(_of(name, span, f"the scenario `{call.name}`", call.instance.names))


def _of_actor(ev: Evaluator, actor: Actor, name: str, span: Span) -> Value:
    if name in _POSE:
        return _POSE[name](ev, current_pose(ev, actor))
    if name in _STATES and ev.moment.running:
        column, dimension = _STATES[name]
        return Quantity(state(ev, actor, column), dimension)
    if name in _STATES and name != "speed":
        raise ONLY_WHILE_RUNNING.mistake(span, what=f"`{name}` of an object")
    if name == "speed":
        check_settled(ev, actor)
    if name in actor.cells and (ev.moment.running or ev.moment.later):
        return changing(ev, actor, name)
    if name in actor.overridden and ev.moment.running:
        return _while_overridden(ev, actor, name)
    if name in actor.properties:
        return property_value(actor.properties[name], name)
    if name in _OF_ACTOR:
        return _OF_ACTOR[name](ev, actor)
    if (of_lane := _OF_PLACE.get(name.removeprefix("_"))) is not None:
        return of_lane(lane_under(ev, actor))
    if (finder := _OF_POINT.get(name.removeprefix("_"))) is not None:
        pose = current_pose(ev, actor)
        if finder == "crossingAt" and None in (closed_value(pose.x), closed_value(pose.y)):
            return streets.crossing_now(ev, pose, span, must=not name.startswith("_"))
        return _surface(ev, actor, finder, not name.startswith("_"))
    if name in relations.EDGES:
        return relations.edge_of(ev, actor, relations.EDGES[name])
    if name == "lastActions":
        raise LAST_ACTIONS.mistake(span, name=actor.name)
    if (of_object := driving.OF_OBJECTS.get(name)) is not None:
        return of_object(ev, actor, span)
    raise UNKNOWN_ATTRIBUTE.mistake(
        span,
        kind=kind_name(actor),
        name=name,
        suggestion=did_you_mean(name, {*_POSE, *_STATES, *PROPERTIES, *actor.properties}),
    )


_OF_ACTOR: Mapping[str, Callable[[Evaluator, Actor], Value]] = {
    "velocity": relations.velocity,
    "angularSpeed": relations.angular_speed,
    "visibleRegion": regions.visible_region,
}


def changing(ev: Evaluator, actor: Actor, name: str) -> Quantity | Truth:
    """Return a property during the run: its latest assigned value, or its first value."""
    cell, first = actor.cells[name], actor.properties[name]
    assert isinstance(first, Quantity | Truth)
    return replace(first, expr=where(ev.algebra.local(cell.assigned), ev.algebra.local(cell.value), first.expr))


def _while_overridden(ev: Evaluator, actor: Actor, name: str) -> Quantity | Truth:
    """Return a property that scenarios may override: the value of the last running scenario in the list decides."""
    result = actor.properties[name]
    assert isinstance(result, Quantity | Truth)
    for monitor, value in actor.overridden[name]:
        result = replace(value, expr=where(ev.algebra.running(monitor), value.expr, result.expr))
    return result


def property_value(value: Value, name: str) -> Value:
    """A stored property as the language sees it."""
    if isinstance(value, Term):
        if PROPERTIES[name].truth:
            return Truth(value)
        return Quantity(value, PROPERTIES[name].dimension)
    return value
