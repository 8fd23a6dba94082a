"""Reference drivers: who gives way, and the emergency brake along ways, in both hosts, and on the examples."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.drivers import DRIVERS, EXAMPLES, ROOT, DrivenBlock, driven, goes_there, main, rows, text_of
from cortex_dsl import compile_text
from cortex_dsl.semantics.acting import giving_way
from engine.batch import trajectory
from engine.kernels.crossing import BESIDE, CLEARANCE
from engine.outcomes import Outcomes
from engine.sampling import sample
from engine.streams import key_rows
from engine.tables import Floats
from engine.vocabulary import Method, State
from tests.test_driving_library import CAR_LENGTH, states

TURN = """
map intersection(approach=100 m)
turn = filter(lambda m: m.type is ManeuverType.LEFT_TURN, intersection.maneuvers)[0]
oncoming = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, turn.conflictingManeuvers))
ego = new Car before intersection by 40 m along turn, with speed 9 m/s, with behavior {driver}
other = new Car before intersection by {distance} m along oncoming, with speed 10 m/s,
    with behavior FollowTrajectoryBehavior(10 m/s, oncoming)
terminate after 20 s
"""
GIVES_WAY = "GivingWayBehavior(9 m/s, turn)"
BRAKES = "EmergencyBrakeBehavior(FollowTrajectoryBehavior(9 m/s, turn))"
INSIDE = 9.5
"""From the middle of the intersection to its stop lines [m]."""


def one_scene(file: str, number: int) -> DrivenBlock:
    """One of the scenes of the table, with who gives way."""
    one = driven(text_of(file, "gives way"), number, number + 1, 1)
    assert one.scenes.valid.all()
    return one


def distance_apart(run: Floats) -> float:
    return float(np.hypot(*(run[:, 1, :2] - run[:, 0, :2]).T).min())


@pytest.mark.parametrize("driver", [GIVES_WAY, BRAKES])
@pytest.mark.parametrize("distance", [40, 55, 70])
def test_a_driver_stops_before_the_area_and_clears_it(driver: str, distance: float) -> None:
    """The blind driver, whatever it meets, goes on; the others wait, if need be, outside, and get through."""
    _, run = states(TURN.format(driver=driver, distance=distance))
    ego = run[:, 0]
    there = ego[:, State.PRESENT] != 0.0
    slow = there & (ego[:, State.SPEED] < 0.1)
    middle = np.abs(ego[:, :2]).max(axis=1)
    assert not (slow & (middle < 1.75 + 0.5 * CAR_LENGTH)).any(), "nobody stands in the area"
    assert distance_apart(run) > 2.5
    assert not there[-1] or middle[-1] > INSIDE + CAR_LENGTH, "it is through"


def test_nobody_waits_for_who_follows() -> None:
    """Another 30 m behind on the same way changes nothing."""
    text = TURN.format(driver=GIVES_WAY, distance=70)
    behind = text.replace("along oncoming", "along turn").replace("(10 m/s, oncoming)", "(9 m/s, turn)")
    _, run = states(behind.replace("10 m/s", "9 m/s"))
    _, alone = states(text.replace("along oncoming", "along turn").replace("(10 m/s, oncoming)", "(1 m/s, turn)"))
    np.testing.assert_allclose(run[:120, 0], alone[:120, 0], atol=1e-9)


def test_of_two_who_give_way_one_goes() -> None:
    """Two that arrive at a time do not wait for ever."""
    text = TURN.format(driver=GIVES_WAY, distance=40).replace(
        "FollowTrajectoryBehavior(10 m/s, oncoming)", "GivingWayBehavior(10 m/s, oncoming)"
    )
    _, run = states(text)
    assert (np.abs(run[-1, :, :2]).max(axis=1) > 15.0).all() or (run[-1, :, State.PRESENT] == 0.0).any()
    assert distance_apart(run) > 2.5


EDGE = """
map intersection(approach=100 m)
ahead = filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers)[0]
across = filter(lambda m: m.type is ManeuverType.LEFT_TURN, ahead.conflictingManeuvers)[{number}]
line = new OrientedPoint before intersection by 0 m along ahead
ego = new Car ahead of line by {beyond} m, with speed 0 m/s, with behavior GivingWayBehavior(9 m/s, ahead)
other = new Car before intersection by 15 m along across, with speed 7 m/s,
    with behavior FollowTrajectoryBehavior(7 m/s, across)
{more}
terminate after 15 s
"""


@pytest.mark.parametrize(("number", "beyond"), [(1, 4.0), (2, 1.0)])
def test_who_stands_too_near_backs_up_to_the_line(number: int, beyond: float) -> None:
    """The front of another that turns swings out of its strip; when it has passed, the driver goes on."""
    _, run = states(EDGE.format(number=number, beyond=beyond, more=""))
    ego = run[:, 0]
    assert 0.5 < -0.05 * np.minimum(ego[:, State.SPEED], 0.0).sum() < 1.5
    assert ego[:, State.SPEED].min() > -2.0, "at walking pace"
    first = int(np.flatnonzero(ego[:, State.SPEED] < 0.0)[-1]) + 1
    assert (ego[first:, State.SPEED] >= 0.0).all(), "once"
    assert ego[:, State.SPEED].max() > 5.0, "and then forwards"
    assert distance_apart(run) > 2.5


BEHIND = {
    "close": "last = new Obstacle behind ego by 1 m, with width 1.8 m, with length 4 m",
    "aslant": """last = new Obstacle at ego offset by (-3 m, -3.85 m), facing 90 deg relative to ego,
    with width 1.8 m, with length 8 m""",
    "walks there": """last = new Pedestrian at ego offset by (-2 m, -3 m), facing -90 deg relative to ego,
    with speed 1.4 m/s, with behavior WalkForwardBehavior(1.4 m/s)""",
}


@pytest.mark.parametrize("behind", BEHIND.values(), ids=BEHIND)
def test_nobody_backs_up_into_who_is_behind(behind: str) -> None:
    _, run = states(EDGE.format(number=1, beyond=4.0, more=behind))
    assert run[:20, 0, State.SPEED].min() == 0.0


LEAVES = {
    "in time": "do GivingWayBehavior(9 m/s, way) for 0.6 s",
    "interrupted": """try:
        do GivingWayBehavior(9 m/s, way)
    interrupt when self.speed < 0 m/s:
        abort""",
}


@pytest.mark.parametrize("leaves", LEAVES.values(), ids=LEAVES)
def test_whoever_takes_over_drives_forwards(leaves: str) -> None:
    """The reverse gear is in for one step at a time."""
    behavior = f"behavior Leaves(way):\n    {leaves}\n    while True:\n        take SetThrottleAction(0.5)\n"
    text = behavior + EDGE.format(number=1, beyond=4.0, more="")
    _, run = states(text.replace("GivingWayBehavior(9 m/s, ahead)", "Leaves(ahead)"))
    speed = run[:, 0, State.SPEED]
    assert speed.min() < 0.0, "it was backing up"
    assert speed.min() > -1.5
    assert speed[-1] > 1.0


@pytest.mark.parametrize("beyond", [6.0, 8.0, 10.0])
def test_who_stands_in_the_middle_of_the_area_does_not_back_up(beyond: float) -> None:
    for number in (0, 1, 2):
        _, run = states(EDGE.format(number=number, beyond=beyond, more=""))
        assert run[:, 0, State.SPEED].min() >= 0.0


def test_nobody_backs_up_before_who_comes_along_his_own_lane() -> None:
    """That one would come after it for as long as it went back."""
    text = """
