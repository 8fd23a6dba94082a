"""The names that a file defines: where, how, and in which part of the text they are known."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

from cortex_dsl.semantics.names.tree import bound_name, everything_in
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes


class SymbolKind(Enum):
    """Kind of a name; the value is its word in hover texts."""

    PARAM = "param"
    VARIABLE = "variable"
    OBJECT = "object"
    BEHAVIOR = "behavior"
    MONITOR = "monitor"
    SCENARIO = "scenario"
    CLASS = "class"
    PROPERTY = "property"
    ARGUMENT = "argument"
    LOCAL = "local variable"
    IMPORT = "import"


@dataclass(frozen=True)
class Symbol:
    """A definition."""

    name: str
    kind: SymbolKind
    span: Span
    """The name itself."""
    whole: Span
    """The statement that defines it."""
    scope: Span
    """Region of the text in which the name is visible."""
    value: nodes.Expression | None = None
    form: str = ""
    """How it is defined, in one line."""
    doc: str = ""
    parameters: tuple[nodes.Parameter, ...] = ()
    origin: str = ""
    """Name of an imported name in its own file."""


Definition = nodes.BehaviorDefinition | nodes.MonitorDefinition | nodes.ScenarioDefinition
_KINDS = {
    nodes.BehaviorDefinition: SymbolKind.BEHAVIOR,
    nodes.MonitorDefinition: SymbolKind.MONITOR,
    nodes.ScenarioDefinition: SymbolKind.SCENARIO,
}


def symbols_of(module: nodes.Module, source: Source) -> tuple[Symbol, ...]:
    """All definitions of a file of the source, in the order of the text."""
    collector = _Collector(source)
    file = source.file(module.span.start)
    everywhere = Span(file.start, file.end)
    found = (*collector.block(module.statements, everywhere, top=True), *collector.inner_names(module))
    return tuple(sorted(found, key=lambda symbol: symbol.span))


@dataclass(frozen=True)
class _Collector:
    source: Source

    def block(self, statements: Sequence[nodes.Statement], scope: Span, *, top: bool) -> Iterator[Symbol]:
        for statement in statements:
            yield from self.statement(statement, scope, top=top)

    def statement(self, node: nodes.Statement, scope: Span, *, top: bool) -> Iterator[Symbol]:
        match node:
            case nodes.Param(entries=entries):
                for e in entries:
                    form = f"param {e.name} = {self.line(e.value.span)}"
                    yield Symbol(e.name, SymbolKind.PARAM, e.name_span, e.span, scope, e.value, form)
            case nodes.Assign(targets=targets, value=value):
                yield from (self.assigned(name, node, value, scope, top=top) for name in targets)
            case nodes.Import():
                yield from self.imported(node, scope)
            case nodes.ImportFrom(names=names):
                for each in names:
                    name = each.alias or each.name
                    form = f"from {node.path} import {self.line(each.span)}"
                    span = self.find(name, each.span)
                    yield Symbol(name, SymbolKind.IMPORT, span, node.span, scope, form=form, origin=each.name)
            case nodes.ClassDefinition():
                yield from self.class_(node, scope)
            case nodes.BehaviorDefinition() | nodes.MonitorDefinition() | nodes.ScenarioDefinition():
                yield from self.definition(node, scope)
            case nodes.Try(body=body, handlers=handlers):
                for block in (body, *(handler.body for handler in handlers)):
                    yield from self.block(block, scope, top=top)
            case nodes.If(branches=branches, otherwise=otherwise):
                for block in (*(body for _, body in branches), otherwise):
                    yield from self.block(block, scope, top=top)
            case nodes.While(body=body):
                yield from self.block(body, scope, top=top)

    def assigned(self, name: str, node: nodes.Assign, value: nodes.Expression, scope: Span, *, top: bool) -> Symbol:
        kind = SymbolKind.OBJECT if isinstance(value, nodes.New) else SymbolKind.VARIABLE
        single = value if len(node.targets) == 1 else None
        form = f"{name} = {self.line(value.span)}"
        span = self.find(name, node.span)
        return Symbol(name, kind if top else SymbolKind.LOCAL, span, node.span, scope, single, form)

    def imported(self, node: nodes.Import, scope: Span) -> Iterator[Symbol]:
        name = bound_name(node)
        if name is not None:
            span = self.find(name, node.span) if node.alias or not node.quoted else node.path_span
            yield Symbol(name, SymbolKind.IMPORT, span, node.span, scope, form=self.line(node.span))

    def class_(self, node: nodes.ClassDefinition, scope: Span) -> Iterator[Symbol]:
        form = f"class {node.name}({node.base or 'Car'})"
        yield Symbol(node.name, SymbolKind.CLASS, node.name_span, node.span, scope, form=form, doc=node.docstring or "")
        for each in node.properties:
            form = f"{each.name}: {self.line(each.value.span)}"
            yield Symbol(each.name, SymbolKind.PROPERTY, each.name_span, each.span, Span(0, 0), each.value, form)

    def definition(self, node: Definition, scope: Span) -> Iterator[Symbol]:
        kind, inside = _KINDS[type(node)], node.span
        shown = ", ".join(self.line(parameter.span) for parameter in node.parameters)
        form = f"{kind.value} {node.name}({shown})"
        doc, parameters = node.docstring or "", node.parameters
        yield Symbol(node.name, kind, node.name_span, inside, scope, form=form, doc=doc, parameters=parameters)
        for each in node.parameters:
            span = Span(each.span.start, each.span.start + len(each.name))
            yield Symbol(each.name, SymbolKind.ARGUMENT, span, each.span, inside, each.default, self.line(each.span))
        if isinstance(node, nodes.ScenarioDefinition):
            yield from self.block((*node.setup, *node.compose), inside, top=True)
        else:
            yield from self.block(node.body, inside, top=False)

    def inner_names(self, module: nodes.Module) -> Iterator[Symbol]:
        """Names of lambdas and comprehensions."""
        for node in everything_in(module):
            if isinstance(node, nodes.Lambda):
                for name in node.parameters:
                    span = self.find(name, node.span)
                    yield Symbol(name, SymbolKind.ARGUMENT, span, span, node.span, form=name)
            elif isinstance(node, nodes.Comprehension):
                for clause in node.clauses:
                    for name in clause.targets:
                        span = self.find(name, clause.span)
                        yield Symbol(name, SymbolKind.ARGUMENT, span, span, node.span, form=name)

    def find(self, name: str, inside: Span) -> Span:
        """The first place of a name in a stretch of text."""
        found = re.compile(rf"\b{re.escape(name)}\b").search(self.source.whole, inside.start, inside.end)
        return Span(*found.span()) if found else Span(inside.start, inside.start)

    def line(self, span: Span) -> str:
        """A stretch of text on one line."""
        return self.source.words(span)


def visible(symbols: Sequence[Symbol], offset: int) -> dict[str, Symbol]:
    """The names known at an offset: the innermost and, of several in one scope, the last above it or else the first."""
    found: dict[str, Symbol] = {}
    for symbol in symbols:
        if not symbol.scope.start <= offset <= symbol.scope.end:
            continue
        other = found.get(symbol.name)
        if other is None or _nearer(symbol, other, offset):
            found[symbol.name] = symbol
    return found


def _nearer(symbol: Symbol, other: Symbol, offset: int) -> bool:
    if symbol.scope != other.scope:
        return symbol.scope.end - symbol.scope.start < other.scope.end - other.scope.start
    return symbol.span.start <= offset
