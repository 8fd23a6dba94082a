"""The table of named metrics of one run, and the command metrics."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.metrics import Metric, measure_trajectory
from engine.metrics.bodies import Body, usual_body
from engine.metrics.table import hardest_braking, jerk, lateral_jerk, pedal_oscillation, steering_oscillation
from engine.metrics.values import SERIOUS, pedestrian_fatality, serious_injury
from engine.outcomes import Outcomes, blank_outcomes
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import ActorKind, EndReason, Side, State
from tests.laws import examples

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
    assert all(metric.meaning for metric in metrics)
    pure = {metric.name for metric in metrics if not metric.unit}
    assert pure == {"BTN", "STN"}
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


# -- the table on scenes whose values are known by hand ----------------------------------------------------------------


def test_a_follower_needs_what_the_closed_forms_say() -> None:
    """16 m behind at 5 m/s more, nearest in the last sample: 6.25 m. A car brakes by 8 and holds 9.81 m/s^2."""
    run = trajectory(drive(0, 0, 0, 15, 40), drive(20, 0, 0, 10, 40))
    metrics = measure_trajectory(run, outcomes(6.25, 1.95))

    def value(name: str) -> float:
        return named(metrics, name, 0, 1)

    assert value("time gap") == pytest.approx(6.25 / 15)
    assert value("a_req") == pytest.approx(25 / 12.5, rel=1e-6)
    assert value("BTN") == pytest.approx(2.0 / 8.0, rel=1e-6)
    assert value("a_lat_req") == pytest.approx(2 * 2.0 / 1.25**2, rel=1e-6)
    assert value("STN") == pytest.approx(value("a_lat_req") / 9.81)
    assert value("TTB") == pytest.approx(1.25 - 5 / 16, abs=1e-6)
    assert value("TTS") == pytest.approx(1.25 - math.sqrt(4 / 9.81), abs=1e-6)
    assert value("TTK") == -math.inf
    assert value("TTR") == pytest.approx(value("TTB"))
    assert value("TTR") >= max(value("TTB"), value("TTS"), value("TTK"))
    below = [ttc for ttc in (3.2 - 0.05 * k for k in range(40)) if ttc <= 3.0 + 1e-9]
    assert value("TET") == pytest.approx(len(below) * 0.05)
    assert value("TIT") == pytest.approx(sum(3.0 - ttc for ttc in below) * 0.05, abs=1e-9)
    assert value("RSS") == pytest.approx(40 * 0.05)
    assert value("dV_ego") == value("dV_other") == pytest.approx(2.5)
    assert math.isnan(value("PET_area"))
    assert value("ET") == pytest.approx(1.95 - 16 / 15)


def test_a_crossing_has_its_times_by_area() -> None:
    """The ego is in the square from 1.7 to 2.3 s, the other from 2.9 s on; by shift it is the same."""
    run = trajectory(drive(-20, 0, 0, 10, 120), drive(0, -32, math.pi / 2, 10, 120))
    metrics = measure_trajectory(run, outcomes(3.0, 2.3))
    assert named(metrics, "PET_area", 0, 1) == pytest.approx(0.6, abs=1e-6)
    assert named(metrics, "PET", 0, 1) == pytest.approx(0.6, abs=1e-3)
    assert named(metrics, "ET", 0, 1) == pytest.approx(0.6, abs=1e-6)
    assert named(metrics, "RSS", 0, 1) == 0.0


def test_who_goes_on_before_the_other_comes_has_a_time_too() -> None:
    """The ego has left the scene before the other is in the square: the time between the two counts."""
    ego, other = drive(-20, 0, 0, 10, 120), drive(0, -50, math.pi / 2, 10, 120)
    ego[60:, State.PRESENT] = 0.0
    metrics = measure_trajectory(trajectory(ego, other), outcomes(20.0, 2.0))
    assert named(metrics, "PET_area", 0, 1) == pytest.approx(4.7 - 2.3, abs=1e-6)


def test_the_lighter_one_changes_its_velocity_more() -> None:
    """By the other's share of both masses; the impulses are equal."""
    bodies = (usual_body(ActorKind.CAR, 4.0, 2.0), usual_body(ActorKind.PEDESTRIAN, 0.5, 0.6))
    run = trajectory(drive(0, 0, 0, 10, 10), drive(20, 0, 0, 0, 10))
    metrics = measure_trajectory(run, outcomes(12.0, 0.45), bodies)
    ego, other = named(metrics, "dV_ego", 0, 1), named(metrics, "dV_other", 0, 1)
    assert ego + other == pytest.approx(10.0)
    assert ego * bodies[0].mass == pytest.approx(other * bodies[1].mass)


