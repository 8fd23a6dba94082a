"""Speeds for bends: v^2 - v_bend^2 = 2 a way."""

import math

import pytest

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.plan import EARLY, HARDEST, PLANNED, Bend, Change, Way, phases_of
from engine.kernels import steering

SPEED = formula.parameter("SPEED")
FREE = Change(SPEED, formula.number(3.0))
BEND = Bend(50.0, 60.0, 1.0 / 12.0)
ALLOWED = 6.0
"""sqrt(3 * 12)"""


def phases(*bends: Bend, along: float = 10.0, lateral: float = 3.0) -> tuple:
    return phases_of(Way(bends, formula.number(along), 50.0, lateral), SPEED, FREE)


def test_drivers_here_look_ahead_as_those_of_the_simulator() -> None:
    assert pytest.approx(steering.SPEED_PREVIEW - 1.0 / steering.SPEED_GAIN) == EARLY


def braked(found: tuple, speed: float) -> tuple[float, float]:
    """Where the speed of the bend is reached and what it is, by a driver who does as told and no more."""
    at = {"SPEED": speed}
    hard, slows = found[1], found[2]
    way = 0.0
    if speed >= hard.faster_than.value(at):
        lower = hard.change.speed.value(at)
        way, speed = (speed**2 - lower**2) / (2.0 * hard.change.rate.value(at)), lower
    way = max(way, slows.begins.value(at))
    target = slows.change.speed.value(at)
    return way + (speed**2 - target**2) / (2.0 * slows.change.rate.value(at)), target


@pytest.mark.parametrize("along", [10.0, 30.0, 35.0])
@pytest.mark.parametrize("speed", [6.5, 10.0, 13.0])
def test_the_speed_of_the_bend_is_reached_just_before_it(speed: float, along: float) -> None:
    """With room by a steady deceleration, with less room by a hard one first, and nothing to spare."""
    way, target = braked(phases(BEND, along=along), speed)
    assert target == pytest.approx(ALLOWED)
    assert way == pytest.approx(50.0 - along - EARLY * ALLOWED)


def test_who_has_room_never_brakes_hard() -> None:
    _, hard, slows, goes_on = phases(BEND)
    at = {"SPEED": 12.0}
    assert hard.faster_than.value(at) > 12.0
    assert (slows.change.rate.number, goes_on.begins.number) == (PLANNED, 60.0 - 10.0)


def test_who_cannot_make_it_brakes_hard_into_the_bend() -> None:
    _, hard, slows, _ = phases(BEND, along=45.0)
    at = {"SPEED": 30.0}
    assert hard.faster_than.value(at) < 30.0
    assert hard.change.rate.number == HARDEST
    assert hard.change.speed.value(at) == pytest.approx(ALLOWED)
    assert slows.begins.value(at) >= (30.0**2 - ALLOWED**2) / (2.0 * HARDEST)


def test_weak_brakes_are_planned_with_as_they_are() -> None:
    names = [each.name for each in phases_of(Way((BEND,), lateral=3.0, braking=3.0), SPEED, FREE)]
    assert names == ["drives", "slows_1", "goes_on_1"]


def test_who_is_slow_keeps_its_speed() -> None:
    _, _, slows, _ = phases(BEND)
    assert slows.change.speed.value({"SPEED": 4.0}) == pytest.approx(4.0)


def test_neighbouring_bends_are_one() -> None:
    found = {each.name: each for each in phases(BEND, Bend(60.05, 70.0, 0.5), Bend(90.0, 95.0, 0.1))}
    assert list(found) == ["drives", "brakes_hard", "slows_1", "goes_on_1", "slows_2", "goes_on_2"]
    assert found["slows_1"].change.speed.value({"SPEED": 20.0}) == pytest.approx(math.sqrt(6.0))
    assert found["goes_on_1"].begins.number == 60.0


def test_who_does_not_plan_for_bends_drives_through_them() -> None:
    assert [phase.name for phase in phases(BEND, lateral=math.inf)] == ["drives"]
