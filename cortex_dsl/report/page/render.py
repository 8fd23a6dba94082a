"""The page's renderer of the report model: blocks become elements of HTML and SVG."""

from collections.abc import Iterator, Sequence

import numpy as np

from cortex_dsl.report.blocks import (
    Bars,
    Block,
    Caution,
    Code,
    Column,
    Curve,
    Drawing,
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
from cortex_dsl.report.findings.case_replay import Shape, outline_corners, way_of
from cortex_dsl.report.findings.framing import CARD, Frame, alike, heading_of_road
from cortex_dsl.report.page import scene_svg
from cortex_dsl.report.page.charts import Course, line_chart
from cortex_dsl.report.page.markup import Element, Node, element, figure, table
from cortex_dsl.report.page.run_charts import bars, grid_chart
from engine.vocabulary import ActorKind, State

CLASSES = {"bad": "hot", "warn": "warn", "quiet": "quiet", "unit": "quiet", "good": "good", "title": "strong"}
"""Class of a word by its style."""
POINTS = 40
"""Maximum number of points of a way in a picture."""


def nodes(block: Block, depth: int = 0) -> list[Node]:
    """Return the elements of a view; its title is a heading of level `depth` + 1."""
    return list(_nodes(block, depth))


def words_of(words: Words) -> list[Node]:
    """Return the nodes of a line; a number keeps its exact value for programs."""
    return [_word(part) for part in parts_of(words)]


def _word(part: Value) -> Node:
    match part:
        case Gauge(share=share, style=style):
            name = f"gauge {style.replace('.', '-')}".rstrip()
            return element("div", class_=name, style=f"--share:{100 * share:.0f}%")
        case Place(share=share, ends=ends):
            return element("div", class_="where", style=f"--at:{100 * share:.1f}%", title=" to ".join(ends))
        case Spark(values=values):
            return _spark(values)
        case Value(text, style, number, name):
            shown: Node = text
            if isinstance(number, int | float):
                shown = figure(name, number, text) if name else element("data", text, value=str(number))
            return element("span", shown, class_=CLASSES[style]) if style in CLASSES and text else shown


def _spark(values: Sequence[float]) -> Element:
    """Return a series as a line, as high as the text."""
    y = np.asarray(values, dtype=np.float64)
    points = np.column_stack([np.arange(len(y)), y])[np.isfinite(y)]
    low, high = (float(points[:, 1].min()), float(points[:, 1].max())) if len(points) else (0.0, 0.0)
    points[:, 1] = 9.0 - 8.0 * (points[:, 1] - low) / ((high - low) or 1.0)
    line = element("polyline", points=scene_svg.points_text(points, 1), class_="course first")
    box = f"0 0 {max(1, len(y) - 1)} 10"
    return element("svg", line, viewBox=box, width=80, height=16, preserveAspectRatio="none", class_="chart")


def _nodes(block: Block, depth: int) -> Iterator[Node]:
    match block:
        case Title():
            yield from _title(block, depth)
        case Note(words, style):
            yield element("p", words_of(words), class_=f"note {CLASSES.get(style, '')}".strip())
        case Caution(words):
            yield element("p", words_of(words), class_="note warn")
        case Facts(rows, tiles):
            pair = [_row((Column(), Column()), row, named=True) for row in rows]
            yield _tiles(rows) if tiles else table(None, pair, "facts")
        case Table(columns, rows, header, name):
            cells = [_row(columns, row, named=not header) for row in rows]
            heads = [column.head.replace("\n", " ") for column in columns]
            yield table(heads if header else None, cells, name or "plain")
        case Bars(rows, whole):
            yield bars([(each.text, each.count, CLASSES.get(each.style, "")) for each in rows], whole)
        case Grid():
            yield grid_chart(block)
        case Curve(lines, end):
            yield from (_curve(line.label.text, line.values, end, line.extent) for line in lines)
        case Picture(panels):
            yield element("div", _panels(panels), class_="panels")
        case Code(text):
            yield element("pre", text, class_="command")


def _title(block: Title, depth: int) -> Iterator[Node]:
    contents = [node for inner in block.blocks for node in _nodes(inner, depth + 1)]
    note = element("p", words_of(block.note), class_="note") if block.note else None
    if block.folded:
        yield element("details", element("summary", block.text), note, contents)
    elif depth == 0:
        yield element("header", element("h1", block.text), note, class_="hero")
        yield from contents
    else:
        yield element(
            "section",
            element(f"h{min(depth + 1, 6)}", block.text),
            note,
            contents,
            class_="part",
            id=block.name or None,
        )


def _tiles(rows: Sequence[tuple[Words, Words]]) -> Element:
    tiles = [
        element("div", element("b", words_of(value)), element("span", words_of(label)), class_="tile")
        for label, value in rows
    ]
    return element("div", tiles, class_="tiles")


def _row(columns: Sequence[Column], row: Sequence[Words], *, named: bool) -> Element:
    """Return a row; `named`: its first cell is its head."""
    cells = [
        element("td", words_of(cell), class_="number" if column.numbers else None)
        for column, cell in zip(columns, row, strict=True)
    ]
    first = element("th", cells[0].children, class_=cells[0].attributes["class_"], scope="row") if named else cells[0]
    return element("tr", first, *cells[1:])


def _curve(label: str, values: Sequence[float], end: float, extent: str) -> Element:
    y = np.asarray(values, dtype=np.float64)
    course = Course(label, "first", np.linspace(0.0, end, len(y)), y)
    return element(
        "figure",
        element("figcaption", element("b", label), element("span", extent)),
        line_chart([course], label, x_label="time [s]"),
        class_="panel",
    )


# -- pictures ----------------------------------------------------------------------------------------------------------


def _panels(panels: Sequence[Panel]) -> Iterator[Element]:
    """Yield one figure per panel; all drawings have one size and one scale."""
    frames = iter(alike([_frame(panel.drawing) for panel in panels if panel.drawing is not None]))
    for panel in panels:
        drawing = panel.drawing
        scene = None if drawing is None else _scene(drawing, next(frames))
        lines = [element("span", words_of(line)) for line in panel.caption]
        yield element("figure", scene, element("figcaption", lines), class_="panel")


def _frame(drawing: Drawing) -> Frame:
    """Return the frame around the pair at the key moment, or around all ways."""
    heading = heading_of_road(drawing.road, drawing.road.reach, drawing.trajectory.states[:, 0])
    sample = drawing.moment.sample if drawing.moment else 0
    corners = [corner for actor in {0, drawing.pair + 1} for corner in _corners(drawing, actor, sample)]
    return Frame.around(np.array(corners or [(0.0, 0.0)]), heading, CARD)


def _corners(drawing: Drawing, actor: int, sample: int) -> Iterator[tuple[float, float]]:
    if actor < len(drawing.trajectory.outlines):
        state, (length, width) = drawing.trajectory.states[sample, actor], drawing.trajectory.outlines[actor][:2]
        x, y, heading = (float(value) for value in state[[State.X, State.Y, State.HEADING]])
        if state[State.PRESENT] > 0.5 and np.isfinite(x + y + heading):
            yield from outline_corners(x, y, heading, float(length), float(width))


def _scene(drawing: Drawing, frame: Frame) -> Element:
    trajectory, moment = drawing.trajectory, drawing.moment
    ways = [way_of(trajectory, actor) for actor in range(len(trajectory.outlines))]
    layers: list[Node] = [
        scene_svg.road_layer(drawing.road),
        scene_svg.way_layer([way[:: max(1, -(-len(way) // POINTS))] for way in ways]),
        scene_svg.actor_layer(_shapes(drawing), trajectory.states[moment.sample if moment else 0]),
        scene_svg.contact_mark(*moment.point) if moment is not None and moment.contact else None,
    ]
    return scene_svg.scene(frame, "the key moment", *layers, compass=False)


def _shapes(drawing: Drawing) -> list[Shape]:
    outlines = drawing.trajectory.outlines[:, :2].tolist()
    kinds = [ActorKind(kind) for kind in drawing.kinds.tolist()] or [ActorKind.CAR] * len(outlines)
    return [
        Shape(name, kind, length, width)
        for name, kind, (length, width) in zip(drawing.actors, kinds, outlines, strict=False)
    ]
