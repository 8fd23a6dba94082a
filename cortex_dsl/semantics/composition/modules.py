"""Imported files at work: each runs once in a variant, with variables of its own, and is then shared by name.

As in Scenic, an import brings the objects and requirements of a file along with its definitions. What decides about
the run as a whole stays with the file that is run.
"""

from collections.abc import Mapping, Sequence

from cortex_dsl.semantics import errors
from cortex_dsl.semantics.composition.imports import ImportedFile, bound_name
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.definitions import BehaviourValue, MonitorValue, Namespace, ScenarioValue
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.statements import STATEMENTS, run_statement
from cortex_dsl.semantics.things import making, mutation
from cortex_dsl.semantics.values import Value
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

OF_THE_RUN: Mapping[type, tuple[str, str]] = {
    nodes.Map: ("map", "all objects share the road of the file that is run"),
    nodes.Simulation: ("simulation", "the file that is run says how it is run"),
    nodes.Signals: ("signals", "the traffic lights belong to the road of the file that is run"),
    nodes.TerminateWhen: ("terminate when", "the file that is run says when it ends"),
    nodes.TerminateAfter: ("terminate after", "the file that is run says when it ends"),
}
"""Statements that an imported file cannot have, and why."""


def run_module(ev: Evaluator, statements: Sequence[nodes.Statement]) -> None:
    """Run the statements of a file's top level; behaviours, monitors and scenarios are known from its start."""
    ev.names.update(definitions(ev, statements))
    mutation.announce(ev, statements)
    for statement in statements:
        run_statement(ev, statement)


def definitions(ev: Evaluator, statements: Sequence[nodes.Statement]) -> dict[str, Value]:
    found: dict[str, Value] = {}
    for statement in statements:
        match statement:
            case nodes.BehaviorDefinition(name=name):
                found[name] = BehaviourValue(statement, ev.home)
            case nodes.MonitorDefinition(name=name):
                found[name] = MonitorValue(statement, ev.home)
            case nodes.ScenarioDefinition(name=name):
                found[name] = ScenarioValue(statement, ev.home)
    return found


def _names_of(ev: Evaluator, span: Span) -> tuple[ImportedFile, dict[str, Value]]:
    """The file behind an import statement, and its variables."""
    file = ev.file.imports.get(span)
    if file is None:
        raise Mistake  # nobody has read it
    if file.name not in ev.run.imported:
        names = ev.run.imported[file.name] = {}
        with ev.naming(""):
            run_module(ev.at_home(names), [s for s in file.module.statements if _belongs(ev, s)])
    return file, ev.run.imported[file.name]


def _belongs(ev: Evaluator, statement: nodes.Statement) -> bool:
    """Whether a statement of an imported file can be honoured; says why not."""
    if isinstance(statement, nodes.Model):
        return False
    word, reason = OF_THE_RUN.get(type(statement), ("", ""))
    if isinstance(statement, nodes.Assign) and "ego" in statement.targets:
        word, reason = "ego = ...", "the file that is run says which object is the ego"
    if word:
        ev.report(errors.NOT_IN_IMPORT.at(statement.span, statement=word, reason=reason))
    return not word


def _import(ev: Evaluator, node: nodes.Import) -> None:
    file, names = _names_of(ev, node.span)
    name = bound_name(node)
    if name is not None:
        ev.scope[name] = Namespace(file.name, names)


def _import_from(ev: Evaluator, node: nodes.ImportFrom) -> None:
    file, names = _names_of(ev, node.span)
    for each in node.names:
        if each.name not in names:
            suggestion = did_you_mean(each.name, names)
            raise errors.NOT_IN_FILE.mistake(each.span, file=file.name, name=each.name, suggestion=suggestion)
        ev.scope[each.alias or each.name] = names[each.name]
    if not node.names:
        ev.scope.update(names)


def _class(ev: Evaluator, node: nodes.ClassDefinition) -> None:
    ev.scope[node.name] = making.define(ev, node)


STATEMENTS.update(
    {
        nodes.Import: _import,
        nodes.ImportFrom: _import_from,
        nodes.ClassDefinition: _class,
        nodes.Mutate: mutation.mutate,
    }  # type: ignore[arg-type]
)
