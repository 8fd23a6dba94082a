"""The junction and the ways of its actors, drawn in the terminal."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from cortex_dsl.report.findings.case_replay import outline_corners
from cortex_dsl.report.findings.framing import heading_of_road
from cortex_dsl.report.terminal.canvas import Canvas, Point, Window
from cortex_dsl.report.terminal.theme import actor_style, columns, left
from engine.road.outline import Outline
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State

DRAWING_COLUMNS = 62
DRAWING_ROWS = 26
MARGIN = 7.0
"""World shown around the actors' ways [m]."""
LANES = 14.0
"""Lanes of one direction are no wider than this together, where the ego's road is looked for [m]."""
MIN_WIDTH_SIDE_BY_SIDE = 92
"""Console width from which the legend is next to the drawing."""
ARROWS = "→↗↑↖←↙↓↘"
SIDES = ("right", "up right", "up", "up left", "left", "down left", "down", "down right")
"""Directions in a drawing, from the right anticlockwise."""
GAPS = ((1, 0), (1, 1), (2, 2), (1, 2), (3, 1), (1, 3))
"""Dots drawn and left out along each actor's way, so that ways differ without colour too."""


@dataclass(frozen=True)
class KeyMoment:
    """The sample at which the drawing shows the actors' outlines, and its kind."""

    sample: int
    contact: bool
    point: Point
    """Position of the mark."""


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
    canvas = draw_scene(road, trajectory, moment, min(DRAWING_COLUMNS, width - 4), ascii_only=ascii_only)
    drawing = Text("\n").join(canvas.cropped(ascii_only=ascii_only))
    legend = _legend(actors, trajectory, canvas, moment, ascii_only=ascii_only)
    legend[1:1] = signal_legend(road)
    if width >= MIN_WIDTH_SIDE_BY_SIDE:
        table = Table.grid(padding=(0, 3))
        table.add_row(drawing, Group(Text(), *legend))
        return table
    return Group(drawing, *legend)


def draw_scene(
    road: Outline, trajectory: Trajectory, moment: KeyMoment | None, width: int, *, ascii_only: bool = False
) -> Canvas:
    """Road, ways, outlines at the key moment, marks; later things lie on top. The ego's road lies along it."""
    ways = [_way(trajectory, actor) for actor in range(len(trajectory.outlines))]
    shown = [point for way in ways for point in way] or [(0.0, 0.0)]
    rows = min(DRAWING_ROWS, max(10, width // 2 - 4))
    heading = heading_of_road(road, LANES, trajectory.states[:, 0])
    canvas = Canvas(width, rows, Window.around(shown, width, rows, MARGIN, heading))
    for line in (*road.middle_lines, *road.lane_lines):
        canvas.line(_points(line), "road", on=1, off=3)
    for line in (*road.stop_lines, *road.kerbs, *(np.vstack([ring, ring[:1]]) for ring in road.buildings)):
        canvas.line(_points(line), "road")
    for actor, way in reversed(list(enumerate(ways))):
        on, off = GAPS[actor % len(GAPS)]
        canvas.line(way, actor_style(actor), on=on, off=off)
    if moment is not None:
        for actor in reversed(range(len(ways))):
            _draw_outline(canvas, trajectory, actor, moment.sample)
    mark_signals(canvas, road, 0.0 if moment is None else float(trajectory.time[moment.sample]))
    for actor, way in reversed(list(enumerate(ways))):
        if way:
            canvas.mark(way[0], _initial(actor), actor_style(actor))
    if moment is not None:
        canvas.mark(moment.point, _moment_mark(moment, ascii_only=ascii_only), "bad" if moment.contact else "warn")
    return canvas


LIGHTS = {"green": ("g", "good"), "yellow": ("y", "warn"), "red": ("r", "bad"), "": ("s", "quiet")}
"""Mark and style of a stop line of a traffic light, by the colour of the light."""


def mark_signals(canvas: Canvas, road: Outline, time: float) -> None:
    """A letter in the middle of each line at which traffic waits for a light."""
    for signal in road.signals:
        x, y = signal.line.mean(axis=0).tolist()
        canvas.mark((x, y), *LIGHTS[signal.colour(time)])


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


def _initial(actor: int) -> str:
    return "E" if actor == 0 else "ABCDFGHIJK"[(actor - 1) % 10]


def _moment_mark(moment: KeyMoment, *, ascii_only: bool) -> str:
    if ascii_only:
        return "X" if moment.contact else "o"
    return "✕" if moment.contact else "◆"


def _legend(
    actors: Sequence[str], trajectory: Trajectory, canvas: Canvas, moment: KeyMoment | None, *, ascii_only: bool
) -> list[RenderableType]:
    rows = [
        (Text(_initial(i), actor_style(i)), Text(name, actor_style(i)), Text(_first_seen(trajectory, i), "quiet"))
        for i, name in enumerate(actors)
    ]
    if moment is not None:
        style = "bad" if moment.contact else "warn"
        name = "contact" if moment.contact else "closest"
        rows.append(
            (
                Text(_moment_mark(moment, ascii_only=ascii_only), style),
                Text(name, style),
                Text("outlines then", "quiet"),
            )
        )
    return [columns(left(), left(), left(), rows=rows), _scale(canvas, ascii_only=ascii_only)]


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
