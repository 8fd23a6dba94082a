"""One case on a page: its replay with synchronous plots, its events, risk and params, and the command to repeat it.

`card` is the article of each case on a run's page, `case_page` a page with one case alone.
"""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from shlex import quote

from cortex_dsl.report.blocks import Block, Column, Gauge, Table, Title, Value
from cortex_dsl.report.findings.case_replay import CaseReplay
from cortex_dsl.report.findings.judgement import EXPLAINED
from cortex_dsl.report.findings.objectives import broken_words, objective_results
from cortex_dsl.report.findings.readable import NOT_LEVEL, first_line, fixed, percent
from cortex_dsl.report.findings.run_report import PARTS
from cortex_dsl.report.findings.story import Moment
from cortex_dsl.report.findings.verification_report import ANSWERS
from cortex_dsl.report.page import scene_svg
from cortex_dsl.report.page.analysis_sections import verdict_badges
from cortex_dsl.report.page.markup import Element, Node, element, figure, page, prose
from cortex_dsl.report.page.player import SCRIPTS, player, player_data
from cortex_dsl.report.page.render import nodes
from cortex_dsl.report.views.analysis import case_verdict_table
from cortex_dsl.report.views.measures import IN_RISK, choices_views, params_table
from engine.avoidability import Avoidability
from engine.metrics import never_on_one_level
from engine.outcomes import MODEL_RANGE, PAIRS, Outcomes
from engine.risk import HIGHEST_RISK
from engine.search.ranking import Case
from engine.search.store import without_folders
from engine.streams import StreamKey, format_key
from engine.verdicts import JudgedCollision

# -- the tables: the risk with its parts, measures, and further pairs --------------------------------------------------

PART_MEANINGS = {
    "C": "contact",
    "MD": "least distance between outlines",
    "D_MS": "distance at fastest closing",
    "TTC_MS": "time to collision at fastest closing",
}


NUMBER = Column(numbers=True)


def risk_table(replay: CaseReplay) -> Table:
    """Return a row per part of the risk: meaning, measured value, and points."""
    rows = [
        (
            name,
            PART_MEANINGS[name],
            _measured(replay, name),
            Gauge(style=f"part.{name}", share=points / most),
            f"{points} of {most}",
        )
        for (name, most, _), points in zip(PARTS, replay.parts, strict=True)
    ]
    return Table((Column(), Column(), NUMBER, Column(), NUMBER), rows, header=False, name="risk")


def _measured(replay: CaseReplay, name: str) -> str:
    outcomes = replay.outcomes
    if name == "C":
        return "yes" if bool(outcomes.collided[0]) else "no"
    if not outcomes.min_distance.shape[1]:
        return "–"
    if never_on_one_level(replay.trajectory, replay.pair + 1):
        return NOT_LEVEL
    (row,) = (each for each in PAIRS if each.symbol == name)
    return f"{fixed(float(getattr(outcomes, row.name)[0, replay.pair]), 2)} {row.unit}"


def measures_table(replay: CaseReplay) -> list[Block]:
    """Return the metrics of the deciding pair and of its two actors that are not in the risk; empty without any."""
    pair = (0, replay.pair + 1)
    found = [metric for metric in replay.metrics if metric.name not in IN_RISK]
    named = [(metric.name, metric) for metric in found if metric.actors == pair]
    named += [
        (f"{metric.name}, {replay.program.actors[actor]}", metric)
        for actor in pair
        for metric in found
        if metric.actors == (actor,)
    ]
    rows = [(name, each.meaning, f"{fixed(each.value, 2)} {each.unit}".rstrip()) for name, each in named]
    table = Table((Column(), Column(), NUMBER), rows, header=False, name="params")
    return [Title("Measures", [table], folded=True)] if rows else []


def pairs_table(replay: CaseReplay) -> Node:
    """Return a table of the ego's distances to all actors except the one that decides the risk; None without any."""
    apart, times = replay.outcomes.min_distance[0], replay.outcomes.min_distance_time[0]
    rows: list[tuple[str, str, Value]] = []
    for pair in range(len(apart)):
        name = replay.program.actors[pair + 1]
        if pair != replay.pair and isfinite(apart[pair]):
            at = Value(f"at {fixed(float(times[pair]), 2)} s", "quiet")
            rows.append((name, f"{fixed(float(apart[pair]), 2)} m", at))
        elif pair != replay.pair and never_on_one_level(replay.trajectory, pair + 1):
            rows.append((name, NOT_LEVEL, Value("", "quiet")))
    table = Table((Column(), NUMBER, Column()), rows, header=False, name="params")
    return [element("h4", "Nearest to the others"), nodes(table)] if rows else None


# -- the article -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Place:
    """Which case of which run this is, for commands that show it again."""

    case: Case
    folder: Path | None
    answer: Avoidability | None = None
    """Answer of the careful driver."""
    judged: JudgedCollision | None = None
    """Answers of all reference drivers, and counterfactuals."""
    opinion: str = ""
    """Result of `cortexc verify --model dynamic`."""


