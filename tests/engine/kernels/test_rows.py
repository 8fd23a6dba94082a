import numpy as np
import pytest

from engine.kernels.bicycle import GRAVITY
from engine.kernels.jit import kernel
from engine.kernels.rows import grip_used
from engine.tables import SLIDING, Floats
from engine.vocabulary import State

STEP = 0.05


@kernel
def used(states: Floats, last: int, grip: float) -> tuple[float, float]:
    found = grip_used(states, last, 0.05, 0, grip)
    return found.sideways, found.together


def record(speed: Floats, turn: float) -> Floats:
    """A drive with these speeds at its samples and a steady turn [rad/s]."""
    states = np.zeros((len(speed), 1, len(State)))
    states[:, 0, State.SPEED] = speed
    states[:, 0, State.HEADING] = turn * STEP * np.arange(len(speed))
    states[1:, 0, State.ACCELERATION] = np.diff(speed) / STEP
    states[:, 0, State.PRESENT] = 1.0
    return states


def test_braking_straight_on_uses_its_deceleration() -> None:
    states = record(20.0 - 6.0 * STEP * np.arange(20.0), 0.0)
    assert used(states, 19, GRAVITY) == pytest.approx((0.0, 6.0 / GRAVITY))


def test_a_steady_bend_uses_speed_times_yaw_rate() -> None:
    states = record(np.full(20, 10.0), 0.3)
    assert used(states, 19, 0.5 * GRAVITY) == pytest.approx((3.0 / (0.5 * GRAVITY),) * 2)


def test_both_add_up_as_in_a_circle_and_only_steps_of_the_run_count() -> None:
    states = record(10.0 + 4.0 * STEP * np.arange(20.0), 0.3)
    sideways = 0.3 * (10.0 + 4.0 * 9.5 * STEP)
    assert used(states, 10, GRAVITY) == pytest.approx((sideways / GRAVITY, np.hypot(4.0, sideways) / GRAVITY))


def test_a_blow_is_no_use_of_tyres() -> None:
    """Hard or gentle, it is a step of a loose body; what its driver does afterwards counts again."""
    for blow in (5.8, 0.4):
        states = record(np.array([10.0, 9.9, 9.8, 9.8 - blow, 9.6 - blow, 9.4 - blow]), 0.0)
        states[3, 0, State.PRESENT] = SLIDING
        assert used(states, 5, GRAVITY) == pytest.approx((0.0, 4.0 / GRAVITY))


def test_who_is_not_there_or_has_no_grip_uses_none() -> None:
    states = record(np.full(20, 10.0), 0.3)
    states[5:, 0, State.PRESENT] = 0.0
    assert used(states[5:], 10, GRAVITY) == (0.0, 0.0)
    assert used(record(np.full(20, 10.0), 0.0), 19, 0.0) == (0.0, 0.0)
