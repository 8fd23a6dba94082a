"""Elements of the networks of files, whatever the format: roads of lanes, intersections with their arms, roles."""

import math
from collections import defaultdict
from collections.abc import Collection, Sequence
from typing import NamedTuple

from engine.road.network import Arm, Intersection, Lane, LaneGroup, LaneRole, Network, Road


class Way(NamedTuple):
    """Ids of a lane, of a connecting lane behind it, and of the lane into which that leads."""

    start: int
    connecting: int
    end: int


def role_of(lane: int, *, connects: bool, starts: Collection[int], ends: Collection[int]) -> LaneRole:
    """Return the role of a lane among those that ways through intersections start and end with."""
    if connects:
        return LaneRole.CONNECTING
    if lane in starts:
        return LaneRole.LINK if lane in ends else LaneRole.INCOMING
    return LaneRole.OUTGOING if lane in ends else LaneRole.THROUGH


def add_roads(network: Network) -> None:
    """Add the roads of all lanes, in the order of their first lanes; those of connecting lanes apart."""
    by_road: dict[str, list[Lane]] = defaultdict(list)
    for lane in network.lanes:
        by_road[lane.road].append(lane)
    roads = [_road(network, name, lanes) for name, lanes in by_road.items()]
    network.roads = tuple(road for road in roads if road.lanes[0].role is not LaneRole.CONNECTING)
    network.connecting_roads = tuple(road for road in roads if road.lanes[0].role is LaneRole.CONNECTING)


def _road(network: Network, name: str, lanes: Sequence[Lane]) -> Road:
    lanes = sorted(lanes, key=lambda lane: lane.number)
    forward, backward = (
        LaneGroup(network, name, way, tuple(lane for lane in lanes if lane.forward is way)) for way in (True, False)
    )
    return Road(network, name, forward, backward, ())


def intersection(network: Network, number: int, name: str, area: int, ways: Sequence[Way]) -> Intersection:
    """Return an intersection: its area by the id of a region, and the ways through it."""
    corners = network.regions.shape(area).edges[:, :2]
    center = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    starts = [network.lanes[index] for index in dict.fromkeys(way.start for way in ways)]
    ends = [network.lanes[index] for index in dict.fromkeys(way.end for way in ways)]
    roads = dict.fromkeys(lane.road for lane in (*starts, *ends))
    legs = [_leg(network, road, starts, ends) for road in roads]
    legs.sort(key=lambda leg: -math.remainder(leg[0] - math.pi / 2.0 - 1e-9, math.tau))
    axis = legs[0][0]
    made = tuple(
        Arm(road, heading, length, incoming, outgoing, None, int(abs(math.cos(heading - axis)) < math.sqrt(0.5)))
        for heading, road, length, incoming, outgoing in legs
    )
    x, y = center.tolist()
    return Intersection(network, number, name, 0, number, (x, y), area, made)


def _leg(
    network: Network, road: str, starts: Sequence[Lane], ends: Sequence[Lane]
) -> tuple[float, str, float, tuple[Lane, ...], tuple[Lane, ...]]:
    """Return heading of outgoing traffic, name and length of an arm, and its lanes at the intersection."""
    paths = network.paths
    incoming = sorted((lane for lane in starts if lane.road == road), key=lambda lane: lane.number)
    outgoing = sorted((lane for lane in ends if lane.road == road), key=lambda lane: lane.number)
    lane = (outgoing or incoming)[0]
    at_end = 0.0 if outgoing else lane.length
    heading = paths.pose(lane.path, at_end).heading + (0.0 if outgoing else math.pi)
    return math.remainder(heading, math.tau), road, lane.length, tuple(incoming), tuple(outgoing)
