"""Statements that speak of the running simulation: evaluated last, with everything that the file defines."""

from collections.abc import Callable, Iterable

from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.running import temporal
from cortex_dsl.semantics.running.records import record
from cortex_dsl.semantics.statements import terminate_when
from cortex_dsl.syntax import nodes

Place = tuple[Evaluator, Iterable[nodes.Statement]]
"""A running moment, and statements that belong there."""


def speaks_of_run(statement: nodes.Statement) -> bool:
    if isinstance(statement, nodes.Require):
        return temporal.is_timed(statement.condition)
    return type(statement) in _RULES


def rules_of_run(places: Iterable[Place]) -> None:
    """Evaluate those of the statements that speak of the run. Of the rules that are true in one sample the first
    decides, so those that abort the run come before those that end it, whichever file or scenario says so.
    """
    late = [(ev, statement) for ev, statements in places for statement in statements if speaks_of_run(statement)]
    for ev, statement in sorted(late, key=lambda each: not isinstance(each[1], nodes.Require)):
        try:
            _RULES[type(statement)](ev, statement)
        except Mistake as mistake:
            ev.report(mistake)


_RULES: dict[type, Callable[[Evaluator, nodes.Statement], None]] = {
    nodes.Require: temporal.require,
    nodes.TerminateWhen: terminate_when,
    nodes.Record: record,
}  # type: ignore[dict-item]
