"""The screens of a run and of a search: one screen each, whose numbers are those of --json; a view is one function."""

import io
import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from cortex_dsl.cli import main
from cortex_dsl.report import blocks
from cortex_dsl.report.blocks import (
    Bar,
    Bars,
    Block,
    Caution,
    Code,
    Column,
    Curve,
    Facts,
    Gauge,
    Grid,
    Line,
    Note,
    Picture,
    Place,
    Spark,
    Table,
    Title,
    Value,
    lines_of,
    plain,
    values_of,
)
from cortex_dsl.report.documents import blocks_content
from cortex_dsl.report.findings.run_report import Conflict, RunReport, conflicts
from cortex_dsl.report.findings.search_report import SearchReport
from cortex_dsl.report.page.markup import render as markup
from cortex_dsl.report.page.render import nodes
from cortex_dsl.report.terminal import render as terminal
from cortex_dsl.report.terminal.theme import THEME
from cortex_dsl.report.views.measures import run_details
from cortex_dsl.report.views.run import LINES, run_screen, with_short_names
from cortex_dsl.report.views.search import comparison_screen, search_screen
from cortex_dsl.report.views.search_details import paper_details, search_details
from engine.program import Program
from engine.risk import HIGHEST_RISK
from engine.strict_json import json_text
from tests.cortex_dsl.report.test_views import METRICS, RECORDS, ROAD

EXAMPLES = Path(__file__).parents[3] / "examples"
SMALL = ("--generations", "3", "--population", "40", "--seed", "1")
RUNS = (
    ("left_turn.scn", "--seed", "4"),
    ("left_turn.scn", "--seed", "1"),
    ("roads/motorway_cut_in.scn", "--seed", "2"),
)
SCALES = (1.0, -1.0, 100.0, 3.6)
"""A number is shown as it is, as how much too late, in percent, or in km/h."""


@pytest.fixture
def run(program: Program, scenes: Any, outcomes: Any, trajectory: Any) -> RunReport:
    known: dict[str, Any] = {"score": 11, "parts": (0.0, 4.0, 3.0, 4.0), "pair": 0, "profile": "paper"}
    known |= {"engine": "world", "road": ROAD, "metrics": METRICS, "records": RECORDS, "impacts": ()}
    again = "cortexc examples/left_turn.scn --seed 0"
    return RunReport(program=program, scenes=scenes, outcomes=outcomes, trajectory=trajectory, reproduce=again, **known)


def text_of(view: Block, width: int = 80, *, ascii_only: bool = False, colour: bool = False) -> str:
    """What a terminal of this width shows."""
    stream = io.StringIO()
    console = Console(file=stream, theme=THEME, width=width, highlight=False, markup=False, force_terminal=colour)
    console.print(terminal.rendered(view, width, ascii_only=ascii_only))
    return stream.getvalue()


def shown(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: str
) -> tuple[Title, str, dict[str, Any]]:
    """The view of a command, its text at 80 columns, and its document."""
    views: list[Title] = []
    made = terminal.rendered

    def kept(view: Title, *arguments: Any, **options: Any) -> Any:
        views.append(view)
        return made(view, *arguments, **options)

    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(terminal, "rendered", kept)
    assert main([*words]) == 0
    text = capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    return views[0], text, json.loads(capsys.readouterr().out)


# -- numbers -----------------------------------------------------------------------------------------------------------


def leaves(content: Any) -> Iterator[Any]:
    """Every number and text of a document."""
    if isinstance(content, dict):
        yield from (leaf for name, each in content.items() for leaf in (name, *leaves(each)))
    elif isinstance(content, list):
        yield from (leaf for each in content for leaf in leaves(each))
    else:
        yield content


NUMERAL = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.\d+)?(?![\w:])")


def matches(numeral: str, number: float) -> bool:
    """Whether a numeral is a number, rounded as the numeral is."""
    decimals = len(numeral.partition(".")[2])
    shown_number, room = float(numeral.replace(",", "")), 0.5 * 10.0**-decimals + 1e-9
    return any(abs(shown_number - scale * number) <= room for scale in SCALES)


