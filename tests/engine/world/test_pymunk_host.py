"""The world host: it agrees with the batch host before contact, and goes on after it."""

import math
from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine import batch, world
from engine.config import Config, ContactConfig, SimulationConfig
from engine.program import Program
from engine.scenes import Scenes
from engine.vocabulary import ActorKind, Column, EndReason, ManeuverType, State, Verdict
from engine.world.pymunk_host import EventKind

Draw = Callable[..., Scenes]
POSE = [State.X, State.Y, State.HEADING]


@pytest.fixture(scope="module")
def lane(hand):
    """A function of the other actors' kinds to a program in which actor 0 follows the southern lane straight on."""

    def make(*kinds: ActorKind) -> Program:
        code = hand.assembler(*kinds)
        path = hand.route("south", ManeuverType.STRAIGHT)
        for actor, kind in enumerate(kinds):
            if kind is not ActorKind.OBSTACLE:
                block = code.behaviour(actor)
                code.follow(block, hand.literal(path), hand.value(actor), progress=actor)
        return code.program(hand.road(), extra_values=len(kinds))

    return make


def queue(hand, kinds: tuple[ActorKind, ...], places: tuple[float, ...], speeds: tuple[float, ...]) -> Scenes:
    """One scene with actors along the southern lane, each driving at its own speed."""
    path = hand.route("south", ManeuverType.STRAIGHT)
    blocks = [hand.on_route(path, s, v, k) for k, s, v in zip(kinds, places, speeds, strict=True)]
    return hand.scenes(blocks, extra=speeds)


def test_outcomes_equal_those_of_the_batch_host(crossing: Program, crossing_scenes: Draw) -> None:
    """Flags and reasons are equal, times and metrics to 1e-9."""
    scenes = crossing_scenes(150, seed=11)
    fast, slow = batch.simulate(crossing, scenes), world.simulate(crossing, scenes)
    assert fast.collided.any()
    for field in fields(fast):
        one, other = getattr(fast, field.name), getattr(slow, field.name)
        if one.dtype.kind == "f":
            np.testing.assert_allclose(other, one, rtol=0.0, atol=1e-9)
        else:
            np.testing.assert_array_equal(other, one)


def test_states_before_contact_equal_those_of_the_batch_host(crossing: Program, crossing_scenes: Draw) -> None:
    """Every recorded pose within 1e-9 m, up to the last sample before contact."""
    scenes = crossing_scenes(25, seed=12)
    for row in range(len(scenes)):
        fast, slow = batch.trajectory(crossing, scenes, row), world.run(crossing, scenes, row).trajectory
        before = len(fast.time)
        assert slow.contact_sample == fast.contact_sample
        assert len(slow.time) >= before
        np.testing.assert_allclose(slow.states[:before], fast.states, rtol=0.0, atol=1e-9)


def test_a_run_is_the_same_every_time(crossing: Program, crossing_scenes: Draw) -> None:
    """Twice the same program, scene and config: the same bits, aftermath included, alone or among others."""
    scenes = crossing_scenes(60, seed=13)
    row = int(np.flatnonzero(world.simulate(crossing, scenes).collided)[0])
    first, again = (world.run(crossing, scenes, row) for _ in range(2))
    np.testing.assert_array_equal(first.trajectory.states, again.trajectory.states)
    assert (first.impacts, first.events) == (again.impacts, again.events)
    alone = world.simulate(crossing, scenes).min_distance[row]
    assert first.outcomes.min_distance[0] == alone


def test_invalid_scenes_are_left_alone(crossing: Program, crossing_scenes: Draw) -> None:
    """Their verdict stays, their numbers are NaN and -1; and nobody can watch them."""
    scenes = crossing_scenes(3, seed=1)
    scenes = replace(scenes, verdict=np.array([Verdict.EXHAUSTED, Verdict.VALID, Verdict.INFEASIBLE], np.int32))
    outcomes = world.simulate(crossing, scenes)
    assert outcomes.verdict.tolist() == scenes.verdict.tolist()
    assert np.isnan(outcomes.end_time).tolist() == [True, False, True]
    assert outcomes.end_reason[[0, 2]].tolist() == [-1, -1]
    with pytest.raises(ValueError, match="scene 0 is not valid"):
        world.run(crossing, scenes, 0)


