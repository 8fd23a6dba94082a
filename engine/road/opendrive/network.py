"""The network of an OpenDRIVE file.

What takes long is done once for a file of given contents, and kept in the user's cache (`contents`); the network is
made of that anew each time, since a scenario joins paths of its own.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from engine import frozen, maps, opendrive, tables, vocabulary
from engine.atomic import write_one
from engine.interchange import contract, xml
from engine.interchange.contract import InterchangeError
from engine.maps import MapFile, digest_of
from engine.opendrive.read import OdrRoad
from engine.road.linking import link_by_ways, maneuver
from engine.road.network import (
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Leg,
    Network,
    Road,
)
from engine.road.opendrive.contents import Contents, from_bytes, packed, to_bytes, unpacked
from engine.road.opendrive.linking import THROUGH
from engine.road.opendrive.planning import LanePlan, Plan, plan_of
from engine.road.opendrive.signs import signs_of
from engine.road.paths import PathBook
from engine.tables import ROAD_REGION
from engine.user_cache import cached_file, fingerprint

GAP, TURN = 0.5, 0.2
"""Lanes whose ends lie further apart, or differ more in heading, are not driven from one to the other [m, rad]."""


def map_file(path: Path, name: str) -> MapFile:
    """The specification of the roads of a file; `name` is what it is called where it is asked for.

    Raises:
        InterchangeError: it is no OpenDRIVE file that can be driven on.
    """
    digest = digest_of(path)
    return MapFile(name, str(path), digest, contents_of(str(path), digest).intersections)


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
    return unpacked(contents_of(spec.path, spec.digest), spec)


# -- networks that are kept --------------------------------------------------------------------------------------------

FAMILY = "roads-*.bin"
CODE = (
    Path(__file__).parent,
    Path(__file__).parents[1],
    Path(opendrive.__file__).parent,
    *map(Path, (contract.__file__, frozen.__file__, maps.__file__, tables.__file__, vocabulary.__file__, xml.__file__)),
)
"""Files, and folders of files, that decide what is read."""


@lru_cache(maxsize=8)
def contents_of(path: str, digest: str) -> Contents:
    """What the file of this digest comes to, or came to when it was read before.

    Raises:
        InterchangeError: it is no OpenDRIVE file that can be driven on.
    """
    surfaces = find_spec("shapely")
    code = (*CODE, *([Path(surfaces.origin).parent] if surfaces is not None and surfaces.origin else ()))
    key = sha256("\0".join([digest, np.__version__, fingerprint(code)]).encode()).hexdigest()
    entry = cached_file(f"roads-{key[:24]}.bin", FAMILY)
    if entry is not None:
        with suppress(OSError):
            if (kept := from_bytes(entry.read_bytes(), key)) is not None:
                return kept
    plan = plan_of(path, digest)
    contents = packed(_Builder(MapFile(path, path, digest, len(plan.junctions)), plan).build(), GAP, TURN)
    if entry is not None:
        with suppress(OSError):
            write_one(entry, to_bytes(contents, key))
    return contents


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
        network.bounds = {index: each.bounds for index, each in enumerate(plan.lanes)}
        network.speed_limits = {
            index: each.speed_limit for index, each in enumerate(plan.lanes) if each.speed_limit is not None
        }
        roads = [self.road(road) for road in dict.fromkeys(each.lane.road for each in plan.lanes)]
        network.roads = tuple(road for road in roads if road.lanes[0].role is not LaneRole.CONNECTING)
        network.connecting_roads = tuple(road for road in roads if road.lanes[0].role is LaneRole.CONNECTING)
        ways = [(number, way) for number, each in enumerate(plan.junctions.values()) for way in each]
        network.maneuvers = tuple(
            maneuver(index, number, *(network.lanes[lane] for lane in way[1:]))
            for index, (number, way) in enumerate(ways)
        )
        network.intersections = tuple(
            self.intersection(number, junction, areas[junction]) for number, junction in enumerate(plan.junctions)
        )
        network.signs = tuple(signs_of(plan.links))
        beside = {index: (each.left, each.right) for index, each in enumerate(plan.lanes)}
        if (apart := link_by_ways(network, plan.links.successors, beside)) > GAP:
            network.remarks += (f"ends of lanes lie up to {apart:.2f} m apart: nobody drives on over them",)
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
