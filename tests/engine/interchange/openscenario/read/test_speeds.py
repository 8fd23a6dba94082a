"""Speeds that our own files carry are believed as they were written, and not when a file says something else."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import load
from engine.config import Config, SimulationConfig
from engine.interchange import ExportOptions, Recording
from engine.interchange.measuring import measure
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.read import Imported, read_openscenario
from engine.interchange.recording import recorded_run
from engine.vocabulary import State
from tests.engine.interchange.openscenario.conftest import actor, recording

ROOT = Path(__file__).parents[5]
SCENARIOS = [*sorted((ROOT / "examples").glob("*.scn")), *sorted((ROOT / "tests" / "agreement").glob("*.scn"))]
MISFIT = "do not fit its vertices"


def recordings(path: Path, step: float, count: int) -> Iterator[Recording]:
    scenario = load(path, replace(Config(), simulation=SimulationConfig(time_step=step)))
    for seed in range(count):
        scenes = scenario.scene_of_seed(seed)
        if scenes.valid[0]:
            yield recorded_run(scenario.program, scenes, scenario.watch(scenes), step=step).taking_part()


def again(folder: Path, one: Recording, *changes: tuple[str, str]) -> Imported:
    text = str(write_trajectories(one, "case", ExportOptions(), None).files["case.xosc"])
    for old, new in changes:
        assert re.search(old, text, re.DOTALL)
        text = re.sub(old, new, text, count=1, flags=re.DOTALL)
    (folder / "case.xosc").write_text(text, encoding="utf-8")
    return read_openscenario(folder / "case.xosc")


@cache
def crash(step: float = 0.05) -> Recording:
    """Two cars that meet between two samples, from the example of the paper."""
    found = [one for one in recordings(ROOT / "examples" / "left_turn.scn", step, 8) if one.contact is not None]
    return found[0]


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
@pytest.mark.parametrize("step", [0.013, 0.2])
def test_our_own_speeds_are_believed(tmp_path: Path, path: Path, step: float) -> None:
    """Whoever drives, brakes to a stand, walks, is set to a speed, comes, goes or slides; through contact and after."""
    for one in recordings(path, step, 3):
        imported = again(tmp_path, one)
        # What follows contact with a building is of physics, and the vertices alone tell of no building.
        assert imported.remarks == () or path.stem == "walls"
        if imported.remarks:
            continue
        assert imported.recording.commands
        assert imported.recording.step == step
        assert imported.recording.states[one.there] == pytest.approx(one.states[one.there], abs=1e-9)


@pytest.mark.parametrize("step", [0.001, 0.05, 0.1])
def test_our_own_crashes_are_believed(tmp_path: Path, step: float) -> None:
    """At every step length."""
    imported = again(tmp_path, crash(step))
    assert imported.remarks == ()
    assert imported.recording.commands


def numbers(name: str, change: Callable[[list[float]], list[float]], one: Recording) -> tuple[str, str]:
    """The first actor's property with other numbers."""
    column = one.states[one.there[:, 0], 0, State[name.upper()]].tolist()
    return rf'"cortexc.{name}" value="[^"]*"', f'"cortexc.{name}" value="{" ".join(map(repr, change(column)))}"'


@pytest.mark.parametrize(
    "change",
    [
        lambda speeds: [1.04 * speed for speed in speeds],
        lambda speeds: [speed + 0.05 for speed in speeds],
        lambda speeds: [-speed for speed in speeds],
        lambda speeds: [0.0 for _ in speeds],
        lambda speeds: [1e9, *speeds[1:]],
        lambda speeds: [*speeds[:5], speeds[5] + 0.2, *speeds[6:]],
        lambda speeds: [*speeds[:-1], 1e6],
    ],
    ids=["more", "added", "back", "none", "first", "one", "last"],
)
def test_other_speeds_are_not_believed(tmp_path: Path, change: Callable[[list[float]], list[float]]) -> None:
    """All a little, one a little, one beyond reason; the vertices still say how fast it was."""
    one = crash()
    imported = again(tmp_path, one, numbers("speed", change, one))
    assert any(MISFIT in remark for remark in imported.remarks)
    assert measure(imported.recording).outcomes.max_closing_speed[0, 0] == pytest.approx(
        measure(one).outcomes.max_closing_speed[0, 0], rel=0.05
    )


def test_the_speed_at_contact_is_held_against_the_way_to_it(tmp_path: Path) -> None:
    """The step before it was cut short, so that it lies in between only."""
    one = crash()
    assert one.contact is not None
    at = int(np.searchsorted(one.time, one.contact.time))
    imported = again(tmp_path, one, numbers("speed", lambda v: [*v[:at], v[at] + 2.0, *v[at + 1 :]], one))
    assert any(MISFIT in remark for remark in imported.remarks)