def test_a_rear_end_collision_is_told_from_brake_to_rest(hand, lane) -> None:
    """The faster car hits the slower from behind; both take part of its speed and rub to rest."""
    kinds = (ActorKind.CAR, ActorKind.CAR)
    found = world.run(lane(*kinds), queue(hand, kinds, (10.0, 30.0), (15.0, 5.0)))
    assert found.outcomes.end_reason[0] == EndReason.COLLISION
    (impact, *_) = found.impacts
    assert impact.actors == (0, 1)
    assert impact.clock == (12, 6)
    assert impact.closing_speed == pytest.approx(10.0, abs=0.05)
    assert impact.delta_v == pytest.approx((5.75, 5.75), rel=0.01)
    assert found.outcomes.end_time[0] == pytest.approx((20.0 - 4.508) / 10.0, abs=0.05)
    assert impact.time == pytest.approx(found.outcomes.end_time[0], abs=2 * ContactConfig().substep)
    kinds_seen = [event.kind for event in found.events]
    assert kinds_seen.index(EventKind.CONTACT) < kinds_seen.index(EventKind.IMPACT) < kinds_seen.index(EventKind.REST)
    assert kinds_seen.count(EventKind.REST) == 2
    assert [event.time for event in found.events] == sorted(event.time for event in found.events)
    last = found.trajectory.states[-1]
    assert np.all(np.abs(last[:, State.SPEED]) < 0.01)
    assert found.trajectory.contact_sample == math.floor(found.outcomes.end_time[0] / 0.05)


def test_nothing_jumps_at_contact(hand, lane) -> None:
    """From sample to sample nobody moves farther than his speed allows: no pose is overwritten after contact."""
    kinds = (ActorKind.CAR, ActorKind.CAR)
    found = world.run(lane(*kinds), queue(hand, kinds, (10.0, 30.0), (15.0, 5.0)))
    ways = np.linalg.norm(np.diff(found.trajectory.states[..., :2], axis=0), axis=-1)
    assert ways.max() <= 15.0 * 0.05 + 0.02


def test_others_go_on_until_they_are_struck(hand, lane) -> None:
    """The third car, behind, drives into the wreck: a second impact, with the time and the pair."""
    kinds = (ActorKind.CAR, ActorKind.CAR, ActorKind.CAR)
    scenes = queue(hand, kinds, (25.0, 40.0, 12.0), (15.0, 3.0, 12.0))
    found = world.run(lane(*kinds), scenes)
    assert found.outcomes.contact_actors[0].tolist() == [0, 1]
    pairs = [impact.actors for impact in found.impacts]
    assert pairs[0] == (0, 1)
    assert (0, 2) in pairs
    contact = found.trajectory.contact_sample
    speed = found.trajectory.states[contact : contact + 3, 2, State.SPEED]
    assert speed == pytest.approx([12.0] * 3, abs=0.1)
    assert abs(found.trajectory.states[-1, 2, State.SPEED]) < 0.01


BACKS = """
map intersection(approach=60 m)
behavior Backs():
    take SetReverseAction(True)
    while True:
        take SetThrottleAction(0.3)
ego = new Car at (1.75 m, -50 m), facing 90 deg, with speed 3 m/s
wall = new Obstacle at (1.75 m, -46.5 m), with length 1 m, with width 1 m
other = new Car at (1.75 m, -38 m), facing 90 deg, with speed 0 m/s, with behavior Backs()
terminate after 12 s
"""


def test_the_aftermath_goes_on_while_somebody_backs() -> None:
    """Who still reverses when those that crashed stand drives into the wreck."""
    scenario = compile_text(BACKS)
    found = world.run(scenario.program, scenario.sample(1, seed=1), 0, scenario.config)
    assert found.outcomes.contact_actors[0].tolist() == [0, 1]
    speeds = found.trajectory.states[..., State.SPEED]
    assert np.any((speeds[:, 2] < -0.1) & (np.abs(speeds[:, :2]).max(axis=1) < 0.01))
    assert (1, 2) in [impact.actors for impact in found.impacts]


