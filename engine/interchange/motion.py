"""Motion that positions at given times show: rates, jumps that no road user makes, and headings.

Times need not be even; arrays are row-aligned with them. A recording has noise, and noise is not motion: a direction is
taken from a way that is long against the noise, and is NaN where there is no such way.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.interchange.contract import cited
from engine.portable import arctan2
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
"""A step whose velocity differs by more from those of the steps before and after is a jump [m/s]. No impact is one: the
velocity of the step in which it happens lies between the two."""

LEAST_JUMP = 0.5
"""A shorter way is no jump, however fast: times that are a microsecond apart are as inexact as that [m]."""

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
    found = steps > GAP * np.median(steps)
    return np.flatnonzero(found if breaks is None else found | breaks[:-1])


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


# -- jumps -------------------------------------------------------------------------------------------------------------


def usual_pace(time: Floats, positions: Floats) -> float:
    """Return the median speed over two steps [m/s]: leaps to and fro do not count."""
    stride = min(2, len(time) - 1)
    if stride < 1:
        return 0.0
    ways = np.hypot(*(positions[stride:] - positions[:-stride]).T)
    return float(np.median(ways / (time[stride:] - time[:-stride])))


def jumps_of(time: Floats, positions: Floats) -> Ints:
    """Return the samples after which an actor makes a step that no road user makes.

    The velocity of such a step is above `FASTEST`, and differs by more than `UNLIKE` from that of the step before or
    after; or it differs from all between these two, by a way of more than `FAR`. An actor whose usual pace is above
    `FASTEST` does not jump: its units are wrong.
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
        off = np.hypot(*(ways - nearest_between(before, after, ways)).T)  # 0 at both ends, which have one neighbour
        found |= (off > UNLIKE) & (off * steps > FAR)
    return np.flatnonzero(found)


def nearest_between(one: Floats, other: Floats, vector: Floats) -> Floats:
    """Return the vectors (rows, 2) from `one` to `other` that are nearest to `vector`."""
    span = other - one
    part = ((vector - one) * span).sum(axis=1) / np.maximum((span * span).sum(axis=1), 1e-12)
    return one + np.clip(part, 0.0, 1.0)[:, np.newaxis] * span


def without_jumps(time: Floats, positions: Floats) -> tuple[Bools, Bools, Ints]:
    """Return the samples to keep, after which of those a jump follows (both (samples,)), and the jumps (`jumps_of`).

    At one sample at least between the two sides of a jump the actor is absent, so that no host moves it across: a
    sample between two jumps is left out, and else the first after the jump.
    """
    jumps = jumps_of(time, positions)
    kept, breaks = np.ones(len(time), np.bool_), np.zeros(len(time), np.bool_)
    edges = [0, *(jumps + 1).tolist(), len(time)]
    last = -1
    for begin, end in pairwise(edges):
        if len(jumps) and end - begin == 1:
            kept[begin] = False
            continue
        if last >= 0:
            breaks[last] = True
            kept[begin] = last < begin - 1
        last = end - 1
    return kept, breaks, jumps


def jump_remark(name: str, time: Floats, positions: Floats, jumps: Ints) -> str:
    """Return what is to be said of jumps (`jumps_of`); "" without any."""
    if not len(jumps):
        return ""
    first = int(jumps[0])
    way = math.hypot(*(positions[first + 1] - positions[first]))
    times = "" if len(jumps) == 1 else f" {len(jumps):,} times, first"
    step, when = time[first + 1] - time[first], time[first]
    return f"{cited(name)} jumps{times} {way:.1f} m in {step:.3g} s, at {when:.6g} s: that is a gap in its track"


# -- headings of motion ------------------------------------------------------------------------------------------------

EXACT = 0.01
"""Least way from which a direction is taken [m]."""
TIMES_NOISE = 150.0
"""And least way in standard deviations of the noise: the direction of two such ways is known to 0.3 degrees."""
MOST = 0.97
"""No longer way than this is asked for, which a turn would bend [m]."""
CERTAIN = 10.0
"""A way of so many standard deviations is no noise."""
SHORT, STRAIGHT = 0.5, 0.8
"""A way shorter than `FAR` shows a direction if its ends are that far apart [m], and this share of its length."""
FEWEST = 5
"""Samples that show noise."""
MEDIAN_2D = math.sqrt(2.0 * math.log(2.0))
"""Median length of a vector whose two coordinates are normal of deviation 1."""


def noise_of(time: Floats, positions: Floats) -> float:
    """Return the standard deviation of a coordinate of one piece [m]; 1 mm of fewer than `FEWEST` samples.

    Each sample is compared with the cubic through the two before and the two after it, which motion follows; the median
    of the differences is not moved by single errors.
    """
    if len(time) < FEWEST:
        return 1e-3
    weights = np.ones((len(time) - 4, 4))
    at, around = time[2:-2], [time[shift : len(time) - 4 + shift] for shift in (0, 1, 3, 4)]
    for one, own in enumerate(around):
        for other in (each for number, each in enumerate(around) if number != one):
            weights[:, one] *= (at - other) / (own - other)
    foreseen = sum(
        weights[:, [one]] * positions[shift : len(time) - 4 + shift] for one, shift in enumerate((0, 1, 3, 4))
    )
    off = np.hypot(*(positions[2:-2] - foreseen).T) / np.sqrt(1.0 + (weights**2).sum(axis=1))
    return float(np.median(off)) / MEDIAN_2D


