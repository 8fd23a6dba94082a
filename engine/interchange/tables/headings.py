"""Headings of a table, replaced by those of motion where they are unknown or do not fit it.

A column is read as anticlockwise from the x axis, and checked by the motion of all actors: on a straight way a vehicle
moves along its heading. If headings differ from motion by the same angle at nearly every sample, they count from
another zero, for any size of the angle.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import NoReturn

import numpy as np

from engine.errors import InterchangeError, cited
from engine.interchange.motion import Motion, pieces_of
from engine.interchange.tables.columns import SLIDES, Cells
from engine.interchange.tables.plausible import FEWEST, AssumedColumn, directions_of, held_headings
from engine.tables import Bools, Floats, Ints

# -- zero and sense of a column ----------------------------------------------------------------------------------------

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


DEGREES = 7.0
"""Largest heading in radians, except for one that is unwrapped."""


def slides(cells: Cells, rows: Ints) -> Bools:
    """Return (samples,) True if an actor slides after an impact, according to a table of cortexc."""
    return cells.whole[SLIDES][rows] != 0 if SLIDES in cells.whole else np.zeros(len(rows), bool)


@dataclass
class Headings:
    """The column of headings, and the result of its comparison with motion."""

    cells: Cells
    remarks: list[str]
    """Remarks on the table; the methods add theirs."""
    misread: bool = False
    """True if the column counts from another zero or in another sense: none of its headings is used."""
    key: str = field(init=False)

    def __post_init__(self) -> None:
        self.key = "yaw" if self.cells.omega_prime else "heading"

    def judge(self, actors: Iterable[Ints], time: Floats) -> None:
        """Set `misread` by comparison of the whole column with motion; `actors`: rows of each, in the order of time
        [s].
        """
        if self.key not in self.cells.numbers:
            return
        column, heading = self.cells.columns[self.key], self.cells.numbers[self.key]
        if not column.unit and np.nanmax(np.abs(heading), initial=0.0) > DEGREES:
            return  # degrees, which are refused, or radians that run on
        places = np.column_stack([self.cells.numbers[axis] for axis in ("x", "y")])
        motions = ((rows, Motion(time[rows], places[rows], pieces_of(time[rows]))) for rows in actors)
        pairs = (straight_offsets(motion, self._directions(motion, rows), heading[rows]) for rows, motion in motions)
        if wrong := misread(pairs, in_radians=bool(column.unit)):
            self.misread = True
            message = f"headings (column {cited(column.name)}) do not fit the motion: {wrong}"
            self.remarks.append(f"{message}; they are taken from motion")

    def of(
        self,
        name: str,
        motion: Motion,
        velocity: AssumedColumn | None,
        rows: Ints,
        motion_headings: Callable[..., Floats],
        *,
        on_foot: bool,
    ) -> Floats:
        """Return the headings of an actor (samples,) [rad]: those of the column if they fit its motion, else those of
        motion.

        `motion_headings` returns those of motion, or of velocities (samples, 2) if they are given.
        """
        believed = velocity is not None and not velocity.rejected
        shown = partial(motion_headings, velocity.values if velocity and believed else None)
        heading = self.cells.numbers[self.key][rows] if self.key in self.cells.numbers else np.full(len(rows), math.nan)
        unknown = int(np.count_nonzero(~np.isfinite(heading)))
        if self.misread:
            return shown()
        if unknown == len(rows):
            source = "velocities, or else of its motion" if believed else "motion"
            self.remarks.append(f"an actor without headings has the directions of its {source}")
            return shown()
        if unknown:
            self.remarks.append(
                f"{cited(name)} has {unknown:,} of {len(rows):,} rows without a heading: motion shows it"
            )
            heading = _filled(heading, shown())
        return self._held(name, motion, heading, rows, motion_headings, on_foot=on_foot)

    def _held(
        self, name: str, motion: Motion, heading: Floats, rows: Ints, of_motion: Callable[[], Floats], *, on_foot: bool
    ) -> Floats:
        if abs(heading[0]) > DEGREES or (len(heading) > 1 and np.abs(np.diff(heading)).max() > DEGREES):
            self._refuse_degrees(f"headings up to {np.abs(heading).max():g} are not in radians", heading, rows)
        direction, heading = self._directions(motion, rows), np.unwrap(heading)
        unit_said = bool(self.cells.columns[self.key].unit)
        held = held_headings(name, direction, heading, unit_said=unit_said, of_motion=of_motion)
        if held.in_degrees:
            self._refuse_degrees("headings lie across the motion, unless they are degrees", heading, rows)
        if held.remark:
            self.remarks.append(held.remark)
        elif not on_foot and (offset := offset_of(*straight_offsets(motion, direction, heading))):
            self.remarks.append(
                f"headings of {cited(name)} lie {aside(offset)} its motion throughout: they are taken from motion"
            )
            return of_motion()
        return held.values

    def _directions(self, motion: Motion, rows: Ints) -> Floats:
        return directions_of(motion, slides(self.cells, rows))

    def _refuse_degrees(self, message: str, heading: Floats, rows: Ints) -> NoReturn:
        column = self.cells.columns[self.key]
        cure = "write radians" if column.unit else f"if they are degrees, call the column `{column.name}_deg`"
        raise InterchangeError(message, cure, self.cells.place(int(rows[int(np.abs(heading).argmax())]), self.key))


def _filled(heading: Floats, shown: Floats) -> Floats:
    """Return headings (samples,) [rad], unknown ones replaced by those of motion, or interpolated between known
    samples.
    """
    heading = np.where(np.isfinite(heading), heading, shown)
    known = np.flatnonzero(np.isfinite(heading))
    return np.interp(np.arange(len(heading)), known, np.unwrap(heading[known]))
