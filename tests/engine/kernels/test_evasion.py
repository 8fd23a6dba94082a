"""How late and how hard the ego must brake, swerve or speed up: closed forms behind a leader, brute force elsewhere."""

import math

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from engine.kernels.conflict import Snapshot, time_to_collision
from engine.kernels.evasion import (
    Maneuver,
    braking_needed,
    evades,
    swerving_needed,
    time_to_brake,
    time_to_kick_down,
    time_to_steer,
)
from engine.kernels.geometry import Box, box_distance
from engine.kernels.pair import Rate
from tests.laws import examples

compiled = settings(examples(60), suppress_health_check=[HealthCheck.filter_too_much])
BRAKES, GRIP = 8.0, 9.81
LENGTH, WIDTH = 4.0, 2.0


def car(x: float, y: float, heading: float, speed: float) -> tuple[Box, Rate]:
    return Box(x, y, heading, LENGTH, WIDTH), Rate(speed * math.cos(heading), speed * math.sin(heading))


def pair(ego: tuple[Box, Rate], other: tuple[Box, Rate]) -> Snapshot:
    return Snapshot(ego[0], other[0], ego[1], other[1])


@st.composite
def on_course(draw: st.DrawFn) -> Snapshot:
    """The ego drives east; somebody comes from anywhere, and the two would touch."""
    angle, away = draw(st.floats(-3.1, 3.1)), draw(st.floats(8.0, 40.0))
    place = away * math.cos(angle), away * math.sin(angle)
    speed, heading = draw(st.floats(0.0, 20.0)), draw(st.floats(-3.1, 3.1))
    now = pair(car(0.0, 0.0, 0.0, draw(st.floats(2.0, 20.0))), car(*place, heading, speed))
    assume(0.0 < time_to_collision(now) < 10.0)
    return now


def least_distance(now: Snapshot, maneuver: Maneuver, until: float, steps: int = 1500) -> float:
    """Of the outlines, by small steps in time."""
    speed = math.hypot(*now.ego_rate)
    ux, uy = now.ego_rate.x / speed, now.ego_rate.y / speed
    nearest = math.inf
    for k in range(steps + 1):
        time = until * k / steps
        acting = min(max(time - maneuver.begin, 0.0), maneuver.end - maneuver.begin)
        after = max(time - maneuver.end, 0.0)
        along = speed * time + maneuver.along * acting * (0.5 * acting + after)
        aside = maneuver.aside * acting * (0.5 * acting + after)
        ego = now.ego._replace(x=now.ego.x + ux * along - uy * aside, y=now.ego.y + uy * along + ux * aside)
        x, y = now.other.x + now.other_rate.x * time, now.other.y + now.other_rate.y * time
        nearest = min(nearest, box_distance(ego, now.other._replace(x=x, y=y)))
    return nearest


@compiled
@given(on_course(), st.floats(0.0, 2.0), st.floats(-12.0, 12.0), st.booleans())
def test_what_evades_keeps_the_outlines_apart_at_every_instant(
    now: Snapshot, begin: float, acceleration: float, sideways: bool
) -> None:
    """By small steps they never touch; where it does not evade they do, but for a touch shorter than a step."""
    lasts = math.hypot(*now.ego_rate) / -acceleration if acceleration < 0.0 and not sideways else 8.0
    maneuver = Maneuver(begin, begin + lasts, 0.0 if sideways else acceleration, acceleration if sideways else 0.0)
    nearest = least_distance(now, maneuver, min(begin + lasts, 10.0) + 4.0)
    if evades(now, maneuver):
        assert nearest > 0.0
    elif time_to_collision(now) < begin:
        assert nearest < 0.1


