"""Where a run failed, on its page: heat maps of pairs of params, and a map of all simulations to explore."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cortex_dsl.page import run_charts
from cortex_dsl.page.document import part
from cortex_dsl.page.element import Element, Node, element
from cortex_dsl.page.heat import HeatMap, heat_maps
from cortex_dsl.report.numbers import fixed
from engine.search.evaluations import Evaluations
from engine.search.journal_reader import Record

DOTS = 12_000
"""Individuals that the map of all simulations shows at most."""


def dots(record: Record) -> dict[str, Any]:
    """All distinct simulations for the map, or as many as it takes: every collision, and every n-th of the others."""
    evaluations = record.evaluations
    rows = _shown(evaluations)
    kind = np.where(evaluations.collided, 2, np.where(evaluations.valid, 1, 0))[rows]
    values = evaluations.genomes[rows]
    return {
        "genes": [
            {"name": p.name, "unit": p.unit, "low": p.low, "high": p.high, "options": list(p.options)}
            for p in record.manifest.parameters
        ],
        "values": [[_short(value) for value in column] for column in values.T.tolist()],
        "kind": kind.tolist(),
        "score": evaluations.score[rows].tolist(),
        "place": evaluations.places[rows].tolist(),
    }


def _short(value: float) -> float:
    """To be drawn: four digits."""
    return float(f"{value:.4g}")


def _shown(evaluations: Evaluations) -> np.ndarray:
    rows = np.flatnonzero(evaluations.simulated)
    if len(rows) <= DOTS:
        return rows
    hit = rows[evaluations.collided[rows]][-DOTS // 2 :]
    others = np.setdiff1d(rows, hit)
    return np.sort(np.concatenate([hit, others[:: -(-len(others) // (DOTS - len(hit)))]]))


def where_it_fails(record: Record) -> Iterator[Node]:
    parameters = record.manifest.parameters
    maps = heat_maps(parameters, record.evaluations)
    if maps:
        key = element(
            "p",
            element("span", element("i", class_="none"), "none of those tried collide"),
            element("span", "few ", element("i", class_="ramp"), "all collide"),
            element("span", element("i", class_="blank"), "never tried"),
            class_="key",
        )
        note = (
            "Pairs of params, those first that tell the most about whether the ego collides (mutual information, with "
            "Miller's correction). The shade is the share of valid simulations in a cell that collided."
        )
        charts = [
            element(
                "figure",
                element(
                    "figcaption",
                    element("b", f"{chart.across.name} × {chart.up.name}"),
                    element("span", f"{fixed(chart.information, 2)} bit", class_="total"),
                ),
                run_charts.heat_chart(chart),
                class_="panel",
            )
            for chart in maps
        ]
        panels = element("div", charts, class_="panels")
        yield part("space", "Where it fails", note, key, panels, _explorer(record, maps[0]))


def _explorer(record: Record, best: HeatMap) -> Element:
    names = [p.name for p in record.manifest.parameters]

    def select(chosen: str, label: str) -> Element:
        options = [element("option", name, value=k, selected=name == chosen) for k, name in enumerate(names)]
        return element("label", f"{label} ", element("select", options))

    idle = "Point at a dot to read it."
    keys = (("--hot", "collision"), ("--safe-dot", "valid, no collision"), ("--invalid", "invalid"))
    return element(
        "div",
        element(
            "div",
            element("b", "Every simulation"),
            select(best.across.name, "across"),
            select(best.up.name, "up"),
            [
                element("span", element("i", style=f"background:var({colour})"), text, class_="dot-key")
                for colour, text in keys
            ],
            class_="choose",
        ),
        element("canvas", role="img", aria_label="a dot for each simulation, by two params"),
        element("p", idle, class_="tip", data_idle=idle),
        class_="explorer panel",
    )
