"""Who begins where, who comes, who goes, and when it ends."""

import pytest
from hypothesis import given

from engine.interchange.recording import Recording
from engine.interchange.xml_writing import Element
from tests.engine.interchange.openscenario.conftest import (
    actor,
    recording,
    recordings,
    scenario,
    small,
    starts,
    versions,
)

NAMED = ("ScenarioObject", "Story", "Act", "ManeuverGroup", "Maneuver", "Event", "Action", "Condition", "Trajectory")


def names(root: Element, tag: str) -> list[str | None]:
    return [each.get("name") for each in root.iter(tag)]


@given(recordings(), versions)
def test_names_are_unique(of: Recording, version: str) -> None:
    """Rule 7: no two elements of a kind have the same name, on whatever level."""
    root = scenario(of, version)
    for tag in NAMED:
        assert len(set(names(root, tag))) == len(names(root, tag)), tag


@given(recordings(), versions)
def test_it_always_ends(of: Recording, version: str) -> None:
    """Rule 7: a stop trigger at the last sample."""
    root = scenario(of, version)
    (stop,) = root.findall("Storyboard/StopTrigger")
    (condition,) = stop.iter("SimulationTimeCondition")
    late = 0.0 if version != "1.0" else 0.001
    assert float(condition.get("value")) + late == pytest.approx(of.time[-1], abs=1e-9)


def test_all_who_are_there_begin_at_their_place() -> None:
    """A place and a speed for each; who comes later has none yet."""
    root = scenario(small())
    assert [each.get("entityRef") for each in root.iter("Private")] == ["ego", "bus_12", "box"]
    assert [each.get("value") for each in root.iter("AbsoluteTargetSpeed")] == ["10", "0", "0"]
    assert len(list(root.find(".//Init").iter("TeleportAction"))) == 3


def test_each_who_moves_has_a_group_of_its_own() -> None:
    """One maneuver group an actor; a box that never moves has none, and no trajectory."""
    root = scenario(small())
    assert names(root, "ManeuverGroup") == ["ego_group", "bus_12_group", "walker_group"]
    for group in root.iter("ManeuverGroup"):
        assert [f"{each.get('entityRef')}_group" for each in group.iter("EntityRef")] == [group.get("name")]


def test_an_actor_comes_goes_and_comes_back() -> None:
    """It is added and taken away at the samples where that is first seen, once for each of its stretches."""
    walker = scenario(small()).find(".//Maneuver[@name='walker_maneuver']")
    what = [(starts(event), [each.tag for action in event.iter("EntityAction") for each in action]) for event in walker]
    assert what == [(0.05, ["AddEntityAction"]), (0.12, ["DeleteEntityAction"]), (0.15, ["AddEntityAction"])]


def test_a_stretch_of_one_sample_has_no_trajectory() -> None:
    """A polyline has two vertices at least; who is there once is put there."""
    comes = scenario(small()).findall(".//Maneuver[@name='walker_maneuver']/Event")[-1]
    assert comes.find(".//FollowTrajectoryAction") is None


def test_no_edge_can_be_missed() -> None:
    """Conditions have no edge: one that holds from the very beginning never rises."""
    conditions = list(scenario(small()).iter("Condition"))
    assert {(each.get("conditionEdge"), each.get("delay")) for each in conditions} == {("none", "0")}


def test_a_scenario_in_which_nothing_moves_has_an_act() -> None:
    """The standard wants one; its group does nothing."""
    root = scenario(recording([actor("car")], [0.0, 0.05], [[(0, 0, 0), (0, 0, 0)]]))
    assert names(root, "ManeuverGroup") == ["car_group"]
    assert not list(root.iter("Event"))
