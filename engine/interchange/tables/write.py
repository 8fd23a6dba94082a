"""Trajectories in omega-prime's columns: one row for each actor and instant, as CSV or Parquet.

x, y, z is the centre of the box, velocities and accelerations are the centre's, yaw lies in (-pi, pi], an actor's idx
is its number in the recording, the ego's 0. A time is a whole number of nanoseconds, unlike the instant of contact: its
row is at the next nanosecond, with all actors moved on linearly, less than 1e-7 m. A reader searches contact again, so
nothing is lost. If other actors collide before, a column in addition to omega-prime's marks the samples at which an
actor slides, whose motion follows from its positions only.

Source: omega-prime 0.3, its specification and `schemas.py` (ika, RWTH Aachen); its columns are those of ASAM OSI.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InterchangeError
from engine.interchange.contract import Export
from engine.interchange.kinds import KINDS
from engine.interchange.motion import across, along, rates
from engine.interchange.recording import Recording
from engine.interchange.tables.columns import NAME, SLIDES
from engine.interchange.tables.parquet import parquet_bytes
from engine.tables import SLIDING, Floats, Ints
from engine.vocabulary import State

NANOS = 1e9
COLUMNS = [
    "total_nanos",
    "idx",
    "x",
    "y",
    "z",
    "vel_x",
    "vel_y",
    "vel_z",
    "acc_x",
    "acc_y",
    "acc_z",
    "length",
    "width",
    "height",
    "roll",
    "pitch",
    "yaw",
    "type",
    "role",
    "subtype",
]
WHOLE = frozenset({"total_nanos", "idx", "type", "role", "subtype", SLIDES})
"""Columns of whole numbers; all others are metres, seconds and radians."""
EXACT = 1e-3
"""Tolerance [ns] of a whole number of nanoseconds: for a day, the last digit of a float."""

Table = Mapping[str, NDArray[Any]]
"""One array per column, row-aligned."""


def write_csv(recording: Recording, stem: str) -> Export:
    """Write `<stem>.csv`: a line of names, then rows by time and idx; numbers read back to the same values.

    A column in addition to omega-prime's, which its reader ignores, contains the actors' names.

    Raises:
        InterchangeError: two samples share a nanosecond.
    """
    table = omega_prime_table(recording)
    names = [_cell(actor.name) for actor in recording.actors]
    columns: list[list[str]] = [
        *map(_texts, table.values()),
        [names[idx] for idx in table["idx"].tolist()],
    ]
    lines = [",".join((*table, NAME)), *map(",".join, zip(*columns, strict=True))]
    return Export({f"{stem}.csv": "\n".join(lines) + "\n"}, _remarks(recording))


def write_parquet(recording: Recording, stem: str, road: tuple[str, str] | None = None) -> Export:
    """Write `<stem>.parquet`: the same table; metadata contain the ego's idx, the names, and name and OpenDRIVE of
    `road`.

    Raises:
        InterchangeError: pyarrow is not installed; two samples share a nanosecond.
    """
    names = [actor.name for actor in recording.actors]
    content = parquet_bytes(omega_prime_table(recording), names, road)
    return Export({f"{stem}.parquet": content}, _remarks(recording, has_road=road is not None))


def omega_prime_table(recording: Recording) -> Table:
    """Return the columns of omega-prime for all samples of all present actors, and `slides` if an actor slides."""
    nanos = _nanos(recording)
    states = _on_nanoseconds(recording, nanos)
    parts = [_of_actor(recording, states, nanos, actor) for actor in range(len(recording.actors))]
    columns = [*COLUMNS, SLIDES] if recording.slides.any() else COLUMNS
    joined = {name: np.concatenate([part[name] for part in parts]) for name in columns}
    order = np.lexsort((joined["idx"], joined["total_nanos"]))
    return {name: column[order] for name, column in joined.items()}


def _texts(column: NDArray[Any]) -> list[str]:
    """Return numbers as texts; floats have a point, so that readers infer one type for all rows."""
    return [repr(value + 0.0) if isinstance(value, float) else str(value) for value in column.tolist()]


def _cell(text: str) -> str:
    """Return a text as a CSV cell; one with special characters is quoted (RFC 4180)."""
    return '"{}"'.format(text.replace('"', '""')) if set(text) & set(',"\r\n') else text


# -- time -------------------------------------------------------------------------------------------------------------


def _nanos(recording: Recording) -> Ints:
    """Return (samples,) int64: steps at the nearest nanosecond, contact at the first that is not before it."""
    exact = recording.time * NANOS
    nanos = np.round(exact).astype(np.int64)
    if recording.contact is not None:
        touching = recording.scored_samples() - 1
        nanos[touching] = math.ceil(exact[touching] - EXACT)
        if touching + 1 < len(nanos):
            nanos[touching] = min(nanos[touching], nanos[touching + 1] - 1)
    if (np.diff(nanos) <= 0).any():
        raise InterchangeError("two samples share a nanosecond", "simulate with a longer --time-step")
    return nanos


def _on_nanoseconds(recording: Recording, nanos: Ints) -> Floats:
    """Return the states, with those of contact extrapolated to its nanosecond."""
    touching = recording.scored_samples() - 1
    if recording.contact is None or touching == 0:
        return recording.states
    states, time = recording.states.copy(), recording.time
    late, step = nanos[touching] / NANOS - time[touching], time[touching] - time[touching - 1]
    if late * NANOS > EXACT:
        both: list[int] = np.flatnonzero(np.all(recording.there[[touching - 1, touching]], axis=0)).tolist()
        here = np.ix_([touching], both, [State.X, State.Y, State.HEADING, State.SPEED])
        before = np.ix_([touching - 1], both, [State.X, State.Y, State.HEADING, State.SPEED])
        states[here] += (states[here] - states[before]) * late / step
    return states


# -- one actor --------------------------------------------------------------------------------------------------------


def _of_actor(recording: Recording, states: Floats, nanos: Ints, actor: int) -> Table:
    """Return all rows of one actor."""
    body, stretches = recording.actors[actor], recording.stretches(actor)
    code, height = KINDS[body.kind].code, KINDS[body.kind].height
    rows = np.concatenate([np.arange(first, last + 1) for first, last in stretches] or [np.zeros(0, np.int64)])
    own = states[:, actor]
    moving = [_motion(recording, own, first, last, body.rear_to_center) for first, last in stretches]
    velocity, acceleration = (np.concatenate([part[i] for part in moving] or [np.zeros((0, 2))]) for i in (0, 1))
    heights = recording.heights
    constant = {"length": body.length, "width": body.width, "height": height}
    zero = dict.fromkeys(("vel_z", "acc_z", "roll", "pitch"), 0.0)
    whole = {"idx": actor, "type": code.type, "role": code.role, "subtype": code.subtype}
    return {
        "total_nanos": nanos[rows],
        "x": own[rows, State.X],
        "y": own[rows, State.Y],
        "z": height / 2 + (np.zeros(len(rows)) if heights is None else heights[rows, actor]),
        "yaw": wrapped(own[rows, State.HEADING]),
        "vel_x": velocity[:, 0],
        "vel_y": velocity[:, 1],
        "acc_x": acceleration[:, 0],
        "acc_y": acceleration[:, 1],
        SLIDES: (own[rows, State.PRESENT] == SLIDING).astype(np.int64),
        **{name: np.full(len(rows), value) for name, value in (constant | zero).items()},
        **{name: np.full(len(rows), value, dtype=np.int64) for name, value in whole.items()},
    }


def _motion(recording: Recording, own: Floats, first: int, last: int, behind: float) -> tuple[Floats, Floats]:
    """Return velocity and acceleration of the centre over one stretch, (samples, 2) each.

    While driven: the rear axle's speed along the heading, plus the swing about it. While it slides, the swing follows
    from its positions; after contact, where wheels no longer roll, the whole velocity does.
    """
    time, own = recording.time[first : last + 1], own[first : last + 1]
    driven = min(max(recording.scored_samples() - first, 0), len(own))
    heading, speed = own[:driven, State.HEADING], own[:driven, State.SPEED]
    places = own[:, [State.X, State.Y]]
    seen = (rates(time[:driven], places[:driven]) * across(heading)).sum(axis=1)
    slides = own[:driven, State.PRESENT] == SLIDING
    swing = np.where(slides, seen, behind * rates(time[:driven], heading))
    velocity = rates(time, places)
    velocity[:driven] = speed[:, np.newaxis] * along(heading) + swing[:, np.newaxis] * across(heading)
    return velocity, rates(time, velocity)


def wrapped(heading: Floats) -> Floats:
    """Return headings in (-pi, pi]; headings in this range keep every digit."""
    inside = (heading > -math.pi) & (heading <= math.pi)
    return np.where(inside, heading, math.pi - np.mod(math.pi - heading, 2.0 * math.pi))


# -- remarks ----------------------------------------------------------------------------------------------------------


def _remarks(recording: Recording, *, has_road: bool = False) -> tuple[str, ...]:
    """Return remarks on facts that these columns cannot hold, and, without the road in its metadata, the file."""
    road = "" if has_road else ", and nothing of the road"
    remarks = [f"omega-prime's columns hold neither steering angles nor pedals{road}"]
    if not has_road and recording.buildings is not None and len(recording.buildings):
        remarks.append("CSV has no place for buildings: who reads it judges an ego that runs into one as if it went on")
    if again := [actor.name for index, actor in enumerate(recording.actors) if len(recording.stretches(index)) > 1]:
        names = ", ".join(again)
        remarks.append(f"omega-prime's own check wants no gap in an actor's rows; {names} comes back after one")
    if recording.contact is not None:
        remarks.append("times are whole nanoseconds: the row of first contact is the next one, less than 1e-7 m on")
    return tuple(remarks)
