"""What a recording says of itself: who is there, whether it is whole, and the same from another begin."""

from dataclasses import replace

import numpy as np
import pytest

from engine.interchange import Contact, InterchangeError, SignalTimes
from engine.interchange.recording import PHASES
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.commonroad.recordings import LIGHTS, absent, crash, recording


def test_who_is_there() -> None:
    """Sample by sample; and who never is."""
    made = absent(absent(recording(ActorKind.CAR, ActorKind.BUS), 1, 0, 1, 2, 3), 2, 1)
    assert made.there.T.tolist() == [[True] * 4, [False] * 4, [True, False, True, True]]
    assert made.never_there == (1,)
    assert recording(ActorKind.CAR).never_there == ()


def test_those_who_take_part() -> None:
    """Their numbers close up, those of contact among them; a recording of all is itself."""
    made = replace(absent(recording(ActorKind.CAR, ActorKind.BUS), 1, 0, 1, 2, 3), contact=Contact(0.2, (0, 2)))
    left = made.taking_part()
    assert [actor.name for actor in left.actors] == ["ego", "bus_2"]
    assert left.contact == Contact(0.2, (0, 1))
    assert np.array_equal(left.states, made.states[:, [0, 2]])
    assert left.taking_part() is left


def test_an_ego_that_never_comes_in() -> None:
    """Nobody else is taken for it."""
    with pytest.raises(InterchangeError, match="the ego never comes in"):
        absent(recording(ActorKind.CAR), 0, 0, 1, 2, 3).taking_part()


def test_times_from_zero() -> None:
    """Contact keeps its place among the samples, the lights show at each what they showed."""
    whole = replace(crash(), signals=LIGHTS)
    contact = whole.contact
    assert contact is not None
    later = replace(whole, time=whole.time + 2.5, contact=replace(contact, time=contact.time + 2.5)).from_zero()
    assert later.time == pytest.approx(whole.time)
    assert later.contact is not None
    assert later.contact.time == pytest.approx(contact.time)
    assert later.signals == replace(LIGHTS, offset=LIGHTS.offset + 2.5)
    assert whole.from_zero() is whole


def test_broken_ones_are_refused() -> None:
    """No actor, times that go back, a state that is no number; values that are never read may be anything."""
    whole = recording(ActorKind.CAR)
    nobody = absent(absent(whole, 0, 0, 1, 2, 3), 1, 0, 1, 2, 3)
    back = replace(whole, time=whole.time[::-1])
    broken = replace(whole, states=whole.states.copy())
    broken.states[2, 1, State.BRAKE] = np.nan
    for made, words in (
        (nobody, "holds no actor"),
        (back, "do not ascend"),
        (broken, "`car_1` has no finite state at 0.2 s"),
    ):
        with pytest.raises(InterchangeError, match=words):
            made.refuse_broken()
    absent(broken, 1, 2).refuse_broken()


def test_the_plan_of_the_lights() -> None:
    """Those that face each other share a turn; a plan is two turns long, and may have begun before the run."""
    plan = SignalTimes(green=10.0, yellow=3.0, all_red=2.0, offset=4.0)
    assert (plan.slot, plan.cycle) == (15.0, 30.0)
    assert [plan.begins(phase) for phase in range(PHASES)] == [-4.0, 11.0]
