"""Cases that a search of the session has found: listed, played, written."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from cortex_dsl.api.scenario import load
from cortex_dsl.console.terminal import Terminal

from .conftest import LEFT_TURN, Talk


@pytest.fixture
def searched(talk: Talk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Talk:
    """A session after a short search, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    talk(f":load {LEFT_TURN}", ":random 1")
    talk.state.terminal = Terminal(colour=False)  # the streams of a set-up are not those of its test
    return talk


@pytest.mark.parametrize("command", [":worst", ":watch", ":watch 2", ":export 1 case.scn"])
def test_nothing_has_been_searched(talk: Talk, command: str) -> None:
    """It is said what searches."""
    said = talk(command).err
    assert "nothing has been searched yet" in said
    assert "`:ga` searches" in said


def test_a_search_says_what_can_be_done_next(searched: Talk) -> None:
    """Below its report."""
    said = searched(":ga 1").out
    assert "`:worst` lists their kinds, `:watch N` plays one, `:export N FILE` keeps it" in said


def test_the_worst(searched: Talk) -> None:
    """Partner, side, speeds, whether a competent driver avoids it, and risk; changes of the draft since are told."""
    said = searched(":worst").out
    assert ":random, 1 x 100, seed 0" in said
    row = r"^ +(\d+)  adversary +(?:front|left|right|rear) .* (yes|no|struck|[\d.]+ m apart)\b.* (\d+) *$"
    rows = re.findall(row, said, re.MULTILINE)
    assert [int(row[0]) for row in rows] == list(range(1, 11))
    risks = [int(row[2]) for row in rows]
    assert risks == sorted(risks, reverse=True)
    assert {row[1] for row in rows} & {"yes", "no"}
    assert "was changed since" not in said
    searched("x = 3 m")
    assert "the scenario was changed since" in searched(":worst").out


def test_a_case_is_watched(searched: Talk) -> None:
    """Where there is no terminal, its key moment; a pace and a number are checked."""
    said = searched(":watch 2").out
    assert re.search(r"case 2 of 10  risk \d+", said)
    assert re.search(r"[\d.]+ s   ego [\d.]+ km/h", said)
    assert "case 1 of 10" in searched(":watch").out
    assert "from 1 to 10, not `11`" in searched(":watch 11").err
    assert "the pace must be a factor" in searched(":watch 1 fast").err


def test_a_case_is_written(searched: Talk) -> None:
    """The suffix says as what, and a scenario runs to the outcome that was found; a folder takes several formats."""
    searched(":export 1 mine.scn")
    assert searched.state.found is not None
    case = searched.state.found.campaign.worst[0]
    copy = load("mine.scn")
    outcomes = copy.simulate(copy.scene_of_seed())
    assert int(copy.assess(outcomes).score[0]) == case.score
    assert float(outcomes.min_distance[0, 0]) == case.min_distance
    searched(':export 2 "my cases" csv,xosc', ":export 3 film/case.csv", ":export 1 key.svg", ":export 2 plain")
    assert sorted(path.name for path in Path("my cases").iterdir()) == [
        "left_turn-case02.csv",
        "left_turn-case02.xosc",
        "left_turn.xodr",
    ]
    assert Path("film/case.csv").is_file()
    assert Path("key.svg").read_text().startswith("<svg")
    assert Path("plain/left_turn-case02.scn").is_file()
    assert not searched.state.mistakes


def test_nothing_is_written_over(searched: Talk) -> None:
    """Unless the command is loud; the same contents are no conflict."""
    Path("a.scn").write_text("mine")
    Path("a.svg").write_text("mine")
    for name in ("a.scn", "a.svg"):
        said = searched(f":export 1 {name}").err
        assert "holds something else" in said
        assert ":export!" in said
        assert "--" not in said
        assert Path(name).read_text() == "mine"
        searched(f":export! 1 {name}")
        assert Path(name).read_text() != "mine"
    assert searched.state.mistakes == 2
    searched(":export 1 a.scn")
    assert searched.state.mistakes == 2


@pytest.mark.parametrize(
    ("argument", "said"),
    [
        ("", "export which case, and where to?"),
        ("1", "export it where to?"),
        ("x a.scn", "must be a whole number from 1 to 10, not `x`"),
        ("1 a.xocs", "did you mean `.xosc`?"),
        ("1 a.pdf", "no case is written as `.pdf`"),
        ("1 here scnn", "did you mean `scn`?"),
        ('1 "a.scn', "a quotation mark is not closed"),
        ("1 ~nobody-of-that-name/a.scn", "there is no home folder"),
    ],
)
def test_what_cannot_be_exported(searched: Talk, argument: str, said: str) -> None:
    """Each slip with its cure."""
    shown = searched(f":export {argument}").err
    assert said in shown
    assert searched.state.mistakes == 1
    assert not list(Path().iterdir())


def test_a_search_without_a_case(searched: Talk) -> None:
    """None of its simulations was valid: it is said so, with a cure."""
    found = searched.state.found
    assert found is not None
    searched.state.found = replace(found, campaign=replace(found.campaign, worst=()))
    assert "none of its simulations was valid" in searched(":worst").err


def test_a_search_for_something_else(searched: Talk) -> None:
    """A flag names the objective; an unknown name is answered with the nearest."""
    said = searched('expect always not self.collided as "no contact"', ':random 1 --objective "no contact"').out
    assert "objective: no contact" in said
    assert "objective no contact" in searched(":worst").out
    assert "did you mean `avoidable`?" in searched(":ga 1 --objective avoidabel").err
    for words in ("1 2", "--objective", "1 --seed 2", '"1'):
        assert searched(f":random {words}").err
    assert searched.state.mistakes == 5
