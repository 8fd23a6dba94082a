"""The views of a session: they fit their console, and plain ones are plain."""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console, RenderableType

from cortex_dsl import Scenario, load
from cortex_dsl.report.findings.cases_found import cases_found, kinds_of_cases
from cortex_dsl.report.findings.plotted import Plotted, Shown
from cortex_dsl.report.terminal.plot_view import distribution_view, scatter_view, values_view
from cortex_dsl.report.terminal.render import parts, rendered
from cortex_dsl.report.terminal.still_view import still_view
from cortex_dsl.report.terminal.theme import THEME
from cortex_dsl.report.views.requirements import weighing_view
from cortex_dsl.report.views.search import worst_cases_table
from engine.acceptance import account, measure_acceptance
from engine.search.ranking import worst_cases
from engine.vocabulary import Blame

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"
Draw = Callable[[Scenario, int, bool], RenderableType]


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load(LEFT_TURN)


def _weighed(scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    few, many = (measure_acceptance(scenario.program, count) for count in (100, 20_000))
    line, below = weighing_view(few, account(many), {1})
    return parts([line, *below], width, ascii_only=ascii_only)


def _plotted(scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    return distribution_view(measure_acceptance(scenario.program, 20_000), 3, width, ascii_only=ascii_only)


def _still(scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    from engine import batch
    from engine.road import build_network
    from engine.road.outline import outline

    scenes = scenario.sample(1, seed=2)
    assert scenes.valid[0]
    ways = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    road = outline(build_network(scenario.program.road_spec))
    return still_view(scenario.program, scenes, road, ways, "scene 1", width, ascii_only=ascii_only)


def _shown(*things: Plotted) -> Shown:
    count = len(things[0].values)
    return Shown(things, np.arange(count) % 5 == 0, ran=True, over_run=True, seed=3)


def _spread(_scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    values = np.append(np.linspace(0.0, 30.0, 399) ** 2, np.nan)
    return values_view(_shown(Plotted("delta_v", "km/h", values)), width, ascii_only=ascii_only)


def _truth(_scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    thing = Plotted("x > 3 m", "", np.arange(400.0) % 2, ("does not hold", "holds"))
    return values_view(_shown(thing), width, ascii_only=ascii_only)


def _scattered(_scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    across = np.linspace(-1e6, 1e6, 400)
    up = Plotted("lane", "", np.arange(400.0) % 3, ("a", "b", "c"))
    return scatter_view(_shown(Plotted("x", "m", across), up), width, ascii_only=ascii_only)


def _worst(scenario: Scenario, width: int, _ascii_only: bool) -> RenderableType:
    campaign = scenario.search("random", generations=1, population=60)
    (table,) = worst_cases_table(scenario.program, campaign, cases_found(scenario, campaign), note="note")
    return rendered(table, width, depth=1)


def shown(view: RenderableType, width: int) -> str:
    console = Console(file=io.StringIO(), theme=THEME, width=width, color_system=None, highlight=False, markup=False)
    console.print(view, soft_wrap=False)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


@pytest.mark.parametrize("draw", [_weighed, _plotted, _still, _spread, _truth, _scattered, _worst])
@pytest.mark.parametrize("width", [60, 80, 120])
def test_views_fit(scenario: Scenario, draw: Draw, width: int) -> None:
    """No line is longer than the console is wide."""
    text = shown(draw(scenario, width, False), width)
    assert max(map(len, text.splitlines())) <= width
    assert len(text.splitlines()) > 4


def test_plain_views_of_draws_are_plain(scenario: Scenario) -> None:
    """Where a terminal has no block characters, nothing is drawn with them."""
    for draw in (_weighed, _plotted, _spread, _truth, _scattered):
        assert shown(draw(scenario, 80, True), 80).isascii()


def test_what_a_weighing_says(scenario: Scenario) -> None:
    """Before and after, the requirement that is new, and what is left of the params."""
    text = shown(_weighed(scenario, 100, False), 100)
    assert " → " in text
    assert "adversary starts where it should" in text
    assert "left of" in text


def test_a_still_names_everybody(scenario: Scenario) -> None:
    """With speeds as they are at the start."""
    text = shown(_still(scenario, 120, False), 120)
    assert "ego" in text
    assert "adversary" in text
    assert text.count("km/h") >= 4


def test_what_a_plot_says(scenario: Scenario) -> None:
    """The middle of the values, those that are missing, who collided, and how two things go together."""
    text = shown(_spread(scenario, 80, False), 80)
    assert "median 225" in text
    assert "80 of 400 collided" in text
    assert "1 run without such a number" in text
    lanes = shown(values_view(_shown(Plotted("lanes", "", np.arange(400.0) % 7)), 80), 80)
    assert "median 3, nine tenths in 0 .. 6" in lanes
    assert "of them collide" in shown(_truth(scenario, 80, False), 80)
    text = shown(_scattered(scenario, 80, False), 80)
    assert "rank correlation +0.00" in text
    assert "×" in text


def test_a_plot_of_what_is_always_the_same(scenario: Scenario) -> None:
    """One value, none at all, and no scene."""
    same, never = (Plotted("x", "m", np.full(5, value)) for value in (2.5, np.inf))
    assert "always 2.5 m" in shown(values_view(_shown(same), 80), 80)
    assert "5 runs without such a number" in shown(values_view(_shown(never), 80), 80)
    assert "no scene has both" in shown(scatter_view(_shown(same, never), 80), 80)
    assert "rank correlation none" in shown(scatter_view(_shown(same, same), 80), 80)
    nothing = Shown((Plotted("x", "m", np.zeros(0)),), np.zeros(0, dtype=bool), ran=True, over_run=False, seed=0)
    assert "no scene is accepted" in shown(values_view(nothing, 80), 80)


def test_avoidable_kinds_come_first(scenario: Scenario) -> None:
    """As the headline counts them first; within both groups the order is that of the cases."""
    campaign = scenario.search("random", generations=1, population=400)
    kinds = kinds_of_cases(campaign.evaluations, campaign.blame, campaign.kinds, worst_cases(campaign.evaluations, 400))
    avoidable = [found.kind.blame == Blame.AVOIDABLE for found, _ in kinds]
    assert avoidable == sorted(avoidable, reverse=True)
    assert len(set(avoidable)) == 2
    for group in (True, False):
        ranks = [case.rank for (_, case), each in zip(kinds, avoidable, strict=True) if each == group]
        assert ranks == sorted(ranks)
