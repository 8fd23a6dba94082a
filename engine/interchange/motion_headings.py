"""Headings that motion shows, for recordings that do not state them.

A recording has noise, and noise is not motion: a direction is taken from a way that is long against the noise, and is
NaN where there is no such way. Arrays are row-aligned with the times.
"""

import math
from itertools import pairwise

import numpy as np

from engine.interchange.motion import FAR, MOVING, Motion, along
from engine.portable import arctan2
from engine.tables import Floats, Ints

EXACT = 0.01
"""Least way from which a direction is taken [m]."""
TIMES_NOISE = 150.0
"""Least way in standard deviations of the noise: the direction between its ends is accurate to 0.3 degrees."""
MOST = 0.97
"""Upper limit of the least way [m]: a turn would bend a longer way."""
CERTAIN = 10.0
"""Way, in standard deviations of the noise, from which on it is motion."""
SHORT, STRAIGHT = 0.5, 0.8
"""A way shorter than `FAR` shows a direction if its ends are that far apart [m], and this share of its length."""
FEWEST = 5
"""Samples that show noise."""
IMPACT, HARDEST = 1.0, 15.0
"""Limits of a driver's change of velocity: a constant [m/s], and a rate for the time that passes [m/s^2]."""
CUT = 0.6
"""Share of the previous leg's length below which a leg counts as cut short."""
MEDIAN_2D = math.sqrt(2.0 * math.log(2.0))
"""Median length of a vector with two normal coordinates of deviation 1."""


def noise_of(time: Floats, positions: Floats) -> float:
    """Return the standard deviation of a coordinate of one piece [m]; 1 mm of fewer than `FEWEST` samples.

    Each sample is compared with the cubic through the two before and the two after it, which motion follows; the median
    of the differences is robust against single errors.
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


def motion_headings(
    motion: Motion, velocity: Floats | None = None, *, lag: float = 0.0, on_foot: bool = False
) -> Floats:
    """Return the headings that motion shows (samples,), not wrapped, constant at standstill; NaN where it shows none.

    `velocity` (samples, 2): shows the directions in each piece in which it is once faster than `MOVING`. `lag`:
    distance of the positions ahead of the rear axle [m]. The front of a vehicle stays in place when it drives
    backwards: it points along most of the way.
    """
    heading = np.full(len(motion.time), math.nan)
    for own in _slices(motion.pieces):
        vectors = np.zeros((1, 2)) if velocity is None else velocity[own]
        moving = np.flatnonzero(np.hypot(*vectors.T) > MOVING)
        if len(moving):
            last = np.maximum(np.searchsorted(moving, np.arange(len(vectors)), "right") - 1, 0)
            heading[own] = _velocity_headings(motion.time[own][moving], vectors[moving], lag, on_foot)[last]
        else:
            heading[own] = _piece_headings(motion.time[own], motion.positions[own], lag, on_foot)
    return _carried(heading, motion.positions, motion.pieces)


def _slices(pieces: Ints) -> list[slice]:
    edges = [0, *(np.flatnonzero(np.diff(pieces)) + 1).tolist(), len(pieces)]
    return [slice(begin, end) for begin, end in pairwise(edges)]


def _piece_headings(time: Floats, positions: Floats, lag: float, on_foot: bool) -> Floats:
    marks = marks_of(time, positions)
    if len(marks) < 2:
        return np.full(len(time), math.nan)
    legs, spans = np.diff(positions[marks], axis=0), np.diff(time[marks])
    heading = _lagging(legs / spans[:, np.newaxis], spans, lag, on_foot)
    leg = np.minimum(np.searchsorted(marks, np.arange(len(time)), "right") - 1, len(legs) - 1)
    way = ((positions - positions[marks[leg]]) * legs[leg]).sum(axis=1) / (legs[leg] ** 2).sum(axis=1)
    return heading[leg] + np.clip(way, 0.0, 1.0) * (heading[leg + 1] - heading[leg])


def marks_of(time: Floats, positions: Floats, far: float = FAR) -> Ints:
    """Return the samples of one piece between which it moves: the way from each to the next is long against the noise.

    The first sample is one. It is the only mark of a piece that leads no farther than `far` [m], unless the way is
    straight, or is once fast and does not return to its start: drift of a measured place does neither.
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


def _velocity_headings(time: Floats, velocity: Floats, lag: float, on_foot: bool) -> Floats:
    if len(time) < 2:
        return _front(velocity, on_foot)[0]
    return _lagging((velocity[1:] + velocity[:-1]) / 2.0, np.diff(time), lag, on_foot)


