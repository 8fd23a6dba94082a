"""Distance and contact of two outlines over the continuous motion of a step.

Within a step, centres and headings move linearly, each heading by the shortest turn. Two facts carry the search for
first contact. For any unit vector n, the gap between the projections of two outlines on n never exceeds their distance;
and a turn by w about its centre moves the edge of a projection by at most |w| r, r = half diagonal. Source:
conservative advancement (Mirtich 1996, "Impulse-based dynamic simulation of rigid body systems", section 2.3), with the
motion bound taken along the direction of the nearest points.

The closest approach is searched only if it can be less than the best one so far. While a unit vector n turns at a
steady rate u, the gap between two outlines' projections on n is at least the chord between its end values less the
bound of its second derivative / 8: in axes that turn with n, the vector p + v t between the centres has a second
derivative of at most u^2 |p| + 2 |u| |v|, and a corner at r from a centre with turn rate w one of at most (w - u)^2 r.
If n turns with the side to which it is normal, this bound is tight for a side that faces a corner.
"""

import math
from typing import NamedTuple

from engine.kernels.geometry import (
    SIDE_OF_A,
    SIDE_OF_B,
    Box,
    Frame,
    Nearest,
    box_distance,
    half_diagonal,
    nearest_points,
    outline_at,
    shortest_turn,
)
from engine.kernels.jit import inlined, kernel
from engine.tables import Floats
from engine.vocabulary import State

TOUCH = 1e-4
"""Outlines nearer than this are in contact [m]."""
FRACTION_AT_START = 1e-9
"""Reported where outlines touch already at the start of a step: contact belongs to (0, 1]."""
MAX_ADVANCES = 4096
"""Maximum number of advances; after as many, the gap was on average below 1/4096 of the motion of a step (1 mm of 4 m),
which counts as contact.
"""
DISTANCE_TOLERANCE = 1e-8
"""Largest excess of the minimum that the search of a whole step returns [m]. Two steps whose least distances differ by
less are equal: either may be returned.
"""
REFINED_TOLERANCE = 1e-12
"""Largest excess after the search around that minimum [m]. The instant of MD is that of a distance slightly above MD
(`kernels.pair`): its error is that of MD divided by the closing speed, which may be as low as 1e-4 m/s there.
"""
REFINED_WINDOW = 0.1
"""Part of the step before and after the minimum that is searched again."""
MAX_SPLITS = 256
"""Maximum number of splits of one search; reached only if the motion in a step is absurd."""


class Motion(NamedTuple):
    """Motion of a pair in a step: outlines at the start, displacement of b relative to a [m], both turns [rad], and
    the bounds that follow.
    """

    a: Box
    b: Box
    x: float
    y: float
    turn_a: float
    turn_b: float
    swing: float
    """|turn_a| r_a + |turn_b| r_b: the most that turning can bring the outlines nearer [m]."""
    reach: float
    """The largest distance between the centres [m]."""


class Probe(NamedTuple):
    """The pair at an instant of a step (`fraction`): both frames and their nearest points."""

    fraction: float
    a: Frame
    b: Frame
    nearest: Nearest


@kernel
def first_contact(a0: Box, a1: Box, b0: Box, b1: Box) -> float:
    """Return the fraction in (0, 1] of the step at which the outlines first come within `TOUCH`; else -1.0."""
    if circles_apart(a0, a1, b0, b1):
        return -1.0
    return _advance_to_contact(a0, a1, b0, b1)


@inlined
def circles_apart(a0: Box, a1: Box, b0: Box, b1: Box) -> bool:
    """Return True if the circumscribed circles stay apart during the step: a cheap test that nearly always answers.

    (r1 + r2)^2 is replaced by its bound 2 (r1^2 + r2^2), exact for equal outlines, which avoids a square root.
    """
    return centers_apart(a0, a1, b0, b1, 0.5 * (a0.length**2 + a0.width**2 + b0.length**2 + b0.width**2))


@inlined
def centers_apart(a0: Box, a1: Box, b0: Box, b1: Box, reach2: float) -> bool:
    """Return True if the squared distance between the centres exceeds `reach2` throughout the step."""
    x0, y0 = b0.x - a0.x, b0.y - a0.y
    x1, y1 = b1.x - a1.x, b1.y - a1.y
    way_x, way_y = x1 - x0, y1 - y0
    if x0 * way_x + y0 * way_y >= 0.0:  # moving apart: nearest at the start
        return x0 * x0 + y0 * y0 > reach2
    if x1 * way_x + y1 * way_y <= 0.0:  # still approaching: nearest at the end
        return x1 * x1 + y1 * y1 > reach2
    cross = x0 * way_y - y0 * way_x
    return cross * cross > reach2 * (way_x * way_x + way_y * way_y)


