"""Roads of OpenDRIVE, read for what positions need: where is road 3, lane -1, 20 m in? Seen from above, in metres.

Sources: ASAM OpenDRIVE 1.7.0, chapters 8 (geometry), 10 (roads) and 11 (lanes). Elevation and superelevation are left
out. Headings on a lane are those of its traffic: lanes right of the reference line run along it, lanes left of it
against it, and the other way round where the road's `rule` is left hand traffic. Of the objects beside roads (chapter
13) buildings that are rectangles are read: they are the walls that a recording may meet.
"""

import bisect
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.interchange.contract import InterchangeError, cited, name_cure, quoted
from engine.interchange.xml import LIMITS, Limits, Node, read_xml
from engine.opendrive.curves import Piece, Pose, read_piece
from engine.opendrive.links import OdrConnection, OdrEnd, connections, lane_end, road_end
from engine.opendrive.signals import OdrSignal, Signals, counting, road_signals, signal_remarks
from engine.opendrive.speeds import SpeedFrom, lane_speeds, road_speeds
from engine.tables import Floats

MOST_LANES = 100
"""Of one section, both sides together."""
NARROWEST = -0.01
"""A width below this gets a remark [m]; files round those of lanes that end."""
BEYOND = 1e-3
"""How far past its end a road may be asked for [m]: files round lengths, too."""


class Cubic(NamedTuple):
    """a + b d + c d² + d d³ of the distance d from where it begins."""

    start: float
    a: float
    b: float
    c: float
    d: float

    def at(self, s: float) -> float:
        x = s - self.start
        return self.a + x * (self.b + x * (self.c + x * self.d))


@dataclass(frozen=True)
class OdrLane:
    """One lane of a section; it has widths, or an outer border measured from the lane offset."""

    id: int
    type: str
    widths: tuple[Cubic, ...]
    borders: tuple[Cubic, ...]
    predecessor: int | None = None
    """The lane before it, of the section or road before this one."""
    successor: int | None = None
    speeds: tuple[SpeedFrom, ...] = ()


@dataclass(frozen=True)
class OdrSection:
    start: float
    lanes: Mapping[int, OdrLane]

    def edges(self, lane: int, s: float) -> tuple[float, float]:
        """Inner and outer edge of a lane, measured to the left of the lane offset; a width is never negative."""
        side, inner, outer = (1 if lane > 0 else -1), 0.0, 0.0
        for number in range(side, lane + side, side):
            inner, row = outer, self.lanes.get(number)
            if row is not None:
                outer = _at(row.borders, s) if row.borders else inner + side * max(_at(row.widths, s), 0.0)
        return inner, outer


@dataclass(frozen=True)
class OdrRoad:
    """One road; `place` is where its file speaks of it."""

    id: str
    name: str
    length: float
    junction: str
    """Id of the junction that it connects through, "-1" for none."""
    left_hand: bool
    pieces: tuple[Piece, ...]
    offsets: tuple[Cubic, ...]
    sections: tuple[OdrSection, ...]
    place: str
    predecessor: OdrEnd | None = None
    successor: OdrEnd | None = None
    speeds: tuple[SpeedFrom, ...] = ()
    """Of all lanes that have none of their own."""
    signals: tuple[OdrSignal, ...] = ()
    """Those that count on it, wherever they stand."""

    def section(self, s: float) -> OdrSection:
        return self.sections[max(bisect.bisect_right(self.sections, s, key=lambda section: section.start) - 1, 0)]

    def against(self, lane: int) -> bool:
        """Whether traffic of a lane runs against the reference line."""
        return lane != 0 and (lane > 0) != self.left_hand

    def reference(self, s: float) -> Pose:
        """The pose of the reference line."""
        return self.pieces[max(bisect.bisect_right(self.pieces, s, key=lambda piece: piece.s) - 1, 0)].pose(s)

    def center(self, lane: int, s: float) -> float:
        """How far left of the reference line the middle of a lane runs."""
        return _at(self.offsets, s) + sum(self.section(s).edges(lane, s)) / 2.0 if lane else _at(self.offsets, s)