def _lagging(velocity: Floats, spans: Floats, lag: float, on_foot: bool) -> Floats:
    """Return the headings (legs + 1,) between legs of constant `velocity` (legs, 2) and duration `spans` [s].

    The velocity is that of a point `lag` [m] ahead of the rear axle, which follows it as a trailer does: the heading h
    obeys dh/ds = sin(direction - h) / lag, and its initial value decays within the length `lag`. Driving backwards is
    driving forwards in reversed time. An impact changes the direction at once, not the heading.
    """
    legs = velocity * spans[:, np.newaxis]
    direction, gear = _front(legs, on_foot)
    ways = np.maximum(np.hypot(*legs.T), 1e-9)
    hit = np.hypot(*np.diff(velocity, axis=0).T) > IMPACT + HARDEST * np.maximum(spans[1:], spans[:-1])
    runs = [0, *(np.flatnonzero((np.diff(gear) != 0) | hit) + 1).tolist(), len(ways)]
    heading = np.zeros(len(ways) + 1)
    for begin, end in pairwise(runs):
        first = float(heading[begin]) if begin else math.nan
        if gear[begin] > 0:
            found = _run_headings(direction[begin:end], ways[begin:end], lag, first)
        else:
            found = _run_headings(direction[begin:end][::-1], ways[begin:end][::-1], lag, math.nan)[::-1]
        heading[begin + 1 : end + 1] = found[1:]
        heading[begin] = found[0] if begin == 0 else heading[begin]
    return heading


def _run_headings(middle: Floats, ways: Floats, lag: float, first: float) -> Floats:
    """Return the headings (legs + 1,) of legs that are driven forwards, from that at `first`, NaN of a steady turn.

    A leg is an arc; `middle` (legs,) is its direction in the middle. On each arc the heading tends to the steady one of
    `_lagging` as if its equation were linear. A last leg that is cut short, as by an impact, bends as the two before.
    """
    if len(ways) > 2 and ways[-1] < CUT * ways[-2]:
        bend = 2.0 * (middle[-2] - middle[-3]) / (ways[-2] + ways[-3])
        middle = np.append(middle[:-1], middle[-2] + bend * (ways[-2] + ways[-1]) / 2.0)
    inner = middle[:-1] + np.diff(middle) * ways[:-1] / (ways[1:] + ways[:-1])
    ends = (2.0 * middle[0] - inner[0], 2.0 * middle[-1] - inner[-1]) if len(inner) else (middle[0], middle[0])
    direction = np.concatenate([ends[:1], inner, ends[1:]])
    if lag <= 0.0:
        return direction
    steady = np.arcsin(np.clip(np.diff(direction) / ways * lag, -1.0, 1.0)).tolist()
    first = _first_heading(middle, ways, lag) if math.isnan(first) else first
    off = first - float(direction[0]) + steady[0]
    found = [off - steady[0]]
    for number, left in enumerate(np.exp(-ways / lag).tolist()):
        off *= left
        found.append(off - steady[number])
        off += steady[min(number + 1, len(steady) - 1)] - steady[number]
    return direction + np.array(found)


def _first_heading(middle: Floats, ways: Floats, lag: float) -> float:
    """Return the heading at the begin of a run of legs, from the line through the directions of its first `lag` [m]."""
    at = np.cumsum(ways) - ways / 2.0
    window = slice(0, max(2, int(np.searchsorted(at, lag))))
    at, found = at[window], middle[window]
    bend = float(((at - at.mean()) * found).sum() / max(((at - at.mean()) ** 2).sum(), 1e-12))
    return float(found.mean()) - bend * float(at.mean()) - math.asin(min(max(bend * lag, -1.0), 1.0))


def _front(vectors: Floats, on_foot: bool) -> tuple[Floats, Ints]:
    """Return the unwrapped heading of an actor that moves by vectors (rows, 2), and its gear, 1 or -1.

    A vehicle does not turn around between two rows: it changes its gear there.
    """
    angles = arctan2(vectors[:, 1], vectors[:, 0])
    if on_foot:
        return np.unwrap(angles), np.ones(len(angles), np.int64)
    front = np.unwrap(angles, period=math.pi)
    forwards = (vectors * along(front)).sum(axis=1)
    if forwards.sum() < 0.0:
        front, forwards = front + math.pi, -forwards
    return front, np.where(forwards < 0.0, -1, 1)


def _carried(heading: Floats, positions: Floats, pieces: Ints) -> Floats:
    """Return headings where a piece without any takes those of a neighbouring piece that ends at its place."""
    own = _slices(pieces)
    for order, edge, other in ((own, 0, -1), (own[::-1], -1, 0)):
        for piece, neighbour in zip(order[1:], order[:-1], strict=True):
            near = np.hypot(*(positions[piece][edge] - positions[neighbour][other])) < FAR
            if near and np.isnan(heading[piece]).all():
                heading[piece] = heading[neighbour][other]
    known = ~np.isnan(heading)
    heading[known] = np.unwrap(heading[known])
    return heading
