"""The roads of an OpenDRIVE file as data, and positions on them, such as road 3, lane -1, s = 20 m. Metres, radians.

Sources: ASAM OpenDRIVE 1.7.0, chapters 8 (geometry), 10 (roads) and 11 (lanes). Positions are in the horizontal plane.
Headings on a lane are those of its traffic: lanes right of the reference line run along it, lanes left of it against
it, and in reverse if the road's `rule` is left hand traffic. Speed limits: sections 10.4 (road type), 11.8.6 (lanes).
"""

import bisect
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.display import counted
from engine.errors import InterchangeError, name_cure
from engine.opendrive.curves import Piece, Pose
from engine.opendrive.links import OdrConnection, OdrEnd
from engine.opendrive.near_roads import OdrCrossing, OdrSignal
from engine.tables import Floats
from engine.unread import Kind, not_read
from engine.xml import Node

# -- speed limits of roads and lanes -----------------------------------------------------------------------------------

UNITS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704}
"""[m/s]"""


class SpeedFrom(NamedTuple):
    """Speed limit from a place on, up to the next place."""

    start: float
    """[m]"""
    limit: float | None
    """[m/s]; None without a limit, or if none is stated."""


def road_speeds(road: Node) -> tuple[SpeedFrom, ...]:
    """Return the speed limits of a road by its types."""
    found = (SpeedFrom(each.number("s", 0.0, low=0.0), _limit(each.find("speed"))) for each in road.every("type"))
    return tuple(sorted(found, key=lambda each: each.start))


def lane_speeds(lane: Node, start: float) -> tuple[SpeedFrom, ...]:
    """Return the speed limits of a lane in a section that begins at `start`."""
    found = (SpeedFrom(start + each.number("sOffset", 0.0, low=0.0), _limit(each)) for each in lane.every("speed"))
    return tuple(sorted(found, key=lambda each: each.start))


def _limit(node: Node | None) -> float | None:
    """Return the limit [m/s] of `max`: a number; None for `no limit`, `undefined` and all other texts."""
    try:
        value = math.nan if node is None else float(node.text("max", "nan"))
    except ValueError:
        return None
    limit = value * (UNITS.get(node.text("unit", "m/s"), math.nan) if node else math.nan)
    return limit if 0.0 < limit < math.inf else None


def limit_at(s: float, *rows: Sequence[SpeedFrom]) -> float | None:
    """Return the limit at a place [m/s]: that of the first rows with a limit there."""
    return next((limit for limit in _limits(s, rows) if limit is not None), None)


def _limits(s: float, rows: Sequence[Sequence[SpeedFrom]]) -> Iterator[float | None]:
    for each in rows:
        begun = bisect.bisect_right(each, s, key=lambda row: row.start)
        yield each[begun - 1].limit if begun else None


BEYOND = 1e-3
"""Distance beyond the end of a road at which it is still accepted [m]: files round lengths, too."""


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
    """One lane of a section; it has widths, or an outer border relative to the lane offset."""

    id: int
    type: str
    widths: tuple[Cubic, ...]
    borders: tuple[Cubic, ...]
    predecessor: int | None = None
    """Lane before it, of the section or road before this one."""
    successor: int | None = None
    speeds: tuple[SpeedFrom, ...] = ()
    line: int = 0
    """Line of the file."""


@dataclass(frozen=True)
class OdrSection:
    start: float
    lanes: Mapping[int, OdrLane]

    def edges(self, lane: int, s: float) -> tuple[float, float]:
        """Return inner and outer edge of a lane, to the left of the lane offset [m]; a width is never negative."""
        side, inner, outer = (1 if lane > 0 else -1), 0.0, 0.0
        for number in range(side, lane + side, side):
            inner, row = outer, self.lanes.get(number)
            if row is not None:
                outer = value_at(row.borders, s) if row.borders else inner + side * max(value_at(row.widths, s), 0.0)
        return inner, outer


