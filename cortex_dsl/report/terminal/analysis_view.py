"""Output of `analyse` and `probability`: kinds of failures, their places, responsible actors, and probability."""

import math
from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.analysis_report import (
    AVOIDANCES,
    DRIVER,
    JUDGED,
    closing_text,
    condition_text,
    fastest_text,
    fresh_text,
    grid_text,
    lift_text,
    lost_text,
    margin_text,
    struck_text,
    system_lines,
    varying,
)
from cortex_dsl.report.findings.failures import (
    BLAMES,
    MEANING,
    collisions_text,
    kind_text,
    lead_text,
    others_text,
    rest_text,
)
from cortex_dsl.report.findings.probability_report import (
    EXPOSURE,
    HOW,
    SAMPLE_TIME,
    avoidable_interval_text,
    avoidable_text,
    counts_text,
    effective_text,
    how_drawn,
    interval_text,
    levels_text,
    probability_text,
    unknown_text,
)
from cortex_dsl.report.findings.readable import ABSENT, counted, fixed, percent, ratio, shortened, whole
from cortex_dsl.report.findings.search_report import partners_text
from cortex_dsl.report.terminal.theme import columns, heading, indented, left, right, section
from engine.avoidability import Avoidability
from engine.program import ParamSpace, Program
from engine.search.evaluations import Partners
from engine.search.insight.analysis import Analysis, Avoided
from engine.search.insight.diversity import Grid
from engine.search.insight.sensitivity import Sensitivity, Share
from engine.search.probability.estimates import JOINT, PARAMS, Probability
from engine.search.statistics import Interval

# -- results of the reference driver: failures of the ego, and their certainty -----------------------------------------


def avoidance_view(analysis: Analysis) -> RenderableType:
    avoided = analysis.avoided
    kinds = {*avoided.by, *(answer.avoidance for answer in analysis.avoidability if answer is not None)}
    shares = [
        (
            Text(whole(avoided.by.get(kind, 0))),
            Text(percent(ratio(avoided.by.get(kind, 0), avoided.driven), 0)),
            Text(AVOIDANCES[kind][0], AVOIDANCES[kind][1]),
            Text(AVOIDANCES[kind][2], "quiet"),
        )
        for kind in sorted(kinds)
    ]
    head = f"of {counted(avoided.driven, 'collision')} that this search found; shares of these, not failure rates:"
    table = columns(right(), right(), left(), left(wrap=True), rows=shares)
    said = [Text(line, "warn") for line in system_lines(avoided)]
    return Group(Text(head), table, *_lost(avoided), *said, Text(), *_worst(analysis), Text(DRIVER, "quiet"))


def _lost(avoided: Avoided) -> Iterator[Text]:
    """Yield how many failures are due to random values of the file, or to other actors, more than to the ego."""
    for text in (lost_text(avoided), struck_text(avoided)):
        if text:
            yield Text(text, "warn")


def _worst(analysis: Analysis) -> list[RenderableType]:
    """Return a table of the worst cases with their verdicts."""
    rows = [
        (Text(str(case.rank), "quiet"), Text(str(case.score)), Text(closing_text(case.closing_speed)), *_answer(answer))
        for case, answer in zip(analysis.worst, analysis.avoidability, strict=True)
        if answer is not None
    ]
    if not rows:
        return []
    head = right("#"), right("risk"), right("closing"), left("verdict"), right("perceived"), right("contact")
    return [columns(*head, left("", wrap=True), rows=rows, header=True), Text(fastest_text(analysis), "quiet"), Text()]


def _answer(answer: Avoidability) -> Sequence[Text]:
    name, style, _ = AVOIDANCES[answer.avoidance]
    return (
        Text(name, style),
        Text(_seconds(answer.perceived)),
        Text(_seconds(answer.contact)),
        Text(margin_text(answer), "quiet"),
    )


def _seconds(time: float) -> str:
    return f"{fixed(time, 2)} s" if math.isfinite(time) else ABSENT


# -- the whole of `cortexc analyse` ------------------------------------------------------------------------------------

