"""Windows of lanes on a crossing: where they begin and end, and that every way onto the crossing has one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.maps import LoneRoad, MapSpec, RoadSpec, Roundabout
from engine.road import build_network
from engine.road.approaches import REACH, SPACING, approaches
from engine.road.linking import NOWHERE
from engine.road.network import Surface, SurfaceKind
from engine.road.regions import distance
from tests.laws import examples

SPECS = st.one_of(
    st.builds(
        RoadSpec,
        ways=st.sampled_from([3, 4]),
        lanes=st.sampled_from([1, 2]),
        approach=st.floats(30.0, 120.0),
        sidewalk=st.just(2.0),
        crossings=st.just(True),
        crossing_width=st.floats(2.0, 6.0),
        left_hand=st.booleans(),
    ),
    st.builds(
        LoneRoad,
        lanes=st.sampled_from([1, 2]),
        length=st.just(300.0),
        curve=st.sampled_from([None, 120.0, -90.0]),
        sidewalk=st.just(2.0),
        parking=st.sampled_from([None, 2.2]),
        crossings=st.tuples(st.floats(40.0, 250.0)),
    ),
    st.builds(Roundabout, sidewalk=st.just(2.0), crossings=st.just(True)),
)


def crossings(spec: MapSpec) -> list[Surface]:
    return [each for each in build_network(spec).surfaces if each.kind is SurfaceKind.CROSSING]


@examples(12, dear=True)
@given(SPECS)
def test_a_window_is_the_part_of_a_lane_on_the_crossing(spec: MapSpec) -> None:
    """Just inside its ends the lane's strip touches the crossing; a metre outside of them it does not."""
    for crossing in crossings(spec):
        network = crossing.network
        for lane, window in zip(network.lanes, approaches(crossing), strict=True):
            if window is NOWHERE or window.enter >= lane.length:
                continue
            for s, touches in ((window.enter, True), (window.leave, True), (window.enter - 1.0, False)):
                if 0.0 < s < lane.length:
                    pose = network.paths.pose(lane.path, s)
                    apart = distance(crossing.shape, pose.x, pose.y)
                    assert (apart <= 0.5 * lane.width + SPACING) if touches else apart > 1.0 - 4.0 * SPACING


@examples(12, dear=True)
@given(SPECS)
def test_whoever_drives_onto_a_crossing_has_been_in_a_window(spec: MapSpec) -> None:
    """Every lane within reach that leads onto the crossing has a window beyond its end, the nearest of its ways."""
    for crossing in crossings(spec):
        windows = approaches(crossing)
        for lane in crossing.network.lanes:
            onward = [lane.length + windows[each.id].enter for each in lane.successors]
            own = windows[lane.id].enter
            if own >= lane.length:
                nearest = min(onward, default=np.inf)
                assert own == pytest.approx(nearest) or (own == np.inf and nearest - lane.length > REACH)


def test_both_directions_of_a_road_cross_it() -> None:
    """On a road of one lane a direction both have a window, of the width of the crossing."""
    (crossing,) = crossings(LoneRoad(length=200.0, sidewalk=2.0, crossings=(80.0,), crossing_width=4.0))
    (one, other) = approaches(crossing)
    assert (one.enter, one.leave) == pytest.approx((78.0, 82.0))
    assert (other.enter, other.leave) == pytest.approx((118.0, 122.0))
