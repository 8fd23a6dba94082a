"""A search on one screen: the failures found, the worst cases, one picture per kind, and the next command."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from shlex import quote

import numpy as np

from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.blocks import (
    Block,
    Caution,
    Code,
    Column,
    Note,
    Panel,
    Picture,
    Table,
    Title,
    Value,
    Words,
    height_of,
)
from cortex_dsl.report.findings.cases_found import CaseFound, known_cases
from cortex_dsl.report.findings.driven_runs import DRIVEN
from cortex_dsl.report.findings.failures import (
    BLAMES,
    driver_failed_text,
    driver_text,
    lead_text,
    others_text,
    rate_texts,
    rest_text,
)
from cortex_dsl.report.findings.judgement import adapted_text, covering, drivers_text
from cortex_dsl.report.findings.readable import (
    ABSENT,
    SpeedUnit,
    counted,
    duration,
    fixed,
    short_names,
    shortened,
    significant,
    speed_unit,
    whole,
)
from cortex_dsl.report.findings.search_report import (
    RANDOM,
    SearchReport,
    draws_texts,
    method_name,
    method_style,
    partners_text,
)
from cortex_dsl.report.findings.story import end_text
from cortex_dsl.report.findings.tally import Tally
from cortex_dsl.report.views.requirements import help_note, requirements_view
from cortex_dsl.report.views.run import LINES, title_of
from engine.avoidability import STRUCK, Avoidability, Avoidance
from engine.program import Program
from engine.search.campaign import INTERRUPTED, Campaign
from engine.search.evaluations import partners
from engine.search.insight.independent import independent_draws
from engine.search.insight.kinds import PACES, FoundKind
from engine.search.manifest import MOST_IN_TABLES, is_large
from engine.search.objectives import known_objectives
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.ranking import Case
from engine.search.result_files import TABLES, broken_by
from engine.vocabulary import Blame, EndReason, Verdict

PICTURE_ROWS, LEAST_ROWS = 8, 4
"""Most and fewest lines of a picture of a kind."""
NAME = 12
"""Characters of the name of an actor in the table."""
FEW = 4
"""Worst cases that each method shows where several searched."""

AVOIDED = {
    Avoidance.AVOIDABLE: ("yes", "bad"),
    Avoidance.UNAVOIDABLE: ("no", "warn"),
    Avoidance.BRAKED_AS_HARD: ("no, braked as hard", "warn"),
    Avoidance.UNSEEN: ("no, unseen", "warn"),
    Avoidance.LOST: ("no, lost at start", "warn"),
    Avoidance.NO_BRAKING_HELPS: ("no, none helps", "warn"),
    Avoidance.STRUCK_FROM_BEHIND: ("struck from behind", "quiet"),
    Avoidance.STRUCK_STANDING: ("struck, standing", "quiet"),
}
"""Answer of the reference driver in the table, and its style."""
OF_AVOIDANCE = {Avoidance.AVOIDABLE: Blame.AVOIDABLE} | dict.fromkeys(STRUCK, Blame.STRUCK)
"""Verdicts that say the same as the careful driver's answer; unavoidable as each other answer."""
BLAMED = {
    Blame.AVOIDABLE: ("yes", "bad"),
    Blame.DISPUTED: ("disputed", "bad"),
    Blame.UNAVOIDABLE: ("no", "warn"),
    Blame.NO_MODEL: ("no model", "quiet"),
    Blame.STRUCK: ("ego was struck", "quiet"),
    Blame.NONE: (ABSENT, "quiet"),
}
"""The same where only the verdict is known."""


def search_screen(program: Program, report: SearchReport, settings: str) -> Title:
    """Return the view of a search by one method: at most 45 lines of 80 columns."""
    cases = report.cases or known_cases(program, report.campaign)
    above = [
        *headline(program, report),
        *_loneliness(program),
        Note(effort(report.campaign), "quiet"),
        *([Note(f"  {settings}", "quiet")] if settings else []),
        *rejections(program, report),
        *worst_cases_table(program, report.campaign, cases),
    ]
    below = list(ending(report))
    rows = LINES - height_of(title_of(program, (*above, *_kinds(program, report, 0), *below)))
    return title_of(program, (*above, *_kinds(program, report, rows), *below))


