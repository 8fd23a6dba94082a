"""What the built-in functions do. Each takes the evaluator, its arguments and the place of the call."""

import math
from collections.abc import Callable, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.errors.behaviours import ONLY_WHILE_RUNNING
from cortex_dsl.semantics.errors.chance import NOT_WHOLE
from cortex_dsl.semantics.errors.values import (
    DIMENSION_MISMATCH,
    NOT_FINITE,
    OUT_OF_RANGE,
    TOO_FEW_ARGUMENTS,
    WRONG_KIND,
)
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given, bind_builtin, items_of, no_names, number_for
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Closure, Quantity, Truth, Value
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.quantities.algebra import closed_value
from cortex_dsl.semantics.quantities.units import ANGLE, PURE, dimension_name
from cortex_dsl.source import Span
from engine.vocabulary import Op

Function = Callable[[Evaluator, Sequence[Given], Span], Value]
FUNCTIONS: dict[str, Function] = {}

RANGE_LIMIT = 10_000
"""Longest list that `range` makes."""


def function(name: str) -> Callable[[Callable[..., Value]], Callable[..., Value]]:
    """Register the meaning of a function with fixed parameters: it gets them in order, bound."""

    def register(meaning: Callable[..., Value]) -> Callable[..., Value]:
        row = BUILTINS[name]

        def call(ev: Evaluator, given: Sequence[Given], span: Span) -> Value:
            if row.variadic:
                no_names(name, given)
                return meaning(ev, list(given), span)
            bound = bind_builtin(row, given, span)
            return meaning(ev, *(bound.get(p.name) for p in row.parameters), span)

        FUNCTIONS[name] = call
        return meaning

    return register


# -- numbers ----------------------------------------------------------------------------------------------------------


def _pure(ev: Evaluator, argument: Given, name: str) -> ir.Expr:
    return numbers.adopt(ev, argument.value, PURE, argument.span, f"the argument of `{name}`")


def _in_domain(result: ir.Expr, span: Span, name: str) -> ir.Expr:
    value = closed_value(result)
    if value is not None and not math.isfinite(value):
        raise NOT_FINITE.mistake(span, reason=f"`{name}` has no value there")
    return result


def _trigonometric(name: str, op: Op) -> None:
    @function(name)
    def meaning(ev: Evaluator, angle: Given, _span: Span) -> Value:
        expr = numbers.adopt(ev, angle.value, ANGLE, angle.span, f"the argument of `{name}`")
        return Quantity(ev.algebra.apply(op, expr), PURE)


def _inverse(name: str, op: Op) -> None:
    @function(name)
    def meaning(ev: Evaluator, x: Given, span: Span) -> Value:
        return Quantity(_in_domain(ev.algebra.apply(op, _pure(ev, x, name)), span, name), ANGLE)


def _of_pure_number(name: str, op: Op) -> None:
    @function(name)
    def meaning(ev: Evaluator, x: Given, span: Span) -> Value:
        given = numbers.quantity(x.value, x.span, f"the argument of `{name}`")
        dimension = None if given.dimension is None else PURE
        return Quantity(_in_domain(ev.algebra.apply(op, _pure(ev, x, name)), span, name), dimension)


for _name, _op in {"sin": Op.SIN, "cos": Op.COS, "tan": Op.TAN}.items():
    _trigonometric(_name, _op)
for _name, _op in {"asin": Op.ASIN, "acos": Op.ACOS, "atan": Op.ATAN}.items():
    _inverse(_name, _op)
for _name, _op in {"exp": Op.EXP, "log": Op.LOG, "floor": Op.FLOOR, "ceil": Op.CEIL, "round": Op.ROUND}.items():
    _of_pure_number(_name, _op)


@function("abs")
def _abs(ev: Evaluator, x: Given, _span: Span) -> Value:
    given = numbers.quantity(x.value, x.span, "the argument of `abs`")
    return Quantity(ev.algebra.apply(Op.ABS, given.expr), given.dimension)


@function("sqrt")
def _sqrt(ev: Evaluator, x: Given, span: Span) -> Value:
    return numbers.square_root(ev, numbers.quantity(x.value, x.span, "the argument of `sqrt`"), span)


def _two_alike(ev: Evaluator, op: Op, x: Given, y: Given, span: Span) -> Quantity:
    left, right = (numbers.quantity(g.value, g.span) for g in (x, y))
    dimension = numbers.common(left.dimension, right.dimension, span, "combined")
    return Quantity(ev.algebra.apply(op, left.expr, right.expr), dimension)


@function("hypot")
def _hypot(ev: Evaluator, x: Given, y: Given, span: Span) -> Value:
    return _two_alike(ev, Op.HYPOT, x, y, span)


@function("atan2")
def _atan2(ev: Evaluator, y: Given, x: Given, span: Span) -> Value:
    return Quantity(_two_alike(ev, Op.ATAN2, y, x, span).expr, ANGLE)


def _spread(given: Sequence[Given]) -> list[Given]:
    """Arguments of `min(a, b)`, or the items of `min(list)`."""
    if len(given) == 1 and isinstance(given[0].value, tuple):
        return [Given(item, given[0].span) for item in given[0].value]
    return list(given)


