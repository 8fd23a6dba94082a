"""Safe distances of RSS by hand, and WTTC against the roots of its quartic."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.conflict import Snapshot
from engine.kernels.geometry import Box
from engine.kernels.pair import Rate
from engine.kernels.safe_distance import (
    Responsibility,
    is_dangerous,
    safe_gap_behind,
    safe_gap_beside,
    safe_gap_oncoming,
    worst_time_to_collision,
)
from tests.laws import examples

compiled = examples(100)
RULES = Responsibility(1.0, 3.5, 8.0, 4.0, 3.0, 0.2, 0.8, 0.1)
LENGTH, WIDTH = 4.0, 2.0


def car(x: float, y: float, heading: float, speed: float) -> tuple[Box, Rate]:
    return Box(x, y, heading, LENGTH, WIDTH), Rate(speed * math.cos(heading), speed * math.sin(heading))


def pair(ego: tuple[Box, Rate], other: tuple[Box, Rate]) -> Snapshot:
    return Snapshot(ego[0], other[0], ego[1], other[1])


def test_the_safe_gaps_are_those_of_the_definitions() -> None:
    """Worked out by hand at 20 and 15 m/s, and at 10 m/s each against the other."""
    assert safe_gap_behind(20.0, 15.0, RULES) == pytest.approx(20 + 1.75 + 23.5**2 / 8 - 15**2 / 16)
    assert safe_gap_behind(0.0, 30.0, RULES) == 0.0
    oncoming = 2 * (10 + 1.75) + 13.5**2 / 6 + 13.5**2 / 8
    assert safe_gap_oncoming(10.0, 10.0, RULES) == pytest.approx(oncoming)
    assert safe_gap_beside(0.0, 0.0, RULES) == pytest.approx(0.1 + 2 * (0.1 + 0.2**2 / 1.6))
    assert safe_gap_beside(-5.0, 0.0, RULES) == pytest.approx(0.1)


@compiled
@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0))
def test_a_follower_at_the_safe_gap_stops_in_time_in_the_worst_case(behind: float, leading: float) -> None:
    """The leader brakes as hard as it can, the follower speeds up, then brakes as it must: they just do not touch."""
    gap = safe_gap_behind(behind, leading, RULES)
    time = np.linspace(0.0, 20.0, 4001)
    stops = leading / RULES.hardest_braking
    lead = gap + leading * np.minimum(time, stops) - 0.5 * RULES.hardest_braking * np.minimum(time, stops) ** 2
    top = behind + RULES.speeding_up * RULES.response
    held, braked = np.minimum(time, RULES.response), np.clip(time - RULES.response, 0.0, top / RULES.braking)
    follow = behind * held + 0.5 * RULES.speeding_up * held**2 + top * braked - 0.5 * RULES.braking * braked**2
    left = float((lead - follow)[-1])
    assert left >= -1e-9
    if gap > 0.0:
        assert left == pytest.approx(0.0, abs=1e-6)


def test_danger_is_where_both_gaps_are_too_small() -> None:
    """10 m behind at 20 m/s it is; beside it, far behind, after passing, or across, it is not."""
    ego = car(0, 0, 0, 20)
    assert is_dangerous(pair(ego, car(14, 0, 0, 15)), RULES)
    assert is_dangerous(pair(ego, car(-14, 0, 0, 30)), RULES)
    assert is_dangerous(pair(ego, car(60, 0, math.pi, 15)), RULES)
    for other in (car(14, 3.5, 0, 15), car(100, 0, 0, 15), car(-14, 0, math.pi, 15), car(14, 0, math.pi / 2, 15)):
        assert not is_dangerous(pair(ego, other), RULES)


@compiled
@given(st.floats(-40, 40), st.floats(-8, 8), st.floats(-0.7, 0.7), st.floats(0, 30), st.floats(0, 30), st.booleans())
def test_danger_does_not_know_left_from_right_nor_where_east_is(
    x: float, y: float, heading: float, mine: float, theirs: float, oncoming: bool
) -> None:
    """Mirrored, or turned by a right angle, it is the same."""
    towards = heading + (math.pi if oncoming else 0.0)
    now = pair(car(0, 0, 0, mine), car(x, y, towards, theirs))
    mirrored = pair(car(0, 0, 0, mine), car(x, -y, -towards, theirs))
    turned = pair(car(0, 0, math.pi / 2, mine), car(-y, x, towards + math.pi / 2, theirs))
    assert is_dangerous(now, RULES) == is_dangerous(mirrored, RULES) == is_dangerous(turned, RULES)


@compiled
@given(st.floats(5, 60), st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 30), st.floats(0, 30), st.floats(0.5, 20))
def test_wttc_is_the_first_root_of_its_quartic(
    away: float, bearing: float, heading: float, mine: float, theirs: float, agility: float
) -> None:
    """|p + v t|^2 = (r1 + r2 + a t^2 / 2)^2, solved by the eigenvalues of its companion matrix."""
    now = pair(car(0, 0, 0, mine), car(away * math.cos(bearing), away * math.sin(bearing), heading, theirs))
    x, y = now.other.x, now.other.y
    vx, vy = now.other_rate.x - mine, now.other_rate.y
    reach = math.hypot(LENGTH, WIDTH)
    quartic = [
        -(agility**2) / 4,
        0.0,
        vx**2 + vy**2 - agility * reach,
        2 * (x * vx + y * vy),
        x**2 + y**2 - reach**2,
    ]
    roots = np.roots(quartic)
    real = sorted(root.real for root in roots if abs(root.imag) < 1e-6 and root.real > 0.0)
    found = worst_time_to_collision(now, agility)
    assert abs(math.hypot(x + vx * found, y + vy * found) - reach - 0.5 * agility * found**2) < 1e-6
    if away > reach + 0.1:
        assert any(found == pytest.approx(root, rel=1e-3, abs=1e-3) for root in real)
        assert found <= real[0] + 1e-3


def test_wttc_without_accelerations_is_when_circles_meet_or_never() -> None:
    """Head on after (40 - 2 r) / 20 s; driving apart never."""
    reach = math.hypot(LENGTH, WIDTH)
    assert worst_time_to_collision(pair(car(0, 0, 0, 10), car(40, 0, math.pi, 10)), 0.0) == pytest.approx(
        (40 - reach) / 20
    )
    assert worst_time_to_collision(pair(car(0, 0, math.pi, 10), car(40, 0, 0, 10)), 0.0) == math.inf
