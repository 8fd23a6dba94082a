"""Places in OpenDRIVE: the road and lane of each lane of a network. Metres and radians.

A road outside the junctions has its two directions to either side of its reference line, which runs in the middle and
with the traffic of its first lane. A turn is a road of one lane with the reference line on the lane's own centre. On
straight roads and turns, arc length along a lane equals arc length along the reference line, or the remaining length; a
curved lane at an offset from its reference line is longer or shorter, primitive by primitive.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from engine.errors import InterchangeError
from engine.maps import LaneletFile, MapFile, MapSpec
from engine.road import Intersection, Lane, Maneuver, Network, Road, build_network
from engine.road.opendrive.drawing import lane_stretches
from engine.road.opendrive.linking import Links
from engine.road.opendrive.planning import LanePlan, plan_of
from engine.road.opendrive.surfaces import places
from engine.road.paths import PathBook

SOMEWHERE = "+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"
"""A <geoReference> for roads without a place on Earth: their origin is at 0 N, 0 E."""


class RoadPlace(NamedTuple):
    """A place in OpenDRIVE: road, lane, arc length along the road's reference line [m]."""

    road: str
    lane: int
    s: float


@dataclass(frozen=True)
class LanePlace:
    """One lane of the network in OpenDRIVE's terms."""

    road: str
    lane: int
    """Positive to the left of the reference line, negative to its right, counted from the middle."""
    forward: bool
    """True if traffic runs in the direction of growing s."""
    length: float
    """[m]"""

    knots: tuple[tuple[float, float], ...] = ()
    """Pairs of arc lengths along the lane and on the road [m], at the ends of arcs of different lengths."""

    numbers: tuple[tuple[float, int], ...] = ()
    """Pairs, for a lane of a file, of the arc length along it [m] and its number from there on."""

    def number(self, along: float) -> int:
        """Return the number of a lane at a point `along` it [m]."""
        return next((number for begin, number in reversed(self.numbers) if begin <= along), self.lane)

    def s(self, along: float) -> float:
        """Return the arc length on the road [m] of a point `along` the lane [m]."""
        if self.knots:
            lane, road = zip(*self.knots, strict=True)
            return float(np.interp(along, lane, road))
        return along if self.forward else self.length - along


@dataclass(frozen=True)
class Carriageway:
    """A road outside the junctions."""

    id: str
    road: Road

    @property
    def name(self) -> str:
        return self.road.name

    @property
    def forward(self) -> tuple[Lane, ...]:
        """Return the lanes in the direction of growing s, from the kerb to the middle."""
        return self.road.forward.lanes

    @property
    def backward(self) -> tuple[Lane, ...]:
        return self.road.backward.lanes

    @property
    def lanes(self) -> tuple[Lane, ...]:
        return self.road.lanes

    @property
    def length(self) -> float:
        return sum(each.length for each in self.road.middle)

    @property
    def junctions(self) -> tuple[Intersection | None, Intersection | None]:
        """Return the junctions at its start and at its end; None at the border of the network."""
        ways = ((self.backward, self.forward), (self.forward, self.backward))
        start, end = (_leads_to(leaving) or _comes_from(entering) for leaving, entering in ways)
        return start, end

    def place(self, lane: Lane) -> LanePlace:
        """Return the place of one of its lanes, numbered from the middle outwards."""
        side = 1 if lane.network.left_hand else -1
        beside = self.forward if lane.forward else self.backward
        from_middle = len(beside) + 1 - lane.number
        number = (side if lane.forward else -side) * from_middle
        return LanePlace(self.id, number, lane.forward, lane.length, self._knots(lane))

    def _knots(self, lane: Lane) -> tuple[tuple[float, float], ...]:
        if all(each.curvature == 0.0 for each in self.road.middle):
            return ()
        ends = [0.0, *accumulate(each.length for each in self.road.middle)]
        starts = lane.network.paths.starts(lane.path)
        return tuple(zip(starts, ends if lane.forward else ends[::-1], strict=True))


def _leads_to(lanes: Sequence[Lane]) -> Intersection | None:
    return lanes[0].intersection if lanes else None


def _comes_from(lanes: Sequence[Lane]) -> Intersection | None:
    return lanes[0].predecessors[0].intersection if lanes and lanes[0].predecessors else None


@dataclass(frozen=True)
class RoadMap:
    """A network with the names that its parts have in OpenDRIVE: numbers from 1, none used twice in a document."""

    network: Network

    @cached_property
    def roads(self) -> tuple[Carriageway, ...]:
        """Return all roads outside the junctions, in the order of their lanes."""
        return tuple(Carriageway(str(number), road) for number, road in enumerate(self.network.roads, 1))

    def turn_id(self, maneuver: Maneuver) -> str:
        """Return the id of the road through the junction along a maneuver."""
        return str(len(self.roads) + 1 + maneuver.id)

    def junction_id(self, intersection: int) -> str:
        return str(len(self.roads) + len(self.network.maneuvers) + 1 + intersection)

    def corner_id(self, corner: int) -> str:
        """Return the id of the road that carries the sidewalk around a corner."""
        return self.junction_id(len(self.network.intersections) + corner)

    @cached_property
    def places(self) -> tuple[LanePlace, ...]:
        """Return the places by lane id."""
        if isinstance(self.network.spec, MapFile):
            return _in_file(self.network.spec)
        places: dict[int, LanePlace] = {}
        for road in self.roads:
            for lane in road.lanes:
                places[lane.id] = road.place(lane)
        for maneuver in self.network.maneuvers:
            lane = maneuver.connecting_lane
            places[lane.id] = LanePlace(self.turn_id(maneuver), self.side, True, lane.length)
        return tuple(places[lane.id] for lane in self.network.lanes)

    def place(self, lane: int, s: float) -> RoadPlace:
        """Return the place of a point `s` along a lane of the network [m]; `lane` is its id."""
        there = self.places[lane]
        return RoadPlace(there.road, there.number(s), there.s(s))

    @property
    def side(self) -> int:
        """Return the sign of the lanes in the direction of growing s."""
        return 1 if self.network.left_hand else -1


