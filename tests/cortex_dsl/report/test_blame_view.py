"""Blame and feasibility as people see them, at every width."""

import io

import pytest
from rich.console import Console, RenderableType

from cortex_dsl import compile_text
from cortex_dsl.report.documents import document
from cortex_dsl.report.findings.tally import blame_content, blame_note, cure_of_conflict
from cortex_dsl.report.terminal.check_view import feasibility_view
from cortex_dsl.report.terminal.render import rendered
from cortex_dsl.report.terminal.theme import THEME
from cortex_dsl.report.views.requirements import blame_view
from engine.acceptance import Account, account, measure_acceptance
from engine.feasibility import explain
from engine.program import Program

WIDTHS = (60, 80, 120)
TEXT = """
map intersection(ways=4, lanes=1)
param A = Range(0, 10) m
param B = Range(0, 10) m
ego = new Car on road
require B > 1 m
require A >= 7 m as "far enough"
require A * 2 <= 10 m as "near enough"
"""


def render(view: RenderableType, width: int) -> str:
    stream = io.StringIO()
    Console(file=stream, theme=THEME, width=width, highlight=False, markup=False).print(view)
    return stream.getvalue()


def blamed(found: Account, width: int) -> str:
    return render(rendered(blame_view(found), width, depth=1), width)


def account_of(text: str, target: float | None = None) -> Account:
    return account(measure_acceptance(compile_text(text).program, 3000), target)


@pytest.fixture
def program() -> Program:
    return compile_text(TEXT.replace("* 2 <= 10 m", "* 2 <= 16 m")).program


@pytest.mark.parametrize("width", WIDTHS)
def test_what_contradicts_what(width: int) -> None:
    """Both requirements with their lines, that it is proved, the nearest miss with its params, and what to relax."""
    text = blamed(account_of(TEXT), width)
    assert max(map(len, text.splitlines())) <= width
    flat = " ".join(text.split())
    assert "never together: `far enough` (line 7) and `near enough` (line 8); proved" in flat
    assert "nearest miss: `far enough` by" in flat
    assert " m, the only one that failed A = " in flat
    assert "to accept 1.00 %: relax `far enough` by" in flat


def test_what_never_failed_is_left_out() -> None:
    """A table of what did something only."""
    text = blamed(account_of(TEXT.replace("B > 1 m", "B >= 0 m")), 80)
    assert "B >= 0 m" not in text
    assert "far enough" in text


def test_the_note_says_what_of() -> None:
    """Shares are of single attempts."""
    assert (
        blame_note(account_of(TEXT))
        == "3,000 single attempts with new params, each tested against all requirements; 0.00 % met all"
    )


def test_document() -> None:
    """JSON has the same, unrounded."""
    content = blame_content(account_of(TEXT, target=0.2))
    assert content["conflict"] == {"requirements": ["far enough", "near enough"], "proved": True}
    assert content["target"] == 0.2
    assert {entry["unit"] for entry in content["relax"]} == {"m"}
    miss = content["requirements"][1]["nearest_miss"]
    assert miss["margin"] < 0
    assert set(miss["params"]) == {"A", "B"}
    assert document("sample", {"blame": content})


@pytest.mark.parametrize("width", WIDTHS)
def test_ranges_that_cannot_hold(program: Program, width: int) -> None:
    """Each end that is cut off, with its unit and its reason."""
    view = feasibility_view(program, explain(program))
    assert view is not None
    text = render(view, width)
    assert max(map(len, text.splitlines())) <= width
    flat = " ".join(text.split())
    assert "A below 7.00 m cannot hold: far enough" in flat
    assert "A above 8.00 m cannot hold: near enough" in flat
    assert "B below 1.00 m cannot hold: B > 1 m" in flat


