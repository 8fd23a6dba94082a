"""The library drives as it says, in both hosts: car following, giving way, lane changes, emergency brakes, lights."""

import math

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine import batch, world
from engine.tables import SLIDING, Floats
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State

LANE_WIDTH = 3.5
CAR_LENGTH = 4.508


def states(text: str) -> tuple[Floats, Floats]:
    """Times and states of the only scene of a text; both hosts agree on it, up to contact."""
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=5)
    assert scenes.valid[0]
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    pose = [State.X, State.Y, State.HEADING]
    count = len(fast.time)
    np.testing.assert_allclose(slow.states[:count, :, pose], fast.states[..., pose], rtol=0.0, atol=1e-9)
    return fast.time, fast.states


def gaps(run: Floats) -> Floats:
    """Between the outlines of two cars on one straight lane [m]."""
    return np.hypot(*(run[:, 1, :2] - run[:, 0, :2]).T) - CAR_LENGTH


# -- car following ----------------------------------------------------------------------------------------------------

QUEUE = """
map intersection(approach=300 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by {behind} m along [lane], with speed {speed} m/s,
    with behavior CarFollowingBehavior(20 m/s, {way})
lead = new Car before intersection by 200 m along [lane], with speed {lead} m/s,
    with behavior ConstantSpeedBehavior({lead} m/s)
terminate after 30 s
"""


@pytest.mark.parametrize("way", ["", "trajectory=lane", "trajectory=[lane]"])
def test_car_following_settles_at_the_gap_of_the_model(way: str) -> None:
    """Behind 8 m/s: (s0 + v T) / sqrt(1 - (v / v0)^4), 14.99 m."""
    _, run = states(QUEUE.format(behind=250, speed=15, lead=8, way=way).replace("30 s", "24 s"))
    equilibrium = (2.0 + 1.6 * 8.0) / math.sqrt(1.0 - (8.0 / 20.0) ** 4)
    assert gaps(run)[-1] == pytest.approx(equilibrium, abs=0.08)
    assert run[-1, 0, State.SPEED] == pytest.approx(8.0, abs=0.02)


@pytest.mark.parametrize("lead", [0.0, 2.0, 8.0, 15.0])
@pytest.mark.parametrize("speed", [5.0, 12.0, 18.0])
@pytest.mark.parametrize("behind", [260, 290])
def test_car_following_never_collides_where_there_is_room(lead: float, speed: float, behind: int) -> None:
    """A benign sweep: 55 m and more to start with, steady leads."""
    _, run = states(QUEUE.format(behind=behind, speed=speed, lead=lead, way=""))
    assert gaps(run).min() > 1.0


def test_car_following_alone_drives_its_target_speed() -> None:
    """Without anybody ahead the model approaches v0 from below."""
    _, run = states(
        "map intersection(approach=300 m)\nlane = intersection.incomingLanes[0]\n"
        "ego = new Car before intersection by 290 m along [lane], with behavior CarFollowingBehavior(8 m/s)\n"
        "terminate after 25 s\n"
    )
    assert 7.0 < run[-1, 0, State.SPEED] < 8.0
    assert np.diff(run[:, 0, State.SPEED]).max() / 0.05 == pytest.approx(0.73, abs=0.01)


# -- giving way -------------------------------------------------------------------------------------------------------

TURN = """
map intersection(approach=100 m, left_hand={left_hand})
far = ManeuverType.{far}
turn = Uniform(*filter(lambda m: m.type is far, intersection.incomingLanes[0].maneuvers))
oncoming = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.incomingLanes[2].maneuvers))
ego = new Car before intersection by 30 m along [turn.startLane], with speed 8 m/s,
    with behavior {behaviour}(8 m/s, turn)
other = new Car before intersection by {distance} m along [oncoming.startLane], with speed 10 m/s,
    with behavior FollowTrajectoryBehavior(10 m/s, oncoming)
terminate after 20 s
"""


def turn(behaviour: str, distance: float, left_hand: bool = False) -> str:
    far = "RIGHT_TURN" if left_hand else "LEFT_TURN"
    return TURN.format(behaviour=behaviour, distance=distance, left_hand=left_hand, far=far)


