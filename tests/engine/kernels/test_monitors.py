"""Rules of every kind, monitors, and actors that come in later: what ends a run, when, and who was there."""

import math

import numpy as np
import pytest

from engine import batch, world
from engine.config import Config, SimulationConfig
from engine.opcodes import Op
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes
from engine.vocabulary import ActorKind, Command, EndReason, RuleKind, State, TemporalOp, Verdict

CAR = ActorKind.CAR
STEP = 0.1


def both(program: Program, scenes: Scenes, max_time: float = 2.0) -> Outcomes:
    """What the batch host makes of the scenes; the world host says the same."""
    config = SimulationConfig(time_step=STEP, max_time=max_time)
    fast = batch.simulate(program, scenes, config)
    slow = world.simulate(program, scenes, Config(simulation=config))
    for name in ("verdict", "end_reason", "end_rule", "steps", "end_time", "collided", "contact_actors"):
        np.testing.assert_array_equal(getattr(fast, name), getattr(slow, name))
    np.testing.assert_allclose(slow.min_distance, fast.min_distance, rtol=0.0, atol=1e-9)
    return fast


@pytest.fixture
def apart(hand):
    """A function to one scene of cars in rows 30 m apart, all at 10 m/s."""
    return lambda cars=2: hand.scenes([hand.placed(CAR, 0, 30.0 * i, 0, 10.0) for i in range(cars)])


def after(code, hand, seconds: float, kind: RuleKind) -> int:
    """A rule that is true from a time on."""
    rule = code.rule(hand.temporary(0), kind)
    code.emit(Op.TIME, hand.temporary(1))
    code.emit(Op.LT, hand.temporary(0), hand.literal(seconds - 1e-9), hand.temporary(1))
    code.emit(Op.END)
    return rule


@pytest.mark.parametrize(
    ("first", "second", "reason", "rule"),
    [
        (RuleKind.TERMINATE, RuleKind.ABORT, EndReason.RULE, 0),
        (RuleKind.ABORT, RuleKind.TERMINATE, EndReason.ABORTED, 0),
        (RuleKind.WATCH, RuleKind.ABORT, EndReason.ABORTED, 1),
        (RuleKind.WATCH, RuleKind.WATCH, EndReason.TIMEOUT, -1),
    ],
)
def test_the_first_true_rule_that_ends_runs_ends_the_run(hand, apart, first, second, reason, rule) -> None:
    """In the order of the rules; a watched one only keeps its value."""
    code = hand.assembler(CAR, CAR)
    after(code, hand, 0.5, first)
    after(code, hand, 0.5, second)
    outcome = both(code.program(hand.road()), apart())
    assert (outcome.end_reason[0], outcome.end_rule[0]) == (reason, rule)
    if reason != EndReason.TIMEOUT:
        assert outcome.end_time[0] == pytest.approx(0.5)


def test_an_aborted_run_has_no_metrics(hand, apart) -> None:
    """Verdict, rule and time are returned, everything that is measured is NaN."""
    code = hand.assembler(CAR, CAR)
    after(code, hand, 0.7, RuleKind.ABORT)
    outcome = both(code.program(hand.road()), apart())
    assert outcome.verdict[0] == Verdict.ABORTED
    assert (outcome.end_reason[0], outcome.end_rule[0], outcome.end_time[0]) == (
        EndReason.ABORTED,
        0,
        pytest.approx(0.7),
    )
    for name in ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms"):
        assert np.isnan(getattr(outcome, name)).all()


def test_all_rules_are_looked_at_in_the_sample_that_ends_the_run(hand, apart) -> None:
    """A watched rule behind the one that ends the run has its value there, too, and one sample a row."""
    code = hand.assembler(CAR, CAR)
    after(code, hand, 0.5, RuleKind.TERMINATE)
    watch = code.rule(hand.temporary(2), RuleKind.WATCH)
    code.emit(Op.TIME, hand.temporary(2))
    code.emit(Op.END)
    program = code.program(hand.road())
    config = SimulationConfig(time_step=STEP)
    trajectory = batch.trajectory(program, apart(), 0, config)
    assert trajectory.watched[:, watch] == pytest.approx(trajectory.time)
    assert len(trajectory.time) == 6
    lived = world.run(program, apart(), 0, Config(simulation=config)).trajectory
    np.testing.assert_array_equal(lived.watched, trajectory.watched)


