"""Definitions and uses of names, and the outline of a file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from cortex_dsl.editor.analysis import View
from cortex_dsl.editor.lexer import NAME
from cortex_dsl.editor.symbols import Symbol, SymbolKind, symbols_of
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax.words import RESERVED
from engine.errors import CortexError

OUTLINED = (
    SymbolKind.PARAM,
    SymbolKind.VARIABLE,
    SymbolKind.OBJECT,
    SymbolKind.BEHAVIOR,
    SymbolKind.MONITOR,
    SymbolKind.SCENARIO,
    SymbolKind.CLASS,
    SymbolKind.PROPERTY,
)
_NAME = re.compile(NAME)


@dataclass(frozen=True)
class Target:
    """A place in a file: the name of the file, its text, and a span in it."""

    file: str
    text: str
    span: Span


def definition(view: View, offset: int) -> Target | None:
    """Return the definition of the name at an offset; it may lie in another file."""
    index = view.index(offset)
    if index < 0:
        return None
    symbol = resolved(view, index)
    if symbol is None or symbol.kind is SymbolKind.IMPORT:
        return _elsewhere(view, index, symbol)
    return target_of(view.analysis.source, symbol.span)


def target_of(source: Source, span: Span) -> Target:
    """A span of a source as a place in the file that it lies in."""
    file = source.file(span.start)
    return Target(file.name, file.text, Span(span.start - file.start, span.end - file.start))


def _elsewhere(view: View, index: int, symbol: Symbol | None) -> Target | None:
    """Return the definition of a name in an imported file, or the beginning of that file for its own name."""
    token = view.tokens[index]
    if symbol is not None:
        return _of_import(view, symbol, symbol.origin)
    texts = [t.text for t in view.tokens[max(index - 2, 0) : index]]
    if texts[1:] == ["."] and (module := view.known(token.start).get(texts[0])) is not None:
        return _of_import(view, module, token.text)
    around = (s for s in view.analysis.symbols if s.kind is SymbolKind.IMPORT and _holds(s.whole, token.span))
    line = next(around, None)
    return None if line is None else _of_import(view, line, "")


def _of_import(view: View, symbol: Symbol, name: str) -> Target | None:
    """The definition of a name in the file behind an import statement; its beginning where there is none."""
    source, file = view.analysis.source, view.analysis.imports.get(symbol.whole)
    if file is None:
        return None
    found = (s.span for s in symbols_of(file.module, source) if s.name == name and s.kind in OUTLINED)
    return target_of(source, next(found, Span(file.module.span.start, file.module.span.start)))


def _holds(outer: Span, inner: Span) -> bool:
    return outer.start <= inner.start and inner.end <= outer.end


def resolved(view: View, index: int) -> Symbol | None:
    """The definition in this file that a token means."""
    token = view.tokens[index]
    if not token.is_name:
        return None
    texts = [t.text for t in view.tokens[max(index - 2, 0) : index]]
    if texts[-1:] == ["."]:
        wanted = (SymbolKind.PARAM,) if texts[:1] == ["globalParameters"] else ()
        return next((s for s in view.analysis.symbols if s.name == token.text and s.kind in wanted), None)
    if texts[-1:] == ["with"]:
        return next((s for s in view.analysis.symbols if s.name == token.text and s.kind is SymbolKind.PROPERTY), None)
    itself = [s for s in view.analysis.symbols if s.span == token.span] if view.fresh else []
    return (itself or [_named_argument(view, index) or view.known(token.start).get(token.text)])[0]


def _named_argument(view: View, index: int) -> Symbol | None:
    """The parameter that `name=` in a call gives a value to."""
    following = view.tokens[index + 1].text if index + 1 < len(view.tokens) else ""
    if following != "=":
        return None
    depth = 0
    for place in range(index - 1, 0, -1):
        text = view.tokens[place].text
        depth += (text in ")]}") - (text in "([{")
        if depth < 0:
            called = view.known(view.tokens[place - 1].start).get(view.tokens[place - 1].text)
            return None if called is None else _parameter(view, called, view.tokens[index].text)
    return None


def _parameter(view: View, called: Symbol, name: str) -> Symbol | None:
    inside = (s for s in view.analysis.symbols if s.kind is SymbolKind.ARGUMENT and s.scope == called.whole)
    return next((s for s in inside if s.name == name), None)


def references(view: View, offset: int) -> list[Span]:
    """Return every place with the same meaning as the name at an offset, including its definition."""
    index = view.index(offset)
    symbol = resolved(view, index) if index >= 0 and view.fresh else None
    return [] if symbol is None else list(_uses(view, symbol))


def _uses(view: View, symbol: Symbol) -> Iterator[Span]:
    for index, token in enumerate(view.tokens):
        if token.text == symbol.name and token.is_name:
            other = resolved(view, index)
            if other is not None and (other.name, other.scope) == (symbol.name, symbol.scope):
                yield token.span


class CannotRenameError(CortexError):
    """Why something cannot have another name."""


def rename(view: View, offset: int, name: str) -> list[Span]:
    """Return the places to be changed.

    Raises:
        CannotRenameError: the name has no definition here, or the new name is invalid.
    """
    if not _NAME.fullmatch(name) or name in RESERVED:
        raise CannotRenameError(
            f"`{name}` is not a name",
            "write letters, digits and `_`; no keyword",
        )
    index = view.index(offset)
    symbol = resolved(view, index) if index >= 0 else None
    if symbol is None or symbol.kind in (SymbolKind.PROPERTY, SymbolKind.IMPORT):
        raise CannotRenameError("this name is not defined in this file", "rename it in the file that defines it")
    if not view.fresh:
        raise CannotRenameError("the file has to be free of syntax errors first", "correct the marked ones")
    if name in view.known(symbol.span.start):
        raise CannotRenameError(f"there is a `{name}` already", "take another name")
    return references(view, offset)


@dataclass(frozen=True)
class Outline:
    """A definition and those inside it."""

    symbol: Symbol
    inside: tuple["Outline", ...] = ()


def outline(view: View) -> list[Outline]:
    """Return the definitions of the file as an outline."""
    symbols = [s for s in view.analysis.symbols if s.kind in OUTLINED]
    blocks = [s for s in symbols if s.kind in (SymbolKind.SCENARIO, SymbolKind.CLASS)]
    inside: dict[Span, list[Outline]] = {block.span: [] for block in blocks}
    top: list[Symbol] = []
    for symbol in symbols:
        around = next((b for b in blocks if b is not symbol and _holds(b.whole, symbol.whole)), None)
        if around is None:
            top.append(symbol)
        else:
            inside[around.span].append(Outline(symbol))
    return [Outline(symbol, tuple(inside.get(symbol.span, ()))) for symbol in top]
