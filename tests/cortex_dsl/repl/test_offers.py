"""What Tab offers: what fits the kind that is asked for, in statements and behind commands."""

from pathlib import Path

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from cortex_dsl.repl import commands, prompt
from cortex_dsl.repl.prompt import DraftCompleter
from cortex_dsl.repl.state import State

from .conftest import LEFT_TURN, Talk


def offered(state: State, text: str) -> list[str]:
    """The words that Tab offers at the end of a text, the best first."""
    found = DraftCompleter(state).get_completions(Document(text), CompleteEvent(completion_requested=True))
    return [each.text for each in found]


@pytest.fixture
def loaded(talk: Talk) -> Talk:
    """A session with the worked example."""
    talk(f":load {LEFT_TURN}")
    return talk


@pytest.mark.parametrize(
    ("text", "there", "not_there"),
    [
        ("maximize ", {"largest", "delta_v", "EGO_SPEED"}, {"ego", "EgoBehavior", "Car", "always", "Range"}),
        ("minimize least(", {"EGO_SPEED", "ego", "distance from"}, {"largest", "EgoBehavior", "Car"}),
        ("expect ", {"always", "EGO_SPEED", "ego", "self"}, {"largest", "EgoBehavior", "SetBrakeAction", "Range"}),
        ("require always ", {"EGO_SPEED", "ego"}, {"EgoBehavior", "and", "Car"}),
        ("require EGO_SPEED > ", {"ADV_SPEED", "EGO_BRAKE", "ego"}, {"EGO_INIT_DIST", "always", "EgoBehavior"}),
        ("require (distance from ego to ", {"adversary", "intersection"}, {"EGO_SPEED", "sqrt", "EgoBehavior"}),
        ("x = new Car at advSpawnPt, with speed ", {"EGO_SPEED", "Range"}, {"EGO_INIT_DIST", "EgoBehavior"}),
        ("x = FollowLaneBehavior(target_speed=", {"EGO_SPEED"}, {"EGO_INIT_DIST", "EgoBehavior"}),
        (":plot ", {"EGO_SPEED", "largest", "delta_v", "always", "ego"}, {"EgoBehavior", "Car"}),
        (":plot EGO_SPEED, ADV", {"ADV_SPEED", "ADV_INIT_DIST"}, {"EGO_SPEED"}),
        (":plot delta_v, distance from ego to ", {"adversary"}, {"EGO_SPEED"}),
        (":set EGO", {"EGO_SPEED"}, {"ADV_SPEED"}),
        (":explain SCN20", {"SCN201"}, {"SCN302"}),
        (":help w", {"worst", "watch"}, {"plot"}),
        (":w", {"worst", "watch"}, {"plot"}),
        (":edit 1", {"1", "10"}, {"2"}),
        (":export 1 x xosc,c", {"csv", "commonroad"}, {"xosc"}),
        (":watch 1 ", {"0.5x", "2x"}, {"1"}),
        (":watch ", set(), {"1"}),
        (":undo ", set(), {"1"}),
        (":ga 5 ", {"--objective"}, {"avoidable"}),
        (":ga 5 --objective ", {"avoidable", "severity"}, {"--objective"}),
        (":random --objective av", {"avoidable"}, {"risk"}),
    ],
)
def test_what_fits_is_offered(loaded: Talk, text: str, there: set[str], not_there: set[str]) -> None:
    """And what cannot stand there is not."""
    found = set(offered(loaded.state, text))
    assert there <= found
    assert not not_there & found


def test_the_best_comes_first(loaded: Talk) -> None:
    """Reducers where a number of the run is asked for, speeds where a speed is."""
    assert set(offered(loaded.state, "maximize ")[:5]) == {"largest", "least", "final", "mean", "total"}
    assert set(offered(loaded.state, "require EGO_SPEED < ")[:2]) == {"EGO_SPEED", "ADV_SPEED"}
    assert set(offered(loaded.state, "x = new Car at advSpawnPt, with occluding ")[:2]) == {"True", "False"}


def test_cases_and_files(loaded: Talk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers of the cases that were found, scenarios to load, any file to write."""
    monkeypatch.chdir(tmp_path)
    for name in ("a.scn", "b.txt"):
        (tmp_path / name).write_text("")
    loaded(":random 1")
    assert offered(loaded.state, ":watch ") == [str(number) for number in range(1, 11)]
    assert offered(loaded.state, ":load ") == ["a.scn"]
    assert set(offered(loaded.state, ":export 1 ")) == {"a.scn", "b.txt"}


def test_every_kind_of_word_has_its_offers() -> None:
    """The table of commands names what exists."""
    kinds = {kind for row in commands.COMMANDS.values() for kind in row.completes}
    assert kinds == {*prompt.KINDS, *prompt.PATHS, "value", "aim"}
