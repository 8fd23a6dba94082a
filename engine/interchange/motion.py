"""Motion that positions at given times show: its rates, and jumps that no road user makes.

Times need not be even; arrays are row-aligned with them.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from engine.errors import cited
from engine.tables import Bools, Floats, Ints

FASTEST = 150.0
"""No road user moves faster [m/s]."""
GAP = 5.0
"""An actor without a row for longer than this number of its usual steps is absent."""
MOVING = 1.0
"""A slower motion shows no direction, unless it leads farther than `FAR` [m/s]."""
FAR = 2.0
"""An actor that stays within this distance shows no direction, unless it is faster than `MOVING` or straight [m]."""
UNLIKE = 30.0
"""Least difference [m/s] between the velocity of a jump and those of the steps before and after. An impact is not a
jump: the velocity of its step is between the two.
"""
THERE_AND_BACK = 100.0
"""Rate of change of velocity [m/s^2], in one step and back in the next, that no road user reaches: a jump, if it leads
farther than `ASIDE`. Tyres give a tenth of that.
"""
ASIDE = 1.8
"""Width of a car [m]: errors of measurement and coarse polylines lead less far."""

LEAST_JUMP = 0.5
"""A shorter way is no jump, however fast: times that are a microsecond apart are as inexact as that [m]."""
LONGEST_STEP = 2.0
"""Rows that are further apart do not show the way between them [s]: who turns or brakes at 4 m/s^2 in the meantime is
a car's width off the straight way (a t^2 / 8)."""

# -- pieces, rates, directions -----------------------------------------------------------------------------------------


def rates(time: Floats, values: Floats, pieces: Ints | None = None) -> Floats:
    """Return the rate of change (samples, …): central differences, one-sided at both ends of a piece, 0 of one sample.

    `pieces` (samples,): see `pieces_of`; None: all samples are of one piece. The rate of unwrapped headings is the yaw
    rate that `engine.kernels.pair.center_velocity` takes.
    """
    if len(time) < 2:
        return np.zeros_like(values)
    before = np.maximum(np.arange(len(time)) - 1, 0)
    after = np.minimum(np.arange(len(time)) + 1, len(time) - 1)
    if pieces is not None:
        here = np.arange(len(time))
        before, after = (np.where(pieces[each] == pieces, each, here) for each in (before, after))
    span = (time[after] - time[before]).reshape(-1, *([1] * (values.ndim - 1)))
    return (values[after] - values[before]) / np.where(span > 0.0, span, 1.0)


def along(heading: Floats) -> Floats:
    """Return unit vectors ahead (samples, 2)."""
    return np.column_stack([np.cos(heading), np.sin(heading)])


def across(heading: Floats) -> Floats:
    """Return unit vectors to the left (samples, 2)."""
    return np.column_stack([-np.sin(heading), np.cos(heading)])


