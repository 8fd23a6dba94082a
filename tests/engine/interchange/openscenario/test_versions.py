"""What is written follows the schema of its version, and says what differs between versions as that version does."""

import pytest
from hypothesis import given

from engine.interchange.contract import OSC_VERSIONS, ExportOptions
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.versions import VERSIONS
from engine.interchange.recording import Recording
from tests.engine.interchange.openscenario.conftest import ROAD, recordings, scenario, small, versions, with_lights
from tests.laws import examples
from tests.schemas import findings


def text(of: Recording, version: str) -> str:
    return str(next(iter(write_trajectories(of, "case", ExportOptions(osc=version), ROAD).files.values())))


@pytest.mark.parametrize("version", OSC_VERSIONS)
def test_every_version_is_valid(version: str) -> None:
    """All kinds of events, kinds of actors and the lights pass the schema of the version."""
    assert findings("openscenario", version, text(with_lights(offset=4.0), version)) == []


@given(recordings(), versions)
@examples(60)
def test_any_recording_is_valid(of: Recording, version: str) -> None:
    """Whoever takes part, comes, goes, stands or has whatever name: the schema has nothing to say."""
    assert findings("openscenario", version, text(of, version)) == []


def test_there_is_a_row_for_each_version() -> None:
    """The table has the versions that may be asked for, each under its own name."""
    assert [(name, version.name) for name, version in VERSIONS.items()] == [(name, name) for name in OSC_VERSIONS]


@pytest.mark.parametrize("version", OSC_VERSIONS)
def test_the_revision_is_named(version: str) -> None:
    """The header's revision is that of the version."""
    header = scenario(small(), version).find("FileHeader")
    assert f"{header.get('revMajor')}.{header.get('revMinor')}" == version


@pytest.mark.parametrize(
    ("version", "priority"), [("1.0", "overwrite"), ("1.1", "overwrite"), ("1.2", "override"), ("1.3", "override")]
)
def test_priority_is_called_as_in_the_version(version: str, priority: str) -> None:
    """Rule 4: 1.2 renamed the priority of an event that takes over."""
    assert {event.get("priority") for event in scenario(small(), version).iter("Event")} == {priority}


@pytest.mark.parametrize("version", OSC_VERSIONS[1:])
def test_a_replay_begins_at_the_first_instant(version: str) -> None:
    """Rule 3: "greater or equal" holds at time 0; "greater" would hold a step late, and double the speed of one."""
    root = scenario(small(), version)
    begins = root.find(".//Condition[@name='ego_begins_1']//SimulationTimeCondition")
    assert (begins.get("value"), begins.get("rule")) == ("0", "greaterOrEqual")


def test_a_replay_begins_at_the_first_instant_in_the_first_version() -> None:
    """Rule 3: 1.0 has no "greater or equal", so "greater" than a little before."""
    conditions = list(scenario(small(), "1.0").iter("SimulationTimeCondition"))
    assert {each.get("rule") for each in conditions} == {"greaterThan"}
    begins = scenario(small(), "1.0").find(".//Condition[@name='ego_begins_1']//SimulationTimeCondition")
    assert -0.01 < float(begins.get("value")) < 0.0


def test_the_first_version_has_trajectories_without_references() -> None:
    """1.0 knows no `TrajectoryRef`, later versions want it."""
    assert scenario(small(), "1.0").find(".//FollowTrajectoryAction/Trajectory") is not None
    assert scenario(small(), "1.1").find(".//FollowTrajectoryAction/TrajectoryRef/Trajectory") is not None


def test_the_first_version_wants_a_model_of_pedestrians_and_no_mass_of_vehicles() -> None:
    """The mass stands in a property where the vehicle has no attribute for it."""
    first, second = scenario(small(), "1.0"), scenario(small(), "1.1")
    assert first.find(".//Pedestrian").get("model")
    assert second.find(".//Pedestrian").get("model") is None
    assert first.find(".//Vehicle").get("mass") is None
    assert first.find(".//Vehicle/Properties/Property[@name='cortexc.mass']").get("value") == "1093"
    assert second.find(".//Vehicle").get("mass") == "1093"


@pytest.mark.parametrize(("version", "speed"), [("1.0", "0"), ("1.1", "-2")])
def test_who_begins_backwards(version: str, speed: str) -> None:
    """ScenarioRunner refuses a file with a negative start speed; the trajectory holds the same."""
    backwards = small()
    backwards.states[0, 0, 3] = -2.0
    assert scenario(backwards, version).find(".//AbsoluteTargetSpeed").get("value") == speed