@dataclass(frozen=True)
class OdrNetwork:
    """All roads of one file, by their id."""

    file: str
    roads: Mapping[str, OdrRoad]
    junctions: tuple[str, ...]
    path: Path
    """Where that file is."""
    remarks: tuple[str, ...] = ()
    buildings: Floats = field(default_factory=lambda: np.zeros((0, 5)))
    """As `Recording.buildings`."""
    connections: tuple[OdrConnection, ...] = ()
    """Of all junctions."""
    content: bytes | None = None
    """The file itself, where it lay in another and is gone."""

    def copy(self) -> bytes:
        """The file, to be put beside another."""
        return self.path.read_bytes() if self.content is None else self.content

    def road(self, road: str, place: str = "") -> OdrRoad:
        """A road of this network; `place` is who asks.

        Raises:
            InterchangeError: there is no such road.
        """
        if road not in self.roads:
            cure = name_cure(road, self.roads)
            raise InterchangeError(f"there is no road `{road[:40]}` in {self.file}", cure, place or self.file)
        return self.roads[road]

    def pose(self, road: str, lane: int | None, s: float, offset: float = 0.0, place: str = "") -> Pose:
        """The pose `offset` [m] to the left of a lane's middle, heading as its traffic does.

        Without a lane, `offset` is t, measured from the reference line, whose heading it has. Left is left of the
        reference line in both cases.

        Raises:
            InterchangeError: no such road or lane, or s beyond its ends.
        """
        row = self.road(road, place)
        along = self._within(row, s, place or row.place)
        if lane is None:
            return row.reference(along).moved(0.0, offset)
        if lane and lane not in (lanes := row.section(along).lanes):
            raise InterchangeError(
                f"road `{row.id}` has no lane {lane} at s = {along:g} m",
                f"there are {_listed(lanes)}",
                place or row.place,
            )
        turn = math.pi if row.against(lane) else 0.0
        return row.reference(along).moved(0.0, row.center(lane, along) + offset, turn)

    def _within(self, road: OdrRoad, s: float, place: str) -> float:
        if -BEYOND <= s <= road.length + BEYOND:
            return min(max(s, 0.0), road.length)
        side = "beyond the end" if s > 0 else "before the beginning"
        raise InterchangeError(
            f"s = {s:g} m lies {side} of road `{road.id}`", f"it runs from 0 to {road.length:g} m", place
        )

    def summary(self) -> str:
        """One sentence for people."""
        lanes = sum(max(map(_driving, road.sections)) for road in self.roads.values())
        sides = {road.left_hand for road in self.roads.values()}
        hand = "left and right hand" if len(sides) == 2 else "left hand" if True in sides else "right hand"
        length = sum(road.length for road in self.roads.values())
        counts = [
            _count(len(self.roads), "road"),
            _count(len(self.junctions), "junction"),
            _count(lanes, "driving lane"),
        ]
        return f"{', '.join(counts)}, {length:.0f} m in all, {hand} traffic"


def read_opendrive(path: str | Path, limits: Limits = LIMITS) -> OdrNetwork:
    """The network of an `.xodr` file.

    Raises:
        InterchangeError: the file cannot be read, or a road in it cannot be.
    """
    path = Path(path)
    root = read_xml(path, "OpenDRIVE", limits)
    roads: dict[str, OdrRoad] = {}
    buildings: list[tuple[float, ...]] = []
    unread: list[str] = []
    for node in root.every("road"):
        road = _read_road(node)
        for place in _building_nodes(node):
            try:
                buildings += _read_building(place, road)
            except InterchangeError:
                unread.append(place.attributes.get("name") or place.attributes.get("id", ""))
        if road.id in roads:
            other = roads[road.id].place
            raise node.error(f"two roads have the id `{road.id}`", f"give each its own id; the other is at {other}")
        roads[road.id] = road
    if not roads:
        raise root.error("there is no road in it", "write <road> elements into <OpenDRIVE>")
    junctions = tuple(node.text("id") for node in root.every("junction"))
    walls: Floats = np.array(buildings, dtype=np.float64).reshape(-1, 5)
    remarks, ways = (*_remarks(roads), *_on_buildings(unread)), tuple(connections(root))
    roads, left_out = with_signals(roads, {node.text("id"): road_signals(node) for node in root.every("road")})
    return OdrNetwork(path.name, roads, junctions, path, (*remarks, *left_out), walls, ways)


def _remarks(roads: Mapping[str, OdrRoad]) -> Iterator[str]:
    """On the first lane that begins with a negative width."""
    for road in roads.values():
        for lane in (lane for section in road.sections for lane in section.lanes.values()):
            if (least := min((row.a for row in lane.widths), default=0.0)) < NARROWEST:
                yield f"lane {lane.id} of road `{road.id[:40]}` is {least:g} m wide, which is taken as 0 m"
                return


