"""Functions of Scenic's driving domain and of its CARLA model: who is near, and the traffic lights."""

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.builtins import BUILTINS
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.evaluation import nearby
from cortex_dsl.semantics.evaluation.arguments import Given, number_for
from cortex_dsl.semantics.evaluation.functions import function
from cortex_dsl.semantics.road import signal_changes, signals
from cortex_dsl.semantics.road.signal_plan import RED, YELLOW
from cortex_dsl.semantics.values import Colour, Effect, Signal, Truth, Value
from cortex_dsl.semantics.wording import kind_name
from cortex_dsl.source import Span
from engine.road.network import Intersection
from engine.vocabulary import Op

REACH = 100.0
"""How far lights are looked for unless a call says otherwise; Scenic's default [m]."""

for _name, _meaning in {
    "withinDistanceToAnyCars": nearby.any_cars,
    "withinDistanceToAnyPedestrians": nearby.any_pedestrians,
    "withinDistanceToObjsInLane": nearby.objects_in_lane,
    "timeToCollision": nearby.time_to_collision,
}.items():
    function(_name)(_meaning)


def _reach(ev: Evaluator, name: str, distance: Given | None) -> ir.Expr:
    parameter = next(p for p in BUILTINS[name].parameters if "istance" in p.name)
    return ev.algebra.literal(REACH) if distance is None else number_for(ev, parameter, distance)


# -- looking at lights ------------------------------------------------------------------------------------------------


def _shown_ahead(ev: Evaluator, name: str, vehicle: Given, distance: Given | None, span: Span) -> ir.Expr:
    nearby.while_running(ev, span, name)
    plan = signals.needed(ev, span, f"`{name}`")
    return signals.colour_ahead(ev, nearby.actor_of(vehicle, "`vehicle`"), _reach(ev, name, distance), plan)


@function("getClosestTrafficLightStatus")
def _closest_status(ev: Evaluator, vehicle: Given, distance: Given | None, span: Span) -> Value:
    return Colour(_shown_ahead(ev, "getClosestTrafficLightStatus", vehicle, distance, span))


@function("withinDistanceToTrafficLight")
def _within_light(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    nearby.while_running(ev, span, "withinDistanceToTrafficLight")
    signals.needed(ev, span, "`withinDistanceToTrafficLight`")
    ahead = signals.ahead_of(ev, nearby.actor_of(vehicle, "`vehicle`"))
    return Truth(ahead.within(ev, _reach(ev, "withinDistanceToTrafficLight", distance)))


@function("withinDistanceToRedYellowTrafficLight")
def _within_red_yellow(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    shown = _shown_ahead(ev, "withinDistanceToRedYellowTrafficLight", vehicle, distance, span)
    is_colour = [ev.algebra.apply(Op.EQ, shown, ev.algebra.literal(float(each))) for each in (RED, YELLOW)]
    return Truth(ev.algebra.apply(Op.OR, *is_colour))


@function("getTrafficLightStatus")
def _status(ev: Evaluator, light: Given, span: Span) -> Value:
    nearby.while_running(ev, span, "getTrafficLightStatus")
    plan = signals.needed(ev, span, "`getTrafficLightStatus`")
    return Colour(signals.colour_of(ev, _light(light), plan))


def _light(given: Given) -> Signal:
    if isinstance(given.value, Signal):
        return given.value
    actual = kind_name(given.value)
    cure = "as in `lane.signal`, or one of `intersection.signals`"
    raise errors.WRONG_KIND.mistake(given.span, what="`signal`", expected="a traffic light", actual=actual, cure=cure)


# -- changing them ----------------------------------------------------------------------------------------------------


@function("setClosestTrafficLightStatus")
def _set_closest(ev: Evaluator, vehicle: Given, color: Given, distance: Given | None, span: Span) -> Value:
    nearby.while_running(ev, span, "setClosestTrafficLightStatus")
    actor = nearby.actor_of(vehicle, "`vehicle`")
    colour = signal_changes.named_colour(color.value, color.span)
    return signal_changes.set_light_ahead(ev, actor, colour, _reach(ev, "setClosestTrafficLightStatus", distance), span)


@function("setTrafficLightStatus")
def _set(ev: Evaluator, light: Given, color: Given, span: Span) -> Value:
    nearby.while_running(ev, span, "setTrafficLightStatus")
    plan = signals.needed(ev, span, "`setTrafficLightStatus`")
    return Effect(
        signal_changes.set_light(ev, plan, _light(light), signal_changes.named_colour(color.value, color.span), span)
    )


@function("setAllIntersectionTrafficLightsStatus")
def _set_all(ev: Evaluator, intersection: Given, color: Given, span: Span) -> Value:
    nearby.while_running(ev, span, "setAllIntersectionTrafficLightsStatus")
    plan = signals.needed(ev, span, "`setAllIntersectionTrafficLightsStatus`")
    if not isinstance(intersection.value, Intersection):
        actual = kind_name(intersection.value)
        raise errors.WRONG_KIND.mistake(
            intersection.span, what="`intersection`", expected="an intersection", actual=actual, cure=""
        )
    colour = signal_changes.named_colour(color.value, color.span)
    lights = signals.lights(ev, intersection.value)
    return Effect(tuple(act for light in lights for act in signal_changes.set_light(ev, plan, light, colour, span)))


@function("freezeTrafficLights")
def _freeze(ev: Evaluator, span: Span) -> Value:
    nearby.while_running(ev, span, "freezeTrafficLights")
    return signal_changes.freeze(ev, span)


@function("unfreezeTrafficLights")
def _unfreeze(ev: Evaluator, span: Span) -> Value:
    nearby.while_running(ev, span, "unfreezeTrafficLights")
    return signal_changes.unfreeze(ev, span)
