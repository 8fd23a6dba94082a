"""Queries and decisions of parallel runs, slot by slot; `engine.driving.stepping` owns the memory."""

from typing import NamedTuple

from engine.kernels.jit import kernel
from engine.kernels.run_state import RUNNING, Status
from engine.kernels.slots import PAGE
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

TOO_NARROW = -1
"""Result of `take_pages` if a slot has more pages than `pages` has columns."""


class ControlTiming(NamedTuple):
    """Columns of a control among all decided numbers, and its timing in turns."""

    first: int
    """First column."""
    last: int
    """End of the columns (exclusive)."""
    delay: int
    """Turns from a decision until it holds."""
    every: int
    """Number of turns from a query to the next."""
    pause: int
    """Number of turns from a pause of the runs to the next; it divides `every`."""


@kernel
def mark_queried(status: Ints, verdict: Ints, every: int, out: Bools) -> None:
    """Mark the slots (slots,) that pause at a sample at which a control with a period of `every` turns is queried."""
    for slot in range(len(out)):
        goes = verdict[slot] == Verdict.VALID and status[slot, Status.END] == RUNNING
        out[slot] = goes and status[slot, Status.PAUSED] == 1 and status[slot, Status.SAMPLE] % every == 0


@kernel
def mark_running(status: Ints, verdict: Ints, out: Bools) -> None:
    """Write True into `out` (slots,) for slots whose run continues."""
    for slot in range(len(out)):
        out[slot] = verdict[slot] == Verdict.VALID and status[slot, Status.END] == RUNNING


@kernel
def are_within(actions: Floats, asked: Bools, low: Floats, high: Floats) -> bool:
    """Return True if all actions (slots, a) of the queried slots are numbers from `low` to `high` (a,)."""
    for slot in range(len(asked)):
        if asked[slot]:
            for number in range(actions.shape[1]):
                if not (low[number] <= actions[slot, number] <= high[number]):
                    return False
    return True


@kernel
def take_pages(chosen: Bools, samples: Ints, pause: int, pages: Ints, free: Ints, left: Ints) -> int:
    """Give each chosen slot without a page for its current row the last of the first `left` (1,) pages in `free`.

    Return the number of missing pages, or `TOO_NARROW`.
    """
    missing = 0
    for slot in range(len(chosen)):
        if not chosen[slot]:
            continue
        which = samples[slot] // pause // PAGE
        if which >= pages.shape[1]:
            return TOO_NARROW
        if pages[slot, which] < 0 and left[0] > 0:
            left[0] -= 1
            pages[slot, which] = free[left[0]]
        elif pages[slot, which] < 0:
            missing += 1
    return missing


@kernel
def store_decisions(
    chosen: Bools, samples: Ints, actions: Floats, timing: ControlTiming, pages: Ints, stored: Floats, coming: Floats
) -> None:
    """Write the actions (slots, a) of a control into its columns of `stored` and `coming`.

    `stored` (pages, PAGE, numbers) holds all decisions of a run; `coming` (slots, turns, numbers) is a ring of the
    turns for which they hold, whose length is a power of two.
    """
    for slot in range(len(chosen)):
        if not chosen[slot]:
            continue
        row, first = samples[slot] // timing.pause, samples[slot] + timing.delay
        page = pages[slot, row // PAGE]
        for number in range(actions.shape[1]):
            stored[page, row % PAGE, timing.first + number] = actions[slot, number]
        for later in range(timing.every):
            turn = (first + later) & (coming.shape[1] - 1)
            for number in range(actions.shape[1]):
                coming[slot, turn, timing.first + number] = actions[slot, number]


@kernel
def read_decisions(
    chosen: Ints, samples: Ints, timing: ControlTiming, pages: Ints, stored: Floats, neutral: Floats, out: Floats
) -> None:
    """Write the decisions for every turn of the chosen slots, which are at `samples` (chosen,), into `out`.

    `out` (chosen, turns, numbers) gets `neutral` (slots, numbers) until the first decision holds. The last decision
    holds until the end.
    """
    apart, delay, every = timing.every // timing.pause, timing.delay, timing.every
    for row in range(len(chosen)):
        slot, count = chosen[row], (samples[row] + every - 1) // every
        turn = out.shape[1] if count == 0 else min(delay, out.shape[1])
        for before in range(turn):
            for column in range(timing.first, timing.last):
                out[row, before, column] = neutral[slot, column]
        number = 0
        while turn < out.shape[1]:
            at, until = number * apart, out.shape[1] if number + 1 == count else min(turn + every, out.shape[1])
            page, place = pages[slot, at // PAGE], at % PAGE
            for later in range(turn, until):
                for column in range(timing.first, timing.last):
                    out[row, later, column] = stored[page, place, column]
            turn, number = until, number + 1
