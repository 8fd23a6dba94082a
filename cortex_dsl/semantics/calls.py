"""Calls: of functions, distributions, lambdas, actions and behaviours."""

from collections.abc import Sequence

from cortex_dsl.semantics import distributions, errors
from cortex_dsl.semantics.arguments import Given, Slot, bind, bind_builtin, evaluate_arguments, number_for
from cortex_dsl.semantics.builtins import BUILTINS, Builtin, Kind
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.draws import Site
from cortex_dsl.semantics.functions import FUNCTIONS
from cortex_dsl.semantics.values import (
    ActionCall,
    BehaviourCall,
    BehaviourValue,
    BuiltinValue,
    Closure,
    Value,
    kind_name,
)
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes


def call(ev: Evaluator, node: nodes.Call) -> Value:
    if distributions.distribution_call(ev, node) is not None:
        return distributions.sample_call(ev, node, Site(node.span))
    callee = ev.evaluate(node.function)
    given = evaluate_arguments(ev, node.arguments)
    match callee:
        case BuiltinValue(name):
            return _builtin(ev, BUILTINS[name], given, node)
        case BehaviourValue():
            return behaviour_call(callee, given, node.span)
        case Closure():
            slots = [Slot(name) for name in callee.parameters]
            signature = f"lambda {', '.join(callee.parameters)}"
            bound = bind("lambda", signature, slots, given, node.span)
            return callee.apply(*(bound[name].value for name in callee.parameters))
    raise errors.NOT_CALLABLE.mistake(node.function.span, kind=kind_name(callee))


def _builtin(ev: Evaluator, row: Builtin, given: Sequence[Given], node: nodes.Call) -> Value:
    match row.kind:
        case Kind.FUNCTION:
            return FUNCTIONS[row.name](ev, given, node.span)
        case Kind.DISTRIBUTION:
            return distributions.DISTRIBUTIONS[row.name](ev, row.name, given, Site(node.span))
        case Kind.ACTION:
            return _action(ev, row, given, node.span)
        case Kind.BEHAVIOUR:
            bound = bind_builtin(row, given, node.span)
            return _behaviour(BuiltinValue(row.name), bound, node.span)
    raise errors.NOT_SUPPORTED.mistake(
        node.span, what=f"`{row.name}` cannot be called", reason="", cure=f"objects are made with `new {row.name} ...`"
    )


def _action(ev: Evaluator, row: Builtin, given: Sequence[Given], span: Span) -> Value:
    bound = bind_builtin(row, given, span)
    parameter = row.parameters[0]
    assert row.command is not None
    return ActionCall(row.command, number_for(ev, parameter, bound[parameter.name]), row.name)


def behaviour_call(behaviour: BehaviourValue, given: Sequence[Given], span: Span) -> BehaviourCall:
    node = behaviour.node
    slots = [Slot(p.name, p.default is not None) for p in node.parameters]
    shown = [p.name if p.default is None else f"{p.name}=..." for p in node.parameters]
    return _behaviour(behaviour, bind(node.name, f"{node.name}({', '.join(shown)})", slots, given, span), span)


def _behaviour(behaviour: BehaviourValue | BuiltinValue, bound: dict[str, Given], span: Span) -> BehaviourCall:
    return BehaviourCall(
        behaviour, {name: g.value for name, g in bound.items()}, {name: g.span for name, g in bound.items()}, span
    )


def as_behaviour(value: Value, span: Span) -> BehaviourCall | None:
    """A behaviour with its arguments; one that was not called takes none."""
    match value:
        case BehaviourCall():
            return value
        case BehaviourValue():
            return behaviour_call(value, [], span)
        case BuiltinValue(name) if BUILTINS[name].kind is Kind.BEHAVIOUR:
            return _behaviour(value, bind_builtin(BUILTINS[name], [], span), span)
    return None