def test_death_is_told_of_people_on_foot_before_a_car_alone() -> None:
    """At 36 km/h 1 / (1 + exp(3.66)); by the abstract 50 km/h has twice the risk of 40 and five times that of 30."""
    bodies = (usual_body(ActorKind.CAR, 4.0, 2.0), usual_body(ActorKind.PEDESTRIAN, 0.5, 0.6))
    run = trajectory(drive(0, 0, 0, 10), drive(10, 0.5, math.pi / 2, 1), contact_sample=15)
    met = replace(outcomes(0.0, 0.775, collided=True), ego_speed=np.array([[10.0]]))
    metrics = measure_trajectory(run, met, bodies)
    assert named(metrics, "P_fatal", 0, 1) == pytest.approx(1 / (1 + math.exp(6.9 - 0.090 * 36)))
    slower = replace(met, ego_speed=np.array([[9.9]]))  # it brakes in the step of contact, too
    assert named(measure_trajectory(run, slower, bodies), "P_fatal", 0, 1) == pedestrian_fatality(9.9)
    beside = trajectory(drive(0, 0, 0, 10), drive(4, 1.3, -math.pi / 2, 1), contact_sample=15)
    assert "P_fatal" not in {m.name for m in measure_trajectory(beside, outcomes(0.0, 0.775, collided=True), bodies)}
    assert "P_fatal" not in {m.name for m in measure_trajectory(run, outcomes(0.0, 0.775, collided=True))}
    thirty, forty, fifty = (pedestrian_fatality(speed / 3.6) for speed in (30, 40, 50))
    assert fifty > 2 * forty
    assert fifty > 5 * thirty


@pytest.mark.parametrize(
    ("kind", "speed"), [(ActorKind.PEDESTRIAN, 29.0), (ActorKind.BICYCLE, 44.0), (ActorKind.CAR, 112.0)]
)
def test_serious_injuries_are_as_likely_as_their_source_says(kind: ActorKind, speed: float) -> None:
    """10 % at the speed that its abstract prints to the km/h, as far as coefficients of three decimals can say."""
    curve, half = SERIOUS[kind], 0.0005
    without = math.log(0.1 / 0.9) - curve.constant - curve.per_year * curve.age
    spread = half * (1.0 + curve.age)
    assert (without - spread) / (curve.per_km_h + half) <= speed <= (without + spread) / (curve.per_km_h - half)
    assert serious_injury(kind, speed / 3.6) == pytest.approx(0.1, abs=0.01)
    assert serious_injury(ActorKind.TRUCK, speed / 3.6) is None


