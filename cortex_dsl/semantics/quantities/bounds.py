"""Static bounds of numbers and conditions: intervals, certainty for every choice of a search, and margins.

A margin is a number that is positive where a condition holds and negative where it does not. `a <= b` holds by b - a,
`a and b` by the lesser of both margins, `a or b` by the greater, `not a` by the opposite; `a == b` fails by |a - b|.
This is the robustness of quantitative semantics: Fainekos and Pappas (2009), "Robustness of temporal logic
specifications for continuous-time signals", Theoretical Computer Science 410. A bare truth (an object in a region, in
view) has no margin, and neither has what joins conditions of different dimensions: metres and seconds have no lesser.
"""

import math
from collections.abc import Callable, Container, Mapping, Sequence
from typing import TypeVar

import numpy as np

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.quantities.algebra import Operation, Term, maximum, minimum
from cortex_dsl.semantics.quantities.units import LENGTH, PURE
from engine.frozen import frozen
from engine.opcodes import Op
from engine.operators import OPERATORS, Operator
from engine.operators.bounds import EVERYTHING, Domain, Interval
from engine.operators.intervals import between

# -- parts and values --------------------------------------------------------------------------------------------------


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


def parts(expression: ir.Expr, apart: Container[ir.Expr] = ()) -> list[ir.Expr]:
    """Return all distinct parts of an expression, operands before their users, the expression itself last.

    Parts in `apart` are left out, with the parts that only they have.
    """
    ordered: dict[ir.Expr, None] = {}
    stack = [(expression, False)]
    while stack:
        part, complete = stack.pop()
        if part in ordered or part in apart:
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
    """Whether an operation of its own reads the running simulation, whatever its operands do."""
    return isinstance(part, ir.Local | ir.Running) or (isinstance(part, ir.Apply) and Op.STATE <= part.op < Op.JUMP)


Result = TypeVar("Result")


def folded(
    expression: ir.Expr,
    value_of: Callable[[ir.Expr, list[Result]], Result],
    known: dict[ir.Expr, Result] | None = None,
) -> Result:
    """Fold an expression bottom-up: `value_of` maps a part and its operands' results to a result; shared parts once.

    `known` holds the results of parts that were folded before, and gets the new ones.
    """
    known = {} if known is None else known
    for part in parts(expression, known):
        known[part] = value_of(part, [known[operand] for operand in operands(part)])
    return known[expression]


CLOSED: Mapping[Op, Callable[..., float]] = {op: row.value for op, row in OPERATORS.items()}
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

    def known_value(part: ir.Expr, values: list[float | None]) -> float | None:
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
                except ValueError:  # the number of a path or region is NaN
                    return math.nan
        return None

    if isinstance(expression, ir.Literal):
        return expression.value
    if isinstance(expression, Term) and operations is CLOSED and not genes and not draws:
        return folded(expression, known_value, expression.algebra.closed)
    return folded(expression, known_value)


# -- intervals ---------------------------------------------------------------------------------------------------------

UNIFORM: Interval = (0.0, 1.0 - 2.0**-53)
LENGTHS = frozenset({Op.REGION_DISTANCE, Op.REGION_BOX_DISTANCE, Op.BOX_DISTANCE, Op.PATH_DISTANCE})
"""Operations whose result is a length, 0 or more."""


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
        case ir.Apply(op=Op.RANDOM):
            return UNIFORM
        case ir.Apply(op=op) if op in LENGTHS:
            return (0.0, math.inf)
        case ir.Apply(op=op) if op in OPERATORS and op != Op.NORMAL_QUANTILE:
            result = _of_operator(OPERATORS[op], within)
            return EVERYTHING if math.isnan(result[0] + result[1]) else result
    return EVERYTHING  # also of a normal distribution, whose draws only their resolution keeps between two numbers


def _of_operator(row: Operator, within: Sequence[Interval]) -> Interval:
    """Return the interval of the result of an operator; all numbers if it may be NaN."""
    if row.bounds is not None:
        return row.bounds(*within)
    with np.errstate(all="ignore"):
        low, high, undefined = row.forward(*(between(*ends, 1) for ends in within))
    return EVERYTHING if undefined[0] else (float(low[0]), float(high[0]))


# -- operations without a value ----------------------------------------------------------------------------------------
# The root of a negative number has none, nor has 0 / 0, nor what is made of them, comparisons and conditions included.
# What bounds neither exclude nor prove, the scene or the run decides: it is an error where the number does not exist.


def may_be_undefined(
    expression: ir.Expr, interval: Callable[[ir.Expr], Interval], known: dict[ir.Expr, bool] | None = None
) -> bool:
    """Return True if a part of an expression may have no value; `interval` gives the bounds of a part.

    `known` holds the answers for parts from before, and gets the new ones.
    """

    def undefined(part: ir.Expr, inside: list[bool]) -> bool:
        domain = _domain(part.op) if isinstance(part, ir.Apply) else None
        return any(inside) or (domain is not None and not domain.holds(*map(interval, operands(part))))

    return folded(expression, undefined, known)


def truth_of(condition: ir.Expr, interval: Callable[[ir.Expr], Interval]) -> Interval:
    """Return the interval of the truth of a condition: (1, 1), (0, 0), or (0, 1) also if it may have no value."""
    return (0.0, 1.0) if may_be_undefined(condition, interval) else interval(condition)


def is_undefined(op: Op, intervals: Sequence[Interval]) -> bool:
    """Return True if an operation has no value, wherever in these intervals its operands lie."""
    domain = _domain(op)
    return domain is not None and domain.misses(*intervals)


def _domain(op: Op) -> Domain | None:
    return OPERATORS[op].domain if op in OPERATORS else None


# -- what is certain of a `require` ------------------------------------------------------------------------------------


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

    def labels(self, genes: Sequence[ir.GeneInfo]) -> tuple[Label, ...]:
        """The declared ranges of its genes."""
        return _labels(self.genes, genes)


def weight_of(condition: ir.Expr, truth: Interval, *, certain: bool) -> Weight:
    """Return the weight of a condition by the interval of its truth; `certain`: it is tested in every scene."""
    return Weight(not certain or truth != (0.0, 0.0), truth[0] > 0.0, _genes(condition))


def range_labels(expression: ir.Expr, genes: Sequence[ir.GeneInfo]) -> tuple[Label, ...]:
    """The declared ranges of the genes that an expression depends on."""
    return _labels(_genes(expression), genes)


def _genes(expression: ir.Expr) -> frozenset[int]:
    return frozenset(part.index for part in parts(expression) if isinstance(part, ir.Gene))


def _labels(indices: frozenset[int], genes: Sequence[ir.GeneInfo]) -> tuple[Label, ...]:
    return tuple(Label(genes[i].span, _range(genes[i])) for i in sorted(indices))


def _range(gene: ir.GeneInfo) -> str:
    if gene.options:
        return f"`{gene.name}` is one of {len(gene.options)} options"
    unit = f" {gene.unit}" if gene.unit else ""
    return f"`{gene.name}` lies between {gene.low:g} and {gene.high:g}{unit}"


# -- margins -----------------------------------------------------------------------------------------------------------

Dimensions = Mapping[Term, ir.Dimension | None]
"""Dimension of the operands of each comparison; None if all are bare."""


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
