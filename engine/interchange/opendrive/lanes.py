"""Reference lines and cross sections of roads."""

from collections.abc import Mapping, Sequence

from engine.interchange.xml_text import Element, child
from engine.road import Primitive

WIDE = {"b": 0, "c": 0, "d": 0}
"""Of a width that does not change along the road."""


def add_plan(road: Element, primitives: Sequence[Primitive]) -> None:
    """The reference line: lines and arcs."""
    plan, s = child(road, "planView"), 0.0
    for line in primitives:
        geometry = child(plan, "geometry", s=s, x=line.x, y=line.y, hdg=line.heading, length=line.length)
        if line.curvature == 0.0:
            child(geometry, "line")
        else:
            child(geometry, "arc", curvature=line.curvature)
        s += line.length


def add_offset(lanes: Element, offset: float) -> None:
    """How far left of the reference line lane 0 runs [m]."""
    child(lanes, "laneOffset", s=0, a=offset, **WIDE)


def add_lane(group: Element, lane: int) -> Element:
    return child(group, "lane", id=lane, type="none" if lane == 0 else "driving", level="false")


def add_link(parent: Element, ends: Mapping[str, int]) -> None:
    """The lanes that a lane goes on to, by `predecessor` and `successor`."""
    link = child(parent, "link")
    for end, lane in ends.items():
        child(link, end, id=lane)


def add_width(lane: Element, width: float) -> None:
    child(lane, "width", sOffset=0, a=width, **WIDE)


def add_mark(lane: Element, kind: str, lane_change: str) -> None:
    """The line at a lane's outer border, of lane 0 in the middle of the road."""
    child(lane, "roadMark", sOffset=0, type=kind, weight="standard", color="standard", laneChange=lane_change)
