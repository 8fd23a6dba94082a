"""Calls in Scenic: its functions, its library of behaviors, and what is called otherwise there."""

from dataclasses import replace
from typing import TYPE_CHECKING

from cortex_dsl.exports.scenic.sheet import NOWHERE, Unsaid, verbatim
from cortex_dsl.exports.scenic.words import ALIASES, BEHAVIOURS, MATH, SEARCHED, SHARED_FUNCTIONS, STAND_INS
from cortex_dsl.semantics.model.values import BuiltinValue
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.syntax import nodes
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind

if TYPE_CHECKING:
    from cortex_dsl.exports.scenic.expressions import Expressions


def call(to: "Expressions", node: nodes.Call) -> nodes.Expression:
    name = _builtin(to, node.function)
    if name is None:
        return to.parts(node)
    if name == "Fixed":
        return _fixed(to, node)
    if name in SEARCHED:
        return replace(to.parts(node), function=verbatim(SEARCHED[name]))
    if name == "SetSteerAction":
        return _steer(to, node)
    if name in BEHAVIOURS or name in STAND_INS:
        return _behaviour(to, node, name)
    if name in MATH:
        to.sheet.mathematics.add(name)
    elif name not in SHARED_FUNCTIONS:
        raise Unsaid(f"`{name}`", node.span)
    return replace(to.parts(node), arguments=tuple(_unnamed(to.parts(each)) for each in node.arguments))


def _builtin(to: "Expressions", function: nodes.Expression) -> str | None:
    """The name of a function of the language, also in a behavior that nobody has; None for what the file defines."""
    called = to.value(function)
    if isinstance(called, BuiltinValue):
        return called.name
    if isinstance(function, nodes.Name) and not to.worth(function.span) and function.id in BUILTINS:
        return function.id
    return None


def _unnamed(argument: nodes.Argument) -> nodes.Argument:
    """Our other spelling of a parameter is not known there."""
    return replace(argument, name=ALIASES.get(argument.name or "", argument.name))


def _fixed(to: "Expressions", node: nodes.Call) -> nodes.Expression:
    """One value after the other, as often as the place is evaluated."""
    values = ", ".join(to.text(argument.value) for argument in node.arguments)
    name = to.sheet.free_name(f"successive_{len(to.sheet.lookups) + 1}")
    to.sheet.lookups[name] = f"iter([{values}])"
    return verbatim(f"next({name})")


def _steer(to: "Expressions", node: nodes.Call) -> nodes.Expression:
    """Scenic steers from -1 to 1 of the full angle, positive to the right; so do files with a `model` line."""
    (argument,) = node.arguments
    if to.from_north:
        return to.parts(node)
    full = nodes.Number(MODELS[ActorKind.CAR].max_steer, None, span=NOWHERE)
    turned = nodes.Unary("-", nodes.Binary("/", to(argument.value), full, span=NOWHERE), span=NOWHERE)
    to.sheet.remark("a steering angle is written as a share of the full angle of a car", node.span)
    return replace(node, arguments=(replace(argument, value=turned, name=None),))


def _behaviour(to: "Expressions", node: nodes.Call, name: str) -> nodes.Expression:
    """A call of a library behaviour, without the arguments that Scenic's has not."""
    shared = BEHAVIOURS.get(name) or tuple(each.split("=")[0] for each in STAND_INS[name].parameters)
    if name in STAND_INS:
        to.sheet.stand_ins[name] = None
        if lacks := STAND_INS[name].lacks:
            to.sheet.remark(f"Scenic has no `{name}`; what stands in for it lacks something: {lacks}")
    kept = []
    for number, argument in enumerate(node.arguments):
        known = argument.name and ALIASES.get(argument.name, argument.name)
        here = known in shared if known else number < len(shared) and shared[number] != ""
        if here:
            kept.append(replace(argument, name=known, value=to(argument.value)))
        else:
            to.sheet.remark(f"`{name}` is written without {_told(argument, number, name)}", argument.span)
    return replace(node, arguments=tuple(kept))


def _told(argument: nodes.Argument, number: int, name: str) -> str:
    parameters = BUILTINS[name].parameters
    return f"`{argument.name or parameters[number].name}`, which Scenic's has not"
