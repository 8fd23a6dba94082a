"""Diagnostics as drawn lines and as data: headline, source lines with carets under a span, reason, cure. No terminal.

A drawn line is a list of pieces, each a text with the name of its style, so that it can be coloured or not.
"""

import textwrap
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.plain_text import visible
from cortex_dsl.source import FileText, Source, Span
from engine.frozen import frozen

if TYPE_CHECKING:
    pass


Piece = tuple[str, str]
DrawnLine = list[Piece]

TAB_STOP = 4
MARGIN = 12
"""Cells that stay visible on the left of a mark when a long line is cropped."""
FEWEST_CELLS = 24


@frozen
class Mark:
    """Part of a label on one line, in cells from the start of the line."""

    start: int
    end: int
    text: str
    primary: bool

    @property
    def style(self) -> str:
        return "primary" if self.primary else "secondary"

    @property
    def sign(self) -> str:
        return "^" if self.primary else "-"


def cells(character: str) -> int:
    """Columns that a character takes in a terminal."""
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def snippet(source: Source, diagnostic: Diagnostic, width: int) -> Iterator[DrawnLine]:
    """The lines that a diagnostic points at, with its marks, file by file; `width` in cells."""
    marked = _marks(source, diagnostic)
    gutter = gutter_width(source, diagnostic)
    yield _row(gutter)
    for file in _files(source, diagnostic):
        if file is not source.file(diagnostic.label.span.start):
            yield [(" " * gutter + " : ", "gutter"), (visible(file.name), "place")]
        numbers = sorted(row for row in marked if source.file(source.line_starts[row - 1]) is file)
        yield from _lines(source, marked, numbers, file, gutter, max(width - gutter - 3, FEWEST_CELLS))


def _files(source: Source, diagnostic: Diagnostic) -> list[FileText]:
    """The files of its labels, that of the first label first."""
    labels = (diagnostic.label, *diagnostic.secondary)
    return list(dict.fromkeys(source.file(label.span.start) for label in labels))


def _lines(
    source: Source, marked: dict[int, list[Mark]], rows: Sequence[int], file: FileText, gutter: int, room: int
) -> Iterator[DrawnLine]:
    previous = rows[0] if rows else 0
    for row in rows:
        if row > previous + 1:
            yield [("...", "gutter")]
        yield from _line(source.line(row), row - file.first_line + 1, marked[row], gutter, room)
        previous = row


def gutter_width(source: Source, diagnostic: Diagnostic) -> int:
    """Digits of the largest line number that the snippet shows."""
    starts = [source.line_starts[row - 1] for row in _marks(source, diagnostic)]
    return len(str(max(source.position(start).line for start in starts)))


def _row(gutter: int, pieces: Sequence[Piece] = (), number: str = "") -> DrawnLine:
    return [(f"{number:>{gutter}} |", "gutter"), *([(" ", "plain"), *pieces] if pieces else [])]


# -- from labels to marks -------------------------------------------------------------------------------------------


def _marks(source: Source, diagnostic: Diagnostic) -> dict[int, list[Mark]]:
    """Marks by line, counted through all files."""
    marked: dict[int, list[Mark]] = {}
    for label in (diagnostic.label, *diagnostic.secondary):
        for number, mark in _label_marks(source, label, primary=label is diagnostic.label):
            marked.setdefault(number, []).append(mark)
    return marked


def _label_marks(source: Source, label: Label, primary: bool) -> Iterator[tuple[int, Mark]]:
    """One mark, or for a span over several lines one on its first and one on its last line."""
    span = _within(label.span, source.file(label.span.start))
    final = max(span.start, span.end - 1)
    first, last = source.row(span.start), source.row(final)
    for number in sorted({first, last}):
        text = source.line(number)
        columns = _columns(text)
        begin = source.position(span.start).column - 1 if number == first else len(text) - len(text.lstrip())
        finish = source.position(final).column if number == last else len(text)
        if span.start == span.end:
            finish = begin
        start, end = columns[min(begin, len(text))], columns[min(finish, len(text))]
        yield number, Mark(start, max(end, start + 1), label.text if number == last else "", primary)


def _within(span: Span, file: FileText) -> Span:
    start = min(max(span.start, file.start), file.end)
    return Span(start, min(max(span.end, start), file.end))


def _columns(text: str) -> list[int]:
    """Cell at which each character begins, and the cell after the last."""
    if text.isascii() and text.isprintable():
        return list(range(len(text) + 1))
    columns = [0]
    for character in text:
        step = TAB_STOP - columns[-1] % TAB_STOP if character == "\t" else cells(character)
        columns.append(columns[-1] + step)
    return columns