def assert_numbers(view: Title, content: dict[str, Any]) -> None:
    """Every number of a view stands in the document; its text shows that number."""
    every = list(leaves(content))
    numbers = [float(leaf) for leaf in every if isinstance(leaf, int | float) and not isinstance(leaf, bool)]
    texts = " ".join(leaf for leaf in every if isinstance(leaf, str))
    valued = list(values_of([view]))
    assert len(valued) > 5
    for value in valued:
        if isinstance(value.number, int | float) and math.isfinite(value.number):
            assert any(math.isclose(value.number, each, rel_tol=1e-9, abs_tol=1e-12) for each in numbers), value
            assert any(matches(numeral, float(value.number)) for numeral in NUMERAL.findall(value.text)), value
    words = " ".join(plain(line) for block in view.blocks for line in lines_of([block]))
    for numeral in NUMERAL.findall(words):
        assert numeral in texts or any(matches(numeral, each) for each in numbers), numeral


@pytest.mark.parametrize("words", RUNS, ids=" ".join)
def test_a_run_is_one_screen_of_the_numbers_of_its_document(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """At most 45 lines of 80 columns."""
    view, text, content = shown(monkeypatch, capsys, str(EXAMPLES / words[0]), *words[1:])
    assert len(text.splitlines()) <= LINES
    assert max(map(len, text.splitlines())) <= 80
    assert "--metrics" in text
    assert_numbers(view, {**content, "highest": HIGHEST_RISK})


@pytest.mark.parametrize("objective", ["risk", "conflict", "severity"])
def test_a_search_is_one_screen_of_the_numbers_of_its_document(
    objective: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """At most 45 lines of 80 columns; the last line is the next command."""
    monkeypatch.chdir(tmp_path)
    file = str(EXAMPLES / "left_turn.scn")
    view, text, content = shown(monkeypatch, capsys, file, "--ga", *SMALL, "--objective", objective)
    lines = text.splitlines()
    assert len(lines) <= LINES
    assert max(map(len, lines)) <= 80
    assert re.fullmatch(r"next: cortexc report runs/left_turn-ga-\d+ --open", lines[-1].strip())
    (search,) = content["searches"]
    hit = [case["collided"] for case in search["cases"]]
    assert hit == sorted(hit, reverse=True)
    for title in ("worst cases", "Kinds of failures"):
        assert title in text
    timed = [block for block in view.blocks if not (isinstance(block, Note) and " a second" in plain(block.words))]
    assert_numbers(replace(view, blocks=[block for block in timed if not isinstance(block, Code | Note)]), content)
    assert_numbers(view, {**content, "timed": _durations(view)})


def _durations(view: Title) -> list[float]:
    """Numbers on the pace of a search, which differ between the two runs of this test."""
    words = [plain(block.words) for block in view.blocks if isinstance(block, Note)]
    return [float(n.replace(",", "")) for line in words for n in re.findall(r"([\d.,]+) (?:a second|s,)", line)]


def test_a_number_that_is_not_in_the_document_is_noticed(run: RunReport) -> None:
    """The comparison can fail."""
    view = Title("t", [Table((Column(),), [[Value("2.31 m", "", 2.31)]] * 6)])
    assert_numbers(view, {"distance": 2.31})
    with pytest.raises(AssertionError):
        assert_numbers(view, {"distance": 2.32})
    with pytest.raises(AssertionError):
        assert_numbers(Title("t", [Table((Column(),), [[Value("2.41 m", "", 2.31)]] * 6)]), {"distance": 2.31})


# -- the closest conflict ----------------------------------------------------------------------------------------------

times = st.one_of(st.just(math.nan), st.floats(-20.0, 20.0))
some_conflicts = st.builds(
    Conflict, st.integers(0, 9), st.booleans(), st.booleans(), st.floats(0.0, 50.0), st.floats(0.0, 9.0), times, times
)


@given(st.lists(some_conflicts, min_size=2, max_size=8))
def test_contact_leads_and_who_never_moves_is_last(found: list[Conflict]) -> None:
    """Then the least of |PET| and TTC, then the distance, within each of these groups."""
    ordered = sorted(found, key=lambda each: each.urgency)
    groups = [0 if each.contact else 1 if each.moves else 2 for each in ordered]
    assert groups == sorted(groups)
    for first, second in pairwise(ordered):
        if groups[ordered.index(first)] == groups[ordered.index(second)]:
            least = [min((abs(t) for t in (c.pet, c.ttc) if t == t), default=math.inf) for c in (first, second)]
            assert least[0] <= least[1]
            assert least[0] < least[1] or first.distance <= second.distance


def test_a_parked_truck_never_leads(run: RunReport) -> None:
    """Nearer than the crossing car, with a higher risk: it stays last, and the risk keeps its pair."""
    states = np.concatenate([run.trajectory.states, run.trajectory.states[:, 1:]], axis=1)
    states[:, 1, 3] = 0.0  # the first of the others stands
    trajectory = replace(
        run.trajectory, states=states, outlines=np.vstack([run.trajectory.outlines, run.trajectory.outlines[1:]])
    )
    wide = {
        name: np.hstack([value, value + 1.0])
        for name, value in vars(run.outcomes).items()
        if isinstance(value, np.ndarray) and value.shape == (1, 1) and value.dtype == np.float64
    }
    program = replace(run.program, actors=("ego", "truck", "car"))
    report = replace(run, program=program, trajectory=trajectory, outcomes=replace(run.outcomes, **wide), pair=0)
    from engine.vocabulary import State

    states[:, 1, State.SPEED] = 0.0
    assert [each.pair for each in conflicts(report)] == [1, 0]
    text = " ".join(text_of(run_screen(report)).split())
    assert "closest: car, 3.31 m apart" in text
    assert "risk 11 of 22 (truck)" in text


# -- a new view --------------------------------------------------------------------------------------------------------


DRAWN = (
    Gauge(style="part.C", share=0.75, length=4, rest="·"),
    Place(share=0.5, ends=("5", "58")),
    Spark(values=(1.0, math.nan, 3.0)),
)


def new_view(failures: int) -> Title:
    """A view as one function, of every kind of block."""
    count = Value(f"{failures:,}", "bad", failures, "failures.count")
    grid = Grid("speeds", ("slow", "fast"), ("left", "right"), np.ones((2, 2), dtype=int), np.eye(2, dtype=int))
    return Title(
        "A new view",
        [
            Note((count, " failures")),
            Caution("not finished"),
            Facts([("failures", count)], tiles=True),
            Title("Rows", [Table((Column("who"), Column("times", numbers=True)), [["truck", count]])], "by partner"),
            Table((Column(), Column(), Column()), [DRAWN], header=False),
            Bars([Bar(3, "collision", "bad"), Bar(1, "time is up")], 4),
            grid,
            Curve([Line(Value("speed"), (0.0, 1.0, 4.0), "0 .. 4 m/s")], 2.0),
            Picture([], 4),
            Title("How", [Code("cortexc analyse RUN", "again")], folded=True),
        ],
    )


def test_a_new_view_is_one_function() -> None:
    """Terminal, page and document show all of it."""
    view = new_view(5000)
    text, page, content = text_of(view), markup(nodes(view)), json_text(blocks_content(view))
    for words in ("A new view", "not finished", "Rows", "by partner", "truck", "5,000", "collision", "cortexc analyse"):
        for medium in (text, page, content):
            assert words in medium
    assert 'data-figure="failures.count"' in page
    assert "<details>" in page
    assert re.search(r"███·  +5 ├─{10}●─{10}┤ 58  ▁ █", text)
    assert re.search(r"###·  +5 \|-{10}o-{10}\| 58", text_of(view, ascii_only=True))
    assert not any(0x2500 <= ord(sign) < 0x2900 for sign in text_of(view.blocks[4], ascii_only=True))
    for mark in ('style="--share:75%"', 'style="--at:50.0%"', "<polyline"):
        assert mark in page
    assert json.loads(content)["blocks"][0]["words"][0]["number"] == 5000
    named = {name for name in vars(blocks) if name[0].isupper()} & {b["block"].title() for b in _tree(content)}
    assert named == {"Title", "Note", "Caution", "Facts", "Table", "Bars", "Grid", "Curve", "Picture", "Code"}


def _tree(content: str) -> Iterator[dict[str, Any]]:
    stack = [json.loads(content)]
    while stack:
        block = stack.pop()
        yield block
        stack += block.get("blocks", [])


# -- terminals and texts of every sort ---------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [40, 60, 80, 100, 300])
@pytest.mark.parametrize("ascii_only", [False, True])
def test_screens_fit(program: Program, run: RunReport, report: SearchReport, width: int, ascii_only: bool) -> None:
    """Whatever the width; without Unicode the drawings are plain characters; without colour nothing is lost."""
    several = comparison_screen(program, [report, replace(report, campaign=replace(report.campaign, method="lhs"))], "")
    details = [*run_details(run), paper_details([report], "30 x 100"), *search_details(program, report)]
    screens = run_screen(run), search_screen(program, report, "30 x 100, seed 4"), several
    for view in (*screens, Title("Details", details)):
        assert markup(nodes(view))
        assert json_text(blocks_content(view))
        text = text_of(view, width, ascii_only=ascii_only)
        assert max(map(len, text.splitlines())) <= width
        if ascii_only:
            assert not any(0x2500 <= ord(sign) < 0x2900 for sign in text)
        coloured = re.sub(r"\x1b\[[\d;]*m", "", text_of(view, width, ascii_only=ascii_only, colour=True))
        assert coloured.split() == text.split()


def test_twelve_actors_are_one_screen(run: RunReport) -> None:
    """Three pairs and the number of the others; the events of the closest actor before those of others."""
    names = ("ego", *(f"car {k}" for k in range(1, 12)))
    others = np.repeat(run.trajectory.states[:, 1:], 11, axis=1)
    states = np.concatenate([run.trajectory.states[:, :1], others], axis=1)
    trajectory = replace(
        run.trajectory,
        states=states,
        outlines=np.vstack([run.trajectory.outlines[:1], np.repeat(run.trajectory.outlines[1:], 11, axis=0)]),
    )
    wide = {
        name: value + np.arange(11.0)[np.newaxis]
        for name, value in vars(run.outcomes).items()
        if isinstance(value, np.ndarray) and value.shape == (1, 1) and value.dtype == np.float64
    }
    wide |= {name: np.repeat(getattr(run.outcomes, name), 11, axis=1) for name in ("side", "fault")}
    wide["left_road_time"] = np.full((1, 12), np.nan)
    report = replace(
        run,
        program=replace(run.program, actors=names),
        trajectory=trajectory,
        outcomes=replace(run.outcomes, **wide),
        records=(),
    )
    text = text_of(run_screen(report))
    assert len(text.splitlines()) <= LINES
    assert "8 more: --metrics" in text
    assert "closest: car 1, " in text


def test_titles_with_markup_are_text(program: Program, run: RunReport, report: SearchReport) -> None:
    """Names and docstrings of users act neither on the terminal nor on a page."""
    strange = replace(program, name="[bold]x[/bold]", description="<script>alert(1)</script> [red]")
    for view in (run_screen(replace(run, program=strange)), search_screen(strange, report, "")):
        assert "[bold]x[/bold]  <script>" in text_of(view)
        page = markup(nodes(view))
        assert "<script>" not in page
        assert "&lt;script&gt;" in page


def test_a_search_without_a_valid_scene(program: Program, nothing_valid: SearchReport) -> None:
    """It begins with that, counts the requirements, ends with a cure, and shows neither cases nor kinds."""
    shown = replace(nothing_valid, folder=Path("runs/none"))
    text = text_of(search_screen(program, shown, ""))
    assert "no valid scene in 392 simulations" in " ".join(text.split())
    assert "requirement" in text
    assert "help: another --seed" in text
    assert "worst" not in text


def test_a_lone_ego_has_no_worst_cases(program: Program, report: SearchReport) -> None:
    """It can meet nobody."""
    alone = replace(program, actors=program.actors[:1])
    text = text_of(search_screen(alone, replace(report, cases=(), kinds=()), ""))
    assert "the ego is the only actor" in text
    assert "worst cases" not in text


def test_long_names_of_actors_lose_their_middle(run: RunReport) -> None:
    """In every line of a run, so that the events keep their room."""
    long = tuple(f"{name}{'_' * 50}{number}" for number, name in enumerate(run.program.actors))
    shown = with_short_names(replace(run, program=replace(run.program, actors=long)))
    text = text_of(run_screen(shown), 80)
    assert "_" * 15 not in text
    assert all(name in text for name in shown.program.actors)
