"""Conversion of tracks to a recording's samples: one grid of times for all entities, and the state of each at it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from engine.errors import InterchangeError
from engine.interchange.motion import jump_remark, without_jumps
from engine.interchange.openscenario.read.entities import Entity
from engine.interchange.openscenario.read.motion import COARSE, Polyline, Track
from engine.interchange.own_metadata import Carried, near, read_carried, step_in
from engine.interchange.recording import SAME_INSTANT
from engine.tables import Bools, Floats
from engine.vocabulary import State

FINE = 0.05
"""Time between samples if vertices are further apart than `COARSE` [s]."""
SOON = 0.002
"""Time before a sample within which a trigger means that sample [s]: 1.0 can only express "later than"."""
FEW = 5
"""Number of samples below which all may be at uneven distances, as contact falls within a step."""
COARSEST = 10.0
"""No step is longer [s]."""
MOST_NUMBERS = 2_000_000
"""Samples times actors; twenty actors over 80 minutes at 20 Hz."""


@dataclass(frozen=True)
class Part:
    """One entity's part of a recording: actor, track, and the data of files of cortexc."""

    entity: Entity
    track: Track
    carried: Carried | None
    """Its samples, if their times fit those of the vertices."""
    believed: bool = False
    """True if the speeds and commands at these samples fit, too: see `speeds`."""
    remarks: tuple[str, ...] = ()

    @property
    def times(self) -> Floats:
        """Return the times of its vertices and samples, ascending."""
        times = [leg.times for leg in self.track.legs if isinstance(leg, Polyline)]
        return _merged(np.concatenate([*times, np.zeros(0) if self.carried is None else self.carried.time]))

    def there(self, times: Floats) -> np.ndarray:
        """Return (times,) True while the entity is present."""
        return self.track.there(times) if self.carried is None else self.carried.there(times)


def part_of(entity: Entity, track: Track) -> Part:
    """Return one entity's part, before its data are compared with its vertices."""
    carried = read_carried(entity.properties)
    if carried is None:
        return Part(entity, track, None)
    paths = [leg for leg in track.legs if isinstance(leg, Polyline)]
    if all(near(carried.time, path.times).all() for path in paths):
        return Part(entity, track, carried)
    said = "the speeds it carries do not fit its vertices, which are believed: they are of other times"
    return Part(entity, track, None, remarks=(f"{entity.actor.name}: {said}",))


class Grid(NamedTuple):
    """Times of all samples [s]."""

    given: Floats
    """Times at which the file has data of an entity, from 0 to the end."""
    times: Floats
    """These times and, if a step is requested or they are far apart, whole steps."""
    step: float
    """Time step of the recording [s]."""
    remarks: tuple[str, ...] = ()


def grid(parts: Sequence[Part], end: float, step: float | None, file: str) -> Grid:
    """Return the times of all vertices, of all samples in files of cortexc, and of actions.

    Raises:
        InterchangeError: no times at all, or more samples than the limit.
    """
    given = _given_times(parts, end, file)
    spacing, usual = _spacing(parts)
    said, remarks = _said_step(parts, given)
    times, wanted = given, step or said
    if wanted is None and usual > COARSE:
        wanted, step = FINE, FINE
    if step is not None:
        times = _with_steps(given, step, len(parts), file)
    _check_size(len(times), len(parts), file)
    return Grid(given, times, wanted or spacing, () if step else remarks)


def usual_step(parts: Sequence[Part]) -> float:
    """Return the most common time between two samples in files of cortexc [s]; infinite for fewer than two."""
    times = _merged(np.concatenate([np.zeros(0), *(part.carried.time for part in parts if part.carried)]))
    return _most_common(np.diff(times)) if len(times) > 1 else math.inf


def _said_step(parts: Sequence[Part], given: Floats) -> tuple[float | None, tuple[str, ...]]:
    """Return the step that a file of cortexc states, if it fits the samples, as far as a few of them can show."""
    said = dict.fromkeys(step for part in parts if (step := step_in(part.entity.properties)) is not None)
    usual = usual_step(parts)
    few = len(given) < FEW
    fitting = [
        step
        for step in said
        if math.isclose(step, usual, rel_tol=1e-6) or (few and step < COARSEST and (step > usual or usual == math.inf))
    ]
    wrong = [step for step in said if step not in fitting]
    if not wrong:
        return (fitting[0] if fitting else None), ()
    taken = fitting[0] if fitting else min(usual, COARSEST)
    return taken, (f"it says a step of {wrong[0]:g} s, but its samples stand {taken:g} s apart, which is taken",)


