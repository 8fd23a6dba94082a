"""One case on a page: its replay with plots in step, what happened, its risk, its params, and how to see it again."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote

from cortex_dsl.page import drawing
from cortex_dsl.page.case import ToldCase
from cortex_dsl.page.case_tables import pairs_table, params_table, risk_table
from cortex_dsl.page.document import figure
from cortex_dsl.page.element import Element, Node, element, prose
from cortex_dsl.page.player import player
from cortex_dsl.page.understanding import avoidance_badge
from cortex_dsl.report.numbers import fixed
from cortex_dsl.report.story import Moment
from engine.avoidability import Avoidability
from engine.risk import HIGHEST_RISK
from engine.search.ranking import Case
from engine.streams import format_key


@dataclass(frozen=True)
class Place:
    """Which case of which run this is, for commands that show it again."""

    case: Case
    folder: Path | None
    answer: Avoidability | None = None
    """Of the reference driver."""


def card(told: ToldCase, place: Place, number: int) -> Element:
    """The whole article of one case."""
    case = place.case
    return element(
        "article",
        element(
            "header",
            element("h3", f"Case {case.rank}"),
            element("p", _verdict(told, case), class_="lead"),
            avoidance_badge(place.answer),
            class_="case-head",
        ),
        player(told, number),
        element(
            "div",
            element("section", element("h4", "What happened"), _story(told), class_="story"),
            element(
                "section",
                element("h4", "Risk"),
                risk_table(told),
                pairs_table(told),
                element("h4", "Params"),
                params_table(told),
            ),
            class_="case-body",
        ),
        _again(told, place),
        class_="case",
        id=f"case-{case.rank}",
        data_case=case.rank,
    )


def _verdict(told: ToldCase, case: Case) -> Node:
    last = [moment for moment in told.moments if moment.kind in ("contact", "end")]
    end = last[0].text if last else ""
    return [
        element("b", "risk ", figure(f"case.{case.rank}.score", case.score, str(case.score)), f" of {HIGHEST_RISK}"),
        " · ",
        prose(f"{end} after {fixed(float(told.outcomes.end_time[0]), 2)} s"),
        None if case.collided else [" · nearest ", _nearest(case)],
    ]


def _nearest(case: Case) -> Node:
    return figure(f"case.{case.rank}.min_distance", case.min_distance, f"{fixed(case.min_distance, 2)} m")


def _story(told: ToldCase) -> Element:
    return element("ol", [element("li", _moment(told, moment)) for moment in told.moments], class_="moments")


def _moment(told: ToldCase, moment: Moment) -> Element:
    who: Node = None
    if moment.actor >= 0:
        name = f"who actor-{drawing.colour(moment.actor)}"
        who = element("span", told.shapes[moment.actor].name, class_=name)
    return element(
        "button",
        element("time", f"{moment.time:.2f} s"),
        element("span", who, " " if who else "", prose(moment.text)),
        type="button",
        class_=f"moment {moment.kind}",
        data_time=repr(moment.time),
        title="show this moment",
    )


def _again(told: ToldCase, place: Place) -> Element:
    command = [] if place.folder is None else [f"cortexc replay {quote(str(place.folder))} --case {place.case.rank}"]
    files = [
        element("details", element("summary", name), element("pre", text, class_="source"))
        for name, text in told.files.items()
    ]
    return element(
        "details",
        element("summary", "See it again"),
        [element("pre", line, class_="command") for line in command],
        element(
            "p",
            "As a scenario of its own, which runs to the same outcome bit for bit with ",
            element("code", f"cortexc {next(iter(told.files))}"),
            "; its stream of random numbers is ",
            element("code", format_key(place.case.key)),
            ".",
        ),
        files,
        class_="again",
    )
