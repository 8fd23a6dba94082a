"""MCAP for Foxglove, Lichtblick and rerun: the scene as `foxglove.SceneUpdate`, and the numbers of each sample.

Topics: `/road` once at the start, `/actors` and `/numbers` at each sample; JSON, one frame, times from the recording's
start. Field names and numbers of kinds are those of Foxglove's published message schemas. Bytes are not compressed, so
equal cases give equal files.
"""

import math
from collections.abc import Iterator, Mapping
from io import BytesIO
from typing import Any

import numpy as np

from engine.errors import InterchangeError
from engine.extras import MissingExtraError, needed
from engine.interchange.contract import Export
from engine.interchange.kinds import KINDS
from engine.interchange.recording import RecordedActor, Recording
from engine.kernels.geometry import Box, box_distance
from engine.maps import MapSpec
from engine.road import build_network
from engine.road.outline import outline
from engine.strict_json import json_text
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, State

# -- scenes: boxes of participants, lines of the road, in one frame ----------------------------------------------------

FRAME = "map"
EGO, OTHERS, THINGS = (0.95, 0.45, 0.1), (0.25, 0.45, 0.75), (0.5, 0.5, 0.5)
"""Colours, as red, green, blue."""
KERB, MARKING, STOP = (0.55, 0.55, 0.55), (0.85, 0.85, 0.85), (1.0, 1.0, 1.0)
LINE_STRIP = 0
"""Foxglove's number of lines from point to point."""
DELETE_ID = 0
"""Foxglove's number for the deletion of one entity."""
Message = dict[str, Any]


def _scene(entities: list[Message], deletions: list[Message] | None = None) -> Message:
    return {"deletions": deletions or [], "entities": entities}


def actors_scene(recording: Recording, sample: int, instant: int) -> Message:
    """Return the boxes of all present actors, and deletions of those that were present one sample before."""
    there, heights = recording.there, recording.heights
    gone = there[max(sample - 1, 0)] & ~there[sample]
    ground = [0.0] * len(recording.actors) if heights is None else heights[sample].tolist()
    entities = [
        _entity(actor.name, instant, cubes=[_cube(actor, recording.states[sample, i], i == 0, ground[i])])
        for i, actor in enumerate(recording.actors)
        if there[sample, i]
    ]
    stamp = _stamp(instant)
    names = [actor.name for actor, left in zip(recording.actors, gone, strict=True) if left]
    return _scene(entities, [{"timestamp": stamp, "type": DELETE_ID, "id": name} for name in names])


def _cube(actor: RecordedActor, state: Floats, is_ego: bool, ground: float) -> Message:
    height, heading = KINDS[actor.kind].height, float(state[State.HEADING])
    colour = EGO if is_ego else THINGS if actor.kind is ActorKind.OBSTACLE else OTHERS
    return {
        "pose": {
            "position": {"x": float(state[State.X]), "y": float(state[State.Y]), "z": ground + 0.5 * height},
            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * heading), "w": math.cos(0.5 * heading)},
        },
        "size": {"x": actor.length, "y": actor.width, "z": height},
        "color": _colour(colour),
    }


def road_scene(spec: MapSpec) -> Message:
    """Return all lines of a road, without an end of display."""
    drawn = outline(build_network(spec))
    lines = [
        *(_line(line, KERB, 0.15) for line in drawn.kerbs),
        *(_line(line, MARKING, 0.12) for line in (*drawn.middle_lines, *drawn.lane_lines)),
        *(_line(line, STOP, 0.3) for line in drawn.stop_lines),
    ]
    return _scene([_entity("road", 0, lines=lines)])


def _line(points: Floats, colour: tuple[float, float, float], thickness: float) -> Message:
    identity = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {
        "type": LINE_STRIP,
        "pose": identity,
        "thickness": thickness,
        "scale_invariant": False,
        "points": [{"x": x, "y": y, "z": 0.0} for x, y in points.tolist()],
        "color": _colour(colour),
        "colors": [],
        "indices": [],
    }


def _entity(
    name: str, instant: int, *, cubes: list[Message] | None = None, lines: list[Message] | None = None
) -> Message:
    """Return an entity that is displayed until it is replaced or deleted."""
    shapes = {"arrows": [], "cubes": cubes or [], "spheres": [], "cylinders": [], "lines": lines or []}
    return {
        "timestamp": _stamp(instant),
        "frame_id": FRAME,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        "metadata": [],
        **shapes,
        "triangles": [],
        "texts": [],
        "models": [],
    }


def _stamp(instant: int) -> dict[str, int]:
    seconds, nanoseconds = divmod(instant, 10**9)
    return {"sec": seconds, "nsec": nanoseconds}


def _colour(rgb: tuple[float, float, float]) -> dict[str, float]:
    return {**dict(zip("rgb", rgb, strict=True)), "a": 1.0}


# -- contents of the messages, as JSON Schema; only fields with values


