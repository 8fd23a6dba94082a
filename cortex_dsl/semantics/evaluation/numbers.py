"""Values as numbers: adopted dimensions, permitted ranges, suspicious bare numbers, and arithmetic.

Dimensions are checked; units end at the literals. A bare number (dimension None) adopts the dimension of its place, and
of the other operand in sums and comparisons; in products and quotients it is pure. A result of bare numbers alone is
bare.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from operator import ge, gt, le, lt

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.values import (
    DIMENSION_MISMATCH,
    NOT_FINITE,
    POWER_NOT_CONSTANT,
    SUSPICIOUS_ACCELERATION,
    SUSPICIOUS_ANGLE,
    SUSPICIOUS_LENGTH,
    SUSPICIOUS_SPEED,
    SUSPICIOUS_TIME,
    UNLIKE_OPERANDS,
    WRONG_KIND,
)
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    BehaviourCall,
    BuiltinValue,
    MonitorCall,
    MonitorValue,
    Quantity,
    Truth,
    Value,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import Operation, Term, equal, function_of, unequal, where
from cortex_dsl.semantics.quantities.bounds import closed_value, is_undefined, range_labels
from cortex_dsl.semantics.quantities.units import (
    ACCELERATION,
    ANGLE,
    LENGTH,
    PURE,
    SPEED,
    TIME,
    UNITS,
    dimension_name,
    example,
    power,
    product,
    quotient,
    unit_examples,
)
from cortex_dsl.source import Span
from engine.opcodes import Op
from engine.operators import OPERATORS, Infix, Rule
from engine.operators.bounds import DIVISIONS, POWERS

Dimension = ir.Dimension
MOST_BARE_SPEED = 40.0
"""A bare speed above this [m/s] was probably meant in km/h."""
MOST_BARE_LENGTH = 500.0
"""A bare length above this [m] was probably meant in centimetres: no road of a usual map is that long."""
MOST_BARE_TIME = 600.0
"""A bare time above this [s] was probably meant in milliseconds."""
MOST_BARE_ACCELERATION = 20.0
"""A bare acceleration above this [m/s^2] is no car's: tyres on a dry road give 10."""
ROUNDING = 1e-9
"""Relative slack of an interval's ends: `low + u (high - low)` may round past `high`."""


def quantity(value: Value, span: Span, what: str = "this", cure: str = "") -> Quantity:
    """Return the value as a number; `cure` is for a value that is neither a number nor a text of one.

    Raises:
        Mistake: the value is no number.
    """
    if isinstance(value, Quantity):
        return value
    quoted = isinstance(value, str) and value.strip()[:1].isdigit()
    cure = f"write it without quotes: `{value}`" if quoted else cure
    raise WRONG_KIND.mistake(span, what=what, expected="a number", actual=kind_name(value), cure=cure)


def _as_condition(value: Value) -> str:
    if isinstance(value, BehaviourCall | BuiltinValue):
        return "`and` and `or` join conditions; list things with commas, as in `do choose A(), B()`"
    if isinstance(value, MonitorCall | MonitorValue):
        monitor = value.monitor.node if isinstance(value, MonitorCall) else value.node
        return f"write `require monitor {monitor.name}({'...' if monitor.parameters else ''})`"
    return "compare it with something, as in `x < 3`"


def truth(ev: Evaluator, value: Value, span: Span) -> Term:
    """The value as a condition; as in Python, lists and None have a truth of their own."""
    match value:
        case Truth(expr):
            return expr
        case Quantity(expr, dimension) if dimension in (None, PURE):
            return unequal(expr, 0.0)
        case None | str() | tuple():
            return ev.algebra.truth(bool(value))
    raise WRONG_KIND.mistake(
        span, what="a condition", expected="a truth value", actual=kind_name(value), cure=_as_condition(value)
    )


def literal(ev: Evaluator, value: float, dimension: Dimension | None, span: Span, reason: str = "") -> Quantity:
    return finite(Quantity(ev.algebra.literal(value), dimension), span, reason)


def finite(result: Quantity, span: Span, reason: str = "") -> Quantity:
    """The result, unless it is a constant that is no number."""
    if isinstance(result.expr, ir.Literal) and not math.isfinite(result.expr.value):
        raise NOT_FINITE.mistake(span, reason=reason or f"it is {result.expr.value}")
    return result


