"""A trace of ASAM OSI: a sequence of messages `GroundTruth`, each after its length, or those of an MCAP.

Source: ASAM Open Simulation Interface 3.7, `osi_groundtruth.proto`, `osi_object.proto`, `osi_common.proto`, and "OSI
trace files" (a length is an unsigned number of 32 bits, its lowest byte first); Protocol Buffers, "Encoding". Only the
few fields of motion are decoded, so that no package is needed for them. Positions and velocities are those of the
boxes' centres, in metres, radians and m/s.
"""

import struct
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from engine.errors import InterchangeError, reading
from engine.interchange.kinds import UNSET, Code, kind_of
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.tables.layouts import Layout, Point
from engine.interchange.tables.track import Tracks
from engine.unread import Unread
from engine.vocabulary import ActorKind

LONGEST = 100_000_000
"""Maximum length of one message [bytes]."""
KEYS = ("time", "actor", "x", "y", "z", "heading", "vel_x", "vel_y", "length", "width", "type", "role")
LAYOUT = Layout(
    name="OSI",
    known_by=(),
    columns={"actor": "id", "heading": "orientation.yaw"},
    point=Point.CENTER,
    said="positions and velocities are those of the boxes' centres",
    kinds={kind.name.lower(): kind for kind in ActorKind},
)
VARINT, DOUBLE, BYTES, FLOAT = 0, 1, 2, 5
"""Wire types."""
VERSION, STAMP, HOST, MOVING = 1, 2, 3, 5
"""Fields of a `GroundTruth` that are read, and its version."""
OTHERS = {
    4: "stationary_object",
    6: "traffic_sign",
    7: "traffic_light",
    8: "road_marking",
    9: "lane_boundary",
    10: "lane",
    11: "occupant",
    12: "environmental_conditions",
    13: "country_code",
    14: "proj_string",
    15: "map_reference",
    16: "model_reference",
    17: "reference_line",
    18: "logical_lane_boundary",
    19: "logical_lane",
    20: "proj_frame_offset",
}
"""Names of the fields that are not read."""
OF_OBJECT = {
    4: "assigned_lane_id",
    5: "vehicle_attributes",
    7: "model_reference",
    8: "future_trajectory",
    9: "moving_object_classification",
    10: "source_reference",
}
OF_CLASSIFICATION = {2: "light_state", 3: "has_trailer", 4: "trailer_id"}
OF_BASE = {5: "acceleration", 6: "orientation_rate", 7: "orientation_acceleration", 8: "base_polygon"}
OF_ORIENTATION = {1: "roll", 2: "pitch"}
"""Names of the fields of a moving object that are not read."""
Message = dict[int, list[int | float | bytes]]
"""Values by field number."""


def read_osi(path: Path) -> Tracks:
    """Return the tracks of a trace.

    Raises:
        InterchangeError: unreadable, not such a trace, truncated, or without moving objects.
    """
    with reading(path), path.open("rb") as file:
        return tracks_of_messages(path, _messages(file, path.name))


def tracks_of_messages(path: Path, messages: Iterable[bytes]) -> Tracks:
    """Return the tracks of messages `GroundTruth`, in their order.

    Raises:
        InterchangeError: a message cannot be decoded, or there is no motion.
    """
    unread = Unread()
    tracks = tracks_of_rows(path, LAYOUT, KEYS, _rows(messages, path.name, unread))
    return replace(tracks, remarks=(*tracks.remarks, *unread.notes()))


def _messages(file: BinaryIO, name: str) -> Iterator[bytes]:
    number = 0
    while head := file.read(4):
        number += 1
        size = struct.unpack("<I", head)[0] if len(head) == 4 else LONGEST + 1
        content = file.read(size) if size <= LONGEST else b""
        if len(content) < size:
            cure = "let it be written to its end; a trace of OSI holds messages behind their lengths"
            message = "the message is cut off, or this is not a trace of OSI"
            raise InterchangeError(message, cure, f"{name}, message {number}")
        yield content


