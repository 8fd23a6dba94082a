"""Check of zero and sense of a column of headings, which is read as anticlockwise from the x axis.

The motion of all actors is the evidence: on a straight way a vehicle moves along its heading. If headings differ from
motion by the same angle at nearly every sample, they count from another zero, for any size of the angle.
"""

import math
from collections.abc import Iterable

import numpy as np

from engine.interchange.motion import Motion
from engine.interchange.tables.plausible import FEWEST
from engine.tables import Floats

STRAIGHT = 0.01
"""Largest curvature of a straight way [1/m]: there the centre of a bus, 4 m ahead of its rear axle, slips 2 degrees."""
SLIP = math.radians(5.0)
"""Largest angle between heading and motion on a straight way [rad]. Tyres carry crosswind and a road's crossfall with
less than 1 degree of slip (Pacejka, "Tire and Vehicle Dynamics", chapter 1: their greatest force comes at 5 to 10)."""
NEARLY_ALL, MOST = 0.9, 0.75
"""Shares of samples."""
BETTER = 0.25
"""Least excess of the share of samples that fit another zero or sense over the share that fits the assumed one."""
FASTEST_REVERSE = 6.0
"""Largest speed in reverse [m/s]: gears and electric drives limit it to about 20 km/h."""
ROUND = math.radians(2.0)
"""Largest difference of a zero from that of a compass or the x axis to be named as that [rad]."""


def straight_offsets(motion: Motion, direction: Floats, heading: Floats) -> tuple[Floats, Floats]:
    """Return heading and direction of motion (both (rows,)) [rad] at the samples of straight ways with both known.

    `direction`: as `directions_of` returns it. It is reversed where an actor drives backwards, which it does slowly.
    """
    (x, y), (change_x, change_y) = motion.velocity.T, motion.rates(motion.velocity).T
    speed = np.maximum(np.hypot(x, y), 1e-9)
    shown = (np.abs(x * change_y - y * change_x) < STRAIGHT * speed**3) & np.isfinite(direction) & np.isfinite(heading)
    backwards = (np.cos(heading - direction) < 0.0) & (speed < FASTEST_REVERSE)
    return heading[shown], np.where(backwards, direction + math.pi, direction)[shown]


def offset_of(heading: Floats, direction: Floats) -> float:
    """Return the angle from an actor's motion to its headings [rad], positive to the left; 0 if it is not the same
    throughout.

    Forwards or backwards: the angle is between -pi/2 and pi/2.
    """
    off = np.remainder(heading - direction + math.pi / 2.0, math.pi) - math.pi / 2.0
    if len(off) < FEWEST:
        return 0.0
    for side in (1.0, -1.0):
        if np.count_nonzero(side * off > SLIP) >= NEARLY_ALL * len(off):
            return float(np.median(off))
    return 0.0


def aside(offset: float) -> str:
    """Return an angle between headings and motion in words."""
    return f"{abs(math.degrees(offset)):.0f} degrees {'left' if offset > 0.0 else 'right'} of"


def misread(every: Iterable[tuple[Floats, Floats]], *, in_radians: bool) -> str:
    """Return the fault of a recording's headings as a whole, in words; "" if most fit, or too few are known.

    `every`: heading and direction of motion (see `straight_offsets`) of each actor; `in_radians`: True if the column
    declares radians. Headings in degrees are refused elsewhere.
    """
    pairs = list(every)
    heading, direction = (np.concatenate([np.zeros(0), *(pair[side] for pair in pairs)]) for side in (0, 1))
    if len(heading) < FEWEST or (least := max(MOST, _share(heading - direction) + BETTER)) > 1.0:
        return ""
    if abs(_zero(direction + heading) - math.pi / 2.0) < ROUND and _fits(direction + heading, least):
        return "they would if they counted clockwise from north (write pi/2 - heading)"
    if not in_radians and _share(np.radians(heading) - direction) >= least:
        return ""
    if _fits(heading - direction, least):
        return f"they lie {aside(_zero(heading - direction))} it"
    if _fits(direction + heading, least):
        zero = _zero(direction + heading)
        where = "the x axis (write -heading)" if abs(zero) < ROUND else f"{math.degrees(zero):.0f} degrees left of it"
        return f"they would if they counted clockwise from {where}"
    return ""


def _zero(angles: Floats) -> float:
    """Return the median of angles on the circle [rad]."""
    middle = math.atan2(float(np.sin(angles).mean()), float(np.cos(angles).mean()))
    around = np.remainder(angles - middle + math.pi, math.tau) - math.pi
    return math.remainder(middle + float(np.median(around)), math.tau)


def _fits(angles: Floats, least: float) -> bool:
    return _share(angles - _zero(angles)) >= least


def _share(angles: Floats) -> float:
    """Return the share of angles that are 0 within `SLIP`."""
    return float(np.mean(np.abs(np.remainder(angles + math.pi, math.tau) - math.pi) < SLIP))
