"""Numbers that the library shares with the engine and with its reference: each has copies, which agree."""

import re
from functools import cache

import pytest

from cortex_dsl import compile_text
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.semantics.acting import following, job
from cortex_dsl.semantics.names.builtins import BUILTINS, Builtin, Kind, Parameter
from engine.batch import trajectory
from engine.kernels import steering
from engine.tables import Floats

SCENE = """
map intersection(approach=60 m, lanes=2{streets})
turn = filter(lambda m: m.type is ManeuverType.LEFT_TURN, intersection.maneuvers)[0]
across = filter(lambda m: m.type is ManeuverType.STRAIGHT, turn.conflictingManeuvers)[0]
ego = new Car before intersection by 40 m along turn, with speed 9 m/s,
    with behavior FollowTrajectoryBehavior(9 m/s, turn)
driver = {driver}
terminate after 8 s
"""
CAR = "new Car before intersection by 30 m along across, with speed 9 m/s, with behavior {}"
PERSON = "new Pedestrian at (20 m, 30 m), with regionContainedIn None, with behavior {}"
ON_FOOT = ("UseCrossingBehavior", "WalkAlongBehavior")
NEEDED = {
    "trajectory": "across",
    "behavior": "FollowTrajectoryBehavior(9 m/s, across)",
    "speed": "9 m/s",
    "laneSectionToSwitch": "across.startLane",
    "reference_actor": "ego",
    "crossing": "intersection.crossings[0]",
    "sidewalk": "network.sidewalks[0]",
    "x": "0.4",
    "distance": "3 m",
    "deceleration": "2 m/s^2",
    "track": '"time,x,y,heading,speed\\n0,0,0,0,8\\n1,8,0,0,8"',
}
"""Argument for each parameter without a default, and for `trajectory`; a new parameter needs a row here."""
WRITTEN = re.compile(r"True|False|\"\w+\"|[\d.* ]+( \S+)?")
"""A default that is an expression of the language; others say in words how the behavior finds one."""
DEFAULTS = [
    pytest.param(row, parameter, id=f"{row.name}-{parameter.name}")
    for row in BUILTINS.values()
    for parameter in row.parameters
    if row.kind is Kind.BEHAVIOUR and parameter.default is not None and WRITTEN.fullmatch(parameter.default)
]


@cache
def driven(behaviour: str, *more: str) -> Scenario:
    rows = BUILTINS[behaviour].parameters
    needed = [f"{p.name}={NEEDED[p.name]}" for p in rows if p.default is None or p.name == "trajectory"]
    driver, streets = (PERSON, ", sidewalk=2 m, crossings=True") if behaviour in ON_FOOT else (CAR, "")
    call = f"{behaviour}({', '.join((*needed, *more))})"
    return compile_text(SCENE.format(driver=driver.format(call), streets=streets))


def states(scenario: Scenario) -> Floats:
    return trajectory(scenario.program, scenario.sample(1, seed=3), 0, scenario.config.simulation).states


@pytest.mark.parametrize(("row", "parameter"), DEFAULTS)
def test_a_default_of_the_reference_is_the_value_that_the_behavior_has_without_the_argument(
    row: Builtin, parameter: Parameter
) -> None:
    """Written out, it gives the same program, or one that drives the same."""
    assert parameter.default is not None
    without, written = driven(row.name), driven(row.name, f"{parameter.name}={parameter.default}")
    same = without.program.digest == written.program.digest
    assert same or states(without).tobytes() == states(written).tobytes()


def test_the_speed_controller_is_the_engines() -> None:
    """Gain, planned deceleration, preview, and the limit of what is asked for."""
    assert steering.SPEED_GAIN == job.SPEED_GAIN
    assert steering.PLANNED_BRAKING == job.STOPPING
    assert steering.SPEED_PREVIEW == job.STOP_PREVIEW
    assert steering.MAX_BRAKING == following.BRAKING_LIMIT


def test_the_steering_law_is_the_engines() -> None:
    """Preview, look-ahead, and the share of it above which offsets are clipped."""
    assert steering.PREVIEW == following.PREVIEW
    assert steering.LOOK_AHEAD == following.LOOK_AHEAD
    assert steering.MIN_LOOK_AHEAD == following.MIN_LOOK_AHEAD
    assert steering.OFFSET_SHARE == following.OFFSET_SHARE
