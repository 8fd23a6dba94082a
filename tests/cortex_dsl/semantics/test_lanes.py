"""Lane sections, groups and roads, for the compiler and for the run."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from tests.cortex_dsl.semantics.conftest import findings, scenario

Compiled = Callable[..., ir.Scenario]
WIDE = "map intersection(lanes=2)\n"
EGO = "ego = new Car in network.lanes[0].centerline\n"
ALWAYS, NEVER = "SCN480", "SCN423"
"""What is said of a requirement that always or never holds."""


def holds(condition: str, head: str = WIDE) -> bool:
    """Return whether the compiler can prove that a condition on the road is true."""
    codes = [d.code for d in findings(f"{head}{EGO}require {condition}\n")]
    assert len(codes) == 1
    assert codes[0] in (ALWAYS, NEVER), codes
    return codes[0] == ALWAYS


@pytest.mark.parametrize(
    "condition",
    [
        "network.lanes[0].sections[0].lane is network.lanes[0]",
        "network.lanes[0].sectionAt((0, 40)) is network.lanes[0].sections[0]",
        "network.lanes[0].sections[0].laneToLeft.lane is network.lanes[1]",
        "network.lanes[0].sections[0]._laneToRight is None",
        "network.lanes[1].sections[0].slowerLane.lane is network.lanes[0]",
        "network.lanes[1].sections[0]._fasterLane is None",
        "network.lanes[1].sections[0].laneToLeft.isForward is not network.lanes[1].isForward",
        "network.lanes[0].group.lanes[1] is network.lanes[1]",
        "network.lanes[0].road is network.roads[0]",
        "len(network.roads) == 4 and len(network.laneGroups) == 8",
        "len(network.laneSections) == len(network.lanes)",
        "len(network.roads[0].forwardLanes.lanes) == 2",
        "network.roads[0].backwardLanes is network.roads[0].forwardLanes.opposite",
        "len(network.lanes[0].adjacentLanes) == 1 and len(network.lanes[1].adjacentLanes) == 2",
        "intersection.roads[0] is network.roads[0]",
        "not intersection.isSignalized and len(intersection.signals) == 0",
    ],
)
def test_what_the_compiler_knows_of_lanes(condition: str) -> None:
    """Neighbours, groups and roads of a four-way intersection with two lanes a direction."""
    assert holds(condition)
    assert not holds(f"not ({condition})")


def test_left_hand_traffic_is_mirrored() -> None:
    """The lane at the kerb has its neighbour on the right, which is the faster one."""
    head = "map intersection(lanes=2, left_hand=True)\n"
    assert holds("network.lanes[0].sections[0]._laneToLeft is None", head)
    assert holds("network.lanes[0].sections[0].fasterLane is network.lanes[0].sections[0].laneToRight", head)


def test_a_lane_that_must_be_there_rejects_the_variant() -> None:
    """`laneToRight` of the lane at the kerb, as in Scenic; the other lanes go on."""
    compiled = scenario(
        WIDE + "start = Uniform(network.lanes[0], network.lanes[1])\n"
        "beside = start.sections[0].laneToRight.lane\nego = new Car in beside.centerline\n"
    )
    assert [variant.rejection for variant in compiled.variants] == ["`north.in.1` has no `laneToRight`", None]


def test_an_object_knows_its_lane_before_the_run() -> None:
    """The lane of a centre line is known; that of a place on the road is a matter of each scene."""
    assert holds("ego.lane is network.lanes[0] and ego.laneSection._laneToRight is None")
    assert not findings(WIDE + "ego = new Car on road\nrequire ego.laneSection._fasterLane is None\n")


def test_lanes_of_the_run_are_looked_up() -> None:
    """A neighbour during the run is a table over the lane's number, remembered when the name is assigned."""
    compiled = scenario(
        WIDE
        + "behavior Over():\n    beside = self.laneSection.laneToLeft\n    do LaneChangeBehavior(beside)\n"
        + "    do FollowLaneBehavior(5 m/s, laneToFollow=beside.lane) until self.lane is not ego.lane\n"
        + EGO
        + "new Car in network.lanes[0].centerline, with behavior Over()\n"
    )
    scope = compiled.variants[0].actors[1].behaviour
    assert scope is not None
    assert isinstance(scope[0], ir.Scope)
    first = scope[0].body[0]
    assert isinstance(first, ir.SetLocal)
    assert compiled.pool


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("new Pedestrian on network.sidewalks[0]", "SCN450"),
        ("new Pedestrian on network.lanes[0].group.sidewalk", "SCN450"),
        ("x = network.lanes[0].sections[0].laneToLef", "SCN203"),
        ("new Car on road, with behavior LaneChangeBehavior(None)", "SCN303"),
        ("new Car on road, with behavior LaneChangeBehavior(3)", "SCN303"),
        ("new Pedestrian on road, with behavior LaneChangeBehavior(network.lanes[0])", "SCN631"),
        ("new Car on road, with behavior GapAcceptanceBehavior(5, [network.lanes[0]])", "SCN632"),
        ("new Car on road, with behavior EmergencyBrakeBehavior(3)", "SCN303"),
        ("terminate when ego.lane.maneuvers is None", "SCN630"),
        ("x = network.lanes[0].centerline[2]", "SCN424"),
    ],
)
def test_mistakes_are_named(line: str, code: str) -> None:
    """Each with its own code."""
    found = [d.code for d in findings(WIDE + EGO + line + "\n")]
    assert code in found, found
