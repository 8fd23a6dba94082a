"""Start positions that follow from a meeting, and courses of speed: what they promise holds in every run."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import CompileError, compile_text
from engine import batch
from engine.tables import Floats
from engine.vocabulary import State

from .laws import examples

MEETING = """
map road(lanes=2, length=2 km, lane_width=12 m)
ego = new Car at (-500, 3), facing {turned} deg, with speed {speed} m/s, with regionContainedIn None,
    with behavior ConstantSpeedBehavior({speed} m/s)
other = new {kind} meeting ego at {place} after {time} s, facing {heading} deg, with speed {own} m/s,
    with drag 0 m/s^2, with regionContainedIn None, with behavior ConstantSpeedBehavior({own} m/s)
terminate after 12 s
"""


def contact_of(text: str) -> tuple[float, Floats]:
    """Return the time of contact, and the states (actors, columns) there."""
    scenario = compile_text(text)
    scenes = scenario.sample(1, seed=1)
    assert scenes.valid[0]
    run = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    when = float(scenario.simulate(scenes).end_time[0])
    states = run.states[-1].copy()
    far = states[:, State.SPEED] * (when - run.time[-1])
    heading = states[:, State.HEADING]
    states[:, :2] += (far * np.array([np.cos(heading), np.sin(heading)])).T
    return when, states


def seen_from_ego(states: Floats, turned: float) -> tuple[float, float]:
    """Return the place of the other actor in the frame of the ego: to the right and ahead [m]."""
    x, y = states[1, :2] - states[0, :2]
    c, s = math.cos(math.radians(turned)), math.sin(math.radians(turned))
    return x * s - y * c, x * c + y * s


@examples(60)
@given(
    turned=st.sampled_from([0, 90, -40, 180]),
    relative=st.sampled_from([0, 90, -90, 180]),
    kind=st.sampled_from(["Car", "Pedestrian", "Motorcycle", "Bicycle"]),
    share=st.floats(0.02, 0.98),
    time=st.floats(0.5, 6.0),
    speed=st.floats(6.0, 30.0),
    part=st.floats(0.0, 0.9),
)
def test_the_front_meets_a_share_of_the_width_at_the_time(
    turned: int, relative: int, kind: str, share: float, time: float, speed: float, part: float
) -> None:
    """Outlines touch at the time, not before, and the centre of the other is then at the share of the ego's width."""
    own = min(part * speed, 5.0)
    text = MEETING.format(
        turned=turned, speed=speed, kind=kind, place=share, time=time, heading=turned + relative, own=own
    )
    when, states = contact_of(text)
    right, _ = seen_from_ego(states, turned)
    assert when == pytest.approx(time, abs=1e-6)
    assert right == pytest.approx((0.5 - share) * 1.61, abs=1e-5)


@examples(40)
@given(place=st.floats(-0.45, 0.45), time=st.floats(1.0, 6.0), speed=st.floats(0.0, 20.0), own=st.floats(2.0, 20.0))
def test_a_front_meets_a_place_of_the_side(place: float, time: float, speed: float, own: float) -> None:
    """A motorcycle from the right hits the side of the ego at that place."""
    at = f"ego.width / 2 @ {place * 4.508}"
    when, states = contact_of(
        MEETING.format(turned=0, speed=speed, kind="Motorcycle", place=at, time=time, heading=90, own=own)
    )
    right, ahead = seen_from_ego(states, 0)
    assert when == pytest.approx(time, abs=1e-6)
    assert ahead == pytest.approx(place * 4.508, abs=1e-5)
    assert right == pytest.approx(1.61 / 2 + 2.1 / 2, abs=1e-5)


def test_an_object_that_speeds_up_meets_after_the_way_that_by_gives() -> None:
    """From standstill over 1 m, then 3 m at 5 km/h: 5 m / (5 km/h) in all."""
    when, states = contact_of(
        """
map road(length=400 m)
ego = new Car at (-100, -1.75), facing 0 deg, with speed 12 m/s, with behavior ConstantSpeedBehavior(12 m/s)
child = new Pedestrian meeting ego at 0.3 after 4 s by 4 m, facing 90 deg, with regionContainedIn None,
    with behavior AccelerateThenKeepBehavior(5 km/h, 1 m, delay=4 s - 5 m / (5 km/h))
"""
    )
    assert when == pytest.approx(4.0, abs=1e-6)
    assert seen_from_ego(states, 0)[0] == pytest.approx(0.2 * 1.61, abs=1e-3)


COURSE = """
map road(length=2 km)
ego = new Car at (-900, -1.75), facing 0 deg, with speed {first} m/s, with behavior {behaviour}
terminate after 15 s
"""


def speeds_and_ways(first: float, behaviour: str) -> tuple[Floats, Floats, Floats]:
    """Return times [s], speeds [m/s] and distances [m] of a run."""
    scenario = compile_text(COURSE.format(first=first, behaviour=behaviour))
    scenes = scenario.sample(1, seed=1)
    run = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    return run.time, run.states[:, 0, State.SPEED], run.states[:, 0, State.X] + 900.0


