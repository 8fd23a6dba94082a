"""Texts with values, `f"{n} cars"`: split into parts, and written back to text.

The grammar itself parses the text between the braces.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TypeAlias

from lark import Token, Tree

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import errors, nodes
from cortex_dsl.syntax.literals import EscapeError, string_value, write_string
from cortex_dsl.syntax.parser import read_tree
from cortex_dsl.syntax.scanning import PAIRS
from engine.errors import Signal
from engine.frozen import frozen

_TEXT = re.compile(r"(?:[^{}]|\{\{|\}\})+")
_BRACES = re.compile(r"(\{\{|\}\})")
_LAYOUT = re.compile(r"[^{}]*")
_INNER = re.compile(r"""\"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|!=|(?P<open>[(\[{])|(?P<end>[)\]}:!])""", re.DOTALL)
_SAYS_ITSELF = re.compile(r"[^=!<>]=\s*$")
_BEFORE = "_ = ("
"""Prefix that makes a statement of an expression, so that line breaks in it have no meaning."""

Branch: TypeAlias = Tree[Token]
Write: TypeAlias = Callable[[nodes.Expression], str]


# -- taken apart -------------------------------------------------------------------------------------------------------


class UnreadableError(Signal):
    """The text between the braces is unreadable; the diagnostic has the reason."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__("")
        self.diagnostics = diagnostics


def read_formatted(
    literal: Token,
    source: Source,
    expression: Callable[[Branch], nodes.Expression],
    report: Callable[[Diagnostic], None],
    span: Span,
) -> nodes.Expression:
    """The text, its values built by `expression`; empty where it cannot be read, which is reported."""
    start = literal.start_pos or 0
    parts: list[str | nodes.Placeholder] = []
    try:
        for part in _taken_apart(literal, start):
            if isinstance(part, Hole):
                value = expression(_tree_of(source, part.value))
                parts.append(nodes.Placeholder(value, part.layout, span=part.span))
            else:
                parts.append(_meant(literal[part.start - start : part.end - start], part.start, report))
    except UnreadableError as unreadable:
        for diagnostic in unreadable.diagnostics:
            report(diagnostic)
        return nodes.String("", span=span)
    return nodes.Formatted(tuple(parts), span=span)


def _meant(text: str, start: int, report: Callable[[Diagnostic], None]) -> str:
    """Return the value of a text at `start` of the file.

    Doubled braces are one brace; braces from escapes are literal.
    """
    pieces: list[str] = []
    for piece in _BRACES.split(text):
        pieces.append(piece[0] if _BRACES.fullmatch(piece) else unescaped(piece, start, report, 0))
        start += len(piece)
    return "".join(pieces)


def unescaped(literal: str, start: int, report: Callable[[Diagnostic], None], quotes: int | None = None) -> str:
    """Return the value of a literal at `start` of the file; report an invalid escape and return ""."""
    try:
        return string_value(literal, quotes)
    except EscapeError as bad:
        place = start + bad.offset
        report(
            errors.WRONG_LITERAL.at(
                Span(place, place + len(bad.text)),
                f"`{bad.text}` is not an escape sequence",
                reason="known escapes are \\n \\t \\r \\0 \\\\ \\\" \\' \\xHH \\uHHHH \\UHHHHHHHH",
                cure="write `\\\\` for a backslash",
            )
        )
        return ""


@frozen
class Hole:
    """`{value:layout}`: where the value and the whole stand in the file, and the layout."""

    value: Span
    span: Span
    layout: str


def _taken_apart(literal: str, start: int) -> Iterator[Span | Hole]:
    """Yield the texts and the holes of a literal that begins at `start` of the file.

    Raises:
        UnreadableError: a brace without its partner, or a form of Python that has no meaning here.
    """
    quotes = 3 if literal[1:4] in ('"""', "'''") else 1
    place, end = 1 + quotes, len(literal) - quotes
    while place < end:
        if (text := _TEXT.match(literal, place, end)) is not None:
            yield Span(start + place, start + text.end())
            place = text.end()
        elif literal[place] == "}":
            raise _unreadable(
                start + place, start + place + 1, "`}` closes nothing", "write `}}` for a brace in the text"
            )
        else:
            hole = _hole(literal, place, end, start)
            yield hole
            place = hole.span.end - start


