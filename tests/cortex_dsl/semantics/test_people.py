"""Walking speeds by age, and the relations of a maneuver to traffic from ahead and from the side."""

import numpy as np
import pytest
from scipy import stats

from cortex_dsl import compile_text
from cortex_dsl.semantics.evaluation.random_values import OLDER, WALKING_DEVIATION, YOUNGER
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
