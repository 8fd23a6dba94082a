"""The closest approach of two outlines over the continuous motion of one step, searched only if it can beat a best one.

While a unit vector n turns at a steady rate u, the gap between two outlines' shadows on n lies above the chord between
its end values less the bound of its bend / 8: seen from n, the way p + v t between the centres has a second derivative
of at most u^2 |p| + 2 |u| |v|, and a corner at r from a centre that turns by w one of at most (w - u)^2 r. Letting n
turn with the side that it stands on keeps this bound tight where a side faces a corner.
"""

import math

from engine.kernels.geometry import (
    SIDE_OF_A,
    SIDE_OF_B,
    Box,
    Frame,
    Motion,
    Probe,
    centers_apart,
    half_diagonal,
    probe,
    relative_motion,
)
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel

DISTANCE_TOLERANCE = 1e-5
"""How far above the true minimum over a step the distance found may lie [m]."""
MAX_SPLITS = 256
"""Bound on the work of one search; reached only where the motion in a step is absurd."""


@kernel
def closest_in_step(a0: Box, a1: Box, b0: Box, b1: Box, best: float) -> tuple[float, float]:
    """Least distance [m] over the step and its fraction, if below `best`; else `(best, -1.0)`.

    The result is a distance that occurs, at most `DISTANCE_TOLERANCE` above the least one.
    """
    reach = best + half_diagonal(a0) + half_diagonal(b0)
    if centers_apart(a0, a1, b0, b1, reach * reach):
        return best, -1.0
    motion = relative_motion(a0, a1, b0, b1)
    start = probe(a0, b0, motion, 0.0)
    closing = start.nearest.x * motion.x + start.nearest.y * motion.y
    if start.nearest.distance + min(0.0, closing) - motion.swing >= best:
        return best, -1.0
    return _search_closest(a0, b0, motion, start, best)


@kernel
def _search_closest(a0: Box, b0: Box, motion: Motion, start: Probe, best: float) -> tuple[float, float]:
    """Sweep over the step: an interval that cannot hold a distance below `best` is passed, any other is split.

    Relative translation of convex bodies has a convex distance, so the planes at an interval's two ends bound it well
    and their crossing is where to look next; turning only adds the small bend.
    """
    end = probe(a0, b0, motion, 1.0)
    best, at = _better(end, *_better(start, best, -1.0))
    low, high = start, end
    for _ in range(MAX_SPLITS):
        bound, crossing = _lower_bound(a0, b0, motion, low, high)
        span = high.fraction - low.fraction
        if max(0.0, bound) < best - DISTANCE_TOLERANCE:
            high = probe(a0, b0, motion, low.fraction + crossing * span)
        elif high.fraction >= 1.0:
            break
        elif high.fraction + 3.0 * span >= 1.0:
            low, high = high, end
        else:
            low, high = high, probe(a0, b0, motion, high.fraction + 2.0 * span)
        best, at = _better(high, best, at)
    return best, at


@inlined
def _better(seen: Probe, best: float, at: float) -> tuple[float, float]:
    """The lesser of a distance seen and the best one, each with its fraction."""
    if seen.nearest.distance < best:
        return seen.nearest.distance, seen.fraction
    return best, at


@kernel
def _lower_bound(a0: Box, b0: Box, motion: Motion, low: Probe, high: Probe) -> tuple[float, float]:
    """Lower bound of the distance between two instants [m], and where in between (0..1) it is attained."""
    square = (high.fraction - low.fraction) ** 2
    slack_low = square * _bend(a0, b0, motion, low.nearest.owner) / 8.0
    slack_high = square * _bend(a0, b0, motion, high.nearest.owner) / 8.0
    falling_start, falling_end = low.nearest.distance - slack_low, _gap_later(low, high) - slack_low
    rising_start, rising_end = _gap_later(high, low) - slack_high, high.nearest.distance - slack_high
    left, right = falling_start - rising_start, rising_end - falling_end
    if falling_end >= falling_start or left <= 0.0:
        return min(falling_start, falling_end), 0.5
    if rising_end <= rising_start or right <= 0.0:
        return min(rising_start, rising_end), 0.5
    where = left / (left + right)
    return falling_start + (falling_end - falling_start) * where, min(0.9, max(0.1, where))


@inlined
def _bend(a0: Box, b0: Box, motion: Motion, owner: int) -> float:
    """Bound on the second derivative of the gap along a direction that turns with its owner [m per step^2]."""
    turn = _turn_of(motion, owner)
    way = turn * turn * motion.reach + 2.0 * abs(turn) * math.sqrt(motion.x * motion.x + motion.y * motion.y)
    return way + (motion.turn_a - turn) ** 2 * half_diagonal(a0) + (motion.turn_b - turn) ** 2 * half_diagonal(b0)


@inlined
def _turn_of(motion: Motion, owner: int) -> float:
    """How far the owner of a direction turns in the step [rad]; a direction between corners stands still."""
    if owner == SIDE_OF_A:
        return motion.turn_a
    return motion.turn_b if owner == SIDE_OF_B else 0.0


@inlined
def _gap_later(found: Probe, other: Probe) -> float:
    """Gap between the shadows at another instant, on the nearest direction of the first carried on by its owner [m]."""
    nearest = found.nearest
    if nearest.owner == SIDE_OF_A:
        x, y = _turned(nearest.x, nearest.y, found.a, other.a)
    elif nearest.owner == SIDE_OF_B:
        x, y = _turned(nearest.x, nearest.y, found.b, other.b)
    else:
        x, y = nearest.x, nearest.y
    a, b = other.a, other.b
    return (b.x - a.x) * x + (b.y - a.y) * y - _shadow(a, x, y) - _shadow(b, x, y)


@inlined
def _turned(x: float, y: float, before: Frame, after: Frame) -> tuple[float, float]:
    """A direction fixed to a frame, after that frame has turned."""
    along, across = before.cos * x + before.sin * y, before.cos * y - before.sin * x
    return after.cos * along - after.sin * across, after.sin * along + after.cos * across


@inlined
def _shadow(outline: Frame, x: float, y: float) -> float:
    """Half the length of an outline's shadow on a direction [m]."""
    along, across = outline.cos * x + outline.sin * y, outline.cos * y - outline.sin * x
    return outline.half_length * abs(along) + outline.half_width * abs(across)
