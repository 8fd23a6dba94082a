"""Expressions and calls in Scenic: numbers are SI, headings are measured from the north, lanes are looked up on the
map, and functions and behaviors go by the names that its library has for them.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

from cortex_dsl import ir
from cortex_dsl.interchange.scenic.scenic_names import (
    ALIASES,
    BEHAVIOURS,
    CLASSES,
    MATH,
    NOWHERE,
    OBJECT_ATTRIBUTES,
    ROAD_ATTRIBUTES,
    SEARCHED,
    SHARED_FUNCTIONS,
    STAND_INS,
    WHEELED,
    OutputBuffer,
    Unsaid,
    area_of,
    by_position,
    left_out,
    place_text,
    the_one,
    verbatim,
)
from cortex_dsl.semantics.model.values import (
    Actor,
    BuiltinValue,
    DirectionField,
    GlobalParameters,
    Pose,
    Quantity,
    Value,
)
from cortex_dsl.semantics.names.builtins import BUILTINS, Kind
from cortex_dsl.semantics.names.properties import ACTOR_KINDS
from cortex_dsl.semantics.quantities.units import UNITS
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.unparse_expressions import Level, write
from engine.interchange.recording import Recording
from engine.road.network import Intersection, Network
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind


# -- calls: functions, the library of behaviors, and renamed ones ------------------------------------------------------
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
    if name == "SetWalkingDirectionAction":
        heading = the_one(node)
        turned = heading_from_north(to, heading.value)
        return replace(node, arguments=(replace(heading, value=turned, name=None),))
    if name in BEHAVIOURS or name in STAND_INS:
        return _behaviour(to, node, name)
    if name in MATH:
        to.sheet.mathematics.add(name)
    elif name not in SHARED_FUNCTIONS:
        raise Unsaid(f"`{name}`", node.span)
    return to.parts(replace(node, arguments=by_position(node, name)))


def _builtin(to: "Expressions", function: nodes.Expression) -> str | None:
    """Return the name of a function of the language, also in an unused behavior; None for names of the file."""
    called = to.value(function)
    if isinstance(called, BuiltinValue):
        return called.name
    if isinstance(function, nodes.Name) and not to.known_values(function.span) and function.id in BUILTINS:
        return function.id
    return None


def _fixed(to: "Expressions", node: nodes.Call) -> nodes.Expression:
    """Return the sampled values one after the other, one for each evaluation of the place."""
    values = ", ".join(to.text(argument.value) for argument in node.arguments)
    name = to.sheet.free_name(f"successive_{len(to.sheet.lookups) + 1}")
    to.sheet.lookups[name] = f"iter([{values}])"
    return verbatim(f"next({name})")


def _steer(to: "Expressions", node: nodes.Call) -> nodes.Expression:
    """Scenic steers from -1 to 1 of the full angle, positive to the right; so do files with a `model` line."""
    argument = the_one(node)
    if to.from_north:
        return replace(node, arguments=(replace(argument, value=to(argument.value), name=None),))
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
            to.sheet.remark(f"Scenic has no `{name}`; its replacement lacks something: {lacks}")
    operands = []
    for number, argument in enumerate(node.arguments):
        known = argument.name and ALIASES.get(argument.name, argument.name)
        here = known in shared if known else number < len(shared) and shared[number] != ""
        if here:
            operands.append(replace(argument, name=known, value=to(argument.value)))
        else:
            to.sheet.remark(f"`{name}` is written without {left_out(argument, number, name)}", argument.span)
    return replace(node, arguments=tuple(operands))


N = TypeVar("N", bound=nodes.Node)
KnownValues = Callable[[Span], list[Value]]
"""The values that an expression had while the file was compiled."""
NORTH = verbatim("90 deg")
"""Angle between a heading from the east and the same heading from the north."""
PLAIN = (nodes.Name, nodes.Attribute, nodes.ListDisplay, nodes.TupleDisplay)
"""Expressions that may stay as they are, if they lead to a part of the road."""


@dataclass(frozen=True)
class Expressions:
    """How each expression of a file is written in Scenic."""

    sheet: OutputBuffer
    network: Network
    known_values: KnownValues
    from_north: bool
    """Whether headings in the author's file are measured as Scenic measures them, because it has a `model` line."""
    recording: Recording
    """Recording of the run, with the positions of all actors."""
    make: "Callable[[Expressions, nodes.New], nodes.Expression]"
    """How a `new` is written; `objects.py`."""

    def __call__(self, node: nodes.Expression) -> nodes.Expression:
        """The same expression for Scenic.

        Raises:
            Unsaid: Scenic has no words for it.
        """
        known = self._place(node)
        if known is not None:
            return known
        handler = _HANDLERS.get(type(node))
        return self.parts(node) if handler is None else handler(self, node)

    def text(self, node: nodes.Expression) -> str:
        return write(self(node))

    def declare(self, class_name: str) -> None:
        """A class of ours that Scenic's library has not is brought along."""
        if class_name in ACTOR_KINDS and class_name not in CLASSES:
            self.sheet.classes[class_name] = "Vehicle" if ACTOR_KINDS[class_name] in WHEELED else "Object"

    def parts(self, node: N) -> N:
        """Return the node with its expressions translated to Scenic."""
        changed: dict[str, Any] = {each.name: self._part(getattr(node, each.name)) for each in fields(node)}
        return replace(node, **changed)

    def _part(self, value: Any) -> Any:
        if isinstance(value, nodes.Expression):
            return self(value)
        if isinstance(value, nodes.Node):
            return self.parts(value)
        return tuple(map(self._part, value)) if isinstance(value, tuple) else value

    def value(self, node: nodes.Expression) -> Value:
        """Return the value of an expression; None if its values differ or it was never evaluated."""
        values = self.known_values(node.span)
        if not values or any(value is not values[0] and value != values[0] for value in values):
            return None
        return values[0]

    def _place(self, node: nodes.Expression) -> nodes.Expression | None:
        """Return a part of the road by its name in Scenic; None for any other or unchanged expression."""
        if isinstance(node, PLAIN) and not self._is_builtin(node) and _leads_along(node):
            return None
        text = place_text(self.sheet, self.network, self.value(node))
        return None if text is None else verbatim(text)

    def _is_builtin(self, node: nodes.Expression) -> bool:
        """Return whether a name is `network`, `intersection` or `road` itself."""
        return isinstance(node, nodes.Name) and node.id in BUILTINS and BUILTINS[node.id].kind is Kind.CONSTANT


