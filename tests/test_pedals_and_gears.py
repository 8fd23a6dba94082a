"""Pedals, gears and limits of kinds drive as the reference says, in both hosts."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import compile_text
from engine import batch, world
from engine.kernels.motion import REVERSE_SPEED, pedal_response
from engine.tables import Floats
from engine.vehicles import BICYCLE, BUS, CAR, TRUCK
from engine.vocabulary import State
from tests.laws import examples

FIELD = """
map intersection(approach=300 m)
behavior Back():
    while True:
        take SetThrottleAction(1)
behavior Turns():
{body}
ego = new {kind} at (-100, -1.75), facing 0 deg{given}, with behavior Turns()
terminate after {seconds} s
"""


def driven(body: str, given: str = "", *, kind: str = "Car", seconds: float = 4.0) -> Floats:
    """(samples, State): one actor with these lines as its behaviour; both hosts agree on it."""
    lines = "\n".join(f"    {line}" for line in body.splitlines())
    text = FIELD.format(body=lines, given=given and f", {given}", kind=kind, seconds=seconds)
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=5)
    assert scenes.valid[0]
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    np.testing.assert_allclose(slow.states, fast.states, rtol=0.0, atol=1e-9)
    return fast.states[:, 0]


BACK = "take SetReverseAction(True)\nwhile True:\n    take SetThrottleAction({pedal})"


def test_the_reverse_gear_drives_backwards() -> None:
    """V = -a t and x = -a t^2 / 2 with half the throttle, from rest; the gear stays in."""
    states = driven(BACK.format(pedal=0.5))
    time = np.maximum(0.0, 0.05 * np.arange(len(states)) - 0.05)
    assert states[:, State.SPEED] == pytest.approx(-1.5 * time, abs=1e-9)
    assert states[:, State.X] + 100.0 == pytest.approx(-0.75 * time**2, abs=1e-9)


def test_brakes_stop_a_car_that_goes_backwards() -> None:
    """It stands at 0, and stays there, with the pedal down."""
    states = driven("take SetReverseAction(True)\ndo Back() for 2 seconds\nwhile True:\n    take SetBrakeAction(0.5)")
    assert states[:, State.SPEED].min() == pytest.approx(-3.0 * 1.95, abs=0.16)
    assert states[-1, State.SPEED] == 0.0
    assert math.copysign(1.0, states[-1, State.SPEED]) == 1.0
    assert states[states[:, State.BRAKE] > 0.0, State.ACCELERATION].max() == pytest.approx(4.0)


def test_backwards_is_forwards_seen_from_behind() -> None:
    """With the wheels turned, a drive backwards traces the arc of a drive forwards, mirrored at the rear axle."""
    steer = "take SetReverseAction({gear}), SetSteerAction(20 deg)\nwhile True:\n    take SetThrottleAction(0.4)"
    ahead, back = (driven(steer.format(gear=gear)) for gear in ("False", "True"))
    axle = [states[:, [State.X, State.Y]] - CAR.rear_to_center * heading(states) for states in (ahead, back)]
    way = [each - each[0] for each in axle]
    np.testing.assert_allclose(way[1] * [-1.0, 1.0], way[0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(back[:, State.HEADING], -ahead[:, State.HEADING], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(back[:, State.STEER], ahead[:, State.STEER], rtol=0.0, atol=1e-9)


def heading(states: Floats) -> Floats:
    return np.column_stack([np.cos(states[:, State.HEADING]), np.sin(states[:, State.HEADING])])


def test_library_drivers_put_the_gear_out() -> None:
    """Who backs up and then follows its lane rolls to a stop, and drives on forwards."""
    states = driven("take SetReverseAction(True)\ndo Back() for 2 seconds\ndo FollowLaneBehavior(8 m/s)", seconds=8)
    assert states[:, State.SPEED].min() < -4.0
    assert states[-1, State.SPEED] == pytest.approx(8.0, abs=0.1)


@pytest.mark.parametrize(
    ("kind", "top"), [("Bicycle", BICYCLE.top_speed), ("Truck", TRUCK.top_speed), ("Bus", BUS.top_speed)]
)
def test_no_throttle_goes_beyond_the_top_speed(kind: str, top: float) -> None:
    """A bicycle ends at 50 km/h, a truck at 90, a bus at 100."""
    states = driven("while True:\n    take SetThrottleAction(1)", f"with speed {top - 1.0} m/s", kind=kind)
    assert states[-1, State.SPEED] == pytest.approx(top, abs=1e-9)


def test_backwards_there_is_a_top_speed_too() -> None:
    """13.9 m/s, or the top speed of a slower vehicle."""
    assert driven(BACK.format(pedal=1), seconds=7)[-1, State.SPEED] == pytest.approx(-REVERSE_SPEED, abs=1e-9)
    slow = driven(BACK.format(pedal=1), "with topSpeed 6 m/s", seconds=7)
    assert slow[-1, State.SPEED] == pytest.approx(-6.0, abs=1e-9)


def test_pedals_build_up() -> None:
    """Of a truck's brakes: 75 % after 0.6 s, all after 0.8 s; the speed that is lost meanwhile is b t^2 / (2 T)."""
    states = driven("while True:\n    take SetBrakeAction(1)", "with speed 20 m/s", kind="Truck", seconds=3)
    assert states[12, State.BRAKE] == pytest.approx(0.75)
    assert states[16:, State.BRAKE] == pytest.approx(np.ones(len(states) - 16))
    time = 0.05 * np.arange(17)
    assert states[:17, State.SPEED] == pytest.approx(20.0 - 5.0 * time**2 / 1.6, abs=1e-9)


