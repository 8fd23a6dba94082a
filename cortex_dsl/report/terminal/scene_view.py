"""The junction and the ways of its actors, drawn in the terminal."""

import math
from collections.abc import Sequence

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from cortex_dsl.report.blocks import Drawing, KeyMoment, actor_style
from cortex_dsl.report.findings.case_replay import outline_corners
from cortex_dsl.report.findings.framing import heading_of_road
from cortex_dsl.report.terminal.canvas import Canvas, Point, Window
from cortex_dsl.report.terminal.theme import columns, left
from engine.road.outline import Outline
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State

DRAWING_COLUMNS = 62
DRAWING_ROWS = 26
MARGIN = 7.0
"""World shown around the actors' ways [m]."""
CLOSE = 9.0
"""World shown to each side of the key moment in a close drawing [m]."""
LANES = 14.0
"""Lanes of one direction are no wider than this together, where the ego's road is looked for [m]."""
MIN_WIDTH_SIDE_BY_SIDE = 92
"""Console width from which the legend is next to the drawing."""
ARROWS = "→↗↑↖←↙↓↘"
SIDES = ("right", "up right", "up", "up left", "left", "down left", "down", "down right")
"""Directions in a drawing, from the right anticlockwise."""
GAPS = ((1, 0), (1, 1), (2, 2), (1, 2), (3, 1), (1, 3))
"""Dots drawn and left out along each actor's way, so that ways differ without colour too."""


def scene_view(
    road: Outline,
    actors: Sequence[str],
    trajectory: Trajectory,
    moment: KeyMoment | None,
    width: int,
    *,
    ascii_only: bool,
) -> RenderableType:
    """Return the drawing with its legend, side by side if the console is wide enough."""
    canvas = draw_scene(road, trajectory, moment, width - 4, ascii_only=ascii_only)
    drawing = Text("\n").join(canvas.cropped(ascii_only=ascii_only))
    legend = _legend(actors, trajectory, canvas, moment, ascii_only=ascii_only)
    legend[1:1] = signal_legend(road)
    if width >= MIN_WIDTH_SIDE_BY_SIDE:
        table = Table.grid(padding=(0, 3))
        table.add_row(drawing, Group(Text(), *legend))
        return table
    return Group(drawing, *legend)


