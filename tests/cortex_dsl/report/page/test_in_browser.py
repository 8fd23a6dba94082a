"""The page in a real browser: it opens whole and without errors, and its replays play."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.cortex_dsl.report.page.conftest import scrub

PLAYED = "() => parseFloat(document.querySelector('.case:not(.away) .clock').textContent) > 0.2"


@pytest.fixture
def shown(opened_tab: Callable[..., Any], page_file: Path) -> Any:
    """The page of the small search, opened; whatever goes wrong in it fails the test."""
    return opened_tab(page_file)


def place(tab: Any, actor: int = 0) -> str:
    return tab.locator(f".case:not(.away) .actors [data-actor='{actor}']").get_attribute("transform")


def clock(tab: Any) -> float:
    return float(tab.locator(".case:not(.away) .clock").inner_text().split()[0])


def test_opens_whole(shown: Any) -> None:
    """Once it is loaded, all its scripts have run, and nothing else is fetched."""
    assert shown.evaluate("document.readyState") == "complete"
    fetched = "performance.getEntriesByType('resource').filter(e => !e.name.startsWith('data:')).length"
    assert shown.evaluate(fetched) == 0


def test_one_case_at_a_time(shown: Any) -> None:
    """The tabs show one case each."""
    assert shown.locator(".case:visible").count() == 1
    last = shown.locator(".case-tab").last
    last.click()
    assert shown.locator(".case:visible").get_attribute("data-case") == last.get_attribute("data-case")


def test_scrubber_moves_everybody(shown: Any) -> None:
    """Actors stand where the embedded data says, at whatever time the scrubber shows."""
    scrub(shown, sample=0)
    start = place(shown)
    scrub(shown, sample=8)
    assert place(shown) != start
    x = shown.evaluate(
        """() => {
            const actor = JSON.parse(document.getElementById("replays").textContent)[0].actors[0];
            return actor.x.slice(0, 9).reduce((sum, step) => sum + step, 0) / 100;
        }"""
    )
    assert float(place(shown).split("(")[1].split()[0]) == pytest.approx(x, abs=1e-3)


def test_plots_are_in_step(shown: Any) -> None:
    """The cursor of every plot is where the clock is."""
    for sample in (0, 10):
        scrub(shown, sample=sample)
        places = shown.evaluate(
            """() => [...document.querySelectorAll(".case:not(.away) .chart")].map((chart) => {
                const { low, high, start, end } = chart.dataset;
                const x = Number(chart.querySelector(".cursor").getAttribute("transform").match(/[\\d.]+/)[0]);
                return Number(low) + (x - start) / (end - start) * (high - low);
            })"""
        )
        assert len(places) == 3
        assert places == pytest.approx([clock(shown)] * 3, abs=0.03)


def test_it_plays_and_pauses(shown: Any) -> None:
    """Play starts at the beginning and moves time on, and pause stops it."""
    shown.locator(".case:not(.away) .speed[data-speed='0.5']").click()
    shown.locator(".case:not(.away) .play").click()
    shown.wait_for_function(PLAYED)
    shown.locator(".case:not(.away) .play").click()
    assert shown.locator(".case:not(.away) .play").get_attribute("aria-pressed") == "false"
    held = clock(shown)
    shown.wait_for_timeout(150)
    assert clock(shown) == held


def test_keyboard(shown: Any) -> None:
    """Arrows step by a sample, Home and End go to the ends, plus doubles the speed, c comes closer, space plays."""
    player = shown.locator(".case:not(.away) .player")
    player.focus()
    shown.keyboard.press("Home")
    assert clock(shown) == 0.0
    shown.keyboard.press("ArrowRight")
    shown.keyboard.press("ArrowRight")
    step = shown.evaluate('() => JSON.parse(document.getElementById("replays").textContent)[0].step')
    assert clock(shown) == pytest.approx(2 * step, abs=0.006)
    shown.keyboard.press("ArrowLeft")
    assert clock(shown) == pytest.approx(step, abs=0.006)
    shown.keyboard.press("+")
    assert player.locator(".speed[aria-pressed='true']").get_attribute("data-speed") == "2"
    whole = player.locator("svg.scene").get_attribute("viewBox")
    shown.keyboard.press("c")
    assert player.locator("svg.scene").get_attribute("viewBox") != whole
    shown.keyboard.press(" ")
    shown.wait_for_function(PLAYED)
    shown.keyboard.press("End")
    assert player.locator(".play").get_attribute("aria-pressed") == "false"


def test_after_contact_is_lighter(shown: Any) -> None:
    """What is shown after contact is marked as not scored, and what is before is not."""
    group = shown.locator(".case:not(.away) .actors")
    scrub(shown, sample=0)
    assert "after" not in str(group.get_attribute("class")).split()
    assert shown.locator(".case:not(.away) g.contact").is_hidden()
    shown.locator(".case:not(.away) .player").focus()
    shown.keyboard.press("End")
    assert "after" in str(group.get_attribute("class")).split()
    assert shown.locator(".case:not(.away) .after-note").is_visible()
    assert shown.locator(".case:not(.away) g.contact").is_visible()


def test_it_opens_at_contact_with_what_led_to_it(shown: Any) -> None:
    """Outlines touch, speeds and closing speed are those before the blow; a moment later they are those after it."""
    reading = {
        name: shown.locator(f".case:not(.away) [data-reading='{name}']")
        for name in ("speed:0", "distance:0", "closing speed:0")
    }
    met = {name: each.inner_text() for name, each in reading.items()}
    assert met["distance:0"] == "0.00"
    assert "–" not in met.values()
    shown.locator(".case:not(.away) .player").focus()
    shown.keyboard.press("ArrowLeft")
    assert reading["speed:0"].inner_text() == met["speed:0"]
    assert float(reading["distance:0"].inner_text()) > 0.0
    shown.keyboard.press("ArrowRight")
    assert reading["speed:0"].inner_text() != met["speed:0"]
    assert (reading["distance:0"].inner_text(), reading["closing speed:0"].inner_text()) == ("–", "–")


def test_moments_lead_to_their_time(shown: Any) -> None:
    """A line of the story shows its moment."""
    moment = shown.locator(".case:not(.away) .moment.contact").first
    moment.click()
    assert clock(shown) == pytest.approx(float(moment.get_attribute("data-time")), abs=0.006)


def test_map_of_simulations(shown: Any) -> None:
    """The map draws something, and tells of the dot under the pointer."""
    canvas = shown.locator(".explorer canvas")
    canvas.scroll_into_view_if_needed()
    drawn = "c => c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v > 0)"
    assert canvas.evaluate(drawn)
    box = canvas.bounding_box()
    tips = set()
    for step in range(144):
        across, up = (step % 12 + 0.5) / 12, (step // 12 + 0.5) / 12
        shown.mouse.move(box["x"] + box["width"] * across, box["y"] + box["height"] * up)
        tips.add(shown.locator(".tip").inner_text())
    assert any("generation" in text for text in tips)


@pytest.mark.parametrize("width", [360, 768, 1600])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_fits_every_screen(opened_tab: Callable[..., Any], page_file: Path, width: int, scheme: str) -> None:
    """Nothing is wider than the screen."""
    tab = opened_tab(page_file, width, 800, color_scheme=scheme)
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_dark_is_dark(opened_tab: Callable[..., Any], page_file: Path) -> None:
    """The page follows the reader's scheme, and the button turns it over."""
    tab = opened_tab(page_file, color_scheme="dark")
    colour = "getComputedStyle(document.body).backgroundColor"
    dark = tab.evaluate(colour)
    tab.locator(".theme").click()
    assert tab.evaluate(colour) != dark
    assert sum(map(int, dark.removeprefix("rgb(").removesuffix(")").split(","))) < 150


def test_without_scripts_all_is_there(chromium: Any, page_file: Path) -> None:
    """A reader without scripts sees every case at its key moment."""
    context = chromium.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(page_file.as_uri())
    cases = tab.locator(".case")
    assert cases.count() == tab.locator(".case-tab").count() > 1
    assert all(cases.nth(number).is_visible() for number in range(cases.count()))
    context.close()
