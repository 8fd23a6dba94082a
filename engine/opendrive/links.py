"""Continuations of roads and lanes of a file: links between roads, and the connections of junctions.

Source: ASAM OpenDRIVE 1.8.0, sections 10.3 (road linkage), 11.6 (lane linkage) and 12 (junctions).
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from engine.xml import Node

COMMON, DIRECT = "default", "direct"
"""Types of junctions with joined roads. `virtual` junctions leave the main road uncut; `crossing` junctions join
nothing.
"""
CONTACTS: Mapping[str, bool] = {"start": True, "end": False}


class OdrEnd(NamedTuple):
    """Element beyond one end of a road."""

    kind: str
    """`road` or `junction`."""
    id: str
    at_start: bool | None
    """True if the link is to the start of a road; None if the file does not say."""


class OdrConnection(NamedTuple):
    """One road of a junction, and the lanes that lead into it."""

    junction: str
    incoming: str
    connecting: str
    """Road through the junction; for a direct junction the road beyond, as it contains no road."""
    at_start: bool | None
    """True if that road is entered at its start; None if the file does not state it."""
    lanes: Mapping[int, int]
    """Connecting lane by incoming lane; if empty, lanes with equal numbers are connected."""
    direct: bool = False


def road_end(road: Node, name: str) -> OdrEnd | None:
    """Return the road or junction that a `predecessor` or `successor` names; None if it names nothing."""
    end = road.find("link", name)
    if end is None or not end.has("elementId"):
        return None
    kind = end.text("elementType", "road" if end.has("contactPoint") else "junction")
    return OdrEnd(kind, end.text("elementId"), _contact(end) if kind == "road" else None)


def _contact(node: Node) -> bool | None:
    return CONTACTS.get(node.text("contactPoint", ""))


def lane_end(lane: Node, name: str) -> int | None:
    """Return the lane into which a lane continues by its `predecessor` or `successor`; None if it names none."""
    end = lane.find("link", name)
    return None if end is None or not end.has("id") else end.integer("id")


def junction_type(junction: Node) -> str:
    return junction.text("type", COMMON)


def connections(root: Node) -> Iterator[OdrConnection]:
    """Yield those of all junctions that join roads end to end, in the order of the file."""
    for junction in root.every("junction"):
        kind = junction_type(junction)
        through = "linkedRoad" if kind == DIRECT else "connectingRoad"
        for node in junction.every("connection") if kind in (COMMON, DIRECT) else ():
            if node.has(through, "incomingRoad"):
                yield OdrConnection(
                    junction.text("id"),
                    node.text("incomingRoad"),
                    node.text(through),
                    _contact(node),
                    {
                        link.integer("from"): link.integer("to")
                        for link in node.every("laneLink")
                        if link.has("from", "to")
                    },
                    kind == DIRECT,
                )
