"""How roads and lanes of a file go on: links between roads, and the connections of junctions.

Source: ASAM OpenDRIVE 1.7.0, sections 10.3 (road linkage), 11.6 (lane linkage) and 12 (junctions).
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from engine.interchange.xml import Node


class OdrEnd(NamedTuple):
    """What lies beyond one end of a road."""

    kind: str
    """`road` or `junction`."""
    id: str
    at_start: bool
    """Of a road: whether its start is what lies here."""


class OdrConnection(NamedTuple):
    """One road of a junction, and which lanes lead into it."""

    junction: str
    incoming: str
    connecting: str
    at_start: bool
    """Whether the connecting road is entered at its start."""
    lanes: Mapping[int, int]
    """From lanes of the incoming road to those of the connecting one; without any, each leads to that of its number."""


def road_end(road: Node, name: str) -> OdrEnd | None:
    """The `predecessor` or `successor` of a road."""
    end = road.find("link", name)
    if end is None:
        return None
    kind = end.text("elementType", "road")
    return OdrEnd(kind, end.text("elementId"), kind == "road" and end.text("contactPoint", "start") == "start")


def lane_end(lane: Node, name: str) -> int | None:
    """The lane that a lane goes on to by its `predecessor` or `successor`."""
    end = lane.find("link", name)
    return None if end is None else end.integer("id")


def connections(root: Node) -> Iterator[OdrConnection]:
    """Those of all junctions, in the order of the file."""
    for junction in root.every("junction"):
        for node in junction.every("connection"):
            if "connectingRoad" not in node.attributes or "incomingRoad" not in node.attributes:
                continue  # of a direct or virtual junction, in which no road lies
            yield OdrConnection(
                junction.text("id"),
                node.text("incomingRoad"),
                node.text("connectingRoad"),
                node.text("contactPoint", "start") == "start",
                {link.integer("from"): link.integer("to") for link in node.every("laneLink")},
            )
