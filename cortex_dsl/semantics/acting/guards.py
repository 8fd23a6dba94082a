"""Conditions that abort a run: guards of behaviours, and `require` in behaviours and monitors.

As in Scenic, preconditions are tested when a behaviour starts, and invariants then and in every sample in which the
behaviour itself goes on: not while something that it `do`es is running, but again when that has ended.
Source: Scenic 3 reference, "Behavior Definition".
"""

from collections.abc import Callable, Iterable

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.quantities.algebra import closed_value
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.vocabulary import Op, RuleKind

Condition = Callable[[nodes.Expression], ir.Expr]
"""The truth of a condition at every later moment."""


def tested(
    ev: Evaluator, guards: Iterable[nodes.Guard], kind: str, name: str, condition: Condition, call: Span
) -> tuple[tuple[ir.Expr, int], ...]:
    """The conditions of guards and the rules that abort the run where they are false."""
    found = []
    for guard in guards:
        holds = condition(guard.condition)
        rule = abort_rule(ev, guard.condition.span, f"{kind} of {name}: {source_of(ev, guard.condition)}")
        if closed_value(holds) == 0.0:
            where = (Label(call, "started here"),)
            ev.report(errors.GUARD_NEVER.at(guard.condition.span, secondary=where, guard=kind, name=name))
        found.append((holds, rule))
    return tuple(found)


def abort_rule(ev: Evaluator, span: Span, name: str) -> int:
    return ev.file.rule(span, name, RuleKind.ABORT)


def source_of(ev: Evaluator, node: nodes.Node) -> str:
    """The text of a node on one line."""
    return " ".join(ev.file.source.slice(node.span).split())


def demand(ev: Evaluator, node: nodes.Require, holds: ir.Expr, probability: float, owner: str) -> ir.Block:
    """`require` in a behaviour or a monitor; the coin of a soft one is tossed each time."""
    if probability < 1.0:
        spared = ev.algebra.apply(Op.LE, ev.algebra.literal(probability), ev.algebra.random())
        holds = ev.algebra.apply(Op.OR, spared, holds)
    if isinstance(holds, ir.Literal) and holds.value:
        return ()
    name = node.name or f"require in {owner}: {source_of(ev, node.condition)}"
    return (ir.Demand(node.span, holds, abort_rule(ev, node.span, name)),)