SHADES = " ·░▒▓█"
"""Shades of a cell: no run, no collision, then increasing shares of collisions."""
CHANCE = "chance"
MARKS = "blank: no simulation; ·: no collision; ░ ▒ ▓ █: more and more collisions"
INDICES = """\
total: share of the variance that is left when all other params are known
alone: share that the param explains by itself; brackets: 95 % bootstrap
Sobol' indices of the mean over chance: lanes, places and everything else that
a scene draws; row chance: what remains when every param is known
risk, collision: among valid runs"""


def analysis_view(program: Program, analysis: Analysis, width: int) -> RenderableType:
    """The whole page of `cortexc analyse`."""
    space = program.space
    parts: list[RenderableType] = [heading(program.name), *_summary(program, analysis), *_partners(program, analysis)]
    if analysis.failures:
        parts.append(section("Kinds of failures", _kinds(program, analysis), collisions_text(analysis.came)))
        parts.append(section("Where failures lie", _clusters(space, analysis), "grouped by their params"))
    covered = [grid for grid in analysis.grids if grid.covered]
    parts += [section(grid.name, _grid(grid, width), _grid_note(grid)) for grid in covered]
    parts += [Text(), indented(Text(MARKS, "quiet"))] if covered else []
    if analysis.sensitivity is not None:
        note = f"{analysis.sensitivity.simulations:,} further simulations, drawn from the distributions of the file"
        parts.append(section("Which params matter", _sensitivity(analysis.sensitivity), note))
    if analysis.avoided.driven:
        parts.append(section("Would a competent driver have avoided it?", avoidance_view(analysis)))
    return Group(*parts)


def _summary(program: Program, analysis: Analysis) -> list[RenderableType]:
    """The first lines, in plain words."""
    if not analysis.valid:
        return [Text(f"not one of {counted(analysis.simulations, 'simulation')} was valid: nothing is known", "bad")]
    if not analysis.failures:
        tried = f" in {analysis.valid:,} valid of {counted(analysis.simulations, 'simulation')}"
        return [Text.assemble(("no collision", "good"), tried, ("; what was not found may still exist", "quiet"))]
    came = analysis.came
    lines: list[RenderableType] = [
        Text.assemble((lead_text(came), "bad"), f" in {came.valid:,} valid simulations"),
        Text.assemble(
            (collisions_text(came), "title"),
            (f" in {counted(analysis.simulations, 'simulation')}", "quiet"),
        ),
    ]
    if others := others_text(came, program.actors[0]):
        lines.append(Text(others, "quiet"))
    if math.isfinite(analysis.spread.pairwise):
        lines.append(
            Text(
                f"difference between two collisions, as a share of the range of a param: "
                f"{percent(analysis.spread.pairwise, 0)} on average, {percent(analysis.spread.nearest)} to the nearest "
                f"(of {analysis.spread.count:,}; more collisions lie nearer)",
                "quiet",
            )
        )
    if analysis.system:
        names = ", ".join(analysis.system)
        lines.append(
            Text.assemble(("the search varied params of the system: ", "warn"), names, " (--freeze fixes them)")
        )
    return lines


def _partners(program: Program, analysis: Analysis) -> list[RenderableType]:
    """Return the actors with which the ego collided, and those with which it never did."""
    text = partners_text(program.actors, analysis.partners) if analysis.valid and analysis.partners.with_ego else ""
    return [Text(f"collisions {text}")] if text else []


# -- kinds ------------------------------------------------------------------------------------------------------------


SHOWN = 12
"""Kinds that the terminal shows."""


def _kinds(program: Program, analysis: Analysis) -> RenderableType:
    """Return the table of kinds of failures; first the kinds that a competent driver would have avoided."""
    rows = [
        (
            Text(whole(each.count)),
            Text(*BLAMES[each.kind.blame]),
            Text(kind_text(program.actors, each.kind)),
        )
        for each in analysis.kinds[:SHOWN]
    ]
    table = columns(right("collisions"), left(), left("what happened", wrap=True), rows=rows, header=True)
    more = [text for text in (rest_text(analysis.kinds, SHOWN), MEANING) if text]
    return Group(table, Text(), *(Text(line, "quiet") for line in more))


