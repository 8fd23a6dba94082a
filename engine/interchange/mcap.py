"""MCAP for Foxglove, Lichtblick and rerun: who is where as `foxglove.SceneUpdate`, and the numbers of each sample.

Topics: `/road` once at the start, `/actors` and `/numbers` at each sample; JSON, one frame, times from the recording's
start. Field names are those of Foxglove's message schemas. Bytes are not compressed: the same case is the same file.
"""

import json
import math
from collections.abc import Iterator, Mapping
from importlib import import_module
from io import BytesIO
from typing import Any

import numpy as np

from engine.extras import installing
from engine.interchange.errors import InterchangeError
from engine.interchange.export import Export
from engine.interchange.foxglove import SCENE_UPDATE, Message, actors_scene, road_scene
from engine.interchange.recording import Recording
from engine.kernels.geometry import Box, box_distance
from engine.tables import Floats
from engine.vocabulary import State

NUMBERS = {
    "speed": State.SPEED,
    "acceleration": State.ACCELERATION,
    "steer": State.STEER,
    "throttle": State.THROTTLE,
    "brake": State.BRAKE,
}


def write_mcap(recording: Recording, stem: str) -> Export:
    """`<stem>.mcap`.

    Raises:
        InterchangeError: the package mcap is not installed, nothing was recorded, or a state is not a finite number.
    """
    recording.refuse_broken()
    writer, out = _writer()
    _write(writer, recording.from_zero())
    return Export({f"{stem}.mcap": out.getvalue()}, tuple(_remarks(recording)))


def _writer() -> tuple[Any, BytesIO]:
    try:
        package = import_module("mcap.writer")
    except ImportError as missing:
        raise InterchangeError("MCAP needs the package mcap", installing("export")) from missing
    out = BytesIO()
    return package.Writer(out, compression=package.CompressionType.NONE), out


def _remarks(recording: Recording) -> Iterator[str]:
    yield "the boxes' heights are usual ones of their kind: a recording has none"
    if recording.signals is not None:
        yield "traffic lights are not shown"


def _write(writer: Any, recording: Recording) -> None:
    """The whole file, message by message in the order of time."""
    writer.start(profile="", library="cortexc")
    writer.add_metadata("recording", _facts(recording))
    road, actors, numbers = (_topic(writer, topic) for topic in ("/road", "/actors", "/numbers"))
    if recording.road is not None:
        _add(writer, road, 0, 0, road_scene(recording.road))
    gaps = _gaps(recording)
    for sample, time in enumerate(recording.time.tolist()):
        instant = round(time * 1e9)
        _add(writer, actors, sample, instant, actors_scene(recording, sample, instant))
        _add(writer, numbers, sample, instant, _numbers(recording, sample, gaps))
    writer.finish()


def _topic(writer: Any, topic: str) -> int:
    is_numbers = topic == "/numbers"
    name, schema = ("cortexc.Numbers", _NUMBERS) if is_numbers else ("foxglove.SceneUpdate", SCENE_UPDATE)
    number = writer.register_schema(name=name, encoding="jsonschema", data=_bytes(schema))
    return writer.register_channel(topic=topic, message_encoding="json", schema_id=number)


def _add(writer: Any, channel: int, sequence: int, instant: int, message: Message) -> None:
    writer.add_message(channel, log_time=instant, publish_time=instant, sequence=sequence, data=_bytes(message))


def _bytes(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()


def _facts(recording: Recording) -> dict[str, str]:
    origin = recording.provenance
    names = {"name": recording.name, "title": origin.title, "author": origin.author, "date": origin.date}
    contact = {} if recording.contact is None else {"contact": repr(recording.contact.time)}
    return {**names, **contact, **origin.facts, **origin.genome}


# -- numbers


def _gaps(recording: Recording) -> dict[int, tuple[Floats, Floats]]:
    """Per other actor: distance between its outline and the ego's, and how fast their centres close in; NaN where not
    both are there. Speeds of closing are differences between neighbouring samples.
    """
    return {
        other: (_distances(recording, other), _closing(recording, other)) for other in range(1, len(recording.actors))
    }


def _distances(recording: Recording, other: int) -> Floats:
    both = np.all(recording.there[:, (0, other)], axis=1)
    pairs = zip(_boxes(recording, 0), _boxes(recording, other), both, strict=True)
    return np.array([box_distance(ego, them) if there else math.nan for ego, them, there in pairs])


def _boxes(recording: Recording, actor: int) -> list[Box]:
    length, width = recording.actors[actor].length, recording.actors[actor].width
    places = recording.states[:, actor, [State.X, State.Y, State.HEADING]]
    return [Box(x, y, heading, length, width) for x, y, heading in places.tolist()]


def _closing(recording: Recording, other: int) -> Floats:
    ways = recording.states[:, other, [State.X, State.Y]] - recording.states[:, 0, [State.X, State.Y]]
    both = np.all(recording.there[:, (0, other)], axis=1)
    apart = np.where(both, np.hypot(*ways.T), math.nan)
    return -np.gradient(apart, recording.time) if len(apart) > 1 else np.full(1, math.nan)


def _numbers(recording: Recording, sample: int, gaps: dict[int, tuple[Floats, Floats]]) -> Message:
    """Of all who are there, by name."""
    message: Message = {}
    there = recording.there[sample]
    for i, actor in enumerate(recording.actors):
        state = recording.states[sample, i]
        if not there[i]:
            continue
        message[actor.name] = {name: float(state[column]) for name, column in NUMBERS.items()}
        if i in gaps:
            between = zip(("distance", "closing_speed"), (float(each[sample]) for each in gaps[i]), strict=True)
            message[actor.name].update({name: value for name, value in between if math.isfinite(value)})
    return message


# -- what they are, as JSON Schema

_NUMBER = {"type": "number"}
_NUMBERS = {"type": "object", "additionalProperties": {"type": "object", "additionalProperties": _NUMBER}}
