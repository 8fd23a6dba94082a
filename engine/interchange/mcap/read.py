"""Reader of MCAP files: those of cortexc, with boxes at `/actors`, speeds at `/numbers` and kinds in the metadata; and
those of OSI.

From OSI's messages, as in ASAM's traces of several channels and in omega-prime, motion is read, and a road. Source:
ASAM Open Simulation Interface 3.7, "OSI trace file formats" (a channel's schema is `osi3.` and the name of its message,
in protobuf), and `osi_mapasamopendrive.proto` of omega-prime 0.3.7 (field 1 a reference, 2 the OpenDRIVE).
"""

import json
import math
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from engine.errors import InterchangeError, quoted, reading
from engine.extras import MissingExtraError, needed
from engine.interchange.logs.osi import fields, tracks_of_messages
from engine.interchange.mcap.write import ACTORS, SLIDES
from engine.interchange.tables.track import TableTrack, Tracks
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind

MOST_MESSAGES = 1_000_000
TRUTH, MAP = "osi3.GroundTruth", "MapAsamOpenDrive"
REFERENCE, OPENDRIVE = 1, 2
"""Fields of a map."""
DAMAGED = (ValueError, LookupError, TypeError, AttributeError, OverflowError, RuntimeError, EOFError, struct.error)
"""Exceptions of a reader for bytes that are not an MCAP; lz4 raises RuntimeError."""
Made = TypeVar("Made")
Sample = tuple[float, ...]
"""Time [s], x, y, heading, speed, length, width, and 1 while the actor slides after an impact."""


def read_mcap(path: Path) -> Tracks:
    """Return the tracks of an MCAP.

    Raises:
        InterchangeError: mcap is not installed; the file is damaged, or of another tool.
    """
    return _opened(path, lambda reader: _tracks(reader, path))


def road_of_mcap(path: Path) -> tuple[str, bytes] | None:
    """Return reference and OpenDRIVE of the road in an MCAP of OSI's messages; None without a road.

    Raises:
        InterchangeError: as `read_mcap`.
    """
    return _opened(path, road_in)


def _opened(path: Path, read: Callable[[Any], Made]) -> Made:
    try:
        reader, broken, zstandard = (
            needed(each, "MCAP needs", "export") for each in ("mcap.reader", "mcap.exceptions", "zstandard")
        )
    except MissingExtraError as missing:
        raise InterchangeError(missing.message, f"{missing.cure}, or take CSV") from None
    try:
        with reading(path), path.open("rb") as file:
            return read(reader.make_reader(file, validate_crcs=True))
    except (broken.McapError, zstandard.ZstdError, *DAMAGED) as error:
        reason = (str(error).splitlines() or [""])[0][:120] or type(error).__name__
        message = f"this is not a readable MCAP file: {quoted(reason)[1:-1]}"
        raise InterchangeError(message, "write it again, or take CSV or Parquet", path.name) from None


def _tracks(reader: Any, path: Path) -> Tracks:
    topics = topics_of_truth(reader)
    if not topics:
        return _own_tracks(reader, path.name)
    found = tracks_of_messages(path, truths(reader, topics[0], MOST_MESSAGES, path.name))
    return replace(found, remarks=(*told_of(topics), *found.remarks))


# -- ours --------------------------------------------------------------------------------------------------------------


def _own_tracks(reader: Any, name: str) -> Tracks:
    samples: dict[str, list[Sample]] = {}
    boxes: dict[int, Mapping[str, Any]] = {}
    begin: int | None = None
    for count, (schema, channel, message) in enumerate(reader.iter_messages()):
        if count >= MOST_MESSAGES:
            raise InterchangeError(f"there are more than {MOST_MESSAGES:,} messages", "take fewer samples", name)
        _refuse_others(schema, name)
        begin = message.log_time if begin is None else begin
        if channel.topic == "/actors":
            boxes[message.log_time] = json.loads(message.data)
        elif channel.topic == "/numbers":
            numbers = json.loads(message.data)
            for entity in boxes.pop(message.log_time)["entities"]:
                seconds = (message.log_time - begin) / 1e9
                reported = numbers[entity["id"]]
                own = _sample(entity["cubes"][0], seconds, float(reported["speed"]))
                samples.setdefault(entity["id"], []).append((*own, float(reported.get(SLIDES, 0.0))))
    if not samples:
        raise InterchangeError("nobody moves in it", "record one actor at least", name)
    nothing: Mapping[str, str] = {}
    said = next((each.metadata for each in reader.iter_metadata() if each.name == ACTORS), nothing)
    remarks = [] if said else ["it does not say what its actors are: all are taken for cars"]
    tracks: list[TableTrack] = []
    for who, own in samples.items():
        track, jumps = _track(who, own, json.loads(said.get(who, "{}"))).without_jumps()
        tracks.append(track)
        remarks += jumps
    if not any(len(track.time) for track in tracks):
        raise InterchangeError("every actor in it jumps at every sample", "correct its names or units", name)
    return Tracks(tuple(track for track in tracks if len(track.time)), tuple(remarks), name)


