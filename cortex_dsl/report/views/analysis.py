"""The views of `analyse` and `probability`: kinds of failures, their places, responsible actors, and probability."""

import math
from collections.abc import Iterator, Sequence

from cortex_dsl.report.blocks import Block, Caution, Column, Grid, Note, Table, Title, Value, Words
from cortex_dsl.report.findings.analysis_report import (
    AVOIDANCES,
    DRIVER,
    JUDGED,
    closing_text,
    condition_text,
    driver_rows,
    fastest_text,
    fresh_text,
    grid_text,
    grouped_text,
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
    verdicts_text,
)
from cortex_dsl.report.findings.judgement import (
    ANSWERS,
    EXPLAINED,
    HEADS,
    LABELS,
    counterfactual_cells,
    drivers_text,
)
from cortex_dsl.report.findings.probability_report import (
    SAMPLE_TIME,
    avoidable_interval_text,
    avoidable_text,
    counts_text,
    effective_text,
    exposure_text,
    how_drawn,
    how_text,
    interval_text,
    levels_text,
    probability_text,
    sequence_text,
    unknown_text,
    unseen_text,
)
from cortex_dsl.report.findings.readable import ABSENT, counted, fixed, percent, ratio, whole
from cortex_dsl.report.findings.search_report import partners_text
from engine.avoidability import Avoidability
from engine.program import ParamSpace, Program
from engine.search.evaluations import Partners
from engine.search.insight.analysis import Analysis, Avoided
from engine.search.insight.diversity import Grid as Cells
from engine.search.insight.sensitivity import Sensitivity, Share
from engine.search.probability.estimates import JOINT, PARAMS, Probability
from engine.search.statistics import Interval
from engine.verdicts import JudgedCollision
from engine.vocabulary import Answer

SHOWN = 12
"""Kinds that are shown."""
CHANCE = "chance"
MARKS = "blank: no simulation; ·: no collision; ░ ▒ ▓ █: more and more collisions"
INDICES = """\
total: share of the variance that is left when all other params are known
alone: share that the param explains by itself; brackets: 95 % bootstrap
Sobol' indices of the mean over chance: lanes, places and everything else that
a scene draws; row chance: what remains when every param is known
risk, collision: among valid runs"""


def analysis_view(program: Program, analysis: Analysis) -> Title:
    """Return the view of `cortexc analyse`."""
    space = program.space
    blocks: list[Block] = [*_summary(program, analysis), *_partners(program, analysis)]
    if analysis.failures:
        blocks.append(
            Title("Kinds of failures", kinds_blocks(program.actors, analysis), collisions_text(analysis.came))
        )
        blocks.append(Title("Where failures lie", places_blocks(space, analysis), "grouped by their params"))
    covered = [grid for grid in analysis.grids if grid.covered]
    marks = [Note(MARKS, "quiet", apart=True)]
    blocks += [
        Title(grid.name, [_grid(grid), *(marks if grid is covered[-1] else [])], _grid_note(grid)) for grid in covered
    ]
    if analysis.sensitivity is not None:
        note = f"{analysis.sensitivity.simulations:,} further simulations, drawn from the distributions of the file"
        blocks.append(Title("Which params matter", _sensitivity(analysis.sensitivity), note))
    if analysis.avoided.driven:
        blocks.append(Title("Would a competent driver have avoided it?", list(avoidance_blocks(analysis))))
    return Title(program.name, blocks)


