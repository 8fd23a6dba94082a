"""People use crossings and walk along sidewalks; drivers let people on crossings go first and keep from cyclists."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import compile_text
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.evaluation.random_values import OLDER, WALKING_DEVIATION, YOUNGER
from engine import batch, world
from engine.outcomes import Outcomes
from engine.tables import Floats
from engine.vocabulary import State
from tests.laws import examples

STREET = "map road(lanes=1, length=400 m, sidewalk=2.5 m, crossings=[200 m])\n"
PLAIN = "map road(lanes=1, length=400 m, sidewalk=2.5 m)\n"
HALF = 2.0
"""Half the width of the crossing [m]."""
CAR_LENGTH = 4.508


def simulated(text: str, scenes: int = 1, seed: int = 5) -> tuple[Scenario, Outcomes]:
    scenario = compile_text(text)
    drawn = scenario.sample(scenes, seed=seed)
    assert drawn.valid.all()
    return scenario, batch.simulate(scenario.program, drawn, scenario.config.simulation)


def states(text: str, seed: int = 5) -> tuple[Floats, Floats]:
    """Times and states of one scene; both hosts agree on it."""
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=seed)
    assert scenes.valid[0]
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    pose = [State.X, State.Y, State.HEADING]
    np.testing.assert_allclose(slow.states[: len(fast.time), :, pose], fast.states[..., pose], rtol=0.0, atol=1e-9)
    return fast.time, fast.states


# -- people ------------------------------------------------------------------------------------------------------------

WALKER = """
crosswalk = network.crossings[0]
kerb = crosswalk.centerline[0]
ego = new Car following roadDirection from network.roads[0].forwardLanes.lanes[0].centerline[0] for {start} m,
    with speed {speed} m/s, with behavior ConstantSpeedBehavior({speed} m/s)
walker = new Pedestrian at kerb offset by ({aside} m, -{back} m), facing {facing} deg{age},
    with behavior UseCrossingBehavior(crosswalk{arguments})