@examples(30)
@given(rate=st.floats(0.2, 2.9), speed=st.floats(1.0, 8.0), delay=st.floats(0.0, 3.0))
def test_a_speed_is_reached_over_its_distance(rate: float, speed: float, delay: float) -> None:
    """V = sqrt(2 a x) while it speeds up, and x = v (t - delay) - distance afterwards."""
    distance = speed**2 / (2.0 * rate)
    time, v, x = speeds_and_ways(0.0, f"AccelerateThenKeepBehavior({speed} m/s, {distance} m, delay={delay} s)")
    bend = rate * 0.05**2
    expected = np.minimum(speed, rate * np.maximum(time - delay, 0.0))
    np.testing.assert_allclose(v, expected, atol=1e-9)
    late = time > delay + speed / rate + 0.1
    np.testing.assert_allclose(x[late], speed * (time[late] - delay) - distance, atol=bend)


@examples(30)
@given(
    first=st.floats(3.0, 30.0), rate=st.floats(0.5, 7.9), rise=st.floats(0.0, 1.5),
    delay=st.floats(0.0, 2.0), end=st.floats(0.0, 10.0),
)  # fmt: skip
def test_a_brake_holds_its_deceleration_down_to_its_speed(
    first: float, rate: float, rise: float, delay: float, end: float
) -> None:
    """The deceleration grows to its value during the rise, and the speed stays at the end speed."""
    call = f"BrakeToBehavior({rate} m/s^2, end_speed={end} m/s, rise={rise} s, delay={delay} s)"
    time, v, _ = speeds_and_ways(first, call)
    lasted = np.maximum(time - delay, 0.0)
    lost = rate * np.where(lasted < rise, lasted**2 / (2.0 * max(rise, 1e-9)), lasted - rise / 2.0)
    np.testing.assert_allclose(v, np.minimum(first, np.maximum(first - lost, end)), atol=1e-6)


def test_an_expectation_limits_the_relative_speed_at_contact() -> None:
    """It is broken in the runs whose speeds at contact differ by more, as the outcomes have them."""
    limit = 10.0 / 3.6
    scenario = compile_text(
        """
map road(length=400 m)
param SPEED = Range(30, 60) km/h
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 50 m, with speed SPEED,
    with behavior EmergencyBrakeBehavior(FollowLaneBehavior(SPEED), threshold=0.8 s)
other = new Car meeting ego at 0.5 after 4 s, with speed 5 km/h, with behavior FollowLaneBehavior(5 km/h)
expect always not self.collided or ego.speed - other.speed <= 10 km/h as "at most 10 km/h at contact"
"""
    )
    outcomes = scenario.simulate(scenario.sample(60, seed=3))
    relative = (outcomes.ego_speed - outcomes.other_speed)[:, 0]
    too_fast = outcomes.collided & (relative > limit)
    assert 0 < too_fast.sum() < outcomes.collided.sum() < 60
    assert ((outcomes.broken[:, 0] == 1.0) == too_fast).all()


@pytest.mark.parametrize(
    ("meeting", "code", "said", "place"),
    [
        ("meeting ego at -1 after 4 s", "SCN402", "the share of the width after `at` is -1", "-1"),
        ("meeting ego at 50 after 4 s", "SCN402", "must be between -0.9 and 1.9", "50"),
        ("meeting ego at SHARE after 4 s", "SCN403", "may become -2", "SHARE"),
        ("meeting ego at 0.5 after 1e9 s", "SCN402", "must be between 0 s and 1000 s", "1e9 s"),
        ("meeting ego at 0.5 after -1 s", "SCN402", "must be at least 0 s", "-1 s"),
        ("meeting ego after 4 s", "SCN101", "a meeting lacks `at P`", "after"),
        ("meeting ego at 0.5", "SCN101", "a meeting lacks `after T`", ","),
        ("meeting ego", "SCN101", "a meeting lacks `at P`", ","),
        ("meeting at 0.5 after 4 s", "SCN101", "a meeting lacks an object", "at"),
        ("meeting ego at 0.5 by 4 m", "SCN101", "a meeting lacks `after T`", "by"),
    ],
)
def test_a_meeting_that_cannot_be_is_refused_at_its_place(meeting: str, code: str, said: str, place: str) -> None:
    """A place beside the other, a time of years, and a meeting without a part have a diagnostic there, with a cure."""
    text = f"""
map road(length=400 m)
param SHARE = Range(-2, 2)
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 50 m, with speed 10 m/s
other = new Car {meeting}, with speed SHARE * 1 m/s + 3 m/s
"""
    with pytest.raises(CompileError) as caught:
        compile_text(text)
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert said in found.message
    assert text[found.label.span.start : found.label.span.end] == place
    assert found.cure


def test_places_of_the_suites_are_meetings() -> None:
    """Targets beside the width of the car, with their tolerances, are met."""
    for share in (-0.61, -0.25, 1.25, 1.61):
        compile_text(
            f"""
map road(length=400 m)
ego = new Car following roadDirection from network.lanes[0].centerline[0] for 50 m, with speed 10 m/s
other = new Car meeting ego at {share} after 4 s, with speed 1 m/s
"""
        )
