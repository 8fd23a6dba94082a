"""A question to a controller in a block of scenes, some of which it may fail over.

A function remembers nothing: where it fails over a question twice, it is asked about each half of the scenes alone,
until those are left over which it always fails. With a memory, or in a process, the block has to be driven again
(`engine.driving.blocks`).
"""

from dataclasses import dataclass, field, replace

import numpy as np

from engine.driving.controllers import ControllerSlot
from engine.errors import LostError
from engine.tables import Bools, Floats, Ints

HOPELESS = 16
"""So many scenes are lost, and none finished, before a driver is given up."""


@dataclass
class DriverHistory:
    """What is known of a driver by now."""

    answered: set[int] = field(default_factory=set)
    """Controls for which it has ever given an action that can be driven: who never did is no driver."""
    finished: bool = False
    """Whether any scene has come to its end."""
    lost: int = 0
    """Scenes over which it failed."""

    @property
    def should_abort(self) -> bool:
        """Whether so much was lost, and nothing finished, that more would be lost as well."""
        return not self.finished and self.lost >= HOPELESS


@dataclass(frozen=True)
class Answer:
    """What a controller decides."""

    actions: Floats
    """(n, a)"""
    lost: dict[int, LostError] = field(default_factory=dict)
    """The rows over which it fails, and how."""
    recovered: LostError | None = None
    """How it failed the first time, where that cost no row."""


def query_with_retries(seat: ControllerSlot, seen: Floats, asked: Bools, times: Floats) -> Answer:
    """Ask about the rows of `seen` (n, d) that are `asked` (n,), of samples at these `times` (n,).

    Raises:
        LostError: it fails, and remembers.
    """
    try:
        return Answer(seat.answer(seen, asked, times))
    except LostError as error:
        if seat.remembers:
            raise
        first = error
    try:
        return Answer(seat.answer(seen, asked, times), recovered=first)
    except LostError:
        answer = _in_halves(seat, seen, asked, times)
        return answer if answer.lost else replace(answer, recovered=first)


def _in_halves(seat: ControllerSlot, seen: Floats, asked: Bools, times: Floats) -> Answer:
    """Ask about ever fewer rows."""
    actions, lost = np.zeros((len(seen), len(seat.control.actions))), dict[int, LostError]()
    waiting: list[Ints] = [np.flatnonzero(asked)]
    while waiting:
        rows = waiting.pop()
        try:
            actions[rows] = seat.answer(_alone(seen, rows), asked, times)[rows]
        except LostError as error:
            if len(rows) > 1:
                waiting.extend(reversed(np.array_split(rows, 2)))
                continue
            lost[int(rows[0])] = error
    return Answer(actions, lost)


def _alone(seen: Floats, rows: Ints) -> Floats:
    """As many rows, for a product of matrices has other bits of another number: these, and elsewhere one of them."""
    only = np.repeat(seen[rows[:1]], len(seen), axis=0)
    only[rows] = seen[rows]
    return only
