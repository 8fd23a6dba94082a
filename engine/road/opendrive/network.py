"""The network of an OpenDRIVE file.

What takes long is done once for a file of given contents (`planning`); the network around it is made anew each time,
since a scenario joins paths of its own.
"""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from engine.interchange.contract import InterchangeError
from engine.maps import MapFile, digest_of
from engine.opendrive.read import OdrRoad
from engine.road.linking import polylines_cross
from engine.road.network import (
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Leg,
    Links,
    Maneuver,
    Network,
    Road,
)
from engine.road.opendrive.linking import THROUGH, Way
from engine.road.opendrive.planning import LanePlan, Plan, plan_of
from engine.road.paths import PathBook
from engine.tables import ROAD_REGION, Floats
from engine.vocabulary import ManeuverType

GAP, TURN = 0.5, 0.2
"""Lanes whose ends lie further apart, or differ more in heading, are not driven from one to the other [m, rad]."""
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
    return MapFile(name, str(path), digest, len(plan_of(str(path), digest).junctions))


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
    return _Builder(spec, plan_of(spec.path, spec.digest)).build()


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
        forward, backward = (
            LaneGroup(self.network, name, way, tuple(lane for lane in lanes if lane.forward is way))
            for way in (True, False)
        )
        return Road(self.network, name, forward, backward, ())

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
        starts = [lanes[index] for index in dict.fromkeys(way.start for way in ways)]
        ends = [lanes[index] for index in dict.fromkeys(way.end for way in ways)]
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
