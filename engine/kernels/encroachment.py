"""When each of two is in the area that both of them pass over, for PET and encroachment time by conflict area.

Allen, Shin and Cooper (1978), "Analysis of traffic conflicts and collisions", Transportation Research Record 667, take
the area as given. Here it is all that the outlines of both sweep while they are in the scene, whoever was there first.
What an outline sweeps between two samples counts as the convex hull of the two: the true one bulges by less than 1 mm.
"""

import math
from typing import NamedTuple

from engine.kernels.jit import inlined, kernel
from engine.kernels.swept import (
    BLOCK,
    Span,
    Swept,
    boxes_apart,
    hulls_apart,
    lay,
    lay_step,
    measure,
    pose,
    steps_of,
    until,
)
from engine.tables import Floats
from engine.vocabulary import State

HALVINGS = 40
"""Of a step, until the instant at which an outline comes into the area is down to rounding."""
NEVER = -1
"""No such step."""


class OccupancyInterval(NamedTuple):
    """From when to when one of the two is in the area, in samples of the record; infinite if there is no such area."""

    enter: float
    leave: float


class Pair(NamedTuple):
    """One and another whose motions are measured: one looks at what the other sweeps."""

    one: Span
    other: Span
    row: int
    """Of the one in working memory; the other has 1 less it."""


@kernel
def stays(
    states: Floats, one: Span, other: Span, outlines: Floats, sweep: Swept
) -> tuple[OccupancyInterval, OccupancyInterval]:
    """When each is in what the other sweeps."""
    first, second = _measured(states, one, other, outlines, sweep)
    enters = _first_step(states, first, outlines, sweep)
    if enters == NEVER:
        return OccupancyInterval(math.inf, math.inf), OccupancyInterval(math.inf, math.inf)
    return _stay(states, first, enters, outlines, sweep), _stay(
        states, second, _first_step(states, second, outlines, sweep), outlines, sweep
    )


@inlined
def _stay(states: Floats, pair: Pair, enters: int, outlines: Floats, sweep: Swept) -> OccupancyInterval:
    if enters == NEVER:
        return OccupancyInterval(math.inf, math.inf)
    leaves = _last_step(states, pair, outlines, sweep)
    enter = _enter(states, pair, enters, outlines, sweep)
    return OccupancyInterval(enter, _leave(states, pair, leaves, outlines, sweep))


@kernel
def encroachment(states: Floats, ego: Span, other: Span, outlines: Floats, sweep: Swept) -> float:
    """`encroachment_gap` of the stays of two. Steps tell who was there first, so that only instants between which the
    gap lies are searched for.
    """
    mine, theirs = _measured(states, ego, other, outlines, sweep)
    enters = _first_step(states, mine, outlines, sweep)
    if enters == NEVER:
        return math.inf
    leaves, comes = _last_step(states, mine, outlines, sweep), _first_step(states, theirs, outlines, sweep)
    if comes == NEVER:
        return math.inf
    if ego.first + leaves + 1 <= other.first + comes:
        leave = _leave(states, mine, leaves, outlines, sweep)
        return _enter(states, theirs, comes, outlines, sweep) - leave
    goes = _last_step(states, theirs, outlines, sweep)
    if ego.first + leaves > other.first + comes + 1 and other.first + goes > ego.first + enters + 1:
        return math.nan
    if other.first + goes + 1 < ego.first + enters:
        leave = _leave(states, theirs, goes, outlines, sweep)
        return leave - _enter(states, mine, enters, outlines, sweep)
    first = OccupancyInterval(
        _enter(states, mine, enters, outlines, sweep), _leave(states, mine, leaves, outlines, sweep)
    )
    second = OccupancyInterval(
        _enter(states, theirs, comes, outlines, sweep), _leave(states, theirs, goes, outlines, sweep)
    )
    return encroachment_gap(first, second)


@kernel
def encroachment_gap(ego: OccupancyInterval, other: OccupancyInterval) -> float:
    """PET by area, in samples: from when the first is out of the area until the second comes in.

    Positive when the ego was there first, negative when the other was; infinite without an area; NaN where both are in
    it at a time, as when one follows the other: the definition is of paths that cross.
    """
    if ego.enter == math.inf:
        return math.inf
    if ego.leave <= other.enter:
        return other.enter - ego.leave
    return other.leave - ego.enter if other.leave <= ego.enter else math.nan


@inlined
def _measured(states: Floats, one: Span, other: Span, outlines: Floats, sweep: Swept) -> tuple[Pair, Pair]:
    """Measure both motions; the one and the other, and the other way round."""
    measure(states, one, outlines, sweep, 0)
    measure(states, other, outlines, sweep, 1)
    return Pair(one, other, 0), Pair(other, one, 1)


# -- steps in the area -------------------------------------------------------------------------------------------------


@kernel
def _first_step(states: Floats, pair: Pair, outlines: Floats, sweep: Swept) -> int:
    """The first step of the one in which it touches what the other sweeps.

    Where two motions are some way apart, the one goes on until it may have come as far: no step is looked at before.
    """
    k, steps = 0, steps_of(pair.one)
    while k < steps:
        apart = _apart(states, pair, k, outlines, sweep)
        if apart < 0.0:
            return k
        k = until(sweep.ways[pair.row], k, steps, apart)
    return NEVER