terminate after {time} s
"""


def crossing(arguments: str = "", **given: object) -> str:
    usual = {"start": 20, "speed": 0.0, "aside": 0, "back": 1.5, "facing": 0, "age": "", "time": 20}
    return STREET + WALKER.format(arguments=arguments and f", {arguments}", **(usual | given))


@examples(10, dear=True)
@given(aside=st.floats(-4.0, 4.0), back=st.floats(0.0, 2.5), facing=st.floats(-180.0, 180.0), speed=st.floats(0.6, 2.5))
def test_a_person_crosses_within_the_crossing_and_stands_behind_it(
    aside: float, back: float, facing: float, speed: float
) -> None:
    """From any place near the kerb, whatever the heading; a parked car far away is no traffic."""
    _, run = states(crossing(f"speed={speed} m/s", aside=aside, back=back, facing=facing))
    x, y = run[:, 1, State.X], run[:, 1, State.Y]
    on_road = np.abs(y) < 3.5
    assert np.all(np.abs(x[on_road]) < HALF)
    assert y[-1] == pytest.approx(3.5 + 1.0, abs=0.1 + 0.05 * speed)
    assert run[-1, 1, State.SPEED] == 0.0


def test_a_person_comes_back_over_the_same_crossing() -> None:
    """The side at which the person stands decides the direction."""
    text = crossing("speed=1.5 m/s", time=20).replace(
        "kerb = crosswalk.centerline[0]", "kerb = crosswalk.centerline[-1]"
    )
    _, run = states(text.replace(", -1.5 m", ", 1.5 m"))
    assert run[0, 1, State.Y] > 3.5 > -3.5 > run[-1, 1, State.Y]


def stepped_on(run: Floats, time: Floats) -> float:
    """Return the time at which the person is on the road [s]; infinite if never."""
    on = np.abs(run[:, 1, State.Y]) < 3.5
    return float(time[np.argmax(on)]) if on.any() else np.inf


@pytest.mark.parametrize("speed", [8.0, 14.0])
@pytest.mark.parametrize("gap", [2.0, 4.0, 6.0])
def test_a_person_steps_onto_the_road_only_in_a_gap(speed: float, gap: float) -> None:
    """When the person begins, the car is at least the gap away from the crossing, or has left it."""
    found = []
    for start in (*range(20, 190, 17), 178):
        time, run = states(crossing(f"speed=1.4 m/s, gap={gap} s", start=start, speed=speed))
        begins = np.argmax((run[:, 1, State.Y] > -4.0 + 1e-3) & (run[:, 1, State.SPEED] > 0.0))
        room = -HALF - (run[begins, 0, State.X] + 0.5 * CAR_LENGTH)
        left = run[begins, 0, State.X] - 0.5 * CAR_LENGTH > HALF
        assert left or room >= gap * speed - 2.0 * 0.05 * speed
        found.append(bool(left))
        assert stepped_on(run, time) < np.inf
    assert any(found)
    assert not all(found)


def test_the_usual_gap_is_the_time_to_cross_and_three_seconds() -> None:
    """Without `gap` a person behaves as with its length / 1.2 m/s + 3 s."""
    for start in (50, 110, 120, 130):
        usual = states(crossing("speed=1.4 m/s", start=start, speed=10.0))[1]
        given_gap = states(crossing(f"speed=1.4 m/s, gap={7.0 / 1.2 + 3.0} s", start=start, speed=10.0))[1]
        np.testing.assert_array_equal(usual, given_gap)


def test_a_standing_vehicle_is_no_traffic_unless_it_is_on_the_crossing() -> None:
    """A person goes before a vehicle that has stopped, and waits for one that blocks the crossing."""
    assert stepped_on(*reversed(states(crossing("speed=1.4 m/s", start=194)))) < 2.0
    assert stepped_on(*reversed(states(crossing("speed=1.4 m/s", start=199)))) == np.inf


@pytest.mark.parametrize(("age", "mean"), [(8, YOUNGER), (40, YOUNGER), (70, OLDER), (None, YOUNGER)])
@pytest.mark.parametrize("in_group", [False, True])
def test_the_speed_follows_from_the_age(age: int | None, mean: float, in_group: bool) -> None:
    """The mean of many persons; groups are 0.15 m/s slower on average."""
    text = crossing(f"in_group={in_group}", age="" if age is None else f", with age {age}", time=1, back=2.4)
    text = text.replace("terminate after", "record final walker.speed as pace\nterminate after")
    scenario = compile_text(text)
    drawn = scenario.sample(600, seed=3)
    runs = [batch.trajectory(scenario.program, drawn, row, scenario.config.simulation) for row in range(0, 600, 3)]
    speeds = np.array([run.states[5, 1, State.SPEED] for run in runs])
    assert speeds.mean() == pytest.approx(mean - 0.15 * in_group, abs=4 * WALKING_DEVIATION / np.sqrt(len(speeds)))
    assert len(np.unique(speeds)) == len(speeds)


LIGHT = """
map intersection(approach=60 m, sidewalk=2.5 m, crossings=True)
signals(green=8 s, yellow=2 s, all_red=2 s)
crosswalk = intersection.crossings[{number}]
ego = new Car before intersection by 50 m along [intersection.incomingLanes[0]], with behavior BrakeBehavior()
walker = new Pedestrian at crosswalk.centerline.start offset by (0 m, -1 m), facing 0 deg,
    with behavior UseCrossingBehavior(crosswalk, speed=1.5 m/s{red})
terminate after 30 s
"""


@pytest.mark.parametrize("number", range(4))
def test_a_person_waits_for_green(number: int) -> None:
    """The person begins while the light of the other arms is green; who ignores red begins at once."""
    time, run = states(LIGHT.format(number=number, red=""))
    ignoring = states(LIGHT.format(number=number, red=", on_red=1"))[1]
    moves = np.hypot(*(run[:, 1, :2] - run[0, 1, :2]).T)
    begins = time[np.argmax(moves > 0.6)] - 0.4
    green = (begins % 24.0 < 8.0) if number % 2 else (begins % 24.0 >= 11.7)
    assert green or begins < 1.0
    early = np.hypot(*(ignoring[:, 1, :2] - ignoring[0, 1, :2]).T)
    assert time[np.argmax(early > 0.6)] < 1.0


def test_red_is_ignored_as_often_as_said() -> None:
    """Of many persons at a red light, a share of `on_red` steps onto the road."""
    text = LIGHT.format(number=0, red=", on_red=0.3").replace("after 30 s", "after 6 s")
    red = LIGHT.format(number=1, red=", on_red=0.3").replace("after 30 s", "after 6 s")
    shares = []
    for each in (text, red):
        scenario = compile_text(each)
        drawn = scenario.sample(300, seed=3)
        ends = [batch.trajectory(scenario.program, drawn, i, scenario.config.simulation).states for i in range(300)]
        shares.append(np.mean([np.hypot(*(run[-1, 1, :2] - run[0, 1, :2])) > 2.0 for run in ends]))
    assert sorted(shares) == pytest.approx([0.3, 1.0], abs=0.1)


@pytest.mark.parametrize("facing", [0, 60, 120, 180, -100])
def test_a_person_walks_along_a_sidewalk_to_its_end(facing: float) -> None:
    """In the direction that is nearer to the heading, in the middle of the sidewalk, or beside it by the offset."""
    text = f"""{PLAIN}
