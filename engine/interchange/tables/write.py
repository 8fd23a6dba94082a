"""Trajectories in omega-prime's columns: one row for each actor and instant, as CSV or Parquet.

x, y, z is the centre of the box, velocities and accelerations are the centre's, yaw lies in (-pi, pi], an actor's idx
is its number in the recording, the ego's 0. A time is a whole number of nanoseconds, which the instant of contact is
not: its row stands at the next one, with all actors where linear motion has them then, less than 1e-7 m on. A reader
searches contact again, so nothing is lost by that. Where others strike one another before, a column more than
omega-prime has tells at which samples an actor slides: those that follow from nothing but the places.

Source: omega-prime 0.3, its specification and `schemas.py` (ika, RWTH Aachen); its columns are those of ASAM OSI.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.interchange.contract import Export, InterchangeError
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
"""Columns of whole numbers; the others are metres, seconds and radians."""
EXACT = 1e-3
"""Nanoseconds by which a time may miss a whole number of them and still be it: of a day, the last digit of a float."""

Table = Mapping[str, NDArray[Any]]
"""One array a column, row-aligned."""


def write_csv(recording: Recording, stem: str) -> Export:
    """`<stem>.csv`: a line of names, then rows in the order of time and idx; numbers read back to the same values. A
    column more than omega-prime has, which its reader lets stand, holds the actors' names.

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
    """`<stem>.parquet`: the same table; which idx is the ego's, the names, and the `road`, by name and as OpenDRIVE,
    where it is known, stand in the file's metadata.

    Raises:
        InterchangeError: pyarrow is not installed; two samples share a nanosecond.
    """
    names = [actor.name for actor in recording.actors]
    content = parquet_bytes(omega_prime_table(recording), names, road)
    return Export({f"{stem}.parquet": content}, _remarks(recording, has_road=road is not None))


def omega_prime_table(recording: Recording) -> Table:
    """The columns of omega-prime, all samples of all who are there; and who slides when, where anybody does."""
    nanos = _nanos(recording)
    states = _on_nanoseconds(recording, nanos)
    parts = [_of_actor(recording, states, nanos, actor) for actor in range(len(recording.actors))]
    columns = [*COLUMNS, SLIDES] if recording.slides.any() else COLUMNS
    joined = {name: np.concatenate([part[name] for part in parts]) for name in columns}
    order = np.lexsort((joined["idx"], joined["total_nanos"]))
    return {name: column[order] for name, column in joined.items()}


def _texts(column: NDArray[Any]) -> list[str]:
    """Numbers that are not whole by their nature have a point, so that readers guess one type for all rows."""
    return [repr(value + 0.0) if isinstance(value, float) else str(value) for value in column.tolist()]


def _cell(text: str) -> str:
    """As CSV has a text that may hold its own signs (RFC 4180)."""
    return '"{}"'.format(text.replace('"', '""')) if set(text) & set(',"\r\n') else text


# -- time -------------------------------------------------------------------------------------------------------------


def _nanos(recording: Recording) -> Ints:
    """(samples,) int64: steps at the nearest nanosecond, contact at the first that is not before it."""
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
    """The states, those of contact carried on to its nanosecond."""
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
    """All rows of one actor."""
    body, stretches = recording.actors[actor], recording.stretches(actor)
    code, height = KINDS[body.kind].code, KINDS[body.kind].height
    rows = np.concatenate([np.arange(first, last + 1) for first, last in stretches] or [np.zeros(0, np.int64)])
    own = states[:, actor]
    moving = [_motion(recording, own, first, last, body.rear_to_center) for first, last in stretches]
    velocity, acceleration = (np.concatenate([part[i] for part in moving] or [np.zeros((0, 2))]) for i in (0, 1))
    constant = {"z": height / 2, "length": body.length, "width": body.width, "height": height}
    zero = dict.fromkeys(("vel_z", "acc_z", "roll", "pitch"), 0.0)
    whole = {"idx": actor, "type": code.type, "role": code.role, "subtype": code.subtype}
    return {
        "total_nanos": nanos[rows],
        "x": own[rows, State.X],
        "y": own[rows, State.Y],
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
    """Velocity and acceleration of the centre over one stretch, (samples, 2) each.

    While it is driven: the rear axle's speed along the heading, and the swing about it. While it slides it swings as
    its positions say, and after contact, where nothing rolls any more, moves so.
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
    """Headings in (-pi, pi]; those that lie there keep every digit."""
    inside = (heading > -math.pi) & (heading <= math.pi)
    return np.where(inside, heading, math.pi - np.mod(math.pi - heading, 2.0 * math.pi))


# -- remarks ----------------------------------------------------------------------------------------------------------


def _remarks(recording: Recording, *, has_road: bool = False) -> tuple[str, ...]:
    """What these columns cannot hold, and, without the road in its metadata, the file."""
    road = "" if has_road else ", and nothing of the road"
    remarks = [f"omega-prime's columns hold neither steering angles nor pedals{road}"]
    if not has_road and recording.buildings is not None and len(recording.buildings):
        remarks.append("CSV has no place for buildings: who reads it judges an ego that runs into one as if it went on")
    if again := _those_who_come_back(recording):
        names = ", ".join(again)
        remarks.append(f"omega-prime's own check wants no gap in an actor's rows; {names} comes back after one")
    if recording.contact is not None:
        remarks.append("times are whole nanoseconds: the row of first contact is the next one, less than 1e-7 m on")
    return tuple(remarks)


def _those_who_come_back(recording: Recording) -> Sequence[str]:
    return [actor.name for index, actor in enumerate(recording.actors) if len(recording.stretches(index)) > 1]