def _refuse_others(schema: Any, name: str) -> None:
    """Raise InterchangeError for messages of other tools, which need their definitions; only `GroundTruth` is read."""
    if schema is not None and schema.encoding != "jsonschema":
        cure = "record a channel of `osi3.GroundTruth`, with the index at its end, or take a table"
        raise InterchangeError(f"its messages are {quoted(schema.name)[1:-1]}, which needs its own reader", cure, name)


def _sample(cube: Any, seconds: float, speed: float) -> Sample:
    at, turned, size = cube["pose"]["position"], cube["pose"]["orientation"], cube["size"]
    heading = 2.0 * math.atan2(turned["z"], turned["w"])
    return seconds, float(at["x"]), float(at["y"]), heading, speed, float(size["x"]), float(size["y"])


def _track(name: str, samples: list[Sample], said: Mapping[str, Any]) -> TableTrack:
    time, x, y, heading, speed, length, width, slides = np.array(samples).T
    kind = ActorKind[str(said.get("kind", "car")).upper()]
    usual = MODELS[kind].rear_to_center * float(length[0]) / MODELS[kind].length
    return TableTrack(
        label=name,
        name=name,
        kind=kind,
        is_ego=bool(said.get("ego", False)),
        time=time,
        positions=np.column_stack([x, y]),
        heading=np.unwrap(heading),
        speed=speed,
        length=float(length[0]),
        width=float(width[0]),
        rear_to_center=float(said.get("rear_to_center", usual)),
        slides=slides != 0.0,
    )


# -- those of OSI ------------------------------------------------------------------------------------------------------


def topics_of_truth(reader: Any) -> list[str]:
    """Return the topics of messages `GroundTruth`; [] if the file has no index."""
    summary = reader.get_summary()
    if summary is None:
        return []
    channels = summary.channels.values()
    return sorted(each.topic for each in channels if _schema(summary, each) == TRUTH)


def truths(reader: Any, topic: str, most: int, name: str) -> Iterator[bytes]:
    """Yield the messages of a topic, by the times at which they were logged.

    Raises:
        InterchangeError: there are more than `most`.
    """
    for count, (_, _, message) in enumerate(reader.iter_messages(topics=[topic])):
        if count >= most:
            raise InterchangeError(f"there are more than {most:,} messages", "take fewer samples", name)
        yield message.data


def road_in(reader: Any) -> tuple[str, bytes] | None:
    """Return reference and OpenDRIVE of the first map; None without a map.

    Raises:
        ValueError: it cannot be decoded.
    """
    summary = reader.get_summary()
    topics = [] if summary is None else [
        each.topic for each in summary.channels.values() if _schema(summary, each).endswith(MAP)
    ]  # fmt: skip
    for _, _, message in reader.iter_messages(topics=topics) if topics else ():
        said = fields(message.data)
        reference, road = (said.get(field, [b""])[0] for field in (REFERENCE, OPENDRIVE))
        if isinstance(reference, bytes) and isinstance(road, bytes) and road:
            return reference.decode("utf-8", "replace"), road
    return None


def told_of(topics: list[str]) -> tuple[str, ...]:
    """Return the remark on the channels that are not read; () with one channel."""
    others = ", ".join(quoted(topic) for topic in topics[1:4])
    return (f"of its channels of GroundTruth {quoted(topics[0])} is read, and not {others}",) if others else ()


def _schema(summary: Any, channel: Any) -> str:
    found = summary.schemas.get(channel.schema_id)
    return str(found.name) if found is not None and found.encoding == "protobuf" else ""
