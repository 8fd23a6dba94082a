"""What a replay shows of the world, in a real browser: turned, in close-up, with an arrow and a bar that are true."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cortex_dsl import load
from cortex_dsl.report.findings.framing import Frame
from tests.cortex_dsl.report.page.conftest import scrub

NORTH = """
map intersection(approach=200 m)
way = filter(lambda m: m.type is ManeuverType.STRAIGHT, network.lanes[0].maneuvers)[0]
ego = new Car before intersection by 180 m along way, with speed 20 m/s,
    with behavior FollowTrajectoryBehavior(20 m/s, way)
slow = new Truck before intersection by 110 m along way, with speed 8 m/s,
    with behavior FollowTrajectoryBehavior(8 m/s, way)
terminate after 20 s
"""
"""A road that runs from north to south."""
ON_SCREEN = """() => {
    const svg = document.querySelector("svg.scene"), stage = svg.getBoundingClientRect();
    const turn = (node, x, y) => {
        const m = node.getScreenCTM();
        return [m.a * x + m.c * y, m.b * x + m.d * y];
    };
    const [world, needle, bar] = [".world", ".needle", ".bar"].map((name) => svg.querySelector(name));
    const length = bar.getBoundingClientRect().width / Math.hypot(...turn(world, 1, 0));
    const box = svg.querySelector(".compass").getBoundingClientRect();
    const places = [...svg.querySelectorAll(".actors .actor")].map((node) => {
        const m = node.getScreenCTM();
        return [Number(node.dataset.actor), (m.e - stage.left) / stage.width, (m.f - stage.top) / stage.height];
    });
    return {
        north: turn(world, 0, 1), east: turn(world, 1, 0), arrow: turn(needle, 0, -1),
        bar: [length, parseFloat(svg.querySelector(".length").textContent)],
        pixels: bar.getBoundingClientRect().width,
        inside: box.left >= stage.left && box.bottom <= stage.bottom && box.width < stage.width,
        places: places.sort((a, b) => a[0] - b[0]).map((place) => place.slice(1)),
    };
}"""
"""What a ruler and a protractor on the screen would say, places of actors as shares of the stage."""


@pytest.fixture(scope="module")
def road_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("camera")
    (home / "north.scn").write_text(NORTH, encoding="utf-8")
    scenario = load(home / "north.scn")
    return scenario.replay(scenario.sample(1)).save(home / "north.html")


@pytest.fixture(params=[1280, 360])
def shown(opened_tab: Callable[..., Any], road_page: Path, request: pytest.FixtureRequest) -> Any:
    """The replay, in a wide and in a narrow window."""
    return opened_tab(road_page, request.param, 800)


def test_the_ego_drives_from_left_to_right(shown: Any) -> None:
    """Its road lies level, and from its first to its last place it crosses most of the stage."""
    scrub(shown, 0.0)
    start = shown.evaluate(ON_SCREEN)["places"][0]
    scrub(shown, 1.0)
    end = shown.evaluate(ON_SCREEN)["places"][0]
    assert end[0] - start[0] > 0.7
    assert end[1] == pytest.approx(start[1], abs=0.02)


def test_all_is_shown_at_all_times(shown: Any) -> None:
    """Without close-up nobody leaves the stage."""
    for share in np.linspace(0.0, 1.0, 9).tolist():
        scrub(shown, share)
        assert all(0.0 < part < 1.0 for place in shown.evaluate(ON_SCREEN)["places"] for part in place)


def is_honest(seen: dict[str, Any]) -> None:
    """The arrow points where the world's north is, and the bar is as long as it says."""
    north, arrow = (np.array(seen[name]) / np.hypot(*seen[name]) for name in ("north", "arrow"))
    assert arrow == pytest.approx(north, abs=1e-3)
    assert np.cross(np.array([*seen["east"], 0.0]), np.array([*seen["north"], 0.0]))[2] < 0.0  # no mirror image
    assert seen["bar"][0] == pytest.approx(seen["bar"][1], rel=0.03)
    assert 20.0 < seen["pixels"] < 145.0
    assert seen["inside"]


