"""Pairs of a recording: the windows in which two actors are near one another, and the metrics of their motion in these.

Actors are stored as a crowd: the samples of one actor after those of another, on a common grid of steps, each from its
first step.
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
"""Columns of a window's row after the metrics of its pair: least time to collision [s], its time [s], and contact."""
COLUMNS = METRICS + 3
APART, TOUCHED, OVERLAPPING = 0.0, 1.0, 2.0
"""Values of `CONTACT`; a pair that overlaps at the first sample of its window has no other number."""


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
    """Return (windows, 4), at most `most` rows: two actors, and the first and last step of their window.

    A window lies within a common presence without a gap; its ends are the first and last step at which the centres are
    nearer than `near` [m].
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
    """Return the step after an actor's last."""
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
    """Return the first and last step of the window in the common presence that begins at `step` or later, and the step
    to continue from; -1 if the two are never near in it. Steps at which they cannot be near are skipped.
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
    """Return (windows, COLUMNS) the metrics of each pair in its window, up to the contact of the two; times [s] count
    from the recording's first step. Other actors, and their contacts, are ignored.
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
    """Return the number of samples that are scored, and the part of the next step before contact; 0 without contact."""
    if touch.sample < 0:
        return samples, 0.0
    if touch.part == 0.0:  # at a sample: it belongs to the step before
        return touch.sample, 1.0
    return touch.sample + 1, touch.part