def comparison_screen(program: Program, reports: Sequence[SearchReport], settings: str) -> Title:
    """Return the view of a search by several methods: their failures side by side, and the worst cases of each."""
    blocks = [line for report in reports for line in headline(program, report)[:1]]
    blocks += [*_loneliness(program), _side_by_side(reports, settings)]
    for report in reports:
        cases = (report.cases or known_cases(program, report.campaign))[:FEW]
        blocks += rejections(program, report)
        blocks += worst_cases_table(program, report.campaign, cases, method_name(report.method))
    blocks += [line for report in reports for line in ending(report, apart=report is reports[0])]
    return title_of(program, blocks)


# -- the lines at the top ----------------------------------------------------------------------------------------------


def headline(program: Program, report: SearchReport) -> list[Block]:
    """Return the failures of the ego, their rate, their partners, and what the search looked for."""
    campaign = report.campaign
    came, found = campaign.failures, campaign.by_simulation
    failed = driver_text(came, campaign.objective)
    if found.runs and not found.valid_runs:
        failed = failed or ("failures of the driver only" if came.lost else "no valid scene")
    valid = "" if found.valid_runs == found.runs else "valid "
    runs = counted(found.runs, "simulation") if failed else f"{found.valid_runs:,} {valid}simulations"
    lead = Note(
        (
            Value(f"{method_name(report.method)}: ", method_style(report.method)),
            Value(failed or lead_text(came), "bad" if failed or came.collisions else "good"),
            f" in {runs}",
            Value("  interrupted" if campaign.stopped else "", "warn"),
            Value(" before its collisions were judged" if campaign.status == INTERRUPTED else "", "warn"),
        )
    )
    return [lead, *(Note(f"  {line}", "quiet") for line in _below(program, campaign) if line)]


def _below(program: Program, campaign: Campaign) -> Iterator[str]:
    came = campaign.failures
    if not driver_text(came, campaign.objective):
        yield driver_failed_text(came)
    yield from rate_texts(came, campaign.elapsed)
    if campaign.method == RANDOM:
        yield from draws_texts(independent_draws(campaign.evaluations, campaign.method, program.judged.names))
    yield others_text(came, program.actors[0])
    yield shortened(partners_text(program.actors, partners(campaign.evaluations, len(program.actors))), 150)
    if campaign.objective != DEFAULT_OBJECTIVES:
        finds = int(campaign.evaluations.found[campaign.evaluations.simulated].sum())
        _, unit, sign = _objective_of(program, campaign)
        best = f"{significant(sign * campaign.worst[0].continuous)} {unit}".rstrip() if campaign.worst else "none"
        yield f"objective: {' and '.join(campaign.objective)}; found {counted(finds, 'time')}, best {best}"
    broken = broken_by(campaign.evaluations, program.judged.names).items()
    yield shortened("; ".join(f'"{name}" broken in {counted(count, "run")}' for name, count in broken), 150)


def effort(campaign: Campaign) -> str:
    """Return the number of runs and the pace of a search; no pace makes the line long enough to wrap."""
    runs = campaign.by_simulation.runs
    rate = runs / campaign.elapsed if campaign.elapsed > 0 else 0.0
    return f"  {counted(runs, 'run')} in {duration(campaign.elapsed)}, {whole(rate)} a second"


def _loneliness(program: Program) -> list[Block]:
    """Return a warning if the ego is the only actor, so that a search cannot find anything."""
    return [] if len(program.actors) > 1 else [Caution("  the ego is the only actor, so every risk is 0")]


def _side_by_side(reports: Sequence[SearchReport], settings: str) -> Title:
    """Return one row per method: its failures and its effort."""
    head = ("avoidable", "their kinds", "collisions", "kinds", "simulations", "invalid")
    rows = []
    for report in reports:
        came, runs = report.campaign.failures, report.campaign.by_simulation
        judged = (came.avoidable, came.avoidable_kinds), (came.kinds,)
        numbers = [*(judged[0] if came.judged else (None, None)), came.collisions]
        numbers += [*(judged[1] if came.judged else (None,)), runs.runs, runs.nis]
        name = Value(method_name(report.method), method_style(report.method))
        rows.append((name, *(Value(ABSENT if n is None else whole(n), "", n) for n in numbers)))
    columns = (Column("method"), *(Column(text, numbers=True, rank=rank) for rank, text in enumerate(head)))
    return Title("Side by side", [Table(columns, rows, name="methods")], settings)