def _rows(messages: Iterable[bytes], name: str, unread: Unread) -> Iterator[Row]:
    for number, content in enumerate(messages, start=1):
        try:
            truth = fields(content)
            for each in truth.keys() - {VERSION, STAMP, HOST, MOVING}:
                unread.add(OTHERS.get(each, f"field {each}"), f"{name}, message {number}")
            yield from ((number, row) for row in _moving(truth, unread, f"{name}, message {number}"))
        except (ValueError, struct.error, OverflowError):
            cure = "name a trace of GroundTruth, in protobuf's binary form"
            raise InterchangeError("the message cannot be decoded", cure, f"{name}, message {number}") from None


def _moving(truth: Message, unread: Unread, place: str) -> Iterator[dict[str, float | str]]:
    """Yield all moving objects, at the time of a `GroundTruth`; fields that are not read are added to `unread`."""
    stamp = _inner(truth, STAMP)
    time = _whole(stamp, 1) + _whole(stamp, 2) / 1e9
    host = _whole(_inner(truth, HOST), 1, UNSET)
    for content in truth.get(MOVING, ()):
        thing = fields(_bytes(content))
        own, base, kind = _whole(_inner(thing, 1), 1), _inner(thing, 2), _inner(thing, 6)
        size, at, turned, velocity = (_inner(base, field) for field in (1, 2, 3, 4))
        for holder, names in ((thing, OF_OBJECT), (kind, OF_CLASSIFICATION), (base, OF_BASE), (turned, OF_ORIENTATION)):
            for field in holder.keys() & names.keys():
                if _says_something(holder[field]):
                    unread.add(f"moving_object.{names[field]}", place)
        code = Code(_whole(thing, 3), _whole(kind, 5, UNSET), _whole(kind, 1, UNSET))
        found = kind_of(code)
        yield {
            "time": time,
            "actor": str(own),
            "x": _real(at, 1),
            "y": _real(at, 2),
            "z": _real(at, 3),
            "heading": _real(turned, 3),
            "vel_x": _real(velocity, 1),
            "vel_y": _real(velocity, 2),
            "length": _real(size, 1),
            "width": _real(size, 2),
            "type": "" if found is None else found.name.lower(),
            "role": "ego" if own == host else "",
        }


def _says_something(values: list[int | float | bytes]) -> bool:
    """Return False for zeros, and for messages of nothing else."""
    return any(_is_stated(value) if isinstance(value, bytes) else value for value in values)


def _is_stated(content: bytes) -> bool:
    try:
        return any(map(_says_something, fields(content).values()))
    except (ValueError, struct.error):
        return True  # a text


# -- Protocol Buffers --------------------------------------------------------------------------------------------------


def fields(content: bytes) -> Message:
    """Return the fields of a message.

    Raises:
        ValueError: the content is not a message.
    """
    found: Message = {}
    at = 0
    while at < len(content):
        key, at = _varint(content, at)
        value: int | float | bytes
        if key & 7 == VARINT:
            value, at = _varint(content, at)
        elif key & 7 == BYTES:
            size, at = _varint(content, at)
            value, at = content[at : at + size], at + size
        elif key & 7 in (DOUBLE, FLOAT):
            form, size = ("<d", 8) if key & 7 == DOUBLE else ("<f", 4)
            value, at = struct.unpack(form, content[at : at + size])[0], at + size
        else:
            raise ValueError("no such wire type")
        if at > len(content):
            raise ValueError("cut off")
        found.setdefault(key >> 3, []).append(value)
    return found


def _varint(content: bytes, at: int) -> tuple[int, int]:
    """Return a whole number, seven bits per byte, and the position after it."""
    value = 0
    for shift in range(0, 70, 7):
        if at >= len(content):
            break
        byte, at = content[at], at + 1
        value |= (byte & 127) << shift
        if byte < 128:
            return value, at
    raise ValueError("a number without end")


def _inner(message: Message, field: int) -> Message:
    """Return the message in a field; an empty message without the field."""
    return fields(_bytes(message[field][-1])) if field in message else {}


def _bytes(value: float | bytes) -> bytes:
    if not isinstance(value, bytes):
        raise ValueError("a number where a message should be")
    return value


def _whole(message: Message, field: int, default: int = 0) -> int:
    value = message.get(field, [default])[-1]
    if not isinstance(value, int):
        raise ValueError("no whole number")
    return value


def _real(message: Message, field: int) -> float:
    value = message.get(field, [0.0])[-1]
    if not isinstance(value, float):
        raise ValueError("no number")
    return value
