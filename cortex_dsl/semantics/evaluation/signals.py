"""Traffic lights: the `signals` statement, the colour of a light at a moment, and the lights of actors.

A light's colour is arithmetic over the clock: its phase begins `phase * (green + yellow + all_red)` into the plan, is
green, then yellow, then red until the plan starts again. Behaviours and monitors may stop the clock and set a light;
the light stays in that colour until its next change in the plan, which never comes while the clock is stopped.
"""

import re
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import DUPLICATE, NOT_SUPPORTED, UNKNOWN_ARGUMENT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.scene import NO_SIGNALS, SCENIC_SIGNALS, SIGNALS_TWICE, SIGNALS_UNUSED, UNKNOWN_COLOUR
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_arguments
from cortex_dsl.semantics.evaluation.geometry import current_pose, size_of, state
from cortex_dsl.semantics.evaluation.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.state import (
    COLOURS,
    DEFAULT_ALL_RED,
    DEFAULT_GREEN,
    DEFAULT_YELLOW,
    GREEN,
    NONE,
    PHASES,
    RED,
    YELLOW,
    Controls,
    SignalPlan,
)
from cortex_dsl.semantics.model.values import Actor, Colour, Pose, Signal, Value
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Operand, Term, equal, floor, path_project, where
from cortex_dsl.semantics.quantities.units import TIME
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.road.lights import lit_arms, signs_at
from engine.road.network import Intersection, Lane, RoadSign
from engine.vocabulary import State

ARGUMENTS = ("green", "yellow", "all_red", "offset")
CONTROLS = ("TrafficLightStatus(", "TrafficLightsStatus(", "reezeTrafficLights(")
"""Calls that change the lights."""
LOOKS = re.compile(r"obey_signals|TrafficLight|\bisSignalized\b|\.signals?\b")
"""Pattern of names that show that actors of a file react to lights."""


# -- the statement ----------------------------------------------------------------------------------------------------


def set_up(ev: Evaluator, node: nodes.Signals) -> None:
    """`signals(...)`: all intersections have lights of one plan."""
    if ev.run.built.signals is not None:
        raise SIGNALS_TWICE.mistake(node.span)
    if not LOOKS.search(_code(ev)):
        ev.report(SIGNALS_UNUSED.at(node.span))
    try:
        ev.run.built.signals = _plan(ev, _arguments(ev, node))
    except Mistake:
        ev.run.built.signals = _plan(ev, {})  # a file without lights needs no note
        raise


def _arguments(ev: Evaluator, node: nodes.Signals) -> dict[str, Given]:
    given: dict[str, Given] = {}
    for argument in evaluate_arguments(ev, node.arguments):
        _check_name(argument, given)
        given[argument.name or ""] = argument
    return given


def _check_name(argument: Given, seen: dict[str, Given]) -> None:
    name = argument.name
    if name is None:
        raise NOT_SUPPORTED.mistake(
            argument.span, what="`signals` takes its arguments by name", reason="", cure="as in `green=10 s`"
        )
    if name not in ARGUMENTS:
        suggestion = did_you_mean(name, ARGUMENTS)
        raise UNKNOWN_ARGUMENT.mistake(argument.place, function="signals", name=name, suggestion=suggestion)
    if name in seen:
        raise DUPLICATE.mistake(argument.place, what="the argument", name=name)


def _plan(ev: Evaluator, given: dict[str, Given]) -> SignalPlan:
    def time(name: str, default: float, low: float, *, above: bool = False) -> Term:
        if name not in given:
            return ev.algebra.literal(default)
        what, argument = f"`{name}` of the lights", given[name]
        expr = numbers.adopt(ev, argument.value, TIME, argument.span, what)
        return in_range(ev, expr, Domain(what, TIME, low, 1e5, above), argument.span)

    green, yellow = time("green", DEFAULT_GREEN, 0.0, above=True), time("yellow", DEFAULT_YELLOW, 0.0)
    plan = SignalPlan(green, yellow, time("all_red", DEFAULT_ALL_RED, 0.0), time("offset", 0.0, -1e5))
    return replace(plan, controls=_controls(ev)) if any(word in _code(ev) for word in CONTROLS) else plan


def _controls(ev: Evaluator) -> Controls:
    network, new = network_of(ev), ev.run.new_local
    count = len(network.intersections) * network.arms
    colours, changes = (tuple(new() for _ in range(count)) for _ in range(2))
    return Controls(new(), new(), new(), colours, changes)


def _code(ev: Evaluator) -> str:
    """The text of the file without comments."""
    return re.sub(r"#[^\n]*", "", ev.facts.source.text)


