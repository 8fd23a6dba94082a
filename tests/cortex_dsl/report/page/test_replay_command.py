"""`cortexc replay`: the same case in the terminal, as a page and as a film."""

import io
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.cli import main
from cortex_dsl.report.findings.case_replay import replay_of_case
from cortex_dsl.report.terminal import replay_view
from cortex_dsl.report.terminal.replay_view import Film
from cortex_dsl.report.terminal.theme import THEME
from engine.vocabulary import State

LEFT_TURN = Path(__file__).parents[4] / "examples" / "left_turn.scn"


def test_one_frame_when_piped(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nobody watches a pipe: it gets the key moment, once."""
    assert main(["replay", str(folder), "--case", "2"]) == 0
    out = capsys.readouterr().out
    assert out.count("km/h") >= 2
    assert "contact" in out
    assert "\x1b" not in out


def test_frames_move(opened: OpenedRun) -> None:
    """Two frames of a film differ, and the first has no mark of contact."""
    replay = replay_of_case(opened, opened.every_case()[0])
    film = Film.of(replay, 80, 40, ascii_only=True)

    def text(place: float) -> str:
        out = io.StringIO()
        Console(file=out, width=80, theme=THEME).print(film.frame(place))
        return out.getvalue()

    assert text(0) != text(replay.key_sample + 1)
    assert "X" not in text(0).split(" s  ")[0]
    assert "X" in text(replay.key_sample + 1)


def test_a_frame_shows_everybody_at_their_place(opened: OpenedRun) -> None:
    """At a sample as it was recorded; between two, between these; nobody who is not in the scene."""
    replay = replay_of_case(opened, opened.every_case()[0])
    states = replay.trajectory.states.copy()
    states[3:6, 1, State.PRESENT] = 0.0
    states[8, 1, State.HEADING] = np.nan
    film = Film.of(replace(replay, trajectory=replace(replay.trajectory, states=states)), 80, 40, ascii_only=True)
    poses = states[:, :, State.X : State.HEADING + 1]
    there = (states[:, :, State.PRESENT] > 0.0) & np.isfinite(poses).all(axis=2)
    for sample, actor in np.ndindex(*there.shape):
        pose, between = film._pose(actor, sample), film._pose(actor, sample + 0.5)
        assert (pose is None) == (between is None) == (not there[sample, actor])
        after = min(sample + 1, len(states) - 1)
        if pose is not None and between is not None:
            assert pose == tuple(poses[sample, actor])
            middle = poses[[sample, after if there[after, actor] else sample], actor].mean(axis=0)
            assert between[:2] == pytest.approx(middle[:2], abs=1e-9)
    assert not there.all()


def test_it_plays_in_a_terminal(opened: OpenedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal sees many frames; contact is held for a moment; fast films take less time."""
    now = [0.0]
    monkeypatch.setattr(replay_view, "monotonic", lambda: now[0])
    monkeypatch.setattr(replay_view, "sleep", lambda seconds: now.__setitem__(0, now[0] + seconds))
    replay = replay_of_case(opened, opened.every_case()[0])
    taken = []
    for speed in (1.0, 4.0):
        now[0] = 0.0
        out = io.StringIO()
        console = Console(file=out, width=80, force_terminal=True, theme=THEME, _environ={"TERM": "xterm"})
        replay_view.play(replay, console, speed)
        assert out.getvalue().count(" km/h") > 8
        taken.append(now[0])
    assert taken[0] == pytest.approx(replay.trajectory.time[-1] + replay_view.PAUSE, abs=0.15)
    assert taken[1] < taken[0]


def test_page_of_a_case(folder: Path, tmp_path: Path) -> None:
    """A case alone is a page with one player."""
    path = tmp_path / "case.html"
    assert main(["replay", str(folder), "--case", "1", "--to", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    assert text.count("data-replay=") == 1
    assert "cortexc replay" in text


def test_picture_of_a_case(folder: Path, tmp_path: Path) -> None:
    """A picture is an SVG of its own, with everybody, a north arrow and a bar."""
    path = tmp_path / "case.svg"
    assert main(["replay", str(folder), "--case", "1", "--to", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    ET.fromstring(text)
    assert text.count("data-actor=") >= 2
    assert 'class="compass"' in text


def test_film_of_a_case(folder: Path, tmp_path: Path) -> None:
    """A film has many frames, of which the first and the last differ."""
    images = pytest.importorskip("PIL.Image")
    path = tmp_path / "case.gif"
    assert main(["replay", str(folder), "--to", str(path), "--speed", "2"]) == 0
    with images.open(path) as film:
        assert film.n_frames > 5
        first = film.convert("RGB").tobytes()
        film.seek(film.n_frames - 1)
        assert film.convert("RGB").tobytes() != first


def test_replay_of_a_scenario(tmp_path: Path) -> None:
    """A scenario is run as `cortexc FILE` runs it."""
    path = tmp_path / "run.html"
    assert main(["replay", str(LEFT_TURN), "--seed", "4", "--to", str(path)]) == 0
    assert "left_turn" in path.read_text(encoding="utf-8")


def test_unknown_case_is_reported(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A case that a run does not have is refused with the ones that it has."""
    assert main(["replay", str(folder), "--case", "99999"]) == 2
    assert "1 is the worst" in capsys.readouterr().err