def test_who_is_more_exposed_before_a_front_says_how_serious_it_is() -> None:
    """Head-on both cars are at 20 m/s; who only runs into a car's side meets no front, and whom it strikes does."""
    car, walker = usual_body(ActorKind.CAR, 4.0, 2.0), usual_body(ActorKind.PEDESTRIAN, 0.5, 0.6)
    truck = usual_body(ActorKind.TRUCK, 4.0, 2.0)

    def risk(
        other: Body, run: Trajectory, ego: float, speed: float, angle: float, side: Side = Side.FRONT
    ) -> float | None:
        met = replace(
            outcomes(0.0, 0.775, collided=True),
            ego_speed=np.array([[ego]]),
            other_speed=np.array([[speed]]),
            approach_angle=np.array([[angle]]),
            side=np.array([[side]]),
        )
        metrics = measure_trajectory(run, met, (car, other))
        return next((m.value for m in metrics if m.name == "P_serious"), None)

    head_on = trajectory(drive(0, 0, 0, 10), drive(19, 0, math.pi, 10), contact_sample=15)
    assert risk(car, head_on, 10.0, 10.0, math.pi) == serious_injury(ActorKind.CAR, 20.0)
    assert risk(truck, head_on, 10.0, 10.0, math.pi) is None  # its driver has no curve, and it is no car
    across = trajectory(drive(0, 0, 0, 10), drive(10, 0.5, math.pi / 2, 1), contact_sample=15)
    assert risk(walker, across, 10.0, 1.0, math.pi / 2) == serious_injury(ActorKind.PEDESTRIAN, math.hypot(10, 1))
    beside = trajectory(drive(0, 0, 0, 10), drive(4, 1.3, -math.pi / 2, 1), contact_sample=15)
    assert risk(walker, beside, 10.0, 1.0, -math.pi / 2, Side.LEFT) is None


def test_jerk_is_the_change_of_acceleration() -> None:
    """Braking by 8 m/s^2 at once is 160 m/s^3 in a step of 0.05 s; a turn at once the same of v times yaw rate."""
    states = drive(0, 0, 0, 10, 9)
    states[4:, State.SPEED] = 10 - 8 * STEP * np.arange(1, 6)
    assert jerk(states, STEP) == pytest.approx(160.0)
    assert hardest_braking(states, STEP) == pytest.approx(8.0)
    assert lateral_jerk(states, STEP) == 0.0
    states = drive(0, 0, 0, 10, 9)
    states[4:, State.HEADING] = 0.2 * STEP * np.arange(1, 6)
    assert lateral_jerk(states, STEP) == pytest.approx(10 * 0.2 / STEP)
    assert math.isnan(jerk(states[:2], STEP))
    assert math.isnan(hardest_braking(states[:1], STEP))


@pytest.mark.parametrize(
    ("speeds", "braking"),
    [([0.0, -1.0, -2.0], 0.0), ([-2.0, -1.7, -1.5], 0.3), ([0.3, -0.5, -1.0], 0.0), ([2.0, 1.6, 2.0], 0.4)],
)
def test_braking_makes_slower_also_backwards(speeds: list[float], braking: float) -> None:
    """Gathering speed in reverse is no braking, nor is to turn from one way to the other."""
    states = drive(0, 0, 0, 0, len(speeds))
    states[:, State.SPEED] = speeds
    assert hardest_braking(states, STEP) == pytest.approx(braking / STEP)


@examples(25)
@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(-3, 3), st.floats(0, 15), st.floats(-3, 3))
def test_no_metric_knows_where_east_is(x: float, y: float, heading: float, speed: float, turn: float) -> None:
    """A run as a whole turned and carried elsewhere has every metric again, but where outlines only graze."""

    def moved(states: Floats) -> Floats:
        moved = states.copy()
        cos, sin = math.cos(turn), math.sin(turn)
        moved[:, State.X] = cos * states[:, State.X] - sin * states[:, State.Y] + 7.0
        moved[:, State.Y] = sin * states[:, State.X] + cos * states[:, State.Y] - 3.0
        moved[:, State.HEADING] += turn
        return moved

    drives = drive(0, 0, 0, 8), drive(x, y, heading, speed)
    first, second = (
        measure_trajectory(trajectory(*each), outcomes(5.0, 1.0)) for each in (drives, [moved(one) for one in drives])
    )
    assert [metric.name for metric in first] == [metric.name for metric in second]
    for one, other in zip(first, second, strict=True):
        if math.isfinite(one.value) and math.isfinite(other.value):
            assert other.value == pytest.approx(one.value, rel=1e-3, abs=0.051), one.name
