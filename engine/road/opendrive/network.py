"""The network of an OpenDRIVE file.

What takes long is done once for a file of given contents (`_plan`); the network around it is made anew each time, since
a scenario joins paths of its own.
"""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from engine.frozen import frozen
from engine.interchange.contract import InterchangeError
from engine.maps import MapFile, digest_of
from engine.opendrive.read import OdrRoad, read_opendrive
from engine.road.linking import polylines_cross
from engine.road.network import (
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Leg,
    Lines,
    Links,
    Maneuver,
    Network,
    Road,
)
from engine.road.opendrive.fitting import Stretch, centre_line, stretches
from engine.road.opendrive.linking import THROUGH, FileLane, Way
from engine.road.opendrive.linking import Links as FileLinks
from engine.road.opendrive.surfaces import NoSurfaceError, border, ring_of, strip_between, union
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape
from engine.tables import ROAD_REGION, Floats
from engine.vocabulary import ManeuverType

GAP, TURN = 0.5, 0.2
"""Lanes whose ends lie further apart, or differ more in heading, are not driven from one to the other [m, rad]."""
WORTH_A_REMARK = 0.005
"""A gap or jump from here on is told [m]."""
TURN_THRESHOLD = math.radians(20.0)
"""A way through a junction that turns by less leads straight on, as in Scenic."""
ROUTE = 1000.0
"""A driver without a plan is led so far [m], and to the end of the lane there."""


def map_file(path: Path, name: str) -> MapFile:
    """The specification of the roads of a file; `name` is what it is called where it is asked for.

    Raises:
        InterchangeError: it is no OpenDRIVE file that can be driven on.
    """
    digest = digest_of(path)
    return MapFile(name, str(path), digest, len(_plan(str(path), digest).junctions))


def file_network(spec: MapFile) -> Network:
    """The network of a file.

    Raises:
        InterchangeError: the file is gone, or another one lies in its place.
    """
    path = Path(spec.path)
    found = digest_of(path) if path.is_file() else None
    if found != spec.digest:
        what = "is not there" if found is None else f"has changed: its digest is {found}, not {spec.digest}"
        raise InterchangeError(f"the map {spec.file} {what}", "put the file back that the scenario was compiled with")
    return _Builder(spec, _plan(spec.path, spec.digest)).build()


# -- what a file of given contents comes to ----------------------------------------------------------------------------


@frozen
class LanePlan:
    """One lane as it will be."""

    lane: FileLane
    line: tuple[Primitive, ...]
    """Its centre, as its traffic runs."""
    shape: Shape
    width: float
    number: int
    name: str
    left: int | None
    right: int | None


@frozen
class Plan:
    """A file's lanes, junctions and surfaces."""

    links: FileLinks
    lanes: tuple[LanePlan, ...]
    junctions: Mapping[str, tuple[Way, ...]]
    areas: Mapping[str, Shape]
    surface: Shape
    drawn: Lines
    left_hand: bool
    remarks: tuple[str, ...]


@lru_cache(maxsize=8)
def _plan(path: str, _digest: str) -> Plan:
    network = read_opendrive(path)
    links = FileLinks(network)
    if not links.lanes:
        raise InterchangeError(
            "there is no lane to drive on in it", 'write lanes of the type "driving" into its roads', Path(path).name
        )
    rows, jumps = zip(*(_stretches(links, lane) for lane in links.lanes), strict=True)
    borders = [(border(each, outer=False), border(each, outer=True)) for each in rows]
    lanes = tuple(_lane_plans(links, rows, borders))
    junctions: dict[str, list[Way]] = defaultdict(list)
    for way in links.ways:
        junctions[way.junction].append(way)
    rings = [ring_of(*each) for each in borders]
    inside: dict[str, list[Floats]] = defaultdict(list)
    for lane, ring in zip(links.lanes, rings, strict=True):
        inside[network.roads[lane.road].junction].append(ring)
    try:
        surface, kerbs = union(rings)
    except NoSurfaceError:
        cure = "give its lanes a <width> above 0 m"
        raise InterchangeError("no lane in it has a width", cure, Path(path).name) from None
    left_hand = any(road.left_hand for road in network.roads.values())
    return Plan(
        links,
        lanes,
        {junction: tuple(ways) for junction, ways in junctions.items()},
        {junction: union(inside[junction])[0] for junction in junctions},
        surface,
        Lines(kerbs, *_lines(links, borders)),
        left_hand,
        (*network.remarks, *_on_jumps(jumps)),
    )


