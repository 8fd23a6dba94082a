"""Sampled scenes: counts of many scenes, endings with an external driver, or one scene from above."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from cortex_dsl.report.blocks import Title, actor_style
from cortex_dsl.report.findings.case_replay import outline_corners
from cortex_dsl.report.findings.driven_runs import ENDINGS, DrivenRuns, Ending
from cortex_dsl.report.findings.readable import ABSENT, counted, percent, ratio, speed_unit, whole
from cortex_dsl.report.findings.tally import Tally, blame_note, most_to_blame
from cortex_dsl.report.terminal.canvas import Canvas
from cortex_dsl.report.terminal.render import parts as parts_view
from cortex_dsl.report.terminal.requirements_view import blame_view, requirements_view
from cortex_dsl.report.terminal.scene_view import DRAWING_COLUMNS, MIN_WIDTH_SIDE_BY_SIDE, draw_scene
from cortex_dsl.report.terminal.theme import bar, columns, left, right, section, title_of
from cortex_dsl.report.views.measures import choices_views, params_table
from engine.program import Program
from engine.road.outline import Outline
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import State, Verdict

if TYPE_CHECKING:
    from engine.acceptance import Account


VERDICTS: Sequence[tuple[Verdict, str, str]] = (
    (Verdict.VALID, "good", "a scene was found"),
    (Verdict.EXHAUSTED, "warn", "no attempt passed"),
    (Verdict.INFEASIBLE, "warn", "shown impossible before sampling"),
    (Verdict.ABORTED, "warn", "broke a rule while it ran"),
    (Verdict.ERROR, "bad", "a bug in cortexc"),
)
BAR = 16


def sample_view(
    program: Program,
    tally: Tally,
    seconds: float,
    reproduce: str,
    account: "Account | None" = None,
    driven: RenderableType | None = None,
) -> RenderableType:
    """The whole report of `--sample N`; `seconds`: of drawing alone, 0 where that is not known."""
    rate = tally.attempts / seconds if seconds > 0 else 0.0
    attempts = Text.assemble(
        counted(tally.attempts, "attempt"),
        f", {percent(tally.acceptance)} of them accepted",
        (f"  {rate / 1e6:.1f} million a second" if rate > 1e5 else "", "quiet"),
    )
    requirements = requirements_view(program, tally, most_to_blame(program, tally, account))
    drawing = [verdicts_table(tally), Text(), attempts, *_params_kept(program, tally)]
    return Group(
        title_of(program),
        section(counted(tally.scenes, "scene"), Group(*drawing), reproduce),
        *([] if driven is None else [driven]),
        section("Requirements", requirements, "tested only if the earlier ones held"),
        *(
            []
            if account is None
            else [section("Which requirement is to blame", blame_view(account), blame_note(account))]
        ),
    )


def _params_kept(program: Program, tally: Tally) -> list[Text]:
    """Return lines on the scope of an attempt, and on draws of the params that allow no scene."""
    if not len(program.space):
        return []
    hopeless = int(tally.verdicts[Verdict.INFEASIBLE])
    lines = [Text("params are drawn once for each scene; each attempt draws all the rest again", "quiet")]
    if hopeless:
        lines.append(Text(f"{hopeless:,} of {counted(tally.scenes, 'draw')} of the params can have no scene", "warn"))
    return lines


def verdicts_table(tally: Tally) -> RenderableType:
    """Every verdict that occurred, and `valid` always."""
    every = (
        (Text(verdict.name.lower(), style), int(tally.verdicts[verdict]), what) for verdict, style, what in VERDICTS
    )
    return _shares(tally.scenes, every)


def _shares(total: int, rows: Iterable[tuple[Text, int, str]]) -> RenderableType:
    """Return a line with count, share and meaning of the first word, and of each other word that occurred."""
    shown = [
        (word, Text(whole(count)), Text(percent(ratio(count, total))), _bar(count, total, word), Text(meaning, "quiet"))
        for number, (word, count, meaning) in enumerate(rows)
        if count or not number
    ]
    return columns(left(), right(), right(), left(), left(wrap=True), rows=shown)


def _bar(count: int, total: int, word: Text) -> Text:
    return Text(bar(ratio(count, total), 1.0, BAR), word.style)


def driven_view(runs: DrivenRuns, driver: str) -> RenderableType:
    """Return the endings of scenes that an external driver drove."""
    rows = ((Text(word, style), runs[ending], meaning) for ending, (word, style, meaning) in ENDINGS.items())
    parts: list[RenderableType] = [_shares(runs.driven, rows)]
    if runs.valid:
        low, high = runs.interval
        rate = f"{percent(ratio(runs.collisions, runs.valid), 2)} of {counted(runs.valid, 'run')}"
        parts += [Text(), Text(f"collisions in {rate}; 95 % interval {percent(low, 2)} .. {percent(high, 2)}")]
        if runs[Ending.CONTROLLER]:
            parts.append(
                Text("its lower end counts scenes in which the driver failed as safe, its upper end as collisions")
            )
    return section(f"{counted(runs.driven, 'scene')} driven", Group(*parts), f"by {driver}")


# -- one scene before anything moves: place and speed of each actor, and the way that it will take ---------------------


def still_view(
    program: Program, scenes: Scenes, road: Outline, ways: Trajectory, note: str, width: int, *, ascii_only: bool
) -> RenderableType:
    """Row 0 of the scenes. `ways`: its run, of which the first sample and the ways are shown."""
    canvas = draw_scene(road, ways, None, min(DRAWING_COLUMNS, width - 6), ascii_only=ascii_only)
    for actor in reversed(range(len(program.actors))):
        _draw_actor(canvas, ways, actor)
    drawing = Text("\n").join(canvas.cropped(ascii_only=ascii_only))
    legend = columns(left(), left(), right(), left(), rows=list(_still_legend(program, canvas, ways)))
    space = program.space
    below = [Title("Params", [params_table(space, scenes.genomes[0])])] if len(space) else []
    below += choices_views(program, scenes)
    scene = section("Scene", _beside(drawing, legend, width), _found(scenes, note))
    return Group(scene, parts_view(below, width, ascii_only=ascii_only))


def _found(scenes: Scenes, note: str) -> str:
    return f"{note}, found after {counted(int(scenes.attempts[0]), 'attempt')}"


def _beside(drawing: Text, legend: RenderableType, width: int) -> RenderableType:
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
