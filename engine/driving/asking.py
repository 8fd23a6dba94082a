"""A question to a controller in a block of scenes, with a second try after a failure.

A function has no memory: if it fails twice over a question, it is asked about each half of the scenes separately, until
only those remain over which it always fails. A block with a stateful controller or a process has to be driven again
(`engine.driving.blocks`).
"""

from dataclasses import dataclass, field, replace

import numpy as np

from engine.driving.controllers import ControllerSlot
from engine.errors import LostError
from engine.tables import Bools, Floats, Ints

HOPELESS = 16
"""Number of lost scenes, with none finished, at which a driver is given up."""


@dataclass
class DriverHistory:
    """Results of the questions that a driver has answered so far."""

    answered: set[int] = field(default_factory=set)
    """Numbers of the controls for which it has given an action that can be driven; if empty, it is no usable driver."""
    finished: bool = False
    """True if a scene has reached its end."""
    lost: int = 0
    """Number of scenes over which it failed."""

    @property
    def should_abort(self) -> bool:
        """Return True if `HOPELESS` scenes are lost and none has finished."""
        return not self.finished and self.lost >= HOPELESS


@dataclass(frozen=True)
class Answer:
    """Answer of a controller to one question."""

    actions: Floats
    """(n, a)"""
    lost: dict[int, LostError] = field(default_factory=dict)
    """Error of each row over which it fails."""
    recovered: LostError | None = None
    """Error of the first try, if the second one succeeded for all rows."""


def query_with_retries(seat: ControllerSlot, seen: Floats, asked: Bools, times: Floats) -> Answer:
    """Return the answer about the rows of `seen` (n, d) selected by `asked` (n,), for samples at `times` (n,) [s].

    Raises:
        LostError: the controller fails, and is stateful.
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
    """Return (len(seen), d): `rows` of `seen` in place, and copies of the first of them elsewhere.

    The number of rows stays the same, because the bits of a matrix product depend on it.
    """
    only = np.repeat(seen[rows[:1]], len(seen), axis=0)
    only[rows] = seen[rows]
    return only