def _expanded(text: str) -> str:
    if text.isprintable():
        return text
    columns = _columns(text)
    shown = (
        " " * (columns[i + 1] - columns[i]) if character == "\t" else visible(character)
        for i, character in enumerate(text)
    )
    return "".join(shown)


# -- drawing --------------------------------------------------------------------------------------------------------


def _line(text: str, number: int, marks: list[Mark], gutter: int, room: int) -> Iterator[DrawnLine]:
    shown, offset = _crop(_expanded(text), marks, room)
    marks = sorted((_moved(mark, offset, room) for mark in marks), key=lambda mark: (mark.start, mark.end))
    yield _row(gutter, [(shown, "source")] if shown else (), str(number))
    yield _row(gutter, _underlines(marks, room))
    hanging = [mark for mark in marks if mark.text and not _fits_beside(mark, marks, room)]
    for index in range(len(hanging) - 1, -1, -1):
        if index == len(hanging) - 1:
            yield _row(gutter, _hooks(hanging[: index + 1]))
        mark = hanging[index]
        shift = max(0, min(mark.start, room - len(mark.text)))
        before = _hooks([each for each in hanging[:index] if each.start < shift])
        yield _row(gutter, [*_padded(before, shift), (visible(mark.text), mark.style)])


def _crop(text: str, marks: list[Mark], room: int) -> tuple[str, int]:
    """The part of a long line that holds its first mark, and the cell at which the part begins."""
    if sum(cells(c) for c in text) <= room:
        return text, 0
    columns = _columns(text)
    anchor = next((mark for mark in marks if mark.primary), marks[0])
    wanted = 0 if anchor.end <= room - 2 else max(0, anchor.start - MARGIN)
    begin = next(i for i, column in enumerate(columns) if column >= wanted)
    end = max((i for i, column in enumerate(columns) if column - columns[begin] <= room - 2), default=begin)
    head, tail = "…" if begin else "", "…" if end < len(text) else ""
    return head + text[begin:end] + tail, columns[begin] - len(head)


def _moved(mark: Mark, offset: int, room: int) -> Mark:
    start = min(max(mark.start - offset, 0), room - 1)
    return Mark(start, min(max(mark.end - offset, start + 1), room), mark.text, mark.primary)


def _fits_beside(mark: Mark, marks: list[Mark], room: int) -> bool:
    """Return whether a text fits to the right of its own carets."""
    return mark is marks[-1] and mark.end + 1 + sum(map(cells, mark.text)) <= room


def _underlines(marks: list[Mark], room: int) -> list[Piece]:
    pieces: list[Piece] = []
    column = 0
    for mark in marks:
        start = max(mark.start, column)
        if mark.end > start:
            pieces += [(" " * (start - column), "plain"), (mark.sign * (mark.end - start), mark.style)]
            column = mark.end
    last = marks[-1]
    if last.text and _fits_beside(last, marks, room):
        pieces.append((" " * (last.end + 1 - column) + visible(last.text), last.style))
    return pieces


def _hooks(marks: list[Mark]) -> list[Piece]:
    pieces: list[Piece] = []
    column = 0
    for mark in marks:
        if mark.start >= column:
            pieces += [(" " * (mark.start - column), "plain"), ("|", mark.style)]
            column = mark.start + 1
    return pieces


def _padded(pieces: list[Piece], width: int) -> list[Piece]:
    used = sum(len(text) for text, _ in pieces)
    return [*pieces, (" " * (width - used), "plain")]


# -- a whole diagnostic: as drawn lines, as plain text, and as data for other programs ---------------------------------


def render_text(source: Source, diagnostics: Iterable[Diagnostic], width: int = 100) -> str:
    """Return the snippet without colour."""
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
            **_range_of(source, diagnostic.label),
            "secondary": [_other_place(source, diagnostic, label) for label in diagnostic.secondary],
            "reason": diagnostic.reason,
            "cure": diagnostic.cure,
        }
        for diagnostic in diagnostics
    ]


def _other_place(source: Source, diagnostic: Diagnostic, label: Label) -> dict[str, Any]:
    """Return a place with its file if that is another file."""
    file = source.file(label.span.start)
    here = file is source.file(diagnostic.label.span.start)
    return _range_of(source, label) if here else {"file": file.name, **_range_of(source, label)}


def _range_of(source: Source, label: Label) -> dict[str, Any]:
    ends = {}
    for key, offset in (("start", label.span.start), ("end", label.span.end)):
        position = source.position(offset)
        local = offset - source.file(label.span.start).start
        ends[key] = {"line": position.line, "column": position.column, "offset": local}
    return {**ends, "label": label.text}
