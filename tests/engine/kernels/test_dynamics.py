import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.dynamics import VEHICLES, agreement, apart, drive_both
from engine.kernels.actuation import BMW, driven
from engine.kernels.bicycle import GRAVITY, Demand, Vehicle
from engine.kernels.dynamics import COMMAND_STEP, SUBSTEP, Chassis, Drift, Held, hold
from engine.kernels.jit import kernel
from engine.kernels.tyres import tyre_across, tyre_along
from tests.laws import examples, share

SUBSTEPS = round(COMMAND_STEP / SUBSTEP)
VEHICLE = Vehicle(2.579, 0.551, 0.7, 3.0, 8.0, GRAVITY, math.inf)
ICE = 0.1
SEED = 32
"""Of drives of which already two stop, spin and lock their wheels."""


@kernel
def ask_for(car: Drift, demand: Demand, vehicle: Vehicle, chassis: Chassis, steps: int) -> Drift:
    for _ in range(steps):
        car = driven(car, demand, vehicle, chassis, 0.05)
    return car


def ask(car: Drift, acceleration: float, steer: float, friction: float, steps: int) -> Drift:
    """The BMW after steps of 0.05 s in which its driver asks for the same."""
    return ask_for(car, Demand(acceleration, steer), VEHICLE, BMW._replace(friction=friction), steps)


@kernel
def along(slip: float, angle: float, load: float, friction: float) -> float:
    return tyre_along(slip, angle, load, friction)


@kernel
def across(slip: float, angle: float, load: float, friction: float) -> float:
    return tyre_across(slip, angle, load, friction)


def rolling(speed: float) -> Drift:
    """A car that goes straight on, in the direction of +x."""
    return Drift(0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0, speed / 0.344, speed / 0.344)


def test_random_drives_are_those_of_commonroads_model() -> None:
    found = agreement(share(8), seed=SEED)
    assert found.farthest < 0.001
    assert min(found.stopped, found.spun, found.locked) > 0


@examples(8)
@given(st.sampled_from(VEHICLES))
def test_a_crawling_car_that_is_spurred_does_not_spin_its_wheels(vehicle: int) -> None:
    time = np.arange(600) * COMMAND_STEP
    commands = np.stack([np.where(time < 1.86, 0.03, -0.1), np.where(time < 1.86, -4.96, 2.75)], axis=1)
    assert apart(*drive_both(vehicle, 9.7, commands)) < 0.0005


@examples(8)
@given(st.sampled_from(VEHICLES), st.sampled_from([5.0, 15.0, 40.0]))
def test_turning_under_brake_is_that_of_commonroads_model(vehicle: int, speed: float) -> None:
    time = np.arange(600) * COMMAND_STEP
    commands = np.stack([np.where(time < 0.2, 0.3, -0.03), np.where(time < 1.0, -2.0, -6.0)], axis=1)
    assert apart(*drive_both(vehicle, speed, commands)) < 0.001


def test_a_driver_who_asks_for_little_gets_it() -> None:
    """In a wide bend at low speed slip angles are small: the rear axle goes round the kinematic circle."""
    car = ask(rolling(5.0), 0.0, 0.02, 1.0, 100)
    turned = 5.0 * 5.0 * math.tan(0.02) / 2.579
    assert car.heading == pytest.approx(turned, rel=0.02)
    assert car.speed == pytest.approx(5.0, rel=0.01)


def test_brakes_slow_down_as_asked_and_end_at_rest() -> None:
    car = ask(rolling(20.0), -5.0, 0.0, 1.0, 20)
    # The wheels' inertia is slowed down by the same torque.
    assert car.speed == pytest.approx(20.0 - 5.0 / (1.0 + 2.0 * 1.7 / (BMW.mass * 0.344**2)), abs=0.05)
    rest = ask(rolling(20.0), -5.0, 0.0, 1.0, 120)
    assert (rest.speed, rest.yaw_rate) == (0.0, 0.0)
    assert rest == ask(rest, -5.0, 0.0, 1.0, 20)
    assert ask(rest, 2.0, 0.0, 1.0, 20).speed == pytest.approx(2.0, rel=0.05)


