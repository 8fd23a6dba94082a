"""Files with Scenic's `model` line keep Scenic's meaning of headings and steering; default maps suit what is asked."""

import math

import numpy as np
import pytest

from cortex_dsl import compile_text, ir
from engine.maps import RoadSpec
from engine.vocabulary import Column, Command
from tests.cortex_dsl.semantics.conftest import findings, scenario

MODEL = "param map = localPath('Town05.xodr')\nparam carla_map = 'Town05'\nmodel scenic.simulators.carla.model\n"
HERE = "map intersection()\n"


def heading(text: str) -> float:
    """Of the ego, anticlockwise from the east [rad]."""
    scenario_ = compile_text(text)
    scenes = scenario_.sample(1, seed=3)
    assert scenes.valid[0]
    return math.remainder(float(scenes.values[0][Column.HEADING]), math.tau)


@pytest.mark.parametrize(("head", "north"), [(HERE, math.pi / 2), (MODEL, 0.0)])
def test_absolute_headings_count_from_north_in_scenic(head: str, north: float) -> None:
    """`facing 30 deg` is north of east here, west of north there; reading a heading gives the number written."""
    placed = "ego = new Car at (0, 0), facing 30 deg\n"
    expected = math.radians(30.0) + (math.pi / 2 - north)
    assert heading(head + placed) == pytest.approx(expected)
    assert heading(head + placed.replace("facing", "with heading")) == pytest.approx(expected)
    assert not [
        d for d in findings(head + placed + "require abs(ego.heading - 30 deg) < 0.001 deg\n") if d.code == "SCN423"
    ]


@pytest.mark.parametrize("head", [HERE, MODEL])
def test_relative_headings_mean_the_same(head: str) -> None:
    """What is taken from a lane or an object and turned is turned by the same angle."""
    text = (
        head
        + "lane = intersection.incomingLanes[0]\nspot = new OrientedPoint before intersection by 20 m along [lane]\n"
    )
    assert heading(
        text + "ego = new Car at spot, facing spot.heading + 90 deg, with regionContainedIn None\n"
    ) == pytest.approx(0.0, abs=1e-9)
    assert heading(text + "ego = new Car at spot, facing spot\n") == pytest.approx(-math.pi / 2)


def test_a_copy_of_a_scenic_case_is_the_same_bit_for_bit() -> None:
    """A drawn pose is written as the file counts headings, and read back to the very same number."""
    text = MODEL + "ego = new Car on road\nother = new Car on road\n"
    loaded = compile_text(text)
    scenes = loaded.sample(1, seed=8)
    copy = compile_text(loaded.concrete(scenes, 0))
    again = copy.sample(1, seed=1)
    assert again.values[0].tolist()[:3] == scenes.values[0].tolist()[:3]


def test_steering_of_scenic_is_a_share_to_the_right() -> None:
    """`SetSteerAction(0.5)` is half the full angle to the right there, half a radian to the left here."""
    behaviour = "behavior Turn():\n    take SetSteerAction(0.5)\n"
    ego = "ego = new Car at (0, 40), facing roadDirection, with behavior Turn()\n"
    angles = []
    for head in (HERE, MODEL):
        block = scenario(head + behaviour + ego).variants[0].actors[0].behaviour
        assert block is not None
        (act,) = block
        assert isinstance(act, ir.Scope)
        (take,) = act.body
        assert isinstance(take, ir.Take)
        ((command, value),) = take.commands
        assert command is Command.STEER
        assert isinstance(value, ir.Literal)
        angles.append(value.value)
    assert angles == pytest.approx([0.5, -0.5 * 0.551])
    wrong = MODEL + behaviour.replace("0.5", "30") + ego
    assert "SCN402" in [d.code for d in findings(wrong)]


def test_pedals_of_scenic_stay() -> None:
    """Until they are set again, by an action or a library behaviour; those of other files for one step."""
    behaviour = (
        "behavior Push():\n    take SetThrottleAction(1)\n    wait for 9 steps\n"
        "    take SetThrottleAction(0), SetBrakeAction(0.5)\n    wait for 9 steps\n    take SetBrakeAction(0)\n"
        "    wait for 5 steps\n    take SetBrakeAction(1)\n    do IdleBehavior() for 5 steps\n"
    )
    ego = "ego = new Car at (1.75, -40), facing roadDirection, with speed 5, with drag 0, with behavior Push()\n"
    changes = []
    for head in (HERE, MODEL):
        loaded = compile_text(f"{head}{behaviour}{ego}record ego.speed as speed\nterminate after 30 steps\n")
        (speed,) = loaded.watch(loaded.sample(1, seed=1), 0).records
        changes.append(np.sign(np.round(np.diff(np.asarray(speed.values, float)), 9)).tolist())
    once, held = changes
    assert once[:31] == [1.0] + [0.0] * 9 + [-1.0] + [0.0] * 15 + [-1.0] + [0.0] * (len(once) - 27)
    assert held[:31] == [1.0] * 10 + [-1.0] * 10 + [0.0] * 6 + [-1.0] + [0.0] * (len(held) - 27)


def test_one_note_each_for_map_and_model() -> None:
    """The line that names CARLA's map again is not worth another."""
    assert [d.code for d in findings(MODEL + "ego = new Car on road\n")] == ["SCN442", "SCN443"]


