"""When each of two is in the area that both of them pass over, for PET and encroachment time by conflict area.

Allen, Shin and Cooper (1978), "Analysis of traffic conflicts and collisions", Transportation Research Record 667, take
the area as given. Here it is all that the outlines of both sweep while they are in the scene, whoever was there first.
What an outline sweeps between two samples counts as the convex hull of the two: the true one bulges by less than 1 mm.
"""

import math
from typing import NamedTuple

from engine.kernels.geometry import Box, half_diagonal, outline_between, shortest_turn
from engine.kernels.jit import inlined, kernel
from engine.tables import Floats

POINTS = 8
"""Corners of two outlines."""
HALVINGS = 40
"""Of a step, until the instant at which an outline comes into the area is down to rounding."""


class Stay(NamedTuple):
    """From when to when one of the two is in the area, in samples of the record; infinite if there is no such area."""

    enter: float
    leave: float


class Span(NamedTuple):
    """An actor, and the first and last sample at which it is in the scene."""

    actor: int
    first: int
    last: int


@kernel
def stay(states: Floats, one: Span, other: Span, outlines: Floats, corners: Floats, ways: Floats) -> Stay:
    """When `one` is in what `other` sweeps. `corners` (2, POINTS, 2) and `ways` (2, samples + 1) are working memory.

    Where two motions are some way apart, both go on until they may have come as far: no step is looked at before.
    """
    _measure(states, one, outlines, ways[0])
    _measure(states, other, outlines, ways[1])
    k, steps = 0, _steps(one)
    while k < steps:
        apart = _apart(states, one, one.first + k, 0.0, 1.0, other, outlines, corners, ways[1])
        if apart < 0.0:
            outside, inside = 0.0, 1.0
            for _ in range(HALVINGS):
                middle = 0.5 * (outside + inside)
                if _apart(states, one, one.first + k, 0.0, middle, other, outlines, corners, ways[1]) < 0.0:
                    inside = middle
                else:
                    outside = middle
            if _apart(states, one, one.first + k, 0.0, 0.0, other, outlines, corners, ways[1]) < 0.0:
                inside = 0.0
            return Stay(one.first + k + inside, _leaves(states, one, other, outlines, corners, ways))
        k = _until(ways[0], k, steps, apart)
    return Stay(math.inf, math.inf)


@kernel
def _leaves(states: Floats, one: Span, other: Span, outlines: Floats, corners: Floats, ways: Floats) -> float:
    """The last instant of `one` in what `other` sweeps, in samples."""
    k = _steps(one) - 1
    while k >= 0:
        step = one.first + k
        apart = _apart(states, one, step, 0.0, 1.0, other, outlines, corners, ways[1])
        if apart < 0.0:
            inside, outside = 0.0, 1.0
            if _apart(states, one, step, 1.0, 1.0, other, outlines, corners, ways[1]) < 0.0:
                inside = 1.0
            for _ in range(HALVINGS):
                middle = 0.5 * (inside + outside)
                if _apart(states, one, step, middle, 1.0, other, outlines, corners, ways[1]) < 0.0:
                    inside = middle
                else:
                    outside = middle
            return min(step + inside, one.last)
        end = ways[0, k + 1]
        k -= 1
        while k >= 0 and end - ways[0, k] < apart:
            k -= 1
    return float(one.first)


@inlined
def _steps(span: Span) -> int:
    """How many are looked at; of a single sample one, in which nothing moves."""
    return max(span.last - span.first, 1)


@kernel
def _measure(states: Floats, span: Span, outlines: Floats, ways: Floats) -> None:
    """Into `ways` how far any point of an outline may have come until each sample of its span [m]."""
    ways[0] = 0.0
    for k in range(_steps(span)):
        before = _pose(states, span, span.first + k, 0.0, outlines)
        after = _pose(states, span, span.first + k, 1.0, outlines)
        turn = abs(shortest_turn(before.heading, after.heading))
        ways[k + 1] = ways[k] + math.hypot(after.x - before.x, after.y - before.y) + half_diagonal(before) * turn