def test_what_is_watched_ends_before_contact(hand) -> None:
    """The last sample watched is the last before first contact, though the world goes on."""
    code = hand.assembler(CAR, CAR)
    code.rule(hand.temporary(2), RuleKind.WATCH)
    code.emit(Op.TIME, hand.temporary(2))
    code.emit(Op.END)
    program = code.program(hand.road())
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 10.0), hand.placed(CAR, 10, 0, 0, 0.0)])
    run = world.run(program, scene, 0, Config(simulation=SimulationConfig(time_step=STEP)))
    assert len(run.trajectory.watched) == run.trajectory.contact_sample + 1 < len(run.trajectory.time)


def eventually_slow(code, hand, below: float) -> int:
    """The rule of a requirement that the ego is at some time slower than a speed."""
    watch = code.rule(hand.temporary(3), RuleKind.WATCH)
    code.emit(Op.STATE, hand.temporary(4), 0, int(State.SPEED))
    code.emit(Op.LT, hand.temporary(3), hand.temporary(4), hand.literal(below))
    code.emit(Op.END)
    return code.temporal(code.node(TemporalOp.EVENTUALLY, code.node(TemporalOp.ATOM, watch)))


@pytest.mark.parametrize(("below", "broken"), [(20.0, False), (5.0, True)])
def test_temporal_requirements_are_judged_at_the_end(hand, apart, below: float, broken: bool) -> None:
    """What never came makes the run invalid, at its end."""
    code = hand.assembler(CAR, CAR)
    rule = eventually_slow(code, hand, below)
    outcome = both(code.program(hand.road()), apart())
    expected = (EndReason.ABORTED, rule, Verdict.ABORTED) if broken else (EndReason.TIMEOUT, -1, Verdict.VALID)
    assert (outcome.end_reason[0], outcome.end_rule[0], outcome.verdict[0]) == expected
    assert outcome.end_time[0] == pytest.approx(2.0)


def test_a_contact_ends_what_a_temporal_requirement_may_hope_for(hand) -> None:
    """Judged over the samples before contact, and then there was no collision that counts."""
    code = hand.assembler(CAR, CAR)
    rule = eventually_slow(code, hand, 5.0)
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 10.0), hand.placed(CAR, 10, 0, 0, 0.0)])
    outcome = both(code.program(hand.road()), scene)
    assert (outcome.end_reason[0], outcome.end_rule[0]) == (EndReason.ABORTED, rule)
    assert not outcome.collided[0]
    assert list(outcome.contact_actors[0]) == [-1, -1]
    run = world.run(code.program(hand.road()), scene)
    assert run.trajectory.contact_sample == -1
    assert run.impacts == ()


def test_monitors_take_turns_before_actors_and_keep_their_place(hand, apart) -> None:
    """A local that a monitor counts up is seen by the behaviour of the same sample."""
    code = hand.assembler(CAR, CAR)
    block = code.behaviour(0)
    code.label("drive")
    code.take(block, Command.SPEED, hand.local(0))
    code.emit(Op.JUMP, 0, "drive")
    monitor = code.monitor()
    for turn in (3.0, 5.0, 4.0):
        code.emit(Op.MOVE, hand.local(0), hand.literal(turn))
        code.emit(Op.YIELD, 0, monitor)
    code.emit(Op.HALT)
    states = hand.states(code.program(hand.road()), apart(), max_time=0.5, time_step=STEP)
    assert list(states[1:, 0, State.SPEED]) == [3, 5, 4, 4, 4]


