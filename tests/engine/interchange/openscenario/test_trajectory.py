"""Motion as timed polylines: exact at every sample."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from engine.interchange.openscenario.document import entity_names
from engine.interchange.openscenario.write import stretches
from engine.interchange.own_metadata import COMMANDS, MOTION
from engine.interchange.recording import Recording
from engine.vocabulary import State
from tests.engine.interchange.openscenario.conftest import (
    actor,
    played,
    polyline,
    recording,
    recordings,
    scenario,
    small,
    versions,
)


@given(recordings(), versions)
def test_every_sample_can_be_read_back(of: Recording, version: str) -> None:
    """At each sample an actor is where it was, to a nanometre, and is not there where it was not."""
    root, of = scenario(of, version), of.taking_part()
    for index, name in enumerate(entity_names(of)):
        poses = of.rear_axle(index)
        for sample, time in enumerate(of.time):
            where = played(root, name, float(time))
            assert (where is not None) == bool(of.states[sample, index, State.PRESENT])
            if where is not None:
                assert where == pytest.approx(poses[sample], abs=1e-9)


@given(recordings())
def test_times_ascend(of: Recording) -> None:
    """Each vertex is later than the one before; the first and last are those of the stretch."""
    for element in scenario(of).iter("Trajectory"):
        times = polyline(element).times
        assert times[0] in of.time
        assert times[-1] in of.time
        assert sorted(set(times)) == times


@given(recordings())
def test_a_standstill_has_two_vertices(of: Recording) -> None:
    """Rule 6: no three vertices at one pose, where readers spin; the last keeps heading and time of the standstill."""
    for element in scenario(of).iter("Trajectory"):
        poses = polyline(element).poses
        same = (poses[1:] == poses[:-1]).all(axis=1)
        assert not (same[1:] & same[:-1]).any()


def test_a_car_that_waits_leaves_on_time() -> None:
    """Rule 6: it stands until the last sample of its standstill, not on its way from the first on."""
    times = [0.05 * sample for sample in range(6)]
    wait = recording([actor("car")], times, [[(0, 0, 1)] * 4 + [(1, 0, 1), (2, 0, 1)]])
    written = polyline(scenario(wait).find(".//Polyline"))
    assert written.times == [0.0, times[3], times[4], times[5]]
    assert (written.poses[:, 2] == 1.0).all()


def test_contact_has_a_vertex_of_its_own() -> None:
    """The instant of first contact lies between two steps."""
    assert 0.12 in polyline(scenario(small()).find(".//Trajectory[@name='ego_trajectory_1']")).times


def test_times_are_absolute() -> None:
    """Rule 2: with `None` a reader ignores times; `position` lets nothing steer."""
    for follow in scenario(small()).iter("FollowTrajectoryAction"):
        timing = follow.find("TimeReference/Timing")
        assert timing.attrib == {"domainAbsoluteRelative": "absolute", "scale": "1", "offset": "0"}
        assert follow.find("TrajectoryFollowingMode").get("followingMode") == "position"
        assert follow.find(".//Trajectory").get("closed") == "false"


def test_all_digits_are_written() -> None:
    """Positions read back to the same numbers."""
    third = recording([actor("car")], [0.0, 0.05], [[(1 / 3, 0.1, 2 / 3), (0.7, 1e-17, 1e20)]])
    assert (polyline(scenario(third).find(".//Polyline")).poses == third.rear_axle(0)).all()


@given(recordings())
def test_what_positions_do_not_say_stands_in_properties(of: Recording) -> None:
    """One number for each sample of the actor: speed, steering, acceleration and pedals as they were, and the step."""
    of.states[:, :, State.SPEED : State.PRESENT] = np.arange(of.states[:, :, State.SPEED : State.PRESENT].size).reshape(
        of.states[:, :, State.SPEED : State.PRESENT].shape
    )
    root, of = scenario(of), of.taking_part()
    for index, element in enumerate(root.iter("ScenarioObject")):
        values = {each.get("name"): each.get("value") for each in element.iter("Property")}
        there = of.states[:, index, State.PRESENT] != 0
        assert float(values["cortexc.step"]) == of.step
        assert [float(each) for each in values["cortexc.time"].split()] == of.time[there].tolist()
        for state in (*MOTION, *COMMANDS):
            written = [float(each) for each in values[f"cortexc.{state.name.lower()}"].split()]
            assert written == of.states[there, index, state].tolist()


def test_stretches_know_when_the_actor_is_gone() -> None:
    """A stretch ends with the first sample without the actor, or never."""
    first, second = stretches(small(), 2)
    assert (first.starts_late, first.gone) == (True, 0.12)
    assert (second.starts_late, second.gone) == (True, None)
    (ego,) = stretches(small(), 0)
    assert (ego.starts_late, ego.gone) == (False, None)


def test_commands_that_were_not_recorded_are_not_written() -> None:
    """A recording of motion alone has no steering and no pedals, rather than some that are 0."""
    named = {each.get("name") for each in scenario(replace(small(), commands=False)).iter("Property")}
    assert {"cortexc.speed", "cortexc.acceleration"} <= named
    assert not {"cortexc.steer", "cortexc.throttle", "cortexc.brake"} & named
