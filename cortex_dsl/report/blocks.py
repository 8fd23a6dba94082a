"""The report model: a view is one function from findings to a tree of blocks, and three renderers show every view.

| block     | holds                                             | terminal             | page                      |
|-----------|---------------------------------------------------|----------------------|---------------------------|
| `Title`   | a heading, a remark, and the blocks below it      | heading, indentation | section, folded on demand |
| `Note`    | a sentence                                        | text                 | paragraph                 |
| `Facts`   | labels with their values                          | two columns          | tiles, or two columns     |
| `Table`   | columns and rows                                  | columns, no lines    | table                     |
| `Bars`    | counts as shares of a whole                       | bars of characters   | bars                      |
| `Grid`    | counts in the cells of two descriptors            | shaded characters    | shaded squares            |
| `Curve`   | series over time, one a line                      | block characters     | line chart                |
| `Picture` | scenes from above, side by side, with captions    | braille or ASCII     | SVG                       |
| `Code`    | a command or a text to copy                       | text                 | preformatted text         |
| `Caution` | a sentence that a reader must not miss            | text in a warning    | paragraph in a warning    |

A word on a screen is a `str` or a `Value`. A `Value` carries its text, its style, and the number that the text shows,
in the unit of documents (SI, or the file's own for params); `name` is its field in the document. So a number on a
screen is the number of the document, and a test can compare them. `Gauge`, `Place` and `Spark` are values that are
drawn within a line.

A function in `cortex_dsl.report.views` makes the tree: a `Title` with all blocks. It knows neither rich nor HTML. The
renderers are `terminal.render.rendered` (rich), `page.render.nodes` (HTML) and `documents.blocks_content` (JSON); none
of them knows a view. What differs between the media is decided by the renderer (wrapping, scales, colours), never by a
view. A column with a `rank` may be left out where the medium is too narrow; that with the highest rank goes first.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from engine.road.outline import Outline
from engine.scenes import Trajectory
from engine.tables import Ints


@dataclass(frozen=True)
class Value:
    """A part of a line with a style, and the number that it shows."""

    text: str
    style: str = ""
    number: float | int | str | None = None
    name: str = ""
    """Field of the number in the document, such as `failures.avoidable`."""


@dataclass(frozen=True)
class Gauge(Value):
    """A share of a whole, drawn as a bar."""

    text: str = ""
    share: float = 0.0
    length: int = 8
    """Characters of a whole."""
    rest: str = ""
    """Sign for each character of the terminal that the bar leaves free."""


@dataclass(frozen=True)
class Place(Value):
    """The place of a number in its range, drawn on a line."""

    text: str = ""
    share: float = 0.0
    """0 at the lower end, 1 at the upper end."""
    ends: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class Spark(Value):
    """A series, drawn within a line; NaN where it has no value."""

    text: str = ""
    values: Sequence[float] = ()
    length: int = 40
    """Most characters."""
    low: float | None = None
    """Value of the lowest character, by default the least of the series; so is `high`."""
    high: float | None = None


ACTOR_STYLES = 6
"""Number of styles of actors: `actor.0`, that of the ego, to `actor.5`."""


def actor_style(actor: int) -> str:
    """Return the style of an actor: the ego has its own, many actors share the rest."""
    return f"actor.{actor if actor == 0 else 1 + (actor - 1) % (ACTOR_STYLES - 1)}"


Words: TypeAlias = str | Value | Sequence[str | Value]


@dataclass(frozen=True)
class Title:
    """A heading with the blocks below it."""

    text: str
    blocks: Sequence["Block"] = ()
    note: Words = ""
    folded: bool = False
    """Whether a page shows the blocks on demand only."""
    name: str = ""
    """Place of a page to which a link leads."""


@dataclass(frozen=True)
class Note:
    """A sentence."""

    words: Words
    style: str = ""
    apart: bool = False
    """Whether an empty line of the terminal separates it from the block above."""


@dataclass(frozen=True)
class Caution:
    """A sentence that a reader must not miss."""

    words: Words


@dataclass(frozen=True)
class Facts:
    """Labels with their values."""

    rows: Sequence[tuple[Words, Words]]
    tiles: bool = False
    """Whether a page shows each value large, above its label."""


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    head: str = ""
    numbers: bool = False
    """Whether its cells are aligned to the right."""
    wrap: bool = False
    style: str = ""
    rank: int = 0
    """0: always shown; else the order in which columns are left out, the highest first."""
    least: int = 0
    """Fewest characters of a line in which the column is shown."""


@dataclass(frozen=True)
class Table:
    """Columns and rows; a row has one cell per column."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Words]]
    header: bool = True
    name: str = ""
    narrow: "Table | None" = None
    """The same facts for a medium in which this table does not fit without wrapping."""
    split: bool = False
    """Whether columns that do not fit stand in a further table, behind the first column."""


