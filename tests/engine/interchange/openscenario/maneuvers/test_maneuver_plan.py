"""Triggers: alternatives of conditions that hold together, and what can be made of them."""

from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import (
    ALWAYS,
    NEVER,
    Condition,
    Measure,
    Trigger,
    all_of,
    any_of,
    none_of,
)

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
