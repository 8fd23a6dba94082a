"""Static bounds of numbers and conditions: intervals, certainty for every choice of a search, and margins.

`engine.feasibility` has intervals of its own, for a reason: there each operation works on thousands of boxes at once,
on compiled code, and tracks NaN. Here an expression is evaluated once or twice in a compilation, where one such array
would cost more than the whole result. A test compares the two.

A margin is a number that is positive if a condition holds and negative if it does not. `a <= b` holds by b - a, `a and
b` by the lesser of both margins, `a or b` by the greater, `not a` by the opposite; `a == b` fails by |a - b|. This is
the robustness of quantitative semantics: Fainekos and Pappas (2009), "Robustness of temporal logic specifications for
continuous-time signals", Theoretical Computer Science 410. A bare truth (an object in a region, in view) has no margin,
and neither has a combination of conditions of different dimensions: metres and seconds have no lesser.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.quantities.algebra import Operation, Term, maximum, minimum
from cortex_dsl.semantics.quantities.exact import EXACT, safe_quotient
from cortex_dsl.semantics.quantities.units import LENGTH, PURE
from engine.frozen import frozen
from engine.opcodes import Op

# -- parts and values --------------------------------------------------------------------------------------------------

_DYNAMIC = frozenset({Op.STATE, Op.TIME, Op.RANDOM, Op.WITHIN, Op.LEAD, Op.TTC, Op.IS_RUNNING,
                      Op.SEES, Op.NOTICES, Op.TOUCHES, Op.VELOCITY, Op.ACTION, Op.CROSSING})  # fmt: skip


def operands(expression: ir.Expr) -> tuple[ir.Expr, ...]:
    """Return the direct operands of an expression."""
    match expression:
        case ir.Apply(arguments=arguments):
            return arguments
        case ir.Pack(items=items):
            return items
        case ir.Item(bundle=bundle):
            return (bundle,)
    return ()


def parts(expression: ir.Expr) -> list[ir.Expr]:
    """Return all distinct parts of an expression, operands before their users, the expression itself last."""
    ordered: dict[ir.Expr, None] = {}
    stack = [(expression, False)]
    while stack:
        part, complete = stack.pop()
        if part in ordered:
            continue
        if complete:
            ordered[part] = None
        else:
            stack.append((part, True))
            stack.extend((operand, False) for operand in operands(part))
    return list(ordered)


def leaves(expression: ir.Expr) -> list[ir.Expr]:
    """All distinct parts without operands of their own."""
    return [part for part in parts(expression) if not operands(part)]


def is_dynamic(expression: ir.Expr) -> bool:
    """Return whether the value may change during a run."""
    return any(map(changes, parts(expression)))


def changes(part: ir.Expr) -> bool:
    """Return whether an operation itself reads the running simulation, regardless of its operands."""
    return isinstance(part, ir.Local | ir.Running) or (isinstance(part, ir.Apply) and part.op in _DYNAMIC)


Result = TypeVar("Result")


def folded(expression: ir.Expr, worth: Callable[[ir.Expr, list[Result]], Result]) -> Result:
    """Fold an expression bottom-up: `worth` maps a part and its operands' results to a result; shared parts once."""
    known: dict[ir.Expr, Result] = {}
    for part in parts(expression):
        known[part] = worth(part, [known[operand] for operand in operands(part)])
    return known[expression]


def _power(a: float, b: float) -> float:
    """Return a power as in the kernels: infinite on overflow, NaN if it is no real number."""
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.inf
    except ValueError:
        return math.inf if a == 0.0 else math.nan