@dataclass(frozen=True)
class Bar:
    """One count of a whole."""

    count: int
    text: str
    style: str = ""


@dataclass(frozen=True)
class Bars:
    """Counts as shares of a whole."""

    rows: Sequence[Bar]
    whole: int


@dataclass(frozen=True)
class Grid:
    """Failures and runs in the cells of two descriptors."""

    name: str
    first: Sequence[str]
    second: Sequence[str]
    runs: Ints
    """(first, second)"""
    failures: Ints
    """(first, second)"""


@dataclass(frozen=True)
class Line:
    """One series over time; NaN where it has no value."""

    label: Value
    values: Sequence[float]
    extent: str
    """Range of the values, with its unit."""


@dataclass(frozen=True)
class Curve:
    """Series over the same time."""

    lines: Sequence[Line]
    end: float
    """[s]"""


@dataclass(frozen=True)
class KeyMoment:
    """The sample at which a drawing shows the outlines of the actors, and its kind."""

    sample: int
    contact: bool
    point: tuple[float, float]
    """Position of the mark [m]."""


@dataclass(frozen=True)
class Drawing:
    """A run from above at its key moment."""

    road: Outline
    actors: Sequence[str]
    trajectory: Trajectory
    moment: KeyMoment | None
    pair: int
    """The ego and actor `pair` + 1."""
    kinds: Ints
    """(actors,) `ActorKind`"""


@dataclass(frozen=True)
class Panel:
    """One drawing with the lines below it."""

    drawing: Drawing | None
    caption: Sequence[Words] = ()


@dataclass(frozen=True)
class Picture:
    """Drawings: a single one with its legend, or several of the same size side by side, each near its key moment."""

    panels: Sequence[Panel]
    rows: int = 0
    """Most lines of the terminal, without captions; 0: one large drawing with its whole legend."""


@dataclass(frozen=True)
class Code:
    """A command or a text to copy."""

    text: str
    label: str = ""
    apart: bool = False
    """Whether an empty line of the terminal separates it from the block above."""


Block: TypeAlias = Title | Note | Caution | Facts | Table | Bars | Grid | Curve | Picture | Code


def parts_of(words: Words) -> Iterator[Value]:
    """Yield the parts of a line as values."""
    parts = (words,) if isinstance(words, str | Value) else words
    yield from (part if isinstance(part, Value) else Value(part) for part in parts)


def plain(words: Words) -> str:
    """Return the text of a line."""
    return "".join(part.text for part in parts_of(words))


def lines_of(blocks: Sequence[Block]) -> Iterator[Words]:
    """Yield every line of text in a tree of blocks, tables cell by cell."""
    for block in blocks:
        match block:
            case Title(text, inner, note):
                yield from (text, note)
                yield from lines_of(inner)
            case Note(words) | Caution(words):
                yield words
            case Facts(rows) | Table(rows=rows):
                yield from (cell for row in rows for cell in row)
            case Bars(rows, whole):
                for bar in rows:
                    yield Value(f"{bar.count:,}", number=bar.count), " ", bar.text
                yield Value(f"{whole:,}", number=whole)
            case Curve(lines):
                yield from ((line.label, " ", line.extent) for line in lines)
            case Picture(panels):
                yield from (line for panel in panels for line in panel.caption)
            case Grid(name):
                yield name
            case Code(text, label):
                yield from (label, text)


def values_of(blocks: Sequence[Block]) -> Iterator[Value]:
    """Yield every value with a number in a tree of blocks."""
    yield from (part for words in lines_of(blocks) for part in parts_of(words) if part.number is not None)


USUAL = 76
"""Characters of a line of text on a screen of 80 columns, less its margin and what breaking at words costs."""


def height_of(block: Block) -> int:
    """Return the lines that a block takes on a screen of 80 columns; a picture counts its captions only."""
    match block:
        case Title(text, blocks, note):
            return 1 + _lines(f"{text}  {plain(note)}") + sum(map(height_of, blocks))
        case Table(columns, rows, header):
            return len(rows) + (max(column.head.count("\n") + 1 for column in columns) if header else 0)
        case Note(words, _, apart):
            return apart + _lines(plain(words))
        case Code(text, label, apart):
            return apart + _lines(f"{label}: {text}")
        case Caution(words):
            return _lines(plain(words))
        case Picture(panels):
            return max((len(panel.caption) for panel in panels), default=0)
        case Facts(rows) | Bars(rows):
            return len(rows)
        case Curve(lines):
            return len(lines) + 1
        case Grid(_, first):
            return len(first) + 2


def _lines(text: str) -> int:
    return max(1, -(-len(text) // USUAL))
