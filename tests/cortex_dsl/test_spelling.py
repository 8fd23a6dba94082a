"""The one helper for words that are nearly right."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.pipeline import compile_source
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.source import Source
from cortex_dsl.spelling import ELSEWHERE, SYNONYMS, class_called, did_you_mean, likely_range, nearest

TURNS = ("STRAIGHT", "LEFT_TURN", "RIGHT_TURN", "U_TURN")


@pytest.mark.parametrize(
    ("word", "meant"),
    [("RIGHT", "RIGHT_TURN"), ("LEFT", "LEFT_TURN"), ("left_trun", "LEFT_TURN"), ("STRAIGT", "STRAIGHT"), ("x", None)],
)
def test_nearest(word: str, meant: str | None) -> None:
    """A word that begins another is meant for it; else letters decide."""
    assert nearest(word, TURNS) == meant


def test_letters_that_changed_places() -> None:
    """The same letters in another order come before other letters."""
    assert nearest("eog", ("log", "ego", "egg")) == "ego"


@pytest.mark.parametrize("name", ["lane_width", "corner_radius"])
def test_a_word_of_a_name(name: str) -> None:
    """Is meant for the name, as its beginning is."""
    assert nearest(name.split("_")[-1], (name, "approach", "light")) == name


def test_of_several_beginnings_the_shortest() -> None:
    """What was nearly finished is meant."""
    assert nearest("lane", ("laneToLeft", "lanes", "laneSection")) == "lanes"


@pytest.mark.parametrize(
    ("word", "meant"),
    [("truck", "Truck"), ("lorry", "Truck"), ("walker2", "Pedestrian"), ("Child", "Pedestrian"), ("adversary", None)],
)
def test_class_called(word: str, meant: str | None) -> None:
    """What people call things, and their numbers."""
    assert class_called(word, ("Car", "Truck", "Pedestrian")) == meant


def test_likely_range() -> None:
    """By a part of the name."""
    assert likely_range("EGO_SPEED") == "Range(20, 60) km/h"
    assert likely_range("COLOUR") == "Range(LOW, HIGH)"


@pytest.mark.parametrize("word", ["pavement", "footpath", "footway"])
def test_no_sidewalk(word: str) -> None:
    """The cure is a place beside the road that compiles."""
    place, argument = re.findall(r"`(\S*sidewalk.*?)`", did_you_mean(word, ()))
    text = f"map intersection({argument})\nego = new Car on road\nnew Pedestrian on {place}\n"
    assert compile_source(Source("cured.scn", text)).diagnostics == ()


FOREIGN = {
    "BasicAgent": "AutopilotBehavior",
    "BasicAgentBehavior": "AutopilotBehavior",
    "BehaviorAgent": "AutopilotBehavior",
    "ChangeAutoPilot": "AutopilotBehavior",
    "DrivingBehavior": "AutopilotBehavior",
    "TrafficManager": "AutopilotBehavior",
    "set_autopilot": "AutopilotBehavior",
    "FollowLeadBehavior": "CarFollowingBehavior",
    "StopBehavior": "BrakeBehavior",
    "StopVehicle": "BrakeBehavior",
    "HandBrakeVehicle": "BrakeBehavior",
    "KeepVelocity": "ConstantSpeedBehavior",
    "ConstantVelocityAgent": "ConstantSpeedBehavior",
    "WaypointFollower": "FollowTrajectoryBehavior",
    "TrackWaypointsAction": "FollowTrajectoryBehavior",
    "LaneChange": "LaneChangeBehavior",
    "CutIn": "LaneChangeBehavior",
    "SyncArrival": "CrossingBehavior",
    "AccelerateForwardBehavior": "ConstantThrottleBehavior",
    "AccelerateToVelocity": "ConstantThrottleBehavior",
    "WalkerControl": "WalkForwardBehavior",
    "SetWalkAction": "SetWalkingSpeedAction",
    "SetGearAction": "SetReverseAction",
    "SetTrafficLightAction": "setClosestTrafficLightStatus",
    "RegulatedControlAction": "SetThrottleAction",
    "VehicleControl": "SetThrottleAction",
    "InTriggerDistanceToVehicle": "distance from",
    "InTimeToArrivalToVehicle": "timeToCollision",
    "ttc": "timeToCollision",
    "pet": "post_encroachment_time",
    "TriggerVelocity": "ego.speed >",
    "StandStill": "ego.speed <",
    "TimeOut": "terminate after",
    "CollisionTest": "contact",
    "OffRoadTest": "in road",
    "VerifaiParameter": "Range",
    "rho": "expect",
    "blueprint": "new Truck",
    "weather": "environment(",
    "egoSpeed": "ego.speed",
    "get_transform": "ego.heading",
    "simulationTime": "currentTime",
    "fixed_delta_seconds": "timestep",
    "is_junction": "in intersection",
    "FollowLeader": "CarFollowingBehavior",
    "EmergencyStop": "BrakeBehavior",
    "set_destination": "FollowTrajectoryBehavior",
    "waypoint": "OrientedPoint",
    "npc": "Car",
    "way": "road",
    "EgoCar": "Car",
    "Cone": "Obstacle",
}


@pytest.mark.parametrize(("word", "meant"), FOREIGN.items())
def test_names_of_other_tools_are_answered_by_meaning(word: str, meant: str) -> None:
    """Names of CARLA, ScenarioRunner, Scenic and VerifAI."""
    assert meant in did_you_mean(word, BUILTINS)


CURES = sorted({code for word in FOREIGN for code in re.findall("`([^`]+[ (_][^`]+)`", ELSEWHERE.get(word, ""))})


@pytest.mark.parametrize("text", CURES)
def test_what_a_cure_proposes_compiles(text: str) -> None:
    """Numbers, conditions, behaviors, actions and statements of the table of foreign words, in a file of their own."""
    text = text.replace("(low, high)", "(1, 2)")
    inside = text if text.startswith(("do ", "take ")) else "wait"
    if text.startswith("with "):
        text = f"new Car on road, {text}"
    elif text.startswith(("least(", "post_encroachment_time")):
        text = f"minimize {text}"
    elif inside == text:
        text = ""
    elif not text.startswith(("require", "terminate", "record", "new ", "environment(")):
        text = f"record {text}"
    first, text = (text, "") if text.startswith("environment(") else ("", text)
    lines = ("map intersection()", first, "behavior B():", f"    {inside}", "ego = new Car on road, with behavior B()")
    compile_source(Source("cure.scn", "\n".join((*lines, "other = new Car on road", text, ""))))


@pytest.mark.parametrize("word", [*ELSEWHERE, *SYNONYMS])
def test_a_name_of_the_file_comes_before_all_tables(word: str) -> None:
    """What differs from it only by capitals or underscores is meant for it, whatever the word means elsewhere."""
    own = f"{word[0]}_{word[1:]}".upper()
    assert did_you_mean(word, [own, "Car", "speed"]) == f"did you mean `{own}`?"


@given(st.text("abcdefgh", min_size=1, max_size=10), st.lists(st.text("abcdefgh", min_size=1, max_size=10)))
def test_no_unrelated_word_is_near(word: str, candidates: list[str]) -> None:
    """What differs in every letter is not offered, however few letters there are."""
    meant = nearest(word, candidates)
    assert meant is None or set(word) & set(meant)


@pytest.mark.parametrize(
    ("word", "candidate"),
    [
        ("deceleration", "SetSteerAction"),
        ("way", "any"),
        ("StopBehavior", "RSSBehavior"),
        ("BehaviorAgent", "RSSBehavior"),
        ("pet", "get"),
    ],
)
def test_of_short_words_one_letter_may_differ(word: str, candidate: str) -> None:
    """The common ending of two names counts for nothing; of three letters one may be wrong."""
    assert nearest(word, [candidate]) == (candidate if word == "pet" else None)