def pile(hand) -> tuple[Program, Scenes]:
    """The ego behind two others, of which the second strikes the third before the ego comes."""
    kinds = (ActorKind.CAR,) * 3
    code = hand.assembler(*kinds)
    blocks = [(0, 0, 0, 12), (30, 0, 0, 14), (40, 0.4, 0.0, 0)]
    return code.program(hand.road()), hand.scenes([hand.placed(ActorKind.CAR, *block) for block in blocks])


def test_the_world_goes_on_from_an_impact_of_others(hand) -> None:
    """Both hosts say the same of a pile; the loose body that the ego strikes had the velocity that it was left with."""
    program, scenes = pile(hand)
    fast, found = batch.simulate(program, scenes), world.run(program, scenes)
    assert fast.others_contact_time[0] == found.outcomes.others_contact_time[0] < fast.end_time[0]
    assert fast.collided[0]
    assert found.outcomes.collided[0]
    assert found.impacts[0].actors == (1, 2)
    assert any(0 in impact.actors for impact in found.impacts)
    states, contact = found.trajectory.states, found.trajectory.contact_sample
    assert list(states[contact, :, State.PRESENT]) == [1.0, 2.0, 2.0]
    ways = np.hypot(*np.diff(states[contact - 3 : contact + 1, 2, :2], axis=0).T)
    later = np.hypot(*np.diff(states[contact : contact + 2, 2, :2], axis=0).T)
    assert later[0] == pytest.approx(ways[-1], rel=0.1)


@pytest.mark.parametrize("aside", [0.0, 0.5, 1.2])
@pytest.mark.parametrize("heading", [0.0, 0.4, math.pi / 2, math.pi])
def test_pymunk_and_the_solver_tell_one_impact_alike(hand, aside: float, heading: float) -> None:
    """Delta-V of a single impact: within 0.3 m/s or 6 % of one another, whether the ego is in it or not."""
    one, other = (0.0, 0.0, 0.0, 15.0), (12.0, aside, heading, 0.0)
    far = hand.placed(ActorKind.CAR, 3000, 0, 0, 0)
    first, second = (hand.placed(ActorKind.CAR, *block) for block in (one, other))
    three, two = (hand.assembler(*(ActorKind.CAR,) * count).program(hand.road()) for count in (3, 2))
    among_others = world.run(three, hand.scenes([far, first, second]))
    of_ego = world.run(two, hand.scenes([first, second]))
    ours, pymunks = among_others.impacts[0], of_ego.impacts[0]
    assert ours.actors == (1, 2)
    assert ours.time == pytest.approx(pymunks.time, abs=0.006)
    assert ours.delta_v == pytest.approx(pymunks.delta_v, rel=0.06, abs=0.3)
    assert ours.clock == pymunks.clock
    assert ours.impact_angle == pytest.approx(pymunks.impact_angle, abs=1e-6)


