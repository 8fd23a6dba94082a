"""One scene before anything moves: where everybody stands, how fast they are, and the way that each will take."""

import math
from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from cortex_dsl.page.case import outline_corners
from cortex_dsl.report.canvas import Canvas
from cortex_dsl.report.layout import columns, left, right, section
from cortex_dsl.report.numbers import ABSENT, counted
from cortex_dsl.report.params import params_view
from cortex_dsl.report.run_view import choices_view
from cortex_dsl.report.scene_view import BESIDE, DRAWING_COLUMNS, draw_scene
from cortex_dsl.report.speeds import speed_unit
from cortex_dsl.report.theme import actor_style
from engine.program import Program
from engine.road.outline import Outline
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import State


def still_view(
    program: Program, scenes: Scenes, road: Outline, ways: Trajectory, note: str, width: int, *, ascii_only: bool
) -> RenderableType:
    """Row 0 of the scenes. `ways`: its run, of which the first sample and the ways are shown."""
    canvas = draw_scene(road, ways, None, min(DRAWING_COLUMNS, width - 6), ascii_only=ascii_only)
    for actor in reversed(range(len(program.actors))):
        _draw_actor(canvas, ways, actor)
    drawing = Text("\n").join(canvas.cropped(ascii_only=ascii_only))
    legend = columns(left(), left(), right(), left(), rows=list(_legend(program, canvas, ways)))
    parts: list[RenderableType] = [section("Scene", _beside(drawing, legend, width), _found(scenes, note))]
    if len(program.space):
        parts.append(section("Params", params_view(program.space, scenes.genomes[0])))
    if (choices := choices_view(program, int(scenes.variant[0]))) is not None:
        parts.append(section("Choices", choices))
    return Group(*parts)


def _found(scenes: Scenes, note: str) -> str:
    return f"{note}, found after {counted(int(scenes.attempts[0]), 'attempt')}"


def _beside(drawing: Text, legend: RenderableType, width: int) -> RenderableType:
    if width < BESIDE:
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


def _legend(program: Program, canvas: Canvas, ways: Trajectory) -> Iterator[tuple[Text, ...]]:
    unit = speed_unit(program)
    marks = {style: character for character, style in canvas.marks.values()}
    for actor, name in enumerate(program.actors):
        style, state = actor_style(actor), ways.states[0, actor]
        speed = unit.number(float(state[State.SPEED])) if state[State.PRESENT] >= 0.5 else ABSENT
        yield Text(marks.get(style, " "), style), Text(name, style), Text(speed), Text(unit.name, "unit")
