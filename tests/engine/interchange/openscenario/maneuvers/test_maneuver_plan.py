"""Triggers: alternatives of conditions that hold together, and what can be made of them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import (
    ALWAYS,
    EARLY,
    HARDEST,
    NEVER,
    PLANNED,
    Bend,
    Change,
    Condition,
    Measure,
    Trigger,
    Way,
    all_of,
    any_of,
    none_of,
    phases_of,
)
from engine.kernels import steering

ACTORS = ("a", "b", "c")
conditions = st.builds(
    Condition,
    measure=st.just(Measure.SPEED),
    limit=st.sampled_from([formula.number(1.0), formula.number(2.0)]),
    below=st.booleans(),
    actor=st.sampled_from(ACTORS),
)
triggers = st.lists(st.lists(conditions, max_size=3).map(tuple), max_size=3).map(tuple)
speeds = st.fixed_dictionaries(dict.fromkeys(ACTORS, st.sampled_from([0.5, 1.5, 2.5])))


def holds(trigger: Trigger, at: dict[str, float]) -> bool:
    return any(all((at[each.actor] < each.limit.number) == each.below for each in group) for group in trigger)


@given(triggers, speeds)
def test_none_of_is_the_opposite(trigger: Trigger, at: dict[str, float]) -> None:
    assert holds(none_of(trigger), at) is not holds(trigger, at)


@given(st.lists(triggers, max_size=3), speeds)
def test_any_and_all_are_what_they_say(several: list[Trigger], at: dict[str, float]) -> None:
    each = [holds(trigger, at) for trigger in several]
    assert holds(any_of(several), at) is any(each)
    assert holds(all_of(several), at) is all(each)


def test_ends_of_the_scale() -> None:
    assert none_of(NEVER) == ALWAYS
    assert none_of(ALWAYS) == NEVER


# -- Speeds for bends: v^2 - v_bend^2 = 2 a way ------------------------------------------------------------------------

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
    """Return where the speed of the bend is reached and what it is, by a driver who follows the plan exactly."""
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