def _stretches(links: FileLinks, lane: FileLane) -> tuple[tuple[Stretch, ...], float]:
    sections = links.sections[lane.road]
    return stretches(sections.road, [(*sections.rows[part.section], part.lane) for part in lane.parts])


def _on_jumps(jumps: Sequence[float]) -> Iterator[str]:
    far = [jump for jump in jumps if jump > WORTH_A_REMARK]
    if far:
        yield f"{len(far)} lanes jump aside between two sections, by up to {max(far):.2f} m, and are evened out"


def _lane_plans(
    links: FileLinks, rows: Sequence[Sequence[Stretch]], borders: Sequence[tuple[Floats, Floats]]
) -> Iterator[LanePlan]:
    seen: dict[str, int] = defaultdict(int)
    for index, lane in enumerate(links.lanes):
        line = centre_line(rows[index])
        name, seen[lane.road] = f"road{lane.road}.lane{seen[lane.road]}", seen[lane.road] + 1
        widths = [row.width(0.5 * (row.start + row.end)) for row in rows[index]]
        lengths = [row.end - row.start for row in rows[index]]
        longest = lane.parts[int(np.argmax([_length(links, lane, part.section) for part in lane.parts]))]
        sections = links.sections[lane.road]
        beside = sections.drivable(longest.section)
        outward = [number for number in beside if number * longest.lane > 0 and abs(number) >= abs(longest.lane)]
        left, right = _neighbours(links, lane, longest, beside)
        yield LanePlan(
            lane,
            tuple(line if lane.forward else [each.turned() for each in reversed(line)]),
            strip_between(*borders[index]),
            float(np.average(widths, weights=lengths)) or 0.1,
            len(outward),
            name,
            left,
            right,
        )


def _length(links: FileLinks, lane: FileLane, section: int) -> float:
    row, end = links.sections[lane.road].rows[section]
    return end - row.start


def _neighbours(links: FileLinks, lane: FileLane, at: tuple[int, int], beside: Sequence[int]) -> list[int | None]:
    """Lanes to the left and right where the lane is longest."""
    section, number = at
    side = 1 if number > 0 else -1
    inner, outer = (number - side if number != side else -side), number + side
    left, right = (inner, outer) if (number < 0) == lane.forward else (outer, inner)
    of = links.lane_of
    return [of.get((lane.road, (section, each))) if each in beside else None for each in (left, right)]  # type: ignore[call-overload]