def states(part: Part, times: Floats) -> Floats:
    """Return (samples, len(State)) the states of one entity.

    Speeds are those in files of cortexc, if they fit. Else they are the motion of the reference point along the
    heading, by central differences over the neighbouring samples (one-sided at both ends).
    """
    poses, carried = part.track.poses(times), part.carried
    there, _ = presence(part, times)
    found = np.zeros((len(times), len(State)))
    found[:, [State.X, State.Y, State.HEADING]] = centers(poses, part.entity)
    found[:, State.PRESENT] = there
    if carried is not None and part.believed:
        for column in carried.columns:
            found[:, column] = carried.at(column, times)
    else:
        _derive(found, poses, times, there)
    found[~there, State.SPEED :] = 0.0
    return found


def presence(part: Part, times: Floats) -> tuple[Bools, str]:
    """Return (samples,) True while an entity is present, except at jumps of its track, and a remark on jumps.

    A file of cortexc replays a simulation, and has none.
    """
    there = part.there(times)
    if part.carried is not None:
        return there, ""
    samples = np.flatnonzero(there)
    own, places = times[samples], part.track.poses(times)[samples, :2]
    remaining, _, jumps = without_jumps(own, places)
    there[samples[~remaining]] = False
    return there, jump_remark(part.entity.actor.name, own, places, jumps)


def _given_times(parts: Sequence[Part], end: float, file: str) -> Floats:
    """Return the times from 0 to the end [s] at which the file has data of an entity."""
    times = _merged(np.concatenate([part.times for part in parts]))
    if not len(times):
        raise InterchangeError(
            "no actor follows a trajectory with times, so there is no recorded case in this file",
            "play it in a simulator, and import what was recorded",
            file,
        )
    last = min(end, max(float(times[-1]), 0.0))
    times = _with_moments(times, [*_action_times(parts), 0.0, last])
    return times[(times >= 0.0) & (times <= last + SOON)]


def _with_moments(times: Floats, moments: Sequence[float]) -> Floats:
    """Return the times, and those moments that are not near a time."""
    wanted = np.array(moments)
    after = np.minimum(np.searchsorted(times, wanted - SAME_INSTANT), len(times) - 1)
    soon = (times[after] >= wanted - SAME_INSTANT) & (times[after] <= wanted + SOON)
    return _merged(np.concatenate([times, wanted[~soon]]))


def _with_steps(times: Floats, step: float, actors: int, file: str) -> Floats:
    """Return the times, and all whole steps between the first and the last of them."""
    _check_size((times[-1] - times[0]) / step, actors, file)
    first, last = math.ceil(float(times[0]) / step), math.floor(float(times[-1]) / step)
    whole = np.arange(first, last + 1, dtype=np.float64) * step
    return _merged(np.concatenate([times, whole]))


def _action_times(parts: Sequence[Part]) -> list[float]:
    """Return the beginnings of legs, and the ends of presence and absence."""
    begins = [leg.begin for part in parts for leg in part.track.legs]
    changes = [time for part in parts for pair in part.track.absent for time in pair]
    return [time for time in begins + changes if math.isfinite(time)]


def _merged(times: Floats) -> Floats:
    """Return ascending times; of instants that no format can distinguish, the first."""
    times = np.sort(times)
    return times[np.diff(times, prepend=-math.inf) > SAME_INSTANT]


def _spacing(parts: Sequence[Part]) -> tuple[float, float]:
    """Return the most common time between two vertices [s], the shorter of two equally common, and the median."""
    between = np.concatenate([np.diff(part.times) for part in parts])
    return (_most_common(between), float(np.median(between))) if len(between) else (FINE, FINE)


def _most_common(between: Floats) -> float:
    """Return the most common value to a nanosecond; of two equally common the shorter."""
    spacings, counts = np.unique(np.round(between, 9), return_counts=True)
    return float(spacings[np.argmax(counts)])


def _check_size(samples: float, actors: int, file: str) -> None:
    if samples * actors > MOST_NUMBERS:
        raise InterchangeError(
            f"{samples:.0f} samples of {actors} actors are more than is read at once",
            f"at most {MOST_NUMBERS} states: cut the scenario, leave out actors, or take a longer step",
            file,
        )


def centers(poses: Floats, entity: Entity) -> Floats:
    """Return poses of the outline's centre."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x = poses[:, 0] + entity.forward * cos - entity.left * sin
    y = poses[:, 1] + entity.forward * sin + entity.left * cos
    return np.column_stack([x, y, poses[:, 2]])


def _derive(found: Floats, poses: Floats, times: Floats, there: np.ndarray) -> None:
    """Fill speed and acceleration from the motion of the reference point, stretch by stretch of being there."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2).tolist():
        if end - start < 2:
            continue
        part = slice(start, end)
        way_x, way_y = np.gradient(poses[part, 0], times[part]), np.gradient(poses[part, 1], times[part])
        speed = way_x * np.cos(poses[part, 2]) + way_y * np.sin(poses[part, 2])
        found[part, State.SPEED] = speed
        found[start + 1 : end, State.ACCELERATION] = np.diff(speed) / np.diff(times[part])