def test_ranges_of_one_reason_share_a_line() -> None:
    """The reason is not said twice."""
    both = compile_text("map intersection()\nparam A = Range(0, 10) m, B = Range(0, 10) m\nego = new Car on road\n"
                        "require A > B + 6 m\n").program  # fmt: skip
    view = feasibility_view(both, explain(both))
    assert view is not None
    flat = " ".join(render(view, 80).split())
    assert "A below 6.00 m, B above 4.00 m cannot hold: A > B + 6 m" in flat
    assert flat.count("cannot hold") == 1


@pytest.mark.parametrize(
    ("requirements", "cure"),
    [
        ('b = new Car ahead of ego by A + 9 m\nrequire (distance to b) < 5 m as "near"', "relax `near` (line 5) by "),
        ('require A > 6 m + B as "apart"\nrequire A < B as "near"', "relax one of those that never hold together"),
        ("require A > B", ""),
    ],
)
def test_the_cure_of_what_is_proved(requirements: str, cure: str) -> None:
    """It names the requirement and the amount, as the table above it does."""
    params = "param A = Range(0, 10) m\nparam B = Range(0, 9) m\n"
    text = params + "ego = new Car before intersection by 40 m along network.lanes[0]\n"
    found = cure_of_conflict(account_of(text + requirements + "\n", target=0.01))
    assert found.startswith(cure)
    assert bool(found) == bool(cure)


def test_nothing_is_said_of_what_is_whole() -> None:
    """A file whose ranges are not cut is reported in one line."""
    free = compile_text("map intersection(ways=4, lanes=1)\nparam A = Range(0, 10) m\nego = new Car on road\n").program
    assert feasibility_view(free, explain(free)) is None


SPOKEN = """
map intersection(ways=4, lanes=1)
param V = Range(10, 40) km/h
param W = Range(10, 40) km/h
param H = Range(-20, 20) deg
param BARE = Range(1, 3)
ego = new Car on road, with speed V
require V - W > 25 km/h as "written"
require W > V + 6 m/s as "another"
require H > 19.9 as "of the param"
require V > W as "of what it reads"
require BARE > 2.9 as "pure"
"""


def test_amounts_are_displayed_in_the_unit_of_the_file() -> None:
    """The unit that a `require` writes, else that of the param it reads, else none; JSON stays in SI units."""
    found = account_of(SPOKEN.replace("19.9", "19.9 deg"))
    lines = blamed(found, 120).splitlines()
    units = {name: next(line for line in lines if line.strip().startswith(name)).rstrip() for name in
             ("written", "another", "of the param", "of what it reads", "pure")}  # fmt: skip
    assert units["written"].endswith(" km/h")
    assert units["another"].endswith(" m/s")
    assert units["of the param"].endswith(" deg")
    assert units["of what it reads"].endswith(" km/h")
    assert units["pure"][-1].isdigit()
    miss = blame_content(found)["requirements"][0]["nearest_miss"]
    assert miss["unit"] == "m/s"
    assert f"{-miss['margin'] * 3.6:.3g} km/h" in units["written"]


def test_the_object_that_leaves_the_road_is_named() -> None:
    """With its share of the rejected attempts and the specifier that lets it, in text and in the document."""
    text = "map road()\nspot = new OrientedPoint in network.lanes[0].centerline\nego = new Car at spot\n"
    found = account_of(text + "bus = new Bus right of spot by 2 m\n")
    shown = blamed(found, 120)
    assert "off the road: `bus` in 100.0 % of the rejected attempts" in shown
    assert "with regionContainedIn None" in shown
    assert blame_content(found)["off_road"][0] == {"object": "bus", "share": 1.0}


def test_off_the_road_is_no_cure_where_it_accepts_nothing() -> None:
    """What leaves the road is named, but if another requirement rejects those attempts too, there is no advice."""
    text = "map road()\nspot = new OrientedPoint in network.lanes[0].centerline\nego = new Car at spot\n"
    found = account_of(text + "bus = new Bus right of spot by Range(-6, 2) m\nrequire (distance to bus) > 90 m\n")
    shown = blamed(found, 120)
    assert "off the road: `bus` in " in shown
    assert "with regionContainedIn None" not in shown