def crossing_cars(hand, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Two cars at up to 30 m/s that meet after a second, at any angle."""
    heading, speed, other = random.uniform(-math.pi, math.pi), random.uniform(5.0, 30.0), random.uniform(0.0, 25.0)
    x, y = speed + 4.0 - other * math.cos(heading), random.uniform(-2.2, 2.2) - other * math.sin(heading)
    return hand.placed(ActorKind.CAR, 0, 0, 0, speed), hand.placed(ActorKind.CAR, x, y, heading, other)


BRIEF = SimulationConfig(max_time=1.6)


def test_random_crashes_have_the_delta_v_that_the_solver_gives_them(hand) -> None:
    """Half within 0.01 m/s, nine of ten within 0.15, and all within 0.5, those that scrape along one another too."""
    config = Config(simulation=BRIEF, contact=ContactConfig(aftermath=0.4))
    three, two = (hand.assembler(*(ActorKind.CAR,) * count).program(hand.road()) for count in (3, 2))
    random, apart = np.random.default_rng(5), []
    for _ in range(50):
        pair = crossing_cars(hand, random)
        if math.hypot(*(pair[1] - pair[0])[:2]) > 6.0:
            ours = world.run(three, hand.scenes([hand.placed(ActorKind.CAR, 3000, 0, 0, 0), *pair]), 0, config).impacts
            pymunks = world.run(two, hand.scenes([*pair]), 0, config).impacts
            if ours and pymunks:
                apart.append(abs(ours[0].delta_v[0] - pymunks[0].delta_v[0]))
    assert len(apart) > 30
    assert np.median(apart) < 0.01
    assert np.quantile(apart, 0.9) < 0.15
    assert max(apart) < 0.5


def test_the_same_face_is_struck_at_a_tenth_of_a_millisecond(hand) -> None:
    """Substeps of 0.1 and 2.5 ms strike the same faces of both, in pymunk, at corners too; the solver has no step."""
    program, random, met = hand.assembler(*(ActorKind.CAR,) * 2).program(hand.road()), np.random.default_rng(7), 0
    for _ in range(14):
        scenes = hand.scenes([*crossing_cars(hand, random)])
        fine, coarse = (
            world.run(program, scenes, 0, Config(BRIEF, ContactConfig(substep=step, aftermath=0.02))).impacts
            for step in (1e-4, 2.5e-3)
        )
        assert bool(fine) == bool(coarse)
        if fine:
            met += 1
            assert fine[0].clock == coarse[0].clock
            assert fine[0].direction == pytest.approx(coarse[0].direction, abs=0.15)
    assert met > 7


def test_a_fixed_obstacle_is_part_of_the_ground(hand, lane) -> None:
    """A car that hits it stops or bounces; the obstacle has no velocity and no delta-V."""
    kinds = (ActorKind.CAR, ActorKind.OBSTACLE)
    scenes = queue(hand, kinds, (10.0, 30.0), (10.0, 0.0))
    scenes.values[:, len(Column) + Column.FIXED] = 1.0
    found = world.run(lane(*kinds), scenes)
    assert found.impacts[0].delta_v[1] == 0.0
    assert found.impacts[0].delta_v[0] == pytest.approx(11.5, rel=0.02)
    assert np.ptp(found.trajectory.states[:, 1, :3], axis=0).tolist() == [0.0, 0.0, 0.0]


def test_without_aftermath_the_story_ends_with_the_step_of_contact(hand, lane) -> None:
    """A config without aftermath lets at most the step of contact and one more pass."""
    kinds = (ActorKind.CAR, ActorKind.CAR)
    config = Config(contact=ContactConfig(aftermath=0.0))
    found = world.run(lane(*kinds), queue(hand, kinds, (10.0, 30.0), (15.0, 5.0)), 0, config)
    assert len(found.trajectory.time) - found.trajectory.contact_sample <= 3


def test_a_run_without_contact_ends_with_its_reason(crossing: Program, crossing_scenes: Draw) -> None:
    """The last event names it; nothing is struck."""
    scenes, config = crossing_scenes(1, seed=2), Config(simulation=SimulationConfig(max_time=0.5))
    found = world.run(crossing, scenes, 0, config)
    assert found.trajectory.contact_sample == -1
    assert found.impacts == ()
    assert found.events[-1].kind is EventKind.END
    assert EndReason(int(found.events[-1].value)) is EndReason.TIMEOUT
    assert found.trajectory.time[-1] == pytest.approx(0.5)


def test_braking_is_told_when_it_begins(crossing: Program, crossing_scenes: Draw) -> None:
    """At the sample from which the pedal was pressed, with the speed there."""
    scenes = crossing_scenes(40, seed=4)
    for row in range(40):
        found = world.run(crossing, scenes, row, Config(contact=ContactConfig(aftermath=0.0)))
        brakes = [event for event in found.events if event.kind is EventKind.BRAKE and event.actors == (0,)]
        if brakes:
            sample = round(brakes[0].time / 0.05)
            states = found.trajectory.states[:, 0]
            assert states[sample + 1, State.BRAKE] > 0.0
            assert np.all(states[: sample + 1, State.BRAKE] <= 0.01)
            return
    pytest.fail("nobody braked")
