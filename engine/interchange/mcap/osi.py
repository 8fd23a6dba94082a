"""OSI's messages in an MCAP, as ASAM's traces of several channels and omega-prime hold them: motion, and a road.

Source: ASAM Open Simulation Interface 3.7, "OSI trace file formats" (a channel's schema is `osi3.` and the name of its
message, in protobuf), and `osi_mapasamopendrive.proto` of omega-prime 0.3.7 (field 1 a reference, 2 the OpenDRIVE).
"""

from collections.abc import Iterator
from typing import Any

from engine.interchange.contract import InterchangeError, quoted
from engine.interchange.logs.osi import fields

TRUTH, MAP = "osi3.GroundTruth", "MapAsamOpenDrive"
REFERENCE, OPENDRIVE = 1, 2
"""Fields of a map."""


def topics_of_truth(reader: Any) -> list[str]:
    """Topics of messages `GroundTruth`; none where the file has no index."""
    summary = reader.get_summary()
    if summary is None:
        return []
    channels = summary.channels.values()
    return sorted(each.topic for each in channels if _schema(summary, each) == TRUTH)


def truths(reader: Any, topic: str, most: int, name: str) -> Iterator[bytes]:
    """The messages of a topic, by the times at which they were logged.

    Raises:
        InterchangeError: there are more than `most`.
    """
    for count, (_, _, message) in enumerate(reader.iter_messages(topics=[topic])):
        if count >= most:
            raise InterchangeError(f"there are more than {most:,} messages", "take fewer samples", name)
        yield message.data


def road_in(reader: Any) -> tuple[str, bytes] | None:
    """Reference and OpenDRIVE of the first map; None where there is none.

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
    """What a reader should know who has several."""
    others = ", ".join(quoted(topic) for topic in topics[1:4])
    return (f"of its channels of GroundTruth {quoted(topics[0])} is read, and not {others}",) if others else ()


def _schema(summary: Any, channel: Any) -> str:
    found = summary.schemas.get(channel.schema_id)
    return str(found.name) if found is not None and found.encoding == "protobuf" else ""