def test_drag_slows_who_rolls() -> None:
    """A bicycle without pedals loses 0.13 m/s^2, a car none."""
    bicycle = driven("do IdleBehavior()", "with speed 5 m/s", kind="Bicycle", seconds=3)
    assert bicycle[-1, State.SPEED] == pytest.approx(5.0 - 0.13 * 3.0, abs=1e-9)
    assert driven("do IdleBehavior()", "with speed 5 m/s", seconds=3)[-1, State.SPEED] == 5.0


def test_drag_stops_at_rest() -> None:
    """Also of a car that rolls backwards."""
    states = driven("take SetReverseAction(True)\ndo Back() for 1 seconds\ndo IdleBehavior()", "with drag 2 m/s^2")
    assert states[:, State.SPEED].min() < -2.0
    assert states[-1, State.SPEED] == 0.0


def plain_built_up(*values: float) -> tuple[float, float]:
    """`pedal_response` without a compiler: it has machine code inside its callers alone."""
    return getattr(pedal_response, "py_func", pedal_response)(*values)


@given(asked=st.floats(0, 1), before=st.floats(0, 1), build_up=st.floats(0, 10), step=st.floats(0.001, 0.1))
@examples(300)
def test_a_pedal_lies_between_before_and_asked(asked: float, before: float, build_up: float, step: float) -> None:
    """Its mean too; what is let go is let go at once, and without build-up the pedal is what was asked for."""
    after, mean = plain_built_up(asked, before, build_up, step)
    if asked <= before or build_up == 0.0:
        assert (after, mean) == (asked, asked)
    else:
        assert before <= after <= asked
        assert before - 1e-12 <= mean <= after


def test_a_pedal_that_is_no_number_stays_none() -> None:
    """NaN breaks a run; it is never hidden."""
    assert all(map(math.isnan, plain_built_up(math.nan, 0.5, 0.8, 0.05)))


STAYING = """
model scenic.simulators.newtonian.driving_model
behavior Pushes():
    while True:
        take SetThrottleAction(0.4)
behavior Once():
    take SetThrottleAction(0.4)
    do BrakeBehavior() for 1 seconds
    while True:
        wait
ego = new Car at (-1.75, 46), facing 180 deg, with speed 10, with behavior {behavior}
other = new Car at (-1.75, 30), facing 180 deg, with speed 8, with behavior FollowLaneBehavior(target_speed=9)
terminate after 8 seconds
"""


def of_ego(behavior: str) -> Floats:
    """(samples, State) of a file with a `model` line; both hosts agree on it up to contact."""
    scenario = compile_text(STAYING.format(behavior=behavior))
    scenes = scenario.sample(1, seed=5)
    assert scenes.valid[0]
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    np.testing.assert_allclose(slow.states[: len(fast.states)], fast.states, rtol=0.0, atol=1e-9)
    return fast.states[:, 0]


@pytest.mark.parametrize("driver", ["EmergencyBrakeBehavior", "RSSBehavior", "FuzzySafetyBehavior"])
def test_who_brakes_for_somebody_lets_go_again_where_pedals_stay(driver: str) -> None:
    """It brakes and eases off again, over the throttle that the driver below it holds."""
    states = of_ego(f"{driver}(Pushes())")
    hardest = int(np.argmax(states[:, State.BRAKE]))
    assert states[hardest:, State.BRAKE].min() < 0.1 * states[hardest, State.BRAKE]
    assert states[-1, State.THROTTLE] == 0.4
    assert states[-1, State.SPEED] > 4.0


def test_what_braked_for_a_time_lets_go_of_the_brake_alone() -> None:
    """The throttle that was taken before stays, as in Scenic."""
    states = of_ego("Once()")
    assert states[:, State.BRAKE].max() == 1.0
    assert states[-1, State.BRAKE] == 0.0
    assert states[-1, State.THROTTLE] == 0.4
