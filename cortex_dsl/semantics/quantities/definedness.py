"""Domains of operations: the root of a negative number has no value, nor has 0 / 0.

An expression with an undefined operand is undefined too, including comparisons and conditions. This module contains the
cases that bounds exclude or prove; the scene or the run decides the others, and an undefined number is an error there.
"""

from collections.abc import Callable, Mapping, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.bounds import Interval, operands, parts
from engine.opcodes import Op


def _not_zero(_dividend: Interval, divisor: Interval) -> bool:
    return divisor[0] > 0.0 or divisor[1] < 0.0


def _is_power(base: Interval, exponent: Interval) -> bool:
    """A positive base, or a known whole exponent."""
    return base[0] > 0.0 or (exponent[0] == exponent[1] >= 0.0 and exponent[0] == exponent[0] // 1.0)


DEFINED: Mapping[Op, Callable[..., bool]] = {
    Op.DIV: _not_zero,
    Op.MOD: _not_zero,
    Op.FLOORDIV: _not_zero,
    Op.POW: _is_power,
    Op.SQRT: lambda a: a[0] >= 0.0,
    Op.LOG: lambda a: a[0] > 0.0,
    Op.ASIN: lambda a: a[0] >= -1.0 and a[1] <= 1.0,
    Op.ACOS: lambda a: a[0] >= -1.0 and a[1] <= 1.0,
}
"""Operations with undefined cases, and tests that all operands in the given intervals have a value."""
UNDEFINED: Mapping[Op, Callable[..., bool]] = {
    Op.SQRT: lambda a: a[1] < 0.0,
    Op.LOG: lambda a: a[1] <= 0.0,
    Op.ASIN: lambda a: a[0] > 1.0 or a[1] < -1.0,
    Op.ACOS: lambda a: a[0] > 1.0 or a[1] < -1.0,
}
"""Tests that no operands in the given intervals have a value."""


def may_be_undefined(expression: ir.Expr, interval: Callable[[ir.Expr], Interval]) -> bool:
    """Return whether a part of an expression may have no value; `interval` returns the bounds of a part."""
    return any(
        isinstance(part, ir.Apply) and part.op in DEFINED and not DEFINED[part.op](*map(interval, operands(part)))
        for part in parts(expression)
    )


def is_undefined(op: Op, intervals: Sequence[Interval]) -> bool:
    """Return whether an operation has no value for any operands in these intervals."""
    return op in UNDEFINED and UNDEFINED[op](*intervals)