def gaps_between(time: Floats, breaks: Bools | None = None) -> Ints:
    """Return the samples after which an actor is absent for a while; `breaks` (samples,): see `without_jumps`."""
    steps = np.diff(time)
    if not len(steps):
        return np.zeros(0, np.int64)
    usual = np.sort(steps)[(len(steps) - 1) // 2]  # the shorter of two steps: the longer may be a gap
    found = steps > GAP * usual
    return np.flatnonzero(found if breaks is None else found | breaks[:-1])


def unseen_steps(time: Floats, positions: Floats) -> Bools:
    """Return the steps (samples - 1,) that are longer than `LONGEST_STEP` and lead elsewhere."""
    return (np.diff(time) > LONGEST_STEP) & (np.hypot(*np.diff(positions, axis=0).T) > LEAST_JUMP)


def pieces_of(time: Floats, breaks: Bools | None = None) -> Ints:
    """Return the number of the piece of each sample (samples,): motion does not lead from one piece to the next."""
    begins = np.zeros(len(time), np.int64)
    begins[gaps_between(time, breaks) + 1] = 1
    return np.cumsum(begins)


@dataclass(frozen=True)
class Motion:
    """Positions of one actor at given times."""

    time: Floats
    """(samples,) ascending [s]."""
    positions: Floats
    """(samples, 2) [m]"""
    pieces: Ints
    """(samples,) See `pieces_of`."""

    def rates(self, values: Floats) -> Floats:
        """Return the rate of change of values (samples, …) within each piece."""
        return rates(self.time, values, self.pieces)

    @cached_property
    def velocity(self) -> Floats:
        """Return the rate of change of the positions (samples, 2) [m/s]."""
        return self.rates(self.positions)


# -- jumps -------------------------------------------------------------------------------------------------------------


def usual_pace(time: Floats, positions: Floats) -> float:
    """Return the median speed over two steps [m/s]: leaps to and fro do not count."""
    stride = min(2, len(time) - 1)
    if stride < 1:
        return 0.0
    ways = np.hypot(*(positions[stride:] - positions[:-stride]).T)
    return float(np.median(ways / (time[stride:] - time[:-stride])))


def jumps_of(time: Floats, positions: Floats) -> Ints:
    """Return the samples after which an actor makes a physically impossible step.

    The velocity of such a step is above `FASTEST`, and differs by more than `UNLIKE` from that of the step before or
    after; or it differs from every velocity between these two by more than `UNLIKE` or at a rate of more than
    `THERE_AND_BACK`, and by a way of more than `ASIDE`. An actor whose usual pace is above `FASTEST` does not jump: its
    units are wrong.
    """
    steps = np.diff(time)
    if not len(steps) or usual_pace(time, positions) > FASTEST:
        return np.zeros(0, np.int64)
    ways = np.diff(positions, axis=0) / steps[:, np.newaxis]
    before, after = np.vstack([ways[:1], ways[:-1]]), np.vstack([ways[1:], ways[-1:]])
    change = np.maximum(np.hypot(*(ways - before).T), np.hypot(*(ways - after).T))
    speed = np.hypot(*ways.T)
    found = (speed > FASTEST) & (change > UNLIKE) & (speed * steps > LEAST_JUMP)
    if len(steps) > 2:
        off = np.hypot(*(ways - nearest_between(before, after, ways)).T)  # 0 at both ends, with one neighbour
        found |= (off > np.minimum(UNLIKE, THERE_AND_BACK * steps)) & (off * steps > ASIDE)
    return np.flatnonzero(found)


def nearest_between(one: Floats, other: Floats, vector: Floats) -> Floats:
    """Return the vectors (rows, 2) from `one` to `other` that are nearest to `vector`."""
    span = other - one
    part = ((vector - one) * span).sum(axis=1) / np.maximum((span * span).sum(axis=1), 1e-12)
    return one + np.clip(part, 0.0, 1.0)[:, np.newaxis] * span


def without_jumps(time: Floats, positions: Floats) -> tuple[Bools, Bools, Ints]:
    """Return masks (samples,) of the samples to keep and of those before a jump or an unseen step, and the jumps
    (`jumps_of`).

    At one sample at least between the two sides of a jump the actor is absent, so that no host moves it across: a
    sample between two jumps is left out, and else the first after the jump.
    """
    jumps = jumps_of(time, positions)
    remaining, breaks = np.ones(len(time), np.bool_), np.zeros(len(time), np.bool_)
    edges = [0, *(jumps + 1).tolist(), len(time)]
    last = -1
    for begin, end in pairwise(edges):
        if len(jumps) and end - begin == 1:
            remaining[begin] = False
            continue
        if last >= 0:
            breaks[last] = True
            remaining[begin] = last < begin - 1
        last = end - 1
    breaks[:-1] |= unseen_steps(time, positions)
    return remaining, breaks, jumps


def jump_remark(name: str, time: Floats, positions: Floats, jumps: Ints) -> str:
    """Return the remark on jumps (`jumps_of`); "" without any."""
    if not len(jumps):
        return ""
    first = int(jumps[0])
    way = math.hypot(*(positions[first + 1] - positions[first]))
    times = "" if len(jumps) == 1 else f" {len(jumps):,} times, first"
    step, when = time[first + 1] - time[first], time[first]
    return f"{cited(name)} jumps{times} {way:.1f} m in {step:.3g} s, at {when:.6g} s: that is a gap in its track"