def test_full_brakes_on_ice_stop_by_its_grip_and_steer() -> None:
    """Anti-lock keeps the wheels turning, so that a car on ice still follows its steering a little."""
    straight, turning = ask(rolling(10.0), -8.0, 0.0, ICE, 60), ask(rolling(10.0), -8.0, 0.05, ICE, 60)
    assert 0.75 * 3.0 < (10.0 - straight.speed) / (ICE * GRAVITY) < 1.2 * 3.0
    assert min(straight.front_wheel, straight.rear_wheel) > 0.5 * straight.speed / 0.344
    assert turning.y > 0.1


@examples(60)
@given(
    st.floats(3.0, 40.0),
    st.floats(-8.0, 3.0),
    st.floats(-0.5, 0.5),
    st.floats(0.05, 1.2),
)
def test_mirrored_commands_give_the_mirrored_drive_but_for_the_tyres(
    speed: float, acceleration: float, steer: float, friction: float
) -> None:
    """The curves of real tyres are not quite the same to either side: 3 % of the force."""
    one, other = (ask(rolling(speed), acceleration, way * steer, friction, 10) for way in (1.0, -1.0))
    way = math.hypot(one.x, one.y)
    assert math.hypot(one.x - other.x, one.y + other.y) < 0.05 * way + 0.01


@examples(60)
@given(
    st.floats(-1.3, 1.3),
    st.floats(-8.0, 8.0),
    st.floats(-0.5, 0.5),
    st.floats(-11.0, 0.0),
    st.floats(0.5, 40.0),
    st.floats(0.05, 1.2),
)
def test_a_car_under_brake_never_gains_energy(
    slip: float, yaw_rate: float, steer: float, acceleration: float, speed: float, friction: float
) -> None:
    wheel = max(0.0, speed * math.cos(slip) / 0.344)
    car = Drift(0.0, 0.0, 0.0, speed, slip, yaw_rate, steer, wheel, wheel)
    chassis = BMW._replace(friction=friction)
    # Sideways tyres pull a turning car along a little, and wheels give back what they hold.
    bound = _energy(car) * 1.001 + 100.0
    for _ in range(60):
        car = hold(car, Held(0.0, acceleration), chassis, COMMAND_STEP, SUBSTEPS)
        assert _energy(car) < bound
        bound = min(bound, _energy(car) * 1.001 + 100.0)
    assert math.isfinite(sum(car))


@pytest.mark.parametrize("slip", [1.7, 2.5, math.pi, -2.0])
def test_a_car_that_slides_backwards_slows_down(slip: float) -> None:
    car = ask(Drift(0.0, 0.0, 0.0, 15.0, slip, 0.0, 0.0, 0.0, 0.0), -8.0, 0.0, 1.0, 20)
    assert car.speed < 12.0


def test_no_tyre_holds_more_than_its_friction() -> None:
    for slip in np.linspace(-1.0, 1.0, 41).tolist():
        for angle in np.linspace(-1.5, 1.5, 41).tolist():
            total = math.hypot(along(slip, angle, 4000.0, 0.7), across(slip, angle, 4000.0, 0.7))
            assert total < 1.2 * 1.1739 * 0.7 * 4000.0


def test_without_friction_a_car_goes_straight_on() -> None:
    car = ask(rolling(12.0), -8.0, 0.4, 1e-6, 20)
    assert (car.x, car.y) == (pytest.approx(12.0, abs=1e-3), pytest.approx(0.0, abs=1e-3))


def _energy(car: Drift) -> float:
    """Of motion, the wheels' included [J]."""
    body = 0.5 * BMW.mass * car.speed**2 + 0.5 * BMW.yaw_inertia * car.yaw_rate**2
    return body + 0.5 * 1.7 * (car.front_wheel**2 + car.rear_wheel**2)
