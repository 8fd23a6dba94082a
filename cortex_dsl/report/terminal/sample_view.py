"""Scenes that are drawn and not run: many of them as counts, one from above, and the accepted values of a param."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from cortex_dsl.report.findings.case_replay import outline_corners
from cortex_dsl.report.findings.readable import ABSENT, counted, format_gene, percent, ratio, speed_unit, whole
from cortex_dsl.report.findings.tally import Tally, blame_note, most_to_blame
from cortex_dsl.report.terminal.canvas import Canvas
from cortex_dsl.report.terminal.requirements_view import blame_view, requirements_view
from cortex_dsl.report.terminal.run_view import choices_view, params_view
from cortex_dsl.report.terminal.scene_view import BESIDE, DRAWING_COLUMNS, draw_scene
from cortex_dsl.report.terminal.theme import EIGHTHS, LEVELS, actor_style, bar, columns, left, right, section, title_of
from engine.program import Program
from engine.road.outline import Outline
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import GeneKind, State, Verdict

if TYPE_CHECKING:
    from engine.acceptance import Account, Weighing
    from engine.tables import Floats


VERDICTS: Sequence[tuple[Verdict, str, str]] = (
    (Verdict.VALID, "good", "a scene was found"),
    (Verdict.EXHAUSTED, "warn", "no attempt passed"),
    (Verdict.INFEASIBLE, "warn", "shown impossible before sampling"),
    (Verdict.ABORTED, "warn", "broke a rule while it ran"),
    (Verdict.ERROR, "bad", "a bug in cortexc"),
)
BAR = 16


def sample_view(
    program: Program, tally: Tally, seconds: float, reproduce: str, account: "Account | None" = None
) -> RenderableType:
    """The whole report of `--sample N`."""
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
        section("Requirements", requirements, "tested only where the earlier ones held"),
        *([] if account is None else [section("Who is to blame", blame_view(account), blame_note(account))]),
    )


def _params_kept(program: Program, tally: Tally) -> list[Text]:
    """Return what an attempt draws again, and how many draws of the params are hopeless."""
    if not len(program.space):
        return []
    hopeless = int(tally.verdicts[Verdict.INFEASIBLE])
    lines = [Text("a scene keeps its params: each of its attempts draws all the rest again", "quiet")]
    if hopeless:
        lines.append(Text(f"{hopeless:,} of {counted(tally.scenes, 'draw')} of the params can have no scene", "warn"))
    return lines


def verdicts_table(tally: Tally) -> RenderableType:
    """Every verdict that occurred, and `valid` always."""
    rows = []
    for verdict, style, meaning in VERDICTS:
        count = int(tally.verdicts[verdict])
        if count or verdict == Verdict.VALID:
            share = ratio(count, tally.scenes)
            rows.append(
                (
                    Text(verdict.name.lower(), style),
                    Text(whole(count)),
                    Text(percent(share)),
                    Text(bar(share, 1.0, BAR), style),
                    Text(meaning, "quiet"),
                )
            )
    return columns(left(), right(), right(), left(), left(wrap=True), rows=rows)


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


def _still_legend(program: Program, canvas: Canvas, ways: Trajectory) -> Iterator[tuple[Text, ...]]:
    unit = speed_unit(program)
    marks = {style: character for character, style in canvas.marks.values()}
    for actor, name in enumerate(program.actors):
        style, state = actor_style(actor), ways.states[0, actor]
        speed = unit.number(float(state[State.SPEED])) if state[State.PRESENT] >= 0.5 else ABSENT
        yield Text(marks.get(style, " "), style), Text(name, style), Text(speed), Text(unit.name, "unit")


# -- the accepted values of one param, drawn over those that were drawn ------------------------------------------------

ROWS = 8
WIDEST = 60
FEWEST_COLUMNS = 10
DRAWS_IN_A_COLUMN = 100
"""Accepted draws that a column should hold, so that what is seen is not chance."""
OPTIONS_BAR = 30


def distribution_view(weighing: "Weighing", gene: int, width: int, *, ascii_only: bool = False) -> RenderableType:
    """A histogram of what is accepted; dots where it would reach if all draws were."""
    space = weighing.program.space
    drawn, accepted = weighing.genomes[:, gene], weighing.genomes[weighing.accepted][:, gene]
    note = f"{len(accepted):,} accepted of {counted(len(drawn), 'draw')}"
    title = f"{space.names[gene]} [{space.units[gene]}]" if space.units[gene] else space.names[gene]
    if not len(accepted):
        return section(title, Text("no draw is accepted; `:relax` shows why", "warn"), note)
    if space.kinds[gene] == GeneKind.INDEX:
        return section(title, _options(weighing, gene, drawn, accepted, ascii_only), note)
    return section(title, _chart(weighing, gene, (drawn, accepted), width, ascii_only), note)


def _options(weighing: "Weighing", gene: int, drawn: "Floats", accepted: "Floats", ascii_only: bool) -> RenderableType:
    names = weighing.program.space.options[gene]
    shares = [np.bincount(values.astype(int), minlength=len(names)) / len(values) for values in (drawn, accepted)]
    rows = []
    for name, before, after in zip(names, *shares, strict=True):
        filled = "#" * round(after * OPTIONS_BAR) if ascii_only else bar(float(after), 1.0, OPTIONS_BAR)
        rows.append((Text(name), Text(percent(before), "quiet"), Text(percent(after)), Text(filled, "bar")))
    return columns(left(), right("drawn"), right("accepted"), left(), rows=rows, header=True)


def _chart(
    weighing: "Weighing", gene: int, values: "tuple[Floats, Floats]", width: int, ascii_only: bool
) -> RenderableType:
    space, (_, accepted) = weighing.program.space, values
    low, high = float(space.low[gene]), float(space.high[gene])
    room = min(WIDEST, width - 8)
    bins = max(FEWEST_COLUMNS, min(room, len(accepted) // DRAWS_IN_A_COLUMN))
    edges = _edges(low, high, bins, whole=space.kinds[gene] == GeneKind.INTEGER)
    before, after = (np.histogram(each, bins=edges)[0] / len(each) for each in values)
    heights = np.stack((after, before)) / max(float(before.max()), float(after.max())) * ROWS
    heights = np.repeat(heights, max(1, room // len(before)), axis=1)
    lines = [_line(heights[0], heights[1], row, ascii_only) for row in reversed(range(ROWS))]
    ends = [format_gene(space, gene, end) for end in (low, high)]
    axis = Text(("-" if ascii_only else "─") * len(heights[0]), "quiet")
    scale = Text(f"{ends[0]}{ends[1]:>{max(1, len(heights[0]) - len(ends[0]))}}", "quiet")
    return Group(*lines, axis, scale, _middle(weighing, gene, accepted, ascii_only))


def _middle(weighing: "Weighing", gene: int, accepted: "Floats", ascii_only: bool) -> Text:
    """Median and the bulk of the accepted values, and what the dots are."""
    space = weighing.program.space
    values = [format_gene(space, gene, float(np.quantile(accepted, q))) for q in (0.05, 0.5, 0.95)]
    return Text.assemble(
        ("accepted: ", "quiet"),
        f"median {values[1]}, nine tenths in {values[0]} .. {values[2]}",
        ("   . " if ascii_only else "   · ", "warn"),
        ("as drawn", "quiet"),
    )


def _edges(low: float, high: float, most: int, *, whole: bool) -> "Floats":
    """Ends of the columns; of whole numbers each column holds equally many."""
    if not whole:
        return np.linspace(low, high, most + 1)
    step = int((high - low) // most) + 1
    return np.arange(low - 0.5, high + 0.5 + step, step)


def _line(after: "Floats", before: "Floats", row: int, ascii_only: bool) -> Text:
    """One row of characters; the columns are filled up to their heights."""
    line = Text()
    for height, prior in zip(after.tolist(), before.tolist(), strict=True):
        part = height - row
        if part >= 1 - 1 / 16:
            line.append("#" if ascii_only else EIGHTHS[8], "bar")
        elif row <= prior < row + 1 and part < 0.5:
            line.append("." if ascii_only else "·", "warn")
        elif part > 1 / 16:
            line.append(":" if ascii_only else LEVELS[min(7, int(part * 8))], "bar")
        else:
            line.append(" ")
    return line
