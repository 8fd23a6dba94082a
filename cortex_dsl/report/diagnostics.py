"""The one renderer of diagnostics: for a terminal, as plain text, and as data for other programs."""

import textwrap
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.report.snippet import DrawnLine, gutter_width, snippet, visible
from cortex_dsl.source import Source

if TYPE_CHECKING:
    pass


def render_text(source: Source, diagnostics: Iterable[Diagnostic], width: int = 100) -> str:
    """The same without colour."""
    blocks = (
        "\n".join("".join(piece for piece, _ in line).rstrip() for line in draw(source, diagnostic, width)) + "\n"
        for diagnostic in diagnostics
    )
    return "\n".join(blocks)


def draw(source: Source, diagnostic: Diagnostic, width: int) -> Iterator[DrawnLine]:
    """One diagnostic as drawn lines: headline, source with marks, reason, cure."""
    offset = min(diagnostic.label.span.start, len(source.whole))
    start = source.position(offset)
    yield [
        (f"{visible(source.file(offset).name)}:{start.line}:{start.column}: ", "place"),
        (f"{diagnostic.severity.value}[{diagnostic.code}]", "severity"),
        (": " + visible(diagnostic.message), "message"),
    ]
    gutter = 1
    if source.text:
        gutter = gutter_width(source, diagnostic)
        yield from snippet(source, diagnostic, width)
    if diagnostic.reason or diagnostic.cure:
        yield [(" " * gutter + " |", "gutter")] if source.text else [("", "plain")]
    if diagnostic.reason:
        yield from _paragraph("", diagnostic.reason, gutter, width)
    if diagnostic.cure:
        yield from _paragraph("help: ", diagnostic.cure, gutter, width)


def _paragraph(head: str, text: str, gutter: int, width: int) -> Iterator[DrawnLine]:
    """A text that begins with `= `, its further lines aligned below its first."""
    room = max(width - gutter - 3 - len(head), 20)
    lines = [line for part in text.split("\n") for line in textwrap.wrap(visible(part), room, break_long_words=False)]
    for index, line in enumerate(lines):
        sign = " = " if index == 0 else "   "
        words = head if index == 0 else " " * len(head)
        yield [(" " * gutter + sign, "gutter"), (words, "help"), (line, "reason")]


def as_json(source: Source, diagnostics: Iterable[Diagnostic]) -> list[dict[str, Any]]:
    """Diagnostics as data. Lines and columns count from 1, offsets from 0; a range ends before its end."""
    return [
        {
            "code": diagnostic.code,
            "severity": diagnostic.severity.value,
            "message": diagnostic.message,
            "file": source.file(diagnostic.label.span.start).name,
            **_place(source, diagnostic.label),
            "secondary": [_other_place(source, diagnostic, label) for label in diagnostic.secondary],
            "reason": diagnostic.reason,
            "cure": diagnostic.cure,
        }
        for diagnostic in diagnostics
    ]


def _other_place(source: Source, diagnostic: Diagnostic, label: Label) -> dict[str, Any]:
    """A place that says its file where it is another one."""
    file = source.file(label.span.start)
    here = file is source.file(diagnostic.label.span.start)
    return _place(source, label) if here else {"file": file.name, **_place(source, label)}


def _place(source: Source, label: Label) -> dict[str, Any]:
    ends = {}
    for key, offset in (("start", label.span.start), ("end", label.span.end)):
        position = source.position(offset)
        local = offset - source.file(label.span.start).start
        ends[key] = {"line": position.line, "column": position.column, "offset": local}
    return {**ends, "label": label.text}
