"""Laws of one step: order of integration, grip, steering, stopping, walking."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from engine.kernels.bicycle import Demand, Motion, Vehicle, drive, walk, within_grip
from engine.kernels.jit import kernel
from engine.tables import Floats
from tests.laws import examples

CAR = Vehicle(2.579, 0.551, 0.7, 3.0, 8.0, 9.81, math.inf)
START = (0.0, 0.0, 0.3, 8.0, 0.0)


@kernel
def run_car(start: tuple, vehicle: Vehicle, demands: Floats, time_step: float, out: Floats) -> None:
    """Drive through all `demands` (n, 2); rows of `out` (n, 5) are x, y, heading, speed, steering angle."""
    x, y, heading, speed, steer = start
    motion = Motion(x, y, heading, math.cos(heading), math.sin(heading), speed, steer)
    for k in range(len(demands)):
        motion = drive(motion, Demand(demands[k, 0], demands[k, 1]), vehicle, time_step)
        out[k, 0], out[k, 1], out[k, 2] = motion.x, motion.y, motion.heading
        out[k, 3], out[k, 4] = motion.speed, motion.steer


@kernel
def run_walker(start: tuple, vehicle: Vehicle, demands: Floats, time_step: float, out: Floats) -> None:
    x, y, heading, speed, steer = start
    motion = Motion(x, y, heading, math.cos(heading), math.sin(heading), speed, steer)
    for k in range(len(demands)):
        motion = walk(motion, Demand(demands[k, 0], demands[k, 1]), vehicle, time_step)
        out[k, 0], out[k, 1], out[k, 2] = motion.x, motion.y, motion.heading
        out[k, 3], out[k, 4] = motion.speed, motion.steer


def driven(demands, start=START, vehicle=CAR, time_step=0.05, kernel=run_car):
    demands = np.array(demands, dtype=float).reshape(-1, 2)
    out = np.zeros((len(demands), 5))
    kernel(tuple(map(float, start)), vehicle, demands, time_step, out)
    return out


def test_order_of_integration_is_two() -> None:
    """Halving the step divides the error of a 4 s turn with changing speed and steering by four."""
    no_limit = CAR._replace(steer_rate=math.inf, grip=math.inf)
    steering, acceleration = (lambda t: 0.25 * np.sin(0.8 * t)), 0.5

    def slope(t: float, y: np.ndarray) -> list[float]:
        return [
            y[3] * math.cos(y[2]),
            y[3] * math.sin(y[2]),
            y[3] * math.tan(steering(t)) / CAR.wheelbase,
            acceleration,
        ]

    reference = solve_ivp(slope, (0, 4), START[:4], rtol=1e-12, atol=1e-12).y[:2, -1]
    errors = []
    for time_step in (0.1, 0.05, 0.025, 0.0125):
        t = np.arange(1, round(4 / time_step) + 1) * time_step
        demands = np.column_stack([np.full(len(t), acceleration), steering(t)])
        errors.append(np.hypot(*(driven(demands, vehicle=no_limit, time_step=time_step)[-1, :2] - reference)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 1.9) & (orders < 2.1)), (errors, orders)


@pytest.mark.parametrize("time_step", [0.05, 0.5])
def test_constant_steering_drives_an_exact_circle(time_step: float) -> None:
    """The rear axle stays on the circle of radius L / tan(delta), whatever the step and the acceleration."""
    steer = 0.4
    radius = CAR.wheelbase / math.tan(steer)
    out = driven([(0.7, steer)] * 20, (0, 0, 0, 1, steer), CAR._replace(grip=1e9), time_step)
    assert np.hypot(out[:, 0], out[:, 1] - radius) == pytest.approx(np.full(20, radius), abs=1e-9)


@given(speed=st.floats(0, 40), braking=st.floats(0.1, 8), time_step=st.sampled_from([0.01, 0.05, 0.2]))
@examples(50)
def test_braking_stops_and_never_reverses(speed: float, braking: float, time_step: float) -> None:
    """The speed reaches zero, exactly, after exactly v^2 / 2a metres, and the car then stays where it is."""
    steps = math.ceil(speed / braking / time_step) + 3
    out = driven([(-braking, 0.0)] * steps, (0, 0, 0, speed, 0), time_step=time_step)
    assert np.all(out[:, 3] >= 0.0)
    assert out[-1, 3] == 0.0
    assert np.all(np.diff(out[:, 0]) >= 0.0)
    assert out[-1, 0] == pytest.approx(speed**2 / (2 * braking), rel=1e-9, abs=1e-9)
    assert out[-1, 0] == out[-2, 0]


@given(
    acceleration=st.floats(-12, 12),
    curvature=st.floats(-0.5, 0.5),
    speed=st.floats(0, 60),
    grip=st.floats(1, 12),
)
@examples(300)
def test_what_is_held_lies_in_the_friction_circle(
    acceleration: float, curvature: float, speed: float, grip: float
) -> None:
    """At the middle of the step both grip laws hold, and a demand that tyres hold is left as it is."""
    held = within_grip(acceleration, curvature, speed, grip, 0.05)
    middle = max(speed + 0.5 * held.acceleration * 0.05, 0.0)
    assert math.hypot(held.acceleration, middle**2 * held.curvature) <= grip * (1 + 1e-12)
    assert middle * abs(middle * held.curvature) <= grip * (1 + 1e-12)
    fastest = max(speed, speed + 0.5 * acceleration * 0.05)
    if math.hypot(acceleration, fastest**2 * curvature) <= grip * (1 - 1e-12):
        assert (held.acceleration, held.curvature) == (acceleration, curvature)


def test_too_fast_for_the_bend_runs_wide() -> None:
    """At 20 m/s full steering turns the car by mu g / v, not by v tan(delta) / L, and without a change of speed."""
    out = driven([(0.0, 0.5)] * 40, (0, 0, 0, 20, 0.5))
    assert np.diff(out[:, 2]) / 0.05 == pytest.approx(np.full(39, 9.81 / 20), rel=1e-9)
    assert out[-1, 3] == 20.0


@given(target=st.floats(-2, 2), start=st.floats(-0.5, 0.5))
@examples(50)
def test_steering_is_limited_in_rate_and_angle(target: float, start: float) -> None:
    """The wheels move by at most 0.7 rad/s towards what is asked for, and never beyond their stop."""
    steer = np.array([start, *driven([(0.0, target)] * 60, (0, 0, 0, 1, start))[:, 4]])
    assert np.all(np.abs(np.diff(steer)) <= 0.7 * 0.05 + 1e-12)
    assert np.all(np.abs(steer) <= CAR.max_steer)
    assert steer[-1] == np.clip(target, -CAR.max_steer, CAR.max_steer)


def test_a_nan_demand_is_not_hidden() -> None:
    """Clipping and gripping hand NaN on, so that a broken behaviour is noticed."""
    assert np.isnan(driven([(math.nan, 0.0)])[0, 3])
    assert np.isnan(driven([(0.0, math.nan)])[0, 0])


@given(speed=st.floats(0.1, 30), turn=st.floats(-0.4, 0.4))
@examples(50)
def test_mirror_image(speed: float, turn: float) -> None:
    """Steering the other way mirrors the path, bit for bit."""
    assume(turn != 0)
    left, right = (driven([(0.5, sign * turn)] * 30, (0, 0, 0, speed, 0)) for sign in (1, -1))
    assert np.array_equal(left * [1, -1, -1, 1, -1], right)


def test_a_walker_turns_at_once_and_keeps_its_speed_limit() -> None:
    """Heading changes by what is asked for in one step; the speed ends at the limit."""
    walker = CAR._replace(max_speed=2.0)
    out = driven([(1.0, math.pi / 2), *[(1.0, 0.0)] * 60], (0, 0, 0, 0, 0), walker, kernel=run_walker)
    assert out[:, 2] == pytest.approx(np.full(61, math.pi / 2))
    assert out[-1, 3] == pytest.approx(2.0)
    assert np.all(out[:, 3] <= 2.0 + 1e-12)
    assert out[:, 0] == pytest.approx(np.zeros(61), abs=1e-12)
    assert driven([(-3.0, 0.0)] * 40, (0, 0, 0, 2, 0), walker, kernel=run_walker)[-1, 3] == 0.0
