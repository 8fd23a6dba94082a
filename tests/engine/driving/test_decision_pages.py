"""Decisions in parallel runs are stored for the length of the runs, and are read as they were stored."""

import numpy as np
import pytest

from engine.control import Action, Control
from engine.driving import stepping as pages_module
from engine.driving.stepping import DecisionPages
from engine.kernels.slots import PAGE
from engine.tables import Floats

STEP = 0.05
SLOTS = 7


def control(every: float, delay: float, numbers: int) -> Control:
    actions = tuple(Action(f"number {n}", "", -1.0, 1.0) for n in range(numbers))
    return Control("driver", 0, actions, every, delay)


def as_it_was(said: list[tuple[int, int, Floats]], neutral: Floats, controls: list[Control], turns: int) -> Floats:
    """(turns, numbers) of one slot, from all (number of the control, sample, what it decided)."""
    out = np.tile(neutral, (turns, 1))
    first = np.cumsum([0, *(len(each.actions) for each in controls)])
    for number, sample, given in said:
        out[sample + round(controls[number].delay / STEP) :, first[number] : first[number + 1]] = given
    return out


@pytest.mark.parametrize(
    "controls",
    [[control(0.05, 0.0, 3)], [control(0.1, 0.1, 2)], [control(0.1, 0.05, 1), control(0.15, 0.0, 2)]],
    ids=["each step", "late", "two"],
)
def test_decisions_come_back_as_they_were(controls: list[Control], monkeypatch: pytest.MonkeyPatch) -> None:
    """Slots begin and end at any time; each has what was decided in its run, and nothing of the runs before, also when
    runs get longer than there was room for.
    """
    monkeypatch.setattr(pages_module, "ROOM", 2 * PAGE)
    rng = np.random.default_rng(4)
    pause = int(np.gcd.reduce([round(each.every / STEP) for each in controls]))
    pages = DecisionPages(controls, SLOTS, STEP, pause, 30 * PAGE)
    coming = np.zeros((SLOTS, pages.coming, sum(len(each.actions) for each in controls)))
    samples, neutral = np.zeros(SLOTS, dtype=np.int64), np.zeros((SLOTS, coming.shape[2]))
    said: list[list[tuple[int, int, Floats]]] = [[] for _ in range(SLOTS)]
    for step in range(30 * PAGE):
        begun = np.flatnonzero(rng.random(SLOTS) < (1.0 if step == 0 else 0.01))
        neutral[begun], samples[begun] = rng.random((len(begun), coming.shape[2])), 0
        pages.begin(begun, neutral[begun], coming)
        for slot in begun:
            said[slot] = []
        for number, each in enumerate(controls):
            asked = samples % round(each.every / STEP) == 0
            actions = rng.random((SLOTS, len(each.actions)))
            pages.decide(number, asked, samples, actions, coming)
            for slot in np.flatnonzero(asked):
                said[slot].append((number, int(samples[slot]), actions[slot]))
        samples += 1
        if step % 37 == 0:
            out = np.full((SLOTS, int(samples.max()) + 5, coming.shape[2]), np.nan)
            pages.decided(np.arange(SLOTS), samples, out)
            for slot in range(SLOTS):
                assert np.array_equal(out[slot], as_it_was(said[slot], neutral[slot], controls, out.shape[1]))


def test_lanes_take_memory_for_how_long_their_runs_are() -> None:
    """Runs that end at once need no more than they did, however many there are."""
    controls = [control(0.05, 0.0, 3)]
    pages = DecisionPages(controls, SLOTS, STEP, 1, 300)
    coming, every = np.zeros((SLOTS, 1, 3)), np.arange(SLOTS)
    before, taken = pages.nbytes, list[int]()
    for _ in range(20):
        pages.begin(every, np.zeros((SLOTS, 3)), coming)
        for sample in range(PAGE):
            pages.decide(0, every >= 0, np.full(SLOTS, sample), np.ones((SLOTS, 3)), coming)
        taken.append(pages.nbytes - before)
    assert taken == [SLOTS * PAGE * 3 * 8] * 20
