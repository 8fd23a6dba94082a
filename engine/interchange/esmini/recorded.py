"""An `.xosc` that only a simulator can work out: esmini plays it, and what it saw is read as any recording is."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from engine.interchange.contract import InterchangeError
from engine.interchange.esmini import answer_of
from engine.interchange.logs.esmini import KEYS, LAYOUT
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.tables.track import Tracks
from engine.vocabulary import ActorKind

STEP = 0.05
"""From one sample to the next, unless another is asked for [s]."""
LONGEST = 600.0
"""A scenario without an end is recorded for so long [s]."""
VEHICLE, PEDESTRIAN = 1, 2
"""Types of esmini's objects; others are things. Source: esmini 3.6.0, `Entities.hpp`, as the next."""
CATEGORIES = (
    *(ActorKind.CAR, ActorKind.CAR),
    *(ActorKind.TRUCK, ActorKind.TRUCK, ActorKind.TRUCK),
    *(ActorKind.BUS, ActorKind.MOTORCYCLE, ActorKind.BICYCLE, ActorKind.BUS, ActorKind.BUS),
)
"""Of vehicles: car and van; truck, semitrailer and trailer; bus, motorbike, bicycle, train, tram."""
PLAYED = replace(LAYOUT, name="esmini", kinds={kind.name.lower(): kind for kind in ActorKind})


def play_and_record(library: Path, path: Path, step: float | None = None) -> Tracks:
    """Who was where when, in steps [s], until the scenario stops or for ten minutes.

    Raises:
        InterchangeError: esmini does not open it, crashes, takes too long, too much memory, or is no esmini.
    """
    with TemporaryDirectory() as folder:
        job = {"library": str(library), "file": str(path.resolve()), "step": step or STEP, "until": LONGEST}
        answer = answer_of(job, Path(folder), path.name)
    if not answer["rows"]:
        raise InterchangeError("no actor is present when esmini plays it", "look into the file", path.name)
    return tracks_of_rows(path, PLAYED, (*KEYS, "type"), _rows(answer["rows"]))


def _rows(rows: list[list[Any]]) -> Iterator[Row]:
    for number, (time, name, x, y, heading, speed, length, width, kind, category) in enumerate(rows, 1):
        pose = {"time": time, "actor": name, "x": x, "y": y, "heading": heading, "speed": speed}
        yield number, {**pose, "length": length, "width": width, "type": _kind(kind, category).name.lower()}


def _kind(kind: int, category: int) -> ActorKind:
    if kind == VEHICLE:
        return CATEGORIES[category] if 0 <= category < len(CATEGORIES) else ActorKind.CAR
    return ActorKind.PEDESTRIAN if kind == PEDESTRIAN else ActorKind.OBSTACLE
