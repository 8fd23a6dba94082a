"""Calls: of functions, distributions, lambdas, actions and behaviours."""

import math
from collections.abc import Mapping, Sequence

from cortex_dsl.semantics.errors.names import NOT_SUPPORTED
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import MONITOR_USED, ONLY_WHILE_RUNNING, SCENARIO_USED, SETTLED_ARGUMENT
from cortex_dsl.semantics.errors.values import NOT_CALLABLE, OUT_OF_RANGE
from cortex_dsl.semantics.evaluation import (
    alignments,
    doors,
    driving,
    functions,
    geometry,
    numbers,
    over_run,
    random_values,
    regions,
    texts,
)
from cortex_dsl.semantics.evaluation.arguments import (
    Given,
    Slot,
    bind,
    bind_builtin,
    evaluate_arguments,
    no_names,
    number_for,
)
from cortex_dsl.semantics.evaluation.random_values import Site
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import (
    ActionCall,
    BehaviourCall,
    BehaviourValue,
    BuiltinValue,
    Closure,
    Function,
    MonitorCall,
    MonitorValue,
    Quantity,
    ScenarioCall,
    ScenarioValue,
    Truth,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import BUILTINS, Builtin, Kind
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Term, atan2, hypot, where, wrapped
from cortex_dsl.semantics.quantities.bounds import closed_value, is_dynamic
from cortex_dsl.semantics.quantities.units import ANGLE, PURE, SPEED
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.vocabulary import ActorKind, Command

# -- steering as Scenic's scripts give it: a share of the full angle, positive to the right ----------------------------


def scenic_steering(ev: Evaluator, steer: Given) -> Term:
    """Return the steering angle, positive to the left [rad]; a value with a unit of angle is used as it is."""
    given = numbers.quantity(steer.value, steer.span, "`steer`")
    if given.dimension == ANGLE or ev.moment.actor is None:
        return numbers.adopt(ev, given, ANGLE, steer.span, "`steer`")
    cure = "a share of the full angle, from -1 to 1, or an angle; as in `steer=5 deg`"
    share = numbers.adopt(ev, given, PURE, steer.span, "`steer`", cure)
    share = in_range(ev, share, Domain("`steer`", PURE, -1.0, 1.0), steer.span)
    return -(share * geometry.size_of(ev.moment.actor, "maxSteer"))


# -- calls -------------------------------------------------------------------------------------------------------------

Definition = nodes.BehaviorDefinition | nodes.MonitorDefinition | nodes.ScenarioDefinition


def call(ev: Evaluator, node: nodes.Call) -> Value:
    if random_values.distribution_call(ev, node) is not None:
        return random_values.sample_call(ev, node, Site(node.span))
    if ev.moment.over and (reducer := over_run.reducer_of(ev, node.function)) is not None:
        return over_run.reduced(ev, reducer, node)
    callee = ev.evaluate(node.function)
    if isinstance(callee, ScenarioValue):
        return scenario_call(ev, callee, node)
    given = evaluate_arguments(ev, node.arguments)
    with ev.file.budget.repeating(node.span):
        match callee:
            case BuiltinValue(name):
                return _builtin(ev, BUILTINS[name], given, node)
            case BehaviourValue():
                return behaviour_call(callee, given, node.span)
            case MonitorValue():
                return monitor_call(callee, given, node.span)
            case Closure():
                least = len(callee.parameters) - callee.optional
                slots = [Slot(name, i >= least) for i, name in enumerate(callee.parameters)]
                signature = f"lambda {', '.join(callee.parameters)}"
                bound = bind("lambda", signature, slots, given, node.span)
                return callee.apply(*(bound[name].value for name in callee.parameters if name in bound))
            case Function():
                return callee.apply(ev.moment, _function_arguments(callee, given, node.span))
    raise NOT_CALLABLE.mistake(node.function.span, kind=kind_name(callee))


def _function_arguments(function: Function, given: Sequence[Given], span: Span) -> dict[str, Value]:
    """Arguments by name; `*rest` takes those that are left over."""
    rest = next((p.name for p in function.parameters if p.rest), None)
    slots = [Slot(p.name, p.default is not None) for p in function.parameters if not p.rest]
    before = next((i for i, p in enumerate(function.parameters) if p.rest), len(slots))
    positional = [g for g in given if g.name is None]
    further = positional[before:] if rest is not None else []
    left_over = set(map(id, further))
    signature = f"{function.name}({', '.join(p.name for p in function.parameters)})"
    bound = bind(function.name, signature, slots, [g for g in given if id(g) not in left_over], span)
    values = {name: argument.value for name, argument in bound.items()}
    return values if rest is None else {**values, rest: tuple(g.value for g in further)}


def _builtin(ev: Evaluator, row: Builtin, given: Sequence[Given], node: nodes.Call) -> Value:
    match row.kind:
        case Kind.FUNCTION:
            return _function(ev, row, given, node.span)
        case Kind.DISTRIBUTION:
            return random_values.drawn(ev, row.name, given, Site(node.span))
        case Kind.ACTION:
            return _action(ev, row, given, node.span)
        case Kind.BEHAVIOUR:
            bound = bind_builtin(row, given, node.span)
            return _behaviour(BuiltinValue(row.name), bound, node.span)
    raise NOT_SUPPORTED.mistake(
        node.span, what=f"`{row.name}` cannot be called", reason="", cure=f"objects are made with `new {row.name} ...`"
    )


def _function(ev: Evaluator, row: Builtin, given: Sequence[Given], span: Span) -> Value:
    """A function gets its arguments in order, or, if it takes any number of them, as a list."""
    meaning = FUNCTIONS[row.name]
    if row.variadic:
        no_names(row.name, given)
        return meaning(ev, list(given), span)
    bound = bind_builtin(row, given, span)
    return meaning(ev, *(bound.get(p.name) for p in row.parameters), span)


FUNCTIONS: Mapping[str, functions.Meaning] = {
    **functions.MEANINGS,
    **driving.MEANINGS,
    **over_run.MEANINGS,
    **regions.MEANINGS,
    **random_values.MEANINGS,
    **alignments.MEANINGS,
    **texts.MEANINGS,
}


def _action(ev: Evaluator, row: Builtin, given: Sequence[Given], span: Span) -> Value:
    bound = bind_builtin(row, given, span)
    parameter = row.parameters[0]
    if row.command is None:
        return doors.open_door(ev, bound, span)
    if row.name == "SetVelocityAction":
        return _velocity_action(ev, row, bound, span)
    if row.name == "SetWalkingDirectionAction":
        return ActionCall(row.command, _turn_into(ev, bound[parameter.name], span), row.name)
    if row.command is Command.STEER and ev.facts.from_scenic:
        return ActionCall(row.command, scenic_steering(ev, bound[parameter.name]), row.name)
    if row.command is Command.REVERSE:
        reverse = bound[parameter.name]
        return ActionCall(row.command, numbers.truth(ev, reverse.value, reverse.span), row.name)
    return ActionCall(row.command, number_for(ev, parameter, bound[parameter.name]), row.name)


OFF_HEADING = math.radians(3.0)
"""Largest angle between a velocity and the heading of a vehicle that it is given to [rad]; *ours*."""


def _velocity_action(ev: Evaluator, row: Builtin, bound: Mapping[str, Given], span: Span) -> Value:
    """Return the actions for a velocity: a pedestrian turns into it, a vehicle must be heading that way."""
    if (actor := ev.moment.actor) is None:
        raise ONLY_WHILE_RUNNING.mistake(span, what="the object")
    x, y = (number_for(ev, parameter, bound[parameter.name]) for parameter in row.parameters[:2])
    up = bound.get("zVel")
    if up is not None and closed_value(numbers.adopt(ev, up.value, SPEED, up.span, "a vertical speed")) != 0.0:
        cure = "write 0, or leave it out: heights are not simulated"
        raise OUT_OF_RANGE.mistake(up.span, what="a vertical speed", actual="another", expected="0 m/s", cure=cure)
    heading, speed = geometry.current_pose(ev, actor).heading, hypot(x, y)
    stands = speed <= 0.0
    turn = where(stands, ev.algebra.literal(0.0), wrapped(atan2(y, x) - heading))
    if actor.kind is ActorKind.PEDESTRIAN:
        return ActionCall(Command.STEER, turn, row.name), ActionCall(Command.SPEED, speed, row.name)
    return ActionCall(Command.SPEED, speed, row.name, abs(turn) <= OFF_HEADING)


def _turn_into(ev: Evaluator, heading: Given, span: Span) -> Term:
    """Return the turn of the acting object to a heading [rad]; a pedestrian turns at once."""
    if (actor := ev.moment.actor) is None:
        raise ONLY_WHILE_RUNNING.mistake(span, what="the pedestrian")
    pose = geometry.current_pose(ev, actor)
    return wrapped(geometry.heading_at(ev, heading.value, Vector(pose.x, pose.y), heading.span) - pose.heading)


def behaviour_call(behaviour: BehaviourValue, given: Sequence[Given], span: Span) -> BehaviourCall:
    return _behaviour(behaviour, bind_parameters(behaviour.node, given, span), span)


def monitor_call(monitor: MonitorValue, given: Sequence[Given], span: Span) -> MonitorCall:
    bound = bind_parameters(monitor.node, given, span)
    values, spans = {name: g.value for name, g in bound.items()}, {name: g.span for name, g in bound.items()}
    return MonitorCall(monitor, values, spans, span)


def scenario_call(ev: Evaluator, scenario: ScenarioValue, node: nodes.Call) -> ScenarioCall:
    """A scenario with its arguments, which are settled with the scene."""
    scene = ev.at_moment(Moment(scenario=ev.moment.scenario, later=True))
    bound = bind_parameters(scenario.node, evaluate_arguments(scene, node.arguments), node.span)
    for name, argument in bound.items():
        if isinstance(argument.value, Quantity | Truth) and is_dynamic(argument.value.expr):
            raise SETTLED_ARGUMENT.mistake(argument.span, name=name)
    values, spans = {name: g.value for name, g in bound.items()}, {name: g.span for name, g in bound.items()}
    return ScenarioCall(scenario, values, spans, node.span)


def as_scenario(value: Value, span: Span) -> ScenarioCall | None:
    """Return a scenario that is ready to start; a scenario that was not called has no arguments."""
    if isinstance(value, ScenarioValue):
        bind_parameters(value.node, [], span)
        return ScenarioCall(value, {}, {}, span)
    return value if isinstance(value, ScenarioCall) else None


def bind_parameters(node: Definition, given: Sequence[Given], span: Span) -> dict[str, Given]:
    """Arguments by the parameters of a definition in the file."""
    if any(p.name == "self" for p in node.parameters):
        raise Mistake  # reported already
    slots = [Slot(p.name, p.default is not None) for p in node.parameters]
    shown = [p.name if p.default is None else f"{p.name}=..." for p in node.parameters]
    return bind(node.name, f"{node.name}({', '.join(shown)})", slots, given, span)


def _behaviour(behaviour: BehaviourValue | BuiltinValue, bound: dict[str, Given], span: Span) -> BehaviourCall:
    return BehaviourCall(
        behaviour, {name: g.value for name, g in bound.items()}, {name: g.span for name, g in bound.items()}, span
    )


def as_behaviour(value: Value, span: Span) -> BehaviourCall | None:
    """Return a behaviour with its arguments; a behaviour that was not called has none."""
    match value:
        case BehaviourCall():
            return value
        case BehaviourValue():
            return behaviour_call(value, [], span)
        case BuiltinValue(name) if BUILTINS[name].kind is Kind.BEHAVIOUR:
            return _behaviour(value, bind_builtin(BUILTINS[name], [], span), span)
        case MonitorValue(node=nodes.MonitorDefinition(name=name)) | MonitorCall(name=name):
            raise MONITOR_USED.mistake(span, name=name)
        case ScenarioValue(node=nodes.ScenarioDefinition(name=name)) | ScenarioCall(name=name):
            raise SCENARIO_USED.mistake(span, name=name)
    return None
