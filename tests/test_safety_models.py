"""Drivers by published models: responsibility-sensitive safety, both models of UN R157, and MOBIL."""

import math

import numpy as np
import pytest

from cortex_dsl.semantics.acting import safety_models
from engine.kernels.crossing import CLEARANCE
from engine.metrics.values import RESPONSIBILITY
from engine.tables import Floats
from engine.vocabulary import State
from tests.test_driving_library import gaps, states

STEP = 0.05
FOLLOWING = """
map intersection(approach=400 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by {behind} m along [lane], with speed {speed} m/s,
    with behavior {model}(FollowLaneBehavior({speed} m/s))
lead = new Car before intersection by 200 m along [lane], with speed {lead} m/s, with behavior {does}
terminate after {time} s
"""
GRIPPING = 8.0
"""Deceleration of a car at full brakes [m/s^2]."""


def follow(model: str, behind: float, speed: float, lead: float, does: str = "", time: float = 10) -> Floats:
    does = does or f"ConstantSpeedBehavior({lead} m/s)"
    text = FOLLOWING.format(model=model, behind=behind, speed=speed, lead=lead, does=does, time=time)
    return states(text)[1]


def first(run: Floats) -> int:
    """The sample at which the ego's brakes are asked for; they build up from the next one on."""
    return int(np.flatnonzero(run[:, 0, State.BRAKE] > 0.0)[0]) - 1


# -- responsibility-sensitive safety -----------------------------------------------------------------------------------


def safe_gap(behind: float, leading: float) -> float:
    """Definition 1 of the paper [m]."""
    faster = behind + 1.0 * 3.5
    return behind * 1.0 + 0.5 * 3.5 * 1.0**2 + faster**2 / (2 * 4.0) - leading**2 / (2 * 8.0)


def test_rss_has_the_parameters_of_the_metric() -> None:
    """One set of numbers in the house."""
    model = safety_models
    lanes = (model.RESPONSE, model.SPEEDING_UP, model.LEADER_BRAKING, model.LEAST_BRAKING, model.IN_LANE_BRAKING)
    assert (*lanes, model.DRIFTING, model.DRIFT_BRAKING, model.DRIFT_MARGIN) == tuple(RESPONSIBILITY)


@pytest.mark.parametrize(("speed", "lead"), [(15.0, 10.0), (20.0, 5.0), (12.0, 0.0)])
def test_rss_brakes_from_the_safe_distance_on(speed: float, lead: float) -> None:
    """From the first sample that is nearer than definition 1 allows, and no sooner."""
    run = follow("RSSBehavior", 320, speed, lead, time=20)
    begun = first(run)
    apart = gaps(run)
    assert apart[begun] < safe_gap(speed, lead) + 0.3
    assert apart[begun - 1] > safe_gap(speed, lead) - 0.3
    assert apart.min() > 1.0


@pytest.mark.parametrize("lead", [8.0, 12.0, 18.0])
def test_who_keeps_the_distance_of_rss_never_runs_into_a_leader_that_brakes_fully(lead: float) -> None:
    """The theorem of the paper, with the leader's full brakes of 8 m/s^2."""
    speed = 15.0
    behind = 200.0 + 4.508 + max(safe_gap(speed, lead), 0.0) + 0.5
    run = follow("RSSBehavior", behind, speed, lead, "BrakeBehavior()")
    assert gaps(run).min() > 0.0
    assert run[-1, 0, State.SPEED] < 0.5


# -- the careful driver of UN R157 -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("closing", "avoids"), [(5.0, True), (6.5, True), (10.0, False)])
def test_the_careful_driver_brakes_late_and_hard(closing: float, avoids: bool) -> None:
    """A risk from 2 s before contact, brakes 1.15 s later, 0.774 g within 0.6 s: so much closing speed it can lose."""
    run = follow("CarefulDriverBehavior", 280, closing + 10.0, 10.0, time=20)
    apart, begun = gaps(run), first(run)
    risk = int(np.flatnonzero(apart < 2.0 * closing)[0])
    assert begun - risk == pytest.approx(1.15 / STEP, abs=3)
    assert (apart.min() > CLEARANCE) == avoids
    pedal = run[begun + 14 : begun + 16, 0, State.BRAKE]
    assert pedal.max() == pytest.approx(0.774 * 9.81 / GRIPPING, abs=0.01)


# -- the fuzzy safety model --------------------------------------------------------------------------------------------


def fuzzy_braking(gap: float, speed: float, lead: float, acceleration: float) -> float:
    """PFS and CFS by the paper, point by point."""
    reach = 0.75 * speed - lead**2 / 14.0
    unsafe, safe = reach + speed**2 / 12.0, reach + speed**2 / 8.0 + 2.0
    proactive = float(np.interp(gap - 2.0, [unsafe, safe], [1.0, 0.0]))
    critical = 0.0
    if speed > lead:
        slowing = max(acceleration, -4.0)
        after = speed + 0.75 * slowing
        if after < lead:
            critical = float(gap < (speed - lead) ** 2 / (2.0 * abs(slowing)))
        else:
            gone = ((speed + after) / 2.0 - lead) * 0.75
            critical = float(np.interp(gap, [gone + (after - lead) ** 2 / x for x in (12.0, 8.0)], [1.0, 0.0]))
    return 4.0 + 2.0 * critical if critical > 0.0 else 4.0 * proactive


