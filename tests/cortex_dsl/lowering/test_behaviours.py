"""Behaviours, from text to what an actor does: the throttle of each step shows which line of the behaviour ran.

Every actor coasts at 1 m/s on a step of 1 s, so `self.position.x` counts the steps; a throttle of a hundredth changes
the speed a little, which the conditions below allow for.
"""

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine import batch
from engine.vocabulary import EndReason, State

HEAD = """
map intersection(approach=100 m)
simulation(time_step=1 s, max_time={steps} s)
behavior Main():
{body}
ego = new Car at (-90 m, -1.75 m), facing 0 deg, with speed 1 m/s, with behavior Main()
"""


def trace(body: str, steps: int = 12, before: str = "") -> list[int]:
    """Hundredths of throttle taken in each step."""
    indented = "\n".join(f"    {line}" for line in body.strip("\n").splitlines())
    scenario = compile_text(before + HEAD.format(body=indented, steps=steps))
    scenes = scenario.sample()
    states = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation).states
    return [round(100 * throttle) for throttle in states[1:, 0, State.THROTTLE]]


def act(hundredths: int) -> str:
    return f"take SetThrottleAction({hundredths / 100})"


def test_actions_follow_one_another_and_then_the_car_coasts() -> None:
    """A behaviour that is over leaves its actor coasting."""
    assert trace(f"{act(1)}\nwait\n{act(2)}", steps=5) == [1, 0, 2, 0, 0]


def test_loops_break_and_continue() -> None:
    """`while`, `break`, `continue` and local variables count steps."""
    body = f"""
n = 0
while True:
    n = n + 1
    if n == 2:
        {act(2)}
        continue
    elif n > 3:
        break
    {act(1)}
{act(3)}
"""
    assert trace(body, steps=6) == [1, 2, 1, 3, 0, 0]


def test_later_handlers_win_and_interrupted_ones_resume() -> None:
    """Later clauses win: handler one is cut after its first action, and goes on when handler two is done."""
    body = f"""
n = 0
try:
    while True:
        {act(9)}
interrupt when n == 0:
    n = 1
    {act(1)}
    {act(2)}
    {act(3)}
interrupt when n == 1:
    n = 2
    {act(7)}
    {act(8)}
"""
    assert trace(body, steps=7) == [1, 7, 8, 2, 3, 9, 9]


def test_abort_leaves_the_innermost_try() -> None:
    """`abort` in a handler ends the statement; what stands behind it goes on."""
    body = f"""
n = 0
try:
    while True:
        n = n + 1
        {act(1)}
interrupt when n == 3:
    {act(2)}
    abort
{act(3)}
"""
    assert trace(body, steps=6) == [1, 1, 1, 2, 3, 0]


def test_a_nested_try_is_watched_by_the_outer_one() -> None:
    """The outer handler interrupts the inner handler; the inner one then finishes."""
    body = f"""
n = 0
try:
    try:
        while True:
            {act(1)}
    interrupt when n == 0:
        n = 1
        {act(2)}
        {act(3)}
interrupt when n == 1:
    n = 2
    {act(4)}
"""
    assert trace(body, steps=5) == [2, 4, 3, 1, 1]


def test_do_until_and_do_for_end_a_sub_behaviour() -> None:
    """The condition is asked before each of its steps; a time is counted from the start."""
    before = """
behavior Forever(n):
    while True:
        take SetThrottleAction(n / 100)
"""
    body = f"do Forever(1) for 3 s\ndo Forever(2) until self.position.x > -85.2 m\n{act(5)}"
    steps = trace(body, steps=9, before=before)
    assert steps[:3] == [1, 1, 1]
    assert set(steps[3 : steps.index(5)]) == {2}
    assert steps[steps.index(5) + 1 :] == [0] * (9 - steps.index(5) - 1)


def test_return_ends_only_the_behaviour_it_stands_in() -> None:
    """The caller goes on after the call."""
    before = f"""
behavior Once():
    {act(1)}
    return
    {act(2)}
"""
    assert trace(f"do Once()\ndo Once()\n{act(3)}", steps=5, before=before) == [1, 1, 3, 0, 0]


def test_arguments_are_evaluated_when_the_behaviour_starts() -> None:
    """A changing argument keeps the value that it had at the `do`."""
    before = """
behavior Echo(n):
    take SetThrottleAction(n / 100)
    take SetThrottleAction(n / 100)
"""
    assert trace("n = 1\ndo Echo(n)\nn += 4\ndo Echo(n)", steps=5, before=before) == [1, 1, 5, 5, 0]


def test_terminate_ends_the_run_with_its_line() -> None:
    """The rule that ended the run is the statement's."""
    text = HEAD.format(steps=9, body="    wait\n    wait\n    terminate")
    scenario = compile_text(text)
    outcomes = scenario.simulate(scenario.sample())
    assert outcomes.end_reason[0] == EndReason.RULE
    assert scenario.program.rules[outcomes.end_rule[0]].line == 1 + text[: text.index("terminate")].count("\n")
    assert outcomes.end_time[0] == 2.0


def test_random_numbers_in_a_behaviour_are_drawn_anew_each_time() -> None:
    """Two draws of one line differ; the same stream repeats them."""
    text = HEAD.format(steps=8, body="    while True:\n        take SetThrottleAction(Range(0, 1))")
    scenario = compile_text(text)
    runs = [
        batch.trajectory(scenario.program, scenario.sample(seed=seed), 0, scenario.config.simulation)
        for seed in (1, 1, 2)
    ]
    throttles = [run.states[1:, 0, State.THROTTLE] for run in runs]
    assert len(set(throttles[0].tolist())) == len(throttles[0])
    np.testing.assert_array_equal(throttles[0], throttles[1])
    assert not np.array_equal(throttles[0], throttles[2])


@pytest.mark.parametrize("steps", [1, 2])
def test_a_condition_that_is_random_draws_twice_in_one_expression(steps: int) -> None:
    """Two `Range` calls in one expression are two numbers."""
    text = HEAD.format(
        steps=steps, body="    while True:\n        take SetThrottleAction(abs(Range(0, 1) - Range(0, 1)))"
    )
    scenario = compile_text(text)
    states = batch.trajectory(scenario.program, scenario.sample(), 0, scenario.config.simulation).states
    assert (states[1:, 0, State.THROTTLE] > 0).all()
