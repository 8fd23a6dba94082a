"""The coroutine machine: what a lone car's behaviour does is read off the speeds that it sets, one a turn."""

import math

import numpy as np
import pytest

from engine.kernels.jit import kernel
from engine.kernels.random_numbers import ATTEMPT_CHANNEL, open_stream, uniform
from engine.opcodes import Op
from engine.tables import Ints
from engine.vocabulary import ActorKind, Command, EndReason, Purpose, State, Verdict

STEP = 0.1
CAR = ActorKind.CAR


@pytest.fixture
def car(hand):
    """An assembler for the behaviour of one car."""
    code = hand.assembler(CAR)
    code.behaviour(0)
    return code


@pytest.fixture
def trace(hand):
    """Speeds that a lone car's behaviour sets, turn by turn, for some turns."""

    def run(code, turns: int) -> list[float]:
        code.emit(Op.HALT)
        scene = hand.scenes([hand.placed(CAR, 0.0, 0.0, 0.0, 0.0)])
        states = hand.states(code.program(hand.road()), scene, time_step=STEP, max_time=turns * STEP)
        return list(states[1:, 0, State.SPEED])

    return run


def between(code, hand, start: float, end: float):
    """A condition: the time lies in [start, end)."""

    def condition():
        code.emit(Op.TIME, hand.temporary(0))
        code.emit(Op.LE, hand.temporary(1), hand.literal(start - 1e-9), hand.temporary(0))
        code.emit(Op.LT, hand.temporary(2), hand.temporary(0), hand.literal(end - 1e-9))
        code.emit(Op.AND, hand.temporary(3), hand.temporary(1), hand.temporary(2))
        return hand.temporary(3)

    return condition


def speeds(code, hand, *values: float):
    """A block that sets one speed after the other, a turn each."""

    def write(block: int) -> None:
        for value in values:
            code.take(block, Command.SPEED, hand.literal(value))

    return write


def test_a_block_goes_on_where_it_yielded(car, hand, trace) -> None:
    """Turns follow the code row by row; when it is over the car coasts."""
    speeds(car, hand, 1, 2, 3)(0)
    assert trace(car, 5) == [1, 2, 3, 3, 3]


def test_later_handlers_win(car, hand, trace) -> None:
    """Of two conditions that hold the last clause acts; without any the body does."""
    body = speeds(car, hand, 1, 2, 3, 4, 5)
    first = (between(car, hand, 0.2, 0.4), speeds(car, hand, 10))
    last = (between(car, hand, 0.3, 0.6), speeds(car, hand, 20))
    car.attempt(0, body, first, last)
    assert trace(car, 9) == [1, 2, 10, 20, 20, 20, 3, 4, 5]


def test_interrupted_handlers_resume(car, hand, trace) -> None:
    """A later handler interrupts an earlier one in the middle; both then finish, and the body goes on."""
    body = speeds(car, hand, 1, 2, 3, 4)
    first = (between(car, hand, 0.2, 0.3), speeds(car, hand, 10, 11, 12))
    last = (between(car, hand, 0.3, 0.4), speeds(car, hand, 20, 21))
    car.attempt(0, body, first, last)
    assert trace(car, 9) == [1, 2, 10, 20, 21, 11, 12, 3, 4]


def test_earlier_handlers_wait_for_later_ones(car, hand, trace) -> None:
    """A running later handler keeps an earlier one from starting."""
    first = (between(car, hand, 0.2, 0.4), speeds(car, hand, 10))
    last = (between(car, hand, 0.1, 0.2), speeds(car, hand, 20, 21))
    car.attempt(0, speeds(car, hand, 1, 2, 3), first, last)
    assert trace(car, 6) == [1, 20, 21, 10, 2, 3]


def test_abort_leaves_the_try_at_once(car, hand, trace) -> None:
    """After `abort` the code behind the try acts in the same turn."""
    handler = (between(car, hand, 0.2, 9), lambda _: car.emit(Op.JUMP, 0, "out"))
    car.attempt(0, speeds(car, hand, 1, 2, 3, 4), handler, end="out")
    speeds(car, hand, 40, 41)(0)
    assert trace(car, 5) == [1, 2, 40, 41, 41]


