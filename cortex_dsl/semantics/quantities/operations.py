"""Arithmetic on quantities: dimensions are checked, units were left behind at the literals.

A bare number (dimension None) adopts the dimension of the other side in sums and comparisons; in products and quotients
it is pure. What is computed from bare numbers alone stays bare.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.quantities.algebra import closed_value
from cortex_dsl.semantics.quantities.numbers import finite, warn_of_slip
from cortex_dsl.semantics.quantities.units import (
    PURE,
    dimension_name,
    power,
    product,
    quotient,
    root,
    unit_examples,
)
from cortex_dsl.semantics.values import Quantity, Value
from cortex_dsl.semantics.wording import kind_name
from cortex_dsl.source import Span
from engine.vocabulary import Op

Dimension = ir.Dimension


def common(left: Dimension | None, right: Dimension | None, span: Span, joined: str) -> Dimension | None:
    """Dimension of two sides that must agree; a bare one adopts the other's."""
    if left is None or right is None:
        return right if left is None else left
    if left != right:
        units = [f"{dimension_name(d)} in {unit_examples(d)}" for d in (left, right) if unit_examples(d)]
        raise errors.UNLIKE_OPERANDS.mistake(
            span,
            left=dimension_name(left),
            right=dimension_name(right),
            joined=joined,
            cure="write " + "; ".join(units) if units else "",
        )
    return left


@contextmanager
def sides(left: tuple[Span, Value], right: tuple[Span, Value]) -> Iterator[None]:
    """Operands that do not fit together are shown each with what it measures."""
    try:
        yield
    except Mistake as mistake:
        if mistake.diagnostic is None or mistake.diagnostic.code != errors.UNLIKE_OPERANDS.code:
            raise
        first, second = (Label(span, kind_name(value)) for span, value in (left, right))
        raise Mistake(replace(mistake.diagnostic, label=second, secondary=(first,))) from None


def add(ev: Evaluator, left: Quantity, right: Quantity, span: Span) -> Quantity:
    dimension = common(left.dimension, right.dimension, span, "added")
    return finite(Quantity(ev.algebra.add(left.expr, right.expr), dimension), span)


def subtract(ev: Evaluator, left: Quantity, right: Quantity, span: Span) -> Quantity:
    dimension = common(left.dimension, right.dimension, span, "subtracted")
    return finite(Quantity(ev.algebra.sub(left.expr, right.expr), dimension), span)


def multiply(ev: Evaluator, left: Quantity, right: Quantity, span: Span) -> Quantity:
    dimension = _combined(left.dimension, right.dimension, product)
    return finite(Quantity(ev.algebra.mul(left.expr, right.expr), dimension), span, "it is too large")


def divide(ev: Evaluator, left: Quantity, right: Quantity, span: Span) -> Quantity:
    dimension = _combined(left.dimension, right.dimension, quotient)
    return finite(Quantity(ev.algebra.apply(Op.DIV, left.expr, right.expr), dimension), span, "it divides by zero")


def _combined(
    left: Dimension | None, right: Dimension | None, rule: Callable[[Dimension, Dimension], Dimension]
) -> Dimension | None:
    """A bare factor is pure, but a bare and a pure number give a bare one: the bare may stand for anything."""
    if left is None and right is None:
        return None
    dimension = rule(left or PURE, right or PURE)
    return None if None in (left, right) and dimension == PURE else dimension


def floor_divide(ev: Evaluator, left: Quantity, right: Quantity, span: Span) -> Quantity:
    common(left.dimension, right.dimension, span, "divided into whole parts")
    _not_zero(right, span)
    dimension = None if left.dimension is None and right.dimension is None else PURE
    return Quantity(ev.algebra.apply(Op.FLOORDIV, left.expr, right.expr), dimension)


def modulo(ev: Evaluator, left: Quantity, right: Quantity, span: Span) -> Quantity:
    dimension = common(left.dimension, right.dimension, span, "divided with remainder")
    _not_zero(right, span)
    return Quantity(ev.algebra.apply(Op.MOD, left.expr, right.expr), dimension)


def _not_zero(divisor: Quantity, span: Span) -> None:
    if closed_value(divisor.expr) == 0.0:
        raise errors.NOT_FINITE.mistake(span, reason="it divides by zero")


def raised(ev: Evaluator, base: Quantity, exponent: Quantity, span: Span) -> Quantity:
    if exponent.dimension not in (None, PURE):
        raise errors.DIMENSION_MISMATCH.mistake(
            span, what="an exponent", expected="a pure number", actual=dimension_name(exponent.dimension), cure=""
        )
    dimension = base.dimension
    if dimension not in (None, PURE):
        known = closed_value(exponent.expr)
        if known is None or known != math.floor(known) or abs(known) > 16:
            raise errors.POWER_NOT_CONSTANT.mistake(span, what=dimension_name(dimension))
        dimension = power(dimension, int(known))
    result = ev.algebra.apply(Op.POW, base.expr, exponent.expr)
    value = closed_value(result)
    if value is not None and not math.isfinite(value):
        reason = "its power is not a real number" if math.isnan(value) else "it is too large"
        raise errors.NOT_FINITE.mistake(span, reason=reason)
    return Quantity(result, dimension)


def square_root(ev: Evaluator, base: Quantity, span: Span) -> Quantity:
    dimension = base.dimension if base.dimension is None else root(base.dimension)
    if dimension is None and base.dimension is not None:
        raise errors.DIMENSION_MISMATCH.mistake(
            span,
            what="under a square root there",
            expected="a square",
            actual=dimension_name(base.dimension),
            cure="as in `sqrt(x * x + y * y)`",
        )
    value = closed_value(base.expr)
    if value is not None and value < 0.0:
        raise errors.NOT_FINITE.mistake(span, reason=f"it is the square root of {value:g}")
    return Quantity(ev.algebra.apply(Op.SQRT, base.expr), dimension)


def negated(ev: Evaluator, operand: Quantity) -> Quantity:
    return Quantity(ev.algebra.apply(Op.NEG, operand.expr), operand.dimension)


_ORDER = {"<": (Op.LT, False), "<=": (Op.LE, False), ">": (Op.LT, True), ">=": (Op.LE, True),
          "==": (Op.EQ, False), "!=": (Op.NE, False)}  # fmt: skip


def compare(ev: Evaluator, operator: str, left: Quantity, right: Quantity, span: Span) -> ir.Expr:
    dimension = common(left.dimension, right.dimension, span, "compared")
    if dimension is not None and None in (left.dimension, right.dimension):
        warn_of_slip(ev, left if left.dimension is None else right, dimension, span)
    op, swapped = _ORDER[operator]
    operands = (right.expr, left.expr) if swapped else (left.expr, right.expr)
    result = ev.algebra.apply(op, *operands)
    ev.run.compared[id(result)] = dimension or ev.run.compared.get(id(result))
    return result


def select(ev: Evaluator, condition: ir.Expr, then: Quantity, otherwise: Quantity, span: Span) -> Quantity:
    dimension = common(then.dimension, otherwise.dimension, span, "alternatives of each other")
    return Quantity(ev.algebra.apply(Op.SELECT, condition, then.expr, otherwise.expr), dimension)
