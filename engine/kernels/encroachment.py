"""Times at which two actors are in the area that both pass over, for PET and encroachment time by conflict area.

Allen, Shin and Cooper (1978), "Analysis of traffic conflicts and collisions", Transportation Research Record 667, take
the area as given. Here it is the intersection of the areas that both outlines sweep while they are in the scene,
whichever was there first. The area swept between two samples is approximated by the convex hull of both outlines; the
true one extends beyond it by less than 1 mm.
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
"""Number of bisections of a step that find the instant of entry or exit to rounding precision."""
NEVER = -1
"""No such step."""


class OccupancyInterval(NamedTuple):
    """Time in the area, in samples of the record; infinite if there is no such area."""

    enter: float
    leave: float


class Pair(NamedTuple):
    """Two actors whose motions are measured: `one` is tested against the area that `other` sweeps."""

    one: Span
    other: Span
    row: int
    """Row of `one` in working memory; that of `other` is 1 - `row`."""


@kernel
def stays(
    states: Floats, one: Span, other: Span, outlines: Floats, sweep: Swept
) -> tuple[OccupancyInterval, OccupancyInterval]:
    """Return the interval of each actor in the area that the other sweeps."""
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
    """Return `encroachment_gap` of the intervals of two actors. Steps determine their order, so that only the instants
    at the ends of the gap are searched for.
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
    """Return PET by area, in samples: from the exit of the first actor to the entry of the second.

    Positive if the ego was there first, negative if the other was; infinite without an area; NaN if both are in it at a
    time, as when one follows the other: the definition applies to crossing paths.
    """
    if ego.enter == math.inf:
        return math.inf
    if ego.leave <= other.enter:
        return other.enter - ego.leave
    return other.leave - ego.enter if other.leave <= ego.enter else math.nan


@inlined
def _measured(states: Floats, one: Span, other: Span, outlines: Floats, sweep: Swept) -> tuple[Pair, Pair]:
    """Measure both motions; return the pair in both orders."""
    measure(states, one, outlines, sweep, 0)
    measure(states, other, outlines, sweep, 1)
    return Pair(one, other, 0), Pair(other, one, 1)


# -- steps in the area -------------------------------------------------------------------------------------------------


@kernel
def _first_step(states: Floats, pair: Pair, outlines: Floats, sweep: Swept) -> int:
    """Return the first step of `one` in which it touches the area that `other` sweeps; else `NEVER`.

    If the two motions are some distance apart, the search skips the steps in which `one` cannot cover that distance.
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
    """Return the last step of `one` in which it touches the area that `other` sweeps; else `NEVER`."""
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
    """Return a lower bound on the distance of a step of `one` from the area that `other` sweeps [m]; negative on
    contact.
    """
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
            # Half of the distance may be used up: the other half bounds the distance of all steps left out.
            least = min(least, 0.5 * apart)
            j = until(sweep.ways[theirs], j, end, 0.5 * apart)
    return least


# -- instants ----------------------------------------------------------------------------------------------------------


@kernel
def _enter(states: Floats, pair: Pair, k: int, outlines: Floats, sweep: Swept) -> float:
    """Return the instant of entry of `one` in its first step in the area, in samples."""
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
    """Return the instant of exit of `one` in its last step in the area, in samples."""
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
    """Note the steps of `other` that a part of a step may touch; return their number. Of standing steps, only the
    first.
    """
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
    """Return True if the part in memory touches a noted step; that step is then tested first."""
    for number in range(near):
        j = sweep.near[number]
        if hulls_apart(sweep.part, sweep.hulls[1 - pair.row, j], sweep.near) < 0.0:
            sweep.near[number], sweep.near[0] = sweep.near[0], j
            return True
    return False