def adopt(ev: Evaluator, value: Value, dimension: Dimension, span: Span, what: str, cure: str = "") -> Term:
    """The SI number that a place of a known dimension takes; without a cure, one names the units of the dimension.

    Raises:
        Mistake: when the value is no number or has another dimension.
    """
    number = quantity(value, span, what, cure)
    if number.dimension is None:
        warn_of_slip(ev, number, dimension, span)
        if isinstance(number.expr, ir.Gene):
            ev.file.genes.dimensions.setdefault(number.expr.index, set()).add(dimension)
    elif number.dimension != dimension:
        raise DIMENSION_MISMATCH.mistake(
            span,
            what=what,
            expected=dimension_name(dimension),
            actual=dimension_name(number.dimension),
            cure=cure or unit_cure(dimension),
        )
    return number.expr


def unit_cure(dimension: Dimension) -> str:
    """Return an example of numbers of a dimension, as the cure for a number with another dimension."""
    words = unit_examples(dimension)
    if words:
        return f"units of {dimension_name(dimension).split(' ', 1)[1]}: {words}"
    return f"write a number without a unit, as in `{example(PURE)}`" if dimension == PURE else ""


def warn_of_slip(ev: Evaluator, number: Quantity, dimension: Dimension, span: Span) -> None:
    """Warn about the assumed unit of a bare number if its size suggests another unit."""
    low, high = ev.interval(number.expr)
    value = high if abs(high) >= abs(low) else low
    if not math.isfinite(value):
        return
    size, (place, uses) = abs(value), _where(ev, number, dimension, span)
    if dimension == ANGLE and size > math.tau + 1e-6:
        ev.report(SUSPICIOUS_ANGLE.at(place, secondary=uses, value=value, turns=size / math.tau))
    elif dimension == SPEED and value > MOST_BARE_SPEED:
        ev.report(SUSPICIOUS_SPEED.at(place, secondary=uses, value=value, kmh=value * 3.6))
    elif dimension == LENGTH and size > MOST_BARE_LENGTH:
        ev.report(SUSPICIOUS_LENGTH.at(place, secondary=uses, value=value, kilometres=value / 1000.0))
    elif dimension == TIME and size > MOST_BARE_TIME:
        ev.report(SUSPICIOUS_TIME.at(place, secondary=uses, value=value, minutes=value / 60.0))
    elif dimension == ACCELERATION and size > MOST_BARE_ACCELERATION:
        gravities = value / UNITS["g"].factor
        ev.report(SUSPICIOUS_ACCELERATION.at(place, secondary=uses, value=value, gravities=gravities))


def _where(ev: Evaluator, number: Quantity, dimension: Dimension, span: Span) -> tuple[Span, tuple[Label, ...]]:
    """Return the place of a missing unit (the param's line if the number is a param), and labels for other places."""
    if not isinstance(number.expr, ir.Gene):
        return span, range_labels(number.expr, ev.file.genes.infos)
    return ev.file.genes.infos[number.expr.index].span, (Label(span, f"taken for {dimension_name(dimension)}"),)


# -- arithmetic --------------------------------------------------------------------------------------------------------


def common(left: Dimension | None, right: Dimension | None, span: Span, joined: str) -> Dimension | None:
    """Dimension of two sides that must agree; a bare one adopts the other's."""
    if left is None or right is None:
        return right if left is None else left
    if left != right:
        units = [f"{dimension_name(d)} in {unit_examples(d)}" for d in (left, right) if unit_examples(d)]
        raise UNLIKE_OPERANDS.mistake(
            span,
            left=dimension_name(left),
            right=dimension_name(right),
            joined=joined,
            cure="write " + "; ".join(units) if units else "",
        )
    return left


@contextmanager
def sides(left: tuple[Span, Value], right: tuple[Span, Value]) -> Iterator[None]:
    """Label each operand with its dimension if the operands do not fit together."""
    try:
        yield
    except Mistake as mistake:
        if mistake.diagnostic is None or mistake.diagnostic.code != UNLIKE_OPERANDS.code:
            raise
        first, second = (Label(span, kind_name(value)) for span, value in (left, right))
        raise Mistake(replace(mistake.diagnostic, label=second, secondary=(first,))) from None


