"""What a search's failures are, for people: how many different ones, where they lie, of what kinds, and whose fault."""

import math
from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, heading, indented, left, right, section
from cortex_dsl.report.numbers import ABSENT, counted, fixed, percent, ratio, whole
from cortex_dsl.report.params import format_gene
from cortex_dsl.report.sparkline import bar
from engine.avoidability import Avoidability, Avoidance
from engine.program import ParamSpace, Program
from engine.search.analysis import Analysis, Avoided
from engine.search.clusters import Cluster, Condition
from engine.search.diversity import Grid
from engine.search.sensitivity import CHANCE, GeneIndex, Sensitivity
from engine.search.statistics import Interval
from engine.vocabulary import GeneKind

BAR = 10
SHADES = " ·░▒▓█"
"""Of a cell: nothing ran there, no collision, then ever more collisions."""
MARKS = "blank: nothing ran there; ·: no collision; ░ ▒ ▓ █: ever more of them"
AVOIDANCES = {
    Avoidance.AVOIDABLE: ("avoidable", "good", "the reference driver would have stopped or passed in time"),
    Avoidance.UNAVOIDABLE: ("unavoidable", "bad", "the reference driver would have braked too late"),
    Avoidance.BRAKED_AS_HARD: ("braked as hard", "warn", "too late, and the ego had braked as hard itself, or stood"),
    Avoidance.UNSEEN: ("unseen", "warn", "in sight for too short a time before contact"),
}
DRIVER = (
    "UN R157: 0.4 s to perceive, 0.75 s to react, 0.774 g after 0.6 s more; it brakes along the ego's own path and "
    "never steers. The regulation means cut-ins on motorways; that a conflict is in sight 4 s ahead is cortexc's choice"
)
INDICES = """\
first: share of the variance of risk that the param explains alone
total: with everything it does together with others; brackets: 95 % bootstrap
(Saltelli et al. 2010); chance: lanes, places and what else a scene draws"""


def analysis_view(program: Program, analysis: Analysis, width: int) -> RenderableType:
    """The whole page of `cortexc analyse`."""
    space = program.space
    parts: list[RenderableType] = [heading(program.name), *_summary(analysis)]
    if analysis.failures:
        parts.append(section("Kinds of failures", _kinds(space, analysis), "what tells them from all else simulated"))
    covered = [grid for grid in analysis.grids if grid.covered]
    parts += [section(grid.name, _grid(grid, width), _grid_note(grid)) for grid in covered]
    parts += [Text(), indented(Text(MARKS, "quiet"))] if covered else []
    if analysis.sensitivity is not None:
        note = f"{analysis.sensitivity.simulations:,} simulations of their own, drawn as the file says"
        parts.append(section("Which params matter", _sensitivity(analysis.sensitivity), note))
    if analysis.avoided.driven:
        parts.append(section("Would a competent driver have avoided it?", _avoidance(analysis)))
    return Group(*parts)


def _summary(analysis: Analysis) -> list[RenderableType]:
    """The first lines, in plain words."""
    if not analysis.valid:
        return [Text(f"not one of {counted(analysis.simulations, 'simulation')} was valid: nothing is known", "bad")]
    if not analysis.failures:
        tried = f" in {analysis.valid:,} valid of {counted(analysis.simulations, 'simulation')}"
        return [Text.assemble(("no collision", "good"), tried, ("; what was not found may still exist", "quiet"))]
    distinct = len(analysis.distinct)
    lines: list[RenderableType] = [
        Text.assemble(
            (counted(analysis.failures, "collision"), "bad"), f" in {counted(analysis.simulations, 'simulation')}"
        ),
        Text.assemble(
            f"{distinct:,} of them ",
            ("different", "title"),
            (" in a third of their params, by a tenth of the range", "quiet"),
        ),
    ]
    if math.isfinite(analysis.spread.pairwise):
        lines.append(
            Text(
                f"two collisions differ by {percent(analysis.spread.pairwise, 0)} of a range on average, "
                f"the nearest by {percent(analysis.spread.nearest, 0)}",
                "quiet",
            )
        )
    if analysis.system:
        names = ", ".join(analysis.system)
        lines.append(
            Text.assemble(("of the system under test, chosen by the search: ", "warn"), names, " (--freeze holds them)")
        )
    return lines


