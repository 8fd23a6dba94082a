"""One scene from above before anything moves: place and speed of each actor, and the way that it will take."""

import math
from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from cortex_dsl.report.blocks import Title, actor_style
from cortex_dsl.report.findings.case_replay import outline_corners
from cortex_dsl.report.findings.readable import ABSENT, counted, speed_unit
from cortex_dsl.report.terminal.canvas import Canvas
from cortex_dsl.report.terminal.render import parts as parts_view
from cortex_dsl.report.terminal.scene_view import DRAWING_COLUMNS, MIN_WIDTH_SIDE_BY_SIDE, draw_scene
from cortex_dsl.report.terminal.theme import columns, left, right, section
from cortex_dsl.report.views.measures import choices_views, params_table
from engine.program import Program
from engine.road.outline import Outline
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import State


def still_view(
    program: Program, scenes: Scenes, road: Outline, ways: Trajectory, note: str, width: int, *, ascii_only: bool
) -> RenderableType:
    """Return the view of row 0 of the scenes; `ways`: its run, of which the first sample and the ways are shown."""
    canvas = draw_scene(road, ways, None, min(DRAWING_COLUMNS, width - 6), ascii_only=ascii_only)
    for actor in reversed(range(len(program.actors))):
        _draw_actor(canvas, ways, actor)
    drawing = Text("\n").join(canvas.cropped(ascii_only=ascii_only))
    legend = columns(left(), left(), right(), left(), rows=list(_still_legend(program, canvas, ways)))
    space = program.space
    below = [Title("Params", [params_table(space, scenes.genomes[0])])] if len(space) else []
    below += choices_views(program, scenes)
    scene = section("Scene", _side_by_side(drawing, legend, width), _attempts_text(scenes, note))
    return Group(scene, parts_view(below, width, ascii_only=ascii_only))


def _attempts_text(scenes: Scenes, note: str) -> str:
    return f"{note}, found after {counted(int(scenes.attempts[0]), 'attempt')}"


def _side_by_side(drawing: Text, legend: RenderableType, width: int) -> RenderableType:
    if width < MIN_WIDTH_SIDE_BY_SIDE:
        return Group(drawing, legend)
    table = Table.grid(padding=(0, 3))
    table.add_row(drawing, Group(Text(), legend))
    return table


def _draw_actor(canvas: Canvas, ways: Trajectory, actor: int) -> None:
    state = ways.states[0, actor]
    if state[State.PRESENT] < 0.5 or not math.isfinite(float(state[State.X])):
        return
    length, width = ways.outlines[actor]
    canvas.fill(
        outline_corners(state[State.X], state[State.Y], state[State.HEADING], length, width), actor_style(actor)
    )


def _still_legend(program: Program, canvas: Canvas, ways: Trajectory) -> Iterator[tuple[Text, ...]]:
    unit = speed_unit(program)
    marks = {style: character for character, style in canvas.marks.values()}
    for actor, name in enumerate(program.actors):
        style, state = actor_style(actor), ways.states[0, actor]
        speed = unit.number(float(state[State.SPEED])) if state[State.PRESENT] >= 0.5 else ABSENT
        yield Text(marks.get(style, " "), style), Text(name, style), Text(speed), Text(unit.name, "unit")
