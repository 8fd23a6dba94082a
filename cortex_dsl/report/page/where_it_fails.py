"""Where a search failed: heat maps of pairs of params, and a map of all simulations to explore."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from cortex_dsl.report.findings.analysis_report import HeatMap, heat_maps
from cortex_dsl.report.findings.failures import LOST, Finds, finds_of
from cortex_dsl.report.findings.readable import fixed
from cortex_dsl.report.page import run_charts
from cortex_dsl.report.page.markup import Element, Node, element, part
from engine.search.evaluations import Evaluations
from engine.search.journal_reader import Record
from engine.tables import Ints
from engine.vocabulary import Verdict

DOTS = 12_000
"""Individuals that the map of all simulations shows at most."""
INVALID, VALID, LOSS, FIND = range(4)
"""Kinds of dots, in the order in which they are drawn."""


class Dot(NamedTuple):
    """A kind of dot."""

    colour: str
    """Colour variable of the stylesheet."""
    key: str
    """Name in the plural."""
    words: str
    """Name in the singular, before the risk."""


def _dots_of(finds: Finds) -> tuple[Dot, ...]:
    return (
        Dot("--invalid", "invalid", "invalid"),
        Dot("--safe-dot", "other valid ones", ""),
        Dot("--warn", LOST, LOST),
        Dot("--hot", finds.many, finds.one),
    )


def dots(record: Record) -> dict[str, Any]:
    """Return all distinct simulations for the map, or a subset that fits.

    A subset holds finds, at most half of it, and every n-th of the remaining simulations.
    """
    evaluations = record.evaluations
    rows = _shown(evaluations)
    values = evaluations.genomes[rows]
    return {
        "genes": [
            {"name": p.name, "unit": p.unit, "low": p.low, "high": p.high, "options": list(p.options)}
            for p in record.manifest.parameters
        ],
        "values": [[float(f"{value:.4g}") for value in column] for column in values.T.tolist()],
        "kinds": [dot._asdict() for dot in _dots_of(finds_of(record.manifest.objective))],
        "kind": _kinds(evaluations)[rows].tolist(),
        "score": evaluations.score[rows].tolist(),
        "place": evaluations.places[rows].tolist(),
    }


def _kinds(evaluations: Evaluations) -> Ints:
    """Return the kind (n,) of each individual."""
    lost = evaluations.verdict == Verdict.CONTROLLER
    return np.select([evaluations.found, lost, evaluations.valid], [FIND, LOSS, VALID], INVALID)


def _shown(evaluations: Evaluations) -> np.ndarray:
    rows = np.flatnonzero(evaluations.simulated)
    if len(rows) <= DOTS:
        return rows
    hit = rows[evaluations.found[rows]][-DOTS // 2 :]
    others = np.setdiff1d(rows, hit)
    return np.sort(np.concatenate([hit, others[:: -(-len(others) // (DOTS - len(hit)))]]))


def section(record: Record) -> Iterator[Node]:
    """The section of a run's page; none where no pair of params can be shown."""
    parameters = record.manifest.parameters
    maps, finds = heat_maps(parameters, record.evaluations), finds_of(record.manifest.objective)
    if maps:
        key = element(
            "p",
            element("span", element("i", class_="none"), f"none of those tried {finds.verb}"),
            element("span", "few ", element("i", class_="ramp"), f"all {finds.verb}"),
            element("span", element("i", class_="blank"), "never tried"),
            class_="key",
        )
        note = (
            f"Pairs of params, the most informative about which simulations {finds.verb} first (mutual information, "
            f"with Miller's correction). The shade is the share of the {finds.among} simulations in a cell that "
            f"{finds.verb}."
        )
        charts = [
            element(
                "figure",
                element(
                    "figcaption",
                    element("b", f"{chart.across.name} × {chart.up.name}"),
                    element("span", f"{fixed(chart.information, 2)} bit", class_="total"),
                ),
                run_charts.heat_chart(chart, finds.verb),
                class_="panel",
            )
            for chart in maps
        ]
        panels = element("div", charts, class_="panels")
        yield part("space", "Where it fails", note, key, panels, _explorer(record, maps[0], finds))


def _explorer(record: Record, best: HeatMap, finds: Finds) -> Element:
    names = [p.name for p in record.manifest.parameters]

    def select(chosen: str, label: str) -> Element:
        options = [element("option", name, value=k, selected=name == chosen) for k, name in enumerate(names)]
        return element("label", f"{label} ", element("select", options))

    shown, every = len(_shown(record.evaluations)), int(record.evaluations.simulated.sum())
    title = "Every simulation" if shown == every else f"{shown:,} of {every:,} simulations"
    idle = "Point at a dot to read it."
    there = set(_kinds(record.evaluations).tolist()) | {FIND, VALID, INVALID}
    keys = [dot for kind, dot in enumerate(_dots_of(finds)) if kind in there]
    return element(
        "div",
        element(
            "div",
            element("b", title),
            select(best.across.name, "across"),
            select(best.up.name, "up"),
            [
                element("span", element("i", style=f"background:var({dot.colour})"), dot.key, class_="dot-key")
                for dot in reversed(keys)
            ],
            class_="choose",
        ),
        element("canvas", role="img", aria_label="a dot for each simulation, by two params"),
        element("p", idle, class_="tip", data_idle=idle),
        class_="explorer panel",
    )
