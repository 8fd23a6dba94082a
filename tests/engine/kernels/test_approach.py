"""First contact of any two in a recording."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.approach import first_contact, search_contact
from engine.kernels.geometry import Box
from engine.vocabulary import State


def standing(places: list[tuple[float, float]], samples: int = 3) -> np.ndarray:
    """Actors that stay where they are."""
    states = np.zeros((samples, len(places), len(State)))
    states[:, :, [State.X, State.Y]] = places
    states[:, :, State.PRESENT] = 1.0
    return states


def outlines(actors: int) -> np.ndarray:
    return np.tile([4.0, 2.0, 0.0], (actors, 1))


def test_nobody_touches() -> None:
    """Sample -1 says so, and no actors."""
    touch = search_contact(standing([(0.0, 0.0), (10.0, 0.0)]), outlines(2))
    assert (touch.sample, touch.one, touch.other) == (-1, -1, -1)


def test_the_lower_pair_wins_a_tie() -> None:
    """All four overlap from the start."""
    touch = search_contact(standing([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)]), outlines(4))
    assert (touch.sample, touch.part, touch.one, touch.other) == (0, 0.0, 0, 1)


@pytest.mark.parametrize("absent", [0, 1])
def test_the_absent_touch_nobody(absent: int) -> None:
    """Whoever of the two it is."""
    states = standing([(0.0, 0.0), (1.0, 0.0)])
    states[:, absent, State.PRESENT] = 0.0
    assert search_contact(states, outlines(2)).sample == -1


def test_two_that_are_there_at_one_sample_alone_touch_then() -> None:
    """No step shows it."""
    states = standing([(0.0, 0.0), (1.0, 0.0)])
    states[[0, 2], 1, State.PRESENT] = 0.0
    touch = search_contact(states, outlines(2))
    assert (touch.sample, touch.part) == (1, 0.0)


@given(st.floats(5.0, 30.0), st.floats(-1.5, 1.5), st.floats(-0.5, 0.5), st.integers(0, 4))
def test_it_is_the_contact_of_the_step_in_which_it_happens(gap: float, aside: float, turn: float, before: int) -> None:
    """As the kernel of one step has it."""
    samples = 7
    states = standing([(0.0, 0.0), (gap, aside)], samples)
    states[before + 1 :, 1, State.X] = 0.0
    states[before + 1 :, 1, State.HEADING] = turn
    one = Box(0.0, 0.0, 0.0, 4.0, 2.0)
    part = first_contact(one, one, Box(gap, aside, 0.0, 4.0, 2.0), Box(0.0, aside, turn, 4.0, 2.0))
    touch = search_contact(states, outlines(2))
    assert (touch.sample, touch.part) == (before, part)
