"""TTC, DRAC, THW and PET on encounters whose answers are known by hand, and their laws."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from engine.kernels.conflict import (
    Snapshot,
    post_encroachment_time,
    required_deceleration,
    time_headway,
    time_to_collision,
)
from engine.kernels.geometry import Box, box_distance
from engine.kernels.pair import Rate
from engine.tables import Floats
from engine.vocabulary import State

STEP = 0.05
OUTLINES = np.array([[4.0, 2.0, 0.0], [4.0, 2.0, 0.0]])


def car(x: float, y: float, heading: float, speed: float) -> tuple[Box, Rate]:
    return Box(x, y, heading, 4.0, 2.0), Rate(speed * math.cos(heading), speed * math.sin(heading))


def pair(ego: tuple[Box, Rate], other: tuple[Box, Rate]) -> Snapshot:
    return Snapshot(ego[0], other[0], ego[1], other[1])


@st.composite
def snapshots(draw: st.DrawFn) -> Snapshot:
    place, angle, speed = st.floats(-30.0, 30.0), st.floats(-3.0, 3.0), st.floats(0.0, 20.0)
    return pair(*(car(draw(place), draw(place), draw(angle), draw(speed)) for _ in range(2)))


def later(now: Snapshot, time: float) -> float:
    """Distance of the outlines after both kept their velocities for a time."""
    ego = now.ego._replace(x=now.ego.x + now.ego_rate.x * time, y=now.ego.y + now.ego_rate.y * time)
    other = now.other._replace(x=now.other.x + now.other_rate.x * time, y=now.other.y + now.other_rate.y * time)
    return box_distance(ego, other)


def mirrored(now: Snapshot) -> Snapshot:
    def box(b: Box) -> Box:
        return b._replace(y=-b.y, heading=-b.heading)

    return Snapshot(box(now.ego), box(now.other), *(Rate(r.x, -r.y) for r in (now.ego_rate, now.other_rate)))


def rotated(now: Snapshot, turn: float) -> Snapshot:
    def place(x: float, y: float) -> tuple[float, float]:
        return x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)

    def box(b: Box) -> Box:
        return Box(*place(b.x, b.y), b.heading + turn, b.length, b.width)

    return Snapshot(box(now.ego), box(now.other), *(Rate(*place(*r)) for r in (now.ego_rate, now.other_rate)))


def test_ttc_behind_a_slower_car_is_gap_over_difference() -> None:
    """10 m behind at 5 m/s more: 2 s; and the deceleration needed is (v2 - v1)^2 / (2 gap)."""
    now = pair(car(0, 0, 0, 15), car(14, 0.5, 0, 10))
    assert time_to_collision(now) == pytest.approx(2.0)
    assert required_deceleration(now) == pytest.approx(25.0 / 20.0)


def test_ttc_of_a_crossing_is_when_corners_meet() -> None:
    """The ego's front reaches the other's strip after 0.7 s, where the other is from 0.6 s to 1.2 s."""
    now = pair(car(-10, 0, 0, 10), car(0, -9, math.pi / 2, 10))
    assert time_to_collision(now) == pytest.approx(0.7)
    assert time_to_collision(pair(car(-10, 0, 0, 10), car(0, -20, math.pi / 2, 10))) == math.inf


@given(snapshots())
@example(pair(car(0.0, 4.0, 1.0, 2e-309), car(0.0, 0.0, 0.0, 0.0)))  # so slow that all times are infinite
def test_ttc_is_the_first_touch_of_outlines_that_keep_their_velocities(now: Snapshot) -> None:
    """At TTC they touch, at no time before they overlap; without TTC they never do."""
    ttc = time_to_collision(now)
    if math.isfinite(ttc):
        assert later(now, ttc) < 1e-6
    assert all(later(now, time) > 0.0 for time in np.linspace(0.0, min(ttc, 60.0), 300) if time < ttc - 1e-6)


@given(snapshots(), st.floats(-3.0, 3.0))
def test_measures_do_not_depend_on_the_axes(now: Snapshot, turn: float) -> None:
    """Turned or mirrored, an instant has the same TTC, DRAC and THW; TTC and DRAC do not mind who is the ego."""
    assume(not grazing(now))
    swapped = Snapshot(now.other, now.ego, now.other_rate, now.ego_rate)
    for measure in (time_to_collision, required_deceleration):
        for same in (mirrored(now), rotated(now, turn), swapped):
            assert measure(same) == pytest.approx(measure(now), rel=1e-6, abs=1e-9)
    assert time_headway(mirrored(now)) == pytest.approx(time_headway(now), rel=1e-9)


def grazing(now: Snapshot) -> bool:
    """Whether outlines a little larger or smaller would decide otherwise."""

    def sized(scale: float) -> float:
        ego, other = [box._replace(length=4.0 * scale, width=2.0 * scale) for box in (now.ego, now.other)]
        return time_to_collision(Snapshot(ego, other, now.ego_rate, now.other_rate))

    larger, smaller = sized(1.0 + 1e-6), sized(1.0 - 1e-6)
    return math.isfinite(larger) != math.isfinite(smaller) or (larger == 0.0) != (smaller == 0.0)


def test_headway_counts_from_front_to_front_behind_a_leader_only() -> None:
    """20 m from centre to centre at 10 m/s is 2 s between equal cars; no leader, no headway."""
    assert time_headway(pair(car(0, 0, 0, 10), car(20, 0.5, 0, 3))) == pytest.approx(2.0)
    for other in (car(-20, 0, 0, 3), car(20, 5, 0, 3), car(20, 0, math.pi, 3)):
        assert time_headway(pair(car(0, 0, 0, 10), other)) == math.inf
    assert time_headway(pair(car(0, 0, 0, 0), car(20, 0, 0, 3))) == math.inf


def drive(x: float, y: float, heading: float, speed: float, samples: int = 120) -> Floats:
    states = np.zeros((samples, len(State)))
    way = speed * STEP * np.arange(samples)
    states[:, State.X], states[:, State.Y] = x + way * math.cos(heading), y + way * math.sin(heading)
    states[:, State.HEADING], states[:, State.SPEED], states[:, State.PRESENT] = heading, speed, 1.0
    return states


def pet(ego: Floats, other: Floats) -> float:
    states = np.stack([ego, other], axis=1)
    return post_encroachment_time(states, len(states), STEP, 1, OUTLINES)


def test_pet_is_from_leaving_to_entering_with_the_sign_of_who_was_first() -> None:
    """The ego's rear leaves the square at (20 + 3) / 10 = 2.3 s, the other's front comes at (32 - 3) / 10 = 2.9 s."""
    ego, other = drive(-20, 0, 0, 10), drive(0, -32, math.pi / 2, 10)
    assert pet(ego, other) == pytest.approx(0.6, abs=1e-4)
    assert pet(other, ego) == pytest.approx(-0.6, abs=1e-4)


def test_pet_of_contact_is_zero_and_without_a_shared_place_infinite() -> None:
    """Who touches has no time in between; who never covers the other's places has all of it."""
    assert pet(drive(-20, 0, 0, 10), drive(0, -20, math.pi / 2, 10)) == 0.0
    assert pet(drive(-20, 0, 0, 10), drive(-20, 5, 0, 10)) == math.inf
    assert pet(drive(0, 0, 0, 0), drive(-20, 5, 0, 10)) == math.inf


def test_pet_of_a_follower_is_its_time_gap() -> None:
    """Behind at the same speed, the place left by the one's rear is reached by the other's front gap / v later."""
    assert pet(drive(0, 0, 0, 10), drive(-16, 0, 0, 10)) == pytest.approx(1.2, abs=1e-4)


@given(st.floats(5.0, 40.0), st.floats(5.0, 40.0), st.floats(3.0, 15.0), st.floats(3.0, 15.0), st.floats(-3, 3))
def test_pet_swaps_its_sign_with_the_roles_and_keeps_it_when_mirrored(
    a: float, b: float, v: float, w: float, turn: float
) -> None:
    """Exchanging the two changes the sign alone; a mirror changes nothing."""
    ego, other = drive(-a, 0, 0, v), drive(-b * math.cos(turn), -b * math.sin(turn), turn, w)
    expected = pet(ego, other)
    if math.isfinite(expected) and expected != 0.0:
        assert pet(other, ego) == pytest.approx(-expected, abs=1e-3)
    mirror = np.where(np.isin(np.arange(len(State)), [State.Y, State.HEADING]), -1.0, 1.0)
    if math.isfinite(expected):
        assert pet(ego * mirror, other * mirror) == pytest.approx(expected, abs=1e-3)