def plan_of(ev: Evaluator) -> SignalPlan | None:
    """Return the plan of the lights; a script with one of Scenic's maps that reads lights gets a default plan."""
    if ev.run.built.signals is None and ev.facts.default_signals is not None:
        ev.report(SCENIC_SIGNALS.at(ev.facts.default_signals))
        ev.run.built.signals = _plan(ev, {})
    return ev.run.built.signals


def needed(ev: Evaluator, span: Span, what: str) -> SignalPlan:
    plan = plan_of(ev)
    if plan is None:
        raise NO_SIGNALS.mistake(span, what=what)
    return plan


# -- which light ------------------------------------------------------------------------------------------------------


def _arm_of(lane: Lane) -> int:
    intersection = lane.intersection
    assert intersection is not None
    return next(i for i, leg in enumerate(intersection.legs) if lane in leg.incoming_lanes)


def number_of(light: Signal) -> int:
    return light.intersection.id * light.intersection.network.arms + light.arm


def light_of(lane: Lane) -> Signal | None:
    """The light at the end of a lane; None where it leads into no intersection, or the map's file has none there."""
    if lane.intersection is None or not lane.maneuvers:
        return None
    light = Signal(lane.intersection, _arm_of(lane))
    return light if is_there(light) else None


def is_there(light: Signal) -> bool:
    """Return whether the map file has a light there; if it has no lights at all, every arm has one."""
    lit = lit_arms(light.intersection.network)
    return lit is None or (light.intersection.id, light.arm) in lit


def sign_of(light: Signal) -> RoadSign | None:
    """Return the sign of a light in the map file; None without one."""
    return (lit_arms(light.intersection.network) or {}).get((light.intersection.id, light.arm))


def lights(ev: Evaluator, intersection: Intersection) -> tuple[Signal, ...]:
    """Return the lights of the arms that have one; () if the scenario has no lights."""
    every = (Signal(intersection, i) for i in range(len(intersection.legs)))
    return () if plan_of(ev) is None else tuple(light for light in every if is_there(light))


def signals_of(ev: Evaluator, intersection: Intersection) -> tuple[Signal | RoadSign, ...]:
    """Return the lights and signs of an intersection; lights come from the map file unless the scenario has a plan."""
    shown = lights(ev, intersection)
    signs = [each for each in signs_at(intersection.network, intersection.id) if not (shown and each.is_traffic_light)]
    if not shown:
        arms = (sign_of(Signal(intersection, arm)) for arm in range(len(intersection.legs)))
        signs += [each for each in dict.fromkeys(filter(None, arms)) if each not in signs]
    return (*shown, *signs)


def is_signalized(ev: Evaluator, intersection: Intersection) -> bool:
    """Return whether it has lights: by the map file if that has any lights, else by the plan."""
    if lit_arms(intersection.network) is None:
        return plan_of(ev) is not None
    return any(is_there(Signal(intersection, i)) for i in range(len(intersection.legs)))


def phase_of(light: Signal) -> int:
    return light.intersection.legs[light.arm].phase


@frozen
class Ahead:
    """The light at the end of the lane that an object is on."""

    light: Term
    """Its number; -1 where the lane has none."""
    phase: Term
    distance: Term
    """Distance from the centre of the object to the stop line, along the lane [m]."""

    def within(self, reach: Term) -> Term:
        return (self.light >= 0.0) & (self.distance < reach)


def ahead_of(ev: Evaluator, actor: Actor) -> Ahead:
    network, pose = network_of(ev), current_pose(ev, actor)
    lane = index_of(ev, lane_at(ev, Pose(pose.x, pose.y, pose.heading)))
    assert lane is not None
    seen = [light_of(each) for each in network.lanes]
    number = looked_up(ev, lane, [-1 if light is None else number_of(light) for light in seen])
    phase = looked_up(ev, lane, [0 if light is None else phase_of(light) for light in seen], missing=0.0)
    path = looked_up(ev, lane, [each.path for each in network.lanes], missing=0.0)
    length = looked_up(ev, lane, [each.length for each in network.lanes], missing=0.0)
    s = path_project(path, pose.x, pose.y)
    return Ahead(number, phase, length - s)


# -- colours -----------------------------------------------------------------------------------------------------------


def clock(ev: Evaluator, plan: SignalPlan) -> Term:
    """The time that the lights have run [s]."""
    algebra, now = ev.algebra, ev.algebra.time()
    if plan.controls is None:
        return now
    running = now - algebra.local(plan.controls.lost)
    frozen, frozen_at = algebra.local(plan.controls.frozen), algebra.local(plan.controls.frozen_at)
    return where(frozen, frozen_at, running)


@frozen
class Showing:
    """Colour by the plan, and how often the plan has changed it so far."""

    colour: Term
    changes: Term


