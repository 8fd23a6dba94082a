"""What is decided in scenes side by side is kept for how long their runs are, and comes back as it was."""

import numpy as np
import pytest

from engine.control import Action, Control
from engine.driving import orders as orders_module
from engine.driving.orders import Orders
from engine.kernels.slots import PAGE
from engine.tables import Floats

STEP = 0.05
LANES = 7


def control(every: float, delay: float, numbers: int) -> Control:
    actions = tuple(Action(f"number {n}", "", -1.0, 1.0) for n in range(numbers))
    return Control("driver", 0, actions, every, delay)


def as_it_was(said: list[tuple[int, int, Floats]], neutral: Floats, controls: list[Control], turns: int) -> Floats:
    """(turns, numbers) of one lane, from all (number of the control, sample, what it decided)."""
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
def test_orders_come_back_as_they_were(controls: list[Control], monkeypatch: pytest.MonkeyPatch) -> None:
    """Lanes begin and end at any time; each has what was decided in its run, and nothing of the runs before, also when
    runs get longer than there was room for.
    """
    monkeypatch.setattr(orders_module, "ROOM", 2 * PAGE)
    rng = np.random.default_rng(4)
    pause = int(np.gcd.reduce([round(each.every / STEP) for each in controls]))
    orders = Orders(controls, LANES, STEP, pause, 30 * PAGE)
    coming = np.zeros((LANES, orders.coming, sum(len(each.actions) for each in controls)))
    samples, neutral = np.zeros(LANES, dtype=np.int64), np.zeros((LANES, coming.shape[2]))
    said: list[list[tuple[int, int, Floats]]] = [[] for _ in range(LANES)]
    for step in range(30 * PAGE):
        begun = np.flatnonzero(rng.random(LANES) < (1.0 if step == 0 else 0.01))
        neutral[begun], samples[begun] = rng.random((len(begun), coming.shape[2])), 0
        orders.begin(begun, neutral[begun], coming)
        for lane in begun:
            said[lane] = []
        for number, each in enumerate(controls):
            asked = samples % round(each.every / STEP) == 0
            actions = rng.random((LANES, len(each.actions)))
            orders.decide(number, asked, samples, actions, coming)
            for lane in np.flatnonzero(asked):
                said[lane].append((number, int(samples[lane]), actions[lane]))
        samples += 1
        if step % 37 == 0:
            out = np.full((LANES, int(samples.max()) + 5, coming.shape[2]), np.nan)
            orders.decided(np.arange(LANES), samples, out)
            for lane in range(LANES):
                assert np.array_equal(out[lane], as_it_was(said[lane], neutral[lane], controls, out.shape[1]))


def test_lanes_take_memory_for_how_long_their_runs_are() -> None:
    """Runs that end at once need no more than they did, however many there are."""
    controls = [control(0.05, 0.0, 3)]
    orders = Orders(controls, LANES, STEP, 1, 300)
    coming, every = np.zeros((LANES, 1, 3)), np.arange(LANES)
    before, taken = orders.nbytes, list[int]()
    for _ in range(20):
        orders.begin(every, np.zeros((LANES, 3)), coming)
        for sample in range(PAGE):
            orders.decide(0, every >= 0, np.full(LANES, sample), np.ones((LANES, 3)), coming)
        taken.append(orders.nbytes - before)
    assert taken == [LANES * PAGE * 3 * 8] * 20
