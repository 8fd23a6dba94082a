"""Loops, branches, assertions and functions: the statements that the compiler runs."""

from collections.abc import Callable, Mapping, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import ASSERTION
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import items_of
from cortex_dsl.semantics.evaluation.functions import known_truth
from cortex_dsl.semantics.evaluation.lists import unpack
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import Function, Value
from cortex_dsl.semantics.quantities.bounds import margin_of
from cortex_dsl.syntax import nodes
from engine.errors import Signal

Run = Callable[[Evaluator, nodes.Statement], None]
"""Function that runs one statement and reports its errors."""


class Leaving(Signal):
    """Something is left before its end."""


class Left(Leaving):
    """`break` or `continue`, on its way to the loop around it."""

    def __init__(self, ends: bool) -> None:
        super().__init__(ends)
        self.ends = ends


def leave(_ev: Evaluator, node: nodes.Statement) -> None:
    raise Left(isinstance(node, nodes.Break))


def block(ev: Evaluator, statements: Sequence[nodes.Statement], run: Run) -> None:
    for statement in statements:
        run(ev, statement)


def branch(ev: Evaluator, node: nodes.If, run: Run) -> None:
    for condition, body in node.branches:
        if known_truth(ev, ev.evaluate(condition), condition.span, "the condition of an `if`"):
            return block(ev, body, run)
    return block(ev, node.otherwise, run)


def loop_over(ev: Evaluator, node: nodes.For, run: Run) -> None:
    """Once for each item of a list; after mistakes no further round would say anything new."""
    with ev.file.budget.repeating(node.iterable.span):
        for item in items_of(ev.evaluate(node.iterable), node.iterable.span, "what `for` runs over"):
            ev.scope.update(unpack(node.targets, item, node.span))
            if _round(ev, node, run) or ev.file.findings.has_errors:
                return


def loop_while(ev: Evaluator, node: nodes.While, run: Run) -> None:
    condition = node.condition
    with ev.file.budget.repeating(condition.span):
        while known_truth(ev, ev.evaluate(condition), condition.span, "the condition of a `while`"):
            if _round(ev, node, run) or ev.file.findings.has_errors:
                return


def _round(ev: Evaluator, node: nodes.For | nodes.While, run: Run) -> bool:
    """One round of a loop; whether it was the last by `break`."""
    ev.file.budget.spend(node.span)
    try:
        block(ev, node.body, run)
    except Left as left:
        return left.ends
    return False


def check_assertion(ev: Evaluator, node: nodes.Assert) -> None:
    """Check a known condition now; turn a random condition into a requirement of the scene.

    Raises:
        Mistake: the condition is false in all cases.
    """
    condition = numbers.truth(ev, ev.evaluate(node.condition), node.condition.span)
    if isinstance(condition, ir.Literal):
        if not condition.value:
            raise ASSERTION.mistake(node.condition.span, reason=_message(ev, node))
        return
    name = node.name or ev.facts.source.words(node.condition.span)
    margin = margin_of(condition, ev.run.compared)
    ev.run.built.requirements.append(ir.Requirement(condition, 1.0, name, ev.facts.line(node.span), *margin))


def _message(ev: Evaluator, node: nodes.Assert) -> str:
    """Return the message of an assertion, with its known values."""
    try:
        message = None if node.message is None else ev.evaluate(node.message)
    except Mistake:
        return node.name
    return message if isinstance(message, str) else node.name


# -- functions of the file ---------------------------------------------------------------------------------------------


class Returned(Leaving):
    """`return`, on its way to the call."""

    def __init__(self, value: Value) -> None:
        super().__init__()
        self.value = value


def return_(ev: Evaluator, node: nodes.Return) -> None:
    raise Returned(None if node.value is None else ev.evaluate(node.value))


def function(ev: Evaluator, node: nodes.FunctionDefinition, run: Run) -> Function:
    """The value of a definition."""

    def apply(moment: Moment, arguments: Mapping[str, Value]) -> Value:
        with ev.run.depth.call(node.name_span):
            here = ev.framed(dict(arguments)).at_moment(moment)
            for parameter in node.parameters:
                if parameter.name not in here.scope and parameter.default is not None:
                    here.scope[parameter.name] = ev.evaluate(parameter.default)
            try:
                block(here, node.body, run)
            except Leaving as leaving:
                return leaving.value if isinstance(leaving, Returned) else None
            return None

    return Function(node.name, node.parameters, apply)
