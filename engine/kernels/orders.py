"""What is asked and decided in runs side by side, lane by lane: for `engine.driving.orders`, which owns the memory."""

from engine.kernels.jit import kernel
from engine.kernels.run_state import RUNNING, Status
from engine.kernels.slots import PAGE
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

TOO_NARROW = -1
"""Of `take_pages`: lanes have more pages than there are columns."""


@kernel
def note_asked(status: Ints, verdict: Ints, every: int, out: Bools) -> None:
    """Whether each lane (lanes,) pauses at a sample at which somebody is asked `every` so many turns."""
    for lane in range(len(out)):
        goes = verdict[lane] == Verdict.VALID and status[lane, Status.END] == RUNNING
        out[lane] = goes and status[lane, Status.PAUSED] == 1 and status[lane, Status.SAMPLE] % every == 0


@kernel
def note_running(status: Ints, verdict: Ints, out: Bools) -> None:
    """Whether each lane (lanes,) has a run that goes on."""
    for lane in range(len(out)):
        out[lane] = verdict[lane] == Verdict.VALID and status[lane, Status.END] == RUNNING


@kernel
def are_within(actions: Floats, asked: Bools, low: Floats, high: Floats) -> bool:
    """Whether all actions (lanes, a) of the lanes that are asked are numbers from `low` to `high` (a,)."""
    for lane in range(len(asked)):
        if asked[lane]:
            for number in range(actions.shape[1]):
                if not (low[number] <= actions[lane, number] <= high[number]):
                    return False
    return True


@kernel
def take_pages(chosen: Bools, samples: Ints, pause: int, pages: Ints, free: Ints, left: Ints) -> int:
    """Give each chosen lane that has none a page for its current row: from the last of the `left` (1,) first ones in
    `free`. Return how many are missing, or `TOO_NARROW`.
    """
    missing = 0
    for lane in range(len(chosen)):
        if not chosen[lane]:
            continue
        which = samples[lane] // pause // PAGE
        if which >= pages.shape[1]:
            return TOO_NARROW
        if pages[lane, which] < 0 and left[0] > 0:
            left[0] -= 1
            pages[lane, which] = free[left[0]]
        elif pages[lane, which] < 0:
            missing += 1
    return missing


@kernel
def note_decisions(
    chosen: Bools,
    samples: Ints,
    actions: Floats,
    column: int,
    delay: int,
    every: int,
    pause: int,
    pages: Ints,
    kept: Floats,
    coming: Floats,
) -> None:
    """Keep actions (lanes, a), which stand from a `column` on among all numbers, in `kept` (pages, PAGE, numbers), and
    for the turns for which they hold in `coming` (lanes, turns, numbers), a ring of a power of two.
    """
    for lane in range(len(chosen)):
        if not chosen[lane]:
            continue
        row, first = samples[lane] // pause, samples[lane] + delay
        page = pages[lane, row // PAGE]
        for number in range(actions.shape[1]):
            kept[page, row % PAGE, column + number] = actions[lane, number]
        for later in range(every):
            turn = (first + later) & (coming.shape[1] - 1)
            for number in range(actions.shape[1]):
                coming[lane, turn, column + number] = actions[lane, number]


@kernel
def tell_decisions(
    chosen: Ints,
    samples: Ints,
    first: int,
    last: int,
    delay: int,
    every: int,
    pause: int,
    pages: Ints,
    kept: Floats,
    neutral: Floats,
    out: Floats,
) -> None:
    """Write what was decided for each turn in the chosen lanes, which are at `samples` (chosen,), into the columns
    `first` to `last` (exclusive) of `out` (chosen, turns, numbers): `neutral` (lanes, numbers) before the first
    decision holds, and the last one from when on it does.
    """
    apart = every // pause
    for row in range(len(chosen)):
        lane, known = chosen[row], (samples[row] + every - 1) // every
        turn = out.shape[1] if known == 0 else min(delay, out.shape[1])
        for before in range(turn):
            for column in range(first, last):
                out[row, before, column] = neutral[lane, column]
        number = 0
        while turn < out.shape[1]:
            at, until = number * apart, out.shape[1] if number + 1 == known else min(turn + every, out.shape[1])
            page, place = pages[lane, at // PAGE], at % PAGE
            for later in range(turn, until):
                for column in range(first, last):
                    out[row, later, column] = kept[page, place, column]
            turn, number = until, number + 1
