"""How probable a collision is: estimates that lie beside a run's journal, or how to come by one."""

from shlex import quote

from cortex_dsl.page.element import Element, element
from cortex_dsl.page.understanding import part, table
from cortex_dsl.report.numbers import counted, percent
from cortex_dsl.report.probability_view import HOW, interval_text, probability_text
from cortex_dsl.runs import OpenedRun
from engine.search.kept_probability import kept
from engine.search.probability import Probability

NOTE = (
    "Of a collision, given a valid run, when every param is drawn as the file says. What a search found tells nothing "
    "of this: it goes where it has found danger."
)


def likely(run: OpenedRun) -> Element:
    """The section of a run's page.

    Raises:
        StoreError: the estimates cannot be read.
    """
    found = kept(run.folder, run.scenario.program.digest)
    if found:
        head = ("probability", "95 %", "by", "from", "valid draws")
        return part("probability", "How probable is it?", NOTE, table(head, [_row(each) for each in found], "likely"))
    command = element("pre", f"cortexc probability {quote(str(run.folder))}", class_="command")
    missing = element("p", "It has not been estimated yet; this does, and the next report shows it:", class_="note")
    return part("probability", "How probable is it?", NOTE, missing, command)


def _row(found: Probability) -> Element:
    return element(
        "tr",
        element("th", probability_text(found), scope="row"),
        element("td", interval_text(found), class_="number"),
        element("td", HOW[found.method]),
        element("td", f"{counted(found.collisions, 'collision')} in {counted(found.simulations, 'simulation')}"),
        element("td", percent(found.valid_share), class_="number quiet"),
    )