def test_a_monitor_may_end_the_run(hand, apart) -> None:
    """Its `terminate` is a rule like a behaviour's, and actors do not act any more in that sample."""
    code = hand.assembler(CAR, CAR)
    rule = code.behaviour_rule(RuleKind.ABORT)
    monitor = code.monitor()
    code.emit(Op.YIELD, 0, monitor)
    code.emit(Op.YIELD, 0, monitor)
    code.emit(Op.TERMINATE, 0, rule)
    outcome = both(code.program(hand.road()), apart())
    assert (outcome.end_reason[0], outcome.end_rule[0], outcome.steps[0]) == (EndReason.ABORTED, rule, 2)


def test_the_time_limit_comes_before_monitors(hand, apart) -> None:
    """At the sample of the time limit no monitor acts any more."""
    code = hand.assembler(CAR, CAR)
    rule = code.behaviour_rule()
    code.monitor()
    code.emit(Op.TERMINATE, 0, rule)
    assert both(code.program(hand.road()), apart(), max_time=0.0).end_reason[0] == EndReason.TIMEOUT


def test_a_monitor_starts_watches_and_stops_another(hand, apart) -> None:
    """A later monitor has its first turn in the sample in which it is started; it is seen running until it ends."""
    code = hand.assembler(CAR, CAR)
    watch = code.rule(hand.temporary(0), RuleKind.WATCH)
    code.emit(Op.MOVE, hand.temporary(0), hand.local(0))
    code.emit(Op.END)
    parent, child = code.monitor(), code.block()
    code.emit(Op.YIELD, 0, parent)
    code.emit(Op.SET_RESUME, 0, child, "child")
    code.label("wait")
    code.emit(Op.IS_RUNNING, hand.local(1), child)
    code.emit(Op.JUMP_UNLESS, 0, hand.local(1), "over")
    code.emit(Op.YIELD, 0, parent)
    code.emit(Op.JUMP, 0, "wait")
    code.label("over")
    code.emit(Op.MOVE, hand.local(0), hand.literal(-1))
    code.emit(Op.HALT)
    code.label("monitor 1")
    code.monitors.append((child, False))
    code.label("child")
    code.emit(Op.ADD, hand.local(0), hand.local(0), hand.literal(1))
    code.emit(Op.YIELD, 0, child)
    code.emit(Op.ADD, hand.local(0), hand.local(0), hand.literal(1))
    code.emit(Op.HALT)
    program = code.program(hand.road())
    watched = batch.trajectory(program, apart(), 0, SimulationConfig(time_step=STEP, max_time=0.5)).watched
    assert list(watched[:, watch]) == [0, 0, 1, 2, -1, -1]


def spawning(hand, delay: int, behaviour: bool = False) -> Program:
    """Two cars; the second is brought in by a monitor after some turns, and then brakes at once if it behaves."""
    code = hand.assembler(CAR, CAR)
    code.absent = frozenset({1})
    monitor = code.monitor()
    for _ in range(delay):
        code.emit(Op.YIELD, 0, monitor)
    code.emit(Op.SPAWN, 0, 1)
    code.emit(Op.HALT)
    if behaviour:
        block = code.behaviour(1)
        code.take(block, Command.BRAKE, hand.literal(1.0))
        code.emit(Op.HALT)
    return code.program(hand.road())


def test_who_is_absent_waits_at_its_place_and_then_takes_part(hand) -> None:
    """It does not move before; its behaviour begins with it; and a run with one actor present goes on."""
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 1.0), hand.placed(CAR, 50, 20, 0, 10.0)])
    states = hand.states(spawning(hand, 5, behaviour=True), scene, max_time=1.0, time_step=STEP)
    assert list(states[:, 1, State.PRESENT]) == [0] * 5 + [1] * 6
    assert set(states[:6, 1, State.X]) == {50.0}
    assert states[6, 1, State.BRAKE] == 1.0
    assert states[6, 1, State.SPEED] == pytest.approx(9.2)
    assert both(spawning(hand, 5), scene, max_time=1.0).end_reason[0] == EndReason.TIMEOUT


