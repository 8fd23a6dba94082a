"""What a search's failures are, for people: how many different ones, where they lie, of what kinds, and whose fault."""

import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.avoidance_view import avoidance_view
from cortex_dsl.report.ends import partners_text
from cortex_dsl.report.failures import condition_text, grid_text, held_out_text, shuffled_text, varying
from cortex_dsl.report.layout import columns, heading, indented, left, right, section, shortened
from cortex_dsl.report.numbers import ABSENT, counted, fixed, percent, whole
from engine.program import ParamSpace, Program
from engine.search.analysis import Analysis
from engine.search.diversity import Grid
from engine.search.sensitivity import Sensitivity, Share
from engine.search.statistics import Interval

SHADES = " ·░▒▓█"
"""Of a cell: nothing ran there, no collision, then ever more collisions."""
CHANCE = "chance"
MARKS = "blank: nothing ran there; ·: no collision; ░ ▒ ▓ █: ever more of them"
INDICES = """\
total: share of the variance that is left when all other params are known
alone: share that the param explains by itself; brackets: 95 % bootstrap
Sobol' indices of the mean over chance, that is lanes, places and what else a
scene draws; row chance: what stays open when every param is known
risk, collision: among valid runs"""


def analysis_view(program: Program, analysis: Analysis, width: int) -> RenderableType:
    """The whole page of `cortexc analyse`."""
    space = program.space
    parts: list[RenderableType] = [heading(program.name), *_summary(analysis), *_partners(program, analysis)]
    if analysis.failures:
        parts.append(section("Kinds of failures", _kinds(space, analysis), "what tells them from all else simulated"))
    covered = [grid for grid in analysis.grids if grid.covered]
    parts += [section(grid.name, _grid(grid, width), _grid_note(grid)) for grid in covered]
    parts += [Text(), indented(Text(MARKS, "quiet"))] if covered else []
    if analysis.sensitivity is not None:
        note = f"{analysis.sensitivity.simulations:,} simulations of their own, drawn as the file says"
        parts.append(section("Which params matter", _sensitivity(analysis.sensitivity), note))
    if analysis.avoided.driven:
        parts.append(section("Would a competent driver have avoided it?", avoidance_view(analysis)))
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
            (f" in a third of their params, by a tenth of the range{shuffled_text(analysis)}", "quiet"),
        ),
    ]
    if math.isfinite(analysis.spread.pairwise):
        lines.append(
            Text(
                f"two collisions differ by {percent(analysis.spread.pairwise, 0)} of a range on average, "
                f"the nearest by {percent(analysis.spread.nearest)} (less, the more are found; here "
                f"{analysis.spread.count:,})",
                "quiet",
            )
        )
    if analysis.system:
        names = ", ".join(analysis.system)
        lines.append(
            Text.assemble(("of the system under test, chosen by the search: ", "warn"), names, " (--freeze holds them)")
        )
    return lines


def _partners(program: Program, analysis: Analysis) -> list[RenderableType]:
    """With whom the ego collided, and with whom never."""
    text = partners_text(program.actors, analysis.partners) if analysis.valid and analysis.partners.with_ego else ""
    return [Text(f"collisions {text}")] if text else []


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


# -- grids ------------------------------------------------------------------------------------------------------------


def _grid_note(grid: Grid) -> str:
    return f"{grid_text(grid)}, QD score {fixed(grid.qd_score, 0)}"


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
    first, last = grid.second[0], grid.second[-1]
    room = width - label - 2
    ends = [f"{first} … {last}"] if len(first) + len(last) + 3 <= room else [f"first {first}", f"last {last}"]
    return Group(*lines, *(Text(f"{'':{label + 2}}{shortened(end, room)}", "quiet") for end in ends))


def _mark(grid: Grid, i: int, j: int, most: int, width: int) -> tuple[str, str]:
    """A cell and its style."""
    failures = int(grid.failures[i, j])
    if not failures:
        return SHADES[1 if grid.runs[i, j] else 0] * width, "quiet"
    shade = min(3, int(4 * math.log1p(failures) / math.log1p(most)))
    return SHADES[2 + shade] * width, "bad"


# -- params -----------------------------------------------------------------------------------------------------------


def _sensitivity(found: Sensitivity) -> RenderableType:
    """What each param leaves open, and what it explains alone, of every output that varies."""
    outputs = varying(found)
    if not outputs:
        return Text("nothing varies: not one param or choice of the scene matters", "quiet")
    names = [gene.name for gene in found.risk.genes]
    totals = [
        _shares(name, [indices.genes[gene].total for _, indices in outputs]) for gene, name in enumerate(names)
    ] + [_shares(CHANCE, [indices.chance for _, indices in outputs], "quiet")]
    alone = [_shares(name, [indices.genes[gene].first for _, indices in outputs]) for gene, name in enumerate(names)]
    tables = [
        columns(left(head), *(left(title) for title, _ in outputs), rows=rows, header=True)
        for head, rows in (("total", totals), ("alone", alone))
    ]
    return Group(tables[0], Text(), tables[1], Text(), Text(INDICES, "quiet"))


def _shares(name: str, shares: Sequence[Share], style: str = "") -> Sequence[Text]:
    cells = (Text.assemble(fixed(share.value, 2), (f" {_interval(share.interval)}", "quiet")) for share in shares)
    return (Text(name, style), *cells)


def _interval(interval: Interval) -> str:
    return f"[{fixed(interval.low, 2)}, {fixed(interval.high, 2)}]" if math.isfinite(interval.low) else ABSENT