# -- kinds ------------------------------------------------------------------------------------------------------------


def _kinds(space: ParamSpace, analysis: Analysis) -> RenderableType:
    rows = [
        (
            Text(whole(len(cluster.rows))),
            Text(condition_text(space, cluster)),
            Text(percent(cluster.precision, 0)),
            Text(percent(cluster.coverage, 0)),
            Text(held_out_text(cluster), "quiet"),
        )
        for cluster in analysis.clusters
    ]
    head = right("failures"), left("where", wrap=True), right("fail there"), right("of the kind"), right("held out")
    return Group(columns(*head, rows=rows, header=True), Text(), *(Text(line, "quiet") for line in FITTED))


FITTED = (
    "fail there: collisions among what the search simulated under the condition, no probability",
    "conditions are fitted to these very runs; held out: both shares when found from every other run, judged on others",
)


def held_out_text(cluster: Cluster) -> str:
    """`71 %, 64 %`: precision and coverage on runs that the rule was not grown from."""
    return f"{percent(cluster.held_out.precision, 0)}, {percent(cluster.held_out.coverage, 0)}"


def condition_text(space: ParamSpace, cluster: Cluster) -> str:
    """`ADV_SPEED > 41.0 km/h and EGO_BRAKE < 0.300`."""
    return " and ".join(_condition(space, each) for each in cluster.conditions) or "no condition sets it apart"


def _condition(space: ParamSpace, condition: Condition) -> str:
    gene = condition.gene
    name, unit = space.names[gene], f" {space.units[gene]}" if space.units[gene] else ""
    if space.kinds[gene] == GeneKind.INDEX:
        return f"{name} is {format_gene(space, gene, condition.low)}"
    low, high = (format_gene(space, gene, end) if math.isfinite(end) else "" for end in (condition.low, condition.high))
    if low and high:
        return f"{name} {low} .. {high}{unit}"
    return f"{name} ≥ {low}{unit}" if low else f"{name} ≤ {high}{unit}"


# -- grids ------------------------------------------------------------------------------------------------------------


def _grid_note(grid: Grid) -> str:
    return f"{grid.failing} of {grid.cells} cells with collisions, QD score {fixed(grid.qd_score, 0)}"


