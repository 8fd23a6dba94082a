"""Areas that outlines sweep between samples: for each step the convex hull of its two ends, and a box about it.

A step's hull is computed when it is first needed. Boxes, of each step and of `BLOCK` steps, are parallel to the axes;
they contain the whole swept area, which extends beyond the hull by at most r turn^2 / 8 in a turn.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.handles import handle
from engine.kernels.geometry import Box, half_diagonal, outline_between, shortest_turn
from engine.kernels.jit import inlined
from engine.tables import Floats, Ints
from engine.vocabulary import State

POINTS = 8
"""Corners of two outlines."""
LINES = POINTS * POINTS
BLOCK = 16
"""Steps that share a box."""
ROUNDING = 1e-6
"""Margin added to boxes [m]."""
LEFT, BELOW, RIGHT, ABOVE = range(4)
"""Sides of a box."""


class Span(NamedTuple):
    """An actor, and the first and last sample at which it is in the scene."""

    actor: int
    first: int
    last: int


@handle
class Swept(NamedTuple):
    """Working memory for the motions of two actors, in rows 0 and 1; created by `swept`."""

    hulls: Floats
    """(2, steps, POINTS, 2): corners of the outline at the start and at the end of a step, valid if `laid`."""
    laid: Ints
    """(2, steps): 1 for a step whose corners in `hulls` are valid."""
    ways: Floats
    """(2, steps + 1): bound on the distance that any point of the outline covers until each sample [m]."""
    boxes: Floats
    """(2, steps, 4): sides of the box about each step."""
    blocks: Floats
    """(2, blocks, 4): sides of the boxes about `BLOCK` steps each."""
    part: Floats
    """(POINTS, 2): corners of a part of a step."""
    near: Ints
    """(steps + 1,): steps that `part` may touch; the last entry is the line that last separated two hulls."""


def swept(samples: int) -> Swept:
    """Return memory for motions of `samples` samples."""
    steps = max(samples, 1)
    return Swept(
        hulls=np.zeros((2, steps, POINTS, 2)),
        laid=np.zeros((2, steps), dtype=np.int32),
        ways=np.zeros((2, steps + 1)),
        boxes=np.zeros((2, steps, 4)),
        blocks=np.zeros((2, -(-steps // BLOCK), 4)),
        part=np.zeros((POINTS, 2)),
        near=np.zeros(steps + 1, dtype=np.int32),
    )


@inlined
def steps_of(span: Span) -> int:
    """Return the number of steps of a span; 1 for a single sample, with a step without motion."""
    return max(span.last - span.first, 1)


@inlined
def pose(states: Floats, span: Span, k: int, part: float, outlines: Floats) -> Box:
    """Return an actor's outline at a part of a step after sample k; after its last sample it stands."""
    return outline_between(states, k, min(k + 1, span.last), part, span.actor, outlines)


