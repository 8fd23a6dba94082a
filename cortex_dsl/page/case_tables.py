"""The tables of one case on a page: its risk with the parts, and its params."""

from math import isfinite

from cortex_dsl.page.case import ToldCase
from cortex_dsl.page.element import Element, Node, element
from cortex_dsl.report.numbers import fixed, format_gene, significant
from cortex_dsl.report.run_document import PARTS
from engine.vocabulary import GeneKind

PART_MEANINGS = {
    "C": "contact",
    "MD": "least distance between outlines",
    "D_MS": "distance at fastest closing",
    "TTC_MS": "time to collision at fastest closing",
}


def risk_table(told: ToldCase) -> Element:
    rows = [
        element(
            "tr",
            element("th", name, scope="row"),
            element("td", PART_MEANINGS[name]),
            element("td", _measured(told, name), class_="number"),
            element("td", element("div", class_=f"gauge part-{name}", style=f"--share:{100 * points / most:.0f}%")),
            element("td", f"{points} of {most}", class_="number"),
        )
        for (name, most, _), points in zip(PARTS, told.parts, strict=True)
    ]
    return element("table", element("tbody", rows), class_="risk")


def _measured(told: ToldCase, name: str) -> str:
    outcomes, pair = told.outcomes, told.pair
    if name == "C":
        return "yes" if bool(outcomes.collided[0]) else "no"
    if not outcomes.min_distance.shape[1]:
        return "–"
    array, unit = {
        "MD": (outcomes.min_distance, "m"),
        "D_MS": (outcomes.distance_at_ms, "m"),
        "TTC_MS": (outcomes.ttc_at_ms, "s"),
    }[name]
    return f"{fixed(float(array[0, pair]), 2)} {unit}"


def pairs_table(told: ToldCase) -> Node:
    """How near the ego came to everybody else than the one who decides the risk."""
    outcomes = told.outcomes
    rows = [
        element(
            "tr",
            element("th", told.program.actors[pair + 1], scope="row"),
            element("td", f"{fixed(float(outcomes.min_distance[0, pair]), 2)} m", class_="number"),
            element("td", f"at {fixed(float(outcomes.min_distance_time[0, pair]), 2)} s", class_="quiet"),
        )
        for pair in range(outcomes.min_distance.shape[1])
        if pair != told.pair and isfinite(outcomes.min_distance[0, pair])
    ]
    if not rows:
        return None
    return [element("h4", "Nearest to the others"), element("table", element("tbody", rows), class_="params")]


def params_table(told: ToldCase) -> Element:
    space, genome = told.program.space, told.scenes.genomes[0]
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
        for one in told.held
    ]
    choices = [
        element("tr", element("th", choice.name, scope="row"), element("td", choice.option, colspan=3))
        for choice in told.program.variants[int(told.scenes.variant[0])].choices
    ]
    return element("table", element("tbody", rows, held, choices), class_="params")