def test_an_acceleration_that_no_vehicle_has_explains_nothing(tmp_path: Path) -> None:
    """Any speed at all would fit with one."""
    one = crash()
    faster = 3.0 / one.step * 2.0
    changes = [
        numbers("speed", lambda v: [v[0], *(speed + 3.0 for speed in v[1:])], one),
        numbers("acceleration", lambda a: [a[0], *(each + faster for each in a[1:])], one),
    ]
    assert any(MISFIT in remark for remark in again(tmp_path, one, *changes).remarks)


VERTEX = r'(<Vertex time="0.1">\s*<Position>\s*<WorldPosition x=")[^"]+'


def test_a_vertex_aside_is_reported(tmp_path: Path) -> None:
    """Speeds do not lead there, and no vehicle does."""
    imported = again(tmp_path, crash(), (VERTEX, r"\g<1>40"))
    assert any(MISFIT in remark for remark in imported.remarks)
    (leap,) = [remark for remark in imported.remarks if "lies" in remark and "off the way" in remark]
    assert "0.1 s" in leap


def test_who_is_made_to_stand_is_not_driving(tmp_path: Path) -> None:
    """In all vertices before contact, while the carried speeds go on."""
    one = crash()
    frozen = replace(one, states=one.states.copy())
    before = one.scored_samples() - 1
    frozen.states[:before, 0, : State.SPEED] = frozen.states[before, 0, : State.SPEED]
    imported = again(tmp_path, frozen)
    assert any(MISFIT in remark for remark in imported.remarks)
    assert imported.recording.states[:3, 0, State.SPEED] == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("step", ["1e8", "0.5", "0.0000001"])
def test_a_step_that_is_not_that_of_the_samples_is_not_taken(tmp_path: Path, step: str) -> None:
    """It gets a remark, and the samples say another."""
    imported = again(tmp_path, crash(), ('"cortexc.step" value="[^"]*"', f'"cortexc.step" value="{step}"'))
    assert imported.recording.step == crash().step
    assert [remark for remark in imported.remarks if "samples stand 0.05 s apart" in remark]


def test_few_samples_leave_the_step_as_it_is_said(tmp_path: Path) -> None:
    """One alone, or contact within the first step."""
    for times in ([0.0], [0.0, 0.013], [0.0, 0.013, 0.05]):
        one = recording([actor("ego")], times, [[(1, 2, 3)] * len(times)])
        imported = again(tmp_path, one)
        assert (imported.recording.step, imported.remarks) == (0.05, ())


def driven(speeds: list[float], accelerations: list[float]) -> Recording:
    """One car, straight on, one step of 0.05 s for each speed after the first."""
    ways = [v * 0.05 - a * 0.05**2 / 2.0 for v, a in zip(speeds[1:], accelerations[1:], strict=True)]
    places = [(float(x), 0.0, 0.0) for x in np.concatenate([[0.0], np.cumsum(ways)])]
    one = recording([actor("ego")], [0.05 * k for k in range(len(speeds))], [places])
    one.states[:, 0, State.SPEED], one.states[:, 0, State.ACCELERATION] = speeds, accelerations
    return one


def test_a_speed_that_is_set_at_once_is_believed(tmp_path: Path) -> None:
    """Within the run the next step shows it; an actor that comes in faster than it ever drives gets a remark."""
    within = again(tmp_path, driven([5.0, 5.0, 9.0, 9.0], [0.0] * 4))
    assert within.remarks == ()
    assert within.recording.states[:, 0, State.SPEED].tolist() == [5.0, 5.0, 9.0, 9.0]
    (remark,) = again(tmp_path, driven([30.0, 5.0, 5.0, 5.0], [0.0] * 4)).remarks
    assert remark == "ego: it comes in at 30 m/s and drives off at 5 m/s, at 0 s"


def test_recordings_from_elsewhere_may_have_noise(tmp_path: Path) -> None:
    """A few centimetres, without pedals; not another speed all along."""
    rng = np.random.default_rng(3)
    one = replace(driven([10.0] * 40, [0.0] * 40), commands=False)
    one.states[:, 0, State.X] += rng.normal(scale=0.02, size=40)
    assert again(tmp_path, one).recording.states[:, 0, State.SPEED].tolist() == [10.0] * 40
    one.states[:, 0, State.SPEED] = 11.0
    assert any(MISFIT in remark for remark in again(tmp_path, one).remarks)