def with_signals(
    roads: Mapping[str, OdrRoad], signals: Mapping[str, Signals]
) -> tuple[dict[str, OdrRoad], tuple[str, ...]]:
    """Roads with the signals that count on them, and remarks on what of these is left out."""
    known = {each.id: each for found in signals.values() for each in found.own}
    new = {road: replace(each, signals=tuple(counting(signals[road], known))) for road, each in roads.items()}
    return new, tuple(signal_remarks(signals.values(), known))


def _read_road(node: Node) -> OdrRoad:
    pieces = sorted(map(read_piece, node.need("planView").every("geometry")), key=lambda piece: piece.s)
    if not pieces:
        raise node.error("the road has no <geometry>", "write at least one into <planView>")
    lanes = node.find("lanes")
    sections = [_read_section(section) for section in lanes.every("laneSection")] if lanes else []
    if not sections:
        raise node.error("the road has no <laneSection>", "write at least one into <lanes>")
    return OdrRoad(
        id=node.text("id"),
        name=node.text("name", ""),
        length=node.number("length", low=0.0),
        junction=node.text("junction", "-1"),
        left_hand=node.text("rule", "RHT") == "LHT",
        pieces=tuple(pieces),
        offsets=_cubics(lanes.every("laneOffset"), "s", 0.0) if lanes else (),
        sections=tuple(sorted(sections, key=lambda section: section.start)),
        place=node.place,
        predecessor=road_end(node, "predecessor"),
        successor=road_end(node, "successor"),
        speeds=road_speeds(node),
    )


# -- buildings ---------------------------------------------------------------------------------------------------------

OVERHEAD = 4.0
"""What hangs so high is driven under [m]: the greatest height of a truck (Directive 96/53/EC, annex I)."""
LARGEST_BUILDING = 10_000.0
"""Length or width [m]."""


def _building_nodes(road: Node) -> list[Node]:
    objects = road.find("objects")
    return [each for each in objects.every("object") if each.text("type", "") == "building"] if objects else []


def _read_building(node: Node, road: OdrRoad) -> list[tuple[float, ...]]:
    """Its row of `OdrNetwork.buildings`; none where it hangs overhead.

    Raises:
        InterchangeError: it is no rectangle, or has no place.
    """
    if node.number("zOffset", 0.0) >= OVERHEAD:
        return []
    if "radius" in node.attributes or node.every("outline", "outlines", "repeat"):
        raise node.error(
            "this building is not a rectangle", 'give it a length and a width, without "radius" or outlines'
        )
    s, t = node.number("s", low=0.0, high=road.length + BEYOND), node.number("t")
    pose = road.reference(s).moved(0.0, t, node.number("hdg", 0.0))
    sizes = (node.number(name, low=0.01, high=LARGEST_BUILDING) for name in ("length", "width"))
    return [(*pose, *sizes)]


def _on_buildings(unread: Sequence[str]) -> Iterator[str]:
    """On those that are left out, by the first."""
    if unread:
        first = f"{cited(unread[0])} and {len(unread) - 1} more" if unread[1:] else quoted(unread[0])
        yield f"buildings that are not rectangles, or have no place, are left out: {first}"


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
    return OdrLane(node.integer("id"), node.text("type", "none"), widths, borders, *ends, lane_speeds(node, start))


def _cubics(nodes: Sequence[Node], key: str, start: float) -> tuple[Cubic, ...]:
    rows = [Cubic(start + node.number(key, low=0.0), *(node.number(name) for name in "abcd")) for node in nodes]
    return tuple(sorted(rows, key=lambda row: row.start))


def in_effect(cubics: Sequence[Cubic], s: float) -> Cubic | None:
    """The last one that has begun; before all of them the first."""
    return cubics[max(bisect.bisect_right(cubics, s, key=lambda row: row.start) - 1, 0)] if cubics else None


def _at(cubics: Sequence[Cubic], s: float) -> float:
    """The value of the last one that has begun; 0 where there is none."""
    return 0.0 if (row := in_effect(cubics, s)) is None else row.at(s)


def _driving(section: OdrSection) -> int:
    return sum(lane.type == "driving" for lane in section.lanes.values())


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _listed(lanes: Mapping[int, OdrLane]) -> str:
    names = ", ".join(str(lane) for lane in sorted(lanes) if lane)
    return f"lanes {names[:200]}" if names else "no lanes"
