"""What an actor sees, as a replay draws it in a real browser: by the definition of the kernels, and on request."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from cortex_dsl import load
from engine.kernels.geometry import View
from tests.cortex_dsl.report.page.conftest import scrub
from tests.engine.kernels.sight_reference import BORDER, Scene, by_rays, depth_inside, drawn, shadow
from tests.sight_polygon import visible_area, visible_sector

WALKER = """
map intersection(approach=120 m, lanes=2, buildings=6 m)
kerb = filter(lambda m: m.type is ManeuverType.STRAIGHT, network.lanes[0].maneuvers)[0]
middle = filter(lambda m: m.type is ManeuverType.STRAIGHT, network.lanes[1].maneuvers)[0]
ego = new Car before intersection by 80 m along middle, with speed 10 m/s,
    with behavior FollowTrajectoryBehavior(10 m/s, middle)
truck = new Truck before intersection by 45 m along kerb
walker = new Pedestrian ahead of truck by 1.5 m
terminate after 12 s
"""
"""A parked truck hides somebody in front of it until the ego is beside it."""
TO_JSON = "eye = { x: view[0], y: view[1], heading: view[2], angle: view[3], distance: view[4] }"
BOX = "box = ([x, y, heading, length, width]) => ({ x, y, heading, length, width })"


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("sight") / "walker.scn"
    path.write_text(WALKER, encoding="utf-8")
    return load(path)


@pytest.fixture(scope="module")
def walker_page(scenario: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scenario.replay(scenario.sample(1)).save(tmp_path_factory.mktemp("sight") / "walker.html")


@pytest.fixture
def shown(opened_tab: Callable[..., Any], walker_page: Path) -> Any:
    return opened_tab(walker_page)


def unseen(tab: Any) -> list[int]:
    """Actors that are drawn as hidden from the viewer."""
    return sorted(map(int, tab.eval_on_selector_all(".actors .unseen", "all => all.map((each) => each.dataset.actor)")))


def test_nothing_is_drawn_before_it_is_asked_for(shown: Any) -> None:
    """At first nobody's sight is shown."""
    assert shown.locator("g.sight").is_hidden()
    assert shown.locator(".chip[aria-pressed='true']").count() == 0


def test_a_truck_hides_a_walker_until_the_ego_is_beside_it(shown: Any) -> None:
    """The walker is faint while the truck's shadow covers it, and no longer when the ego has come near."""
    shown.locator(".chip", has_text="ego").click()
    scrub(shown, 0.0)
    assert shown.locator("g.sight .seen").is_visible()
    assert unseen(shown) == [2]
    seen_at = [share for share in np.linspace(0.0, 1.0, 41).tolist() if scrub(shown, share) or 2 not in unseen(shown)]
    assert 0.1 < min(seen_at) < 0.6


def test_v_shows_one_after_another_and_then_nobody(shown: Any) -> None:
    """The ego's sight, the truck's, the walker's, none."""
    shown.locator(".player").focus()
    pressed = []
    for _ in range(5):
        shown.keyboard.press("v")
        pressed.append(shown.eval_on_selector_all(".chip[aria-pressed='true']", "all => all.map((c) => c.innerText)"))
    assert pressed == [["ego"], ["truck"], ["walker"], [], ["ego"]]
    shown.locator(".see").click()
    assert shown.locator(".chip[aria-pressed='true']").inner_text() == "truck"
    shown.locator(".chip", has_text="truck").click()
    assert shown.locator("g.sight").is_hidden()


def test_who_is_told_to_see_sees_and_the_others_do_not(shown: Any) -> None:
    """Verdicts are those of one ray in each interval of directions, but where less than 1e-9 rad remains."""
    random = np.random.default_rng(11)
    scenes = [drawn(random, int(random.integers(0, 9)), grid=bool(k % 2)) for k in range(300)]
    sees = f"""(scenes) => scenes.map(([view, target, shades]) => {{
        const {TO_JSON}, {BOX};
        return seesBox(eye, box(target), shades.map(box));
    }})"""
    verdicts = shown.evaluate(sees, plain(scenes))
    assert 50 < sum(verdicts) < 250
    for verdict, scene in zip(verdicts, scenes, strict=True):
        seen = by_rays(scene).seen
        assert verdict == (seen > BORDER) or 0.0 < seen < 1e-6, scene