@pytest.mark.parametrize("left_hand", [False, True])
@pytest.mark.parametrize("distance", [35, 40, 45, 50])
def test_gap_acceptance_waits_for_who_would_be_hit_and_then_goes(distance: float, left_hand: bool) -> None:
    """Without it the two collide; with it the ego slows down before the intersection, lets pass, and leaves."""
    scenario = compile_text(turn("FollowTrajectoryBehavior", distance, left_hand))
    assert scenario.simulate(scenario.sample(1, seed=5)).collided[0]
    _, run = states(turn("GapAcceptanceBehavior", distance, left_hand))
    slowest = int(np.argmin(run[:, 0, State.SPEED]))
    assert run[slowest, 0, State.SPEED] < 0.5
    before = np.hypot(*run[slowest, 0, :2])
    assert before > 7.75, "it waits outside of the intersection"
    assert np.hypot(*run[slowest, 1, :2]) < before + 5.0, "until the other has come"
    assert run[-1, 0, State.SPEED] > 4.0 or run[-1, 0, State.PRESENT] == 0.0


def test_gap_acceptance_does_not_wait_for_a_long_gap() -> None:
    """An oncoming car 8 s away changes nothing."""
    _, plain = states(turn("FollowTrajectoryBehavior", 95))
    _, careful = states(turn("GapAcceptanceBehavior", 95))
    np.testing.assert_array_equal(plain, careful)