def test_a_finished_body_leaves_the_try(car, hand, trace) -> None:
    """When the body ends the code behind the try acts in the same turn, handlers or not."""
    car.attempt(0, speeds(car, hand, 1), (between(car, hand, 5, 9), speeds(car, hand, 9)))
    speeds(car, hand, 2)(0)
    assert trace(car, 3) == [1, 2, 2]


def test_a_try_that_is_entered_again_starts_anew(car, hand, trace) -> None:
    """In a loop, body and handlers of a try start from their beginnings."""
    car.label("loop")
    car.attempt(0, speeds(car, hand, 1, 2), (between(car, hand, 0.3, 0.4), speeds(car, hand, 10, 11)))
    car.emit(Op.JUMP, 0, "loop")
    assert trace(car, 7) == [1, 2, 1, 10, 11, 2, 1]


def test_nested_tries(car, hand, trace) -> None:
    """An outer handler interrupts an inner one, which then resumes, and with it the inner body."""
    inner = (between(car, hand, 0.1, 0.2), speeds(car, hand, 10, 11, 12))
    outer = (between(car, hand, 0.2, 0.3), speeds(car, hand, 20))
    car.attempt(0, lambda block: car.attempt(block, speeds(car, hand, 1, 2, 3), inner), outer)
    assert trace(car, 7) == [1, 10, 20, 11, 12, 2, 3]


def test_nested_until_ends_only_the_inner_one(car, hand, trace) -> None:
    """`do (do A until t >= 0.2) until t >= 0.4`, written as tries whose handlers abort."""
    until_inner = (between(car, hand, 0.2, 99), lambda _: car.emit(Op.JUMP, 0, "inner out"))
    until_outer = (between(car, hand, 0.4, 99), lambda _: car.emit(Op.JUMP, 0, "outer out"))

    def body(block: int) -> None:
        car.attempt(block, speeds(car, hand, 1, 2, 3), until_inner, end="inner out")
        speeds(car, hand, 7, 8, 9)(block)

    car.attempt(0, body, until_outer, end="outer out")
    speeds(car, hand, 50)(0)
    assert trace(car, 6) == [1, 2, 7, 8, 50, 50]


def test_a_condition_that_is_nan_ends_the_run(car, hand, trace) -> None:
    """A condition that is NaN neither holds nor fails: the run ends as an error."""
    car.emit(Op.SQRT, hand.temporary(0), hand.literal(-1))
    car.emit(Op.JUMP_UNLESS, 0, hand.temporary(0), "no")
    speeds(car, hand, 1)(0)
    car.label("no")
    speeds(car, hand, 2)(0)
    assert trace(car, 1) == []


def test_locals_last_and_start_at_zero(car, hand, trace) -> None:
    """A local counts turns."""
    car.label("loop")
    car.emit(Op.ADD, hand.local(2), hand.local(2), hand.literal(1))
    car.take(0, Command.SPEED, hand.local(2))
    car.emit(Op.JUMP, 0, "loop")
    assert trace(car, 4) == [1, 2, 3, 4]


def test_a_behaviour_that_never_acts_is_stuck(car, hand) -> None:
    """It is stopped after its budget, and its row is returned; the run is an error."""
    car.emit(Op.YIELD, 0, 0)
    car.label("loop")
    car.emit(Op.JUMP, 0, "loop")
    program = car.program(hand.road())
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 0)])
    outcome = hand.outcome(program, scene, time_step=STEP, instruction_budget=1000)
    assert outcome.end_reason[0] == EndReason.STUCK
    assert outcome.verdict[0] == Verdict.ERROR
    assert outcome.end_rule[0] == 1
    assert outcome.end_time[0] == pytest.approx(STEP)