def rejections(program: Program, report: SearchReport) -> list[Title]:
    """Return why no scene of a search was valid; [] if one was driven."""
    evaluations = report.campaign.evaluations
    tally = Tally.of_search(evaluations)
    if np.isin(evaluations.rollouts.verdict, DRIVEN).any() or not tally.attempts:
        return []
    return requirements_view(program, tally, account=report.blame)


def unfinished_note(program: Program, report: SearchReport) -> Note | None:
    """Return a line on runs that the engine could not finish; None without any."""
    runs = report.campaign.evaluations.rollouts
    failed = (runs.verdict == Verdict.ERROR) & (runs.end_reason != EndReason.STUCK)
    if not failed.any():
        return None
    reasons = Counter(zip(runs.end_reason[failed].tolist(), runs.end_rule[failed].tolist(), strict=True))
    (reason, rule), _ = reasons.most_common(1)[0]
    cause = end_text(program, EndReason(reason), rule) if reason >= 0 else "a scene could not be drawn"
    count = Value(f"{counted(int(failed.sum()), 'run')} failed and are not counted", "bad")
    return Note((count, f": {cause}; please report it"))


# -- the worst cases ---------------------------------------------------------------------------------------------------


def worst_cases_table(
    program: Program, campaign: Campaign, cases: Sequence[CaseFound], method: str = "", note: str = ""
) -> list[Title]:
    """Return one row per case: partner, side, speeds, and whether a competent driver avoids it.

    [] without cases, and where a lone ego can meet nobody.
    """
    aimed = campaign.objective != DEFAULT_OBJECTIVES
    if not cases or (len(program.actors) == 1 and not aimed and not any(each.case.lost for each in cases)):
        return []
    unit = speed_unit(program)
    known = [each.judged for each in cases if each.judged is not None]
    several = any(len(covering(each)) > 1 for each in known)
    names = dict(zip(program.actors, short_names(program.actors, NAME), strict=True))
    _, of_goal, sign = _objective_of(program, campaign)
    columns = (
        Column("#", numbers=True, style="quiet"),
        Column("with"),
        Column("side", rank=3),
        Column("heading", rank=6),
        Column(f"ego\n{unit.name}", numbers=True, rank=4),
        Column(f"other\n{unit.name}", numbers=True, rank=4),
        Column("avoidable"),
        *((Column("by", rank=2),) if several else ()),
        Column("braking", rank=2),
        Column("risk", numbers=True, rank=5),
        *((Column(f"objective\n{of_goal}".rstrip(), numbers=True, rank=1),) if aimed else ()),
    )
    rows = [_case(each, names, unit, sign if aimed else None, several=several) for each in cases]
    title = f"The {len(cases)} worst cases" if len(cases) > 1 else "The worst case"
    table = Table(columns, rows, name="cases")
    beyond = sum(each.is_beyond_model for each in cases)
    blocks: list[Block] = [table] if method else [table, Note(LEGEND, "quiet")]
    if not method and (adapted := adapted_text(known)):
        blocks.append(Note(adapted, "quiet"))
    if beyond:
        blocks.append(Note(f"beyond the grip of the vehicle model: {beyond} of {len(cases)}; {BEYOND}", "warn"))
    return [Title(f"{title} of {method}" if method else title, blocks, note or ORDERS[not aimed])]


ORDERS = ("collisions first, then near misses", "by risk, avoidable ones first among equals")
BEYOND = "`cortexc verify RUN --model dynamic` drives them with tyres"
LEGEND = "speeds at contact, or closest; avoidable: by the reference drivers"


def _objective_of(program: Program, campaign: Campaign) -> tuple[str, str, float]:
    """Return name, unit and sign of the first objective; the sign leads from the maximized to the shown number."""
    name = campaign.objective[0]
    row = known_objectives(program).get(name)
    return (name, row.unit, row.sign) if row is not None else (name, "", 1.0)


def _case(
    each: CaseFound, names: Mapping[str, str], unit: SpeedUnit, sign: float | None, *, several: bool
) -> tuple[Words, ...]:
    case = each.case
    partner = Value(names[each.partner] if each.partner else ABSENT, "" if each.partner else "quiet")
    speeds = [Value(unit.number(speed, 0), "", speed) for speed in each.speeds]
    goal = () if sign is None else (Value(significant(sign * case.continuous), "", case.continuous),)
    score: Words = ABSENT if case.lost else Value(str(case.score), "title", case.score)
    rank = Value(str(case.rank), "", case.rank)
    avoided, braking = _verdict(each)
    drivers = (Value(drivers_text(each.judged) if each.judged else "", "quiet"),) if several else ()
    return (rank, partner, each.side, each.heading, *speeds, avoided, *drivers, braking, score, *goal)