def _object(**properties: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list(items: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_NUMBER, _WHOLE, _TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
_VECTOR = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_POSE = _object(position=_VECTOR, orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER))
_TIME = _object(sec=_WHOLE, nsec=_WHOLE)
_COLOUR = _object(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_CUBE = _object(pose=_POSE, size=_VECTOR, color=_COLOUR)
_LINE = _object(
    type=_WHOLE,
    pose=_POSE,
    thickness=_NUMBER,
    scale_invariant={"type": "boolean"},
    points=_list(_VECTOR),
    color=_COLOUR,
)
_ENTITY = _object(
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_TIME,
    frame_locked={"type": "boolean"},
    cubes=_list(_CUBE),
    lines=_list(_LINE),
)
SCENE_UPDATE = _object(
    deletions=_list(_object(timestamp=_TIME, type=_WHOLE, id=_TEXT)), entities=_list(_ENTITY)
)  # fmt: skip

# -- the file ----------------------------------------------------------------------------------------------------------

ACTORS = "actors"
"""Name of the metadata with the kind of each actor."""
NUMBERS = {
    "speed": State.SPEED,
    "acceleration": State.ACCELERATION,
    "steer": State.STEER,
    "throttle": State.THROTTLE,
    "brake": State.BRAKE,
}

SLIDES = "slides"
"""Number of an actor that slides after an impact."""


def write_mcap(recording: Recording, stem: str) -> Export:
    """Write `<stem>.mcap`.

    Raises:
        InterchangeError: the package mcap is not installed, the recording is empty, or a state is not a finite number.
    """
    recording.refuse_broken()
    writer, out = _writer()
    _write(writer, recording.from_zero())
    return Export({f"{stem}.mcap": out.getvalue()}, tuple(_remarks(recording)))


def _writer() -> tuple[Any, BytesIO]:
    try:
        package = needed("mcap.writer", "MCAP needs", "export")
    except MissingExtraError as missing:
        raise InterchangeError("MCAP needs the package mcap", missing.cure) from missing
    out = BytesIO()
    return package.Writer(out, compression=package.CompressionType.NONE), out


def _remarks(recording: Recording) -> Iterator[str]:
    yield "the boxes' heights are usual ones of their kind: a recording has none"
    if recording.signals is not None:
        yield "traffic lights are not shown"


def _write(writer: Any, recording: Recording) -> None:
    """Write the whole file, message by message in the order of time."""
    writer.start(profile="", library="cortexc")
    writer.add_metadata("recording", _facts(recording))
    writer.add_metadata(ACTORS, {actor.name: _what(actor, i == 0) for i, actor in enumerate(recording.actors)})
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
    name, schema = ("cortexc.Numbers", _NUMBERS_SCHEMA) if is_numbers else ("foxglove.SceneUpdate", SCENE_UPDATE)
    number = writer.register_schema(name=name, encoding="jsonschema", data=_bytes(schema))
    return writer.register_channel(topic=topic, message_encoding="json", schema_id=number)


def _add(writer: Any, channel: int, sequence: int, instant: int, message: Message) -> None:
    writer.add_message(channel, log_time=instant, publish_time=instant, sequence=sequence, data=_bytes(message))


def _bytes(value: Mapping[str, Any]) -> bytes:
    return json_text(value, separators=(",", ":")).encode()


def _facts(recording: Recording) -> dict[str, str]:
    origin = recording.provenance
    names = {"name": recording.name, "title": origin.title, "author": origin.author, "date": origin.date}
    contact = {} if recording.contact is None else {"contact": repr(recording.contact.time)}
    return {**names, **contact, **origin.facts, **origin.genome}


def _what(actor: RecordedActor, is_ego: bool) -> str:
    """Return the facts of an actor that its box does not contain, so that it can be read back."""
    facts = {"kind": actor.kind.name.lower(), "rear_to_center": actor.rear_to_center, "ego": is_ego}
    return json_text(facts, separators=(",", ":"))


# -- numbers


def _gaps(recording: Recording) -> dict[int, tuple[Floats, Floats]]:
    """Return per other actor the distance between its outline and the ego's [m], and their closing speed [m/s].

    NaN unless both are present. Closing speeds are differences of centre distances between neighbouring samples.
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
    """Return the numbers of all present actors, by name."""
    message: Message = {}
    there = recording.there[sample]
    for i, actor in enumerate(recording.actors):
        state = recording.states[sample, i]
        if not there[i]:
            continue
        message[actor.name] = {name: float(state[column]) for name, column in NUMBERS.items()}
        if state[State.PRESENT] == SLIDING:
            message[actor.name][SLIDES] = 1.0
        if i in gaps:
            between = zip(("distance", "closing_speed"), (float(each[sample]) for each in gaps[i]), strict=True)
            message[actor.name].update({name: value for name, value in between if math.isfinite(value)})
    return message


# -- what they are, as JSON Schema

_NUMBER_SCHEMA = {"type": "number"}
_NUMBERS_SCHEMA = {"type": "object", "additionalProperties": {"type": "object", "additionalProperties": _NUMBER_SCHEMA}}
