"""The plan of the lights, as OpenSCENARIO has it."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.opendrive import signal_groups
from engine.interchange.openscenario.write import GREEN, RED, YELLOW, phases
from engine.interchange.recording import SignalTimes
from engine.maps import RoadSpec
from tests.engine.interchange.openscenario.conftest import scenario, small, with_lights

seconds = st.floats(0.5, 30.0)
plans = st.builds(SignalTimes, seconds, seconds, st.floats(0.0, 5.0), st.floats(0.0, 200.0))


def shown(times: SignalTimes, turn: int, time: float) -> str:
    """What the plan says, worked out by its definition."""
    slot = times.green + times.yellow + times.all_red
    into = (times.offset + time - turn * slot) % (2 * slot)
    if into < times.green:
        return GREEN
    return YELLOW if into < times.green + times.yellow else RED


def played(times: SignalTimes, turn: int, time: float) -> str:
    written = phases(times, turn)
    time %= sum(phase.duration for phase in written)
    for phase in written:
        if time < phase.duration:
            return phase.state
        time -= phase.duration
    return written[0].state


@given(plans, st.integers(0, 1), st.floats(0.0, 300.0))
def test_phases_show_what_the_plan_says(times: SignalTimes, turn: int, time: float) -> None:
    """At any time but within a microsecond of a change."""
    if shown(times, turn, time - 1e-6) == shown(times, turn, time + 1e-6):
        assert played(times, turn, time) == shown(times, turn, time)


@given(plans, st.integers(0, 1))
def test_phases_last_and_have_names(times: SignalTimes, turn: int) -> None:
    """The checker of the standard wants durations above 0; a cycle takes as long as the plan."""
    written = phases(times, turn)
    assert all(phase.duration > 0.0 for phase in written)
    assert len({phase.name for phase in written}) == len(written)
    cycle = 2 * (times.green + times.yellow + times.all_red)
    assert sum(phase.duration for phase in written) == pytest.approx(cycle)


@pytest.mark.parametrize("road", [RoadSpec(), RoadSpec(ways=3), RoadSpec(rows=2, cols=2)])
def test_controllers_and_lights_are_those_of_the_road(road: RoadSpec) -> None:
    """Each group of the road is one controller; no light is named that the road does not have."""
    root = scenario(replace(with_lights(), road=road))
    written = {
        controller.get("name"): {state.get("trafficSignalId") for state in controller.iter("TrafficSignalState")}
        for controller in root.iter("TrafficSignalController")
    }
    assert written == {group.controller: set(group.signals) for group in signal_groups(road)}


def test_without_lights_there_are_none() -> None:
    """A road without a plan has no `TrafficSignals`."""
    assert scenario(small()).find(".//TrafficSignals") is None