ROW = (
    "param near = Range(20, 25)\nparam far = globalParameters.near + VerifaiRange(10, 20)\n"
    "a = new Car following roadDirection for globalParameters.far\n"
    "b = new Car following roadDirection from a for 30\n"
)
"""Cars ahead of the ego, the last one by 75 m at most."""


@pytest.mark.parametrize(
    ("text", "ways", "lanes", "approach"),
    [
        ("x = 3\n", 4, 1, 50.0),
        ("x = filter(lambda i: i.is3Way, network.intersections)\n", 3, 1, 50.0),
        ("x = filter(lambda i: i.is3Way or i.is4Way, network.intersections)\n", 4, 1, 50.0),
        ("x = [l for l in network.lanes if l.sections[0]._laneToRight is not None]\n", 4, 2, 50.0),
        ("x = [l for l in network.lanes if l.sections[0]._slowerLane is None]\n", 4, 1, 50.0),
        ("FAR = 50\nrequire (distance to intersection) > FAR\n", 4, 1, 100.0),
        ("require (distance from ego to intersection) > 75\n", 4, 1, 130.0),
        ("require (distance to intersection) < 75\n", 4, 1, 50.0),
        (f"{ROW}require (distance to intersection) > 50\n", 4, 1, 150.0),
        (f"{ROW}require (distance to intersection) > 99950\n", 4, 1, 100000.0),
        (ROW, 4, 1, 50.0),
    ],
)
def test_the_default_map_suits_what_the_file_asks_for(text: str, ways: int, lanes: int, approach: float) -> None:
    """T-junctions, neighbouring lanes, and room to be far from the intersection, for a row of cars too."""
    road = scenario(MODEL + "ego = new Car on road\n" + text).road
    assert isinstance(road, RoadSpec)
    assert (road.ways, road.lanes, road.approach) == (ways, lanes, approach)
    (note,) = (d for d in findings(MODEL + "ego = new Car on road\n" + text) if d.code == "SCN442")
    assert f"ways={ways}, lanes={lanes}" in note.cure


WHOLE = '''
"""Constructs of Scenic's own scripts, in a script of our own: a car behind a standing one waits, then passes it."""
param map = localPath('../maps/Town05.xodr')
param carla_map = 'Town05'
model scenic.simulators.carla.model
MODEL = 'vehicle.lincoln.mkz_2017'
param GAP = VerifaiRange(10, 14)
param SPEED = VerifaiRange(7, 9)
PASSING = [12, 18]

behavior Pass():
    while (distance to mover) < 8:
        take SetBrakeAction(1.0)
    sideSec = self.laneSection.laneToRight
    do LaneChangeBehavior(
            laneSectionToSwitch=sideSec,
            target_speed=globalParameters.SPEED)
    do FollowLaneBehavior(target_speed=globalParameters.SPEED)

intersection = Uniform(*filter(lambda i: i.is4Way, network.intersections))
standLane = Uniform(*filter(lambda lane:
    all([sec._laneToRight is not None for sec in lane.sections]),
    intersection.incomingLanes))
standPt = new OrientedPoint in standLane.centerline
moverLane = standLane.sectionAt(standPt).laneToRight.lane
moverManeuver = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, moverLane.maneuvers))
moverTrajectory = [moverLane, moverManeuver.connectingLane, moverManeuver.endLane]
moverPt = new OrientedPoint in moverLane.centerline

standing = new Car at standPt,
    with blueprint MODEL
ego = new Car behind standing by globalParameters.GAP,
    with blueprint MODEL,
    with behavior Pass()
mover = new Car at moverPt,
    with blueprint MODEL,
    with behavior FollowTrajectoryBehavior(target_speed=9, trajectory=moverTrajectory)

require 0 <= (distance from standing to intersection) <= 6
require PASSING[0] <= (distance from mover to intersection) <= PASSING[1]
terminate when (distance to standPt) > 60
'''


def test_a_script_with_scenics_constructs_runs() -> None:
    """It compiles without an error, draws scenes, and the ego ends in the lane to the right of where it began."""
    loaded = compile_text(WHOLE)
    assert isinstance(loaded.program.road_spec, RoadSpec)
    assert loaded.program.road_spec.lanes == 2
    scenes = loaded.sample(20, seed=1)
    assert scenes.valid.any()
    assert not loaded.simulate(scenes).collided[scenes.valid].all()


def test_scenics_intersection_is_all_of_them() -> None:
    """`distance to intersection` is that to the nearest one; in our own files `intersection` has to be one."""
    near = "min(distance from ego to network.intersections[0], distance from ego to network.intersections[1])"
    text = f"map intersection(cols=2)\nego = new Car on road\nrequire abs((distance to {{}}) - {near}) < 1e-9\n"
    for head, word in (("model scenic.simulators.carla.model\n", "intersection"), ("", "network.intersectionRegion")):
        assert compile_text(head + text.format(word)).sample(100, seed=1).valid.all()
    assert "SCN416" in [each.code for each in findings(text.format("intersection"))]
    bare = findings("map road()\nego = new Car in network.intersectionRegion\n")
    assert "SCN448" in [each.code for each in bare]