def test_gap_acceptance_ignores_who_does_not_conflict() -> None:
    """Whoever follows on the same lane is no reason to wait."""
    text = turn("GapAcceptanceBehavior", 40).replace("along [oncoming.startLane]", "along [turn.startLane]")
    text = text.replace("(10 m/s, oncoming)", "(6 m/s, turn)").replace("with speed 10 m/s", "with speed 6 m/s")
    _, run = states(text.replace("by 40 m along", "by 60 m along"))
    assert run[: len(run) // 2, 0, State.SPEED].min() > 3.0


# -- lane changes -----------------------------------------------------------------------------------------------------

CHANGE = """
map intersection(lanes=2, approach=400 m)
lane = intersection.incomingLanes[{start}]
behavior Change():
    do LaneChangeBehavior(self.laneSection.{side}, target_speed={speed} m/s)
    terminate
ego = new Car before intersection by 380 m along [lane], with speed {speed} m/s, with behavior Change()
terminate after 20 s
"""


@pytest.mark.parametrize("speed", [2, 5, 10, 15, 20, 25])
@pytest.mark.parametrize(("side", "start"), [("laneToRight", 1), ("laneToLeft", 0)])
def test_a_lane_change_ends_in_the_lane(speed: int, side: str, start: int) -> None:
    """Settled within 0.1 m, hardly beyond, with less than 2 m/s^2 to the side, the speed kept."""
    _, run = states(CHANGE.format(speed=speed, side=side, start=start))
    own = run[:, 0]
    heading = own[0, State.HEADING]
    moved = own[:, :2] - own[0, :2]
    left = (moved[:, 1] * np.cos(heading) - moved[:, 0] * np.sin(heading)) * (1 if side == "laneToLeft" else -1)
    assert left[-1] == pytest.approx(LANE_WIDTH, abs=0.1)
    assert left.max() < LANE_WIDTH + 0.05
    turned = np.diff(np.unwrap(own[:, State.HEADING])) / 0.05
    assert np.abs(turned * own[1:, State.SPEED]).max() < 2.0
    assert np.ptp(own[:, State.SPEED]) < 0.01


def test_a_lane_change_starts_from_rest() -> None:
    """A standing car moves over while it speeds up; at low speed the way counts, not the time."""
    text = CHANGE.format(speed=8, side="laneToLeft", start=0).replace("with speed 8 m/s, ", "")
    time, run = states(text)
    assert time[-1] < 6.0
    assert np.abs(run[-1, 0, 0] - run[0, 0, 0]) == pytest.approx(LANE_WIDTH, abs=0.1)


def test_a_lane_change_without_a_lane_makes_the_run_invalid() -> None:
    """There is nothing to the right of the lane at the kerb: reported by name, scored as invalid."""
    scenario = compile_text(CHANGE.format(speed=8, side="laneToRight", start=0))
    outcomes = scenario.simulate(scenario.sample(1, seed=5))
    rule = scenario.program.rules[int(outcomes.end_rule[0])]
    assert rule.name == "LaneChangeBehavior has a lane to go to"
    assert np.isnan(outcomes.min_distance).all()


def test_who_drives_against_traffic_goes_back_to_where_the_lane_begins() -> None:
    """`is_oppositeTraffic` follows the oncoming lane from its end to its start."""
    text = CHANGE.format(speed=8, side="laneToLeft", start=1).replace("target_speed=8", "True, target_speed=8")
    _, run = states(text)
    assert run[-1, 0, 0] == pytest.approx(LANE_WIDTH / 2, abs=0.1), "on the other side of the middle"
    assert run[-1, 0, 1] < run[0, 0, 1], "still southwards"


# -- emergency brake --------------------------------------------------------------------------------------------------

BLOCKED = """
map intersection(approach=200 m)
lane = intersection.incomingLanes[0]
behavior Plain():
    do FollowLaneBehavior({speed} m/s)
ego = new Car before intersection by 150 m along [lane], with speed {speed} m/s, with behavior {behaviour}
block = new Obstacle before intersection by 40 m along [lane]
terminate after 20 s
"""


@pytest.mark.parametrize("speed", [10, 20, 30])
@pytest.mark.parametrize("threshold", ["", ", threshold=2.5 s"])
def test_the_emergency_brake_prevents_a_collision(speed: int, threshold: str) -> None:
    """Without it the car hits the obstacle at full speed; with it it stands before it."""
    plain = compile_text(BLOCKED.format(speed=speed, behaviour="Plain()"))
    assert plain.simulate(plain.sample(1, seed=5)).collided[0]
    braked = f"EmergencyBrakeBehavior(Plain(){threshold})"
    _, run = states(BLOCKED.format(speed=speed, behaviour=braked))
    assert run[-1, 0, State.SPEED] == pytest.approx(0.0, abs=0.01)
    assert np.hypot(*(run[:, 1, :2] - run[:, 0, :2]).T).min() > 0.5 * CAR_LENGTH + 0.5


def test_the_emergency_brake_leaves_others_alone() -> None:
    """Who follows at the same speed is no reason to brake."""
    text = BLOCKED.format(speed=10, behaviour="EmergencyBrakeBehavior(Plain())").replace(
        "new Obstacle before intersection by 40 m along [lane]",
        "new Car before intersection by 140 m along [lane], with speed 10 m/s, with behavior Plain()",
    )
    _, run = states(text)
    assert run[:200, 0, State.BRAKE].max() == 0.0


ASKEW = """
map intersection(approach=200 m)
behavior Straight():
    while True:
        wait
ego = new Car at (1.75 m, -150 m), facing 90 deg, with speed 6 m/s, with drag 0,
    with behavior EmergencyBrakeBehavior(Straight())
struck = new Car at (1.75 m, {y} m), facing 0 deg, with regionContainedIn None, with friction 0.05
truck = new Truck at (1.75 m, -60 m), facing 270 deg, with speed 20 m/s, with behavior Straight(), with drag 0
terminate after 20 s
"""


@pytest.mark.parametrize("y", [-80, -90])
def test_the_emergency_brake_knows_who_slides_broadside(y: float) -> None:
    """A car that a truck pushes towards the ego, across its heading, comes at 21 m/s: TTC < v_rel / 12 m/s^2 + 0.35 s
    at once, and by the ego's own 6 m/s not for long.
    """
    _, run = states(ASKEW.format(y=y))
    struck = int(np.flatnonzero(run[:, 1, State.PRESENT] == SLIDING)[0])
    assert np.abs(run[struck:, 1, State.SPEED]).max() < 0.1
    closing = 6.0 + (run[struck, 1, State.Y] - run[struck + 1, 1, State.Y]) / 0.05
    gap = run[struck, 1, State.Y] - run[struck, 0, State.Y] - 0.5 * CAR_LENGTH - 0.9
    assert 6.0 / 12.0 + 0.35 < gap / closing < closing / 12.0 + 0.35
    assert not run[: struck + 1, 0, State.BRAKE].any()
    assert run[struck + 1, 0, State.BRAKE] > 0.0


def test_time_to_collision_in_a_condition() -> None:
    """10 m/s towards a thing 104.996 m before the bumper: 3 s before contact is at 7.5 s."""
    text = BLOCKED.format(speed=10, behaviour="Plain()") + "terminate when timeToCollision(ego) < 3 s\n"
    time, _ = states(text)
    assert time[-1] == pytest.approx((110.0 - 0.5 * CAR_LENGTH - 0.5) / 10.0 - 3.0, abs=0.06)


# -- roundabouts ------------------------------------------------------------------------------------------------------

RING = """
map roundabout(arms=4, radius=18 m, approach=80 m)
south = network.intersections[2]
way = south.incomingLanes[0].routeTo(network.roads[0].backwardLanes.lanes[0])
other = network.roads[{start}].forwardLanes.lanes[0].routeTo(network.roads[{end}].backwardLanes.lanes[0])
ego = new Car before south by 40 m along way, with speed 8 m/s,
    with behavior GapAcceptanceBehavior(8 m/s, way)
new Car before network.intersections[{start}] by {away} m along other, with speed 6 m/s,
    with behavior FollowTrajectoryBehavior(6 m/s, other)
terminate after 20 s
"""
WEST, EAST_ARM, SOUTH = 3, 1, 2


def least_speed_before_the_line(**places: float) -> float:
    """Of the ego on its arm, which ends 25.7 m south of the middle: sqrt(30^2 - 15.5^2) m [m/s]."""
    _, run = states(RING.format(**places))
    ego = run[:, 0]
    before = ego[:, State.Y] + 0.5 * CAR_LENGTH < -math.sqrt(30.0**2 - 15.5**2)
    assert np.hypot(*(run[:, 1, :2] - ego[:, :2]).T).min() > CAR_LENGTH
    return float(ego[before, State.SPEED].min())


def test_the_ring_goes_first() -> None:
    """Whoever comes round past the arm is waited for."""
    assert least_speed_before_the_line(start=WEST, end=EAST_ARM, away=22) < 0.5


FAR_AWAY = {"start": WEST, "end": SOUTH, "away": 60}
LEAVES_BEFORE = {"start": EAST_ARM, "end": 0, "away": 10}


@pytest.mark.parametrize("places", [FAR_AWAY, LEAVES_BEFORE])
def test_nobody_waits_for_who_does_not_come(places: dict[str, float]) -> None:
    """One who is far away, and one who leaves before."""
    assert least_speed_before_the_line(**places) > 2.0


# -- speed limits -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limit", "respected", "speed"), [("", "True", 20.0), ("12 m/s", "False", 20.0), ("12 m/s", "True", 12.0)]
)
@pytest.mark.parametrize("behaviour", ["FollowLaneBehavior", "FollowTrajectoryBehavior"])
def test_drivers_respect_signs_where_asked_to(limit: str, respected: str, speed: float, behaviour: str) -> None:
    """On a road without signs, and without being asked, they drive their target speed."""
    sign = f", speed_limit={limit}" if limit else ""
    way = "[lane], " if "Trajectory" in behaviour else ""
    _, run = states(
        f"map road(length=1 km{sign})\nlane = network.lanes[0]\n"
        "ego = new Car following roadDirection from lane.centerline[0] for 200 m, with speed 15 m/s,\n"
        f"    with behavior {behaviour}(20 m/s, {way}respect_speed_limit={respected})\nterminate after 8 s\n"
    )
    assert run[-1, 0, State.SPEED] == pytest.approx(speed, abs=0.05)