@inlined
def measure(states: Floats, span: Span, outlines: Floats, sweep: Swept, row: int) -> None:
    """Write distances and boxes of a motion into a row; no hull is computed yet."""
    length, width = outlines[span.actor, 0], outlines[span.actor, 1]
    radius = half_diagonal(Box(0.0, 0.0, 0.0, length, width))
    sweep.ways[row, 0] = 0.0
    x, y = states[span.first, span.actor, State.X], states[span.first, span.actor, State.Y]
    heading = states[span.first, span.actor, State.HEADING]
    cos, sin = abs(math.cos(heading)), abs(math.sin(heading))
    across, up = 0.5 * (length * cos + width * sin), 0.5 * (length * sin + width * cos)
    for k in range(steps_of(span)):
        after = min(span.first + k + 1, span.last)
        x1, y1 = states[after, span.actor, State.X], states[after, span.actor, State.Y]
        heading1 = states[after, span.actor, State.HEADING]
        across1, up1 = across, up
        if heading1 != heading:
            cos, sin = abs(math.cos(heading1)), abs(math.sin(heading1))
            across1, up1 = 0.5 * (length * cos + width * sin), 0.5 * (length * sin + width * cos)
        turn = abs(shortest_turn(heading, heading1))
        slack = ROUNDING + 0.125 * radius * turn * turn
        box = sweep.boxes[row, k]
        box[LEFT], box[BELOW] = min(x - across, x1 - across1) - slack, min(y - up, y1 - up1) - slack
        box[RIGHT], box[ABOVE] = max(x + across, x1 + across1) + slack, max(y + up, y1 + up1) + slack
        if not math.isfinite(x + y + heading + x1 + y1 + heading1):  # a broken run touches nothing
            box[LEFT], box[BELOW], box[RIGHT], box[ABOVE] = math.inf, math.inf, -math.inf, -math.inf
        _widen(sweep.blocks[row, k // BLOCK], box, k % BLOCK == 0)
        sweep.ways[row, k + 1] = sweep.ways[row, k] + math.sqrt((x1 - x) ** 2 + (y1 - y) ** 2) + radius * turn
        sweep.laid[row, k] = 0
        x, y, heading, across, up = x1, y1, heading1, across1, up1


@inlined
def _widen(block: Floats, box: Floats, first: bool) -> None:
    """Let the box of a block hold a step's, the first of which begins it."""
    for side in range(4):
        lower = side < RIGHT
        if first or (lower and box[side] < block[side]) or (not lower and box[side] > block[side]):
            block[side] = box[side]


@inlined
def boxes_apart(one: Floats, other: Floats) -> float:
    """Return the distance of two boxes along an axis [m]; negative if they overlap."""
    aside = max(one[LEFT] - other[RIGHT], other[LEFT] - one[RIGHT])
    return max(aside, one[BELOW] - other[ABOVE], other[BELOW] - one[ABOVE])


@inlined
def until(ways: Floats, k: int, steps: int, apart: float) -> int:
    """Return the first step after step k by whose end a point may have covered `apart` [m]; else `steps`."""
    low, high = k + 1, steps
    if low < high and not ways[low + 1] - ways[k] < apart:
        return low
    while low < high:
        middle = (low + high) // 2
        if ways[middle + 1] - ways[k] < apart:
            low = middle + 1
        else:
            high = middle
    return low


# -- hulls -------------------------------------------------------------------------------------------------------------


@inlined
def lay_step(states: Floats, span: Span, k: int, outlines: Floats, sweep: Swept, row: int) -> None:
    """Lay the hull of a step, unless it is laid."""
    if sweep.laid[row, k] == 0:
        lay(sweep.hulls[row, k], 0, pose(states, span, span.first + k, 0.0, outlines))
        lay(sweep.hulls[row, k], 4, pose(states, span, span.first + k, 1.0, outlines))
        sweep.laid[row, k] = 1


@inlined
def lay(corners: Floats, first: int, box: Box) -> None:
    """Write the four corners of an outline into rows from `first` on."""
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    for number in range(4):
        along = 0.5 * box.length * (1.0 if number < 2 else -1.0)
        across = 0.5 * box.width * (1.0 if number % 2 == 0 else -1.0)
        corners[first + number, 0] = box.x + along * cos - across * sin
        corners[first + number, 1] = box.y + along * sin + across * cos


@inlined
def hulls_apart(one: Floats, other: Floats, near: Ints) -> float:
    """Return the distance by which a line through two corners of a hull separates the two [m], for the first such line;
    negative if there is none. Every side of a hull is such a line. The line that separated last is tried first
    (`near[-1]`).
    """
    hint = int(near[-1])
    for number in range(-1, 2 * LINES):
        line = hint if number < 0 else number
        i, j = line % LINES // POINTS, line % POINTS
        if i < j:
            apart = _parted(one, other, i, j) if line < LINES else _parted(other, one, i, j)
            if apart >= 0.0:
                near[-1] = line
                return apart
    return -1.0


@inlined
def _parted(own: Floats, theirs: Floats, i: int, j: int) -> float:
    """Return the distance by which the line through corners i and j of `own` separates two hulls [m]; else negative.

    Corner i is on the line. If corners of the other hull are on both sides of it, or on it, nothing is separated; else
    the nearest of them is compared with the own corner that extends farthest to their side.
    """
    nx, ny = own[i, 1] - own[j, 1], own[j, 0] - own[i, 0]
    line = nx * own[i, 0] + ny * own[i, 1]
    low, high = math.inf, -math.inf
    for point in range(POINTS):
        place = nx * theirs[point, 0] + ny * theirs[point, 1]
        low, high = min(low, place), max(high, place)
        if low <= line <= high:
            return -1.0
    least, most = line, line
    for point in range(POINTS):
        place = nx * own[point, 0] + ny * own[point, 1]
        least, most = min(least, place), max(most, place)
        if least <= high and low <= most:
            return -1.0
    return max(low - most, least - high) / math.hypot(nx, ny)