CLOSED: Mapping[Op, Callable[..., float]] = {
    **EXACT,
    Op.MOD: lambda a, b: a % b,
    Op.FLOORDIV: lambda a, b: a // b,
    Op.POW: _power,
    Op.SQRT: math.sqrt,
    Op.SIN: math.sin,
    Op.COS: math.cos,
    Op.TAN: math.tan,
    Op.ASIN: math.asin,
    Op.ACOS: math.acos,
    Op.ATAN: math.atan,
    Op.ATAN2: math.atan2,
    Op.EXP: math.exp,
    Op.LOG: math.log,
    Op.ROUND: lambda a: float(round(a)),
    Op.HYPOT: math.hypot,
    Op.WRAP: lambda a: a - math.tau * math.floor((a + math.pi) / math.tau),
}
"""Values of operations on constants, for checks and indices; never written into the program."""

Numbers = Mapping[int, float]
NOTHING: Numbers = {}


def closed_value(
    expression: ir.Expr,
    operations: Mapping[Op, Callable[..., float]] = CLOSED,
    genes: Numbers = NOTHING,
    draws: Numbers = NOTHING,
) -> float | None:
    """Return the value of an expression without unknowns; None for any other, NaN if it has no value.

    `genes` (SI) and `draws` are known values, by index.
    """

    def worth(part: ir.Expr, values: list[float | None]) -> float | None:
        known = [value for value in values if value is not None]
        match part:
            case ir.Literal(value=value):
                return value
            case ir.Gene(index=index):
                return genes.get(index)
            case ir.Draw(index=index):
                return draws.get(index)
            case ir.Apply(op=op) if op in operations and len(known) == len(values):
                try:
                    return operations[op](*known)
                except (ValueError, ArithmeticError, TypeError):
                    return math.nan
        return None

    return expression.value if isinstance(expression, ir.Literal) else folded(expression, worth)


# -- intervals ---------------------------------------------------------------------------------------------------------

Interval = tuple[float, float]
EVERYTHING: Interval = (-math.inf, math.inf)
UNIFORM: Interval = (0.0, 1.0 - 2.0**-53)


def interval(expression: ir.Expr, genes: Mapping[int, Interval]) -> Interval:
    """Numbers between which the value surely lies; `genes` are the SI bounds by index. Of a truth: (1, 1), (0, 0) or
    (0, 1).
    """
    if isinstance(expression, ir.Literal):  # as most are
        return (expression.value, expression.value)
    return folded(expression, lambda part, within: part_interval(part, within, genes))


def part_interval(part: ir.Expr, within: Sequence[Interval], genes: Mapping[int, Interval]) -> Interval:
    """Return the interval of an operation whose operands lie in the intervals `within`."""
    match part:
        case ir.Literal(value=value):
            return (value, value)
        case ir.Gene(index=index):
            return genes.get(index, EVERYTHING)
        case ir.Draw():
            return UNIFORM
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


def _magnitude(a: Interval) -> Interval:
    return (0.0 if a[0] <= 0.0 <= a[1] else min(map(abs, a)), max(map(abs, a)))


ROUNDED = 1e-12
"""More than by which two ways to round a square root differ, in parts of it."""


def _lengths(a: Interval, b: Interval) -> Interval:
    return (math.hypot(a[0], b[0]) * (1.0 - ROUNDED), math.hypot(a[1], b[1]) * (1.0 + ROUNDED))


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
    Op.ABS: _magnitude,
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
    Op.RANDOM: lambda: UNIFORM,
    Op.HYPOT: lambda a, b: _lengths(_magnitude(a), _magnitude(b)),
    **dict.fromkeys((Op.PATH_DISTANCE, Op.REGION_DISTANCE, Op.BOX_DISTANCE, Op.REGION_BOX_DISTANCE),
                    lambda *_: (0.0, math.inf)),
}  # fmt: skip

# -- certainty of a `require` ------------------------------------------------------------------------------------------


