"""The terminal's renderer of the report model: blocks become lines of text, no wider than the console."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Column as TableColumn
from rich.table import Table as Columns
from rich.text import Text

from cortex_dsl.plain_text import ASCII
from cortex_dsl.report.blocks import (
    Bar,
    Bars,
    Block,
    Caution,
    Code,
    Column,
    Curve,
    Facts,
    Gauge,
    Grid,
    Note,
    Panel,
    Picture,
    Place,
    Spark,
    Table,
    Title,
    Value,
    Words,
    parts_of,
)
from cortex_dsl.report.findings.readable import percent, ratio, shortened, whole
from cortex_dsl.report.terminal.scene_view import compact_legend, draw_close, draw_scene, scene_view
from cortex_dsl.report.terminal.theme import LEVELS, MARGIN, bar, columns, heading, indented, left, right, sparkline

LEAST_PANEL, GAP = 24, 2
"""Columns of a narrow drawing, and between two drawings."""
LEAST_WRAP = 16
"""Columns that a wrapping cell of a table needs."""
BAR = 16
EXTENT = 24
"""Columns that the range of a series takes, with the gaps."""
PLACES = 21
"""Characters of a range, odd so that it has a middle."""
SPARKS = 4
"""Share of a line that a series takes at most: one part of so many."""
SHADES = " ·░▒▓█"
"""Shades of a cell: no run, no failure, then increasing counts of failures."""
PLAIN_SHADES = " .:+*#"
PLAIN_LEVELS = str.maketrans(LEVELS, "_.-:=+*#")
PLAIN_SIGNS = str.maketrans(ASCII)


def rendered(view: Block, width: int, *, ascii_only: bool = False, depth: int = 0) -> RenderableType:
    """Return the lines of a view, `width` columns wide; `ascii_only`: drawn with plain characters; `depth` 1: the view
    is a part of another, whose title is above it.
    """
    return Group(*_block(view, width, depth, ascii_only))


def parts(views: Sequence[Block], width: int, *, ascii_only: bool = False) -> RenderableType:
    """Return the lines of views or sentences below the title of another."""
    return Group(*(rendered(view, width, ascii_only=ascii_only, depth=1) for view in views))


def text_of(words: Words, style: str = "", width: int = 80, *, ascii_only: bool = False) -> Text:
    """Return the text of a line; `style` is that of its parts without one, `width` that of its block."""
    text = Text(style=style)
    for part in parts_of(words):
        text.append_text(_drawn(part, width, ascii_only))
    return text


def _drawn(part: Value, width: int, ascii_only: bool) -> Text:
    match part:
        case Gauge(share=share, length=length, rest=rest):
            drawn = _filled(share, length, ascii_only)
            return Text.assemble((drawn, part.style), (rest * (length - len(drawn)), "quiet"))
        case Place(share=share, ends=(low, high)):
            at = max(0, min(PLACES - 1, round(share * (PLACES - 1))))
            end, dash, mark, other = "|-o|" if ascii_only else "├─●┤"
            before, after = f"{low:>6} {end}" + dash * at, dash * (PLACES - 1 - at) + f"{other} {high}"
            return Text.assemble((before, "quiet"), (mark, "bar"), (after, "quiet"))
        case Spark():
            room = min(part.length, max(LEAST_WRAP, (width + MARGIN) // SPARKS))
            return Text(_series(sparkline(part.values, room, part.low, part.high), ascii_only), part.style)
        case _:
            return Text(part.text.translate(PLAIN_SIGNS) if ascii_only else part.text, part.style)


def _filled(share: float, length: int, ascii_only: bool) -> str:
    return "#" * round(share * length) if ascii_only else bar(share, 1.0, length)


def _series(drawn: str, ascii_only: bool) -> str:
    return drawn.translate(PLAIN_LEVELS) if ascii_only else drawn


def _block(block: Block, width: int, depth: int, ascii_only: bool) -> Iterator[RenderableType]:
    match block:
        case Title():
            yield from _title(block, width, depth, ascii_only)
        case Note(words, style, apart):
            yield from [Text()] if apart else []
            yield text_of(words, style, width, ascii_only=ascii_only)
        case Caution(words):
            yield text_of(words, "warn", width, ascii_only=ascii_only)
        case Facts(rows):
            cells = [[text_of(word, ascii_only=ascii_only) for word in row] for row in rows]
            yield columns(left(), left(wrap=True), rows=cells)
        case Table(split=True):
            yield from _tables(block, width, ascii_only)
        case Table():
            yield _table(block, width, ascii_only)
        case Bars(rows, total):
            yield columns(
                right(), right(), left(), left(wrap=True), rows=[_bar(each, total, ascii_only) for each in rows]
            )
        case Grid():
            yield _grid(block, width, PLAIN_SHADES if ascii_only else SHADES)
        case Curve():
            yield _curves(block, width, ascii_only)
        case Picture(panels, rows):
            yield from _pictures(panels, rows, width, ascii_only)
        case Code(text, label, apart):
            yield from [Text()] if apart else []
            yield WholeLine(Text.assemble((f"{label}: " if label else "", "quiet"), text))


def _title(block: Title, width: int, depth: int, ascii_only: bool) -> Iterator[RenderableType]:
    inner = width - MARGIN if depth else width
    contents = [part for each in block.blocks for part in _block(each, inner, depth + 1, ascii_only)]
    note = text_of(block.note, "quiet", ascii_only=ascii_only)
    head = heading(block.text) + Text("  ") + note if note.plain else heading(block.text)
    yield from [Text()] if depth else []
    yield head
    yield from (_indented(part) for part in contents) if depth else contents


@dataclass(frozen=True)
class WholeLine:
    """A line that is never broken, so that it can be copied; a frame around it would cut it off."""

    text: Text
    indent: int = 0

    def __rich__(self) -> Text:
        return Text(" " * self.indent, no_wrap=True, overflow="ignore").append_text(self.text)


def _indented(part: RenderableType) -> RenderableType:
    """Return a part of a view, indented once."""
    return replace(part, indent=part.indent + MARGIN) if isinstance(part, WholeLine) else indented(part)


def _table(block: Table, width: int, ascii_only: bool) -> Columns:
    cells = [[text_of(cell, "", width, ascii_only=ascii_only) for cell in row] for row in block.rows]
    if block.narrow is not None and sum(_widths(block.columns, cells, wrap=False)) > width:
        return _table(block.narrow, width, ascii_only)
    visible = _visible_columns(block, cells, width)
    head = [_column(block.columns[k]) for k in visible]
    return columns(*head, rows=[[row[k] for k in visible] for row in cells], header=block.header)


def _tables(block: Table, width: int, ascii_only: bool) -> Iterator[RenderableType]:
    """Yield the columns of a table in as many tables as they need; each begins with the first column."""
    cells = [[text_of(cell, "", width, ascii_only=ascii_only) for cell in row] for row in block.rows]
    widths = _widths(block.columns, cells)
    tables = [[0]]
    for k in range(1, len(widths)):
        if sum(widths[at] for at in (*tables[-1], k)) - GAP > width and len(tables[-1]) > 1:
            tables.append([0])
        tables[-1].append(k)
    for number, visible in enumerate(tables):
        yield from [Text()] if number else []
        rows = [[row[k] for k in visible] for row in cells]
        yield columns(*(_column(block.columns[k]) for k in visible), rows=rows, header=block.header)


def _column(column: Column) -> TableColumn:
    return right(column.head, column.style) if column.numbers else left(column.head, column.style, wrap=column.wrap)


def _visible_columns(block: Table, cells: Sequence[Sequence[Text]], width: int) -> list[int]:
    """Return the columns that fit, without those of the highest ranks if there are too many."""
    widths = _widths(block.columns, cells)
    visible = [k for k, column in enumerate(block.columns) if column.least <= width]
    while sum(widths[k] for k in visible) - GAP > width:
        dropped = max(visible, key=lambda k: block.columns[k].rank)
        if not block.columns[dropped].rank:
            break
        visible.remove(dropped)
    return visible


def _widths(columns: Sequence[Column], cells: Sequence[Sequence[Text]], *, wrap: bool = True) -> list[int]:
    """Return the characters that each column takes, with the gap behind it; `wrap`: where cells may wrap."""
    longest = [max((row[k].cell_len for row in cells), default=0) for k in range(len(columns))]
    return [
        GAP + max(min(most, LEAST_WRAP) if column.wrap and wrap else most, *map(len, column.head.split("\n")))
        for column, most in zip(columns, longest, strict=True)
    ]


def _bar(each: Bar, total: int, ascii_only: bool) -> tuple[Text, Text, Text, Text]:
    share = ratio(each.count, total)
    return (
        Text(whole(each.count)),
        Text(percent(share) if share >= 0.0005 or not each.count else "< 0.1 %"),
        Text(_filled(share, BAR, ascii_only), each.style or "bar"),
        Text(each.text, each.style),
    )


def _grid(grid: Grid, width: int, shades: str) -> RenderableType:
    """One row for each cell of the first descriptor that was reached, one mark for each of the second."""
    used = [i for i in range(len(grid.first)) if grid.runs[i].any()]
    most = max(int(grid.failures.max()), 1)
    label = max((len(grid.first[i]) for i in used), default=0)
    cell = max(1, min(3, (width - label - 6) // max(1, len(grid.second))))
    lines = [
        Text.assemble(
            (grid.first[i].rjust(label) + " ▏", "quiet"),
            *(_mark(grid, i, j, most, cell, shades) for j in range(len(grid.second))),
        )
        for i in used
    ]
    first, last = grid.second[0], grid.second[-1]
    room = width - label
    ends = [f"{first} … {last}"] if len(first) + len(last) + 3 <= room else [f"first {first}", f"last {last}"]
    return Group(*lines, *(Text(f"{'':{label + 2}}{shortened(end, room)}", "quiet") for end in ends))


def _mark(grid: Grid, i: int, j: int, most: int, width: int, shades: str) -> tuple[str, str]:
    """Return a cell and its style."""
    failures = int(grid.failures[i, j])
    if not failures:
        return shades[1 if grid.runs[i, j] else 0] * width, "quiet"
    shade = min(3, int(4 * math.log1p(failures) / math.log1p(most)))
    return shades[2 + shade] * width, "bad"


def _curves(block: Curve, width: int, ascii_only: bool) -> RenderableType:
    labels = max(len(line.label.text) for line in block.lines)
    room = max(10, min(48, width - labels - EXTENT))
    rows = [
        (
            text_of(line.label, ascii_only=ascii_only),
            Text(_series(sparkline(_stretched(line.values, room), room, low=0.0), ascii_only), line.label.style),
            Text(line.extent, "quiet"),
        )
        for line in block.lines
    ]
    axis = Text("0.0 s" + f"{block.end:.1f} s".rjust(max(0, room - 5)), "quiet")
    return columns(left(), left(), right(), rows=[*rows, (Text(), axis, Text())])


def _stretched(values: Sequence[float], room: int) -> list[float]:
    """Return a series by linear interpolation at `room` places."""
    return np.interp(np.linspace(0, len(values) - 1, room), np.arange(len(values)), values).tolist()


# -- pictures ----------------------------------------------------------------------------------------------------------


def _pictures(panels: Sequence[Panel], rows: int, width: int, ascii_only: bool) -> Iterator[RenderableType]:
    """Yield a single drawing with its legend, or as many drawings as stand side by side."""
    if len(panels) == 1 and panels[0].drawing is not None and not panels[0].caption:
        drawing = panels[0].drawing
        if not rows:
            whole = drawing.road, drawing.actors, drawing.trajectory, drawing.moment
            yield scene_view(*whole, width, ascii_only=ascii_only)
            return
        canvas = draw_scene(drawing.road, drawing.trajectory, drawing.moment, width, rows=rows, ascii_only=ascii_only)
        legend = compact_legend(drawing, canvas, ascii_only=ascii_only)
        used = len(legend.wrap(None, width)) if legend.plain else 0  # type: ignore[arg-type]
        if used > 1:
            canvas = draw_scene(
                drawing.road, drawing.trajectory, drawing.moment, width, rows=max(6, rows - used), ascii_only=ascii_only
            )
        yield from canvas.cropped(ascii_only=ascii_only)
        yield compact_legend(drawing, canvas, ascii_only=ascii_only)
        return
    count = max(1, min(len(panels), (width + GAP) // (LEAST_PANEL + GAP)))
    room = min((width + GAP) // count - GAP, 2 * LEAST_PANEL)
    shown = [_panel(panel, room, rows, ascii_only) for panel in panels[:count]]
    grid = Columns.grid(padding=(0, GAP, 0, 0))
    for _ in shown:
        grid.add_column(width=room, no_wrap=False, overflow="fold")
    grid.add_row(*shown)
    yield grid


def _panel(panel: Panel, width: int, rows: int, ascii_only: bool) -> RenderableType:
    lines: list[RenderableType] = []
    if panel.drawing is not None:
        lines += draw_close(panel.drawing, width, rows, ascii_only=ascii_only).lines(ascii_only=ascii_only)
    return Group(*lines, *(text_of(line, ascii_only=ascii_only) for line in panel.caption))