def _extremum(name: str, op: Op) -> None:
    @function(name)
    def meaning(ev: Evaluator, given: Sequence[Given], span: Span) -> Value:
        if not (given := _spread(given)):
            raise TOO_FEW_ARGUMENTS.mistake(
                span, function=name, missing="at least one number", signature=f"{name}(a, b)"
            )
        result = numbers.quantity(given[0].value, given[0].span)
        for other in given[1:]:
            result = _two_alike(ev, op, Given(result, span), other, span)
        return result


_extremum("min", Op.MIN)
_extremum("max", Op.MAX)


@function("sum")
def _sum(ev: Evaluator, items: Given, span: Span) -> Value:
    total = Quantity(ev.algebra.literal(0.0), None)
    for item in items_of(items.value, items.span):
        total = numbers.add(ev, total, numbers.quantity(item, items.span), span)
    return total


# -- lists ------------------------------------------------------------------------------------------------------------


def _count(ev: Evaluator, number: int) -> Quantity:
    return Quantity(ev.algebra.literal(float(number)), None)


@function("len")
def _len(ev: Evaluator, items: Given, _span: Span) -> Value:
    return _count(ev, len(items_of(items.value, items.span)))


def _closure(argument: Given) -> Closure:
    if isinstance(argument.value, Closure) and len(argument.value.parameters) == 1:
        return argument.value
    raise WRONG_KIND.mistake(
        argument.span,
        what="this",
        expected="a function of one argument",
        actual=kind_name(argument.value),
        cure="as in `filter(lambda m: m.type is ManeuverType.STRAIGHT, lane.maneuvers)`",
    )


def known_truth(ev: Evaluator, value: Value, span: Span, purpose: str) -> bool:
    """A condition that must be known at compile time."""
    return bool(ev.constant(Quantity(numbers.truth(ev, value, span), PURE), span, purpose))


@function("filter")
def _filter(ev: Evaluator, predicate: Given, items: Given, _span: Span) -> Value:
    keep = _closure(predicate).apply
    return tuple(
        item
        for item in items_of(items.value, items.span)
        if known_truth(ev, keep(item), predicate.span, "the condition of `filter`")
    )


@function("map")
def _map(_ev: Evaluator, transform: Given, items: Given, _span: Span) -> Value:
    return tuple(map(_closure(transform).apply, items_of(items.value, items.span)))


def _combination(name: str, op: Op, empty: bool) -> None:
    @function(name)
    def meaning(ev: Evaluator, items: Given, _span: Span) -> Value:
        result: ir.Expr = ev.algebra.truth(empty)
        for item in items_of(items.value, items.span):
            result = ev.algebra.apply(op, result, numbers.truth(ev, item, items.span))
        return Truth(result)


_combination("any", Op.OR, empty=False)
_combination("all", Op.AND, empty=True)


@function("range")
def _range(ev: Evaluator, given: Sequence[Given], span: Span) -> Value:
    bounds = [whole_number(ev, g.value, g.span, "the end of a `range`") for g in given]
    if not 1 <= len(bounds) <= 3 or (len(bounds) == 3 and bounds[2] == 0):
        raise TOO_FEW_ARGUMENTS.mistake(
            span, function="range", missing="an end, or a start and an end", signature="range(start, end)"
        )
    numbers_within = range(*bounds)
    if len(numbers_within) > RANGE_LIMIT:
        raise OUT_OF_RANGE.mistake(
            span, what="the length of a `range`", actual=len(numbers_within), expected=f"at most {RANGE_LIMIT}", cure=""
        )
    return tuple(_count(ev, n) for n in numbers_within)


def whole_number(ev: Evaluator, value: Value, span: Span, what: str) -> int:
    """A whole number that must be known at compile time."""
    given = numbers.quantity(value, span, what)
    if given.dimension not in (None, PURE):
        raise DIMENSION_MISMATCH.mistake(
            span, what=what, expected="a pure number", actual=dimension_name(given.dimension), cure=""
        )
    number = ev.constant(given, span, what)
    if not math.isfinite(number) or number != math.floor(number):
        raise NOT_WHOLE.mistake(span, what=what, actual=f"{number:g}")
    return int(number)


for _name in ("list", "tuple"):

    @function(_name)
    def _items(_ev: Evaluator, items: Given, _span: Span) -> Value:
        return items_of(items.value, items.span)


# -- the simulation ---------------------------------------------------------------------------------------------------


@function("withinDistanceToAnyObjs")
def _within_distance(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    if not isinstance(vehicle.value, Actor):
        raise WRONG_KIND.mistake(
            vehicle.span, what="`vehicle`", expected="an object", actual=kind_name(vehicle.value), cure="write `self`"
        )
    if not ev.moment.running:
        raise ONLY_WHILE_RUNNING.mistake(span, what="`withinDistanceToAnyObjs`")
    limit = number_for(ev, BUILTINS["withinDistanceToAnyObjs"].parameters[1], distance)
    return Truth(ev.algebra.apply(Op.WITHIN, limit, immediates=(vehicle.value.index,)))


@function("localPath")
def _local_path(_ev: Evaluator, path: Given, _span: Span) -> Value:
    return path.value