def test_the_area_is_the_sector_without_shadows(shown: Any) -> None:
    """It differs from what polygons of shadows leave of the sector by no more than the straight pieces of its rim."""
    random = np.random.default_rng(12)
    scenes = [drawn(random, int(random.integers(0, 9)), grid=bool(k % 2)) for k in range(300)]
    area = f"""(scenes) => scenes.map(([view, , shades]) => {{
        const {TO_JSON}, {BOX};
        return visibleArea(eye, shades.map(box));
    }})"""
    nothing = 0
    for points, scene in zip(shown.evaluate(area, plain(scenes)), scenes, strict=True):
        reference = area_of(scene)
        nothing += reference.is_empty
        sector = 0.5 * scene.view.angle * scene.view.distance**2
        assert polygon(points).symmetric_difference(reference).area <= 6e-4 * sector + 1e-6, scene
    assert 0 < nothing < 150


def test_the_area_is_that_of_python(shown: Any) -> None:
    """`sight_polygon` draws the same: they differ by straight pieces of the rim at most, also on a grid, where outlines
    overlap, and touch one another and the eye.
    """
    random = np.random.default_rng(13)
    scenes = [drawn(random, int(random.integers(1, 9)), grid=bool(k % 2)) for k in range(200)]
    area = f"""(scenes) => scenes.map(([view, , shades]) => {{
        const {TO_JSON}, {BOX};
        return visibleArea(eye, shades.map(box));
    }})"""
    for points, scene in zip(shown.evaluate(area, plain(scenes)), scenes, strict=True):
        reference = polygon(visible_sector(scene.view, np.array(scene.shades)))
        rim_pieces = 6e-4 * 0.5 * scene.view.angle * scene.view.distance**2
        assert polygon(points).symmetric_difference(reference).area <= rim_pieces + 1e-6, scene


def test_what_is_drawn_is_what_the_actor_sees(shown: Any, scenario: Any) -> None:
    """At samples of the run the shaded area is the actor's, buildings and all, up to poses rounded for the page."""
    scenes = scenario.sample(1)
    states = scenario.watch(scenes).trajectory.states
    assert len(scenario.program.road.buildings) > 0
    for actor in (0, 2):
        shown.locator(".chip").nth(actor).click()
        for sample in (0, 40, len(states) - 1):
            scrub(shown, sample / (len(states) - 1))
            path = shown.locator("g.sight .seen").get_attribute("d")
            points = [tuple(map(float, point.split())) for point in path.strip("MZ").split("L")]
            truth = polygon(visible_area(scenario.program, scenes.values[0], states[sample], actor))
            assert truth.area > 100.0
            assert polygon(points).symmetric_difference(truth).area < 0.005 * truth.area


def polygon(points: Any) -> Any:
    return shapely.Polygon(points).buffer(0.0) if len(points) > 2 else shapely.Polygon()


def plain(scenes: list[Scene]) -> list[Any]:
    return [[list(scene.view), list(scene.target), [list(box) for box in scene.shades]] for scene in scenes]


def area_of(scene: Scene) -> Any:
    """What polygons of shadows leave of the sector."""
    view = scene.view
    if view.distance == 0.0 or any(depth_inside(box, view.x, view.y) > 1e-9 for box in scene.shades):
        return shapely.Polygon()
    left = shapely.Polygon(rim(view)).buffer(0.0)
    for box in scene.shades:
        left = left.difference(shadow(view, box))
    return left


def rim(view: View) -> list[tuple[float, float]]:
    turns = view.heading + np.linspace(-0.5, 0.5, 2000) * view.angle
    points = [(view.x + view.distance * math.cos(turn), view.y + view.distance * math.sin(turn)) for turn in turns]
    return points if view.angle >= math.tau else [(view.x, view.y), *points]