# -- lights -----------------------------------------------------------------------------------------------------------

LIGHTS = """
map intersection(approach=100 m)
signals(green=6 s, yellow=3 s, all_red=2 s, offset={offset} s)
lane = intersection.incomingLanes[{arm}]
ego = new Car before intersection by 60 m along [lane], with speed 10 m/s,
    with behavior FollowLaneBehavior(10 m/s, obey_signals=True)
{more}
"""
NORTH, EAST = 0, 1


def lights(arm: int, offset: float, more: str = "terminate after 20 s") -> tuple[Floats, Floats]:
    return states(LIGHTS.format(arm=arm, offset=offset, more=more))


@pytest.mark.parametrize("offset", [2.0, 4.0, 8.0, 12.0])
def test_red_is_waited_for_at_the_stop_line(offset: float) -> None:
    """The northern arm is red from 9 s of the plan to its end at 22 s; the car starts again when that comes."""
    time, run = lights(NORTH, offset)
    speed = run[:, 0, State.SPEED]
    assert speed.min() < 0.1
    front = np.hypot(*run[int(np.argmin(speed)), 0, :2]) - 0.5 * CAR_LENGTH - 9.5
    assert 0.0 < front < 1.0
    starts = time[np.flatnonzero(speed < 0.1)[-1]]
    assert starts == pytest.approx(22.0 - offset, abs=0.2)


def test_green_is_driven_through() -> None:
    """The northern arm in the first seconds of the plan, the eastern one eleven seconds later."""
    assert lights(NORTH, 0.0)[1][:120, 0, State.SPEED].min() == pytest.approx(10.0)
    assert lights(EAST, 11.0)[1][:120, 0, State.SPEED].min() == pytest.approx(10.0)