def _hole(literal: str, place: int, end: int, start: int) -> Hole:
    """Return the hole that begins with the `{` at `place`."""
    stop = _value_end(literal, place + 1, end)
    sign = literal[stop : stop + 1] if stop < end else ""
    value = Span(start + place + 1, start + stop)
    if not literal[place + 1 : stop].strip() and sign:
        raise _unreadable(
            start + place, start + stop + 1, "there is nothing between these braces", "write a value there"
        )
    if _SAYS_ITSELF.search(literal, place + 1, stop):
        raise _unreadable(
            start + stop - 1, start + stop, "`=` after a value is not supported", "write its name too: `x = {x}`"
        )
    if sign == "!":
        raise _unreadable(start + stop, start + stop + 2, "`!` after a value is not supported", "leave it out")
    layout = ""
    if sign == ":":
        written = _LAYOUT.match(literal, stop + 1, end)
        layout, stop = written.group() if written else "", written.end() if written else stop
        sign = literal[stop : stop + 1] if stop < end else ""
    if sign == "{":
        raise _unreadable(
            start + stop, start + stop + 1, "a format cannot contain values", "write it as it is: `{x:.1f}`"
        )
    if sign != "}":
        raise _unreadable(
            start + place, start + place + 1, "`{` is never closed", "close it, or write `{{` for a brace"
        )
    return Hole(value, Span(start + place, start + stop + 1), layout)


def _value_end(literal: str, place: int, end: int) -> int:
    """Return the end of a value: the first sign outside its brackets and strings."""
    open_: list[str] = []
    for match in _INNER.finditer(literal, place, end):
        sign = match.group()
        if match.lastgroup == "open":
            open_.append(PAIRS[sign])
        elif open_ and open_[-1] == sign:
            open_.pop()
        elif not open_ and match.lastgroup == "end":
            return match.start()
    return end


def _unreadable(start: int, end: int, message: str, cure: str) -> UnreadableError:
    code = errors.WRONG_FORMATTED
    return UnreadableError(code.at(Span(start, end), message, reason=code.reason, cure=cure))


def _tree_of(source: Source, value: Span) -> Branch:
    """Return the tree of the expression at a place of the file, as if it had been read with the file.

    Raises:
        UnreadableError: with the errors of the grammar.
    """
    by = value.start - len(_BEFORE)
    tree, diagnostics = read_tree(Source(source.name, f"{_BEFORE}{source.text[value.start : value.end]})\n"))
    if tree is None or diagnostics:
        raise UnreadableError(*(_moved(each, by, value) for each in diagnostics))
    statement, *more = tree.children
    assert isinstance(statement, Tree)
    if more or statement.data != "assign":
        raise _unreadable(value.start, value.end, "this is not a value", "write one value between the braces")
    expression = statement.children[1]
    assert isinstance(expression, Tree)
    _move(expression, by)
    return expression


def _move(tree: Branch, by: int) -> None:
    if not tree.meta.empty:
        tree.meta.start_pos += by
        tree.meta.end_pos += by
    for child in tree.children:
        if isinstance(child, Tree):
            _move(child, by)
        elif isinstance(child, Token) and child.start_pos is not None:
            child.start_pos += by
            child.end_pos = (child.end_pos or 0) + by


def _moved(diagnostic: Diagnostic, by: int, value: Span) -> Diagnostic:
    """Move a diagnostic to its place in the file; the end of the value there is a brace."""

    def label(each: Label) -> Label:
        return Label(Span(each.span.start + by, each.span.end + by), each.text)

    at_end = diagnostic.label.span.start + by == value.end
    message = diagnostic.message.replace("found `)`", "found `}`") if at_end else diagnostic.message
    secondary = tuple(map(label, diagnostic.secondary))
    return replace(diagnostic, message=message, label=label(diagnostic.label), secondary=secondary)


# -- back to text ------------------------------------------------------------------------------------------------------


def write_formatted(node: nodes.Formatted, write: Write) -> str:
    """A literal within quotes that no value in it has."""
    values = "".join(_placeholder(part, write) for part in node.parts if isinstance(part, nodes.Placeholder))
    quotes = next((each for each in ('"', "'", "'''") if each not in values), '"""')
    parts = (_between(part, quotes) if isinstance(part, str) else _placeholder(part, write) for part in node.parts)
    return f"f{quotes}{''.join(parts)}{quotes}"


def _placeholder(node: nodes.Placeholder, write: Write) -> str:
    value = write(node.value)
    gap = " " if value.startswith("{") else ""  # two adjacent braces would be a literal brace of the text
    return f"{{{gap}{value}{f':{node.layout}' if node.layout else ''}}}"


def _between(text: str, quotes: str) -> str:
    escaped = write_string(text)[1:-1].replace("{", "{{").replace("}", "}}")
    return escaped if quotes == '"' else escaped.replace("'", "\\'")
