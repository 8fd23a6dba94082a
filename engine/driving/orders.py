"""What is decided in scenes side by side: of the coming turns, which runs read, and all of it, by which they run again.

The decisions of a lane stand in pages, of which it takes one more whenever the last one is full, and gives all back
when its next run begins: lanes need memory for how long their runs are, not for how long any could be. Beside them
stands what everybody was commanded, where it is kept (`engine.kernels.review`).
"""

import math
from collections.abc import Sequence

import numpy as np

from engine.control import Control, columns, numbers_decided, turns
from engine.host import ring
from engine.kernels.orders import TOO_NARROW, note_decisions, take_pages, tell_decisions
from engine.kernels.slots import COMMAND_COLUMNS, PAGE
from engine.program import Program
from engine.tables import PLAIN, Bools, Floats, Ints

ROOM = 256
"""Turns of each lane for which there is room from the start; it is memory once something is written there …"""
SHARE = 32
"""… and for so many more pages whenever none is left, as a part of those that there are."""


class Orders:
    """Decisions for `count` lanes of at most so many turns: by whom they are asked for at which samples, and from when
    on they hold. `told`: how many numbers say what everybody is commanded in a step.
    """

    def __init__(
        self, controls: Sequence[Control], count: int, time_step: float, pause: int, turns_at_most: int, told: int = 0
    ) -> None:
        self.every = [max(1, turns(each.every, time_step)) for each in controls]
        self._delay = [turns(each.delay, time_step) for each in controls]
        self._columns, self._pause = columns(controls), pause
        self.coming = ring(max(map(sum, zip(self.every, self._delay, strict=True))))
        """Rows of a ring of turns of which it is known what was decided."""
        width = numbers_decided(controls)
        self._neutral = np.zeros((count, width))
        room = count * -(-min(turns_at_most, ROOM) // (pause * PAGE))
        self._decided, self.told = np.empty((room, PAGE, width)), np.empty((room, PAGE, pause, told))
        self.pages = np.full((count, 1), -1, dtype=np.int32)
        """(lanes, n): those of each lane, one after the other."""
        self.moves = 0
        """How often pages or their numbers got another place in memory."""
        self._free, self._left, self._most = _from_first(0, room), np.array([room]), 0

    @property
    def nbytes(self) -> int:
        """Memory of what is kept, and was at the most; without `pages`, which runs have."""
        page = sum(each.itemsize * math.prod(each.shape[1:]) for each in (self._decided, self.told))
        return self._most * page + self._free.nbytes + self._neutral.nbytes

    def begin(self, chosen: Ints, neutral: Floats, coming: Floats) -> None:
        """Runs begin in the chosen lanes with the next step; until something is decided, `neutral` (chosen, numbers)
        holds. `coming` (lanes, turns, numbers) is what runs read.
        """
        had = self.pages[chosen]
        back, left = had[had >= 0], int(self._left[0])
        self._free[left : left + len(back)] = back
        self._left[0] = left + len(back)
        self.pages[chosen] = -1
        self._neutral[chosen] = neutral
        coming[chosen] = neutral[:, np.newaxis]

    def reserve(self, chosen: Bools, samples: Ints) -> None:
        """Have a row in the chosen lanes, which are at `samples` (lanes,), for what is decided and commanded there."""
        missing = take_pages(chosen, samples, self._pause, self.pages, self._free, self._left)
        if missing == TOO_NARROW:
            self.pages = np.pad(self.pages, ((0, 0), (0, 1)), constant_values=-1)
            self.moves += 1
        elif missing > 0:
            self._make_room(missing)
        else:
            self._most = max(self._most, len(self._decided) - int(self._left[0]))
            return
        self.reserve(chosen, samples)

    def _make_room(self, needed: int) -> None:
        """Have so many free pages; there are none."""
        self.moves += 1
        there = len(self._decided)
        more = max(needed, there // SHARE)
        for each in (self._decided, self.told):
            each.resize((there + more, *each.shape[1:]), refcheck=False)  # where it is, or moved without a copy
        self._free = np.concatenate([_from_first(there, more), np.zeros(there, dtype=np.int32)])
        self._left[0] = more

    def decide(self, number: int, chosen: Bools, samples: Ints, actions: Floats, coming: Floats) -> None:
        """Let the control of this number do `actions` (lanes, a) in the chosen lanes, now or from its delay on."""
        self.reserve(chosen, samples)
        first, delay, every = self._columns[number].start, self._delay[number], self.every[number]
        given, kept = np.require(actions, np.float64, PLAIN), self._decided
        note_decisions(chosen, samples, given, first, delay, every, self._pause, self.pages, kept, coming)

    def decided(self, chosen: Ints, samples: Ints, out: Floats) -> None:
        """Write what was decided for each turn in the chosen lanes, which are at `samples` (chosen,), into `out`
        (chosen, turns, numbers); what was decided last goes on.
        """
        for its, every, delay in zip(self._columns, self.every, self._delay, strict=True):
            first, last, pause = its.start, its.stop, self._pause
            kept, neutral = self._decided, self._neutral
            tell_decisions(chosen, samples, first, last, delay, every, pause, self.pages, kept, neutral, out)


def _from_first(first: int, count: int) -> Ints:
    """So many pages to be taken one after the other, which is from the end: none is touched before all earlier ones."""
    return np.arange(first + count - 1, first - 1, -1, dtype=np.int32)


def command_columns(program: Program) -> Ints:
    """(actors,) as `kernels.run_state.Run` says: who is given pedals from outside mostly does what is decided."""
    given = {
        control.actor: its.start
        for control, its in zip(program.controls, columns(program.controls), strict=True)
        if control.names == ("throttle", "brake", "steer")
    }
    others = [actor for actor in range(len(program.actors)) if actor not in given]
    at = [
        COMMAND_COLUMNS * others.index(actor) if actor in others else -1 - given[actor]
        for actor in range(len(program.actors))
    ]
    return np.array(at, dtype=np.int32)
