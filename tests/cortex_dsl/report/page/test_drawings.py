"""Drawings, charts and heat maps: what they show is where the numbers say."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import load
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.report.findings.analysis_report import heat_maps, information
from cortex_dsl.report.findings.case_replay import replay_case
from cortex_dsl.report.page import film
from cortex_dsl.report.page.charts import Box, Course, box_chart, line_chart, nice_ticks
from cortex_dsl.report.page.film import DASH, GAP, dashes
from cortex_dsl.report.page.player import packed, player
from cortex_dsl.report.page.scene_svg import OVERVIEW, overview, road_layer
from engine.search.statistics import clopper_pearson
from engine.vocabulary import Column

LEFT_TURN = Path(__file__).parents[4] / "examples" / "left_turn.scn"
VILLAGE = LEFT_TURN.parent / "roads" / "village.scn"
NUMBERS = st.floats(-1e6, 1e6)


@pytest.mark.parametrize(("path", "count"), [(VILLAGE, 1), (LEFT_TURN, 0)])
def test_an_overview_shows_where_in_a_town_a_case_is(path: Path, count: int) -> None:
    """With a ring that lies in it; a map that is drawn whole has none."""
    scenario = load(path)
    replay = replay_case(scenario, scenario.sample(1, seed=2))
    text = str(player(replay, 0))
    assert text.count('class="overview"') == count
    if replay.town is not None:
        ring = ET.fromstring(str(overview(replay.town, replay.trajectory.states[0, 0, :2].tolist()))).find(
            ".//{*}circle"
        )
        assert ring is not None
        assert all(0.0 < float(ring.get(name, "")) < OVERVIEW for name in ("cx", "cy"))
        assert len(replay.road.center_lines) <= len(replay.town.center_lines)


@given(st.lists(st.none() | st.floats(-1e4, 1e4), max_size=50))
def test_packed_series_come_back(values: list[float | None]) -> None:
    """Adding up the differences gives each number to half a unit; gaps stay gaps."""
    steps = packed(np.array([np.nan if v is None else v for v in values]), 100.0)
    total = 0
    for value, step in zip(values, steps, strict=True):
        assert (value is None) == (step is None)
        if step is not None:
            total += step
            assert total / 100.0 == pytest.approx(value, abs=0.0051)


@given(NUMBERS, NUMBERS)
def test_ticks_enclose(first: float, second: float) -> None:
    """Ticks ascend, are few, and enclose what they were made for."""
    low, high = sorted((first, second))
    if high - low < 1e-6:
        return
    ticks = list(nice_ticks(low, high))
    assert ticks == sorted(set(ticks))
    assert len(ticks) <= 7
    assert ticks[0] <= low + 1e-6 * (high - low)
    assert ticks[-1] >= high - 1e-6 * (high - low)


def test_a_line_breaks_where_there_is_no_number() -> None:
    """A course with a gap is two lines."""
    y = np.array([1.0, 2.0, np.nan, 3.0, 4.0])
    text = str(line_chart([Course("a", "first", np.arange(5.0), y)], "title"))
    assert text.count("<polyline") == 2
    assert "nan" not in text


def test_charts_of_nothing_are_charts() -> None:
    """No numbers, one number, equal numbers: still a well-formed picture."""
    for values in (np.zeros(0), np.ones(1), np.full(4, np.nan), np.full(4, 2.0)):
        x = np.arange(len(values), dtype=np.float64)
        ET.fromstring(str(line_chart([Course("a", "first", x, values)], "t")))
        ET.fromstring(str(box_chart([Box("a", "first", values)], "t", stars=[(0, 0, "*")])))


def test_information_of_what_says_nothing_and_everything() -> None:
    """Cells that fail alike tell nothing; cells that always or never fail tell all, here one bit."""
    even = np.full((4, 4), 100)
    assert information(even, even // 2) == 0.0
    half = np.zeros((4, 4), dtype=int)
    half[:2] = 100
    assert information(even, half) == pytest.approx(1.0, abs=0.01)
    assert information(np.zeros((3, 3), dtype=int), np.zeros((3, 3), dtype=int)) == 0.0


def test_heat_maps_count_every_valid_simulation(opened: OpenedRun) -> None:
    """No simulation falls out of the cells, and those that tell more come first."""
    evaluations = opened.record.evaluations
    maps = heat_maps(opened.record.manifest.parameters, evaluations)
    rows = evaluations.valid & evaluations.simulated
    assert len(maps) == 3
    assert [found.information for found in maps] == sorted((found.information for found in maps), reverse=True)
    for found in maps:
        assert found.tried.sum() == rows.sum()
        assert found.failed.sum() == (rows & evaluations.collided).sum()


@pytest.mark.parametrize(
    ("hits", "tries", "low", "high"), [(0, 10, 0.0, 0.3085), (5, 10, 0.1871, 0.8129), (10, 10, 0.6915, 1.0)]
)
def test_interval_of_a_share(hits: int, tries: int, low: float, high: float) -> None:
    """As tabulated by Clopper and Pearson."""
    assert clopper_pearson(hits, tries) == pytest.approx((low, high), abs=1e-4)


def shown(display: object, form: str) -> str:
    """Return what a notebook gets of a display, in one of its forms."""
    return getattr(display, form)()


def test_asphalt_of_lanes_that_follow_each_other_overlaps() -> None:
    """By a few centimetres at each end, as at their sides: smoothed edges side by side let the ground through."""
    scenario = load(VILLAGE)
    road = replay_case(scenario, scenario.sample(1, seed=2)).road
    strips = ET.fromstring(str(road_layer(road))).findall(".//{*}polyline[@class='asphalt']")
    drawn = [np.array([point.split(",") for point in strip.get("points", "").split()], float) for strip in strips]
    assert len(drawn) == len(road.center_lines)
    for points, line, width, strip in zip(drawn, road.center_lines, road.widths, strips, strict=True):
        more = np.hypot(*np.diff(points, axis=0).T).sum() - np.hypot(*np.diff(line, axis=0).T).sum()
        assert more == pytest.approx(float(strip.get("stroke-width", "")) - width, abs=0.05)
        assert np.abs(points[0] - line[0]).max() < 0.1


def test_scene_shows_everybody_where_they_start() -> None:
    """The picture of a scene is an SVG of its own, with each actor at its place."""
    scenario = load(LEFT_TURN)
    scenes = scenario.sample(5, seed=1)
    row = int(scenes.valid.argmax())
    svg = shown(scenario.show(scenes, row), "_repr_svg_")
    ET.fromstring(svg)
    places = re.findall(r'data-actor="(\d)" transform="translate\((\S+) (\S+)\)', svg)
    assert {actor for actor, _, _ in places} == {"0", "1"}
    for actor, x, y in places:
        block = scenes.values[row][int(actor) * len(Column) :]
        assert (float(x), float(y)) == pytest.approx((block[0], block[1]), abs=1e-3)


def test_notebooks_show_searches_and_runs() -> None:
    """A scenario, a campaign, a case and a run have a form for notebooks; anything else is refused."""
    scenario = load(LEFT_TURN)
    campaign = scenario.search("random", generations=1, population=20)
    assert "EGO_SPEED" in scenario._repr_html_()
    assert f"{campaign.by_individual.nis:,}" in shown(scenario.show(campaign), "_repr_html_")
    assert "srcdoc" in shown(scenario.show(campaign.worst[0]), "_repr_html_")
    scenes = scenario.sample(5, seed=1)
    assert "data-replay" in scenario.replay(scenes, int(scenes.valid.argmax())).text
    with pytest.raises(TypeError, match="got int"):
        scenario.show(3)  # type: ignore[arg-type]


def test_a_broken_line_of_a_film_is_painted_as_the_page_paints_it() -> None:
    """Pieces of `drawing.css`'s length and gap along the line, round its bends too."""
    bend = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 9.0]])
    pieces = list(dashes(bend))
    assert [float(np.hypot(*np.diff(piece, axis=0).T).sum()) for piece in pieces] == pytest.approx([DASH, DASH, DASH])
    assert pieces[0].tolist() == [[0.0, 0.0], [1.0, 0.0], [1.0, pytest.approx(DASH - 1.0)]]
    assert pieces[1][0].tolist() == [1.0, pytest.approx(DASH + GAP - 1.0)]
    css = (Path(film.__file__).with_name("drawing.css")).read_text(encoding="utf-8")
    assert f"stroke-dasharray: {DASH} {GAP};" in css.partition(".road .lane-line")[2].partition("}")[0]