def card(replay: CaseReplay, place: Place, number: int) -> Element:
    """The whole article of one case."""
    case, program = place.case, replay.program
    return element(
        "article",
        element(
            "header",
            element("h3", f"Case {case.rank}"),
            element("p", _verdict(replay, case), class_="lead"),
            verdict_badges(place.answer, place.judged),
            opinion_badge(replay.outcomes, place.opinion),
            class_="case-head",
        ),
        player(replay, number),
        element(
            "div",
            element("section", element("h4", "What happened"), _story(replay), class_="story"),
            element(
                "section",
                element("h4", "Risk"),
                nodes(risk_table(replay)),
                pairs_table(replay),
                _judgement(place.judged),
                [nodes(each) for each in measures_table(replay)],
                element("h4", "Params"),
                nodes(params_table(program.space, replay.scenes.genomes[0], replay.held)),
                [nodes(each) for view in choices_views(program, replay.scenes) for each in view.blocks],
            ),
            class_="case-body",
        ),
        _again(replay, place),
        class_="case",
        id=f"case-{case.rank}",
        data_case=case.rank,
    )


def _judgement(judged: JudgedCollision | None) -> Node:
    """Return the answers of the reference drivers, and the counterfactuals; None if the ego was struck."""
    if judged is None or judged.counterfactuals is None:
        return None
    return [element("h4", "What would have avoided it", title=EXPLAINED), nodes(case_verdict_table(judged))]


OPINION_STYLES = {"bad": "hit", "warn": "warn"}
"""Styles of opinions on a page, for those that are red or yellow in a terminal."""


def opinion_badge(outcomes: Outcomes, opinion: str) -> Node:
    """Return the badge for the second opinion of a case; without one, a badge if the grip exceeds the vehicle model."""
    if opinion:
        style, meaning = next(((style, text) for name, style, text in ANSWERS.values() if name == opinion), ("", ""))
        return element("span", opinion, class_=f"badge {OPINION_STYLES.get(style, '')}".strip(), title=meaning)
    used = float(outcomes.combined_grip[0, 0])
    if not used > MODEL_RANGE:
        return None
    text = f"beyond the vehicle model: {percent(used, 0)} of the grip"
    return element(
        "span", text, class_="badge warn", title="`cortexc verify --model dynamic` drives it again with slipping tyres"
    )


AT_ONCE = 1e-9
"""Moments no farther apart are one [s]."""


def _verdict(replay: CaseReplay, case: Case) -> Node:
    over = float(replay.outcomes.end_time[0]) + AT_ONCE
    last = [moment for moment in replay.moments if moment.kind in ("contact", "end") and moment.time <= over]
    end = last[-1].text if last else ""
    return [
        element("b", "risk ", figure(f"case.{case.rank}.score", case.score, str(case.score)), f" of {HIGHEST_RISK}"),
        " · ",
        prose(f"{end} after {fixed(float(replay.outcomes.end_time[0]), 2)} s"),
        None if case.collided else [" · nearest ", _nearest(case)],
        [" · ", element("b", broken)]
        if (broken := broken_words(objective_results(replay.program, replay.outcomes)))
        else None,
    ]


def _nearest(case: Case) -> Node:
    return figure(f"case.{case.rank}.min_distance", case.min_distance, f"{fixed(case.min_distance, 2)} m")


def _story(replay: CaseReplay) -> Element:
    return element("ol", [element("li", _moment(replay, moment)) for moment in replay.moments], class_="moments")


def _moment(replay: CaseReplay, moment: Moment) -> Element:
    who: Node = None
    if moment.actor >= 0:
        name = f"who actor-{scene_svg.colour(moment.actor)}"
        who = element("span", replay.shapes[moment.actor].name, class_=name)
    return element(
        "button",
        element("time", f"{moment.time:.2f} s"),
        element("span", who, " " if who else "", prose(moment.text)),
        type="button",
        class_=f"moment {moment.kind}",
        data_time=repr(moment.time),
        title="show this moment",
    )


def _again(replay: CaseReplay, place: Place) -> Element:
    command = (
        []
        if place.folder is None
        else [f"cortexc replay {quote(without_folders(str(place.folder)))} --case {place.case.rank}"]
    )
    files = [
        element("details", element("summary", name), element("pre", text, class_="source"))
        for name, text in replay.files.items()
    ]
    return element(
        "details",
        element("summary", "Run it again"),
        [element("pre", line, class_="command") for line in command],
        element(
            "p",
            "A separate scenario, which gives the same outcome bit for bit with ",
            element("code", f"cortexc {next(iter(replay.files))}"),
            " and the same --ego" if replay.program.controls else None,
            "; its stream of random numbers is ",
            element("code", format_key(place.case.key)),
            ".",
        ),
        files,
        class_="again",
    )


# -- the page ----------------------------------------------------------------------------------------------------------


def case_page(replay: CaseReplay, case: Case | None = None, folder: Path | None = None) -> str:
    """Return the page of a case; `folder` is that of its run, if it has one."""
    program = replay.program
    description = first_line(program.description)
    place = Place(case or case_of(replay), folder)
    body = element(
        "main",
        element(
            "header",
            element("p", "Replay", class_="kicker"),
            element("h1", program.name),
            element("p", description, class_="description") if description else None,
        ),
        card(replay, place, 0),
        class_="film",
    )
    return page(f"{program.name}: replay", body, {"replays": [player_data(replay)]}, SCRIPTS)


def case_of(replay: CaseReplay) -> Case:
    """A single run as a case, where there is no search to rank it."""
    distances = replay.outcomes.min_distance[0]
    return Case(
        rank=1,
        row=0,
        rollout=0,
        genome=tuple(replay.scenes.genomes[0].tolist()),
        key=StreamKey(*replay.scenes.keys[0].tolist()),
        score=replay.score,
        continuous=float("nan"),
        collided=bool(replay.outcomes.collided[0]),
        min_distance=float(distances.min()) if len(distances) else float("nan"),
    )
