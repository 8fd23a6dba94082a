"""Functions of Scenic's driving domain and of its CARLA model: nearby objects, and traffic lights.

Behaviours and monitors change lights by setting a light or stopping the clock of all lights. Names and meaning are
those of Scenic's driving domain: distances are from centre to centre.
"""

import math
from collections.abc import Callable, Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.errors.runs import NOT_JUDGED, ONLY_WHILE_RUNNING
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import signals
from cortex_dsl.semantics.evaluation.arguments import Given, number_for
from cortex_dsl.semantics.evaluation.functions import Meaning
from cortex_dsl.semantics.evaluation.geometry import between, current_pose, is_present, others, size_of
from cortex_dsl.semantics.evaluation.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import sees
from cortex_dsl.semantics.evaluation.signals import (
    ahead_of,
    by_plan,
    clock,
    needed,
    number_of,
    phase_of,
    unknown_colour,
)
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.state import COLOURS, RED, YELLOW, SignalPlan, WarningCells
from cortex_dsl.semantics.model.values import (
    Actor,
    BuiltinValue,
    Closure,
    Colour,
    Effect,
    Pose,
    Quantity,
    Signal,
    Truth,
    Value,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import ACTOR_KINDS
from cortex_dsl.semantics.names.tree import WARNINGS
from cortex_dsl.semantics.quantities.algebra import Term, cos, equal, region_contains, sin, where
from cortex_dsl.semantics.quantities.units import LENGTH, TIME
from cortex_dsl.source import Span
from engine.road.network import Intersection
from engine.vocabulary import ActorKind

NOT_VEHICLES = frozenset({ActorKind.PEDESTRIAN, ActorKind.OBSTACLE})


def actor_of(argument: Given, what: str) -> Actor:
    if isinstance(argument.value, Actor):
        return argument.value
    actual = kind_name(argument.value)
    raise WRONG_KIND.mistake(argument.span, what=what, expected="an object", actual=actual, cure="write `self`")


def while_running(ev: Evaluator, span: Span, name: str) -> None:
    if not ev.moment.running:
        raise ONLY_WHILE_RUNNING.mistake(span, what=f"`{name}`")


def _near(one: Pose, other: Pose, limit: Term) -> Term:
    return between(one, other) < limit


def _limit(ev: Evaluator, name: str, distance: Given) -> Term:
    return number_for(ev, BUILTINS[name].parameters[1], distance)


def any_cars(ev: Evaluator, car: Given, distance: Given, span: Span) -> Value:
    """Return whether another vehicle, seen or not, is near."""
    while_running(ev, span, "withinDistanceToAnyCars")
    actor, limit = actor_of(car, "`car`"), _limit(ev, "withinDistanceToAnyCars", distance)
    here = current_pose(ev, actor)
    return Truth(
        ev.algebra.any_of(
            [
                ev.algebra.all_of((is_present(ev, each), _near(here, current_pose(ev, each), limit)))
                for each in others(ev, actor)
                if each.kind not in NOT_VEHICLES
            ],
        )
    )


def any_pedestrians(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    """Return whether a person that the vehicle sees is near its front."""
    while_running(ev, span, "withinDistanceToAnyPedestrians")
    actor, limit = actor_of(vehicle, "`vehicle`"), _limit(ev, "withinDistanceToAnyPedestrians", distance)
    front = _front(ev, actor)
    return Truth(
        ev.algebra.any_of(
            [
                ev.algebra.all_of(
                    (is_present(ev, each), _near(front, current_pose(ev, each), limit), sees(ev, actor, each))
                )
                for each in others(ev, actor)
                if each.kind is ActorKind.PEDESTRIAN
            ],
        )
    )


def _front(ev: Evaluator, actor: Actor) -> Pose:
    """The middle of the front of the outline."""
    pose = current_pose(ev, actor)
    half = size_of(actor, "length") * 0.5
    x = pose.x + half * cos(pose.heading)
    y = pose.y + half * sin(pose.heading)
    return Pose(x, y, pose.heading)


def objects_in_lane(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    """Return whether the vehicle sees another vehicle nearby in the same lane, or in the same intersection."""
    while_running(ev, span, "withinDistanceToObjsInLane")
    actor, limit = actor_of(vehicle, "`vehicle`"), _limit(ev, "withinDistanceToObjsInLane", distance)
    here = current_pose(ev, actor)
    return Truth(ev.algebra.any_of([_in_lane(ev, actor, here, each, limit) for each in others(ev, actor)]))


def _in_lane(ev: Evaluator, actor: Actor, here: Pose, other: Actor, limit: Term) -> Term:
    there = current_pose(ev, other)
    near = _near(here, there, limit)
    return ev.algebra.all_of((is_present(ev, other), near, sees(ev, actor, other), together(ev, here, there)))


def together(ev: Evaluator, here: Pose, there: Pose) -> Term:
    """Return whether two places lie in one intersection, or in one lane outside of it."""
    network = network_of(ev)
    lane = index_of(ev, lane_at(ev, here))
    assert lane is not None
    areas = [
        float(each.region if each.intersection is None or each.maneuvers else each.intersection.region)
        for each in network.lanes
    ]
    region = looked_up(ev, lane, areas, missing=0.0)
    return region_contains(region, there.x, there.y)


def distance_to_closest(ev: Evaluator, actor: Actor, kind: Value, span: Span) -> Value:
    """Return the distance to the nearest other object of a class [m]; infinite without one."""
    if not isinstance(kind, BuiltinValue) or kind.name not in ACTOR_KINDS:
        raise WRONG_KIND.mistake(
            span, what="`distanceToClosest`", expected="a class", actual=kind_name(kind), cure="as in `Car`"
        )
    while_running(ev, span, "distanceToClosest")
    wanted = ACTOR_KINDS[kind.name]
    return Quantity(closest(ev, actor, [each for each in others(ev, actor) if each.kind is wanted]), LENGTH)


def collided(ev: Evaluator, actor: Actor, span: Span) -> Value:
    """Return `self.collided`: whether the ego has touched any actor."""
    if not ev.moment.judged or actor is not ev.run.ego:
        raise NOT_JUDGED.mistake(span)
    return Truth(ev.algebra.touches())


# -- warnings ----------------------------------------------------------------------------------------------------------

NEVER = -1.0
"""`timeSinceWarning` before the first warning [s]."""


def warning_cells(ev: Evaluator, actor: Actor) -> WarningCells:
    """Return the locals of the warnings of an actor, made at the first use."""
    new, cells = ev.run.new_local, ev.run.built.warnings
    if actor.index not in cells:
        cells[actor.index] = WarningCells(new(), new(), new())
    return cells[actor.index]


def is_warning(ev: Evaluator, actor: Actor, span: Span) -> Value:
    while_running(ev, span, "isWarning")
    return Truth(ev.algebra.local(warning_cells(ev, actor).now) > 0.0)


def time_since_warning(ev: Evaluator, actor: Actor) -> Term:
    """Return the time since the first warning [s]; `NEVER` before it."""
    begun = ev.algebra.local(warning_cells(ev, actor).begun)
    return where(begun > 0.0, ev.algebra.time() + 1.0 - begun, NEVER)


def _since_warning(ev: Evaluator, actor: Actor, span: Span) -> Value:
    while_running(ev, span, "timeSinceWarning")
    return Quantity(time_since_warning(ev, actor), TIME)


def _warning_ttc(ev: Evaluator, actor: Actor, span: Span) -> Value:
    while_running(ev, span, "warningTTC")
    return Quantity(ev.algebra.local(warning_cells(ev, actor).ttc), TIME)


OF_OBJECTS: Mapping[str, Callable[[Evaluator, Actor, Span], Value]] = {
    "distanceToClosest": lambda ev, actor, span: Closure(
        ("type",), lambda kind: distance_to_closest(ev, actor, kind, span)
    ),
    "collided": collided,
    **dict(zip(WARNINGS, (is_warning, _since_warning, _warning_ttc), strict=True)),
}
"""Attributes that only objects have, except their state and place."""


def closest(ev: Evaluator, actor: Actor, candidates: list[Actor]) -> Term:
    """Return the least distance to present objects [m]; infinite without any."""
    here = current_pose(ev, actor)
    distances = [where(is_present(ev, each), between(here, current_pose(ev, each)), math.inf) for each in candidates]
    return ev.algebra.least(distances)


def time_to_collision(ev: Evaluator, first: Given, second: Given | None, span: Span) -> Value:
    """Return the time until two outlines touch at constant velocities [s]; without `second`, the least over all."""
    while_running(ev, span, "timeToCollision")
    actor = actor_of(first, "`object`")
    other = -1 if second is None or second.value is None else actor_of(second, "`other`").index
    return Quantity(ev.algebra.time_to_contact(actor.index, other), TIME)


# -- changing the lights: acts -----------------------------------------------------------------------------------------


def named_colour(value: Value, span: Span) -> float:
    if isinstance(value, str) and value in COLOURS[1:]:
        return float(COLOURS.index(value))
    raise unknown_colour(value, span)


def set_light(ev: Evaluator, plan: SignalPlan, light: Signal, colour: float, span: Span) -> ir.Block:
    controls = plan.controls
    assert controls is not None, "the file changes lights, so there are locals for it"
    number, phase = number_of(light), ev.algebra.literal(float(phase_of(light)))
    return (
        ir.SetLocal(span, controls.changes[number], by_plan(ev, plan, phase).changes),
        ir.SetLocal(span, controls.colours[number], ev.algebra.literal(colour)),
    )


def set_light_ahead(ev: Evaluator, actor: Actor, colour: float, reach: Term, span: Span) -> Effect:
    """Set the light that an object comes to, if it is within reach."""
    plan = needed(ev, span, "`setClosestTrafficLightStatus`")
    ahead = ahead_of(ev, actor)
    within = ahead.within(reach)
    acts: list[ir.Act] = []
    for intersection in network_of(ev).intersections:
        for light in signals.lights(ev, intersection):
            this = equal(ahead.light, float(number_of(light)))
            condition = within & this
            acts.append(ir.Branch(span, condition, set_light(ev, plan, light, colour, span), ()))
    return Effect(tuple(acts))


def freeze(ev: Evaluator, span: Span) -> Effect:
    """Stop the clock of the lights."""
    plan = needed(ev, span, "`freezeTrafficLights`")
    assert plan.controls is not None
    return Effect(
        (
            ir.SetLocal(span, plan.controls.frozen_at, clock(ev, plan)),
            ir.SetLocal(span, plan.controls.frozen, ev.algebra.truth(True)),
        )
    )


def unfreeze(ev: Evaluator, span: Span) -> Effect:
    """Restart the clock of the lights at the time at which it was stopped."""
    plan, algebra = needed(ev, span, "`unfreezeTrafficLights`"), ev.algebra
    assert plan.controls is not None
    frozen, lost = algebra.local(plan.controls.frozen), algebra.local(plan.controls.lost)
    stood = algebra.time() - algebra.local(plan.controls.frozen_at)
    return Effect(
        (
            ir.SetLocal(span, plan.controls.lost, where(frozen, stood, lost)),
            ir.SetLocal(span, plan.controls.frozen, algebra.truth(False)),
        )
    )


# -- the functions -----------------------------------------------------------------------------------------------------

REACH = 100.0
"""How far lights are looked for unless a call says otherwise; Scenic's default [m]."""


def _reach(ev: Evaluator, name: str, distance: Given | None) -> Term:
    parameter = next(p for p in BUILTINS[name].parameters if "istance" in p.name)
    return ev.algebra.literal(REACH) if distance is None else number_for(ev, parameter, distance)


# -- looking at lights ------------------------------------------------------------------------------------------------


def _shown_ahead(ev: Evaluator, name: str, vehicle: Given, distance: Given | None, span: Span) -> Term:
    while_running(ev, span, name)
    plan = signals.needed(ev, span, f"`{name}`")
    return signals.colour_ahead(ev, actor_of(vehicle, "`vehicle`"), _reach(ev, name, distance), plan)


def _closest_status(ev: Evaluator, vehicle: Given, distance: Given | None, span: Span) -> Value:
    return Colour(_shown_ahead(ev, "getClosestTrafficLightStatus", vehicle, distance, span))


def _within_light(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    while_running(ev, span, "withinDistanceToTrafficLight")
    signals.needed(ev, span, "`withinDistanceToTrafficLight`")
    ahead = signals.ahead_of(ev, actor_of(vehicle, "`vehicle`"))
    return Truth(ahead.within(_reach(ev, "withinDistanceToTrafficLight", distance)))


def _within_red_yellow(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    shown = _shown_ahead(ev, "withinDistanceToRedYellowTrafficLight", vehicle, distance, span)
    return Truth(equal(shown, float(RED)) | equal(shown, float(YELLOW)))


def _status(ev: Evaluator, light: Given, span: Span) -> Value:
    while_running(ev, span, "getTrafficLightStatus")
    plan = signals.needed(ev, span, "`getTrafficLightStatus`")
    return Colour(signals.colour_of(ev, _light(light), plan))


def _light(given: Given) -> Signal:
    if isinstance(given.value, Signal):
        return given.value
    actual = kind_name(given.value)
    cure = "as in `lane.signal`, or one of `intersection.signals`"
    raise WRONG_KIND.mistake(given.span, what="`signal`", expected="a traffic light", actual=actual, cure=cure)


# -- changing them ----------------------------------------------------------------------------------------------------


def _set_closest(ev: Evaluator, vehicle: Given, color: Given, distance: Given | None, span: Span) -> Value:
    while_running(ev, span, "setClosestTrafficLightStatus")
    actor = actor_of(vehicle, "`vehicle`")
    colour = named_colour(color.value, color.span)
    return set_light_ahead(ev, actor, colour, _reach(ev, "setClosestTrafficLightStatus", distance), span)


def _set(ev: Evaluator, light: Given, color: Given, span: Span) -> Value:
    while_running(ev, span, "setTrafficLightStatus")
    plan = signals.needed(ev, span, "`setTrafficLightStatus`")
    return Effect(set_light(ev, plan, _light(light), named_colour(color.value, color.span), span))


def _set_all(ev: Evaluator, intersection: Given, color: Given, span: Span) -> Value:
    while_running(ev, span, "setAllIntersectionTrafficLightsStatus")
    plan = signals.needed(ev, span, "`setAllIntersectionTrafficLightsStatus`")
    if not isinstance(intersection.value, Intersection):
        what, actual = "`intersection`", kind_name(intersection.value)
        raise WRONG_KIND.mistake(intersection.span, what=what, expected="an intersection", actual=actual, cure="")
    colour = named_colour(color.value, color.span)
    lights = signals.lights(ev, intersection.value)
    return Effect(tuple(act for light in lights for act in set_light(ev, plan, light, colour, span)))


def _freeze(ev: Evaluator, span: Span) -> Value:
    while_running(ev, span, "freezeTrafficLights")
    return freeze(ev, span)


def _unfreeze(ev: Evaluator, span: Span) -> Value:
    while_running(ev, span, "unfreezeTrafficLights")
    return unfreeze(ev, span)


MEANINGS: Mapping[str, Meaning] = {
    "withinDistanceToAnyCars": any_cars,
    "withinDistanceToAnyPedestrians": any_pedestrians,
    "withinDistanceToObjsInLane": objects_in_lane,
    "timeToCollision": time_to_collision,
    "getClosestTrafficLightStatus": _closest_status,
    "withinDistanceToTrafficLight": _within_light,
    "withinDistanceToRedYellowTrafficLight": _within_red_yellow,
    "getTrafficLightStatus": _status,
    "setClosestTrafficLightStatus": _set_closest,
    "setTrafficLightStatus": _set,
    "setAllIntersectionTrafficLightsStatus": _set_all,
    "freezeTrafficLights": _freeze,
    "unfreezeTrafficLights": _unfreeze,
}
