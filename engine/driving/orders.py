"""What is decided in scenes side by side: of the coming turns, which runs read, and all of it, by which they run again.

The decisions of a lane stand in pages, of which it takes one more whenever the last one is full, and gives all back
when its next run begins: lanes need memory for how long their runs are, not for how long any could be.
"""

from collections.abc import Sequence

import numpy as np

from engine.control import Control, columns, numbers_decided, turns
from engine.tables import Bools, Floats, Ints

PAGE = 16
"""Rows of a page, each what was decided at one pause."""
AT_ONCE = 256
"""Lanes that are gathered at once: what a processor's cache holds."""
SHARE = 8
"""There is room for so many more pages whenever none is left, as a part of those that there are."""


class Orders:
    """Decisions for `count` lanes: by whom they are asked for at which samples, and from when on they hold."""

    def __init__(self, controls: Sequence[Control], count: int, time_step: float, pause: int) -> None:
        self.every = [max(1, turns(each.every, time_step)) for each in controls]
        self._delay = [turns(each.delay, time_step) for each in controls]
        self._columns, self._pause = columns(controls), pause
        self.coming = max(map(sum, zip(self.every, self._delay, strict=True)))
        """Turns of which it is known what was decided."""
        width = numbers_decided(controls)
        self._neutral = np.zeros((count, width))
        self._pages = np.zeros((count, PAGE, width))
        self._table = np.full((count, 1), -1, dtype=np.int32)  # the pages of each lane, one after the other
        self._free = np.arange(count, dtype=np.int32)

    @property
    def nbytes(self) -> int:
        """Memory of what is kept."""
        return self._pages.nbytes + self._table.nbytes + self._free.nbytes + self._neutral.nbytes

    def begin(self, chosen: Ints, neutral: Floats, coming: Floats) -> None:
        """Runs begin in the chosen lanes with the next step; until something is decided, `neutral` (chosen, numbers)
        holds. `coming` (lanes, turns, numbers) is what runs read.
        """
        had = self._table[chosen]
        self._free = np.concatenate([self._free, had[had >= 0]])
        self._table[chosen] = -1
        self._neutral[chosen] = neutral
        coming[chosen] = neutral[:, np.newaxis]

    def decide(self, number: int, chosen: Bools, samples: Ints, actions: Floats, coming: Floats) -> None:
        """Let the control of this number do `actions` (lanes, a) in the chosen lanes, now or from its delay on."""
        its, lane = self._columns[number], np.flatnonzero(chosen)
        now, given = samples[lane], actions[lane]
        row = now // self._pause
        page = self._page(lane, row // PAGE)  # which may make room for more of them
        _rows(self._pages)[page * PAGE + row % PAGE, its] = given
        first, kept = now + self._delay[number], coming.shape[1]
        for later in range(self.every[number]):
            _rows(coming)[lane * kept + (first + later) % kept, its] = given

    def _page(self, lane: Ints, which: Ints) -> Ints:
        """The pages of these numbers of the lanes; who has none yet takes one."""
        missing = int(which.max(initial=0)) + 1 - self._table.shape[1]
        if missing > 0:
            self._table = np.pad(self._table, ((0, 0), (0, missing)), constant_values=-1)
        page = self._table[lane, which]
        new = np.flatnonzero(page < 0)
        if len(new):
            self._make_room(len(new))
            page[new], self._free = self._free[: len(new)], self._free[len(new) :]
            self._table[lane[new], which[new]] = page[new]
        return page

    def _make_room(self, needed: int) -> None:
        """Have so many free pages."""
        there = len(self._pages)
        if needed > len(self._free):
            more = max(needed - len(self._free), there // SHARE)
            self._pages = np.concatenate([self._pages, np.zeros((more, *self._pages.shape[1:]))])
            self._free = np.concatenate([self._free, np.arange(there, there + more, dtype=np.int32)])

    def decided(self, chosen: Ints, samples: Ints, out: Floats) -> None:
        """Write what was decided for each turn in the chosen lanes, which are at `samples` (chosen,), into `out`
        (chosen, turns, numbers); what was decided last goes on.
        """
        for first in range(0, len(chosen), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            self._decided(chosen[some], samples[some], out[some])

    def _decided(self, chosen: Ints, samples: Ints, out: Floats) -> None:
        length, width = int(out.shape[1]), int(out.shape[2])
        turn, each = np.arange(length), np.arange(len(chosen))
        rows = self._pages[self._table[chosen]].reshape(len(chosen), -1, width)
        for its, every, delay in zip(self._columns, self.every, self._delay, strict=True):
            out[:, :delay, its] = self._neutral[chosen, np.newaxis, its]
            of_it = rows[:, :: every // self._pause, its]
            for later in range(every):
                to = out[:, delay + later :: every, its]
                known = min(to.shape[1], of_it.shape[1])
                to[:, :known] = of_it[:, :known]
            last = (samples - 1) // every
            held = np.where((samples > 0)[:, np.newaxis], of_it[each, np.maximum(last, 0)], self._neutral[chosen, its])
            late = turn >= (delay + (last + 1) * every)[:, np.newaxis]
            np.copyto(out[:, :, its], held[:, np.newaxis], where=late[:, :, np.newaxis])


def _rows(array: Floats) -> Floats:
    """The rows of all lanes or pages, one after the other."""
    return array.reshape(-1, array.shape[-1])
