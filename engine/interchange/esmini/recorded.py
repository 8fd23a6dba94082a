"""Reader of an `.xosc` that requires a simulator: esmini plays it, and its states are read as a recording."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from engine.errors import InterchangeError
from engine.interchange.esmini import answer_of
from engine.interchange.logs.esmini import KEYS, LAYOUT
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.tables.track import Tracks
from engine.vocabulary import ActorKind

STEP = 0.05
"""Default time between samples [s]."""
LONGEST = 600.0
"""Maximum duration of a recording [s], for scenarios without an end."""
VEHICLE, PEDESTRIAN = 1, 2
"""Types of esmini's objects; all others are things. Source: esmini 3.6.0, `Entities.hpp`, as for `CATEGORIES`."""
CATEGORIES = (
    *(ActorKind.CAR, ActorKind.CAR),
    *(ActorKind.TRUCK, ActorKind.TRUCK, ActorKind.TRUCK),
    *(ActorKind.BUS, ActorKind.MOTORCYCLE, ActorKind.BICYCLE, ActorKind.BUS, ActorKind.BUS),
)
"""Kinds of vehicle categories: car and van; truck, semitrailer, trailer; bus, motorbike, bicycle, train, tram."""
PLAYED = replace(LAYOUT, name="esmini", kinds={kind.name.lower(): kind for kind in ActorKind})


def play_and_record(library: Path, path: Path, step: float | None = None) -> Tracks:
    """Return the motion of all actors, in steps [s], until the scenario stops or for ten minutes.

    Raises:
        InterchangeError: esmini does not open it, crashes, takes too long, too much memory, or is not esmini.
    """
    with TemporaryDirectory() as folder:
        job = {"library": str(library), "file": str(path.resolve()), "step": step or STEP, "until": LONGEST}
        answer = answer_of(job, Path(folder), path.name)
    if not answer["rows"]:
        raise InterchangeError("no actor is present when esmini plays it", "look into the file", path.name)
    return tracks_of_rows(path, PLAYED, (*KEYS, "type"), _rows(answer["rows"]))


def _rows(rows: list[list[Any]]) -> Iterator[Row]:
    for number, (time, name, x, y, heading, z, speed, length, width, kind, category) in enumerate(rows, 1):
        pose = {"time": time, "actor": name, "x": x, "y": y, "z": z, "heading": heading, "speed": speed}
        yield number, {**pose, "length": length, "width": width, "type": _kind(kind, category).name.lower()}


def _kind(kind: int, category: int) -> ActorKind:
    if kind == VEHICLE:
        return CATEGORIES[category] if 0 <= category < len(CATEGORIES) else ActorKind.CAR
    return ActorKind.PEDESTRIAN if kind == PEDESTRIAN else ActorKind.OBSTACLE