def _lines(links: FileLinks, borders: Sequence[tuple[Floats, Floats]]) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Middle lines, and lines between lanes of one direction, outside junctions."""
    middle: list[Floats] = []
    between: list[Floats] = []
    for lane, (inner, _) in zip(links.lanes, borders, strict=True):
        sections = links.sections[lane.road]
        if sections.road.junction != THROUGH:
            continue
        inmost = min(abs(part.lane) for part in lane.parts) == 1
        if not inmost:
            between.append(inner)
        elif lane.forward and _is_two_way(links, lane):
            middle.append(inner)
    return tuple(middle), tuple(between)


def _is_two_way(links: FileLinks, lane: FileLane) -> bool:
    section, number = lane.parts[0]
    return any(other * number < 0 for other in links.sections[lane.road].drivable(section))


# -- the network around it ---------------------------------------------------------------------------------------------


class _Builder:
    """The network while it grows; each step adds one kind of element."""

    def __init__(self, spec: MapFile, plan: Plan) -> None:
        self.plan = plan
        self.network = Network(spec, plan.left_hand, PathBook(GAP, TURN), drawn=plan.drawn, remarks=plan.remarks)
        self.starts = {way.start for way in plan.links.ways}
        self.ends = {way.end for way in plan.links.ways}

    def build(self) -> Network:
        network, plan = self.network, self.plan
        assert network.regions.add(plan.surface) == ROAD_REGION
        areas = {junction: network.regions.add(plan.areas[junction]) for junction in plan.junctions}
        network.lanes = tuple(self.lane(index, each) for index, each in enumerate(plan.lanes))
        roads = [self.road(road) for road in dict.fromkeys(each.lane.road for each in plan.lanes)]
        network.roads = tuple(road for road in roads if road.lanes[0].role is not LaneRole.CONNECTING)
        network.connecting_roads = tuple(road for road in roads if road.lanes[0].role is LaneRole.CONNECTING)
        ways = [(number, way) for number, each in enumerate(plan.junctions.values()) for way in each]
        network.maneuvers = tuple(self.maneuver(index, *each) for index, each in enumerate(ways))
        network.intersections = tuple(
            self.intersection(number, junction, areas[junction]) for number, junction in enumerate(plan.junctions)
        )
        self.link()
        return network

    def lane(self, index: int, each: LanePlan) -> Lane:
        path = self.network.paths.add(each.line)
        region = self.network.regions.add(each.shape)
        road = each.lane.road
        return Lane(
            self.network,
            index,
            each.name,
            self.role(index, self.plan.links.sections[road].road),
            each.width,
            path,
            region,
            f"road{road}",
            each.number,
            each.lane.forward,
        )

    def role(self, index: int, road: OdrRoad) -> LaneRole:
        if road.junction != THROUGH:
            return LaneRole.CONNECTING
        if index in self.starts:
            return LaneRole.LINK if index in self.ends else LaneRole.INCOMING
        return LaneRole.OUTGOING if index in self.ends else LaneRole.THROUGH

    def road(self, road: str) -> Road:
        name = f"road{road}"
        lanes = sorted((lane for lane in self.network.lanes if lane.road == name), key=lambda lane: lane.number)
        groups = [
            LaneGroup(self.network, name, way, tuple(lane for lane in lanes if lane.forward is way))
            for way in (True, False)
        ]
        return Road(self.network, name, *groups, ())

    def maneuver(self, index: int, intersection: int, way: Way) -> Maneuver:
        start, connecting, end = (self.network.lanes[each] for each in way[1:])
        kind = self.kind(start, connecting, end)
        name = f"{start.name}-{end.name} {kind.name.lower()}"
        return Maneuver(self.network, index, name, kind, start.id, connecting.id, end.id, intersection)

    def kind(self, start: Lane, connecting: Lane, end: Lane) -> ManeuverType:
        """Back on the same road is a U-turn; else by how much the connecting lane turns."""
        if start.road == end.road:
            return ManeuverType.U_TURN
        paths = self.network.paths
        first, last = paths.pose(connecting.path, 0.0), paths.pose(connecting.path, connecting.length)
        turn = math.remainder(last.heading - first.heading, math.tau)
        if abs(turn) < TURN_THRESHOLD:
            return ManeuverType.STRAIGHT
        return ManeuverType.LEFT_TURN if turn > 0.0 else ManeuverType.RIGHT_TURN

    def intersection(self, number: int, junction: str, area: int) -> Intersection:
        lanes, ways = self.network.lanes, self.plan.junctions[junction]
        corners = self.plan.areas[junction].edges[:, :2]
        center = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        starts, ends = ([lanes[i] for i in dict.fromkeys(way[place] for way in ways)] for place in (1, 3))
        roads = dict.fromkeys(lane.road for lane in (*starts, *ends))
        legs = [self.leg(road, starts, ends) for road in roads]
        legs.sort(key=lambda leg: -math.remainder(leg[0] - math.pi / 2.0 - 1e-9, math.tau))
        axis = legs[0][0]
        made = tuple(
            Leg(
                road,
                heading,
                length,
                incoming,
                outgoing,
                None,
                int(abs(math.cos(heading - axis)) < math.sqrt(0.5)),
            )
            for heading, road, length, incoming, outgoing in legs
        )
        x, y = center.tolist()
        return Intersection(self.network, number, f"junction{junction}", 0, number, (x, y), area, made)

    def leg(
        self, road: str, starts: Sequence[Lane], ends: Sequence[Lane]
    ) -> tuple[float, str, float, tuple[Lane, ...], tuple[Lane, ...]]:
        """Heading of the traffic that leaves by a road, its name and length, and its lanes at the junction."""
        paths = self.network.paths
        incoming = sorted((lane for lane in starts if lane.road == road), key=lambda lane: lane.number)
        outgoing = sorted((lane for lane in ends if lane.road == road), key=lambda lane: lane.number)
        lane = (outgoing or incoming)[0]
        at_end = 0.0 if outgoing else lane.length
        heading = paths.pose(lane.path, at_end).heading + (0.0 if outgoing else math.pi)
        return math.remainder(heading, math.tau), road, lane.length, tuple(incoming), tuple(outgoing)

    # -- references

    def link(self) -> None:
        network, plan = self.network, self.plan
        count = len(network.lanes)
        links = Links(
            maneuvers=[() for _ in range(count)],
            intersection=[None] * count,
            successors=[() for _ in range(count)],
            predecessors=[() for _ in range(count)],
            default_route=[lane.path for lane in network.lanes],
            conflicts=self.conflicts(),
            beside={index: (each.left, each.right) for index, each in enumerate(plan.lanes)},
        )
        network.links = links
        for maneuver in network.maneuvers:
            links.maneuvers[maneuver.start] += (maneuver.id,)
            links.intersection[maneuver.start] = links.intersection[maneuver.connecting] = maneuver.intersection_id
            self.follow(maneuver.start, maneuver.connecting)
        for before, after in plan.links.successors.items():
            self.follow(before, after)
        apart = [0.0]
        for lane in network.lanes:
            links.default_route[lane.id] = network.paths.join([network.lanes[i].path for i in self.route(lane, apart)])
        if max(apart) > GAP:
            network.remarks += (f"ends of lanes lie up to {max(apart):.2f} m apart: nobody drives on over them",)

    def follow(self, before: int, after: int) -> None:
        links = self.network.links
        if after not in links.successors[before]:
            links.successors[before] += (after,)
            links.predecessors[after] += (before,)

    def route(self, lane: Lane, apart: list[float]) -> list[int]:
        """The lanes that a driver without a plan takes: straight on where that can be."""
        network, route, length = self.network, [lane.id], lane.length
        while length < ROUTE:
            here = network.lanes[route[-1]]
            onward = self.onward(here)
            if not onward or any(index in route for index in onward):
                break
            chain = [here, *(network.lanes[index] for index in onward)]
            if not all(network.paths.continues(a.path, b.path) for a, b in pairwise(chain)):
                apart.append(self.gap(chain[0], chain[1]))
                break
            route += onward
            length += sum(network.lanes[index].length for index in onward)
        return route

    def gap(self, before: Lane, after: Lane) -> float:
        paths = self.network.paths
        end, start = paths.pose(before.path, before.length), paths.pose(after.path, 0.0)
        return math.hypot(end.x - start.x, end.y - start.y)

    def onward(self, lane: Lane) -> list[int]:
        near = ManeuverType.LEFT_TURN if self.plan.left_hand else ManeuverType.RIGHT_TURN
        ranking = {ManeuverType.STRAIGHT: 0, near: 1}
        if lane.maneuvers:
            chosen = min(lane.maneuvers, key=lambda maneuver: ranking.get(maneuver.type, 2))
            return [chosen.connecting, chosen.end]
        following = self.plan.links.successors.get(lane.id)
        return [] if following is None else [following]

    def conflicts(self) -> list[tuple[int, ...]]:
        """Per maneuver those of its intersection from other lanes whose centre lines meet its own."""
        network = self.network
        lines = {each.connecting: network.paths.points(each.connecting_lane.path, 0.01) for each in network.maneuvers}
        found: list[list[int]] = [[] for _ in network.maneuvers]
        by_place: dict[int, list[Maneuver]] = defaultdict(list)
        for maneuver in network.maneuvers:
            by_place[maneuver.intersection_id].append(maneuver)
        for here in by_place.values():
            for place, one in enumerate(here):
                for other in here[place + 1 :]:
                    if one.start != other.start and self.meet(one, other, lines):
                        found[one.id].append(other.id)
                        found[other.id].append(one.id)
        return [tuple(sorted(others)) for others in found]

    def meet(self, one: Maneuver, other: Maneuver, lines: Mapping[int, Floats]) -> bool:
        return one.end == other.end or polylines_cross(lines[one.connecting], lines[other.connecting])
