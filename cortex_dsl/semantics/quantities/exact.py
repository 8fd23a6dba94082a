"""Operations that may be calculated while a file is compiled, since that gives the very bits of the kernel."""

import math
from collections.abc import Callable, Mapping

from engine.opcodes import Op


def safe_quotient(a: float, b: float) -> float:
    if b == 0.0:
        return math.nan if a == 0.0 or math.isnan(a) else math.copysign(math.inf, a) * math.copysign(1.0, b)
    return a / b


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
    Op.LT: lambda a, b: float(a < b),
    Op.LE: lambda a, b: float(a <= b),
    Op.EQ: lambda a, b: float(a == b),
    Op.NE: lambda a, b: float(a != b),
    Op.AND: lambda a, b: float(bool(a) and bool(b)),
    Op.OR: lambda a, b: float(bool(a) or bool(b)),
    Op.NOT: lambda a: float(not a),
    Op.SELECT: lambda a, b, c: b if a else c,
}
"""Operations whose results are exactly defined, so that folding them changes no bit."""