def by_plan(ev: Evaluator, plan: SignalPlan, phase: Term) -> Showing:
    part = plan.green + (plan.yellow + plan.all_red)
    cycle = part * float(PHASES)
    since = clock(ev, plan) + plan.offset - phase * part
    rounds = floor(since / cycle)
    into = since - rounds * cycle
    is_green = into < plan.green
    is_yellow = into < plan.green + plan.yellow
    not_green = where(is_yellow, float(YELLOW), float(RED))
    colour = where(is_green, float(GREEN), not_green)
    return Showing(colour, rounds * 3.0 + colour)


def _shown(ev: Evaluator, plan: SignalPlan, light: Term, phase: Term) -> Term:
    """The colour of a light that is there."""
    showing = by_plan(ev, plan, phase)
    if plan.controls is None:
        return showing.colour
    given = _entry(ev, light, plan.controls.colours)
    lasts = equal(_entry(ev, light, plan.controls.changes), showing.changes)
    is_set = lasts & (given > float(NONE))
    return where(is_set, given, showing.colour)


def _entry(ev: Evaluator, light: Term, locals_: tuple[int, ...]) -> Term:
    if isinstance(light, ir.Literal):
        return ev.algebra.local(locals_[int(light.value)])
    return ev.algebra.chosen(light, [ev.algebra.local(each) for each in locals_])


def colour_ahead(ev: Evaluator, actor: Actor, reach: Term, plan: SignalPlan) -> Term:
    """Return the colour of the light ahead; NONE without a light within reach."""
    ahead = ahead_of(ev, actor)
    shown = _shown(ev, plan, ahead.light, ahead.phase)
    return where(ahead.within(reach), shown, float(NONE))


def colour_of(ev: Evaluator, light: Signal, plan: SignalPlan) -> Term:
    number, phase = ev.algebra.literal(float(number_of(light))), ev.algebra.literal(float(phase_of(light)))
    return _shown(ev, plan, number, phase)


def time_to_red(ev: Evaluator, light: Signal) -> Term:
    """Return the time until a light next turns red by its plan [s]; before the run, counted from its start."""
    plan = needed(ev, ev.algebra.span, "`timeToRed`")
    part, amber_end = plan.green + (plan.yellow + plan.all_red), plan.green + plan.yellow
    cycle = part * float(PHASES)
    now = clock(ev, plan) if ev.moment.running or ev.moment.later else ev.algebra.literal(0.0)
    left = amber_end - (now + plan.offset - float(phase_of(light)) * part)
    return left - floor(left / cycle) * cycle


def same_colour(ev: Evaluator, left: Value, right: Value, span: Span) -> Term | None:
    """Return whether a light shows a colour; None if neither side is a light.

    Raises:
        Mistake: the other side is no colour.
    """
    if not (isinstance(left, Colour) or isinstance(right, Colour)):
        return None
    one, other = (_colour_index(ev, each, span) for each in (left, right))
    return equal(one, other)


def _colour_index(ev: Evaluator, value: Value, span: Span) -> Term:
    if isinstance(value, Colour):
        return value.index
    name = "None" if value is None else value
    if isinstance(name, str) and name in COLOURS:
        return ev.algebra.literal(float(COLOURS.index(name)))
    raise unknown_colour(value, span)


def unknown_colour(value: Value, span: Span) -> Exception:
    actual = f'"{value}"' if isinstance(value, str) else kind_name(value)
    near = did_you_mean(value, COLOURS[1:]) if isinstance(value, str) else ""
    choices = ", ".join(f'"{name}"' for name in COLOURS[1:])
    return UNKNOWN_COLOUR.mistake(span, actual=actual, suggestion=near or f"one of {choices}")


# -- driving by them --------------------------------------------------------------------------------------------------

COMFORTABLE = 3.4
"""Deceleration with which drivers stop for yellow [m/s^2]: AASHTO, Policy on Geometric Design (2011), section 3.2.2."""


def must_stop(ev: Evaluator, actor: Actor, span: Span) -> tuple[Term, Term]:
    """Return whether an object must stop for the light ahead, and the distance of its front to the stop line [m]."""
    plan = needed(ev, span, "`obey_signals`")
    ahead, speed = ahead_of(ev, actor), state(ev, actor, State.SPEED)
    shown = _shown(ev, plan, ahead.light, ahead.phase)
    room = ahead.distance - size_of(actor, "length") * 0.5
    energy = 0.5 * (speed * speed)

    def stops(colour: int, braking: Operand) -> Term:
        can = energy <= braking * room
        return equal(shown, float(colour)) & can

    red = stops(RED, size_of(actor, "maxBraking"))
    yellow = stops(YELLOW, COMFORTABLE)
    return (ahead.light >= 0.0) & (red | yellow), room