def test_who_is_absent_is_not_met(hand) -> None:
    """The ego drives through the place of one who is not there, and meets one who is put on top of it at once."""
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 10.0), hand.placed(CAR, 8, 0, 0, 0.0)])
    late = both(spawning(hand, 15), scene)
    assert not late.collided[0]
    assert late.min_distance[0, 0] == pytest.approx(15.0 - 8.0 - 4.508)
    assert late.min_distance_time[0, 0] == pytest.approx(1.5)
    assert late.max_closing_speed[0, 0] == pytest.approx(-10.0)
    on_top = both(spawning(hand, 8), scene)
    assert on_top.collided[0]
    assert on_top.end_time[0] == pytest.approx(0.8, abs=1e-9)
    assert on_top.min_distance[0, 0] == 0.0


def test_metrics_of_a_late_pair_are_those_of_the_same_pair_from_there_on(hand) -> None:
    """Times are counted from the start of the run."""
    late = hand.scenes([hand.placed(CAR, 0, 0, 0, 10.0), hand.placed(CAR, 60, 3, math.pi, 12.0)])
    from_there = hand.scenes([hand.placed(CAR, 5, 0, 0, 10.0), hand.placed(CAR, 60, 3, math.pi, 12.0)])
    one = both(spawning(hand, 5), late, max_time=4.5)
    other = both(hand.assembler(CAR, CAR).program(hand.road()), from_there, max_time=4.0)
    for name in ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=1e-9)
    for name in ("min_distance_time", "max_closing_time"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name) + 0.5, atol=1e-9)


def test_who_never_comes_was_never_near(hand) -> None:
    """Infinitely far at no time; and with no monitor left to bring it in, nobody waits for it."""
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 10.0), hand.placed(CAR, 8, 0, 0, 0.0)])
    outcome = both(spawning(hand, 100), scene)
    assert outcome.min_distance[0, 0] == math.inf
    assert np.isnan(outcome.min_distance_time[0, 0])
    assert (outcome.distance_at_ms[0, 0], outcome.ttc_at_ms[0, 0]) == (math.inf, math.inf)
    assert outcome.end_reason[0] == EndReason.TIMEOUT
    code = hand.assembler(CAR, CAR)
    code.absent = frozenset({1})
    assert both(code.program(hand.road()), scene).end_reason[0] == EndReason.ALL_DONE


def test_a_behaviour_that_is_stopped_leaves_its_actor_coasting(hand, apart) -> None:
    """The block of an actor may be stopped from elsewhere."""
    code = hand.assembler(CAR, CAR)
    block = code.behaviour(0)
    code.label("drive")
    code.take(block, Command.THROTTLE, hand.literal(1.0))
    code.emit(Op.JUMP, 0, "drive")
    monitor = code.monitor()
    code.emit(Op.YIELD, 0, monitor)
    code.emit(Op.SET_RESUME, 0, block, -1)
    code.emit(Op.HALT)
    states = hand.states(code.program(hand.road()), apart(), max_time=0.4, time_step=STEP)
    assert list(states[1:, 0, State.THROTTLE]) == [1, 0, 0, 0]


@pytest.mark.parametrize("scored", [True, False])
def test_after_contact_monitors_rest(hand, scored: bool) -> None:
    """Nobody new comes in while contact physics has the stage."""
    scene = hand.scenes(
        [hand.placed(CAR, 0, 0, 0, 10.0), hand.placed(CAR, 10, 0, 0, 0.0), hand.placed(CAR, 0, 40, 0, 10.0)]
    )
    code = hand.assembler(CAR, CAR, CAR)
    code.absent = frozenset({2})
    monitor = code.monitor()
    for _ in range(3 if scored else 8):
        code.emit(Op.YIELD, 0, monitor)
    code.emit(Op.SPAWN, 0, 2)
    code.emit(Op.HALT)
    config = Config(simulation=SimulationConfig(time_step=STEP))
    run = world.run(code.program(hand.road()), scene, 0, config)
    assert run.outcomes.collided[0]
    assert len(run.trajectory.time) > 12
    assert bool(run.trajectory.states[-1, 2, State.PRESENT]) == scored
