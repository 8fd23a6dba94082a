"""What positions at given times say of motion, and whether headings and speeds fit them: positions are believed where
they contradict each other. Times need not be even; arrays are row-aligned with them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from engine.interchange.contract import cited
from engine.portable import arctan2
from engine.tables import Floats

STANDING = 1e-6
"""Less way between two samples shows no direction [m]."""


def rates(time: Floats, values: Floats) -> Floats:
    """(samples, …) rate of change: central differences, one-sided at both ends; 0 of a single sample.

    Of headings that are not wrapped it is the yaw rate that `engine.kernels.pair.center_velocity` takes.
    """
    if len(time) < 2:
        return np.zeros_like(values)
    before = np.maximum(np.arange(len(time)) - 1, 0)
    after = np.minimum(np.arange(len(time)) + 1, len(time) - 1)
    span = (time[after] - time[before]).reshape(-1, *([1] * (values.ndim - 1)))
    return (values[after] - values[before]) / span


def along(heading: Floats) -> Floats:
    """(samples, 2) unit vectors ahead."""
    return np.column_stack([np.cos(heading), np.sin(heading)])


def across(heading: Floats) -> Floats:
    """(samples, 2) unit vectors to the left."""
    return np.column_stack([-np.sin(heading), np.cos(heading)])


def driven(time: Floats) -> int:
    """Samples up to and with the first that is on no step: in a table of ours, that of first contact."""
    steps = np.diff(time)
    if len(steps) == 0:
        return len(time)
    short = np.flatnonzero(steps < 0.999 * np.median(steps))
    return int(short[0]) + 2 if len(short) else len(time)


def headings_of(positions: Floats) -> Floats:
    """(samples,) directions of motion, not wrapped; at standstill the last one, or the first to come; 0 without any.

    `positions` (samples, 2). The direction at a sample is that from the sample before to the one after it.
    """
    count = len(positions)
    before, after = np.maximum(np.arange(count) - 1, 0), np.minimum(np.arange(count) + 1, count - 1)
    found = directions(positions[after] - positions[before], STANDING)
    return np.zeros(count) if found is None else found


def directions(velocity: Floats, slowest: float) -> Floats | None:
    """(samples,) where velocities point, not wrapped, while they are faster than `slowest`; else as before, or as the
    first time. None where they never are.
    """
    moving = np.flatnonzero(np.hypot(velocity[:, 0], velocity[:, 1]) > slowest)
    if not len(moving):
        return None
    last = moving[np.maximum(np.searchsorted(moving, np.arange(len(velocity)), "right") - 1, 0)]
    return np.unwrap(arctan2(velocity[last, 1], velocity[last, 0]))


# -- whether units can be those that are taken for granted -------------------------------------------------------------

FASTEST = 150.0
"""No road user moves faster over its whole way [m/s]."""
SLOWEST_SAMPLING = 10.0
"""Rows of a recording do not lie further apart [s]."""


def scale_remarks(names: Sequence[str], tracks: Sequence[tuple[Floats, Floats]]) -> Iterator[str]:
    """What speaks against metres and seconds; `tracks`: (samples,) times and (samples, 2) positions of each name."""
    steps = [float(np.median(np.diff(time))) for time, _ in tracks if len(time) > 1]
    if steps and min(steps) > SLOWEST_SAMPLING:
        yield f"rows lie {min(steps):.4g} s apart: if times are milliseconds, call them `time [ms]`"
    pace = [float(np.hypot(*np.ptp(places, axis=0)) / max(time[-1] - time[0], STANDING)) for time, places in tracks]
    if pace and max(pace) > FASTEST:
        who = cited(names[int(np.argmax(pace))])
        cure = "if positions are millimetres, call them `x [mm]` and `y [mm]`; if times are not seconds, say their unit"
        yield f"{who} moves at {max(pace):,.0f} m/s, which no actor on a road does: {cure}"


# -- headings and speeds held against positions ------------------------------------------------------------------------

HARDEST = 15.0
"""No actor brakes harder [m/s^2]: so much may a speed differ from that of the way to the next sample."""
NOISE = 1.0
"""Of speeds taken from positions that were measured or rounded [m/s]; their median has a tenth of it."""
SHARE = 0.2
"""How much two ways to measure a speed may differ."""
GAP = 5.0
"""Longer than so many of its usual steps without a row, an actor is not there."""
MOVING = 1.0
"""A slower motion shows no direction [m/s]."""
FAR = 2.0
"""An actor that stays within this distance only jitters, and shows no direction either [m]."""
ASIDE = math.radians(45.0)
"""The largest angle between heading and motion of an actor that drives, forwards or backwards [rad]."""
NEAR = math.radians(20.0)
KMH = 3.6
FEWEST = 3
"""Samples whose median is worth comparing."""


@dataclass(frozen=True)
class Held:
    """A column as it is believed."""

    values: Floats
    remark: str = ""
    in_degrees: bool = False
    """What it holds are degrees."""


def held_headings(
    who: str, time: Floats, positions: Floats, heading: Floats, loose: np.ndarray, *, unit_said: bool
) -> Held:
    """Headings [rad], not wrapped; those of motion where most lie across it.

    `loose` (samples,): where it slides after an impact, which may be any way; `unit_said`: whether they are known to be
    radians.
    """
    direction = np.where(loose, math.nan, _directions(time, positions))
    shown = np.flatnonzero(~np.isnan(direction))
    if not len(shown):
        return Held(heading)
    off = _apart(heading[shown], direction[shown])
    across, behind = (np.count_nonzero(found) for found in ((off > ASIDE) & (off < math.pi - ASIDE), off > ASIDE))
    if 2 * behind <= len(shown):
        return Held(heading)
    fits = int(np.count_nonzero(_apart(np.radians(heading[shown]), direction[shown]) < NEAR))
    degrees = not unit_said and 2 * fits > len(shown)
    if 2 * across > len(shown):
        message = f"headings of {cited(who)} lie across its motion at {across:,} of {len(shown):,} samples"
        return Held(headings_of(positions), f"{message}: they are taken from motion", degrees)
    return Held(heading, f"{cited(who)} drives backwards, unless its headings are degrees" if degrees else "")


def _directions(time: Floats, positions: Floats) -> Floats:
    """(samples,) of motion while it is driven; nan where there is none to be seen."""
    if np.ptp(positions, axis=0).max(initial=0.0) < FAR:
        return np.full(len(time), math.nan)
    velocity = rates(time, positions)
    shown = np.hypot(velocity[:, 0], velocity[:, 1]) > MOVING
    shown[driven(time) :] = False
    return np.where(shown, arctan2(velocity[:, 1], velocity[:, 0]), math.nan)


def _apart(one: Floats, other: Floats) -> Floats:
    """Angles between directions, from 0 to pi."""
    return np.abs((one - other + math.pi) % (2.0 * math.pi) - math.pi)


def held_speeds(who: str, column: str, time: Floats, positions: Floats, velocity: Floats, factor: float) -> Held:
    """(samples, 2) velocities of the centre; those of motion where they do not fit: all of them if most do not.

    `column`: what the file calls them; `factor`: from its unit to m/s, 0 where its name says no unit.
    """
    steps = np.diff(time)
    near = steps <= GAP * np.median(steps) if len(steps) else np.zeros(0, bool)
    if not near.any():
        return Held(velocity)
    moved = rates(time, positions)
    if remark := _contradiction(who, column, time, moved, velocity, factor):
        return Held(moved, remark)
    wrong = _misfits(positions, velocity, steps, near)
    if 2 * np.count_nonzero(wrong) > len(time):
        return Held(moved, f"speeds of {cited(who)} do not fit its positions: they are taken from motion")
    if not wrong.any():
        return Held(velocity)
    message = f"{np.count_nonzero(wrong):,} of {len(time):,} speeds of {cited(who)} do not fit its positions"
    return Held(np.where(wrong[:, np.newaxis], moved, velocity), f"{message}: those are taken from motion")


def _misfits(positions: Floats, velocity: Floats, steps: Floats, near: np.ndarray) -> np.ndarray:
    """(samples,) which velocities lie nowhere between that of the way to them and that of the way from them.

    Where a contact comes between two samples these differ; an actor may come in from a standstill.
    """
    ways = np.where(near[:, np.newaxis], np.diff(positions, axis=0) / steps[:, np.newaxis], 0.0)
    none = np.zeros((1, 2))
    before, after = np.vstack([none, ways]), np.vstack([ways, none])
    span = after - before
    part = ((velocity - before) * span).sum(axis=1) / np.maximum((span * span).sum(axis=1), 1e-12)
    between = before + np.clip(part, 0.0, 1.0)[:, np.newaxis] * span
    fastest = np.maximum(np.hypot(*before.T), np.hypot(*after.T))
    allowed = NOISE + SHARE * fastest + HARDEST * np.median(steps)
    judged = np.append(False, near) | np.append(near, False)
    return judged & ~(np.hypot(*(velocity - between).T) <= allowed)


def _contradiction(who: str, column: str, time: Floats, moved: Floats, velocity: Floats, factor: float) -> str:
    """What is to be said where speeds as a whole are others than those of motion; "" where they are not."""
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
    """(samples,) the part of velocities ahead."""
    return (velocity * along(heading)).sum(axis=1)