def test_arrow_and_bar_are_true_in_every_view(shown: Any) -> None:
    """In the whole picture, in close-up, and after the window has another size."""
    is_honest(shown.evaluate(ON_SCREEN))
    shown.locator(".zoom").click()
    is_honest(shown.evaluate(ON_SCREEN))
    shown.set_viewport_size({"width": 700, "height": 600})
    shown.wait_for_timeout(100)
    is_honest(shown.evaluate(ON_SCREEN))
    shown.locator(".zoom").click()
    is_honest(shown.evaluate(ON_SCREEN))


def test_close_up_follows_the_ego(shown: Any) -> None:
    """It stays in the middle half, several times as large as in the whole picture; the button leads back."""
    whole = shown.evaluate(ON_SCREEN)
    shown.locator(".zoom").click()
    assert np.hypot(*shown.evaluate(ON_SCREEN)["east"]) > 1.5 * np.hypot(*whole["east"])
    for share in np.linspace(0.0, 1.0, 9).tolist():
        scrub(shown, share)
        assert all(0.249 < part < 0.751 for part in shown.evaluate(ON_SCREEN)["places"][0])
    shown.locator(".zoom").click()
    assert shown.evaluate(ON_SCREEN)["east"] == pytest.approx(whole["east"], rel=1e-3)


# -- the functions -----------------------------------------------------------------------------------------------------


def test_places_of_the_page_are_those_of_python(shown: Any) -> None:
    """A place of the world lies where `Frame.turned` says, with y pointing down."""
    random = np.random.default_rng(3)
    for heading in random.uniform(-4.0, 4.0, 5).tolist():
        places = random.uniform(-300.0, 300.0, (20, 2))
        found = shown.evaluate("([places, h]) => places.map((p) => toPicture(p, h))", [places.tolist(), heading])
        assert np.array(found) * (1, -1) == pytest.approx(Frame.around(places, heading).turned(places), abs=1e-9)


def test_bars_of_the_page_are_those_of_python(shown: Any) -> None:
    """Both choose one length for what a pixel shows."""
    frames = [Frame(0.0, 0.0, 3.0 * height, height) for height in np.geomspace(24.0, 3000.0, 60).tolist()]
    found = shown.evaluate("(pixels) => pixels.map(barLength)", [frame.pixel for frame in frames])
    assert found == [frame.bar for frame in frames]


def test_a_box_is_fitted_to_the_stage(shown: Any) -> None:
    """It has the stage's shape, holds what was to be shown in its middle, and touches it on two sides."""
    for box in ([-3.0, 4.0, 60.0, 20.0], [0.0, 0.0, 10.0, 90.0]):
        for shape in (0.5, 1.5, 3.0, 6.0):
            left, top, width, height = shown.evaluate("([box, shape]) => fitted(box, shape)", [box, shape])
            assert width / height == pytest.approx(shape)
            assert (left + width / 2, top + height / 2) == pytest.approx((box[0] + box[2] / 2, box[1] + box[3] / 2))
            assert min(width - box[2], height - box[3]) == pytest.approx(0.0, abs=1e-9)
            assert width >= box[2] - 1e-9
            assert height >= box[3] - 1e-9


def test_the_close_up_never_jumps(shown: Any) -> None:
    """Whoever passes by, the middle moves less than six times as far as anybody did, and the ego is well inside."""
    passing = """() => {
        const boxes = [];
        for (let x = -60; x <= 60; x += 0.1)
            boxes.push(closeUpOf([0, 0], [[x, 3], [2 * x, -4], [30, x]], [-200, -70, 400, 140], 3));
        return boxes;
    }"""
    boxes = np.array(shown.evaluate(passing))
    assert np.abs(np.diff(boxes, axis=0)).max() < 6.0 * 0.2
    shares = -boxes[:, :2] / boxes[:, 2:]
    assert ((shares > 0.2499) & (shares < 0.7501)).all()
    assert len(np.unique(boxes[:, 2:].round(9), axis=0)) == 1