@pytest.mark.parametrize(("colour", "begins", "ends"), [("green", 0.0, 6.0), ("yellow", 6.0, 9.0), ("red", 9.0, 22.0)])
def test_lights_turn_when_they_should(colour: str, begins: float, ends: float) -> None:
    """From where a colour begins in the plan it lasts to where it ends, 22 s being the whole plan."""
    more = f'terminate when getTrafficLightStatus(lane.signal) != "{colour}"\nterminate after 30 s'
    time, _ = lights(NORTH, begins, more)
    assert time[-1] == pytest.approx(ends - begins, abs=0.051)


CONTROL = """
map intersection(approach=100 m)
signals(green=6 s, yellow=3 s, all_red=2 s, offset={offset} s)
lane = intersection.incomingLanes[0]
monitor Lights():
{body}
require monitor Lights()
ego = new Car before intersection by 60 m along [lane], with speed 10 m/s,
    with behavior FollowLaneBehavior(10 m/s, obey_signals=True)
terminate after 15 s
"""


def controlled(body: str, offset: float) -> Floats:
    lines = "\n".join(f"    {line}" for line in body.splitlines())
    return states(CONTROL.format(body=lines, offset=offset))[1][:, 0, State.SPEED]


def test_a_frozen_light_keeps_what_it_is_set_to() -> None:
    """Red by the plan, but frozen and set to green: the car drives on."""
    body = 'freezeTrafficLights()\nwhile True:\n    setClosestTrafficLightStatus(ego, "green")\n    wait'
    assert controlled(body, 12.0)[:150].min() == pytest.approx(10.0)


def test_a_set_light_goes_on_with_its_plan() -> None:
    """Set to red at once, it is red until the plan turns it yellow after 6 s, which is red to who stands, then red."""
    speed = controlled('setTrafficLightStatus(lane.signal, "red")\nwait', 0.0)
    assert speed.min() < 0.2


def test_unfrozen_lights_go_on_where_they_stood() -> None:
    """The northern green of 6 s is too short for a car 60 m away from 3 s on; stopped for 5 s it is long enough."""
    body = "freezeTrafficLights()\ncount = 0\nwhile count < 100:\n    count += 1\n    wait\nunfreezeTrafficLights()"
    assert controlled(body, 3.0)[:110].min() == pytest.approx(10.0)
    assert controlled("wait", 3.0).min() < 1.0


# -- who is near ------------------------------------------------------------------------------------------------------

NEAR = """
map intersection(approach=100 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 80 m along [lane], with speed 10 m/s, with behavior FollowLaneBehavior(10 m/s)
{other}
terminate when {condition}
terminate after 9 s
"""
AHEAD = "new Car before intersection by 40 m along [lane]"
BESIDE = "new Car at (1.75, 49.75), facing roadDirection"
PERSON = "new Pedestrian at (-1.75, 49.75)"


def ended(condition: str, other: str) -> float:
    """When a condition ended the run [s]."""
    return float(states(NEAR.format(condition=condition, other=other))[0][-1])


@pytest.mark.parametrize(
    ("condition", "other", "time"),
    [
        ("withinDistanceToObjsInLane(ego, 20)", AHEAD, 2.0),
        ("withinDistanceToObjsInLane(ego, 20)", BESIDE, 9.0),
        ("withinDistanceToObjsInLane(ego, 20)", PERSON, 2.0),
        ("withinDistanceToAnyCars(ego, 20)", AHEAD, 2.0),
        ("withinDistanceToAnyCars(ego, 20)", BESIDE, 2.0),
        ("withinDistanceToAnyPedestrians(ego, 20)", PERSON, 1.8),
        ("withinDistanceToAnyPedestrians(ego, 20)", BESIDE, 9.0),
        ("ego.distanceToClosest(Car) < 20", BESIDE, 2.0),
        ("ego.distanceToClosest(Pedestrian) < 20", BESIDE, 9.0),
        ("ego.lane is not lane", BESIDE, 8.0),
        ("ego.laneSection._laneToLeft is None", BESIDE, 8.0),
    ],
)
def test_conditions_on_others_hold_when_they_should(condition: str, other: str, time: float) -> None:
    """10 m/s, and 20 m or the stop line to come to; 9 s where it never holds."""
    assert ended(condition, other) == pytest.approx(time, abs=0.15)