def _leads_along(node: nodes.Expression) -> bool:
    """Return whether an expression consists of the author's names, and of attributes that Scenic has too."""
    match node:
        case nodes.Name():
            return True
        case nodes.Attribute():
            return node.name in ROAD_ATTRIBUTES and _leads_along(node.value)
        case nodes.ListDisplay() | nodes.TupleDisplay():
            return all(map(_leads_along, node.items))
    return False


# -- numbers ----------------------------------------------------------------------------------------------------------


def _number(_to: Expressions, node: nodes.Number) -> nodes.Expression:
    if node.unit is None or node.unit == "deg":
        return node
    return nodes.Number(node.value * UNITS[node.unit].factor, None, span=node.span)


def _with_unit(to: Expressions, node: nodes.WithUnit) -> nodes.Expression:
    value, factor = to(node.value), UNITS[node.unit].factor
    if factor == 1.0:
        return value
    return nodes.Binary("*", value, nodes.Number(factor, None, span=node.span), span=node.span)


def heading_from_north(to: Expressions, node: nodes.Expression) -> nodes.Expression:
    """Return a heading of the author as one of Scenic's."""
    if to.from_north or isinstance(to.value(node), DirectionField):
        return to(node)
    match node:
        case nodes.Attribute(name="heading"):
            return replace(node, value=to(node.value))
        case nodes.Binary(operator="+" | "-"):
            return replace(node, left=heading_from_north(to, node.left), right=to(node.right))
        case nodes.Number(unit="deg"):
            return replace(node, value=node.value - 90.0)
    return nodes.Binary("-", to(node), NORTH, span=NOWHERE)