@inlined
def relative_motion(a0: Box, a1: Box, b0: Box, b1: Box) -> Motion:
    """Return the motion of the pair over the step."""
    turn_a, turn_b = shortest_turn(a0.heading, a1.heading), shortest_turn(b0.heading, b1.heading)
    radius_a, radius_b = half_diagonal(a0), half_diagonal(b0)
    return Motion(
        a0,
        b0,
        (b1.x - b0.x) - (a1.x - a0.x),
        (b1.y - b0.y) - (a1.y - a0.y),
        turn_a,
        turn_b,
        abs(turn_a) * radius_a + abs(turn_b) * radius_b,
        math.sqrt(max((b0.x - a0.x) ** 2 + (b0.y - a0.y) ** 2, (b1.x - a1.x) ** 2 + (b1.y - a1.y) ** 2)),
    )


@inlined
def _moved(box: Box, x: float, y: float, turn: float) -> Frame:
    """Return the box's frame after a shift [m] and a turn [rad]."""
    heading = box.heading + turn
    return Frame(box.x + x, box.y + y, math.cos(heading), math.sin(heading), 0.5 * box.length, 0.5 * box.width)


@kernel
def probe(motion: Motion, fraction: float) -> Probe:
    """Return the pair at a fraction of the step, in axes that move with a's centre."""
    a = _moved(motion.a, 0.0, 0.0, fraction * motion.turn_a)
    b = _moved(motion.b, fraction * motion.x, fraction * motion.y, fraction * motion.turn_b)
    return Probe(fraction, a, b, nearest_points(a, b))


@kernel
def _advance_to_contact(a0: Box, a1: Box, b0: Box, b1: Box) -> float:
    """Return the fraction of first contact, or -1.0, by conservative advancement.

    Each advance adds distance / (approach along the nearest direction + swing), until the distance is below `TOUCH`.
    """
    motion = relative_motion(a0, a1, b0, b1)
    fraction = 0.0
    for _ in range(MAX_ADVANCES):
        nearest = probe(motion, fraction).nearest
        if nearest.distance < TOUCH:
            return max(fraction, FRACTION_AT_START)
        rate = max(0.0, -(nearest.x * motion.x + nearest.y * motion.y)) + motion.swing
        # Written so that zero motion, infinity and NaN all end the search.
        if not nearest.distance <= rate * (1.0 - fraction):
            return -1.0
        fraction = min(1.0, fraction + nearest.distance / rate)
    return fraction


# -- the closest approach ----------------------------------------------------------------------------------------------


@kernel
def closest_in_step(a0: Box, a1: Box, b0: Box, b1: Box, best: float) -> tuple[float, float]:
    """Return the least distance [m] over the step and its fraction, if below `best`; else `(best, -1.0)`.

    The result is a distance that occurs, at most `DISTANCE_TOLERANCE` above the least. Inside the step it is at most
    `REFINED_TOLERANCE` above the least distance around it.
    """
    reach = best + half_diagonal(a0) + half_diagonal(b0)
    if centers_apart(a0, a1, b0, b1, reach * reach):
        return best, -1.0
    motion = relative_motion(a0, a1, b0, b1)
    start = probe(motion, 0.0)
    closing = start.nearest.x * motion.x + start.nearest.y * motion.y
    if start.nearest.distance + min(0.0, closing) - motion.swing >= best:
        return best, -1.0
    return _search_closest(motion, start, best)


@kernel
def _search_closest(motion: Motion, start: Probe, best: float) -> tuple[float, float]:
    """Search the step, then the neighbourhood of the minimum with a smaller tolerance."""
    end = probe(motion, 1.0)
    best, at = _better(end, *_better(start, best, -1.0))
    best, at = _sweep(motion, start, end, best, at, DISTANCE_TOLERANCE)
    if at <= 0.0 or at >= 1.0:
        return best, at
    start = probe(motion, max(0.0, at - REFINED_WINDOW))
    end = probe(motion, min(1.0, at + REFINED_WINDOW))
    return _sweep(motion, start, end, best, at, REFINED_TOLERANCE)


@kernel
def _sweep(motion: Motion, start: Probe, end: Probe, best: float, at: float, tolerance: float) -> tuple[float, float]:
    """Search an interval: skip a part that cannot contain a distance below `best`, split any other.

    Relative translation of convex bodies has a convex distance, so the planes at both ends of an interval bound it
    well, and the next sample is taken at their intersection; turning only adds the small second derivative.
    """
    low, high = start, end
    for _ in range(MAX_SPLITS):
        bound, crossing = _lower_bound(motion, low, high)
        span = high.fraction - low.fraction
        if max(0.0, bound) < best - tolerance:
            high = probe(motion, low.fraction + crossing * span)
        elif high.fraction >= end.fraction:
            break
        elif high.fraction + 3.0 * span >= end.fraction:
            low, high = high, end
        else:
            low, high = high, probe(motion, high.fraction + 2.0 * span)
        best, at = _better(high, best, at)
    return best, at


