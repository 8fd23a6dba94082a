"""Notebook output: scenes, runs and searches as SVG and HTML, by the same drawings as the pages.

    >>> scenario.show(scenario.sample(1))           # the actors at their start
    >>> scenario.replay(scenario.sample(1))         # a replay of its run
    >>> campaign = scenario.search("ga")
    >>> scenario.show(campaign)                     # results of a search
    >>> scenario.show(campaign.worst[0])            # a replay of one of its cases

Notebooks display the result, and its `save` writes it to a file.
"""

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from cortex_dsl.report.findings.case_replay import Runnable
from cortex_dsl.report.findings.framing import CARD, Frame, heading_of_road
from cortex_dsl.report.page import scene_svg
from cortex_dsl.report.page.markup import Element, element, picture, render
from engine.errors import ArgumentKindError, kind, path_of, row_of
from engine.program import Program
from engine.road import build_network
from engine.road.outline import outline
from engine.scenes import Scenes, actor_columns
from engine.search.campaign import Campaign
from engine.search.store import store_errors
from engine.tables import Floats
from engine.vocabulary import Column, State

HEIGHT = 640
"""Height of a page inside a notebook [px]."""


@dataclass(frozen=True)
class Shown:
    """Something to look at: markup for a notebook, and the text of a file."""

    html: str
    text: str

    def _repr_html_(self) -> str:
        return self.html

    def save(self, path: str | Path) -> Path:
        """Write it as a file of its own."""
        return _saved(path, self.text)


@dataclass(frozen=True)
class Picture:
    """A drawing: notebooks show it as SVG."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | Path) -> Path:
        """Write it as a file of its own."""
        return _saved(path, self.svg)


def _saved(path: str | Path, text: str) -> Path:
    place = path_of("path", path, "name a file")
    with store_errors(place):
        place.write_text(text, encoding="utf-8")
    return place


def show(scenario: Runnable, thing: Any, row: int = 0) -> Picture | Shown:
    """Return a picture of one scene, a page with a replay of a case, or a table of the results of a campaign.

    Raises:
        ArgumentKindError: it is nothing of these.
    """
    from engine.search.ranking import Case

    if isinstance(thing, Scenes):
        return Picture(picture(scene_drawing(scenario.program, thing, row_of(thing, row))))
    if isinstance(thing, Case):
        from cortex_dsl.report.findings.case_replay import replay_case
        from cortex_dsl.report.page.case_page import case_page

        return _framed(case_page(replay_case(scenario, scenario.scene(thing)), thing))
    if isinstance(thing, Campaign):
        html = render(campaign_table(thing))
        return Shown(html, html)
    raise ArgumentKindError(
        f"thing: expected scenes, a case or a campaign, got {type(thing).__name__}", "`sample` and `search` make them"
    )


def replay(scenario: Runnable, scenes: Scenes, row: int = 0) -> Shown:
    """One valid scene run in the world host, as a page that plays."""
    from cortex_dsl.report.findings.case_replay import replay_case
    from cortex_dsl.report.page.case_page import case_page
    from engine.assessment import take

    kind("scenes", scenes, Scenes, "`sample` draws some, `scene` is that of a case")
    row = row_of(scenes, row)
    return _framed(case_page(replay_case(scenario, take(scenes, slice(row, row + 1)))))


def _framed(page: str) -> Shown:
    """A page inside a notebook, apart from its styles and scripts."""
    frame = f'<iframe srcdoc="{escape(page)}" style="width:100%;height:{HEIGHT}px;border:0" loading="lazy"></iframe>'
    return Shown(frame, page)


def scene_drawing(program: Program, scenes: Scenes, row: int = 0) -> Element:
    """Draw the actors of a scene at its start; for an invalid scene, the road alone."""
    road = outline(build_network(program.road_spec))
    states, outlines = _start(program, scenes, row)
    names = zip(program.actors, program.code.actor_kind.tolist(), outlines.tolist(), strict=True)
    shapes = [scene_svg.Shape(name, scene_svg.ActorKind(kind), *size) for name, kind, size in names]
    there = states[states[:, State.PRESENT] > 0.5][:, [State.X, State.Y]]
    heading = heading_of_road(road, road.reach, states[:1])
    frame = Frame.around(there if len(there) else np.concatenate(road.kerbs), heading, CARD)
    return scene_svg.scene(
        frame,
        f"{program.name} from above",
        scene_svg.road_layer(road),
        element("g", scene_svg.actor_layer(shapes, states), class_="actors"),
    )


def _start(program: Program, scenes: Scenes, row: int) -> tuple[Floats, Floats]:
    """States (actors, len(State)) and outlines (actors, 2) at the start."""
    columns = actor_columns(program, scenes.values[row])
    states = np.zeros((len(program.actors), len(State)))
    states[:, [State.X, State.Y, State.HEADING, State.SPEED]] = columns[
        :, [Column.X, Column.Y, Column.HEADING, Column.SPEED]
    ]
    there = np.isfinite(columns[:, Column.X]) & (program.code.actor_present != 0)
    states[:, State.PRESENT] = there & bool(scenes.valid[row])
    return states, columns[:, [Column.LENGTH, Column.WIDTH]]


def campaign_table(campaign: Campaign) -> Element:
    """Return a table with the facts of a search."""
    return element("table", element("tbody", [_row(*row) for row in campaign.facts()]))


def _row(name: str, value: str) -> Element:
    return element("tr", element("th", name, style="text-align:left"), element("td", value))


def scenario_table(scenario: Runnable) -> Element:
    """Return a table of a scenario's name, its actors and its params, with one of its scenes."""
    space = scenario.program.space
    rows = [
        _row(name, ", ".join(options) if options else f"{low:g} to {high:g} {unit}")
        for name, unit, low, high, options in zip(
            space.names, space.units, space.low.tolist(), space.high.tolist(), space.options, strict=True
        )
    ]
    return element(
        "div",
        element("b", scenario.program.name),
        element("p", ", ".join(scenario.program.actors)),
        element("table", element("tbody", rows)),
    )