@frozen
class Weight:
    """Of one `require` over all variants in which it was met."""

    possible: bool
    """Whether it could hold in some variant."""
    certain: bool
    """Whether it holds in all of them."""
    genes: frozenset[int]
    """Indices of the genes that it depends on."""

    def joined(self, other: "Weight | None") -> "Weight":
        """Return the weight over the variants of both."""
        if other is None:
            return self
        return Weight(self.possible or other.possible, self.certain and other.certain, self.genes | other.genes)

    def labels(self, genes: Mapping[str, ir.GeneInfo]) -> tuple[Label, ...]:
        """The declared ranges of its genes."""
        return _labels(self.genes, genes)


def weight_of(condition: ir.Expr, truth: Interval, *, certain: bool) -> Weight:
    """Return the weight of a condition by the interval of its truth; `certain`: it is tested in every scene."""
    return Weight(not certain or truth != (0.0, 0.0), truth[0] > 0.0, _genes(condition))


def range_labels(expression: ir.Expr, genes: Mapping[str, ir.GeneInfo]) -> tuple[Label, ...]:
    """The declared ranges of the genes that an expression depends on."""
    return _labels(_genes(expression), genes)


def _genes(expression: ir.Expr) -> frozenset[int]:
    return frozenset(part.index for part in parts(expression) if isinstance(part, ir.Gene))


def _labels(indices: frozenset[int], genes: Mapping[str, ir.GeneInfo]) -> tuple[Label, ...]:
    known = list(genes.values())
    return tuple(Label(known[i].span, _range(known[i])) for i in sorted(indices))


def _range(gene: ir.GeneInfo) -> str:
    if gene.options:
        return f"`{gene.name}` is one of {len(gene.options)} options"
    unit = f" {gene.unit}" if gene.unit else ""
    return f"`{gene.name}` lies between {gene.low:g} and {gene.high:g}{unit}"


# -- margins -----------------------------------------------------------------------------------------------------------

Dimensions = Mapping[Term, ir.Dimension | None]
"""Dimension of the operands of each comparison; None if all are bare."""

LENGTHS = frozenset({Op.REGION_DISTANCE, Op.REGION_BOX_DISTANCE, Op.BOX_DISTANCE, Op.PATH_DISTANCE})


@frozen
class Margin:
    term: Term
    dimension: ir.Dimension | None


def margin_of(condition: Term, compared: Dimensions) -> tuple[Term | None, ir.Dimension]:
    """The margin of a condition, None if it has none, and its dimension."""
    try:
        found = _margin(condition, compared)
    except Mistake:  # a chain of operations as long as there may be: the condition fits, its margin does not
        found = None
    return (None, PURE) if found is None else (found.term, found.dimension or PURE)


def _margin(condition: Term, compared: Dimensions) -> Margin | None:
    match condition:
        case Operation(op=Op.LT | Op.LE, arguments=(left, right)):
            return _of_comparison(condition, right - left, left, compared)
        case Operation(op=Op.EQ, arguments=(left, right)):
            return _of_comparison(condition, -abs(left - right), left, compared)
        case Operation(op=Op.NE, arguments=(left, right)):
            return _of_comparison(condition, abs(left - right), left, compared)
        case Operation(op=Op.AND, arguments=(one, other)):
            return _joined(minimum, _margin(one, compared), _margin(other, compared))
        case Operation(op=Op.OR, arguments=(one, other)):
            return _joined(maximum, _margin(one, compared), _margin(other, compared))
        case Operation(op=Op.NOT, arguments=(inner,)):
            margin = _margin(inner, compared)
            return margin and Margin(-margin.term, margin.dimension)
    return None


def _of_comparison(condition: Term, difference: Term, left: Term, compared: Dimensions) -> Margin | None:
    if isinstance(left, Operation) and left.op in LENGTHS:
        return Margin(difference, LENGTH)
    return Margin(difference, compared[condition]) if condition in compared else None


def _joined(lesser: Callable[..., Term], left: Margin | None, right: Margin | None) -> Margin | None:
    if left is None or right is None:
        return None
    if None not in (left.dimension, right.dimension) and left.dimension != right.dimension:
        return None
    return Margin(lesser(left.term, right.term), left.dimension or right.dimension)
