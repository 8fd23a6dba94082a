"""A second opinion: what each answer needs, and scenes whose answer can be told in advance."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine import batch
from engine.outcomes import Outcomes
from engine.verification import NOBODY, Answer, Drive, Verified, answer_of, verify
from engine.vocabulary import ActorKind, EndReason, State, Verdict

HIT = Drive(Verdict.VALID, True, 1, 2.0, 12.0, (0.0, 0.4), 20, 0.4)
MISS = replace(HIT, collided=False, distances=(1.0, 0.4), score=8)
BY_A_HAIR = replace(MISS, distances=(0.01, 0.4))
NEAR = replace(MISS, score=9)


@pytest.mark.parametrize(
    ("run", "finer", "alert", "dynamic", "answer"),
    [
        (HIT, HIT, HIT, BY_A_HAIR, Answer.DIFFERS),
        (HIT, BY_A_HAIR, HIT, MISS, Answer.MODEL),
        (HIT, HIT, None, MISS, Answer.MODEL),
        (HIT, MISS, None, MISS, Answer.STEP),
        (HIT, HIT, HIT, HIT, Answer.SURVIVES),
        (HIT, MISS, MISS, HIT, Answer.SURVIVES),
        (HIT, HIT, HIT, replace(HIT, closing_speed=14.3), Answer.SURVIVES),
        (HIT, HIT, HIT, replace(HIT, closing_speed=15.0), Answer.DIFFERS),
        (HIT, HIT, HIT, replace(HIT, partner=2), Answer.DIFFERS),
        (HIT, HIT, HIT, replace(MISS, verdict=Verdict.ABORTED), Answer.DIFFERS),
        (HIT, HIT, HIT, MISS, Answer.MODEL),
        (HIT, MISS, HIT, MISS, Answer.STEP),
        (HIT, HIT, MISS, MISS, Answer.STEP),
        (NEAR, NEAR, NEAR, MISS, Answer.SURVIVES),
        (NEAR, NEAR, NEAR, replace(MISS, score=6), Answer.MODEL),
        (NEAR, replace(MISS, score=5), NEAR, replace(MISS, score=6), Answer.STEP),
        (NEAR, NEAR, NEAR, replace(MISS, score=12), Answer.DIFFERS),
        (NEAR, NEAR, NEAR, HIT, Answer.DIFFERS),
    ],
)
def test_answers(run: Drive, finer: Drive, alert: Drive | None, dynamic: Drive, answer: Answer) -> None:
    """The second actor stands 0.4 m aside in every run: nobody is in danger of it."""
    assert answer_of(run, finer, alert, dynamic) is answer


QUEUE = """
behavior Stop():
    while True:
        take SetBrakeAction(0.7)

map intersection(approach=300 m)
lane = intersection.incomingLanes[0]
ego = new {ego} before intersection by 120 m along [lane], with speed {speed} m/s{more}
other = new {other} before intersection by 60 m along [lane], with speed 0 m/s
terminate after 12 s
"""


def opinion(ego: str = "Car", other: str = "Car", speed: float = 12.0, more: str = "") -> Verified:
    scenario = compile_text(QUEUE.format(ego=ego, other=other, speed=speed, more=more))
    scenes = scenario.sample(1, seed=2)
    (found,) = verify(scenario.program, scenes, scenario.config.simulation)
    assert found is not None
    return found


def test_whoever_rolls_into_a_standing_car_does_so_with_any_tyres() -> None:
    found = opinion()
    assert found.answer is Answer.SURVIVES
    assert found.slides == (0, 1)
    assert found.dynamic is not None
    assert found.dynamic.time == pytest.approx(found.run.time, abs=0.01)
    assert found.dynamic.closing_speed == pytest.approx(12.0, abs=0.05)


def test_an_ego_without_cited_tyres_is_not_judged_and_others_move_as_before() -> None:
    truck = opinion(ego="Truck")
    assert (truck.answer, truck.dynamic, truck.slides) == (Answer.NOT_JUDGED, None, ())
    assert opinion(other="Truck").slides == (0,)


BACKING = """
map intersection()
lane = network.lanes[0]
behavior Backs():
    take SetReverseAction(True)
    while True:
        take SetThrottleAction(0.4)
ego = new Car before intersection by 20 m along [lane], with speed 0 m/s{ego}
other = new Car before intersection by 35 m along [lane], with speed 0 m/s{other}
terminate after 6 s
"""


@pytest.mark.parametrize(("actor", "answer"), [("ego", Answer.BACKWARDS), ("other", Answer.SURVIVES)])
def test_who_drives_backwards_has_no_cited_tyres(actor: str, answer: Answer) -> None:
    """The ego is not judged then; another car moves as before."""
    behaviours = {"ego": "", "other": ""} | {actor: ", with behavior Backs()"}
    scenario = compile_text(BACKING.format(**behaviours))
    (found,) = verify(scenario.program, scenario.sample(1, seed=2), scenario.config.simulation)
    assert found is not None
    assert found.answer is answer
    assert found.slides == (() if actor == "ego" else (0,))


def test_a_scene_without_anybody_else_survives() -> None:
    scenario = compile_text(
        "map intersection(approach=300 m)\nlane = intersection.incomingLanes[0]\n"
        "ego = new Car before intersection by 50 m along [lane]\nterminate after 3 s\n"
    )
    scenes = scenario.sample(1)
    (found,) = verify(scenario.program, scenes, scenario.config.simulation)
    assert found is not None
    assert (found.answer, found.run.partner) == (Answer.SURVIVES, NOBODY)


FOLLOWS = """
map intersection(approach=300 m)
lane = intersection.incomingLanes[0]
turn = Uniform(*lane.maneuvers)
path = [turn.startLane, turn.connectingLane, turn.endLane]
ego = new Car before intersection by 60 m along path, with speed 8 m/s,
    with behavior FollowTrajectoryBehavior(8 m/s, path)
