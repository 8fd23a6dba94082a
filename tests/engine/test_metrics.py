"""The table of named metrics of one run, and the command metrics."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.metrics import Metric, measure_trajectory, pedal_oscillation, steering_oscillation
from engine.outcomes import Outcomes, blank_outcomes
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import EndReason, State

STEP = 0.05


def drive(x: float, y: float, heading: float, speed: float, samples: int = 80) -> Floats:
    states = np.zeros((samples, len(State)))
    way = speed * STEP * np.arange(samples)
    states[:, State.X], states[:, State.Y] = x + way * math.cos(heading), y + way * math.sin(heading)
    states[:, State.HEADING], states[:, State.SPEED], states[:, State.PRESENT] = heading, speed, 1.0
    return states


def trajectory(*actors: Floats, contact_sample: int = -1) -> Trajectory:
    return Trajectory(
        time=np.arange(len(actors[0]), dtype=np.float64) * STEP,
        states=np.stack(actors, axis=1),
        outlines=np.tile([4.0, 2.0], (len(actors), 1)),
        contact_sample=contact_sample,
    )


def outcomes(distance: float, time: float, collided: bool = False) -> Outcomes:
    """One row of one pair; what these tests do not read is NaN or -1."""
    return blank_outcomes(
        1,
        2,
        verdict=np.zeros(1, np.int32),
        collided=np.array([collided]),
        end_reason=np.array([EndReason.COLLISION if collided else EndReason.TIMEOUT], np.int32),
        end_time=np.array([time]),
        min_distance=np.array([[distance]]),
        min_distance_time=np.array([[time]]),
        contact_actors=np.array([[0, 1] if collided else [-1, -1]], np.int32),
    )


def named(metrics: tuple[Metric, ...], name: str, *actors: int) -> float:
    (found,) = [m for m in metrics if m.name == name and m.actors == actors]
    return found.value


def test_following_has_every_metric_of_a_follower() -> None:
    """20 m behind at 15 against 10 m/s for 1.95 s: gap 16 m at first, 6.25 m in the end."""
    run = trajectory(drive(0, 0, 0, 15, 40), drive(20, 0, 0, 10, 40))
    metrics = measure_trajectory(run, outcomes(6.25, 1.95))
    assert named(metrics, "MD", 0, 1) == 6.25
    assert named(metrics, "V_MD", 0, 1) == pytest.approx(5.0)
    assert named(metrics, "TTC_MD", 0, 1) == pytest.approx(1.25)
    assert named(metrics, "TTC", 0, 1) == pytest.approx(1.25)
    assert named(metrics, "DRAC", 0, 1) == pytest.approx(25 / 12.5)
    assert named(metrics, "THW", 0, 1) == pytest.approx((20 - 9.75) / 15)
    assert named(metrics, "PET", 0, 1) == pytest.approx(-6.25 / 10, abs=1e-3)


def test_the_instant_of_md_may_lie_between_samples() -> None:
    """Passing a standing car: halfway through a step it is alongside, and no contact lies ahead."""
    run = trajectory(drive(0, 0, 0, 20), drive(20.5, 3.5, 0, 0))
    metrics = measure_trajectory(run, outcomes(1.5, 1.025))
    assert named(metrics, "V_MD", 0, 1) == pytest.approx(20.0)
    assert named(metrics, "TTC_MD", 0, 1) == math.inf


def test_contact_makes_the_times_zero() -> None:
    """TTC, TTC at MD and PET of a pair that touched are 0; what contact physics shows is not measured."""
    ego = drive(0, 0, 0, 10)
    ego[16:, State.STEER] = np.tile([0.5, -0.5], 32)
    run = trajectory(ego, drive(11.9, 0, 0, 0), contact_sample=15)
    metrics = measure_trajectory(run, outcomes(0.0, 0.79, collided=True))
    assert [named(metrics, name, 0, 1) for name in ("TTC", "TTC_MD", "PET")] == [0.0] * 3
    assert named(metrics, "DRAC", 0, 1) == pytest.approx(100 / (2 * (11.9 - 4 - 7.5)))
    assert named(metrics, "steering oscillation", 0) == 0.0


def test_each_metric_has_a_unit_and_a_meaning() -> None:
    """And no pair or actor has two of one name."""
    metrics = measure_trajectory(trajectory(*(drive(x, 9.0 * x, 0, 5) for x in (0, 1))), outcomes(7.0, 0.0))
    assert all(metric.unit and metric.meaning for metric in metrics)
    assert len({(metric.name, metric.actors) for metric in metrics}) == len(metrics)


def test_an_actor_that_has_left_is_not_measured() -> None:
    """Metrics of the pair stop at the last sample of both."""
    ego, other = drive(0, 0, 0, 10), drive(60, 0, math.pi, 10)
    other[20:, State.PRESENT] = 0.0
    metrics = measure_trajectory(trajectory(ego, other), outcomes(37.0, 0.95))
    assert named(metrics, "TTC", 0, 1) == pytest.approx((60 - 4 - 19) / 20)


def test_steering_oscillation_counts_turns_of_the_wheel() -> None:
    """Left, right, left within 0.3 s are two changes; a rate inside the dead band has no sign."""
    states = drive(0, 0, 0, 5, 7)
    states[:, State.STEER] = [0.0, 0.1, 0.0, 0.0004, 0.0, -0.1, 0.0]
    assert steering_oscillation(states, STEP) == pytest.approx(2 / 0.3)
    states[:, State.STEER] = [0.0, 0.0004, 0.0, 0.0004, 0.0, 0.0004, 0.0]
    assert steering_oscillation(states, STEP) == 0.0


def test_pedal_oscillation_counts_switches_between_the_pedals() -> None:
    """Throttle, coasting, brake, throttle are two switches; with both pressed it is the brake."""
    states = drive(0, 0, 0, 5, 7)
    states[:, State.THROTTLE] = [0.0, 0.5, 0.5, 0.0, 0.2, 0.0, 0.5]
    states[:, State.BRAKE] = [0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0]
    assert pedal_oscillation(states, STEP) == pytest.approx(2 / 0.3)


def test_without_a_step_there_is_no_oscillation_to_speak_of() -> None:
    """A single sample has no rate."""
    assert math.isnan(steering_oscillation(drive(0, 0, 0, 5, 1), STEP))
    assert math.isnan(pedal_oscillation(drive(0, 0, 0, 5, 1), STEP))


@given(st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=40))
def test_steering_oscillation_does_not_know_left_from_right(angles: list[float]) -> None:
    """Mirrored or reversed in time the count is the same."""
    states = drive(0, 0, 0, 5, len(angles))
    states[:, State.STEER] = angles
    expected = steering_oscillation(states, STEP)
    assert steering_oscillation(states[::-1], STEP) == expected
    states[:, State.STEER] *= -1.0
    assert steering_oscillation(states, STEP) == expected
