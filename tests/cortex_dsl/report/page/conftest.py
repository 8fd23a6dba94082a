"""One small search whose names are as hostile as the language lets them be, and a browser to look at its page."""

import os
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cortex_dsl.api.runs import OpenedRun, open_run
from cortex_dsl.cli import main
from cortex_dsl.report.page.run_page import run_page
from tests.runs import small_designs

HOSTILE = "<img src=x onerror=alert(1)>"
"""The stem of the scenario's file, and so its name."""
SCENARIO = '''"""</script><script>alert(2)</script> & "quotes" \\u2028"""

map intersection(ways=4, lanes=1, lane_width=3.5 m, corner_radius=6 m, approach=50 m)

param EGO_SPEED = Range(20, 60) km/h
param OTHER_SPEED = Range(20, 60) km/h
param GAP = Range(5, 40) m

egoLane = Uniform(*intersection.incomingLanes)
egoManeuver = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, egoLane.maneuvers))
otherLane = Uniform(*egoManeuver.reverseManeuvers).startLane
otherManeuver = Uniform(*filter(lambda m: m.type is ManeuverType.LEFT_TURN, otherLane.maneuvers))

ego = new Car at (new OrientedPoint in egoLane.centerline),
    with speed EGO_SPEED,
    with behavior FollowTrajectoryBehavior(EGO_SPEED, [egoLane, egoManeuver.connectingLane, egoManeuver.endLane])
other = new Car at (new OrientedPoint in otherLane.centerline),
    with speed OTHER_SPEED,
    with behavior FollowTrajectoryBehavior(
        OTHER_SPEED, [otherLane, otherManeuver.connectingLane, otherManeuver.endLane])
require (distance from ego to other) > GAP as "</style><script>alert(3)</script>"
terminate after 12 s
'''


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished search of 6 generations of 30."""
    home = tmp_path_factory.mktemp("page")
    file = home / f"{HOSTILE}.scn"
    file.write_text(SCENARIO, encoding="utf-8")
    run = home / "run"
    words = ["--ga", "--generations", "6", "--population", "30", "--seed", "3", "--out", str(run), "--json"]
    assert main([str(file), *words]) == 0
    return run


@pytest.fixture(scope="session")
def opened(folder: Path) -> OpenedRun:
    return open_run(folder)


@pytest.fixture(scope="session")
def page_text(opened: OpenedRun) -> str:
    with small_designs():
        return run_page(opened, 3)


@pytest.fixture(scope="session")
def page_file(page_text: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(page_text, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A headless browser, whose home is a folder of the tests."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    binary = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if binary is None:
        pytest.skip("there is no Chromium on this machine to open the page with")
    with playwright.sync_playwright() as started:
        home = {**os.environ, "HOME": str(tmp_path_factory.mktemp("home"))}
        home = {name: value for name, value in home.items() if not name.startswith("XDG_")}
        browser = started.chromium.launch(executable_path=binary, args=["--no-sandbox"], env=home)
        yield browser
        browser.close()


@pytest.fixture
def opened_tab(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Open a page in a tab, with options of Playwright; an error, a line on its console or a request fails the test."""
    tabs: list[Any] = []
    troubles: list[str] = []

    def open_tab(file: Path, width: int = 1280, height: int = 900, **options: Any) -> Any:
        tab = chromium.new_page(viewport={"width": width, "height": height}, **options)
        tabs.append(tab)
        tab.on("console", lambda message: troubles.append(message.text))
        tab.on("pageerror", lambda error: troubles.append(str(error)))
        tab.on("request", lambda request: None if request.url.startswith("file:") else troubles.append(request.url))
        tab.goto(file.as_uri())
        return tab

    yield open_tab
    for tab in tabs:
        tab.close()
    assert troubles == []


def scrub(tab: Any, share: float = 0.0, sample: int | None = None) -> None:
    """Move the replay that is shown to this share of its samples, or to a sample."""
    node = tab.locator(".scrub:visible")
    node.evaluate("(node, [share, sample]) => { node.value = sample ?? share * node.max; }", [share, sample])
    node.dispatch_event("input")


class Reader(HTMLParser):
    """What a browser would find: tags with attributes, the texts of scripts, and figures by name."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.blocks: dict[str, str] = {}
        self.figures: dict[str, list[tuple[float, str]]] = {}
        self._open: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._open.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        self._open = self._open[:-1] if self._open and self._open[-1][0] == tag else self._open

    def handle_data(self, data: str) -> None:
        tag, attributes = self._open[-1] if self._open else ("", {})
        if tag == "script" and attributes.get("id"):
            self.blocks[str(attributes["id"])] = data
        if tag == "data" and attributes.get("data-figure"):
            value = float(str(attributes["value"]))
            self.figures.setdefault(str(attributes["data-figure"]), []).append((value, data))


@pytest.fixture(scope="session")
def read(page_text: str) -> Reader:
    reader = Reader()
    reader.feed(page_text)
    return reader


# -- numbers of a page that its data must hold -------------------------------------------------------------------------

NUMBER = re.compile(r"(?<![\w.])\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?(?![\w])")
UNSEEN = ("script", "style", "svg", "pre")
"""What a reader of the text does not see, or what is a text of its own: sources and commands."""
BULK = frozenset({"rows", "distinct", "runs", "failures", "tried", "failed", "key"})
"""Long lists of row numbers and cells, in which any number would be found."""


class Words(HTMLParser):
    """The text of a page as it is read, piece by piece."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.pieces: list[str] = []
        self._unseen = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._unseen += tag in UNSEEN

    def handle_endtag(self, tag: str) -> None:
        self._unseen -= tag in UNSEEN

    def handle_data(self, data: str) -> None:
        if not self._unseen:
            self.pieces.append(data)


def numbers_in(value: Any) -> Iterator[float]:
    """Every number of a document: values, lengths of lists, and those inside sentences."""
    if isinstance(value, bool) or value is None:
        return
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, str):
        yield from (float(text.replace(",", "")) for text in NUMBER.findall(value))
    elif isinstance(value, list):
        yield float(len(value))
        for item in value:
            yield from numbers_in(item)
    else:
        for name, item in value.items():
            yield from numbers_in(name)
            yield from [float(len(item))] if name in BULK and isinstance(item, list) else numbers_in(item)


def missing_numbers(page: str, data: Any, constants: Sequence[str]) -> list[str]:
    """Numbers that a page shows and its data does not hold: as they are, as a share in percent, or as a speed."""
    words = Words()
    words.feed(page)
    text = " ".join(" ".join(words.pieces).split())
    for constant in constants:
        text = text.replace(" ".join(constant.replace("`", " ").split()), " ").replace(constant, " ")
    known = np.array(sorted({abs(number) for number in numbers_in(data)}))
    return [
        f"{match[0]} in {text[max(0, match.start() - 60) : match.end() + 20]!r}"
        for match in NUMBER.finditer(text)
        if not _is_known(match[0], known)
    ]


def _is_known(shown: str, known: np.ndarray) -> bool:
    plain = shown.replace(",", "")
    mantissa, _, power = plain.partition("e")
    ulp = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
    return bool(np.any(np.abs(np.outer((1.0, 100.0, 3.6), known) - float(plain)) <= 0.501 * ulp))
