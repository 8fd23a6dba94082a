"""Consistency of headings and speeds with positions; in a contradiction, positions are used. Times need not be even;
arrays are row-aligned with them.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from engine.errors import cited
from engine.interchange.motion import (
    FAR,
    FASTEST,
    MOVING,
    Motion,
    along,
    nearest_between,
    usual_pace,
)
from engine.portable import arctan2
from engine.tables import Bools, Floats

# -- whether units can be those that are taken for granted -------------------------------------------------------------

SLOWEST_SAMPLING = 10.0
"""Largest usual time between two rows of a recording [s]."""


def scale_remarks(names: Sequence[str], tracks: Sequence[tuple[Floats, Floats]]) -> Iterator[str]:
    """Yield remarks if data contradict metres and seconds; `tracks`: (samples,) times and (samples, 2) positions per
    name.
    """
    steps = [float(np.median(np.diff(time))) for time, _ in tracks if len(time) > 1]
    if steps and min(steps) > SLOWEST_SAMPLING:
        yield f"rows lie {min(steps):.4g} s apart: if times are milliseconds, call them `time [ms]`"
    pace = [usual_pace(time, places) for time, places in tracks]
    if pace and max(pace) > FASTEST:
        who = cited(names[int(np.argmax(pace))])
        cure = "if positions are millimetres, call them `x [mm]` and `y [mm]`; if times are not seconds, say their unit"
        yield f"{who} moves at {max(pace):,.0f} m/s, which no actor on a road does: {cure}"


# -- headings and speeds held against positions ------------------------------------------------------------------------

HARDEST = 15.0
"""Largest deceleration of an actor [m/s^2]: it limits the difference between a speed and that of the next way."""
NOISE = 1.0
"""Noise of speeds from measured or rounded positions [m/s]; their median has a tenth of it."""
SHARE = 0.2
"""Largest relative difference between two measurements of a speed."""
ASIDE = math.radians(45.0)
"""The largest angle between heading and motion of an actor that drives, forwards or backwards [rad]."""
NEAR = math.radians(20.0)
KMH = 3.6
FEWEST = 3
"""Minimum number of samples for a comparison of medians."""


@dataclass(frozen=True)
class AssumedColumn:
    """A column after its check."""

    values: Floats
    remark: str = ""
    in_degrees: bool = False
    """True if its numbers are degrees."""
    rejected: bool = False
    """True if all `values` are those of motion, so that the column is unused."""


def held_headings(
    who: str, direction: Floats, heading: Floats, *, unit_said: bool, of_motion: Callable[[], Floats]
) -> AssumedColumn:
    """Return headings [rad], not wrapped; those of motion if most are across it.

    `direction`: as `directions_of` returns it; `unit_said`: the headings are known to be radians; `of_motion`: returns
    the headings of motion.
    """
    shown = np.flatnonzero(~np.isnan(direction))
    if not len(shown):
        return AssumedColumn(heading)
    off = _apart(heading[shown], direction[shown])
    across, behind = (np.count_nonzero(found) for found in ((off > ASIDE) & (off < math.pi - ASIDE), off > ASIDE))
    if 2 * behind <= len(shown):
        return AssumedColumn(heading)
    fits = int(np.count_nonzero(_apart(np.radians(heading[shown]), direction[shown]) < NEAR))
    degrees = not unit_said and 2 * fits > len(shown)
    if 2 * across > len(shown):
        message = f"headings of {cited(who)} lie across its motion at {across:,} of {len(shown):,} samples"
        return AssumedColumn(of_motion(), f"{message}: they are taken from motion", degrees)
    return AssumedColumn(heading, f"{cited(who)} drives backwards, unless its headings are degrees" if degrees else "")


def driven(time: Floats) -> int:
    """Return the number of samples up to the first off the steps (included): in a table of cortexc, contact."""
    steps = np.diff(time)
    if len(steps) == 0:
        return len(time)
    short = np.flatnonzero(steps < 0.999 * np.median(steps))
    return int(short[0]) + 2 if len(short) else len(time)


def directions_of(motion: Motion, loose: Bools) -> Floats:
    """Return (samples,) the direction of motion while it is driven [rad]; NaN where there is none.

    `loose` (samples,): where the actor slides after an impact, in any direction.
    """
    away = motion.positions - motion.positions[0]
    if np.hypot(*away.T).max() < FAR:
        return np.full(len(away), math.nan)
    velocity = motion.velocity
    shown = (np.hypot(velocity[:, 0], velocity[:, 1]) > MOVING) & ~loose
    shown[driven(motion.time) :] = False
    return np.where(shown, arctan2(velocity[:, 1], velocity[:, 0]), math.nan)


def _apart(one: Floats, other: Floats) -> Floats:
    """Return angles between directions, from 0 to pi."""
    return np.abs((one - other + math.pi) % (2.0 * math.pi) - math.pi)


def held_speeds(who: str, column: str, motion: Motion, velocity: Floats, factor: float) -> AssumedColumn:
    """Return (samples, 2) velocities of the centre; those of motion where they do not fit: all of them if most do not.

    `column`: its name in the file; `factor`: from its unit to m/s, 0 if its name has no unit.
    """
    time, near = motion.time, np.diff(motion.pieces) == 0
    if not near.any():
        return AssumedColumn(velocity)
    moved = motion.velocity
    if remark := _contradiction(who, column, time, moved, velocity, factor):
        return AssumedColumn(moved, remark, rejected=True)
    wrong = _misfits(motion, velocity, near)
    if 2 * np.count_nonzero(wrong) > len(time):
        message = f"speeds of {cited(who)} do not fit its positions: they are taken from motion"
        return AssumedColumn(moved, message, rejected=True)
    if not wrong.any():
        return AssumedColumn(velocity)
    message = f"{np.count_nonzero(wrong):,} of {len(time):,} speeds of {cited(who)} do not fit its positions"
    return AssumedColumn(np.where(wrong[:, np.newaxis], moved, velocity), f"{message}: those are taken from motion")


def _misfits(motion: Motion, velocity: Floats, near: Bools) -> Bools:
    """Return (samples,) True for velocities that are not between those of the way to the sample and of the way from it.

    At a contact between two samples these differ; an actor may appear from a standstill.
    """
    steps = np.diff(motion.time)
    ways = np.where(near[:, np.newaxis], np.diff(motion.positions, axis=0) / steps[:, np.newaxis], 0.0)
    none = np.zeros((1, 2))
    before, after = np.vstack([none, ways]), np.vstack([ways, none])
    between = nearest_between(before, after, velocity)
    fastest = np.maximum(np.hypot(*before.T), np.hypot(*after.T))
    allowed = NOISE + SHARE * fastest + HARDEST * np.median(steps)
    judged = np.append(False, near) | np.append(near, False)
    return judged & ~(np.hypot(*(velocity - between).T) <= allowed)


def _contradiction(who: str, column: str, time: Floats, moved: Floats, velocity: Floats, factor: float) -> str:
    """Return a remark if the speeds differ from those of motion as a whole; "" if not."""
    own = slice(0, driven(time))
    if len(time[own]) < FEWEST:
        return ""
    said, seen = (float(np.median(np.hypot(*each[own].T))) for each in (velocity, moved))
    if abs(said - seen) <= NOISE / 10 + SHARE * seen + HARDEST / 2 * np.median(np.diff(time)):
        return ""
    is_kmh = not factor and abs(said / max(seen, NOISE) - KMH) < 0.5
    asked = f"; is it km/h? call it `{column} [km/h]`" if is_kmh else ""
    found = f"column {cited(column)}: {said / (factor or 1.0):.3g}, but the positions of {cited(who)}"
    return f"{found} move at {seen:.3g} m/s: speeds are taken from motion{asked}"


def along_heading(velocity: Floats, heading: Floats) -> Floats:
    """Return (samples,) the component of velocities along the headings."""
    return (velocity * along(heading)).sum(axis=1)
