"""Decisions of controllers in parallel runs: those of the coming turns, and all of a run for its repetition.

The decisions of a slot are stored in pages. A slot takes a page whenever its last one is full, and returns all pages
when its next run begins, so that memory grows with the length of the runs that happen. The commands of the actors are
stored in pages of the same numbers, if at all (`engine.kernels.review`).
"""

import math
from collections.abc import Sequence

import numpy as np

from engine.control import Control, columns, numbers_decided, turns
from engine.host import ring
from engine.kernels.decision_pages import TOO_NARROW, ControlTiming, read_decisions, store_decisions, take_pages
from engine.kernels.slots import COMMAND_COLUMNS, PAGE
from engine.program import Program
from engine.tables import PLAIN, Bools, Floats, Ints

ROOM = 256
"""Turns per slot for which pages exist from the start; the system provides their memory at the first write."""
SHARE = 32
"""Growth of the page pool when it is exhausted: 1 / SHARE of its size."""


class DecisionPages:
    """Decisions of `controls` in `count` slots for at most `turns_at_most` turns.

    `commands`: numbers per turn that store the commands of all actors; 0 stores none.
    """

    def __init__(
        self,
        controls: Sequence[Control],
        count: int,
        time_step: float,
        pause: int,
        turns_at_most: int,
        commands: int = 0,
    ) -> None:
        self.timings = [
            ControlTiming(
                its.start, its.stop, turns(each.delay, time_step), max(1, turns(each.every, time_step)), pause
            )
            for each, its in zip(controls, columns(controls), strict=True)
        ]
        self._pause = pause
        self.coming = ring(max(timing.every + timing.delay for timing in self.timings))
        """Rows of the ring of turns whose decisions are known."""
        width = numbers_decided(controls)
        self._neutral = np.zeros((count, width))
        room = count * -(-min(turns_at_most, ROOM) // (pause * PAGE))
        self._stored, self.commands = np.empty((room, PAGE, width)), np.empty((room, PAGE, pause, commands))
        self.pages = np.full((count, 1), -1, dtype=np.int32)
        """(slots, n) Numbers of the pages of each slot, in the order of time; -1 where there is none."""
        self.moves = 0
        """Number of times that an array of pages, or of their numbers, was replaced or moved."""
        self._free, self._left, self._most = _from_first(0, room), np.array([room]), 0

    @property
    def nbytes(self) -> int:
        """Return the largest memory that decisions and commands have used [bytes], without `pages`."""
        page = sum(each.itemsize * math.prod(each.shape[1:]) for each in (self._stored, self.commands))
        return self._most * page + self._free.nbytes + self._neutral.nbytes

    def begin(self, chosen: Ints, neutral: Floats, coming: Floats) -> None:
        """Prepare the chosen slots for runs that begin with the next step.

        `neutral` (chosen, numbers) holds until the first decision. The runs read `coming` (slots, turns, numbers).
        """
        had = self.pages[chosen]
        back, left = had[had >= 0], int(self._left[0])
        self._free[left : left + len(back)] = back
        self._left[0] = left + len(back)
        self.pages[chosen] = -1
        self._neutral[chosen] = neutral
        coming[chosen] = neutral[:, np.newaxis]

    def reserve(self, chosen: Bools, samples: Ints) -> None:
        """Provide a row for the decisions and commands of the chosen slots, which are at `samples` (slots,)."""
        missing = take_pages(chosen, samples, self._pause, self.pages, self._free, self._left)
        if missing == TOO_NARROW:
            self.pages = np.pad(self.pages, ((0, 0), (0, 1)), constant_values=-1)
            self.moves += 1
        elif missing > 0:
            self._make_room(missing)
        else:
            self._most = max(self._most, len(self._stored) - int(self._left[0]))
            return
        self.reserve(chosen, samples)

    def _make_room(self, needed: int) -> None:
        """Add at least `needed` pages to the empty pool."""
        self.moves += 1
        there = len(self._stored)
        more = max(needed, there // SHARE)
        for each in (self._stored, self.commands):
            each.resize((there + more, *each.shape[1:]), refcheck=False)  # in place, or moved without a copy
        self._free = np.concatenate([_from_first(there, more), np.zeros(there, dtype=np.int32)])
        self._left[0] = more

    def decide(self, number: int, chosen: Bools, samples: Ints, actions: Floats, coming: Floats) -> None:
        """Store `actions` (slots, a) of a control in the chosen slots; they hold after its delay."""
        self.reserve(chosen, samples)
        given = np.require(actions, np.float64, PLAIN)
        store_decisions(chosen, samples, given, self.timings[number], self.pages, self._stored, coming)

    def decided(self, chosen: Ints, samples: Ints, out: Floats) -> None:
        """Write the decisions for every turn of the chosen slots, which are at `samples` (chosen,), into `out`.

        `out`: (chosen, turns, numbers). The last decision holds until the end.
        """
        for timing in self.timings:
            read_decisions(chosen, samples, timing, self.pages, self._stored, self._neutral, out)


def _from_first(first: int, count: int) -> Ints:
    """Return `count` page numbers so that the pool, which is taken from its end, touches low pages first."""
    return np.arange(first + count - 1, first - 1, -1, dtype=np.int32)


def command_columns(program: Program) -> Ints:
    """Return (actors,) the columns of the actors' commands, as `kernels.run_state.Run` defines them.

    An actor whose pedals are controlled from outside has no columns of its own: its decision is its command.
    """
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
