"""Walking speeds by age, traffic from ahead and from the side of a maneuver, and the time until a light turns red."""

from itertools import permutations

import numpy as np
import pytest
from scipy import stats

from cortex_dsl import compile_text
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.evaluation.lanes import maneuver_by_arms
from cortex_dsl.semantics.evaluation.random_values import OLDER, WALKING_DEVIATION, YOUNGER
from cortex_dsl.semantics.quantities.algebra import NOWHERE
from engine import batch
from engine.maps import RoadSpec
from engine.road import build_network
from engine.vocabulary import Column, ManeuverType

WALKER = """
map road(lanes=1, length=100 m)
ego = new Car on road
new Pedestrian right of ego by 3 m, with speed WalkingSpeed({age}), with regionContainedIn None
"""


@pytest.mark.parametrize(("age", "mean"), [(8, YOUNGER), (60, YOUNGER), (61, OLDER), (90, OLDER)])
def test_walking_speeds_have_the_distribution_of_their_age(age: int, mean: float) -> None:
    """They are normal, cut off at three deviations, as by scipy; the 15th percentile is that of the sources."""
    scenario = compile_text(WALKER.format(age=age))
    scenes = scenario.sample(2000, seed=3)
    values = scenes.values[scenes.valid]
    speeds = values[:, len(Column) + Column.SPEED]
    assert stats.kstest(speeds, stats.truncnorm(-3, 3, mean, WALKING_DEVIATION).cdf).pvalue > 0.001
    assert np.quantile(speeds, 0.15) == pytest.approx(1.15 if age <= 60 else 0.92, abs=0.03)


@pytest.mark.parametrize("age", ["2", "120", "-5", "5 m", '"old"'])
def test_ages_of_nobody_are_refused(age: str) -> None:
    """An age is a number of years from 3 to 110."""
    with pytest.raises(Exception, match="age"):
        compile_text(WALKER.format(age=age))


@pytest.mark.parametrize("ways", [3, 4])
@pytest.mark.parametrize("lanes", [1, 2])
def test_traffic_comes_from_ahead_or_from_the_side(ways: int, lanes: int) -> None:
    """Each conflicting maneuver is oncoming, crossing, or comes the same way; oncoming is mutual."""
    network = build_network(RoadSpec(ways=ways, lanes=lanes))
    for maneuver in network.maneuvers:
        oncoming, crossing = maneuver.oncoming_maneuvers, maneuver.crossing_maneuvers
        assert not set(map(id, oncoming)) & set(map(id, crossing))
        assert all(maneuver in other.oncoming_maneuvers for other in oncoming)
        assert all(other in maneuver.conflicting_maneuvers for other in crossing)
        rest = [m for m in maneuver.conflicting_maneuvers if m not in oncoming and m not in crossing]
        assert all(m.start_lane.road == maneuver.start_lane.road for m in rest)
        if ways == 4 and maneuver.type is ManeuverType.LEFT_TURN:
            assert any(m.type is ManeuverType.STRAIGHT and m in maneuver.conflicting_maneuvers for m in oncoming)


LIGHT = """
map intersection(approach=100 m)
signals(green=6 s, yellow=2 s, all_red=1 s, offset={offset} s)
lane = intersection.incomingLanes[{arm}]
monitor Turns():
    while getTrafficLightStatus(lane.signal) == "red":
        wait
    while not getTrafficLightStatus(lane.signal) == "red":
        wait
    terminate
require monitor Turns()
ego = new Car on lane.centerline, with speed lane.signal.timeToRed * 1 m/s^2, with behavior BrakeBehavior()
terminate after 30 s
"""


@pytest.mark.parametrize("arm", [0, 1])
@pytest.mark.parametrize("offset", [0.0, 3.02, 7.5, 11.0, -4.0, 40.0])
def test_a_light_turns_red_at_the_time_that_it_tells(arm: int, offset: float) -> None:
    """The run ends at the first sample at which the light has turned red, whatever it showed at the start."""
    scenario = compile_text(LIGHT.format(offset=offset, arm=arm))
    scenes = scenario.sample(1, seed=1)
    told = scenes.values[0, Column.SPEED]
    ended = batch.simulate(scenario.program, scenes, scenario.config.simulation).end_time[0]
    assert 0.0 <= told < 18.0
    assert told - 1e-9 <= ended <= told + 0.05 + 1e-9


@pytest.mark.parametrize("lanes", [1, 2])
@pytest.mark.parametrize("ways", [3, 4])
def test_a_route_leads_from_arm_to_arm(ways: int, lanes: int) -> None:
    """It begins on the first arm and ends on the second; no other maneuver between them is nearer to the kerb."""
    place = build_network(RoadSpec(ways=ways, lanes=lanes)).intersections[0]
    legs = {leg.name: leg for leg in place.legs}
    for start, end in permutations(legs, 2):
        way = maneuver_by_arms(place, NOWHERE, start, end)
        assert way.start_lane in legs[start].incoming_lanes
        assert way.end_lane in legs[end].outgoing_lanes
        for other in place.maneuvers:
            if other.start_lane in legs[start].incoming_lanes and other.end_lane in legs[end].outgoing_lanes:
                assert way.start_lane.number <= other.start_lane.number


@pytest.mark.parametrize("arms", ['"south", "norht"', '"south", "south"', "1, 2", '"south"'])
def test_ways_between_arms_that_do_not_exist_are_refused(arms: str) -> None:
    with pytest.raises(CompileError):
        compile_text(f"map intersection()\nway = intersection.route({arms})\nego = new Car on road\n")
