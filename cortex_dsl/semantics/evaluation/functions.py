"""Built-in functions. Each takes the evaluator, its arguments and the place of the call."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from operator import and_, or_

from cortex_dsl.semantics.errors.runs import ONLY_WHILE_RUNNING
from cortex_dsl.semantics.errors.values import (
    DIMENSION_MISMATCH,
    NOT_WHOLE,
    OUT_OF_RANGE,
    TOO_FEW_ARGUMENTS,
    WRONG_KIND,
)
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given, items_of, number_for
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Closure, Filtered, Function, Items, Quantity, Truth, Value
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.semantics.quantities.algebra import Term, function_of, sees_within, where
from cortex_dsl.semantics.quantities.units import ANGLE, PURE, dimension_name, root
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.opcodes import Op
from engine.operators import OPERATORS, Rule
from engine.operators import Function as FunctionRow
from engine.road.network import Intersection, Lane, Maneuver

Meaning = Callable[..., Value]
"""Function of the evaluator, the arguments in order, and the place of the call."""

RANGE_LIMIT = 10_000
"""Longest list that `range` makes."""


# -- numbers ----------------------------------------------------------------------------------------------------------


def _pure(ev: Evaluator, argument: Given, name: str) -> Term:
    return numbers.adopt(ev, argument.value, PURE, argument.span, f"the argument of `{name}`")


def _of_angle(op: Op, name: str) -> Meaning:
    def meaning(ev: Evaluator, angle: Given, _span: Span) -> Value:
        given = numbers.adopt(ev, angle.value, ANGLE, angle.span, f"the argument of `{name}`")
        return Quantity(function_of(op)(given), PURE)

    return meaning


def _to_angle(op: Op, name: str) -> Meaning:
    def meaning(ev: Evaluator, x: Given, span: Span) -> Value:
        return Quantity(
            numbers.defined(ev, function_of(op)(_pure(ev, x, name)), span, f"it is `{name}` of {{}}"), ANGLE
        )

    return meaning


def _of_pure_number(op: Op, name: str) -> Meaning:
    def meaning(ev: Evaluator, x: Given, span: Span) -> Value:
        given = numbers.quantity(x.value, x.span, f"the argument of `{name}`")
        dimension = None if given.dimension is None else PURE
        result = function_of(op)(_pure(ev, x, name))
        return Quantity(numbers.defined(ev, result, span, f"it is `{name}` of {{}}"), dimension)

    return meaning


def _of_any(op: Op, name: str) -> Meaning:
    def meaning(_ev: Evaluator, x: Given, _span: Span) -> Value:
        given = numbers.quantity(x.value, x.span, f"the argument of `{name}`")
        return Quantity(function_of(op)(given.expr), given.dimension)

    return meaning


def _root(op: Op, name: str) -> Meaning:
    def meaning(ev: Evaluator, x: Given, span: Span) -> Value:
        base = numbers.quantity(x.value, x.span, f"the argument of `{name}`")
        dimension = None if base.dimension is None else root(base.dimension)
        if dimension is None and base.dimension is not None:
            raise DIMENSION_MISMATCH.mistake(
                span,
                what="under a square root there",
                expected="a square",
                actual=dimension_name(base.dimension),
                cure="as in `sqrt(x * x + y * y)`",
            )
        result = numbers.defined(ev, function_of(op)(base.expr), span, "it is the square root of {}")
        return Quantity(result, dimension)

    return meaning


def _two_alike(of: Callable[..., Term], x: Given, y: Given, span: Span) -> Quantity:
    left, right = (numbers.quantity(g.value, g.span) for g in (x, y))
    dimension = numbers.common(left.dimension, right.dimension, span, "combined")
    return Quantity(of(left.expr, right.expr), dimension)


def _alike(op: Op, _name: str) -> Meaning:
    return lambda _ev, x, y, span: _two_alike(function_of(op), x, y, span)


def _alike_to_angle(op: Op, _name: str) -> Meaning:
    return lambda _ev, y, x, span: Quantity(_two_alike(function_of(op), y, x, span).expr, ANGLE)


def _spread(given: Sequence[Given]) -> list[Given]:
    """Arguments of `min(a, b)`, or the items of `min(list)`."""
    if len(given) == 1 and isinstance(given[0].value, tuple):
        return [Given(item, given[0].span) for item in given[0].value]
    return list(given)


def _extremum(op: Op, name: str) -> Meaning:
    def meaning(ev: Evaluator, given: Sequence[Given], span: Span) -> Value:
        if not (given := _spread(given)):
            raise TOO_FEW_ARGUMENTS.mistake(
                span, function=name, missing="at least one number", signature=f"{name}(a, b)"
            )
        ev.file.budget.spend(span, len(given))
        result = numbers.quantity(given[0].value, given[0].span)
        for other in given[1:]:
            result = _two_alike(partial(_strict, ev, op), Given(result, span), other, span)
        return result

    return meaning


def _strict(ev: Evaluator, op: Op, one: Term, other: Term) -> Term:
    """`min` or `max`, NaN where an operand is: the instruction leaves out a second operand that is NaN."""
    if not ev.may_be_undefined(other):
        return function_of(op)(one, other)
    if not ev.may_be_undefined(one):
        return function_of(op)(other, one)
    return where(other < one if op == Op.MIN else one < other, other, one)


def _sum(ev: Evaluator, items: Given, span: Span) -> Value:
    total = Quantity(ev.algebra.literal(0.0), None)
    ev.file.budget.spend(span, len(items_of(items.value, items.span)))
    for item in items_of(items.value, items.span):
        total = numbers.combined(Op.ADD, total, numbers.quantity(item, items.span), span)
    return total


# -- lists ------------------------------------------------------------------------------------------------------------


def _count(ev: Evaluator, number: int) -> Quantity:
    return Quantity(ev.algebra.literal(float(number)), None)


def _len(ev: Evaluator, items: Given, _span: Span) -> Value:
    return _count(ev, len(items_of(items.value, items.span)))


def _closure(ev: Evaluator, argument: Given) -> Closure:
    if isinstance(argument.value, Closure) and len(argument.value.parameters) == 1:
        return argument.value
    if isinstance(argument.value, Function) and len(argument.value.parameters) == 1:
        function, (parameter,) = argument.value, argument.value.parameters
        return Closure((parameter.name,), lambda item: function.apply(ev.moment, {parameter.name: item}))
    raise WRONG_KIND.mistake(
        argument.span,
        what="this",
        expected="a function of one argument",
        actual=kind_name(argument.value),
        cure="as in `filter(lambda m: m.type is ManeuverType.STRAIGHT, lane.maneuvers)`",
    )


def known_truth(ev: Evaluator, value: Value, span: Span, purpose: str, *, may_vary: bool = True) -> bool:
    """Return a condition that must be known at compile time; `may_vary`: variants may differ in it."""
    return bool(ev.constant(Quantity(numbers.truth(ev, value, span), PURE), span, purpose, may_vary=may_vary))


def _filter(ev: Evaluator, predicate: Given, items: Given, _span: Span) -> Value:
    closure, among = _closure(ev, predicate), items_of(items.value, items.span)
    if closure.body is None or not _is_of_the_road(ev, closure, closure.body, among):
        return _filtered(ev, closure, among, predicate.span)
    key = closure.body.span, tuple(among)
    if key not in ev.file.roads.filtered:
        ev.file.roads.filtered[key] = _filtered(ev, closure, among, predicate.span)
    return ev.file.roads.filtered[key]


def _filtered(ev: Evaluator, closure: Closure, among: Sequence[Value], span: Span) -> tuple[Value, ...]:
    purpose = "the condition of `filter`"
    return Filtered(item for item in among if known_truth(ev, closure.apply(item), span, purpose)).of(tuple(among))


OF_THE_PLAN = frozenset({"signal", "signals", "isSignalized"})
"""Attributes of road elements that a statement of the file decides."""


def _is_of_the_road(ev: Evaluator, closure: Closure, body: nodes.Expression, among: Sequence[Value]) -> bool:
    """Return whether a lambda reads only fixed attributes of road elements, which all variants share.

    Its result is then computed once, since a town has hundreds of elements.
    """
    if ev.observe is not None:
        return False
    if not all(isinstance(item, Lane | Maneuver | Intersection) for item in among):
        return False
    if body.span not in ev.file.roads.is_about_road:
        ev.file.roads.is_about_road[body.span] = _uses_road(body, closure.parameters)
    return ev.file.roads.is_about_road[body.span]


def _uses_road(body: nodes.Expression, parameters: Sequence[str]) -> bool:
    plain = (nodes.Name, nodes.Attribute, nodes.Compare, nodes.BoolOp, nodes.Unary, nodes.Constant, nodes.String)
    for node in (body, *everything_in(body)):
        if not isinstance(node, plain):
            return False
        if isinstance(node, nodes.Name) and node.id not in (*parameters, "ManeuverType"):
            return False
        if isinstance(node, nodes.Attribute) and node.name in OF_THE_PLAN:
            return False
    return True


def _map(ev: Evaluator, transform: Given, items: Given, _span: Span) -> Value:
    return tuple(map(_closure(ev, transform).apply, items_of(items.value, items.span)))


def _combination(of: Callable[[Term, Term], Term], *, empty: bool) -> Meaning:
    def meaning(ev: Evaluator, items: Given, span: Span) -> Value:
        result: Term = ev.algebra.truth(empty)
        ev.file.budget.spend(span, len(items_of(items.value, items.span)))
        for item in items_of(items.value, items.span):
            result = of(result, numbers.truth(ev, item, items.span))
        return Truth(result)

    return meaning


def _range(ev: Evaluator, given: Sequence[Given], span: Span) -> Value:
    parts = ("the end",) if len(given) == 1 else ("the start", "the end", "the step")
    bounds = [whole_number(ev, g.value, g.span, f"{part} of a `range`") for g, part in zip(given, parts, strict=False)]
    if len(bounds) == 3 and bounds[2] == 0:
        what, cure = "the step of a `range`", "write -1 to count down"
        raise OUT_OF_RANGE.mistake(
            given[2].span, what=what, actual=0, expected="a whole number other than 0", cure=cure
        )
    if not 1 <= len(given) <= 3:
        raise TOO_FEW_ARGUMENTS.mistake(
            span, function="range", missing="an end, or a start and an end", signature="range(start, end)"
        )
    within = range(*bounds)
    count = max(0, -((within.start - within.stop) // within.step))  # `len` refuses what no memory could hold
    if count > RANGE_LIMIT:
        raise OUT_OF_RANGE.mistake(
            span,
            what="the length of a `range`",
            actual=count,
            expected=f"at most {RANGE_LIMIT}",
            cure="use a shorter one",
        )
    ev.file.budget.spend(span, count)
    return tuple(_count(ev, n) for n in within)


def whole_number(ev: Evaluator, value: Value, span: Span, what: str, *, may_vary: bool = True) -> int:
    """Return a whole number that must be known at compile time; `may_vary`: variants may differ in it."""
    given = numbers.quantity(value, span, what)
    if given.dimension not in (None, PURE):
        raise DIMENSION_MISMATCH.mistake(
            span, what=what, expected="a pure number", actual=dimension_name(given.dimension), cure=""
        )
    number = ev.constant(given, span, what, may_vary=may_vary)
    if not math.isfinite(number) or number != math.floor(number):
        raise NOT_WHOLE.mistake(span, what=what, actual=f"{number:g}")
    return int(number)


def _items(_ev: Evaluator, items: Given, _span: Span) -> Value:
    return Items(items_of(items.value, items.span))


# -- the simulation ---------------------------------------------------------------------------------------------------


def _within_distance(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    if not isinstance(vehicle.value, Actor):
        raise WRONG_KIND.mistake(
            vehicle.span, what="`vehicle`", expected="an object", actual=kind_name(vehicle.value), cure="write `self`"
        )
    if not ev.moment.running:
        raise ONLY_WHILE_RUNNING.mistake(span, what="`withinDistanceToAnyObjs`")
    limit = number_for(ev, BUILTINS["withinDistanceToAnyObjs"].parameters[1], distance)
    return Truth(sees_within(limit, vehicle.value.index))


def _color(ev: Evaluator, given: Sequence[Given], _span: Span) -> Value:
    """Looks do not matter here."""
    for each in given:
        numbers.adopt(ev, each.value, PURE, each.span, "a share of a colour")
    return tuple(each.value for each in given)


def _local_path(_ev: Evaluator, path: Given, _span: Span) -> Value:
    return path.value


_RULES: Mapping[Rule, Callable[[Op, str], Meaning]] = {
    Rule.ANGLE_TO_PURE: _of_angle,
    Rule.PURE_TO_ANGLE: _to_angle,
    Rule.PURE: _of_pure_number,
    Rule.ANY: _of_any,
    Rule.ROOT: _root,
    Rule.ALIKE: _alike,
    Rule.ALIKE_TO_ANGLE: _alike_to_angle,
    Rule.EXTREMUM: _extremum,
}
MEANINGS: Mapping[str, Meaning] = {
    **{
        row.spelling.name: _RULES[row.spelling.rule](op, row.spelling.name)
        for op, row in OPERATORS.items()
        if isinstance(row.spelling, FunctionRow)
    },
    "sum": _sum,
    "len": _len,
    "filter": _filter,
    "map": _map,
    "any": _combination(or_, empty=False),
    "all": _combination(and_, empty=True),
    "range": _range,
    "list": _items,
    "tuple": _items,
    "withinDistanceToAnyObjs": _within_distance,
    "localPath": _local_path,
    "Color": _color,
}
"""Functions of numbers and lists; those of the driving domain stand in `driving`."""