def draw_scene(
    road: Outline,
    trajectory: Trajectory,
    moment: KeyMoment | None,
    width: int,
    *,
    rows: int = DRAWING_ROWS,
    ascii_only: bool = False,
) -> Canvas:
    """Return the whole run, at most `DRAWING_COLUMNS` wide and `rows` high. The ego's road lies along it."""
    shown = [point for actor in range(len(trajectory.outlines)) for point in _way(trajectory, actor)] or [(0.0, 0.0)]
    width = min(DRAWING_COLUMNS, width)
    rows = min(rows, max(10, width // 2 - 4))
    window = Window.around(shown, width, rows, MARGIN, heading_of_road(road, LANES, trajectory.states[:, 0]))
    return _drawn(Canvas(width, rows, window), road, trajectory, moment, ascii_only=ascii_only)


def draw_close(drawing: Drawing, width: int, rows: int, *, ascii_only: bool = False) -> Canvas:
    """Return the surroundings of the key moment, `width` x `rows` characters."""
    moment, heading = drawing.moment, heading_of_road(drawing.road, LANES, drawing.trajectory.states[:, 0])
    x, y = moment.point if moment else (0.0, 0.0)
    apart = 0.0 if moment is None or moment.contact else _extent(drawing, moment)
    reach = max(CLOSE, apart)
    corners = [(x - reach, y - reach), (x + reach, y + reach), (x - reach, y + reach), (x + reach, y - reach)]
    window = Window.around(corners, width, rows, 0.0, heading)
    return _drawn(
        Canvas(width, rows, window), drawing.road, drawing.trajectory, moment, ascii_only=ascii_only, marks=False
    )


def _extent(drawing: Drawing, moment: KeyMoment) -> float:
    """Return how far the two actors of the pair are from the key point at the key moment [m]."""
    states = drawing.trajectory.states[moment.sample][[0, drawing.pair + 1]]
    away = np.hypot(states[:, State.X] - moment.point[0], states[:, State.Y] - moment.point[1])
    return float(np.nan_to_num(away).max()) + 2.0


def _drawn(
    canvas: Canvas,
    road: Outline,
    trajectory: Trajectory,
    moment: KeyMoment | None,
    *,
    ascii_only: bool,
    marks: bool = True,
) -> Canvas:
    """Return the canvas with road, ways, outlines at the key moment, and marks; later things lie on top."""
    ways = [_way(trajectory, actor) for actor in range(len(trajectory.outlines))]
    for line in (*road.middle_lines, *road.lane_lines):
        canvas.line(_points(line), "road", on=1, off=3)
    for _, ring in road.strips:
        canvas.line(_closed(ring), "quiet", on=1, off=5)
    for ring in road.stripes:
        canvas.line(_closed(ring), "road", on=1, off=1)
    for line in (*road.stop_lines, *road.kerbs, *(np.vstack([ring, ring[:1]]) for ring in road.buildings)):
        canvas.line(_points(line), "road")
    for ring in road.parked:
        canvas.line(_closed(ring), "quiet")
    for actor, way in reversed(list(enumerate(ways))):
        on, off = GAPS[actor % len(GAPS)]
        canvas.line(way, actor_style(actor), on=on, off=off)
    if moment is not None:
        for actor in reversed(range(len(ways))):
            _draw_outline(canvas, trajectory, actor, moment.sample)
    mark_signals(canvas, road, 0.0 if moment is None else float(trajectory.time[moment.sample]))
    for actor, way in reversed(list(enumerate(ways))):
        if way and marks:
            canvas.mark(way[0], actor_mark(actor), actor_style(actor))
    if moment is not None:
        canvas.mark(moment.point, moment_mark(moment, ascii_only=ascii_only), "bad" if moment.contact else "warn")
    return canvas


LIGHTS = {"green": ("g", "good"), "yellow": ("y", "warn"), "red": ("r", "bad"), "": ("s", "quiet")}
"""Mark and style of a stop line of a traffic light, by the colour of the light."""


def mark_signals(canvas: Canvas, road: Outline, time: float) -> None:
    """A letter in the middle of each line at which traffic waits for a light."""
    for signal in road.signals:
        x, y = signal.line.mean(axis=0).tolist()
        canvas.mark((x, y), *LIGHTS[signal.colour(time)])


def _closed(ring: Floats) -> list[Point]:
    return _points(np.vstack([ring, ring[:1]]))


def _points(line: Floats) -> list[Point]:
    return [(float(x), float(y)) for x, y in line]


def _draw_outline(canvas: Canvas, trajectory: Trajectory, actor: int, sample: int) -> None:
    state = trajectory.states[sample, actor]
    if state[State.PRESENT] < 0.5:
        return
    length, width = trajectory.outlines[actor]
    corners = outline_corners(state[State.X], state[State.Y], state[State.HEADING], length, width)
    canvas.fill(corners, actor_style(actor))


def _way(trajectory: Trajectory, actor: int) -> list[Point]:
    """Return the path of an actor's centre while it is present."""
    states = trajectory.states[:, actor]
    present = (states[:, State.PRESENT] > 0.5) & np.isfinite(states[:, : State.HEADING]).all(axis=1)
    return _points(states[present][:, [State.X, State.Y]])


def _first_seen(trajectory: Trajectory, actor: int) -> str:
    """Return the label of an actor's mark: its start, or the time of its entry."""
    there = np.flatnonzero(trajectory.states[:, actor, State.PRESENT] > 0.5)
    if not len(there):
        return "never comes in"
    return "start" if there[0] == 0 else f"comes in at {trajectory.time[there[0]]:.2f} s"


EGO_MARK, MARKS = "E", "ABCDFGHIJKLMNPQRSTUVWYZabcdefhijklmnpqtuvwz0123456789"
"""Mark of the ego, and marks of other actors: no letter of a light, of a contact, or of a closest approach."""


def actor_mark(actor: int) -> str:
    """Return the mark of an actor in a drawing; actors share marks only if there are more than 53 others."""
    return EGO_MARK if actor == 0 else MARKS[(actor - 1) % len(MARKS)]


def moment_mark(moment: KeyMoment, *, ascii_only: bool) -> str:
    if ascii_only:
        return "X" if moment.contact else "o"
    return "✕" if moment.contact else "◆"


def _legend(
    actors: Sequence[str], trajectory: Trajectory, canvas: Canvas, moment: KeyMoment | None, *, ascii_only: bool
) -> list[RenderableType]:
    rows = [
        (Text(actor_mark(i), actor_style(i)), Text(name, actor_style(i)), Text(_first_seen(trajectory, i), "quiet"))
        for i, name in enumerate(actors)
    ]
    if moment is not None:
        style = "bad" if moment.contact else "warn"
        name = "contact" if moment.contact else "closest"
        rows.append(
            (
                Text(moment_mark(moment, ascii_only=ascii_only), style),
                Text(name, style),
                Text("outlines then", "quiet"),
            )
        )
    return [columns(left(), left(), left(), rows=rows), _scale(canvas, ascii_only=ascii_only)]


def compact_legend(drawing: Drawing, canvas: Canvas, *, ascii_only: bool) -> Text:
    """Return the marks of a drawing, its scale and north in one paragraph."""
    parts: list[Text] = [
        Text(f"{actor_mark(i)} {name}", actor_style(i))
        for i, name in enumerate(drawing.actors)
        if i < len(drawing.trajectory.outlines)
    ]
    if drawing.moment is not None:
        mark = moment_mark(drawing.moment, ascii_only=ascii_only)
        style, name = ("bad", "contact") if drawing.moment.contact else ("warn", "closest")
        parts.append(Text(f"{mark} {name}", style))
    parts += [line for line in signal_legend(drawing.road) if isinstance(line, Text)]
    return Text("  ").join([*parts, _scale(canvas, ascii_only=ascii_only)])


def signal_legend(road: Outline) -> list[RenderableType]:
    """Return the legend of the letters on lines; empty without traffic lights."""
    if not road.signals:
        return []
    if not road.signals[0].colour(0.0):
        return [Text("s  waits for a light", "quiet")]
    letters = (Text(*LIGHTS[colour]) for colour in ("green", "yellow", "red"))
    return [Text.assemble(*(part for letter in letters for part in (letter, " ")), ("lights then", "quiet"))]


def _scale(canvas: Canvas, *, ascii_only: bool) -> Text:
    """A bar of ten metres, and where north is."""
    characters = max(1, round(10 * canvas.window.scale / 2))
    bar = "|" + "-" * max(0, characters - 2) + "|" if ascii_only else "├" + "─" * max(0, characters - 2) + "┤"
    north = math.pi / 2 - canvas.window.heading  # against the right of the drawing
    side = round(north / (math.pi / 4)) % len(ARROWS)
    return Text(f"{bar} 10 m  {'north: ' + SIDES[side] if ascii_only else ARROWS[side] + ' north'}", "quiet")