@kernel
def _last_step(states: Floats, pair: Pair, outlines: Floats, sweep: Swept) -> int:
    """The last such step."""
    k, ways = steps_of(pair.one) - 1, sweep.ways[pair.row]
    while k >= 0:
        apart = _apart(states, pair, k, outlines, sweep)
        if apart < 0.0:
            return k
        end = ways[k + 1]
        k -= 1
        while k >= 0 and end - ways[k] < apart:
            k -= 1
    return NEVER


@kernel
def _apart(states: Floats, pair: Pair, k: int, outlines: Floats, sweep: Swept) -> float:
    """How far a step of the one stays away from all that the other sweeps, or less [m]; negative if it touches that."""
    row, theirs = pair.row, 1 - pair.row
    box, least, steps = sweep.boxes[row, k], math.inf, steps_of(pair.other)
    lay_step(states, pair.one, k, outlines, sweep, row)
    for block in range(-(-steps // BLOCK)):
        apart = boxes_apart(box, sweep.blocks[theirs, block])
        if apart > 0.0:
            least = min(least, apart)
            continue
        j, end = block * BLOCK, min((block + 1) * BLOCK, steps)
        while j < end:
            apart = boxes_apart(box, sweep.boxes[theirs, j])
            if apart <= 0.0:
                lay_step(states, pair.other, j, outlines, sweep, theirs)
                apart = hulls_apart(sweep.hulls[row, k], sweep.hulls[theirs, j], sweep.near)
            if apart < 0.0:
                return -1.0
            # Half of it may be used up: the rest is what all steps left out are still away.
            least = min(least, 0.5 * apart)
            j = until(sweep.ways[theirs], j, end, 0.5 * apart)
    return least


# -- instants ----------------------------------------------------------------------------------------------------------


@kernel
def _enter(states: Floats, pair: Pair, k: int, outlines: Floats, sweep: Swept) -> float:
    """When the one, in its first step in the area, comes into it, in samples."""
    near = _note_near(states, pair, k, outlines, sweep)
    _part(states, pair, k, 0.0, 0.0, outlines, sweep)
    inside = 0.0 if _touches(pair, near, sweep) else 1.0
    outside = 0.0
    for _ in range(HALVINGS if inside > 0.0 else 0):
        middle = 0.5 * (outside + inside)
        _part(states, pair, k, 0.0, middle, outlines, sweep)
        if _touches(pair, near, sweep):
            inside = middle
        else:
            outside = middle
    return pair.one.first + k + inside


@kernel
def _leave(states: Floats, pair: Pair, k: int, outlines: Floats, sweep: Swept) -> float:
    """When the one, in its last step in the area, goes out of it, in samples."""
    near = _note_near(states, pair, k, outlines, sweep)
    _part(states, pair, k, 1.0, 1.0, outlines, sweep)
    inside = 1.0 if _touches(pair, near, sweep) else 0.0
    outside = 1.0
    for _ in range(HALVINGS if inside < 1.0 else 0):
        middle = 0.5 * (inside + outside)
        _part(states, pair, k, middle, 1.0, outlines, sweep)
        if _touches(pair, near, sweep):
            inside = middle
        else:
            outside = middle
    return min(pair.one.first + k + inside, pair.one.last)


@inlined
def _note_near(states: Floats, pair: Pair, k: int, outlines: Floats, sweep: Swept) -> int:
    """Note which steps of the other a part of a step may touch; how many. Of steps in which it stands, the first."""
    row, theirs, count = pair.row, 1 - pair.row, 0
    for j in range(steps_of(pair.other)):
        stood = j > 0 and _stands(states, pair.other, j - 1) and _stands(states, pair.other, j)
        if not stood and boxes_apart(sweep.boxes[row, k], sweep.boxes[theirs, j]) <= 0.0:
            lay_step(states, pair.other, j, outlines, sweep, theirs)
            sweep.near[count] = j
            count += 1
    return count


@inlined
def _stands(states: Floats, span: Span, step: int) -> bool:
    before, after = states[span.first + step, span.actor], states[min(span.first + step + 1, span.last), span.actor]
    at = before[State.X] == after[State.X] and before[State.Y] == after[State.Y]
    return at and before[State.HEADING] == after[State.HEADING]


@inlined
def _part(states: Floats, pair: Pair, k: int, start: float, end: float, outlines: Floats, sweep: Swept) -> None:
    """Lay the hull of a part of a step."""
    lay(sweep.part, 0, pose(states, pair.one, pair.one.first + k, start, outlines))
    lay(sweep.part, 4, pose(states, pair.one, pair.one.first + k, end, outlines))


@kernel
def _touches(pair: Pair, near: int, sweep: Swept) -> bool:
    """Whether the part that is laid touches one of the steps noted; the one that it touches is looked at first then."""
    for number in range(near):
        j = sweep.near[number]
        if hulls_apart(sweep.part, sweep.hulls[1 - pair.row, j], sweep.near) < 0.0:
            sweep.near[number], sweep.near[0] = sweep.near[0], j
            return True
    return False
