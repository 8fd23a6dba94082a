"""Which names a statement gives a value to, and what a definition consists of."""

from collections.abc import Iterator
from typing import TypeGuard

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.composition.imports import bound_name
from cortex_dsl.semantics.running.temporal import atoms
from cortex_dsl.semantics.tree import parts
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

Definition = nodes.BehaviorDefinition | nodes.MonitorDefinition | nodes.ScenarioDefinition


def bound_by(statement: nodes.Statement) -> tuple[str, ...]:
    """Names that a top-level statement gives a value to."""
    match statement:
        case nodes.Assign(targets=targets):
            return targets
        case nodes.AugmentedAssign(target=target):
            return (target,)
        case nodes.Param(entries=entries):
            return tuple(entry.name for entry in entries if entry.name != "map")
        case nodes.BehaviorDefinition(name=name) | nodes.MonitorDefinition(name=name):
            return (name,)
        case nodes.ScenarioDefinition(name=name) | nodes.ClassDefinition(name=name):
            return (name,)
        case nodes.Import() if (alias := bound_name(statement)) is not None:
            return (alias,)
        case nodes.ImportFrom(names=names):
            return tuple(each.alias or each.name for each in names)
    return ()


def assigned(statements: tuple[nodes.Statement, ...]) -> Iterator[str]:
    """Names that a body assigns, nested blocks included."""
    for statement in statements:
        yield from () if isinstance(statement, Definition) else bound_by(statement)
        for part in parts(statement):
            if isinstance(part, nodes.Statement):
                yield from assigned((part,))
            elif isinstance(part, nodes.Handler):
                yield from assigned(part.body)


def body_of(definition: Definition) -> tuple[nodes.Statement, ...]:
    """The statements of a definition; those of a setup come before those of its `compose`."""
    if isinstance(definition, nodes.ScenarioDefinition):
        return (*definition.setup, *definition.compose)
    return definition.body


def looked_at(statement: nodes.Statement) -> Iterator[nodes.Expression]:
    """What is worked out in every sample."""
    match statement:
        case nodes.Require(condition=condition):
            yield from atoms(condition)
        case nodes.TerminateWhen(condition=condition):
            yield condition
        case nodes.Record(value=value):
            yield value


def is_class(statement: nodes.Statement) -> TypeGuard[nodes.ClassDefinition]:
    return isinstance(statement, nodes.ClassDefinition)


def duplicate(what: str, name: str, span: Span, first: Span) -> Diagnostic:
    return errors.DUPLICATE.at(span, what=what, name=name, secondary=(Label(first, "first here"),))
