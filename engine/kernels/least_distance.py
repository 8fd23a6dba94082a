"""The least distance between the outlines of a pair over a run, and its first instant.

Both are searched in continuous time: within a step, outlines move as in `kernels.approach`.
"""

import math

from engine.kernels.approach import centers_apart, closest_in_step
from engine.kernels.geometry import box_distance, half_diagonal, outline_at, outline_between
from engine.kernels.jit import inlined, kernel
from engine.tables import Floats

SAME_DISTANCE = 1e-6
"""Distances that differ by less are equal [m]: rounding decides which of them is the least."""
ROUNDING = 1e-13
"""Distances [m] and parts of a step that differ by less differ by rounding."""
MAX_ROUNDS = 60
"""Maximum number of rounds of the search for the instant of MD; 5 to 15 are usual."""


@kernel
def least_distance(states: Floats, together: int, other: int, outlines: Floats, seed: int) -> tuple[float, float]:
    """Return MD over whole steps [m] and its time in steps. A good first value (at `seed`) lets nearly all steps be
    skipped.
    """
    first, second = outline_at(states, seed, 0, outlines), outline_at(states, seed, other, outlines)
    best, at = box_distance(first, second), float(seed)
    radii = half_diagonal(first) + half_diagonal(second)
    reach2 = (best + radii) ** 2
    for k in range(together - 1):
        a0, a1 = outline_at(states, k, 0, outlines), outline_at(states, k + 1, 0, outlines)
        b0, b1 = outline_at(states, k, other, outlines), outline_at(states, k + 1, other, outlines)
        if centers_apart(a0, a1, b0, b1, reach2):
            continue
        best, fraction = closest_in_step(a0, a1, b0, b1, best)
        if fraction >= 0.0:
            at, reach2 = k + fraction, (best + radii) ** 2
    return best, at


@kernel
def first_as_near(states: Floats, other: int, outlines: Floats, least: float, at: float) -> float:
    """Return the first instant at which the distance is at most MD + `SAME_DISTANCE`, in steps.

    The search goes back from `at`, an instant of MD: first over samples, then in the step before the first sample that
    is as near, so that a small change of the states changes the result little.
    """
    limit = least + SAME_DISTANCE
    radii = half_diagonal(outline_at(states, 0, 0, outlines)) + half_diagonal(outline_at(states, 0, other, outlines))
    reach2 = (limit + radii) ** 2  # centres farther apart than this: no need to look at the outlines
    for k in range(math.ceil(at)):
        ego, them = outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)
        x, y = them.x - ego.x, them.y - ego.y
        if x * x + y * y <= reach2 and box_distance(ego, them) <= limit:
            at = float(k)
            break
    if at == 0.0:
        return at
    before = math.ceil(at) - 1
    return before + _part_until(states, before, other, outlines, limit, at - before)


@kernel
def _part_until(states: Floats, k: int, other: int, outlines: Floats, limit: float, end: float) -> float:
    """Return the part of the step after sample k at which the distance falls to `limit` [m], by the Illinois method.

    The distance is larger at the sample, and at most `limit` at the part `end`. Source: Dowell and Jarratt (1971), "A
    modified regula falsi method for computing the root of an equation", BIT 11.
    """
    low, high = 0.0, end
    above = box_distance(outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)) - limit
    below = _distance_within(states, k, end, other, outlines) - limit
    side = 0
    for _ in range(MAX_ROUNDS):
        if high - low <= ROUNDING:
            break
        part = (low * below - high * above) / (below - above)
        excess = _distance_within(states, k, part, other, outlines) - limit
        if abs(excess) <= ROUNDING:
            return part
        if excess > 0.0:
            low, above = part, excess
            below = 0.5 * below if side > 0 else below
            side = 1
        else:
            high, below = part, excess
            above = 0.5 * above if side < 0 else above
            side = -1
    return high


@inlined
def _distance_within(states: Floats, k: int, part: float, other: int, outlines: Floats) -> float:
    """Return the distance between the outlines at a part of the step after sample k [m]."""
    ego = outline_between(states, k, k + 1, part, 0, outlines)
    return box_distance(ego, outline_between(states, k, k + 1, part, other, outlines))


@kernel
def least_in_ending(
    states: Floats, k: int, other: int, outlines: Floats, ending: float, best: float, at: float
) -> tuple[float, float]:
    """Return MD and its time, including the part `ending` of the step after sample k, in which a third actor was in
    contact.
    """
    a0, b0 = outline_at(states, k, 0, outlines), outline_at(states, k, other, outlines)
    a1 = outline_between(states, k, k + 1, ending, 0, outlines)
    b1 = outline_between(states, k, k + 1, ending, other, outlines)
    best, fraction = closest_in_step(a0, a1, b0, b1, best)
    return best, (k + fraction * ending if fraction >= 0.0 else at)
