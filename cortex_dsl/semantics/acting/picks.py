"""`do choose` and `do shuffle`: one of several behaviours, or all of them in random order.

As in Scenic, only options whose guards hold at that moment take part, each as likely as its weight over the sum of all
that do; where none is left, the run is aborted. Arguments are evaluated once, where the statement starts.
Source: Scenic 3 reference, "do choose", "do shuffle".
"""

from collections.abc import Iterator, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.acting import guards
from cortex_dsl.semantics.acting.bodies import Body, Invocation
from cortex_dsl.semantics.evaluation.arguments import items_of
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.quantities import numbers
from cortex_dsl.semantics.quantities.algebra import closed_value
from cortex_dsl.semantics.quantities.units import PURE
from cortex_dsl.semantics.values import Value, Weights
from cortex_dsl.syntax import nodes
from engine.frozen import frozen

WHAT = "a weight"


@frozen
class Candidate:
    """One option as it is written."""

    value: Value
    node: nodes.Expression
    weight: ir.Expr


def pick(body: Body, node: nodes.Do) -> ir.Block:
    """The acts of the statement, without its `until` or `for`."""
    candidates = list(_candidates(body, node.invocations))
    if len(candidates) == 1:
        body.ev.report(errors.ONE_OPTION.at(node.span, mode=node.mode))
    if all(closed_value(candidate.weight) == 0.0 for candidate in candidates):
        what = "all weights are 0" if candidates else f"`do {node.mode}` has no options"
        raise errors.NO_WEIGHT.mistake(node.span, what=what, mode=node.mode)
    invocations = _invocations(body, candidates)
    rule = guards.abort_rule(body.ev, node.span, f"do {node.mode} in {body.inliner.owner}: no option may start")
    options = tuple(
        ir.Option(candidate.weight, invocation.allowed(body.ev), invocation.acts)
        for candidate, invocation in zip(candidates, invocations, strict=True)
    )
    prologue = tuple(act for invocation in invocations for act in invocation.prologue)
    return (*prologue, ir.Pick(node.span, options, node.mode == "shuffle", rule))


def _invocations(body: Body, candidates: Sequence[Candidate]) -> list[Invocation]:
    """What each option runs; reports the mistakes of all before giving up. It may run more than once, or not at all."""
    found = []
    for candidate in candidates:
        try:
            found.append(body.option(candidate.value, candidate.node))
        except Mistake as mistake:
            body.ev.report(mistake)
    if len(found) < len(candidates):
        raise Mistake
    return found


def _candidates(body: Body, invocations: Sequence[nodes.Expression]) -> Iterator[Candidate]:
    for node in invocations:
        if isinstance(node, nodes.DictDisplay):
            for option, weight in node.entries:
                yield Candidate(body.ev.evaluate(option), option, _weight(body, body.ev.evaluate(weight), weight))
        elif isinstance(node, nodes.Starred):
            for value in items_of(body.ev.evaluate(node.value), node.span, "what `*` unpacks"):
                yield Candidate(value, node, body.ev.algebra.literal(1.0))
        else:
            yield from _named(body, body.ev.evaluate(node), node)


def _named(body: Body, value: Value, node: nodes.Expression) -> Iterator[Candidate]:
    """One behaviour, or a dictionary that has a name."""
    if not isinstance(value, Weights):
        yield Candidate(value, node, body.ev.algebra.literal(1.0))
        return
    for option, weight in value.entries:
        yield Candidate(option, node, _weight(body, weight, node))


def _weight(body: Body, value: Value, node: nodes.Expression) -> ir.Expr:
    expr = numbers.adopt(body.ev, value, PURE, node.span, WHAT)
    return numbers.in_range(body.ev, expr, 0.0, float("inf"), PURE, node.span, WHAT)