def _grid(grid: Grid, width: int) -> RenderableType:
    """One row for each cell of the first descriptor that was reached, one mark for each of the second."""
    used = [i for i in range(len(grid.first)) if grid.runs[i].any()]
    most = max(int(grid.failures.max()), 1)
    label = max((len(grid.first[i]) for i in used), default=0)
    cell = max(1, min(3, (width - label - 8) // max(1, len(grid.second))))
    lines = [
        Text.assemble(
            (grid.first[i].rjust(label) + " ▏", "quiet"),
            *(_mark(grid, i, j, most, cell) for j in range(len(grid.second))),
        )
        for i in used
    ]
    ends = f"{' ' * (label + 2)}{grid.second[0]} … {grid.second[-1]}"
    return Group(*lines, Text(ends[:width], "quiet"))


def _mark(grid: Grid, i: int, j: int, most: int, width: int) -> tuple[str, str]:
    """A cell and its style."""
    failures = int(grid.failures[i, j])
    if not failures:
        return SHADES[1 if grid.runs[i, j] else 0] * width, "quiet"
    shade = min(3, int(4 * math.log1p(failures) / math.log1p(most)))
    return SHADES[2 + shade] * width, "bad"


# -- params -----------------------------------------------------------------------------------------------------------


def _sensitivity(found: Sensitivity) -> RenderableType:
    most = max((index.total for index in found.risk if math.isfinite(index.total)), default=0.0)
    rows = [_index_row(risk, collision, most) for risk, collision in zip(found.risk, found.collision, strict=True)]
    head = (
        left("param"),
        right("first"),
        right("total"),
        left(),
        left(),
        right("of collision"),
    )
    return Group(columns(*head, rows=rows, header=True), Text(), Text(INDICES, "quiet"))


def _index_row(risk: GeneIndex, collision: GeneIndex, most: float) -> Sequence[Text]:
    style = "quiet" if risk.name == CHANCE else ""
    return (
        Text(risk.name, style),
        Text(fixed(risk.first, 2)),
        Text(fixed(risk.total, 2)),
        Text(_interval(risk.total_interval), "quiet"),
        Text(bar(risk.total, most, BAR) if math.isfinite(risk.total) and most > 0.0 else "", "bar"),
        Text(fixed(collision.total, 2)),
    )


def _interval(interval: Interval) -> str:
    return f"[{fixed(interval.low, 2)}, {fixed(interval.high, 2)}]" if math.isfinite(interval.low) else ABSENT


# -- the reference driver ---------------------------------------------------------------------------------------------


def _avoidance(analysis: Analysis) -> RenderableType:
    avoided = analysis.avoided
    told = {*avoided.by, *(answer.avoidance for answer in analysis.avoidability if answer is not None)}
    shares = [
        (
            Text(whole(avoided.by.get(kind, 0))),
            Text(percent(ratio(avoided.by.get(kind, 0), avoided.driven), 0)),
            Text(AVOIDANCES[kind][0], AVOIDANCES[kind][1]),
            Text(AVOIDANCES[kind][2], "quiet"),
        )
        for kind in sorted(told)
    ]
    head = f"of {counted(avoided.driven, 'different collision')}:"
    table = columns(right(), right(), left(), left(wrap=True), rows=shares)
    return Group(Text(head), table, *_lost(avoided), Text(), *_worst(analysis), Text(DRIVER, "quiet"))


def _lost(avoided: Avoided) -> Iterator[Text]:
    """How many say more about what the file draws than about the ego."""
    if lost_text(avoided):
        yield Text(lost_text(avoided), "warn")


def lost_text(avoided: Avoided) -> str:
    """`3 of them happen even so …`; empty where there are none."""
    if not avoided.lost:
        return ""
    return f"{avoided.lost:,} of them happen even with full braking from the start: they speak of the scene drawn"


def _worst(analysis: Analysis) -> list[RenderableType]:
    """What is said of each of the worst cases."""
    rows = [
        (Text(str(case.rank), "quiet"), Text(str(case.score)), *_answer(answer))
        for case, answer in zip(analysis.worst, analysis.avoidability, strict=True)
        if answer is not None
    ]
    if not rows:
        return []
    head = right("#"), right("risk"), left("of the worst"), right("perceived"), right("contact"), left("", wrap=True)
    return [columns(*head, rows=rows, header=True), Text()]


def _answer(answer: Avoidability) -> Sequence[Text]:
    name, style, _ = AVOIDANCES[answer.avoidance]
    return (
        Text(name, style),
        Text(_seconds(answer.perceived)),
        Text(_seconds(answer.contact)),
        Text(margin_text(answer), "quiet"),
    )


def margin_text(answer: Avoidability) -> str:
    """By how much braking was early enough, or too late."""
    if math.isnan(answer.margin):
        return ""
    if math.isinf(answer.margin):
        return "braking never helps"
    if answer.avoidable:
        return f"{fixed(answer.margin, 2)} s to spare"
    return f"{fixed(-answer.margin, 2)} s too late"


def _seconds(time: float) -> str:
    return f"{fixed(time, 2)} s" if math.isfinite(time) else ABSENT