@inlined
def _better(seen: Probe, best: float, at: float) -> tuple[float, float]:
    """Return the lesser of a computed distance and the best one, with its fraction."""
    if seen.nearest.distance < best:
        return seen.nearest.distance, seen.fraction
    return best, at


@kernel
def _lower_bound(motion: Motion, low: Probe, high: Probe) -> tuple[float, float]:
    """Return a lower bound of the distance between two instants [m], and its fraction in between (0..1)."""
    square = (high.fraction - low.fraction) ** 2
    slack_low = square * _bend(motion, low.nearest.owner) / 8.0
    slack_high = square * _bend(motion, high.nearest.owner) / 8.0
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
def _bend(motion: Motion, owner: int) -> float:
    """Return the bound on the second derivative of the gap along a direction fixed to its owner [m per step^2]."""
    turn = _turn_of(motion, owner)
    way = turn * turn * motion.reach + 2.0 * abs(turn) * math.sqrt(motion.x * motion.x + motion.y * motion.y)
    return (
        way
        + (motion.turn_a - turn) ** 2 * half_diagonal(motion.a)
        + (motion.turn_b - turn) ** 2 * half_diagonal(motion.b)
    )


@inlined
def _turn_of(motion: Motion, owner: int) -> float:
    """Return the turn of a direction's owner in the step [rad]; 0 for a direction between corners."""
    if owner == SIDE_OF_A:
        return motion.turn_a
    return motion.turn_b if owner == SIDE_OF_B else 0.0


@inlined
def _gap_later(found: Probe, other: Probe) -> float:
    """Return the gap between the projections at another instant, on the nearest direction turned with its owner [m]."""
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
    """Return a direction fixed to a frame, after that frame has turned."""
    along, across = before.cos * x + before.sin * y, before.cos * y - before.sin * x
    return after.cos * along - after.sin * across, after.sin * along + after.cos * across


@inlined
def _shadow(outline: Frame, x: float, y: float) -> float:
    """Return half the length of an outline's projection on a direction [m]."""
    along, across = outline.cos * x + outline.sin * y, outline.cos * y - outline.sin * x
    return outline.half_length * abs(along) + outline.half_width * abs(across)


# -- First contact of any two in a recording: between samples all actors move linearly ---------------------------------


class Touch(NamedTuple):
    """First contact of two actors, at `part` (0 .. 1) of the step after sample `sample`; sample -1: no contact."""

    sample: int
    part: float
    one: int
    other: int


def search_contact(states: Floats, outlines: Floats) -> Touch:
    """Return the first contact of any two actors; of simultaneous contacts, the lower pair."""
    return search_contact_of(states, outlines, 0, states.shape[1])


@kernel
def search_contact_of(states: Floats, outlines: Floats, low: int, high: int) -> Touch:
    """Return the first contact of an actor from `low` to `high` (exclusive) with a later one; of equals, the lower
    pair.

    `states` (samples, actors, len(State)) with headings that are not wrapped, at times that need not be evenly spaced;
    `outlines` (actors, at least 2): length, width [m]. Two actors present together at a single sample, or at the last,
    are in contact if they touch at it.
    """
    samples, actors = states.shape[0], states.shape[1]
    for k in range(samples):
        first, first_one, first_other = 2.0, -1, -1
        for one in range(low, high):
            if states[k, one, State.PRESENT] == 0.0:
                continue
            for other in range(one + 1, actors):
                if states[k, other, State.PRESENT] == 0.0:
                    continue
                part = _part_until_contact(states, samples, k, one, other, outlines)
                if 0.0 <= part < first:
                    first, first_one, first_other = part, one, other
        if first_one >= 0:
            return Touch(k, first if first > FRACTION_AT_START else 0.0, first_one, first_other)
    return Touch(-1, 0.0, -1, -1)


@inlined
def _part_until_contact(states: Floats, samples: int, k: int, one: int, other: int, outlines: Floats) -> float:
    """Return the fraction of the step to the next sample at first contact; -1.0 if there is none."""
    a0, b0 = outline_at(states, k, one, outlines), outline_at(states, k, other, outlines)
    after = min(k + 1, samples - 1)
    if after == k or states[after, one, State.PRESENT] == 0.0 or states[after, other, State.PRESENT] == 0.0:
        return 0.0 if box_distance(a0, b0) < TOUCH else -1.0
    return first_contact(a0, outline_at(states, after, one, outlines), b0, outline_at(states, after, other, outlines))