def _summary(program: Program, analysis: Analysis) -> Iterator[Block]:
    """Yield the first lines, in plain words."""
    simulations = counted(analysis.simulations, "simulation")
    if not analysis.valid:
        yield Note(f"not one of {simulations} was valid: nothing is known", "bad")
        return
    if not analysis.failures:
        tried = f" in {analysis.valid:,} valid of {simulations}"
        yield Note((Value("no collision", "good"), tried, Value("; what was not found may still exist", "quiet")))
        return
    came = analysis.came
    yield Note((Value(lead_text(came), "bad"), f" in {came.valid:,} valid simulations"))
    yield Note((Value(collisions_text(came), "title"), Value(f" in {simulations}", "quiet")))
    if others := others_text(came, program.actors[0]):
        yield Note(others, "quiet")
    spread = analysis.spread
    if math.isfinite(spread.pairwise):
        yield Note(
            f"difference between two collisions, as a share of the range of a param: {percent(spread.pairwise, 0)} on "
            f"average, {percent(spread.nearest)} to the nearest (of {spread.count:,}; more collisions lie nearer)",
            "quiet",
        )
    if analysis.system:
        names = ", ".join(analysis.system)
        yield Note((Value("the search varied params of the system: ", "warn"), names, " (--freeze fixes them)"))


def _partners(program: Program, analysis: Analysis) -> list[Note]:
    """Return the actors with which the ego collided, and those with which it never did."""
    text = partners_text(program.actors, analysis.partners) if analysis.valid and analysis.partners.with_ego else ""
    return [Note(f"collisions {text}")] if text else []


# -- results of the reference driver: failures of the ego, and their certainty -----------------------------------------


def avoidance_blocks(analysis: Analysis) -> Iterator[Block]:
    """Yield the answers of the reference drivers: verdicts, drivers, the careful driver's reasons, the worst cases."""
    avoided = analysis.avoided
    yield Note(verdicts_text(analysis.came))
    yield drivers_table(avoided)
    kinds = {*avoided.by, *(answer.avoidance for answer in analysis.avoidability if answer is not None)}
    shares = [
        (
            Value(whole(avoided.by.get(kind, 0)), "", avoided.by.get(kind, 0)),
            percent(ratio(avoided.by.get(kind, 0), avoided.driven), 0),
            Value(*AVOIDANCES[kind][:2]),
            Value(AVOIDANCES[kind][2], "quiet"),
        )
        for kind in sorted(kinds)
    ]
    found = counted(avoided.driven, "collision")
    yield Note(f"the careful driver in {found} that this search found; shares of these, not failure rates:", apart=True)
    columns = Column(numbers=True), Column(numbers=True), Column(), Column(wrap=True)
    yield Table(columns, shares, header=False, name="answers")
    yield from (Caution(text) for text in (lost_text(avoided), struck_text(avoided), *system_lines(avoided)) if text)
    yield from _worst(analysis)
    yield from counterfactual_blocks([case.rank for case in analysis.worst], analysis.judged)
    yield Note(DRIVER, "quiet", apart=True)


def drivers_table(avoided: Avoided) -> Table:
    """Return a table of the reference drivers: collisions that each avoids, of those that it covers."""
    rows = [
        (name, Value(whole(avoids), "", avoids), Value(whole(covers), "", covers), Value(out, "quiet"))
        for name, _, avoids, covers, out in driver_rows(avoided)
    ]
    columns = (
        Column("driver"),
        Column("avoids", numbers=True),
        Column("of", numbers=True),
        Column("out of range", wrap=True),
    )
    return Table(columns, rows, name="drivers")


def counterfactual_blocks(ranks: Sequence[int], judged: Sequence[JudgedCollision | None]) -> Iterator[Block]:
    """Yield a table of the counterfactuals of cases; nothing without a collision that the ego caused."""
    rows = [
        (Value(str(rank), "quiet"), drivers_text(each), *counterfactual_cells(each.counterfactuals))
        for rank, each in zip(ranks, judged, strict=True)
        if each is not None and each.counterfactuals is not None
    ]
    if rows:
        heads = (Column(head, numbers=True) for head in HEADS[:-1])
        yield Note("")
        yield Table(
            (Column("#", numbers=True), Column("avoided by"), *heads, Column(HEADS[-1])), rows, name="counterfactuals"
        )
        yield Note(EXPLAINED, "quiet")


