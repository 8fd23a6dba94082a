"""Names that are given a value which nothing reads, and names that hide what is built in."""

from collections.abc import Iterable, Iterator

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.builtins import BUILTINS
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

MEANT = frozenset({"intersection", "road", "network"})
"""Built-in names that a file is told to choose anew: `intersection = Uniform(*network.intersections)`."""
Binding = tuple[str, str, Span]
"""What it is, its name, its place."""


def unused_names(module: nodes.Module) -> Iterator[Diagnostic]:
    """A hint for each name that is never read; objects exist without being named again."""
    read = _read(module)
    yield from _unread(_assigned(module.statements), read)
    for behaviour in module.statements:
        if isinstance(behaviour, nodes.BehaviorDefinition):
            yield from _unread((*_arguments(behaviour), *_assigned(everything_in(behaviour))), _read(behaviour))


def unused_definitions(module: nodes.Module, entry: nodes.ScenarioDefinition | None) -> Iterator[Diagnostic]:
    """Classes without objects, and scenarios that the one that runs does not start."""
    read = _read(module) | {node.class_name for node in everything_in(module) if isinstance(node, nodes.New)}
    bases = {s.base for s in module.statements if isinstance(s, nodes.ClassDefinition)}
    for statement in module.statements:
        match statement:
            case nodes.ClassDefinition(name=name) if name not in read | bases:
                yield errors.UNUSED_CLASS.at(statement.name_span, name=name)
            case nodes.ScenarioDefinition(name=name) if entry is not None and name not in read | {entry.name}:
                yield errors.UNUSED_SCENARIO.at(statement.name_span, name=name, entry=entry.name)


def _unread(bindings: Iterable[Binding], read: set[str]) -> Iterator[Diagnostic]:
    for what, name, span in bindings:
        if name not in read and name != "ego" and not name.startswith("_"):
            yield errors.UNUSED_NAME.at(span, what=what, name=name)


def _read(tree: nodes.Node) -> set[str]:
    return {node.id for node in everything_in(tree) if isinstance(node, nodes.Name)}


def _assigned(statements: Iterable[nodes.Node]) -> Iterator[Binding]:
    """Single names: of several at once, some are there for their places."""
    for statement in statements:
        if isinstance(statement, nodes.Assign) and len(statement.targets) == 1 and not _makes_objects(statement.value):
            yield "name", statement.targets[0], _name_span(statement)


def _makes_objects(value: nodes.Expression) -> bool:
    return any(isinstance(node, nodes.New) for node in (value, *everything_in(value)))


def _arguments(behaviour: nodes.BehaviorDefinition) -> Iterator[Binding]:
    for parameter in behaviour.parameters:
        yield "argument", parameter.name, parameter.span


def _name_span(statement: nodes.Assign) -> Span:
    return Span(statement.span.start, statement.span.start + len(statement.targets[0]))


def shadowing_names(module: nodes.Module) -> Iterator[Diagnostic]:
    """A hint for each name of something built in that the file gives another meaning."""
    for name, span in _top_level(module):
        if name in BUILTINS and name not in MEANT:
            yield errors.SHADOWS.at(span, name=name, kind=BUILTINS[name].kind.value)


def _top_level(module: nodes.Module) -> Iterator[tuple[str, Span]]:
    for statement in module.statements:
        match statement:
            case nodes.Assign(targets=(name,)):
                yield name, _name_span(statement)
            case nodes.BehaviorDefinition(name=name) | nodes.ClassDefinition(name=name):
                yield name, statement.name_span
            case nodes.Param(entries=entries):
                yield from ((entry.name, entry.name_span) for entry in entries if entry.name != "map")
