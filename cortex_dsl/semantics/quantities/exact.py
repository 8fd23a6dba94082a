"""Operations that may be calculated while a file is compiled, since that gives the very bits of the kernel."""

import math
import operator
from collections.abc import Callable, Mapping

from engine.opcodes import Op


def safe_quotient(a: float, b: float) -> float:
    if b == 0.0:
        return math.nan if a == 0.0 or math.isnan(a) else math.copysign(math.inf, a) * math.copysign(1.0, b)
    return a / b


def _compared(holds: Callable[[float, float], bool]) -> Callable[[float, float], float]:
    """A comparison as the kernels have it: NaN where an operand is."""
    return lambda a, b: math.nan if math.isnan(a) or math.isnan(b) else float(holds(a, b))


def _both(a: float, b: float) -> float:
    """NaN where the operands that are numbers do not decide."""
    if 0.0 in (a, b):
        return 0.0
    return math.nan if math.isnan(a) or math.isnan(b) else 1.0


def _negation(a: float) -> float:
    return math.nan if math.isnan(a) else float(not a)


def _selected(condition: float, then: float, otherwise: float) -> float:
    return math.nan if math.isnan(condition) else then if condition else otherwise


EXACT: Mapping[Op, Callable[..., float]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUB: lambda a, b: a - b,
    Op.MUL: lambda a, b: a * b,
    Op.DIV: safe_quotient,
    Op.NEG: lambda a: -a,
    Op.ABS: lambda a: abs(a),  # noqa: PLW0108 - the builtin's own type is too wide
    Op.MIN: lambda a, b: b if b < a else a,
    Op.MAX: lambda a, b: b if b > a else a,
    Op.FLOOR: lambda a: float(math.floor(a)),
    Op.CEIL: lambda a: float(math.ceil(a)),
    Op.LT: _compared(operator.lt),
    Op.LE: _compared(operator.le),
    Op.EQ: _compared(operator.eq),
    Op.NE: _compared(operator.ne),
    Op.AND: _both,
    Op.OR: lambda a, b: _negation(_both(_negation(a), _negation(b))),
    Op.NOT: _negation,
    Op.SELECT: _selected,
}
"""Operations with exactly defined results, so that folding them changes no bit."""
