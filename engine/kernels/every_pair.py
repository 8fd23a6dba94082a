"""Every pair of a recording: when two are near one another, and what their motion comes to then.

Actors come as a crowd: the samples of one after those of another, on one grid of steps, each from its own first step.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.handles import handle
from engine.kernels.approach import Touch, search_contact_of
from engine.kernels.conflict import snapshot, time_to_collision
from engine.kernels.jit import allocating, kernel
from engine.kernels.pair import PLACES, ROWS, measure_pair
from engine.tables import Floats, Ints
from engine.vocabulary import State

METRICS = len(PLACES)
NEAREST_AT = PLACES.index(ROWS.index("min_distance_time"))
FASTEST_AT = PLACES.index(ROWS.index("max_closing_time"))
TTC, TTC_TIME, CONTACT = METRICS, METRICS + 1, METRICS + 2
"""Columns of a window's row behind the metrics of its pair: least time to collision [s], when [s], and what came of
it."""
COLUMNS = METRICS + 3
APART, TOUCHED, OVERLAPPING = 0.0, 1.0, 2.0
"""What came of it; those who overlap from its first sample have no other number."""


@handle
class RecordedActors(NamedTuple):
    """All actors of a recording."""

    states: Floats
    """(rows, len(State)); an actor that is missing for a while has rows without `PRESENT` then."""
    offset: Ints
    """(actors + 1,) the first row of each, and the number of rows."""
    begin: Ints
    """(actors,) the step of its first row."""
    outlines: Floats
    """(actors, 3): length, width, distance from rear axle to centre [m]."""
    bounds: Floats
    """(actors, 4): least and largest x, least and largest y of its centre [m]."""
    fastest: Floats
    """(actors,) the longest way of a step [m]; infinite where the actor is missing for a while."""


@allocating
def near_windows(crowd: RecordedActors, near: float, most: int) -> Ints:
    """(windows, 4): one, other, first and last step between which the two are there without a gap and whose ends are
    the first and last at which their centres are nearer than `near` [m]. No more than `most` windows.
    """
    found = np.empty((1024, 4), dtype=np.int64)
    count = 0
    actors = len(crowd.begin)
    for one in range(actors):
        for other in range(one + 1, actors):
            step = max(crowd.begin[one], crowd.begin[other])
            end = min(_end(crowd, one), _end(crowd, other))
            if step >= end or _never_near(crowd.bounds, one, other, near):
                continue
            while step < end and count < most:
                first, last, step = _next_window(crowd, one, other, step, end, near)
                if first < 0:
                    continue
                if count == len(found):
                    larger = np.empty((2 * count, 4), dtype=np.int64)
                    larger[:count] = found
                    found = larger
                found[count, 0], found[count, 1], found[count, 2], found[count, 3] = one, other, first, last
                count += 1
    return found[:count].copy()


@kernel
def _end(crowd: RecordedActors, actor: int) -> int:
    """The step after an actor's last."""
    return crowd.begin[actor] + crowd.offset[actor + 1] - crowd.offset[actor]


@kernel
def _never_near(bounds: Floats, one: int, other: int, near: float) -> bool:
    return (
        bounds[one, 0] - bounds[other, 1] > near
        or bounds[other, 0] - bounds[one, 1] > near
        or bounds[one, 2] - bounds[other, 3] > near
        or bounds[other, 2] - bounds[one, 3] > near
    )


@kernel
def _next_window(crowd: RecordedActors, one: int, other: int, step: int, end: int, near: float) -> tuple[int, int, int]:
    """First and last step of the stretch of common presence that begins at `step` or later, -1 where the two are never
    near in it, and where to go on. Steps in which nobody can have come near are passed.
    """
    states, ways = crowd.states, crowd.fastest[one] + crowd.fastest[other]
    mine, theirs = crowd.offset[one] - crowd.begin[one], crowd.offset[other] - crowd.begin[other]
    first, last, together = -1, -1, False
    while step < end:
        a, b = mine + step, theirs + step
        if states[a, State.PRESENT] == 0.0 or states[b, State.PRESENT] == 0.0:
            if together:
                break
            step += 1
            continue
        together = True
        apart = math.hypot(states[b, State.X] - states[a, State.X], states[b, State.Y] - states[a, State.Y])
        if apart < near:
            first, last = (step if first < 0 else first), step
            step += 1
        elif ways > 0.0:
            step += max(1, int(min((apart - near) / ways, 1e9)))
        else:  # both stand
            step = end
    return first, last, step


@allocating
def judge_windows(crowd: RecordedActors, windows: Ints, time_step: float) -> Floats:
    """(windows, COLUMNS): metrics of each pair in its window, up to the contact of the two; times [s] count from the
    recording's first step. Others, and what they touch, have no part in it.
    """
    rows = np.full((len(windows), COLUMNS), math.nan)
    longest = 0
    for window in windows:
        longest = max(longest, window[3] - window[2] + 1)
    buffer = np.zeros((longest, 2, crowd.states.shape[1]))
    outlines = np.zeros((2, crowd.outlines.shape[1]))
    for number in range(len(windows)):
        one, other, first, last = windows[number]
        samples = last - first + 1
        states = buffer[:samples]
        a, b = crowd.offset[one] + first - crowd.begin[one], crowd.offset[other] + first - crowd.begin[other]
        states[:, 0], states[:, 1] = crowd.states[a : a + samples], crowd.states[b : b + samples]
        outlines[0], outlines[1] = crowd.outlines[one], crowd.outlines[other]
        _judge(states, outlines, time_step, first * time_step, rows[number])
    return rows


@kernel
def _judge(states: Floats, outlines: Floats, time_step: float, begin: float, row: Floats) -> None:
    touch = search_contact_of(states, outlines, 0, 2)
    if touch.sample == 0 and touch.part == 0.0:
        row[CONTACT] = OVERLAPPING
        return
    touched = touch.sample >= 0
    samples, ending = _judged_up_to(touch, len(states))
    metrics = measure_pair(
        states[: samples + 1] if touched else states, samples, time_step, 1, outlines, touched, ending
    )
    for column in range(METRICS):
        row[column] = metrics[column]
    row[NEAREST_AT] += begin
    row[FASTEST_AT] += begin
    row[CONTACT] = TOUCHED if touched else APART
    row[TTC] = math.inf
    if touched:
        row[TTC], row[TTC_TIME] = 0.0, row[NEAREST_AT]
        return
    for k in range(samples):
        seconds = time_to_collision(snapshot(states, len(states), k, 0.0, time_step, 1, outlines))
        if seconds < row[TTC]:
            row[TTC], row[TTC_TIME] = seconds, begin + k * time_step


@kernel
def _judged_up_to(touch: Touch, samples: int) -> tuple[int, float]:
    """How many samples are scored, and the part of the step after them that came before contact; 0 without contact."""
    if touch.sample < 0:
        return samples, 0.0
    if touch.part == 0.0:  # at a sample: it belongs to the step before
        return touch.sample, 1.0
    return touch.sample + 1, touch.part
