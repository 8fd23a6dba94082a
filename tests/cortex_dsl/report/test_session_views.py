"""The views of a session: they fit their console, and plain ones are plain."""

import io
from collections.abc import Callable
from pathlib import Path

import pytest
from rich.console import Console, RenderableType

from cortex_dsl import Scenario, load
from cortex_dsl.report.terminal.requirements_view import weighing_view
from cortex_dsl.report.terminal.sample_view import distribution_view, still_view
from cortex_dsl.report.terminal.theme import THEME
from engine.acceptance import account, weigh

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"
Draw = Callable[[Scenario, int, bool], RenderableType]


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load(LEFT_TURN)


def _weighed(scenario: Scenario, _width: int, ascii_only: bool) -> RenderableType:
    few, many = (weigh(scenario.program, count) for count in (100, 20_000))
    return weighing_view(few, account(many), {1}, ascii_only=ascii_only)


def _plotted(scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    return distribution_view(weigh(scenario.program, 20_000), 3, width, ascii_only=ascii_only)


def _still(scenario: Scenario, width: int, ascii_only: bool) -> RenderableType:
    from engine import batch
    from engine.road import build_network
    from engine.road.outline import outline

    scenes = scenario.sample(1, seed=2)
    assert scenes.valid[0]
    ways = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    road = outline(build_network(scenario.program.road_spec))
    return still_view(scenario.program, scenes, road, ways, "scene 1", width, ascii_only=ascii_only)


def shown(view: RenderableType, width: int) -> str:
    console = Console(file=io.StringIO(), theme=THEME, width=width, color_system=None, highlight=False, markup=False)
    console.print(view, soft_wrap=False)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


@pytest.mark.parametrize("draw", [_weighed, _plotted, _still])
@pytest.mark.parametrize("width", [60, 80, 120])
def test_views_fit(scenario: Scenario, draw: Draw, width: int) -> None:
    """No line is longer than the console is wide."""
    text = shown(draw(scenario, width, False), width)
    assert max(map(len, text.splitlines())) <= width
    assert len(text.splitlines()) > 4


def test_plain_views_of_draws_are_plain(scenario: Scenario) -> None:
    """Where a terminal has no block characters, nothing is drawn with them."""
    for draw in (_weighed, _plotted):
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