def combined(op: Op, left: Quantity, right: Quantity, span: Span) -> Quantity:
    """Return the result of an arithmetic operator on two numbers."""
    row = OPERATORS[op]
    assert isinstance(row.spelling, Infix)
    assert row.spelling.rule is not None
    dimension = _DIMENSIONS[row.spelling.rule](left, right, span, row.spelling.joined)
    if row.domain is DIVISIONS and closed_value(right.expr) == 0.0:
        raise NOT_FINITE.mistake(span, reason="it divides by zero")
    result = function_of(op)(left.expr, right.expr)
    if row.domain is POWERS and (value := closed_value(result)) is not None and not math.isfinite(value):
        reason = "its power is not a real number" if math.isnan(value) else "it is too large"
        raise NOT_FINITE.mistake(span, reason=reason)
    return finite(Quantity(result, dimension), span, "it is too large")


def _alike(left: Quantity, right: Quantity, span: Span, joined: str) -> Dimension | None:
    return common(left.dimension, right.dimension, span, joined)


def _alike_to_pure(left: Quantity, right: Quantity, span: Span, joined: str) -> Dimension | None:
    return None if common(left.dimension, right.dimension, span, joined) is None else PURE


def _of_factors(rule: Callable[[Dimension, Dimension], Dimension]) -> Callable[..., Dimension | None]:
    """A bare factor is pure, but a bare and a pure number give a bare one: the bare may stand for anything."""

    def dimension_of(left: Quantity, right: Quantity, _span: Span, _joined: str) -> Dimension | None:
        if left.dimension is None and right.dimension is None:
            return None
        dimension = rule(left.dimension or PURE, right.dimension or PURE)
        return None if None in (left.dimension, right.dimension) and dimension == PURE else dimension

    return dimension_of


def _of_power(base: Quantity, exponent: Quantity, span: Span, _joined: str) -> Dimension | None:
    if exponent.dimension not in (None, PURE):
        raise DIMENSION_MISMATCH.mistake(
            span, what="an exponent", expected="a pure number", actual=dimension_name(exponent.dimension), cure=""
        )
    if base.dimension in (None, PURE):
        return base.dimension
    known = closed_value(exponent.expr)
    if known is None or known != math.floor(known) or abs(known) > 16:
        raise POWER_NOT_CONSTANT.mistake(span, what=dimension_name(base.dimension))
    return power(base.dimension, int(known))


_DIMENSIONS: Mapping[Rule, Callable[[Quantity, Quantity, Span, str], Dimension | None]] = {
    Rule.ALIKE: _alike,
    Rule.ALIKE_TO_PURE: _alike_to_pure,
    Rule.PRODUCT: _of_factors(product),
    Rule.QUOTIENT: _of_factors(quotient),
    Rule.POWER: _of_power,
}


def defined(ev: Evaluator, result: Term, span: Span, reason: str) -> Term:
    """The result of an operation on one number, unless it has none wherever its operand may lie.

    `reason` has a place for the operand.

    Raises:
        Mistake: it is surely no finite number.
    """
    if not isinstance(result, Operation):
        return result
    value, within = closed_value(result), tuple(map(ev.interval, result.arguments))
    if is_undefined(result.op, within) or (value is not None and not math.isfinite(value)):
        known, (low, high) = closed_value(result.arguments[0]), within[0]
        operand = f"{low:g} to {high + 0.0:g}" if known is None else f"{known:g}"
        raise NOT_FINITE.mistake(
            span, reason=reason.format(operand), secondary=range_labels(result, ev.file.genes.infos)
        )
    return result


def negated(operand: Quantity) -> Quantity:
    return Quantity(-operand.expr, operand.dimension)


_COMPARISONS: Mapping[str, Callable[[Term, Term], Term]] = {
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
    "==": equal,
    "!=": unequal,
}


def compare(ev: Evaluator, operator: str, left: Quantity, right: Quantity, span: Span) -> Term:
    dimension = common(left.dimension, right.dimension, span, "compared")
    if dimension is not None and None in (left.dimension, right.dimension):
        warn_of_slip(ev, left if left.dimension is None else right, dimension, span)
    result = _COMPARISONS[operator](left.expr, right.expr)
    ev.run.compared[result] = dimension or ev.run.compared.get(result)
    return result


def select(condition: Term, then: Quantity, otherwise: Quantity, span: Span) -> Quantity:
    dimension = common(then.dimension, otherwise.dimension, span, "alternatives of each other")
    return Quantity(where(condition, then.expr, otherwise.expr), dimension)