def _verdict(each: CaseFound) -> tuple[Words, Words]:
    """Return whether the reference drivers avoid a case, and how much too late the careful driver brakes."""
    if each.case.lost:
        return Value(f"driver failed at {fixed(each.end, 2)} s", "bad", each.end), ""
    if not each.case.collided:
        distance = each.case.min_distance
        return Value(f"{fixed(distance, 2)} m apart", "quiet", distance), ""
    if each.answer is None:
        return Value(*BLAMED[each.blame]), ""
    said, same = AVOIDED[each.answer.avoidance], OF_AVOIDANCE.get(each.answer.avoidance, Blame.UNAVOIDABLE)
    if each.judged is not None and each.judged.verdict != same:
        said = BLAMED[each.judged.verdict]
    return Value(*said), _margin(each.answer)


def _margin(answer: Avoidability) -> Words:
    if answer.struck or math.isnan(answer.margin):
        return ""
    if math.isinf(answer.margin):
        return Value("never helps", "quiet")
    if answer.avoidable:
        return Value(f"{fixed(answer.margin, 2)} s in time", "quiet", answer.margin)
    if answer.margin > 0.0:
        return Value(f"{fixed(answer.margin, 2)} s too early", "quiet", answer.margin)
    return Value(f"{fixed(-answer.margin, 2)} s too late", "", answer.margin)


# -- kinds of failures -------------------------------------------------------------------------------------------------


def _kinds(program: Program, report: SearchReport, rows: int) -> list[Title]:
    """Return one picture per kind of collision with its count, `rows` lines high; [] without kinds."""
    shown, campaign = report.kinds, report.campaign
    if not (shown and campaign.failures.judged):
        return []
    rows = min(rows, PICTURE_ROWS)
    panels = [
        Panel(each.drawing if rows >= LEAST_ROWS else None, kind_lines(program.actors, each.found, each.case))
        for each in shown
    ]
    numbers = {each.found.kind for each in shown}
    rest = [each for each in campaign.kinds if each.kind not in numbers]
    return [Title("Kinds of failures", [Picture(panels, rows)], rest_text(rest, 0))]


def kind_lines(actors: Sequence[str], found: FoundKind, case: Case) -> tuple[Words, ...]:
    """Return the caption of a kind: its count, its verdict, where the two met, and how fast."""
    kind = found.kind
    count = Value(f"{found.count:,}", "title", found.count)
    name, style = BLAMES[kind.blame]
    other = short_names(actors, NAME)[kind.pair + 1]
    unit = " km/h" if kind.ego_speed or kind.other_speed else ""
    return (
        (count, " x ", Value(name, style)),
        f"{other}, {kind.side.name.lower()}",
        Value(f"{kind.heading}, as case {case.rank}", "quiet"),
        Value(f"{PACES[kind.ego_speed]}, {PACES[kind.other_speed]}{unit}", "quiet"),
    )


# -- the last lines ----------------------------------------------------------------------------------------------------


def ending(report: SearchReport, *, apart: bool = True) -> Iterator[Block]:
    """Yield the files in one line, the command that repeats a case with its driver, and the next commands."""
    if report.folder is None:
        return
    folder = quote(as_argument(report.folder))
    worst = f"worst/01.scn .. {report.worst_files[-1].name}, " if report.worst_files else ""
    failures = "controller.log, failures/01.scn, " if report.campaign.failures.lost else ""
    yield Note(f"files: {folder}/ ({failures}{worst}README.md explains them)", "quiet", apart=apart)
    if is_large(report.campaign.config) and not any((report.folder / name).exists() for name in TABLES):
        why = f"no CSV and no JSON lines, which a search of more than {MOST_IN_TABLES:,} simulations has on request"
        yield Note(why, "quiet")
        yield Code(f"cortexc report {folder} --tables", "tables")
    if report.driver and report.worst_files:
        yield Code(f"cortexc {quote(as_argument(report.worst_files[0]))} {report.driver}", "again")
    if not report.campaign.by_simulation.valid_runs and not report.campaign.failures.lost:
        yield help_note(report.blame)
        return
    yield Note(f"more: cortexc resume {folder} --metrics, or --paper", "quiet")
    yield Code(f"cortexc report {folder} --open", "next")