@inlined
def _until(ways: Floats, k: int, steps: int, apart: float) -> int:
    """The first step after step k by whose end something may have come as far as this, `steps` if none."""
    low, high = k + 1, steps
    while low < high:
        middle = (low + high) // 2
        if ways[middle + 1] - ways[k] < apart:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _apart(
    states: Floats,
    one: Span,
    k: int,
    start: float,
    end: float,
    other: Span,
    outlines: Floats,
    corners: Floats,
    ways: Floats,
) -> float:
    """How far the part of `one`'s step after sample k stays away from all that `other` sweeps, or less [m]; negative
    if it touches that.
    """
    a0, a1 = _pose(states, one, k, start, outlines), _pose(states, one, k, end, outlines)
    _lay(corners, 0, a0, a1)
    least, j, steps = math.inf, 0, _steps(other)
    while j < steps:
        b0 = _pose(states, other, other.first + j, 0.0, outlines)
        b1 = _pose(states, other, other.first + j, 1.0, outlines)
        apart = _slack(a0, a1, b0, b1)
        if apart <= 0.0:
            _lay(corners, 1, b0, b1)
            apart = _parted(corners, 0)
            apart = _parted(corners, 1) if apart < 0.0 else apart
        if apart < 0.0:
            return -1.0
        # Half of it may be used up: the rest is what all steps left out are still away.
        least = min(least, 0.5 * apart)
        j = _until(ways, j, steps, 0.5 * apart)
    return least


@inlined
def _pose(states: Floats, span: Span, k: int, part: float, outlines: Floats) -> Box:
    """An actor's outline a part of a step after sample k; after its last sample it stays."""
    return outline_between(states, k, min(k + 1, span.last), part, span.actor, outlines)


@inlined
def _slack(a0: Box, a1: Box, b0: Box, b1: Box) -> float:
    """How far circles about both motions are apart [m]; 0 or less where they are not."""
    x, y = 0.5 * (b0.x + b1.x - a0.x - a1.x), 0.5 * (b0.y + b1.y - a0.y - a1.y)
    reach = half_diagonal(a0) + half_diagonal(b0)
    reach += 0.5 * (math.hypot(a1.x - a0.x, a1.y - a0.y) + math.hypot(b1.x - b0.x, b1.y - b0.y))
    return math.sqrt(x * x + y * y) - reach


@inlined
def _lay(corners: Floats, row: int, start: Box, end: Box) -> None:
    """The corners of both outlines into a row of the working memory."""
    for number in range(POINTS):
        box = start if number < 4 else end
        along = 0.5 * box.length * (1.0 if number % 4 < 2 else -1.0)
        across = 0.5 * box.width * (1.0 if number % 2 == 0 else -1.0)
        cos, sin = math.cos(box.heading), math.sin(box.heading)
        corners[row, number, 0] = box.x + along * cos - across * sin
        corners[row, number, 1] = box.y + along * sin + across * cos


@kernel
def _parted(corners: Floats, row: int) -> float:
    """How far a line through two corners of a row has the two hulls apart [m], the first one that has; negative
    without. Every side of its hull is such a line.
    """
    for i in range(POINTS):
        for j in range(i + 1, POINTS):
            nx = corners[row, i, 1] - corners[row, j, 1]
            ny = corners[row, j, 0] - corners[row, i, 0]
            low, high, other_low, other_high = math.inf, -math.inf, math.inf, -math.inf
            for point in range(POINTS):
                own = nx * corners[row, point, 0] + ny * corners[row, point, 1]
                theirs = nx * corners[1 - row, point, 0] + ny * corners[1 - row, point, 1]
                low, high = min(low, own), max(high, own)
                other_low, other_high = min(other_low, theirs), max(other_high, theirs)
            if high < other_low or other_high < low:
                return max(other_low - high, low - other_high) / math.hypot(nx, ny)
    return -1.0


@kernel
def encroachment_gap(ego: Stay, other: Stay) -> float:
    """PET by area, in samples: from when the first is out of the area until the second comes in.

    Positive when the ego was there first, negative when the other was; infinite without an area; NaN where both are in
    it at a time, as when one follows the other: the definition is of paths that cross.
    """
    if ego.enter == math.inf:
        return math.inf
    if ego.leave <= other.enter:
        return other.enter - ego.leave
    return other.leave - ego.enter if other.leave <= ego.enter else math.nan