def motion_headings(motion: Motion, velocity: Floats | None = None, *, on_foot: bool = False) -> Floats:
    """Return the directions of motion (samples,), not wrapped, kept at standstill; NaN where no motion shows one.

    `velocity` (samples, 2): shows the directions in each piece in which it is once faster than `MOVING`. Who is not on
    foot keeps its front when it drives backwards: the front points where most of its way leads.
    """
    heading = np.full(len(motion.time), math.nan)
    for own in _slices(motion.pieces):
        vectors = np.zeros((1, 2)) if velocity is None else velocity[own]
        moving = np.flatnonzero(np.hypot(*vectors.T) > MOVING)
        if len(moving):
            last = np.maximum(np.searchsorted(moving, np.arange(len(vectors)), "right") - 1, 0)
            heading[own] = _oriented(vectors[moving], on_foot)[last]
        else:
            heading[own] = _piece_headings(motion.time[own], motion.positions[own], on_foot)
    return _carried(heading, motion.positions, motion.pieces)


def _slices(pieces: Ints) -> list[slice]:
    edges = [0, *(np.flatnonzero(np.diff(pieces)) + 1).tolist(), len(pieces)]
    return [slice(begin, end) for begin, end in pairwise(edges)]


def _piece_headings(time: Floats, positions: Floats, on_foot: bool) -> Floats:
    marks = marks_of(time, positions)
    if len(marks) < 2:
        return np.full(len(time), math.nan)
    legs = np.diff(positions[marks], axis=0)
    turned_back = (legs[:-1] * legs[1:]).sum(axis=1) < 0.0  # the sum of two such legs has any direction
    inner = np.where(turned_back[:, np.newaxis], legs[:-1], legs[:-1] + legs[1:])
    heading = _oriented(np.vstack([legs[:1], inner, legs[-1:]]), on_foot)
    leg = np.minimum(np.searchsorted(marks, np.arange(len(time)), "right") - 1, len(legs) - 1)
    way = ((positions - positions[marks[leg]]) * legs[leg]).sum(axis=1) / (legs[leg] ** 2).sum(axis=1)
    return heading[leg] + np.clip(way, 0.0, 1.0) * (heading[leg + 1] - heading[leg])


def marks_of(time: Floats, positions: Floats, far: float = FAR) -> Ints:
    """Return the samples of one piece between which it moves: the way from each to the next is long against the noise.

    The first sample is one. It is the only one of a piece that leads no farther than `far` [m], unless its way is
    straight, or is once fast and does not end where it began: a measured place that drifts does neither.
    """
    noise = noise_of(time, positions)
    spacing = min(max(EXACT, TIMES_NOISE * noise), MOST)
    found, least = [0], spacing * spacing
    (at_x, at_y), rows = positions[0].tolist(), positions.tolist()
    for sample, (x, y) in enumerate(rows):
        if (x - at_x) ** 2 + (y - at_y) ** 2 >= least:
            found.append(sample)
            at_x, at_y = x, y
    marks = np.array(found)
    return marks if len(marks) > 1 and _moves(time, positions, marks, noise, far) else marks[:1]


def _moves(time: Floats, positions: Floats, marks: Ints, noise: float, far: float) -> bool:
    away = np.hypot(*(positions - positions[0]).T)
    if max(away[-1], np.minimum(away[1:], away[:-1]).max()) >= far:  # a single sample may be wrong
        return True
    legs = np.hypot(*np.diff(positions[marks], axis=0).T)
    steady = len(legs) > 1 and away[-1] >= max(SHORT, STRAIGHT * float(legs.sum()))
    fast = away[-1] >= CERTAIN * noise and (legs / np.diff(time[marks])).max() >= MOVING
    return bool(steady or fast)


def _oriented(vectors: Floats, on_foot: bool) -> Floats:
    """Return directions of vectors (rows, 2), not wrapped: of a vehicle those of its front, which never turns about."""
    angles = arctan2(vectors[:, 1], vectors[:, 0])
    if on_foot:
        return np.unwrap(angles)
    heading = np.unwrap(angles, period=math.pi)
    forwards = float((vectors * along(heading)).sum())
    return heading if forwards >= 0.0 else heading + math.pi


def _carried(heading: Floats, positions: Floats, pieces: Ints) -> Floats:
    """Return headings with those of the neighbouring piece where a piece shows none, and lies where that one ends."""
    own = _slices(pieces)
    for order, edge, other in ((own, 0, -1), (own[::-1], -1, 0)):
        for piece, neighbour in zip(order[1:], order[:-1], strict=True):
            near = np.hypot(*(positions[piece][edge] - positions[neighbour][other])) < FAR
            if near and np.isnan(heading[piece]).all():
                heading[piece] = heading[neighbour][other]
    known = ~np.isnan(heading)
    heading[known] = np.unwrap(heading[known])
    return heading