@dataclass(frozen=True)
class OdrRoad:
    """One road; `place` is its place in its file."""

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
    """Speed limits of lanes without a limit of their own."""
    signals: tuple[OdrSignal, ...] = ()
    """Signals that apply to it, at any place."""
    heights: tuple[Cubic, ...] = ()
    """Heights of the reference line [m]; none for a flat road at height 0."""
    crossings: tuple[OdrCrossing, ...] = ()

    def section(self, s: float) -> OdrSection:
        return self.sections[max(bisect.bisect_right(self.sections, s, key=lambda section: section.start) - 1, 0)]

    def against(self, lane: int) -> bool:
        """Return True if traffic of a lane runs against the reference line."""
        return lane != 0 and (lane > 0) != self.left_hand

    def reference(self, s: float) -> Pose:
        """Return the pose of the reference line."""
        return self.pieces[max(bisect.bisect_right(self.pieces, s, key=lambda piece: piece.s) - 1, 0)].pose(s)

    def center(self, lane: int, s: float) -> float:
        """Return the offset of a lane's middle to the left of the reference line [m]."""
        return (
            value_at(self.offsets, s) + sum(self.section(s).edges(lane, s)) / 2.0 if lane else value_at(self.offsets, s)
        )


@dataclass(frozen=True)
class OdrNetwork:
    """All roads of one file, by their id."""

    file: str
    roads: Mapping[str, OdrRoad]
    junctions: tuple[str, ...]
    path: Path
    """Path of the file."""
    remarks: tuple[str, ...] = ()
    unread: tuple[Kind, ...] = ()
    """Content of the file that the reader does not read."""
    junction_types: Mapping[str, str] = field(default_factory=dict[str, str])
    """Types of junctions that no roads lead through, by id."""
    buildings: Floats = field(default_factory=lambda: np.zeros((0, 5)))
    """Buildings, see `Recording.buildings`."""
    connections: tuple[OdrConnection, ...] = ()
    """Connections of all junctions."""
    content: bytes | None = None
    """The file itself, if it was inside a file and is not on disk."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Return the remarks, and the sentence about unread content."""
        return (*self.remarks, f"{self.file}: {not_read(self.unread)}") if self.unread else self.remarks

    def copy(self) -> bytes:
        """Return the file's bytes, for a copy."""
        return self.path.read_bytes() if self.content is None else self.content

    def road(self, road: str, place: str = "") -> OdrRoad:
        """Return a road of this network; `place` is the place of the reference.

        Raises:
            InterchangeError: there is no such road.
        """
        if road not in self.roads:
            cure = name_cure(road, self.roads)
            raise InterchangeError(f"there is no road `{road[:40]}` in {self.file}", cure, place or self.file)
        return self.roads[road]

    def pose(self, road: str, lane: int | None, s: float, offset: float = 0.0, place: str = "") -> Pose:
        """Return the pose `offset` [m] to the left of a lane's middle, with the heading of its traffic.

        Without a lane, `offset` is t, measured from the reference line, and the heading is that line's. Left is left of
        the reference line in both cases.

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
        """Return a summary in one sentence."""
        lanes = sum(max(map(_driving, road.sections)) for road in self.roads.values())
        sides = {road.left_hand for road in self.roads.values()}
        hand = "left and right hand" if len(sides) == 2 else "left hand" if True in sides else "right hand"
        length = sum(road.length for road in self.roads.values())
        counts = [
            counted(len(self.roads), "road"),
            counted(len(self.junctions), "junction"),
            counted(lanes, "driving lane"),
        ]
        return f"{', '.join(counts)}, {length:.0f} m in all, {hand} traffic"


def in_effect(cubics: Sequence[Cubic], s: float) -> Cubic | None:
    """Return the last cubic that has begun at s; before all of them the first; None without cubics."""
    return cubics[max(bisect.bisect_right(cubics, s, key=lambda row: row.start) - 1, 0)] if cubics else None


def value_at(cubics: Sequence[Cubic], s: float) -> float:
    """Return the value of the last cubic that has begun; 0 without cubics."""
    return 0.0 if (row := in_effect(cubics, s)) is None else row.at(s)


def _driving(section: OdrSection) -> int:
    return sum(lane.type == "driving" for lane in section.lanes.values())


def _listed(lanes: Mapping[int, OdrLane]) -> str:
    names = ", ".join(str(lane) for lane in sorted(lanes) if lane)
    return f"lanes {names[:200]}" if names else "no lanes"
