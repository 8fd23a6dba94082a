"""SUMO's floating car data, `--fcd-output FILE.xml`: the states of all actors in each time step.

Source: SUMO's documentation, "FCD output": x and y are the front bumper's middle [m], `angle` counts clockwise from
north [degrees], `speed` [m/s]. Sizes are not in it; those of SUMO's vehicle classes are used.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from engine.errors import InterchangeError
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.tables.layouts import SUMO_SAID, SUMO_SIZES, Layout, Point
from engine.interchange.tables.track import Tracks
from engine.unread import unread_elements
from engine.vocabulary import ActorKind
from engine.xml import Limits, Node, read_xml

LIMITS = Limits(megabytes=300.0, elements=3_000_000, all_attributes=36_000_000)
KEYS = ("time", "actor", "x", "y", "z", "heading", "speed", "type")
LAYOUT = Layout(
    name="SUMO's FCD output",
    known_by=(),
    columns={"actor": "id", "heading": "angle"},
    point=Point.FRONT,
    said=SUMO_SAID,
    compass=True,
    kinds={"person": ActorKind.PEDESTRIAN, "container": ActorKind.OBSTACLE},
    sizes=SUMO_SIZES,
)
_ACTOR = ("id", "x", "y", "z", "angle", "speed", "type")
READ = {"fcd-export": None, "timestep": ("time",), **dict.fromkeys(("vehicle", "person", "container"), _ACTOR)}
"""Elements that are read, with their attributes."""
GEO_EXTENT = 1.0
"""Degrees: every network spans less. Positions that span less, with a speed above it, are not metres."""


def read_fcd(path: Path) -> Tracks:
    """Return the tracks of an FCD output.

    Raises:
        InterchangeError: unreadable, not an FCD output, or positions in degrees of longitude and latitude.
    """
    root = read_xml(path, "fcd-export", LIMITS)
    rows = list(_rows(root))
    _refuse_degrees(path, rows)
    tracks = tracks_of_rows(path, LAYOUT, KEYS, rows)
    return replace(tracks, remarks=(*tracks.remarks, *unread_elements(root, READ)))


def _rows(root: Node) -> Iterator[Row]:
    for step in root.every("timestep"):
        time = step.number("time")
        for node in step.children:
            if node.tag not in READ:
                continue
            yield (
                node.line,
                {
                    "time": time,
                    "actor": node.text("id"),
                    "x": node.number("x"),
                    "y": node.number("y"),
                    "z": node.number("z", 0.0),
                    "heading": math.radians(node.number("angle")),
                    "speed": node.number("speed"),
                    "type": node.tag if node.tag in LAYOUT.kinds else node.text("type", ""),
                },
            )


def _refuse_degrees(path: Path, rows: list[Row]) -> None:
    """Raise InterchangeError if positions hardly change during fast motion: they are longitude and latitude."""
    spans = [_span(rows, "x"), _span(rows, "y")]
    fast = any(float(row["speed"]) > GEO_EXTENT for _, row in rows)
    long = _span(rows, "time") > 10.0
    if rows and fast and long and max(spans) < GEO_EXTENT:
        message = "its positions are degrees of longitude and latitude"
        raise InterchangeError(message, "write it again without --fcd-output.geo", path.name)


def _span(rows: list[Row], key: str) -> float:
    values = [float(row[key]) for _, row in rows]
    return max(values) - min(values) if values else 0.0
