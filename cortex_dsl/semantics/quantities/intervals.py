"""Interval reasoning: between which numbers an expression lies, and whether a condition is decided, over all genes.

`engine.feasibility` has intervals of its own, and for good reason: there each operation answers for thousands of boxes
at once, on compiled code, and keeps account of NaN. Here an expression is asked once or twice while a file is compiled,
where one such array would cost more than the whole answer. A test holds the two together.
"""

import math
from collections.abc import Callable, Mapping, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.algebra import folded, safe_quotient
from engine.vocabulary import Op

Interval = tuple[float, float]
EVERYTHING: Interval = (-math.inf, math.inf)


def interval(expression: ir.Expr, genes: Mapping[int, Interval]) -> Interval:
    """Numbers between which the value surely lies; `genes` are the SI bounds by index. Of a truth: (1, 1), (0, 0) or
    (0, 1).
    """
    return folded(expression, lambda part, within: part_interval(part, within, genes))


def part_interval(part: ir.Expr, within: Sequence[Interval], genes: Mapping[int, Interval]) -> Interval:
    """The same of an operation whose operands lie in the intervals `within`."""
    match part:
        case ir.Literal(value=value):
            return (value, value)
        case ir.Gene(index=index):
            return genes.get(index, EVERYTHING)
        case ir.Draw():
            return (0.0, 1.0)
        case ir.Apply(op=op) if op in _INTERVALS:
            result = _INTERVALS[op](*within)
            return EVERYTHING if math.isnan(result[0] + result[1]) else result
    return EVERYTHING


def _hull(*values: float) -> Interval:
    return (min(values), max(values))


def _quotients(a: Interval, b: Interval) -> Interval:
    return EVERYTHING if b[0] <= 0.0 <= b[1] else _hull(*(safe_quotient(x, y) for x in a for y in b))


def _roots(a: Interval) -> Interval:
    return EVERYTHING if a[0] < 0.0 else (math.sqrt(a[0]), math.sqrt(a[1]))


def _floor(end: float) -> float:
    return end if math.isinf(end) else float(math.floor(end))


def _truth(always: bool, never: bool) -> Interval:
    return (float(always), float(not never))


def _never_zero(a: Interval) -> bool:
    return a[0] > 0.0 or a[1] < 0.0


_INTERVALS: Mapping[Op, Callable[..., Interval]] = {
    Op.ADD: lambda a, b: (a[0] + b[0], a[1] + b[1]),
    Op.SUB: lambda a, b: (a[0] - b[1], a[1] - b[0]),
    Op.MUL: lambda a, b: _hull(*(x * y for x in a for y in b)),
    Op.DIV: _quotients,
    Op.SQRT: _roots,
    Op.SIN: lambda _: (-1.0, 1.0),
    Op.COS: lambda _: (-1.0, 1.0),
    Op.NEG: lambda a: (-a[1], -a[0]),
    Op.ABS: lambda a: (0.0 if a[0] <= 0.0 <= a[1] else min(map(abs, a)), max(map(abs, a))),
    Op.MIN: lambda a, b: (min(a[0], b[0]), min(a[1], b[1])),
    Op.MAX: lambda a, b: (max(a[0], b[0]), max(a[1], b[1])),
    Op.FLOOR: lambda a: (_floor(a[0]), _floor(a[1])),
    Op.SELECT: lambda _, b, c: _hull(*b, *c),
    Op.LT: lambda a, b: _truth(a[1] < b[0], a[0] >= b[1]),
    Op.LE: lambda a, b: _truth(a[1] <= b[0], a[0] > b[1]),
    Op.EQ: lambda a, b: _truth(a[0] == a[1] == b[0] == b[1], a[1] < b[0] or b[1] < a[0]),
    Op.NE: lambda a, b: _truth(a[1] < b[0] or b[1] < a[0], a[0] == a[1] == b[0] == b[1]),
    Op.AND: lambda a, b: _truth(_never_zero(a) and _never_zero(b), (0.0, 0.0) in (a, b)),
    Op.OR: lambda a, b: _truth(_never_zero(a) or _never_zero(b), a == b == (0.0, 0.0)),
    Op.NOT: lambda a: _truth(a == (0.0, 0.0), _never_zero(a)),
    Op.RANDOM: lambda: (0.0, 1.0),
    **dict.fromkeys((Op.HYPOT, Op.PATH_DISTANCE, Op.REGION_DISTANCE, Op.BOX_DISTANCE, Op.REGION_BOX_DISTANCE),
                    lambda *_: (0.0, math.inf)),
}  # fmt: skip