@pytest.mark.parametrize(("speed", "lead"), [(15.0, 8.0), (22.0, 2.0), (12.0, 0.0)])
def test_the_fuzzy_model_brakes_by_its_metrics(speed: float, lead: float) -> None:
    """Sample by sample from 0.75 s after the first reaction on, no faster than 12.65 m/s^3."""
    run = follow("FuzzySafetyBehavior", 320, speed, lead, time=20)
    apart = gaps(run) - CLEARANCE
    wanted = [
        fuzzy_braking(apart[k], run[k, 0, State.SPEED], lead, run[k, 0, State.ACCELERATION]) for k in range(len(run))
    ]
    begun = int(np.flatnonzero(np.array(wanted) > 0.0)[0])
    moving = [k for k in range(begun + 16, begun + 60) if run[k, 0, State.SPEED] > max(lead, 0.5)]
    asked = [min(wanted[k], 12.65 * ((k - begun) * STEP - 0.75)) / GRIPPING for k in moving]
    np.testing.assert_allclose(run[np.array(moving) + 1, 0, State.BRAKE], asked, atol=0.02)
    assert not run[: begun + 16, 0, State.BRAKE].any()
    assert gaps(run).min() > 0.5


CUTS_IN = """
map intersection(approach=400 m, lanes=2)
inner = filter(lambda lane: lane.sections[0]._laneToRight is not None, intersection.incomingLanes)[0]
behavior CutsIn():
    do LaneChangeBehavior(inner, target_speed={lead} m/s, duration=3 s)
    do FollowLaneBehavior({lead} m/s)
ego = new Car before intersection by 300 m along [inner], with speed 20 m/s, with behavior {model}
spot = new OrientedPoint ahead of ego by {ahead} m
other = new Car right of spot by 2.5 m, with speed {lead} m/s, with behavior CutsIn()
terminate after 8 s
"""


@pytest.mark.parametrize("model", ["RSSBehavior", "CarefulDriverBehavior", "FuzzySafetyBehavior"])
def test_all_three_models_see_who_cuts_in_before_it_is_in_the_way(model: str) -> None:
    """At 14 m/s, 20 m ahead of an ego of 20 m/s, which would hit it; brakes act while it still has room beside."""
    driver = f"{model}(FollowLaneBehavior(20 m/s))"
    _, blind = states(CUTS_IN.format(model="FollowLaneBehavior(20 m/s)", lead=14, ahead=22))
    _, run = states(CUTS_IN.format(model=driver, lead=14, ahead=22))
    assert np.hypot(*(blind[-1, 1, :2] - blind[-1, 0, :2])) < 5.0
    assert np.hypot(*(run[:, 1, :2] - run[:, 0, :2]).T).min() > 5.0
    assert run[:, 0, State.BRAKE].max() > 0.3


# -- MOBIL -------------------------------------------------------------------------------------------------------------

LANES = """
map intersection(approach=600 m, lanes=2)
lane = filter(lambda lane: lane.sections[0]._laneToLeft is not None, intersection.incomingLanes)[0]
beside = lane.sections[0].laneToLeft
ego = new Car before intersection by 500 m along [lane], with speed 15 m/s,
    with behavior LaneChoosingBehavior(20 m/s{more})
slow = new Car before intersection by {slow} m along [lane], with speed 8 m/s, with behavior FollowLaneBehavior(8 m/s)
fast = new Car before intersection by {fast} m along [beside.lane], with speed {speed} m/s,
    with behavior FollowLaneBehavior({speed} m/s)
terminate after {time} s
"""


def changes(slow: float = 460, fast: float = 300, speed: float = 15, more: str = "", time: float = 4) -> bool:
    """Whether the ego leaves its lane."""
    _, run = states(LANES.format(slow=slow, fast=fast, speed=speed, more=more, time=time))
    across = run[:, 0, :2] - run[0, 0, :2]
    heading = run[0, 0, State.HEADING]
    return bool(np.abs(across @ np.array([-math.sin(heading), math.cos(heading)])).max() > 0.5)


def test_mobil_overtakes_who_is_slower_where_there_is_room() -> None:
    """It gains by it, and hinders nobody."""
    assert changes()


def test_mobil_stays_where_there_is_nothing_to_gain() -> None:
    """The slow one is far away, and the other lane no better."""
    assert not changes(slow=120, fast=100, speed=15)


def test_mobil_makes_nobody_brake_harder_than_is_safe() -> None:
    """One of 25 m/s who is 13 m behind would have to brake harder than 4 m/s^2."""
    lone = ", politeness=0, max_acceleration=2 m/s^2"
    assert not changes(fast=518, speed=25, more=lone, time=2)
    assert changes(fast=518, speed=25, more=f"{lone}, safe_deceleration=1000 m/s^2", time=2)


def test_politeness_weighs_the_loss_of_others() -> None:
    """One of 17 m/s, 35 m behind, loses more than the ego gains, but has not to brake hard."""
    lone = ", max_acceleration=2 m/s^2, safe_deceleration=9 m/s^2"
    assert changes(slow=455, fast=535, speed=17, more=f"{lone}, politeness=0")
    assert not changes(slow=455, fast=535, speed=17, more=f"{lone}, politeness=5")