@compiled
@given(st.floats(1.0, 60.0), st.floats(0.0, 20.0), st.floats(0.5, 15.0))
def test_behind_a_slower_car_the_closed_forms_hold(gap: float, leader: float, faster: float) -> None:
    """TTB = TTC - dv / 2a, TTS = TTC - sqrt(2 d / a), a_req = dv^2 / (2 gap), a_lat = 2 d / TTC^2."""
    now = pair(car(0, 0, 0, leader + faster), car(gap + LENGTH, 0.5, 0, leader))
    ttc, aside = gap / faster, WIDTH - 0.5
    assert braking_needed(now) == pytest.approx(faster**2 / (2 * gap), rel=1e-6)
    assert swerving_needed(now) == pytest.approx(2 * aside / ttc**2, rel=1e-6)
    to_brake, to_steer = ttc - faster / (2 * BRAKES), ttc - math.sqrt(2 * aside / GRIP)
    assert time_to_brake(now, BRAKES) == pytest.approx(to_brake if to_brake >= 0.0 else -math.inf, abs=1e-6)
    assert time_to_steer(now, GRIP) == pytest.approx(to_steer if to_steer >= 0.0 else -math.inf, abs=1e-6)
    assert time_to_kick_down(now, 3.0, math.inf) == -math.inf


def test_who_speeds_up_may_pass_before_a_crossing_car() -> None:
    """Its rear clears the strip of the other, 3 m past the middle, at the instant the other's front comes."""
    now = pair(car(-8, 0, 0, 10), car(0, -12, math.pi / 2, 10))
    assert time_to_collision(now) == pytest.approx(0.9)  # the other's front is at the ego's strip, its rear still in it
    latest = time_to_kick_down(now, 6.0, math.inf)
    # 11 m by then: 10 t + 3 (t - begin)^2 = 11 at t = 0.9
    assert latest == pytest.approx(0.9 - math.sqrt((11.0 - 9.0) / 3.0), abs=1e-6)
    assert time_to_kick_down(now, 6.0, 10.0) == -math.inf


@compiled
@given(on_course())
def test_the_latest_instant_helps_and_a_little_later_does_not(now: Snapshot) -> None:
    """As brute force sees it; and who needs no more than its brakes give can wait."""
    latest = time_to_brake(now, BRAKES)
    lasts = math.hypot(*now.ego_rate) / BRAKES
    if latest >= 0.0:
        assert evades(now, Maneuver(latest, latest + lasts, -BRAKES, 0.0))
        assert not evades(now, Maneuver(latest + 1e-4, latest + 1e-4 + lasts, -BRAKES, 0.0))
    needed = braking_needed(now)
    if math.isfinite(needed):
        assert evades(now, Maneuver(0.0, math.hypot(*now.ego_rate) / needed, -needed, 0.0))
    if needed <= BRAKES and evades(now, Maneuver(0.0, lasts, -BRAKES, 0.0)):
        assert latest >= 0.0


@compiled
@given(on_course(), st.floats(-3.0, 3.0))
def test_nothing_depends_on_the_axes(now: Snapshot, turn: float) -> None:
    """Turned as a whole, or mirrored, an instant needs the same, but where it grazes."""

    def moved(box: Box, rate: Rate, mirror: float) -> tuple[Box, Rate]:
        def turned(x: float, y: float) -> tuple[float, float]:
            y *= mirror
            return x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)

        return Box(*turned(box.x, box.y), mirror * box.heading + turn, box.length, box.width), Rate(*turned(*rate))

    for mirror in (1.0, -1.0):
        same = pair(moved(now.ego, now.ego_rate, mirror), moved(now.other, now.other_rate, mirror))
        needed, again = swerving_needed(now), swerving_needed(same)
        if math.isfinite(needed) and math.isfinite(again):
            assert again == pytest.approx(needed, rel=1e-4, abs=1e-6)


def test_nobody_needs_anything_without_contact_ahead_and_nothing_helps_one_who_stands() -> None:
    """Infinitely much time and no acceleration; or none, and infinitely much."""
    apart = pair(car(0, 0, 0, 10), car(20, 6, 0, 5))
    assert (braking_needed(apart), swerving_needed(apart)) == (0.0, 0.0)
    assert time_to_brake(apart, BRAKES) == time_to_steer(apart, GRIP) == math.inf
    struck = pair(car(0, 0, 0, 0), car(20, 0, math.pi, 10))
    assert (braking_needed(struck), swerving_needed(struck)) == (math.inf, math.inf)
    assert time_to_brake(struck, BRAKES) == time_to_steer(struck, GRIP) == -math.inf
    assert time_to_kick_down(struck, 0.0, math.inf) == -math.inf
