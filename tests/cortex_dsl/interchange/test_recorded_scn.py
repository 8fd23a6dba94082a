"""A recording as a scenario: with its params at what was seen, a run of it is the recording again, in both hosts."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.cli import main
from cortex_dsl.interchange.recorded_scn import LANE, write_recorded
from cortex_dsl.source import Source
from cortex_dsl.syntax.formatting import format_source
from engine import batch
from engine.interchange import InterchangeError
from engine.interchange.measuring import measure
from engine.interchange.sources import read_recording
from engine.vocabulary import State

SEEN: dict[str, Any] = {"EGO_AHEAD": 0, "EGO_PACE": 1, "TRUCK_9_AHEAD": 0, "TRUCK_9_PACE": 1}


def near_miss(path: Path, step: float = 0.04, radius: float = 40.0) -> Path:
    """A car in a bend, one that brakes across its way, who leaves, who stands, a thing; and two who come, one of them a
    sample late.
    """
    rows = ["time [s],id,x [m],y [m],heading [rad],speed [m/s],length [m],width [m],type"]
    for k in range(120):
        t = k * step
        turn = t * 10.0 / radius
        x, y = 1000 + radius * math.sin(turn), 500 + radius * (1 - math.cos(turn))
        rows.append(f"{t},7,{x},{y},{turn},10,4.5,1.8,car")
        rows.append(f"{t},9,1036,{472 + 12 * t - 0.9 * t * t},{math.pi / 2},{12 - 1.8 * t},7.5,2.4,truck")
        rows.append(f"{t},30,990,512,0,0,4.2,1.7,car")
        rows.append(f"{t},31,990,488,0.3,0,1,1,obstacle")
        if t <= 3.0:
            rows.append(f"{t},12,{970 + 1.2 * t},510,0,1.2,0.5,0.5,pedestrian")
        if k > 0:
            rows.append(f"{t},13,{960 + 1.2 * t},520,0,1.2,0.5,0.5,pedestrian")
        if t >= 1.0:
            rows.append(f"{t},11,{980 + 1.2 * t},505,0,1.2,0.5,0.5,pedestrian")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return near_miss(tmp_path_factory.mktemp("recorded") / "near miss.csv")


def scenario_of(path: Path, window: tuple[float, float] | None = None) -> tuple[str, tuple[str, ...]]:
    recording = read_recording(path, ego="7", window=window).recording
    export = write_recorded(recording, "near", None, partner=1)
    (text,) = export.files.values()
    return str(text), export.remarks


@pytest.fixture(scope="module")
def text(table: Path) -> str:
    return scenario_of(table)[0]


@pytest.mark.parametrize("window", [None, (1.2, 4.0)])
def test_a_run_with_what_was_seen_is_the_recording(table: Path, window: tuple[float, float] | None) -> None:
    """Distances, times, risk: to 1e-6. Poses are turned and moved as one, the ego's first one to the right lane of a
    road along x.
    """
    recording = read_recording(table, ego="7", window=window).recording
    scenario = cx.compile_text(scenario_of(table, window)[0], **SEEN)
    scenes = scenario.scene_of_seed(0)
    assert scenes.valid[0]
    ours, theirs = batch.simulate(scenario.program, scenes, scenario.config.simulation), measure(recording).outcomes
    run = scenario.watch(scenes)
    assert len(run.trajectory.time) == len(recording.time)
    names = [actor.name for actor in recording.actors]
    begin = recording.states[0, 0, State.X : State.HEADING + 1]
    turn = np.array([[math.cos(begin[2]), -math.sin(begin[2])], [math.sin(begin[2]), math.cos(begin[2])]])
    start = run.trajectory.states[0, 0, State.X : State.HEADING + 1]
    assert start == pytest.approx((0.0, -0.5 * LANE, 0.0), abs=1e-6)
    for number, name in enumerate(scenario.program.actors[1:], 1):
        pair = names.index(name.rpartition("_")[2]) - 1
        for what in ("min_distance", "min_distance_time", "max_closing", "ttc", "distance_at_ms", "ttc_at_ms"):
            if hasattr(ours, what):
                one, other = getattr(ours, what)[0, number - 1], getattr(theirs, what)[0, pair]
                assert one == pytest.approx(other, abs=1e-6), (name, what)
                assert getattr(run.outcomes, what)[0, number - 1] == pytest.approx(one, abs=1e-9)
        there = recording.there[:, pair + 1]
        assert (run.trajectory.states[:, number, State.PRESENT] == 1.0).tolist() == there.tolist()
        apart = run.trajectory.states[there, number, :2] - run.trajectory.states[there, 0, :2]
        seen_apart = recording.states[there, pair + 1, :2] - recording.states[there, 0, :2]
        assert np.hypot(*apart.T) == pytest.approx(np.hypot(*seen_apart.T), abs=1e-7)
        moved = (recording.states[there, pair + 1, :2] - begin[:2]) @ turn + start[:2]
        assert run.trajectory.states[there, number, :2] == pytest.approx(moved, abs=1e-6)


def test_it_is_laid_out_and_says_how_to_see_what_was_recorded(text: str) -> None:
    """`cortexc fmt` has nothing to do, and the docstring holds the command."""
    assert format_source(Source("near.scn", text)) == text
    seen = " ".join(f"-p {name}={value}" for name, value in SEEN.items())
    assert f"cortexc near.scn {seen}" in " ".join(text.split())


def test_params_lie_around_what_was_seen(text: str) -> None:
    """Four of them, of the ego and its partner; all scenes are valid, and no actor jumps in its first step."""
    scenario = cx.compile_text(text)
    assert scenario.program.space.names == tuple(SEEN)
    scenes = scenario.sample(20, seed=1)
    assert scenes.valid.all()
    run = scenario.watch(scenes, 3)
    way = np.hypot(*np.diff(run.trajectory.states[:, :2, :2], axis=0).T)
    pace = scenes.genomes[3][[1, 3]][:, np.newaxis]
    assert way.max(axis=1) == pytest.approx((0.4 * pace[0, 0], way[1, 0]), rel=0.01)


def test_who_cannot_be_carried_is_told(table: Path) -> None:
    """Who comes later, by name; and that there is no road."""
    remarks = scenario_of(table)[1]
    assert "not there at the beginning, and left out of the scenario: 13, 11" in remarks
    assert any("no road was recorded" in remark for remark in remarks)


def test_a_long_recording_is_refused(table: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The two that matter have to have room; others are left out, the farthest first."""
    monkeypatch.setattr("cortex_dsl.interchange.recorded_scn.MAX_BYTES", 13_000)
    text, remarks = scenario_of(table)
    assert "no room for their tracks in a scenario: 12" in remarks
    assert "PEDESTRIAN_12" not in text
    monkeypatch.setattr("cortex_dsl.interchange.recorded_scn.MAX_BYTES", 5_000)
    with pytest.raises(InterchangeError, match="too long for a scenario"):
        scenario_of(table)


def test_the_command_writes_it(table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In a window, which the command to see it again names."""
    words = ["measure", str(table), "--ego", "7", "--window", "1.2,4", "--to", "scn", "--out", str(tmp_path)]
    assert main(words) == 0
    assert "--window 1.2,4" in " ".join(capsys.readouterr().out.split())
    assert main([str(tmp_path / "near miss.scn"), "--check"]) == 0
    assert main(["measure", str(table), "--ego", "7", "--window", "80,90"]) == 1
    assert "`7` is not there from 80 to 90 s" in capsys.readouterr().err
    assert main(["measure", str(table), "--window", "9"]) == 2
