"""FIXME: a docstring"""

from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.model.context import Evaluator
from engine.vocabulary import Op


def gathered(ev: Evaluator, op: Op, items: Sequence[ir.Expr], empty: float) -> ir.Expr:
    """All items joined by an associative operation, as a tree: long chains of operations are refused."""
    if len(items) < 2:
        return items[0] if items else ev.algebra.literal(empty)
    half = len(items) // 2
    return ev.algebra.apply(op, gathered(ev, op, items[:half], empty), gathered(ev, op, items[half:], empty))


def any_of(ev: Evaluator, items: Sequence[ir.Expr]) -> ir.Expr:
    return gathered(ev, Op.OR, items, 0.0)


def all_of(ev: Evaluator, items: Sequence[ir.Expr]) -> ir.Expr:
    return gathered(ev, Op.AND, items, 1.0)


def chosen(ev: Evaluator, index: ir.Expr, items: Sequence[ir.Expr], first: int = 0) -> ir.Expr:
    """The item of a number that only the run knows, found by halving."""
    if len(items) == 1:
        return items[0]
    half = len(items) // 2
    below = ev.algebra.apply(Op.LT, index, ev.algebra.literal(float(first + half)))
    return ev.algebra.apply(
        Op.SELECT, below, chosen(ev, index, items[:half], first), chosen(ev, index, items[half:], first + half)
    )