other = new Car before intersection by 150 m along [lane], with speed 6 m/s,
    with behavior ConstantSpeedBehavior(6 m/s)
terminate after 12 s
"""


def test_behaviours_follow_their_paths_with_slipping_tyres_and_with_held_commands() -> None:
    """At 8 m/s a turn uses little grip: all ways of running end within centimetres of one another."""
    scenario = compile_text(FOLLOWS)
    scenes = scenario.sample(12, seed=4)
    scenes_config = scenario.config.simulation
    fine = replace(scenes_config, time_step=0.005)
    ways = [
        batch.simulate(scenario.program, scenes, scenes_config),
        batch.simulate(scenario.program, scenes, fine, hold=10),
        batch.simulate(scenario.program, scenes, fine, hold=10, slides=(0, 1)),
    ]
    for name, tolerance in (("end_time", 0.3), ("min_distance", 0.4)):
        values = [getattr(way, name) for way in ways]
        assert np.allclose(values[1], values[0], atol=0.1, equal_nan=True), name
        assert np.allclose(values[2], values[0], atol=tolerance, equal_nan=True), name
    assert all(np.isnan(way.left_road_time).all() for way in ways)


def test_steps_do_not_matter_where_nobody_acts() -> None:
    """Held commands are the same commands: bit for bit without a driver, whatever their hold."""
    scenario = compile_text(QUEUE.format(ego="Car", other="Car", speed=12.0, more=""))
    scenes = scenario.sample(1, seed=2)
    fine = replace(scenario.config.simulation, time_step=0.005)
    held, free = (batch.simulate(scenario.program, scenes, fine, hold=hold) for hold in (10, 1))
    assert _same(held, free)


def test_without_grip_no_car_steers_or_brakes() -> None:
    """Friction scales the tyres of both models: on ice both roll on into the car ahead."""
    found = opinion(more=", with friction 0.01, with behavior ConstantSpeedBehavior(0 m/s)")
    assert found.dynamic is not None
    assert (found.run.collided, found.dynamic.collided) == (True, True)
    assert math.isfinite(found.dynamic.closing_speed)


def test_grip_of_a_run_is_that_of_its_brakes() -> None:
    scenario = compile_text(QUEUE.format(ego="Car", other="Pedestrian", speed=10.0, more=", with behavior Stop()"))
    scenes = scenario.sample(1, seed=2)
    assert scenario.program.code.actor_kind[1] == ActorKind.PEDESTRIAN
    found = batch.simulate(scenario.program, scenes, scenario.config.simulation)
    states = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation).states
    assert found.combined_grip[0, 0] == pytest.approx(-states[:, 0, State.ACCELERATION].min() / 9.81)
    assert found.lateral_grip[0, 0] == 0.0
    assert math.isnan(found.combined_grip[0, 1])


def _same(one: Outcomes, other: Outcomes) -> bool:
    names = ("verdict", "collided", "end_time", "min_distance", "closing_speed", "combined_grip")
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in names)


LUCK = """
behavior Brakes():
    while True:
        take SetBrakeAction({pedal})

map intersection(approach=300 m)
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 120 m along [lane], with speed 12 m/s, with behavior Brakes()
other = new Car before intersection by 60 m along [lane], with speed 0 m/s
terminate after 3 s
"""


@pytest.mark.parametrize(("pedal", "alert"), [("0.1", True), ("Range(0.05, 0.15)", False)])
def test_drivers_who_draw_are_not_made_alert(pedal: str, alert: bool) -> None:
    """Ten times as many turns draw ten times as many numbers: that is another scene."""
    scenario = compile_text(LUCK.format(pedal=pedal))
    (found,) = verify(scenario.program, scenario.sample(1, seed=2), scenario.config.simulation)
    assert found is not None
    assert (found.alert is not None) == alert
    assert found.finer is not None


def test_who_looks_every_tenth_step_leaves_before_the_end_of_the_road() -> None:
    """Also where the turn after the next would be too late, no outline passes the end."""
    scenario = compile_text(FOLLOWS)
    scenes = scenario.sample(12, seed=4)
    config = replace(scenario.config.simulation, time_step=0.005, max_time=60.0)
    last = {}
    for hold in (1, 10):
        outcomes = batch.simulate(scenario.program, scenes, config, hold=hold)
        last[hold] = outcomes.end_time
    assert np.all(last[10] <= last[1] + 1e-9)


LEAVES = """
map intersection(approach=40 m)
lane = intersection.incomingLanes[0]
ego = new {kind} before intersection by Range(20 m, 30 m) along [lane], with speed 12 m/s,
    with behavior FollowLaneBehavior(12 m/s)
require always ego in road
terminate after 12 s
"""


@pytest.mark.parametrize("kind", ["Car", "Truck"])
def test_no_outline_passes_the_end_of_the_road_between_two_turns(kind: str) -> None:
    """Of whoever looks every tenth step of 5 ms, the next turn is 0.6 m further on."""
    scenario = compile_text(LEAVES.format(kind=kind))
    scenes = scenario.sample(20, seed=3)
    assert scenes.valid.all()
    config = replace(scenario.config.simulation, time_step=0.005)
    for hold in (1, 10):
        outcomes = batch.simulate(scenario.program, scenes, config, hold=hold)
        assert np.all(outcomes.verdict == Verdict.VALID)
        assert np.all(outcomes.end_reason == EndReason.ALL_DONE)