def _binary(to: Expressions, node: nodes.Binary) -> nodes.Expression:
    """`6 / 3 deg` is `(6 / 3) deg` there."""
    if node.operator not in ("/", "//", "%", "**"):
        return to.parts(node)
    return to.parts(replace(node, left=_in_radians(node.left), right=_in_radians(node.right)))


def _in_radians(node: nodes.Expression) -> nodes.Expression:
    if isinstance(node, nodes.Number) and node.unit == "deg":
        return nodes.Number(math.radians(node.value), None, span=node.span)
    return node


# -- names, attributes ------------------------------------------------------------------------------------------------


def _name(_to: Expressions, node: nodes.Name) -> nodes.Expression:
    if node.id == "none":
        return verbatim("None")
    if node.id == "pi":
        return verbatim(repr(math.pi))
    return node


def _attribute(to: Expressions, node: nodes.Attribute) -> nodes.Expression:
    base, value = to.value(node.value), to.value(node)
    if isinstance(base, GlobalParameters):
        return nodes.Name(node.name, span=node.span)
    if node.name == "heading":
        found = replace(node, value=to(node.value))
        return found if to.from_north else nodes.Binary("+", found, NORTH, span=node.span)
    if node.name in ("x", "y") and isinstance(base, Actor | Pose):
        position = nodes.Attribute(to(node.value), "position", span=node.span, name_span=node.span)
        return replace(node, value=position)
    known = value.expr if isinstance(value, Quantity) else None
    if isinstance(known, ir.Literal) and not isinstance(base, Pose) and node.name != "speed":
        return nodes.Number(float(known.value), None, span=node.span)
    if isinstance(base, Actor) and node.name not in OBJECT_ATTRIBUTES:
        raise Unsaid(f"`{node.name}` of an object", node.name_span)
    return replace(node, value=to(node.value))


# -- operators --------------------------------------------------------------------------------------------------------


def _distance(to: Expressions, node: nodes.Distance) -> nodes.Expression:
    if node.between_outlines:
        to.sheet.remark("`minimum distance` is written as the distance between centres", node.span)
    return replace(
        node,
        origin=None if node.origin is None else _measured(to, node.origin),
        target=_measured(to, node.target),
        between_outlines=False,
    )


def _measured(to: Expressions, node: nodes.Expression) -> nodes.Expression:
    """Return the target of a distance; for an intersection its exact outline, since Scenic's outline differs."""
    value = to.value(node)
    return verbatim(area_of(to.sheet, value)) if isinstance(value, Intersection) else to(node)


def _temporal(to: Expressions, node: nodes.Temporal) -> nodes.Expression:
    """Scenic reads brackets around a temporal formula only before few words, and not before a name; so none are
    written where its grammar needs none (scenic.gram, `scenic_temporal_group`).
    """
    first, *rest = (_formula(to, operand, bare=_is_prefix(operand)) for operand in node.operands)
    if not rest:
        inner = node.operands[0]
        bare = _is_prefix(inner) or (isinstance(inner, nodes.Temporal) and inner.operator == "implies")
        return verbatim(f"{node.operator} {_formula(to, inner, bare=bare)}")
    return verbatim(f"{first} {node.operator} {rest[0]}")


def _formula(to: Expressions, node: nodes.Expression, *, bare: bool) -> str:
    """Return an operand of a temporal operator; `bare`: a temporal one needs no brackets."""
    if isinstance(node, nodes.Temporal):
        text = to.text(node)
        return text if bare else f"({text})"
    return write(to(node), Level.OR)


def _is_prefix(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Temporal) and len(node.operands) == 1


def _lambda(to: Expressions, node: nodes.Lambda) -> nodes.Expression:
    return replace(node, body=to(node.body))


_HANDLERS: Mapping[type, Callable[[Expressions, Any], nodes.Expression]] = {
    nodes.Number: _number,
    nodes.WithUnit: _with_unit,
    nodes.Name: _name,
    nodes.Attribute: _attribute,
    nodes.Call: call,
    nodes.Binary: _binary,
    nodes.Distance: _distance,
    nodes.Temporal: _temporal,
    nodes.New: lambda to, node: to.make(to, node),
    nodes.Lambda: _lambda,
}
