"""Tree to nodes: classes, behaviours, monitors and scenarios, and the order of their contents."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Span
from cortex_dsl.syntax import errors, nodes
from cortex_dsl.syntax.expressions import Branch, Child, ExpressionBuilder, branch, span_of, token
from engine.frozen import frozen

Statements: TypeAlias = tuple[nodes.Statement, ...]
Parts: TypeAlias = Sequence[Child]


class Builder(Protocol):
    """Interface of the builder of statements that definitions use."""

    expressions: ExpressionBuilder

    def statements(self, children: Parts) -> Statements: ...

    def report(self, diagnostic: Diagnostic) -> None: ...


@frozen
class _Body:
    """The parts of a block: its docstring, its guards by their word, its sections by theirs, and the remainder."""

    docstring: str | None
    guards: dict[str, tuple[nodes.Guard, ...]]
    sections: dict[str, Branch]
    statements: list[Branch]


def behavior(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    word, *parameters, block = parts
    body = _body(builder, block)
    return nodes.BehaviorDefinition(
        str(word),
        _parameters(builder, parameters),
        builder.statements(body.statements),
        body.docstring,
        body.guards["precondition"],
        body.guards["invariant"],
        span=span,
        name_span=span_of(token(word)),
    )


def monitor(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    return _named_block(nodes.MonitorDefinition, builder, parts, span)


def def_(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    return _named_block(nodes.FunctionDefinition, builder, parts, span)


def _named_block(
    kind: type[nodes.MonitorDefinition | nodes.FunctionDefinition], builder: Builder, parts: Parts, span: Span
) -> nodes.Statement:
    word, *parameters, block = parts
    docstring, rest = _docstring(builder, block)
    return kind(
        str(word),
        _parameters(builder, parameters),
        builder.statements(rest),
        docstring,
        span=span,
        name_span=span_of(token(word)),
    )


def scenario(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    word, *parameters, block = parts
    body = _body(builder, block, sections=("setup", "compose"))
    setup, compose = (_section(builder, body.sections.get(name)) for name in ("setup", "compose"))
    if body.sections and body.statements:
        _stray_statement(builder, body.statements[0], next(iter(body.sections.values())))
    return nodes.ScenarioDefinition(
        str(word),
        _parameters(builder, parameters),
        setup or builder.statements(body.statements),
        compose,
        body.docstring,
        body.guards["precondition"],
        body.guards["invariant"],
        span=span,
        name_span=span_of(token(word)),
    )


def class_(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    word, base, block = parts
    docstrings, lines = [], []
    for line in map(branch, branch(block).children):
        if line.data == "docstring" and not lines and not docstrings:
            docstrings.append(builder.expressions.text(token(line.children[0])))
        elif line.data == "docstring":
            builder.report(_no_property(span_of(line)))
        else:
            lines.append(line)
    return nodes.ClassDefinition(
        str(word),
        None if base is None else str(base),
        tuple(_property(builder, line) for line in lines if line.data == "property"),
        docstrings[0] if docstrings else None,
        span=span,
        name_span=span_of(token(word)),
        base_span=None if base is None else span_of(token(base)),
    )


def _no_property(span: Span) -> Diagnostic:
    return errors.CLASS_BODY.at(
        span,
        "a string is not a property",
        reason=errors.CLASS_BODY.reason,
        cure="its docstring is the first line of a class",
    )


def _property(builder: Builder, line: Branch) -> nodes.PropertyDefault:
    word, value = line.children
    return nodes.PropertyDefault(
        str(word), builder.expressions.expression(value), span=span_of(line), name_span=span_of(token(word))
    )


def _parameters(builder: Builder, children: Parts) -> tuple[nodes.Parameter, ...]:
    return tuple(_parameter(builder, branch(child)) for child in children if child is not None)


def _parameter(builder: Builder, tree: Branch) -> nodes.Parameter:
    if tree.data == "rest_parameter":
        return nodes.Parameter(str(tree.children[1]), rest=True, span=span_of(tree))
    word, default = tree.children
    return nodes.Parameter(str(word), builder.expressions.optional(default), span=span_of(tree))


# -- contents of a block ----------------------------------------------------------------------------------------------


def _docstring(builder: Builder, block: Child) -> tuple[str | None, Sequence[Child]]:
    """Return a leading string and the children after it."""
    children = branch(block).children
    if children and branch(children[0]).data == "expression_statement":
        value = branch(branch(children[0]).children[0])
        if value.data == "string":
            return builder.expressions.text(token(value.children[0])), children[1:]
    return None, children


def _body(builder: Builder, block: Child, sections: Sequence[str] = ()) -> _Body:
    docstring, rest = _docstring(builder, block)
    body = _Body(docstring, {"precondition": (), "invariant": ()}, {}, [])
    for child in map(branch, rest):
        if child.data == "guard" and not body.statements and not body.sections:
            body.guards[str(child.children[0])] += (_guard(builder, child),)
        elif child.data in sections and _in_order(builder, body, child):
            body.sections[child.data] = child
        elif child.data not in sections:
            body.statements.append(child)
    return body


def _guard(builder: Builder, tree: Branch) -> nodes.Guard:
    return nodes.Guard(builder.expressions.expression(tree.children[1]), span=span_of(tree))


def _in_order(builder: Builder, body: _Body, section: Branch) -> bool:
    """Return whether a section is the only one of its name, and no earlier one belongs below it."""
    name = section.data
    first = body.sections.get(name) or (body.sections.get("compose") if name == "setup" else None)
    if first is None:
        return True
    twice = first.data == name
    builder.report(
        errors.MISPLACED_PART.at(
            _head(section, name),
            f"a second `{name}:` in one scenario" if twice else "`setup:` goes before `compose:`",
            secondary=[Label(_head(first, first.data), "first here" if twice else "this comes second")],
            reason=errors.MISPLACED_PART.reason,
            cure="put both into one block" if twice else "move this block above it",
        )
    )
    return False


def _section(builder: Builder, tree: Branch | None) -> Statements:
    return () if tree is None else builder.statements(branch(tree.children[0]).children)


def _stray_statement(builder: Builder, statement: Branch, section: Branch) -> None:
    span = span_of(statement)
    builder.report(
        errors.MISPLACED_PART.at(
            Span(span.start, _line_end(builder, span)),
            f"this is beside `{section.data}:`",
            secondary=[Label(_head(section, section.data), "a block of the same scenario")],
            reason=errors.MISPLACED_PART.reason,
            cure="move it into `setup:`",
        )
    )


def _line_end(builder: Builder, span: Span) -> int:
    end = builder.expressions.source.text.find("\n", span.start)
    return span.end if end < 0 else min(span.end, end)


def _head(tree: Branch, word: str) -> Span:
    start = span_of(tree).start
    return Span(start, start + len(word))


# -- in the wrong place ----------------------------------------------------------------------------------------------


def stray_section(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    """`setup:` or `compose:` that no scenario holds directly."""
    word = builder.expressions.source.text[span.start : span.end].split(":")[0].strip()
    builder.statements(branch(parts[0]).children)
    builder.report(
        errors.MISPLACED_PART.at(
            Span(span.start, span.start + len(word)),
            f"`{word}:` outside a scenario",
            reason=errors.MISPLACED_PART.reason,
            cure=f"write `scenario Main():` above it and indent the `{word}:` block",
        )
    )
    return nodes.Pass(span=span)


def stray_guard(builder: Builder, parts: Parts, span: Span) -> nodes.Statement:
    """A guard anywhere else than at the top of a behaviour or scenario."""
    word = token(parts[0])
    builder.expressions.expression(parts[1])
    builder.report(
        errors.MISPLACED_PART.at(
            span_of(word),
            f"`{word}` belongs at the top of a behavior or scenario",
            "too late, or in another place",
            reason=errors.MISPLACED_PART.reason,
            cure="move it above the statements, below the docstring",
        )
    )
    return nodes.Pass(span=span)


BUILDERS: dict[str, Callable[[Builder, Parts, Span], nodes.Statement]] = {
    "class_": class_,
    "behavior": behavior,
    "monitor": monitor,
    "def_": def_,
    "scenario": scenario,
    "setup": stray_section,
    "compose": stray_section,
    "guard": stray_guard,
}
"""Builder of each rule of the grammar."""