@pytest.mark.parametrize(("budget", "stuck"), [(20, True), (21, False)])
def test_the_budget_counts_instructions_of_one_turn(hand, budget: int, stuck: bool) -> None:
    """A turn of 21 instructions passes with a budget of 21 and not with 20."""
    code = hand.assembler(CAR)
    code.behaviour(0)
    code.label("loop")
    for _ in range(20):
        code.emit(Op.MOVE, hand.temporary(0), hand.literal(1))
    code.emit(Op.YIELD, 0, 0)
    code.emit(Op.HALT)
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 0)])
    outcome = hand.outcome(code.program(hand.road()), scene, max_time=1, instruction_budget=budget)
    assert (outcome.end_reason[0] == EndReason.STUCK) == stuck


@kernel
def _numbers(key: Ints, count: int, out) -> None:
    for i in range(count):
        out[i] = uniform(open_stream(key, Purpose.BEHAVIOUR, ATTEMPT_CHANNEL), i)


def test_random_numbers_are_those_of_the_scenes_behaviour_stream(hand) -> None:
    """Two actors draw in turn from one stream, addressed by the scene's key."""
    code = hand.assembler(CAR, CAR)
    for actor in range(2):
        block = code.behaviour(actor)
        code.label(f"loop {actor}")
        code.emit(Op.RANDOM, hand.temporary(0))
        code.take(block, Command.SPEED, hand.temporary(0))
        code.emit(Op.JUMP, 0, f"loop {actor}")
    pair = [hand.placed(CAR, 0, 0, 0, 0), hand.placed(CAR, 0, 20, 0, 0)]
    scenes = hand.scenes(pair, pair)
    for row in range(2):
        states = hand.states(code.program(hand.road()), scenes, row, max_time=0.2)
        expected = np.zeros(8)
        _numbers(scenes.keys[row], 8, expected)
        assert list(states[1:, :, State.SPEED].ravel()) == list(expected)


@pytest.mark.parametrize(
    ("x", "y", "heading", "distance", "seen"),
    [
        (10, 0, 0.0, 10.001, True),
        (10, 0, 0.0, 10.0, False),
        (-10, 0, 0.0, 20, False),
        (10, 9.9, 0.0, 20, True),
        (10, 13.1, 0.0, 20, False),
        (10, 12.0, math.pi / 2, 20, True),
        (40, 0, 0.0, 60, True),
        (52, 0, 0.0, 60, True),
        (52.3, 0, 0.0, 60, False),
        (10, 0, 0.0, -20, False),
    ],
)
def test_within_distance_is_centre_to_centre_and_in_view(hand, x, y, heading, distance, seen) -> None:
    """Nearer than the distance, and a corner or the centre in the sector of 90 degrees and 50 m."""
    code = hand.assembler(CAR, CAR)
    code.behaviour(0)
    code.emit(Op.WITHIN, hand.temporary(0), 0, hand.literal(distance))
    code.take(0, Command.SPEED, hand.temporary(0))
    code.emit(Op.HALT)
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 0), hand.placed(CAR, x, y, heading, 0)])
    states = hand.states(code.program(hand.road()), scene, max_time=0.05)
    assert states[1, 0, State.SPEED] == float(seen)


def test_states_are_those_of_the_sample(hand) -> None:
    """What an earlier actor does in this step is not seen by a later one before the next."""
    code = hand.assembler(CAR, CAR)
    speeds(code, hand, 1, 2, 3)(code.behaviour(0))
    code.emit(Op.HALT)
    block = code.behaviour(1)
    code.label("loop")
    code.emit(Op.STATE, hand.temporary(0), 0, int(State.SPEED))
    code.take(block, Command.SPEED, hand.temporary(0))
    code.emit(Op.JUMP, 0, "loop")
    scene = hand.scenes([hand.placed(CAR, 0, 0, 0, 0), hand.placed(CAR, 0, 30, 0, 0)])
    states = hand.states(code.program(hand.road()), scene, max_time=0.2)
    assert list(states[:, 1, State.SPEED]) == [0, 0, 1, 2, 3]