def _in_file(spec: MapFile) -> tuple[LanePlace, ...]:
    """Return the places of a file's lanes, under their names in the file.

    Raises:
        InterchangeError: it is no OpenDRIVE file.
    """
    if isinstance(spec, LaneletFile):
        what = "this format names roads and lanes of OpenDRIVE, and a Lanelet2 map has none"
        raise InterchangeError(what, "export to csv, mcap, commonroad or scn", spec.file)
    plan = plan_of(spec.path, spec.digest)
    return tuple(_file_place(plan.links, each) for each in plan.lanes)


def _file_place(links: Links, each: LanePlan) -> LanePlace:
    lane, rows = each.lane, links.sections[each.lane.road].rows
    parts = lane.parts if lane.forward else lane.parts[::-1]
    knots = _file_knots(links, each)
    way, held = 1.0 if lane.forward else -1.0, np.array(knots, dtype=np.float64)
    along, s = held[:, 0], held[:, 1]
    begins = [rows[part.section][0].start if lane.forward else rows[part.section][1] for part in parts]
    numbers = tuple(
        (float(np.interp(way * begin, way * s, along)), part.lane) for begin, part in zip(begins, parts, strict=True)
    )
    return LanePlace(lane.road, parts[0].lane, lane.forward, float(along[-1]), knots, numbers)


def _file_knots(links: Links, each: LanePlan) -> tuple[tuple[float, float], ...]:
    """Return pairs of arc lengths along a lane and on its road, every few metres where the lane curves or widens."""
    stretches, _ = lane_stretches(links, each.lane)
    at = [(row, s) for row in stretches for s in ([row.start] if row.is_plain else places(row))]
    at.append((stretches[-1], stretches[-1].end))
    s = np.array([s for _, s in at])
    points = np.array([row.beside(s, row.centre(s)) for row, s in at])
    paths = PathBook()
    along = paths.feet(paths.add(each.line), *points.T).s
    along, s = (along, s) if each.lane.forward else (along[::-1], s[::-1])
    advancing = np.concatenate([[True], np.diff(np.maximum.accumulate(along)) > 0.0])
    return tuple(zip(along[advancing].tolist(), s[advancing].tolist(), strict=True))


def road_map(spec: MapSpec) -> RoadMap:
    """Return the road of a specification with its names in OpenDRIVE.

    Raises:
        RoadError: no road fits the specification.
    """
    return RoadMap(build_network(spec))


class Beside(NamedTuple):
    """A building or parked car near a road: number, s and t of its centre [m], heading relative to the road's [rad],
    sizes [m].
    """

    number: int
    s: float
    t: float
    heading: float
    length: float
    width: float


def buildings_by_road(roads: RoadMap) -> Mapping[str, list[Beside]]:
    """Return the buildings by the id of the first road whose length passes their centre."""
    found: dict[str, list[Beside]] = {road.id: [] for road in roads.roads}
    blocks = len(roads.network.buildings) - roads.network.parked
    for number, (x, y, heading, length, width) in enumerate(roads.network.buildings[:blocks].tolist()):
        for road in roads.roads:
            line = road.road.middle[0]  # makers with buildings have straight roads
            cos, sin = round(math.cos(line.heading)), round(math.sin(line.heading))
            s, t = (x - line.x) * cos + (y - line.y) * sin, (y - line.y) * cos - (x - line.x) * sin
            if 0.0 <= s <= line.length:
                found[road.id].append(Beside(number, s, t, heading - line.heading, length, width))
                break
    return found


def parked_by_road(roads: RoadMap) -> Mapping[str, list[Beside]]:
    """Return the parked cars by the id of the nearest road."""
    network, paths = roads.network, PathBook()
    lines = {road.id: paths.add(road.road.middle) for road in roads.roads}
    found: dict[str, list[Beside]] = {road.id: [] for road in roads.roads}
    first = len(network.buildings) - network.parked
    for number, (x, y, heading, length, width) in enumerate(network.buildings[first:].tolist(), first):
        nearest = min(lines, key=lambda road: paths.distance(lines[road], x, y))
        s, t, turn = beside_path(paths, lines[nearest], x, y, heading)
        found[nearest].append(Beside(number, s, t, turn, length, width))
    return found


def beside_path(paths: PathBook, path: int, x: float, y: float, heading: float) -> tuple[float, float, float]:
    """Return s and t of a point beside a path [m], and a heading relative to the path's there [rad]."""
    s = paths.project(path, x, y)
    pose = paths.pose(path, s)
    t = (y - pose.y) * math.cos(pose.heading) - (x - pose.x) * math.sin(pose.heading)
    return s, t, math.remainder(heading - pose.heading, math.tau)