def test_a_crossing_walker_meets_the_car() -> None:
    """It waits until the car is 30 m away, then walks so as to be on the lane when the car comes."""
    walker = (
        "walker = new Pedestrian at (-6, 49.75), facing toward (0, 49.75), with regionContainedIn None,\n"
        "    with behavior CrossingBehavior(ego, 1, 30)"
    )
    _, run = states(NEAR.format(condition="walker.x > 3", other=walker))
    apart = np.hypot(*(run[:, 1, :2] - run[:, 0, :2]).T)
    assert run[np.flatnonzero(apart < 30.0)[0], 1, 0] == pytest.approx(-6.0, abs=0.1)
    assert apart.min() < 3.0, "they meet"


def test_driving_avoiding_collisions_stops_behind_who_stands() -> None:
    """Scenic's behaviour of that name, 10 m from centre to centre."""
    text = NEAR.format(condition="ego.speed < 0", other=AHEAD)
    text = text.replace("FollowLaneBehavior(10 m/s)", "DriveAvoidingCollisions(10 m/s, avoidance_threshold=15)")
    _, run = states(text)
    apart = np.hypot(*(run[-1, 1, :2] - run[-1, 0, :2]))
    assert run[-1, 0, State.SPEED] == pytest.approx(0.0, abs=0.01)
    assert 8.0 < apart < 10.0


# -- offsets from the path ---------------------------------------------------------------------------------------------

ABREAST = """
map road(lanes=1, length=300 m, lane_width=4.5 m)
ego = new Bicycle at network.lanes[0].centerline[0] offset along roadDirection by (1.7 m, {ahead} m),
    with speed 5 m/s, with behavior {driver}(5 m/s, offset=-1.7 m)
truck = new Truck at network.lanes[0].centerline[0] offset along roadDirection by (0 m, 20 m),
    with speed 5 m/s, with behavior CarFollowingBehavior(6 m/s, offset=0.6 m)
terminate after 10 s
"""


@pytest.mark.parametrize("driver", ["FollowLaneBehavior", "CarFollowingBehavior", "DriveAvoidingCollisions"])
@pytest.mark.parametrize("ahead", [14, 20, 26])
def test_a_cyclist_keeps_to_its_side_beside_a_truck(driver: str, ahead: int) -> None:
    """For 10 s the cyclist stays within 5 cm of its line, and neither waits for the other in the same lane."""
    _, run = states(ABREAST.format(driver=driver, ahead=ahead))
    assert len(run) == 201 or driver == "DriveAvoidingCollisions"
    aside = run[:, 0, State.Y] - run[0, 0, State.Y]
    assert np.abs(aside).max() <= 0.05
    if driver != "DriveAvoidingCollisions":
        assert run[-1, 0, State.SPEED] == pytest.approx(5.0, abs=0.6)
        assert run[-1, 1, State.SPEED] > 5.3


FOLLOWERS = {
    "FollowTrajectoryBehavior": "10 m/s, [lane]",
    "FollowLaneBehavior": "10 m/s",
    "CarFollowingBehavior": "10 m/s",
    "GivingWayBehavior": "10 m/s",
    "AutopilotBehavior": "10 m/s",
    "LaneChangeBehavior": "lane",
    "LaneChoosingBehavior": "10 m/s",
    "DriveAvoidingCollisions": "10 m/s",
}


@pytest.mark.parametrize("name", FOLLOWERS)
@pytest.mark.parametrize("offset", [-0.7, 0.4])
def test_every_follower_keeps_its_offset(name: str, offset: float) -> None:
    """From the middle of the lane the rear axle of each comes to its offset and stays there; both hosts agree."""
    text = f"""
map road(lanes=1, length=300 m)
lane = network.lanes[0]
behavior Drive():
    do {name}({FOLLOWERS[name]}, offset={offset} m)
    do FollowLaneBehavior(10 m/s, offset={offset} m)
ego = new Car at lane.centerline[0] offset along roadDirection by (0 m, 20 m), with speed 10 m/s, with behavior Drive()
terminate after 10 s
"""
    _, run = states(text)
    heading = run[:, 0, State.HEADING]
    rear = run[:, 0, State.Y] - MODELS[ActorKind.CAR].rear_to_center * np.sin(heading)
    side = (rear - rear[0]) * math.copysign(1.0, offset * math.cos(heading[0]))
    assert side.min() >= -0.05
    assert side.max() <= abs(offset) + 0.05
    assert np.abs(side[-60:] - abs(offset)).max() <= 0.05
