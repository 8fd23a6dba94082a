"""A text and the places in it. Every other stage speaks of places as `Span`s of character offsets.

A scenario with imports is one space of offsets: the main text, a line break, the first imported text, and so on. A span
therefore names its file, and places of the main file are the same with and without imports.
"""

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from functools import cached_property

from engine.frozen import frozen


@dataclass(frozen=True, order=True)
class Span:
    """Half-open range of character offsets into one source."""

    start: int
    end: int

    def to(self, other: "Span") -> "Span":
        """Return the span from the start of this one to the end of `other`."""
        return Span(self.start, max(self.end, other.end))


@frozen
class Position:
    """Line and column, both from 1, as editors count."""

    line: int
    column: int


@frozen
class FileText:
    """One file of a source: its name, where it begins in the whole (offset and line, the latter from 1), its text."""

    name: str
    start: int
    first_line: int
    text: str = field(repr=False)

    @property
    def end(self) -> int:
        return self.start + len(self.text)


@frozen
class Source:
    """A file's text under the name that messages show, and the texts that it imports."""

    name: str
    text: str = field(repr=False)
    imported: tuple[FileText, ...] = field(default=(), repr=False)

    def with_import(self, name: str, text: str) -> "Source":
        """Return the source with one more file at its end."""
        last = self.files[-1]
        added = FileText(name, last.end + 1, last.first_line + last.text.count("\n") + 1, text)
        return replace(self, imported=(*self.imported, added))

    @cached_property
    def files(self) -> tuple[FileText, ...]:
        """The main file and the imported ones."""
        return (FileText(self.name, 0, 1, self.text), *self.imported)

    @cached_property
    def whole(self) -> str:
        """All texts, each on a line of its own."""
        return "\n".join(file.text for file in self.files)

    @cached_property
    def line_starts(self) -> tuple[int, ...]:
        """Return the offsets of the line starts in the whole text."""
        return (0, *(i + 1 for i, character in enumerate(self.whole) if character == "\n"))

    def file(self, offset: int) -> FileText:
        """The file in which an offset lies."""
        starts = [file.start for file in self.files]
        return self.files[max(bisect_right(starts, offset) - 1, 0)]

    def row(self, offset: int) -> int:
        """Line of an offset, counted through all files."""
        return bisect_right(self.line_starts, offset)

    def position(self, offset: int) -> Position:
        """Line and column of a character offset in its own file (one past its end is allowed)."""
        row = self.row(offset)
        return Position(row - self.file(offset).first_line + 1, offset - self.line_starts[row - 1] + 1)

    def line(self, row: int) -> str:
        """Text of a line, without its line break; `row` counts from 1 through all files."""
        start = self.line_starts[row - 1]
        end = self.whole.find("\n", start)
        return self.whole[start : end if end >= 0 else len(self.whole)].rstrip("\r")

    def slice(self, span: Span) -> str:
        return self.whole[span.start : span.end]

    def words(self, span: Span) -> str:
        """The text of a span on one line, its words one space apart."""
        return " ".join(self.slice(span).split())