def _clusters(space: ParamSpace, analysis: Analysis) -> RenderableType:
    """Return the table of failure clusters in the space of params, with the failure rate inside each."""
    rows = [
        (
            Text(whole(len(cluster.rows))),
            Text(condition_text(space, cluster)),
            Text(percent(cluster.coverage, 0) if cluster.conditions else ABSENT),
            Text(fresh_text(cluster)),
            Text(lift_text(cluster), "quiet"),
        )
        for cluster in analysis.clusters
    ]
    head = right("failures"), left("where", wrap=True), right("inside"), right("failure rate"), right("lift")
    return Group(columns(*head, rows=rows, header=True), Text(), Text(JUDGED, "quiet"))


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
    """Return the total and first-order shares of each param, for every output that varies."""
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


# -- how probable a collision is ---------------------------------------------------------------------------------------

HINT = "--condition joint draws the params again in every attempt"


def probability_view(program: Program, found: Probability) -> RenderableType:
    """Return the estimate with its interval, its conditions, and its method."""
    if not found.valid and not found.lost:
        return Group(heading(program.name), Text(f"no valid {_given(found)}: there is nothing to estimate", "bad"))
    event = f'that "{found.of}" is broken' if found.of else "of a collision"
    lines = [
        Text.assemble(f"probability {event}, given a valid {_given(found)}: ", (probability_text(found), "bad")),
        Text(f"{percent(found.level, 0)} interval: {interval_text(found)}", "warn" if found.withheld else ""),
        *_avoidable(found),
        Text(),
        *_conditions(found),
        Text(counts_text(found), "quiet"),
        *_partners_met(program, found),
        Text(HOW[found.method], "quiet"),
    ]
    lines += [Text(line, "quiet") for line in (effective_text(found), levels_text(found)) if line]
    return Group(heading(program.name), *lines, Text(EXPOSURE, "quiet"), Text(SAMPLE_TIME, "quiet"))


def _partners_met(program: Program, found: Probability) -> Iterator[Text]:
    """Yield the actors with which the ego collided, and those with which it never did."""
    missing = (0,) * (len(program.actors) - 1 - len(found.by_partner))
    text = partners_text(program.actors, Partners(found.by_partner + missing, found.without_ego))
    if text and found.method == "mc" and not found.of:
        yield Text(f"collisions {text}", "quiet")


def _avoidable(found: Probability) -> Iterator[Text]:
    """Yield the probability of a collision that a competent driver avoids."""
    if not found.driven:
        return
    yield Text.assemble("of a collision that a competent driver avoids (UN R157): ", (avoidable_text(found), "bad"))
    yield Text(f"{percent(found.level, 0)} interval: {avoidable_interval_text(found)}")


def _given(found: Probability) -> str:
    """Return `run` if runs broke requirements or failed, else `scene`: the condition of the estimate."""
    return "run" if found.aborted or found.errors else "scene"


def _conditions(found: Probability) -> Iterator[Text]:
    """Yield the conditions of the probability, and the runs that it leaves out."""
    yield Text(how_drawn(found), "quiet")
    if found.condition == PARAMS and found.method == "mc":
        yield Text(HINT, "quiet")
    allow = "allow a valid scene" if _given(found) == "scene" else "give a valid run"
    yield Text(f"{percent(found.valid_share)} of all {_draws(found)} {allow}; the others do not count", "quiet")
    broken, failed = (counted(number, "simulation") for number in (found.aborted, found.errors))
    if found.aborted:
        yield Text(f"{broken} broke a requirement on the run and ended there: they are not counted", "warn")
    if found.errors:
        yield Text(f"{failed} failed and are not counted: the estimate is of the others; a search says why", "warn")
    yield from [Text(unknown_text(found), "bad")] if found.lost else []


def _draws(found: Probability) -> str:
    return "draws" if found.condition == JOINT else "draws of the params"
