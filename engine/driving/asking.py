"""A question to a controller in a block of scenes, some of which it may fail over.

A function remembers nothing: where it fails over a question twice, it is asked about each half of the scenes alone,
until those are left over which it always fails. With a memory, or in a process, the block has to be driven again
(`engine.driving.blocks`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from engine.driving.controllers import Seat
from engine.errors import LostError
from engine.tables import Bools, Floats, Ints


@dataclass(frozen=True)
class Answer:
    """What a controller decides."""

    actions: Floats
    """(n, a)"""
    lost: dict[int, LostError] = field(default_factory=dict)
    """The rows over which it fails, and how."""
    recovered: LostError | None = None
    """How it failed the first time, and not again."""


def asked_patiently(
    seat: Seat, seen: Floats, asked: Bools, times: Floats, is_hopeless: Callable[[int], bool]
) -> Answer:
    """Ask about the rows of `seen` (n, d) that are `asked` (n,), of samples at these `times` (n,).

    `is_hopeless` says whether to give up after so many rows without an answer for any.

    Raises:
        LostError: it fails, and remembers.
        ControllerError: it is hopeless.
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
        return _in_halves(seat, seen, asked, times, is_hopeless)


def _in_halves(seat: Seat, seen: Floats, asked: Bools, times: Floats, is_hopeless: Callable[[int], bool]) -> Answer:
    """Ask about ever fewer rows; hopeless it is where none of those before had an answer."""
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
            if len(lost) == np.count_nonzero(asked) - sum(map(len, waiting)) and is_hopeless(len(lost)):
                raise error.for_good() from error
    return Answer(actions, lost)


def _alone(seen: Floats, rows: Ints) -> Floats:
    """As many rows, for a product of matrices has other bits of another number: these, and elsewhere one of them."""
    only = np.repeat(seen[rows[:1]], len(seen), axis=0)
    only[rows] = seen[rows]
    return only