def case_verdict_table(judged: JudgedCollision) -> Table:
    """Return the answers of the reference drivers to one case, and its counterfactuals."""
    rows = [(name, Value(*ANSWERS[answer])) for name, answer in judged.answers.items() if answer is not Answer.STRUCK]
    if judged.counterfactuals is not None:
        rows += [
            (Value(label, "quiet"), Value(text))
            for label, text in zip(LABELS, counterfactual_cells(judged.counterfactuals), strict=True)
        ]
    return Table((Column(), Column(wrap=True)), rows, header=False, name="verdict")


def _worst(analysis: Analysis) -> list[Block]:
    """Return a table of the worst cases with their verdicts."""
    rows = [
        (Value(str(case.rank), "quiet"), str(case.score), closing_text(case.closing_speed), *_answer(answer))
        for case, answer in zip(analysis.worst, analysis.avoidability, strict=True)
        if answer is not None
    ]
    if not rows:
        return []
    numbers = [Column(head, numbers=True) for head in ("#", "risk", "closing")]
    times = [Column(head, numbers=True) for head in ("perceived", "contact")]
    columns = (*numbers, Column("verdict"), *times, Column(wrap=True))
    return [Note(""), Table(columns, rows, name="cases"), Note(fastest_text(analysis), "quiet")]


def _answer(answer: Avoidability) -> Sequence[Words]:
    name, style, _ = AVOIDANCES[answer.avoidance]
    times = [f"{fixed(time, 2)} s" if math.isfinite(time) else ABSENT for time in (answer.perceived, answer.contact)]
    return Value(name, style), *times, Value(margin_text(answer), "quiet")


# -- kinds and places --------------------------------------------------------------------------------------------------


def kinds_blocks(actors: Sequence[str], analysis: Analysis, shown: int = SHOWN) -> list[Block]:
    """Return the table of kinds of failures; first the kinds that a competent driver would have avoided."""
    rows = [
        (
            Value(whole(each.count), "", each.count),
            Value(*BLAMES[each.kind.blame]),
            kind_text(actors, each.kind),
        )
        for each in analysis.kinds[:shown]
    ]
    columns = Column("collisions", numbers=True), Column(), Column("what happened", wrap=True)
    more = [text for text in (rest_text(analysis.kinds, shown), MEANING) if text]
    notes = [Note(line, "quiet", apart=not number) for number, line in enumerate(more)]
    return [Table(columns, rows, name="kinds"), *notes]


def places_blocks(space: ParamSpace, analysis: Analysis) -> list[Block]:
    """Return the table of failure clusters in the space of params, with the failure rate inside each."""
    rows = [
        (
            Value(whole(len(cluster.rows)), "", len(cluster.rows)),
            condition_text(space, cluster),
            percent(cluster.coverage, 0) if cluster.conditions else ABSENT,
            fresh_text(cluster),
            Value(lift_text(cluster), "quiet"),
        )
        for cluster in analysis.clusters
    ]
    numbers = [Column(head, numbers=True) for head in ("inside", "failure rate", "lift")]
    columns = (Column("failures", numbers=True), Column("where", wrap=True), *numbers)
    notes = [text for text in (grouped_text(analysis), JUDGED) if text]
    return [Table(columns, rows, name="kinds"), *(Note(text, "quiet", apart=not n) for n, text in enumerate(notes))]


def _grid_note(grid: Cells) -> str:
    return f"{grid_text(grid)}, QD score {fixed(grid.qd_score, 0)}"


def _grid(grid: Cells) -> Grid:
    return Grid(grid.name, grid.first, grid.second, grid.runs, grid.failures)


# -- params ------------------------------------------------------------------------------------------------------------