ego = new Car on road, with behavior BrakeBehavior()
walker = new Pedestrian at (150 m, -4.2 m), facing {facing} deg,
    with behavior WalkAlongBehavior(network.roads[0].sidewalks[0], speed=2 m/s, offset=0.3 m)
terminate after 100 s
"""
    _, run = states(text)
    ahead = abs(facing) < 90
    assert run[-1, 1, State.X] == pytest.approx(200.0 if ahead else -200.0, abs=0.2) or run[-1, 1, State.SPEED] > 0.0
    assert run[400, 1, State.Y] == pytest.approx(-4.75 + (0.3 if ahead else -0.3), abs=0.05)


@pytest.mark.parametrize(
    ("walker", "behaviour", "code"),
    [
        ("Car", "UseCrossingBehavior(crosswalk)", "SCN680"),
        ("Pedestrian", "UseCrossingBehavior(network.sidewalks[0])", "SCN310"),
        ("Pedestrian", "WalkAlongBehavior(network.lanes[0])", "SCN310"),
        ("Pedestrian", "UseCrossingBehavior(crosswalk, gap=-1 s)", "SCN410"),
        ("Pedestrian", "UseCrossingBehavior(crosswalk, on_red=2)", "SCN410"),
        ("Car, with age 3", "IdleBehavior()", "SCN2"),
        ("Pedestrian, with age 2", "IdleBehavior()", "SCN410"),
        ("Pedestrian, with age 3 m", "IdleBehavior()", "SCN3"),
    ],
)
def test_what_people_cannot_do_is_refused(walker: str, behaviour: str, code: str) -> None:
    kind, _, age = walker.partition(",")
    text = f"""{STREET}
crosswalk = network.crossings[0]
ego = new Car on road
who = new {kind} at crosswalk.centerline[0], with regionContainedIn None{"," if age else ""}{age},
    with behavior {behaviour}
"""
    with pytest.raises(CompileError) as caught:
        compile_text(text)
    assert any(each.code.startswith(code[:4]) for each in caught.value.diagnostics)


# -- drivers -----------------------------------------------------------------------------------------------------------

DRIVERS = (
    "GivingWayBehavior(11 m/s{})",
    "AutopilotBehavior(11 m/s{})",
    "EmergencyBrakeBehavior(FollowLaneBehavior(11 m/s){})",
    "RSSBehavior(FollowLaneBehavior(11 m/s){})",
    "CarefulDriverBehavior(FollowLaneBehavior(11 m/s){})",
    "FuzzySafetyBehavior(FollowLaneBehavior(11 m/s){})",
)
OFF = ", yields_at_crossings=False"
MEETING = """
lane = network.roads[0].forwardLanes.lanes[0]
begin = lane.centerline[0]
ego = new Car following roadDirection from begin for {start} m, with speed 11 m/s, with behavior {driver}
walker = new Pedestrian at (200 m, {y} m) offset by (-200 m, 0 m), facing {facing} deg,
    with regionContainedIn None, with speed {speed} m/s, with behavior ConstantSpeedBehavior({speed} m/s)
