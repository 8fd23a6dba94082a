"""How probable a collision is: estimates that lie beside a run's journal, or how to come by one."""

from shlex import quote

from cortex_dsl.page.document import part, table
from cortex_dsl.page.element import Element, element
from cortex_dsl.report.failures import (
    EXPOSURE,
    HOW,
    avoidable_interval_text,
    avoidable_text,
    counts_text,
    how_drawn,
    interval_text,
    probability_text,
)
from cortex_dsl.report.numbers import percent
from cortex_dsl.runs import OpenedRun
from engine.search.estimated import Probability
from engine.search.kept_probability import kept

NOTE = (
    "Given a valid run, when every param is drawn as the file says. What a search found tells nothing "
    f"of this: it goes where it has found danger. And {EXPOSURE}."
)
HEAD = ("a collision", "one a competent driver avoids", "how it is drawn", "from", "valid draws")


def likely(run: OpenedRun) -> Element:
    """The section of a run's page.

    Raises:
        StoreError: the estimates cannot be read.
    """
    found = kept(run.folder, run.scenario.program.digest)
    if found:
        return part("probability", "How probable is it?", NOTE, table(HEAD, [_row(each) for each in found], "likely"))
    command = element("pre", f"cortexc probability {quote(str(run.folder))}", class_="command")
    missing = element("p", "It has not been estimated yet; this does, and the next report shows it:", class_="note")
    return part("probability", "How probable is it?", NOTE, missing, command)


def _row(found: Probability) -> Element:
    level = percent(found.level, 0)
    return element(
        "tr",
        _number("th", probability_text(found), f"{level}: {interval_text(found)}"),
        _number("td", avoidable_text(found), f"{level}: {avoidable_interval_text(found)}"),
        element("td", how_drawn(found), element("br"), element("small", HOW[found.method], class_="quiet")),
        element("td", counts_text(found)),
        element("td", percent(found.valid_share), class_="number quiet"),
    )


def _number(tag: str, value: str, interval: str) -> Element:
    return element(tag, value, element("br"), element("small", interval, class_="quiet"), class_="number")
