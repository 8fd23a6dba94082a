"""By how much a condition holds: a number that is positive where it does and negative where it does not.

`a <= b` holds by b - a, `a and b` by the lesser of both margins, `a or b` by the greater, `not a` by the opposite;
`a == b` fails by |a - b|. This is the robustness of quantitative semantics: Fainekos and Pappas (2009), "Robustness of
temporal logic specifications for continuous-time signals", Theoretical Computer Science 410. A bare truth (an object
in a region, in sight) has no margin, and neither has what joins conditions of different dimensions: metres and seconds
have no lesser.
"""

from collections.abc import Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.quantities.algebra import Algebra
from cortex_dsl.semantics.quantities.units import LENGTH, PURE
from engine.frozen import frozen
from engine.vocabulary import Op

Dimensions = Mapping[int, ir.Dimension | None]
"""Dimension of what each comparison compares, by the identity of its expression; None where all is bare."""

LENGTHS = frozenset({Op.REGION_DISTANCE, Op.REGION_BOX_DISTANCE, Op.BOX_DISTANCE, Op.PATH_DISTANCE})


@frozen
class Margin:
    expr: ir.Expr
    dimension: ir.Dimension | None


def margin_of(algebra: Algebra, condition: ir.Expr, compared: Dimensions) -> tuple[ir.Expr | None, ir.Dimension]:
    """The margin of a condition, None if it has none, and its dimension."""
    try:
        found = _Margins(algebra, compared).of(condition)
    except Mistake:  # a chain of operations as long as there may be: the condition fits, its margin does not
        found = None
    return (None, PURE) if found is None else (found.expr, found.dimension or PURE)


@frozen
class _Margins:
    algebra: Algebra
    compared: Dimensions

    def of(self, condition: ir.Expr) -> Margin | None:
        match condition:
            case ir.Apply(op=Op.LT | Op.LE, arguments=(left, right)):
                return self._compared(condition, self.algebra.sub(right, left), left)
            case ir.Apply(op=Op.EQ, arguments=(left, right)):
                return self._compared(condition, self._negated(self._apart(left, right)), left)
            case ir.Apply(op=Op.NE, arguments=(left, right)):
                return self._compared(condition, self._apart(left, right), left)
            case ir.Apply(op=Op.AND, arguments=(one, other)):
                return self._joined(Op.MIN, one, other)
            case ir.Apply(op=Op.OR, arguments=(one, other)):
                return self._joined(Op.MAX, one, other)
            case ir.Apply(op=Op.NOT, arguments=(inner,)):
                margin = self.of(inner)
                return margin and Margin(self._negated(margin.expr), margin.dimension)
        return None

    def _compared(self, condition: ir.Expr, difference: ir.Expr, left: ir.Expr) -> Margin | None:
        if isinstance(left, ir.Apply) and left.op in LENGTHS:
            return Margin(difference, LENGTH)
        return Margin(difference, self.compared[id(condition)]) if id(condition) in self.compared else None

    def _joined(self, op: Op, one: ir.Expr, other: ir.Expr) -> Margin | None:
        left, right = self.of(one), self.of(other)
        if left is None or right is None or (None not in (left.dimension, right.dimension) and
                                             left.dimension != right.dimension):  # fmt: skip
            return None
        return Margin(self.algebra.apply(op, left.expr, right.expr), left.dimension or right.dimension)

    def _apart(self, left: ir.Expr, right: ir.Expr) -> ir.Expr:
        return self.algebra.apply(Op.ABS, self.algebra.sub(left, right))

    def _negated(self, expr: ir.Expr) -> ir.Expr:
        return self.algebra.apply(Op.NEG, expr)
