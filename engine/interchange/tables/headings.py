"""Headings of a table, replaced by those of motion where they are unknown or do not fit it."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import NoReturn

import numpy as np

from engine.errors import InterchangeError, cited
from engine.interchange.motion import Motion, pieces_of
from engine.interchange.tables.columns import SLIDES, Cells
from engine.interchange.tables.heading_sense import aside, misread, offset_of, straight_offsets
from engine.interchange.tables.plausible import AssumedColumn, directions_of, held_headings
from engine.tables import Bools, Floats, Ints

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