map intersection(approach=200 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 60 m along [lane], with speed 0 m/s, with behavior GivingWayBehavior(9 m/s)
other = new Car ahead of ego by 100 m, facing 180 deg relative to ego, with speed 2 m/s,
    with behavior FollowLaneBehavior(2 m/s, is_oppositeTraffic=True)
terminate after 20 s
"""
    _, run = states(text)
    assert -0.05 * np.minimum(run[:, 0, State.SPEED], 0.0).sum() < 2.5


@pytest.mark.parametrize(("file", "number"), [("C", 24576), ("C", 39384), ("C", 80650), ("D", 70069)])
def test_who_had_to_brake_hard_is_not_struck_at_the_edge(file: str, number: int) -> None:
    """It comes to rest just before or in the way of one that turns, which would strike it there."""
    assert not one_scene(file, number).outcomes.collided[0]


def test_who_gives_way_has_the_measures_of_the_search_for_areas() -> None:
    assert (giving_way.OFF, giving_way.TOUCHING) == (BESIDE, CLEARANCE)


def test_who_brakes_at_the_edge_brakes_to_the_end_and_backs_off() -> None:
    """In 89672 of C it is too late by some centimetres: it presses its throttle again only backwards."""
    one = one_scene("C", 89672)
    assert one.outcomes.collided[0]
    assert one.outcomes.ego_speed[0, 0] < -0.5
    scenario = compile_text(text_of("C", "gives way"))
    ego = trajectory(scenario.program, one.scenes, 0, scenario.config.simulation).states[:, 0]
    late = np.flatnonzero(ego[:, State.BRAKE] == 1.0)[0]
    assert ((ego[late:, State.THROTTLE] == 0.0) | (ego[late:, State.SPEED] < 0.0)).all()


# -- the emergency brake, by UN R152 -----------------------------------------------------------------------------------

AHEAD = """
map intersection(approach=200 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 150 m along [lane], with speed {speed} km/h, with behavior {behaviour}
target = new Car before intersection by 60 m along [lane], with speed {target} km/h,
    with behavior FollowLaneBehavior({target} km/h)
terminate after 25 s
"""
R152 = "EmergencyBrakeBehavior(FollowLaneBehavior({speed} km/h), reference_deceleration=5 m/s^2{more})"


def met(speed: float, target: float, more: str = "") -> Any:
    driver = R152.format(speed=speed, more=more)
    scenario = compile_text(AHEAD.format(speed=speed, target=target, behaviour=driver))
    return scenario.simulate(scenario.sample(1, seed=5))


@pytest.mark.parametrize("speed", [20, 30, 40, 60])
def test_the_brake_avoids_a_car_that_stands(speed: float) -> None:
    """R152, 5.2.1.4: up to 40 km/h no contact; up to 60 km/h at most 35 km/h are left, which this brake undercuts."""
    assert not met(speed, 0).collided[0]


@pytest.mark.parametrize(("speed", "target"), [(40, 20), (60, 20)])
def test_the_brake_avoids_a_slower_car(speed: float, target: float) -> None:
    """R152, 6.5: a target that drives 20 km/h."""
    assert not met(speed, target).collided[0]


def test_below_its_range_of_speeds_the_brake_does_nothing() -> None:
    """R152, 5.2.1.3: it works at least from 10 to 60 km/h; below and above, this one does not."""
    assert met(18, 0, ", min_speed=20 km/h").collided[0]
    assert met(62, 0, ", max_speed=60 km/h").collided[0]


DRIVERS_PAGE = ROOT / "docs" / "reference" / "drivers.md"
STANDING = """
map intersection(approach=200 m)
ego = new Car before intersection by 150 m along [intersection.incomingLanes[0]], with speed {speed},
    with behavior {behavior}
block = new Obstacle ahead of ego by 60 m
terminate after 25 s
"""


def before_a_block(text: str) -> tuple[Outcomes, list[Floats]]:
    """Outcomes and states of the ego at 10 to 60 km/h, in steps of 1 km/h; the text has the speed as a param `V`."""
    scenario = compile_text(f"param V = Range(10, 60) km/h\n{text}")
    program, simulation = scenario.program, scenario.config.simulation
    speeds = np.arange(10.0, 61.0)
    keys = key_rows(1, Method.SAMPLE, 0, 0, np.arange(len(speeds)))
    scenes = sample(program, speeds[:, None], keys, simulation)
    runs = [trajectory(program, scenes, row, simulation).states[:, 0] for row in range(len(scenes))]
    return scenario.simulate(scenes), runs


def phases(ego: Floats) -> int:
    """How often it begins to brake."""
    brakes = ego[:, State.BRAKE] > 0.0
    return int((brakes[1:] & ~brakes[:-1]).sum() + brakes[0])


@pytest.mark.parametrize("latency", ["0 s", "0.2 s"])
def test_the_brake_of_the_page_meets_r152(latency: str) -> None:
    """R152, 5.2.1.4: no contact with a block that stands, up to 40 km/h; the page says up to 60 km/h.

    It brakes once, to standstill, also below the least speed at which it begins to, and the car then stands.
    """
    blocks = DRIVERS_PAGE.read_text(encoding="utf-8").split("```scn\n")[1:]
    block = next(each for each in blocks if "min_speed" in each).split("```")[0]
    assert block.count("50 km/h") == 2
    block = block.replace("50 km/h", "V").replace("latency=0.2 s", f"latency={latency}").replace("15 s", "25 s")
    outcomes, runs = before_a_block(block)
    assert not outcomes.collided.any()
    assert outcomes.min_distance.min() > 0.9
    assert [phases(ego) for ego in runs] == [1] * 51
    assert all(ego[-1, State.SPEED] == 0.0 for ego in runs)


def test_the_careful_driver_brakes_to_standstill_as_well() -> None:
    """UN R157's model sees a risk 2 s before contact and brakes 1.15 s later: enough up to 25 km/h.

    If it let go of the brake before it stood, it would begin again too late.
    """
    text = STANDING.format(speed="V", behavior="CarefulDriverBehavior(FollowLaneBehavior(V))")
    outcomes, runs = before_a_block(text)
    assert not outcomes.collided[:16].any()
    assert [phases(ego) for ego in runs[:16]] == [1] * 16


def test_the_brake_ends_for_a_target_that_leaves_or_drives_off() -> None:
    """Behind a car that stands for 10 s the ego stands, and drives on after it."""
    brake = "EmergencyBrakeBehavior(FollowLaneBehavior(40 km/h), min_speed=10 km/h)"
    text = STANDING.format(speed="40 km/h", behavior=brake)
    car = """target = new Car ahead of ego by 60 m, with speed 0 m/s, with behavior Later()
behavior Later():
    do BrakeBehavior() for 10 s
    do FollowLaneBehavior(30 km/h)
"""
    _, run = states(text.replace("block = new Obstacle ahead of ego by 60 m\n", car))
    ego = run[:, 0, State.SPEED]
    stood = int(np.flatnonzero(ego == 0.0)[-1])
    assert 10.0 < 0.05 * stood < 11.0
    assert ego[-1] > 5.0


@pytest.mark.parametrize("more", [", range=4 m", ", field_of_view=0.1 deg, range=4 m"])
def test_a_brake_that_sees_too_little_brakes_too_late(more: str) -> None:
    """From 60 km/h 4 m are not enough."""
    assert met(60, 0, more).collided[0]


def test_a_latency_costs_the_way_driven_meanwhile() -> None:
    """Seen 0.5 s late, the brake is late by as much: 0.5 s at 13.9 m/s."""
    standing = []
    for more in ("", ", latency=0.5 s"):
        driver = R152.format(speed=50, more=more + ", delay=0.8 s")
        _, run = states(AHEAD.format(speed=50, target=5, behaviour=driver))
        standing.append(int(np.flatnonzero(run[:, 0, State.BRAKE] > 0.0)[0]))
    assert standing[1] - standing[0] == 10


# -- the table ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("file", ["A", "E"])
def test_who_gives_way_leaves_no_collision_that_could_be_avoided(file: str) -> None:
    """On few scenes, what `python -m benchmarks.drivers` says of many."""
    blind, careful = rows(file, ["blind", "gives way"], 150, 1)
    assert blind.scenes == careful.scenes >= 150
    assert blind.collisions > 0.1
    assert careful.collisions < 0.05
    assert careful.avoidable <= 0.01
    assert careful.stood == 0.0
    assert careful.through > 0.9
    assert careful.lost < 10.0


def test_a_driver_of_ones_own_is_held_against_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As another row, of the same fair scenes; where it fails it is not through."""
    (tmp_path / "half_of_mine.py").write_text(
        (ROOT / "examples" / "own_driver" / "planner.py")
        .read_text()
        .replace(
            "return np", "speed = observations[:, SPEED]\n    return np.where(speed > 14, np.nan, 1)[:, None] * np"
        )
    )
    monkeypatch.chdir(tmp_path)
    name = "python:half_of_mine:drive"
    arguments = ["--scenes", "100", "--files", "A", "--drivers", "blind", "--ego", name, "--json"]
    assert main(arguments) == 0
    blind, mine = json.loads(capsys.readouterr().out)
    assert (mine["driver"], mine["scenes"]) == (name, blind["scenes"])
    assert 0.0 < mine["through"] < 1.0
    assert mine["collisions"] < blind["collisions"]


def test_the_brake_along_ways_ends_no_run_early_and_gets_through() -> None:
    """In B the ego joins the way of a slow car far away, which is nothing to brake for: as it once did, for good."""
    brake = rows("B", ["emergency brake"], 150, 1)[0]
    assert brake.avoidable == 0.0
    assert brake.stood == 0.0
    assert brake.through > 0.99


@pytest.mark.parametrize(
    ("file", "number"),
    [
        *(("B", number) for number in (107, 12561)),
        *(("D", number) for number in (3119, 5464, 7797, 68129, 86104)),
        ("E", 2233),
    ],
)
def test_who_comes_too_fast_keeps_aside_or_gets_out_ahead(file: str, number: int) -> None:
    """Scenes in which it once stopped askew on its way back to its way, or where ways join, in front of another."""
    assert not one_scene(file, number).outcomes.collided.any()


@pytest.mark.parametrize("file", sorted(each.stem for each in (ROOT / "benchmarks" / "suite").glob("*.scn")))
def test_nobody_is_through_before_it_has_begun(file: str) -> None:
    """Wherever the ego's way leads, runs of the suite go on until it is behind the intersection."""
    blind = driven(text_of(file, "blind"), 0, 4, 1)
    assert (blind.outcomes.end_time[blind.scenes.valid] > 1.0).all()


FILES = (*EXAMPLES, "cut_in", "crowd", "two_walkers")


@cache
def params_of(file: str, driver: str) -> tuple[str, ...]:
    return compile_text(text_of(file, driver)).program.space.names


@pytest.mark.parametrize(("file", "driver"), [(f, d) for f in FILES for d in DRIVERS if goes_there(f, d)])
def test_every_driver_fits_into_every_file(file: str, driver: str) -> None:
    """With the same params."""
    assert params_of(file, driver) == params_of(file, "blind")
