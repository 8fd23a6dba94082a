"""What we write and read again is what it was: positions, times, speeds, who is there, and how it is judged."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from engine.interchange import ExportOptions, InterchangeError, Recording
from engine.interchange.opendrive import write_opendrive
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.read import Imported, read_openscenario
from engine.maps import RoadSpec
from engine.vocabulary import State
from tests.engine.interchange.openscenario.conftest import actor as made_actor
from tests.engine.interchange.openscenario.conftest import recording, recordings, small, versions
from tests.laws import examples

many = settings(examples(100), suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
POSE = (State.X, State.Y, State.HEADING)
HUGE = "1 " * 6_000_000


def again(folder: Path, one: Recording, version: str = "1.2", road_file: str | None = None) -> Imported:
    for name, text in write_trajectories(one, "case", ExportOptions(osc=version), road_file).files.items():
        (folder / name).write_text(str(text), encoding="utf-8")
    return read_openscenario(folder / "case.xosc")


def assert_same(one: Recording, other: Recording, columns: Sequence[State] = tuple(State)) -> None:
    there = one.states[:, :, State.PRESENT] != 0.0
    assert other.time == pytest.approx(one.time, abs=1e-9)
    assert (other.states[:, :, State.PRESENT] != 0.0).tolist() == there.tolist()
    for column in set(columns) - {State.HEADING}:
        assert other.states[:, :, column][there] == pytest.approx(one.states[:, :, column][there], abs=1e-9)
    turn = (other.states[:, :, State.HEADING] - one.states[:, :, State.HEADING])[there]
    assert np.remainder(turn + 1.0, 2 * np.pi) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("version", ["1.0", "1.1", "1.2", "1.3"])
def test_a_crash_comes_back_as_it_was(tmp_path: Path, version: str) -> None:
    """Four actors, one that comes and goes, contact between two samples, with the road beside."""
    one = small()
    one.states[:, 2, State.SPEED] = [0, 2, 2, 0, 2]
    (tmp_path / "road.xodr").write_text(write_opendrive(RoadSpec(), None, "road"))
    imported = again(tmp_path, one, version, "road.xodr")
    assert_same(one, imported.recording)
    assert imported.recording.actors == one.actors
    assert imported.recording.step == one.step
    assert imported.recording.commands
    assert imported.recording.contact is None
    assert imported.recording.provenance.genome == one.provenance.genome
    assert imported.recording.provenance.title == one.provenance.title
    assert imported.recording.provenance.facts.items() >= one.provenance.facts.items()
    assert imported.road is not None
    assert not [remark for remark in imported.remarks if "speeds" in remark]


@pytest.mark.parametrize("ego", ["bus 12", "bus_12"])
def test_the_ego_may_be_named_as_it_is_shown(tmp_path: Path, ego: str) -> None:
    """By the name that it had before readers wanted letters alone, or by that of the file."""
    again(tmp_path, small())
    read = read_openscenario(tmp_path / "case.xosc", ego=ego).recording
    assert [actor.name for actor in read.actors] == ["bus 12", "ego", "walker", "box"]


def test_nobody_of_that_name(tmp_path: Path) -> None:
    """The name that is shown is offered before that of the file."""
    again(tmp_path, small())
    with pytest.raises(InterchangeError, match="no actor is called `walkre`") as wrong:
        read_openscenario(tmp_path / "case.xosc", ego="walkre")
    assert wrong.value.cure == "did you mean `walker`?"


def test_the_ego_stays_the_ego_whatever_others_are_called(tmp_path: Path) -> None:
    """Neither a name nor the order of the file makes another one of it."""
    ways = [[(10.0 * k, 0, 0), (10.0 * k + 1, 0, 0)] for k in range(3)]
    one = recording([made_actor(name) for name in ("VUT", "Hero", "EGO")], [0.0, 0.05], ways)
    assert [actor.name for actor in again(tmp_path, one).recording.actors] == ["VUT", "Hero", "EGO"]
    text = (tmp_path / "case.xosc").read_text()
    objects = re.findall("<ScenarioObject.*?</ScenarioObject>", text, re.DOTALL)
    (tmp_path / "case.xosc").write_text(text.replace(objects[0], "").replace(objects[2], objects[2] + objects[0]))
    assert read_openscenario(tmp_path / "case.xosc").recording.actors[0].name == "VUT"
    (tmp_path / "case.xosc").write_text(text.replace('value="ego_vehicle"', 'value="simulation"'))
    assert read_openscenario(tmp_path / "case.xosc").recording.actors[0].name == "VUT"


def test_names_come_back_to_the_letter(tmp_path: Path) -> None:
    """Signs that mean a parameter, or an escape of ours, and no name at all."""
    names = ["$a", "\\d", "\\$\\\\", "", "\N{FULLWIDTH DOLLAR SIGN}", "a\nb"]
    one = recording([made_actor(name) for name in names], [0.0, 0.05], [[(9.0 * k, 0, 0)] * 2 for k in range(6)])
    assert [actor.name for actor in again(tmp_path, one).recording.actors] == names


def test_the_smallest_that_the_language_makes_comes_back(tmp_path: Path) -> None:
    """A millimetre long, and one instant alone."""
    one = recording([replace(made_actor("ego"), length=0.001, width=1e-6)], [0.0], [[(1, 2, 3)]])
    assert_same(one, again(tmp_path, one).recording)


def test_as_many_as_are_written_are_read(tmp_path: Path) -> None:
    """A scenario may have 999 actors."""
    one = recording([made_actor(f"c{k}") for k in range(999)], [0.0], [[(9.0 * k, 0, 0)] for k in range(999)])
    assert len(again(tmp_path, one).recording.actors) == 999


@many
@given(recordings(), versions)
def test_every_recording_comes_back(tmp_path: Path, one: Recording, version: str) -> None:
    """With gaps, standstills, and names of all kinds; somebody is there at any time.

    Random poses do not fit their speeds of 0, so that what is compared of them is where and when.
    """
    there = one.states[:, :, State.PRESENT] != 0.0
    assume(there.any(axis=0).all() and there.any(axis=1).all())
    other = again(tmp_path, one, version).recording
    assert [each.kind for each in other.actors] == [each.kind for each in one.actors]
    assert_same(one, other, POSE)


def test_who_never_moves_is_a_recording_too(tmp_path: Path) -> None:
    """Without any trajectory, from the samples that the file carries."""
    one = recording([made_actor("ego")], [0.0, 0.05, 0.1], [[(1, 2, 3)] * 3])
    assert_same(one, again(tmp_path, one).recording)


def edited(folder: Path, change: tuple[str, str]) -> Imported:
    time = [0.05 * sample for sample in range(20)]
    one = recording([made_actor("ego")], time, [[(10 * t, 0, 0) for t in time]])
    one.states[:, 0, State.SPEED] = 10.0
    again(folder, one)
    text = (folder / "case.xosc").read_text()
    assert change[0] in text
    (folder / "case.xosc").write_text(text.replace(*change))
    return read_openscenario(folder / "case.xosc")


@pytest.mark.parametrize("change", [('scale="1"', 'scale="2"'), ('offset="0"', 'offset="0.01"')])
def test_speeds_that_do_not_fit_any_more_are_worked_out(tmp_path: Path, change: tuple[str, str]) -> None:
    """Somebody changed the times and left the speeds: the vertices are believed, with a remark."""
    imported = edited(tmp_path, change)
    assert any("do not fit its vertices" in remark for remark in imported.remarks)
    speeds = imported.recording.states[2:-2, 0, State.SPEED]
    assert speeds == pytest.approx(np.full(len(speeds), 5.0 if "scale" in change[0] else 10.0))


def test_speeds_of_a_moved_actor_are_worked_out(tmp_path: Path) -> None:
    """Twice as far in the same time is twice as fast, whatever the properties say."""
    time = [0.05 * sample for sample in range(20)]
    one = recording([made_actor("ego")], time, [[(20 * t, 0, 0) for t in time]])
    one.states[:, 0, State.SPEED] = 10.0
    imported = again(tmp_path, one)
    assert imported.recording.states[:, 0, State.SPEED] == pytest.approx([20.0] * 20)
    assert not imported.recording.commands


@pytest.mark.parametrize("value", ["", "1 2", "a b c", "nan " * 20, HUGE], ids=["", "2", "a", "nan", "huge"])
def test_properties_without_sense_are_passed_over(tmp_path: Path, value: str) -> None:
    """What is no list of numbers, of another length, or huge."""
    imported = edited(tmp_path, ('name="cortexc.speed" value="', f'name="cortexc.speed" value="{value}" note="'))
    assert imported.recording.states[:, 0, State.SPEED] == pytest.approx([10.0] * 20)
    assert not imported.recording.commands


@settings(examples(30), suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.floats(0.2, 20.0), st.floats(-0.3, 0.3))
def test_derived_speeds_are_those_of_the_rear_axle(tmp_path: Path, speed: float, rate: float) -> None:
    """On a circle: the speed along the arc, to the second order of the step."""
    time = np.arange(40) * 0.05
    heading = rate * time
    radius = speed / rate if abs(rate) > 1e-9 else 0.0
    x = radius * np.sin(heading) if radius else speed * time
    y = radius * (1 - np.cos(heading)) if radius else np.zeros(40)
    car = replace(made_actor("ego"), rear_to_center=0.0)
    one = recording([car], time.tolist(), [list(zip(x, y, heading, strict=True))])
    one.states[:, 0, State.SPEED] = 1000.0
    speeds = again(tmp_path, one).recording.states[:, 0, State.SPEED]
    assert speeds[1:-1] == pytest.approx(np.full(38, speed), rel=1e-4)


def test_an_empty_folder_is_reported(tmp_path: Path) -> None:
    """As is a scenario that is not there."""
    with pytest.raises(InterchangeError, match="no such file"):
        read_openscenario(tmp_path / "case.xosc")
