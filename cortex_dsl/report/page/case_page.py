"""One case on a page: its replay with synchronous plots, its events, risk and params, and the command to repeat it.

`card` is the article of each case on a run's page, `case_page` a page with one case alone.
"""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from shlex import quote

from cortex_dsl.report.findings.case_replay import CaseReplay
from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.report.findings.objectives import broken_words, objective_results
from cortex_dsl.report.findings.readable import first_line, fixed, format_gene, percent, significant
from cortex_dsl.report.findings.run_report import PARTS
from cortex_dsl.report.findings.story import Moment
from cortex_dsl.report.findings.verification_report import ANSWERS
from cortex_dsl.report.page import scene_svg
from cortex_dsl.report.page.analysis_sections import avoidance_badge
from cortex_dsl.report.page.markup import Element, Node, element, figure, page, prose
from cortex_dsl.report.page.player import SCRIPTS, player, player_data
from engine.avoidability import Avoidability
from engine.metrics import Metric
from engine.outcomes import MODEL_RANGE, PAIRS, Outcomes, Result
from engine.risk import HIGHEST_RISK
from engine.search.ranking import Case
from engine.search.store import without_folders
from engine.streams import StreamKey, format_key
from engine.vocabulary import GeneKind

# -- the tables: the risk with its parts, and the params ---------------------------------------------------------------

PART_MEANINGS = {
    "C": "contact",
    "MD": "least distance between outlines",
    "D_MS": "distance at fastest closing",
    "TTC_MS": "time to collision at fastest closing",
}
IN_RISK = frozenset(row.symbol for row in PAIRS if row.of_risk)


def risk_table(replay: CaseReplay) -> Element:
    rows = [
        element(
            "tr",
            element("th", name, scope="row"),
            element("td", PART_MEANINGS[name]),
            element("td", _measured(replay, name), class_="number"),
            element("td", element("div", class_=f"gauge part-{name}", style=f"--share:{100 * points / most:.0f}%")),
            element("td", f"{points} of {most}", class_="number"),
        )
        for (name, most, _), points in zip(PARTS, replay.parts, strict=True)
    ]
    return element("table", element("tbody", rows), class_="risk")


def _measured(replay: CaseReplay, name: str) -> str:
    outcomes = replay.outcomes
    if name == "C":
        return "yes" if bool(outcomes.collided[0]) else "no"
    if not outcomes.min_distance.shape[1]:
        return "–"
    (row,) = (each for each in PAIRS if each.symbol == name)
    return _amount(replay, row)


def _amount(replay: CaseReplay, row: Result) -> str:
    return f"{fixed(float(getattr(replay.outcomes, row.name)[0, replay.pair]), 2)} {row.unit}"


def measures_table(replay: CaseReplay) -> Node:
    """The metrics of the deciding pair and its two that the score does not come from; nothing where there are none."""
    pair = (0, replay.pair + 1)
    found = [metric for metric in replay.metrics if metric.name not in IN_RISK]
    rows = [_measure(metric, metric.name) for metric in found if metric.actors == pair]
    rows += [
        _measure(metric, f"{metric.name}, {replay.program.actors[actor]}")
        for actor in pair
        for metric in found
        if metric.actors == (actor,)
    ]
    if not rows:
        return None
    table = element("table", element("tbody", rows), class_="params")
    return element("details", element("summary", "Measures"), table)


def _measure(metric: Metric, name: str) -> Element:
    return element(
        "tr",
        element("th", name, scope="row"),
        element("td", metric.meaning),
        element("td", f"{fixed(metric.value, 2)} {metric.unit}".rstrip(), class_="number"),
    )


def pairs_table(replay: CaseReplay) -> Node:
    """Return a table of the ego's distances to all actors except the one that decides the risk."""
    outcomes = replay.outcomes
    rows = [
        element(
            "tr",
            element("th", replay.program.actors[pair + 1], scope="row"),
            element("td", f"{fixed(float(outcomes.min_distance[0, pair]), 2)} m", class_="number"),
            element("td", f"at {fixed(float(outcomes.min_distance_time[0, pair]), 2)} s", class_="quiet"),
        )
        for pair in range(outcomes.min_distance.shape[1])
        if pair != replay.pair and isfinite(outcomes.min_distance[0, pair])
    ]
    if not rows:
        return None
    return [element("h4", "Nearest to the others"), element("table", element("tbody", rows), class_="params")]


def params_table(replay: CaseReplay) -> Element:
    space, genome = replay.program.space, replay.scenes.genomes[0]
    rows = []
    for gene, name in enumerate(space.names):
        value, low, high = float(genome[gene]), float(space.low[gene]), float(space.high[gene])
        share = 100 * (value - low) / (high - low) if high > low else 50.0
        ends = None if space.kinds[gene] == GeneKind.INDEX else f"{significant(low, 3)} to {significant(high, 3)}"
        rows.append(
            element(
                "tr",
                element("th", name, scope="row"),
                element("td", element("data", format_gene(space, gene, value), value=repr(value)), class_="number"),
                element("td", space.units[gene], class_="unit"),
                element("td", element("div", class_="where", style=f"--at:{share:.1f}%"), title=ends),
            )
        )
    held = [
        element(
            "tr",
            element("th", one.name, scope="row"),
            element("td", one.text, class_="number"),
            element("td", one.unit, class_="unit"),
            element("td", "held", class_="quiet"),
        )
        for one in replay.held
    ]
    choices = [
        element("tr", element("th", name, scope="row"), element("td", option, colspan=3))
        for name, option in made_choices(replay.program, replay.scenes)
    ]
    return element("table", element("tbody", rows, held, choices), class_="params")


# -- the article -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Place:
    """Which case of which run this is, for commands that show it again."""

    case: Case
    folder: Path | None
    answer: Avoidability | None = None
    """Answer of the reference driver."""
    opinion: str = ""
    """Result of `cortexc verify --model dynamic`."""


def card(replay: CaseReplay, place: Place, number: int) -> Element:
    """The whole article of one case."""
    case = place.case
    return element(
        "article",
        element(
            "header",
            element("h3", f"Case {case.rank}"),
            element("p", _verdict(replay, case), class_="lead"),
            avoidance_badge(place.answer),
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
                risk_table(replay),
                pairs_table(replay),
                measures_table(replay),
                element("h4", "Params"),
                params_table(replay),
            ),
            class_="case-body",
        ),
        _again(replay, place),
        class_="case",
        id=f"case-{case.rank}",
        data_case=case.rank,
    )


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
