"""Behaviours and monitors that change the traffic lights: they set a light, or stop the clock of all."""

from cortex_dsl import ir
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.road.roads import network_of
from cortex_dsl.semantics.road.signal_plan import COLOURS, SignalPlan
from cortex_dsl.semantics.road.signals import ahead_of, by_plan, clock, needed, number_of, phase_of, unknown_colour
from cortex_dsl.semantics.values import Effect, Signal, Value
from cortex_dsl.source import Span
from engine.vocabulary import Op


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


def set_light_ahead(ev: Evaluator, actor: Actor, colour: float, reach: ir.Expr, span: Span) -> Effect:
    """Set the light that an object comes to, if it is within reach."""
    plan = needed(ev, span, "`setClosestTrafficLightStatus`")
    ahead = ahead_of(ev, actor)
    within = ahead.within(ev, reach)
    acts: list[ir.Act] = []
    for intersection in network_of(ev).intersections:
        for light in (Signal(intersection, i) for i in range(len(intersection.legs))):
            this = ev.algebra.apply(Op.EQ, ahead.light, ev.algebra.literal(float(number_of(light))))
            condition = ev.algebra.apply(Op.AND, within, this)
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
    """Let the clock of the lights go on where it stood."""
    plan, algebra = needed(ev, span, "`unfreezeTrafficLights`"), ev.algebra
    assert plan.controls is not None
    frozen, lost = algebra.local(plan.controls.frozen), algebra.local(plan.controls.lost)
    stood = algebra.sub(algebra.apply(Op.TIME), algebra.local(plan.controls.frozen_at))
    return Effect(
        (
            ir.SetLocal(span, plan.controls.lost, algebra.apply(Op.SELECT, frozen, stood, lost)),
            ir.SetLocal(span, plan.controls.frozen, algebra.truth(False)),
        )
    )