terminate after 25 s
"""


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize(("y", "facing"), [(3.0, -90), (-3.0, 90)])
def test_a_person_standing_on_a_crossing_is_waited_for(driver: str, y: float, facing: float) -> None:
    """Before whom a driver that does not yield would pass: the person faces the lane and may walk on at any time."""
    meeting = MEETING.format(start=120, driver=driver, y=y, facing=facing, speed=0.0)
    yields = states(STREET + meeting.format(""))[1]
    goes = states(STREET + meeting.format(OFF))[1]
    if abs(y) == 3.0 and y > 0.0:
        assert goes[-1, 0, State.X] > 50.0
    assert yields[-1, 0, State.SPEED] < 0.05
    assert yields[-1, 0, State.X] + 0.5 * CAR_LENGTH < -0.4
    if driver.startswith(("Giving", "Auto")):
        assert yields[-1, 0, State.X] + 0.5 * CAR_LENGTH < -HALF


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_person_who_has_passed_is_not_waited_for(driver: str) -> None:
    """A person on the crossing who walks away from the lane, or stands at the kerb, does not stop a driver."""
    for y, facing, speed in ((1.0, 90, 0.4), (-4.5, 90, 0.0), (4.5, -90, 0.0)):
        text = STREET + MEETING.format(start=120, driver=driver.format(""), y=y, facing=facing, speed=speed)
        run = states(text)[1]
        assert run[-1, 0, State.X] > 50.0, (y, facing)


@examples(5, dear=True)
@given(
    driver=st.sampled_from(DRIVERS[:4]),
    start=st.floats(40.0, 130.0),
    speed=st.floats(0.5, 2.0),
    wait=st.floats(0.0, 6.0),
    left=st.booleans(),
)
def test_nobody_on_a_crossing_is_hit_by_a_driver_who_can_stop(
    driver: str, start: float, speed: float, wait: float, left: bool
) -> None:
    """Someone in full view walks onto the crossing while the driver is still farther away than it needs to stop."""
    text = f"""{STREET}
ego = new Car following roadDirection from network.lanes[0].centerline[0] for {start} m, with speed 11 m/s,
    with behavior {driver.format("")}
behavior Walk():
    do IdleBehavior() for {wait} s
    do ConstantSpeedBehavior({speed} m/s)
walker = new Pedestrian at (0 m, {4.5 if left else -4.5} m), facing {-90 if left else 90} deg,
    with regionContainedIn None, with behavior Walk()
terminate after 25 s
"""
    time, run = states(text)
    steps = np.argmax(np.abs(run[:, 1, State.Y]) < 4.5 - 0.1)
    if -HALF - (run[steps, 0, State.X] + 0.5 * CAR_LENGTH) > 20.0:
        assert not simulated(text)[1].collided[0]
    assert len(time)


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("head", [PLAIN, "map intersection(approach=200 m)\n", "map road(bike_lane=1.8 m)\n"])
def test_without_crossings_the_switch_changes_nothing(driver: str, head: str) -> None:
    """The program is the same to the last bit, with and without it."""
    text = f"{head}ego = new Car on road, with behavior {driver}\nnew Pedestrian right of ego by 2 m\n"
    one, other = (compile_text(text.format(word)).program for word in ("", OFF))
    assert one.digest == other.digest


@pytest.mark.parametrize("side", [1, -1])
def test_drivers_keep_from_cyclists_where_the_lane_allows(side: int) -> None:
    """Past a cyclist on the bicycle lane: 1.5 m, without leaving the lane; another map has no cyclist's clearance."""
    text = """map road(lanes=1, length=400 m, lane_width=4 m, bike_lane=1.6 m, left_hand={left})
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 20 m, with speed 11 m/s,
    with behavior GivingWayBehavior(11 m/s{word})
bike = new Bicycle at (-120 m, {y} m), facing 0 deg, with speed 4 m/s, with regionContainedIn None,
    with behavior ConstantSpeedBehavior(4 m/s)
terminate after 20 s
"""
    left = side > 0
    y = (4.0 + 0.3) * (1 if left else -1)
    closest = []
    for word in ("", OFF):
        run = states(text.format(left=left, y=y, word=word))[1]
        beside = np.abs(run[:, 0, State.X] - run[:, 1, State.X]) < 2.5
        gap = np.abs(run[:, 0, State.Y] - run[:, 1, State.Y]) - 0.5 * (1.61 + 0.65)
        assert np.all(np.abs(np.abs(run[:, 0, State.Y]) - 2.0) <= 2.0 - 0.5 * 1.61 + 0.02)
        closest.append(gap[beside].min())
    assert closest[0] == pytest.approx(1.5, abs=0.06)
    assert closest[1] < 1.3