def _sensitivity(found: Sensitivity) -> list[Block]:
    """Return the total and first-order shares of each param, for every output that varies."""
    outputs = varying(found)
    if not outputs:
        return [Note("nothing varies: not one param or choice of the scene matters", "quiet")]
    names = [gene.name for gene in found.risk.genes]
    totals = [
        _shares(name, [indices.genes[gene].total for _, indices in outputs]) for gene, name in enumerate(names)
    ] + [_shares(CHANCE, [indices.chance for _, indices in outputs], "quiet")]
    alone = [_shares(name, [indices.genes[gene].first for _, indices in outputs]) for gene, name in enumerate(names)]
    tables = [
        Table((Column(head), *(Column(title) for title, _ in outputs)), rows, name=head)
        for head, rows in (("total", totals), ("alone", alone))
    ]
    return [tables[0], Note(""), tables[1], Note(INDICES, "quiet", apart=True)]


def _shares(name: str, shares: Sequence[Share], style: str = "") -> Sequence[Words]:
    cells = (
        (Value(fixed(share.value, 2), "", share.value), Value(f" {_interval(share.interval)}", "quiet"))
        for share in shares
    )
    return (Value(name, style), *cells)


def _interval(interval: Interval) -> str:
    return f"[{fixed(interval.low, 2)}, {fixed(interval.high, 2)}]" if math.isfinite(interval.low) else ABSENT


# -- how probable a collision is ---------------------------------------------------------------------------------------

HINT = "--condition joint draws the params again in every attempt"


def probability_view(program: Program, found: Probability) -> Title:
    """Return the estimate with its interval, its conditions, and its method."""
    return Title(program.name, list(_probability(program, found)))


def _probability(program: Program, found: Probability) -> Iterator[Block]:
    if not found.valid and not found.lost:
        yield Note(f"no valid {_given(found)}: there is nothing to estimate", "bad")
        return
    event = f'that "{found.of}" is broken' if found.of else "of a collision"
    given = f"probability {event}, given a valid {_given(found)}: "
    level = percent(found.level, 0)
    yield Note((given, Value(probability_text(found), "bad")))
    yield Note(f"{level} interval: {interval_text(found)}", "warn" if found.withheld else "")
    if found.driven:
        avoided = "of a collision that each reference driver avoids: "
        yield Note((avoided, Value(avoidable_text(found), "bad")))
        yield Note(f"{level} interval: {avoidable_interval_text(found)}")
    yield Note("")
    yield from _conditions(found)
    yield Note(counts_text(found), "quiet")
    missing = (0,) * (len(program.actors) - 1 - len(found.by_partner))
    met = partners_text(program.actors, Partners(found.by_partner + missing, found.without_ego))
    reported = f"collisions {met}" if met and found.method == "mc" and not found.of else ""
    lines = (
        reported,
        how_text(found),
        sequence_text(found),
        unseen_text(found.unseen, "violation" if found.of else "collision"),
        effective_text(found),
        levels_text(found),
        exposure_text(program),
        SAMPLE_TIME,
    )
    yield from (Note(line, "quiet") for line in lines if line)


def _given(found: Probability) -> str:
    """Return `run` if runs broke requirements or failed, else `scene`: the condition of the estimate."""
    return "run" if found.aborted or found.errors else "scene"


def _conditions(found: Probability) -> Iterator[Block]:
    """Yield the conditions of the probability, and the runs that it leaves out."""
    yield Note(how_drawn(found), "quiet")
    if found.condition == PARAMS and found.method == "mc":
        yield Note(HINT, "quiet")
    allow = "allow a valid scene" if _given(found) == "scene" else "give a valid run"
    draws = "draws" if found.condition == JOINT else "draws of the params"
    yield Note(f"{percent(found.valid_share)} of all {draws} {allow}; the others do not count", "quiet")
    broken, failed = (counted(number, "simulation") for number in (found.aborted, found.errors))
    if found.aborted:
        yield Caution(f"{broken} broke a requirement on the run and ended there: they are not counted")
    if found.errors:
        yield Caution(f"{failed} failed and are not counted: the estimate is of the others; a search says why")
    yield from [Note(unknown_text(found), "bad")] if found.lost else []
