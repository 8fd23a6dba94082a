"""Reader of OpenDRIVE files. Sources: ASAM OpenDRIVE 1.7.0, chapters 8 (geometry), 10 (roads) and 11 (lanes).

Heights are used for levels only (`engine.kernels.levels`); slopes and superelevation have no effect. Of the objects
near roads (chapter 13) only rectangular buildings and crossings are read; buildings are walls of recordings.

Sections with `singleSide="true"` (11.4) apply to one side of the road, up to the next section that applies to that
side: they are converted to sections of the whole road.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np

from engine.errors import InterchangeError, quoted
from engine.opendrive.curves import Piece, read_piece
from engine.opendrive.links import (
    COMMON,
    DIRECT,
    connections,
    junction_type,
    lane_end,
    road_end,
)
from engine.opendrive.near_roads import (
    OdrCrossing,
    Signals,
    building_row,
    counting,
    crossing_of,
    on_buildings,
    on_crossings,
    road_objects,
    road_signals,
    signal_remarks,
)
from engine.opendrive.roads import BEYOND, Cubic, OdrLane, OdrNetwork, OdrRoad, OdrSection, lane_speeds, road_speeds
from engine.tables import Floats
from engine.unread import unread
from engine.xml import LIMITS, Limits, Node, read_xml

# -- sections for one side of a road -----------------------------------------------------------------------------------

LEFT, RIGHT = 1, -1


def whole_sections(sections: Sequence[OdrSection], single: Sequence[OdrSection]) -> list[OdrSection]:
    """Return sections, cut at each beginning of either side; `single` are those that apply to one side only."""
    ordered = sorted([*sections, *single], key=lambda each: each.start)
    if not single:
        return ordered
    starts = list(dict.fromkeys(each.start for each in ordered))
    of_side = {
        side: [each for each in ordered if each in sections or any(side * lane > 0 for lane in each.lanes)]
        for side in (LEFT, RIGHT)
    }
    center = dict((0, each.lanes[0]) for each in ordered if 0 in each.lanes)  # noqa: C402 - the last one
    return [
        OdrSection(start, center | {k: v for side in of_side for k, v in _cut(of_side[side], side, start, end)})
        for start, end in pairwise([*starts, None])
        if start is not None
    ]


def _cut(sections: Sequence[OdrSection], side: int, start: float, end: float | None) -> Iterator[tuple[int, OdrLane]]:
    """Yield the lanes of one side between two cuts; lanes that continue across a cut keep their numbers."""
    begun = [each for each in sections if each.start <= start]
    if not begun:
        return
    here = begun[-1]
    is_last = end is None or any(each.start == end for each in sections)
    lanes: Mapping[int, OdrLane] = here.lanes
    for number, lane in lanes.items():
        if side * number > 0:
            before = lane.predecessor if here.start == start else number
            yield number, replace(lane, predecessor=before, successor=lane.successor if is_last else number)


MOST_LANES = 100
"""Maximum number of lanes of one section, both sides together."""
NARROWEST = -0.01
"""A width below this gets a remark [m]; files round those of lanes that end."""
METADATA = frozenset(
    {
        *("header", "userData", "dataQuality", "name", "connection id", "lane level", "type type", "roadMark"),
        *(f"{corner} {name}" for corner in ("cornerLocal", "cornerRoad") for name in ("z", "dz", "height", "id")),
        *(f"outline {name}" for name in ("id", "closed", "outer", "fillType", "laneType")),
        *(f"signal {name}" for name in ("zOffset", "hOffset", "height", "width", "pitch", "roll", "text")),
    }
)
"""Elements and attributes that change no result: authors, dates, tools, labels, paint, the shape of signals, heights of
crossings. A lane's
`level` qualifies the superelevation, which is not read."""
SHORT = 0.1
"""Difference of lengths above which a reference line ends before its road [m]: files round lengths."""
SINGLE: Mapping[str, bool] = MappingProxyType({"true": True, "1": True, "false": False, "0": False, "": False})
LEFT_HAND: Mapping[str, bool] = MappingProxyType({"lht": True, "rht": False, "": False})


def read_opendrive(path: str | Path, limits: Limits = LIMITS) -> OdrNetwork:
    """Return the network of an `.xodr` file.

    Raises:
        InterchangeError: the file, or a road in it, cannot be read.
    """
    path = Path(path)
    root = read_xml(path, "OpenDRIVE", limits)
    roads: dict[str, OdrRoad] = {}
    buildings: list[tuple[float, ...]] = []
    odd: list[str] = []
    lost: list[str] = []
    short: list[tuple[OdrRoad, float]] = []
    for node in root.every("road"):
        road = _read_road(node)
        if 0.0 < road.length != (said := node.number("length")):
            short.append((road, said))
        walls, crossings = road_objects(node)
        road = replace(road, crossings=tuple(_crossings(road, crossings, lost)))
        for place in walls:
            try:
                buildings += building_row(place, road.reference, road.length + BEYOND)
            except InterchangeError:
                odd.append(place.attributes.get("name") or place.attributes.get("id", ""))
                place.leave_out()
        if road.id in roads:
            other = roads[road.id].place
            raise node.error(f"two roads have the id `{road.id}`", f"give each its own id; the other is at {other}")
        roads[road.id] = road
    if not roads:
        raise root.error("there is no road in it", "write <road> elements into <OpenDRIVE>")
    junctions = _junctions(root)
    blocks: Floats = np.array(buildings, dtype=np.float64).reshape(-1, 5)
    ways = tuple(connections(root))
    roads, left_out = with_signals(roads, {node.text("id"): road_signals(node) for node in root.every("road")})
    return OdrNetwork(
        path.name,
        roads,
        tuple(junctions),
        path,
        (*_remarks(roads), *_on_lengths(short), *on_buildings(odd), *on_crossings(lost), *left_out),
        unread(root, METADATA),
        {junction: kind for junction, kind in junctions.items() if kind not in (COMMON, DIRECT)},
        blocks,
        ways,
    )


def _crossings(road: OdrRoad, nodes: Sequence[Node], lost: list[str]) -> Iterator[OdrCrossing]:
    """Yield the crossings of a road; `lost` gets the errors of those that are left out."""
    for node in nodes:
        try:
            yield crossing_of(node, road.reference, road.length + BEYOND)
        except InterchangeError as error:
            lost.append(f"{error.message}, {error.place}")
            node.leave_out()


def _junctions(root: Node) -> dict[str, str]:
    """Return the types of junctions, by id.

    Raises:
        InterchangeError: two have one id.
    """
    found: dict[str, Node] = {}
    for node in root.every("junction"):
        if (other := found.setdefault(node.text("id"), node)) is not node:
            message = f"two junctions have the id `{node.text('id')[:40]}`"
            raise node.error(message, f"give each its own id; the other is at {other.place}")
    return {name: junction_type(node) for name, node in found.items()}


def _remarks(roads: Mapping[str, OdrRoad]) -> Iterator[str]:
    """Yield a remark on the first lane that begins with a negative width."""
    for road in roads.values():
        for lane in (lane for section in road.sections for lane in section.lanes.values()):
            if (least := min((row.a for row in lane.widths), default=0.0)) < NARROWEST:
                yield f"lane {lane.id} of road `{road.id[:40]}` is {least:g} m wide, which is taken as 0 m"
                return


def _on_lengths(short: Sequence[tuple[OdrRoad, float]]) -> Iterator[str]:
    """Yield the sentence about roads that are longer than their reference lines, which names the first."""
    for road, said in short[:1]:
        more = f" (so are {len(short) - 1} more)" if short[1:] else ""
        line = f"its reference line {road.length:g} m, where it ends"
        yield f"road `{road.id[:40]}` is {said:g} m long by its file, and {line}{more}"


def with_signals(
    roads: Mapping[str, OdrRoad], signals: Mapping[str, Signals]
) -> tuple[dict[str, OdrRoad], tuple[str, ...]]:
    """Return roads with the signals that apply to them, and remarks on signals that are left out."""
    known = {each.id: each for found in signals.values() for each in found.own}
    new = {road: replace(each, signals=tuple(counting(signals[road], known))) for road, each in roads.items()}
    return new, tuple(signal_remarks(signals.values(), known))


def _read_road(node: Node) -> OdrRoad:
    pieces = sorted(map(read_piece, node.need("planView").every("geometry")), key=lambda piece: piece.s)
    if not pieces:
        raise node.error("the road has no <geometry>", "write at least one into <planView>")
    lanes = node.find("lanes")
    sections: dict[bool, list[OdrSection]] = {False: [], True: []}
    for section in lanes.every("laneSection") if lanes else ():
        sections[_one_of(SINGLE, section, "singleSide")].append(_read_section(section))
    if not any(sections.values()):
        raise node.error("the road has no <laneSection>", "write at least one into <lanes>")
    return OdrRoad(
        id=node.text("id"),
        name=node.text("name", ""),
        length=_length(node, pieces[-1]),
        junction=node.text("junction", "-1"),
        left_hand=_one_of(LEFT_HAND, node, "rule"),
        pieces=tuple(pieces),
        offsets=_cubics(lanes.every("laneOffset"), "s", 0.0) if lanes else (),
        sections=tuple(whole_sections(sections[False], sections[True])),
        place=node.place,
        predecessor=road_end(node, "predecessor"),
        successor=road_end(node, "successor"),
        speeds=road_speeds(node),
        heights=_heights(node),
    )


def _one_of(choices: Mapping[str, bool], node: Node, name: str) -> bool:
    """Return the meaning of an attribute; that of "" if it is missing.

    Raises:
        InterchangeError: it is no choice.
    """
    said = node.text(name, "").strip()
    if said.casefold() not in choices:
        words = " or ".join(f"{name}={quoted(word)}" for word in choices if len(word) > 1)
        raise node.error(f"{name}={quoted(said)} has no meaning", f"write {words}, or leave it out")
    return choices[said.casefold()]


def _length(node: Node, last: Piece) -> float:
    """Return the length of a road, which ends where its reference line does [m]."""
    length, line = node.number("length", low=0.0), last.s + last.length
    return line if length - line > SHORT else length


def _heights(road: Node) -> tuple[Cubic, ...]:
    """Return the heights of a road. Its profiles count as read only without slopes, which have no effect."""
    rows: tuple[Cubic, ...] = ()
    for name in ("elevationProfile", "lateralProfile", "surface"):
        if (profile := road.find(name)) is None:
            continue
        try:
            found = _cubics(profile.every("elevation", "superelevation"), "s", 0.0)
        except InterchangeError:
            found = ()
        sloping = 2 if name == "elevationProfile" else 1  # first coefficient of a slope
        if len(found) < len(profile.children) or any(any(row[sloping:]) for row in found):
            profile.leave_out()
        rows = found if name == "elevationProfile" else rows
    return rows


def _read_section(node: Node) -> OdrSection:
    start = node.number("s", low=0.0)
    lanes: dict[int, OdrLane] = {}
    rows = [lane for side in node.every("left", "center", "right") for lane in side.every("lane")]
    if len(rows) > MOST_LANES:
        raise node.error(f"a section of {len(rows):,} lanes", f"write at most {MOST_LANES}: each place counts them all")
    for row in rows:
        lane = _read_lane(row, start)
        if lane.id in lanes:
            raise row.error(f"two lanes of one section have the id {lane.id}", "lanes are 1, 2, … and -1, -2, …")
        lanes[lane.id] = lane
    if lanes and max(map(abs, lanes)) > len(lanes) + 1:
        raise node.error("lane ids do not run on", "number lanes 1, 2, … and -1, -2, … from the middle outwards")
    return OdrSection(start, lanes)


def _read_lane(node: Node, start: float) -> OdrLane:
    widths = _cubics(node.every("width"), "sOffset", start)
    borders = () if widths else _cubics(node.every("border"), "sOffset", start)
    ends = lane_end(node, "predecessor"), lane_end(node, "successor")
    return OdrLane(
        node.integer("id"), node.text("type", "none"), widths, borders, *ends, lane_speeds(node, start), node.line
    )


def _cubics(nodes: Sequence[Node], key: str, start: float) -> tuple[Cubic, ...]:
    rows = [Cubic(start + node.number(key, low=0.0), *(node.number(name) for name in "abcd")) for node in nodes]
    return tuple(sorted(rows, key=lambda row: row.start))
