"""Elements of the networks of files, whatever the format: roads of lanes, intersections with their arms, surfaces."""

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

from engine.road.areas import CARRIAGEWAY
from engine.road.linking import Beside, Successors, link_by_ways, maneuver
from engine.road.network import (
    Arm,
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Network,
    Road,
    Surface,
    SurfaceKind,
)
from engine.road.opendrive.beside import Sidewalks
from engine.road.opendrive.lanes import NEAR
from engine.road.opendrive.surfaces import NoSurface, merged
from engine.road.paths import Primitive
from engine.road.regions import Shape
from engine.tables import ROAD_REGION


class Way(NamedTuple):
    """Ids of a lane, of a connecting lane behind it, and of the lane into which that leads."""

    start: int
    connecting: int
    end: int


class Junction(NamedTuple):
    """An intersection to be added."""

    name: str
    area: int
    """Id of its region."""
    ways: Sequence[Way]


class SurfaceRow(NamedTuple):
    """Fields of a `Surface` to be added."""

    kind: SurfaceKind
    name: str
    line: tuple[Primitive, ...]
    shape: Shape
    width: float
    road: str
    forward: bool
    intersection_id: int | None


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


def link_lanes(network: Network, successors: Successors, beside: Beside) -> None:
    """Link all lanes, with a remark if ends lie apart."""
    if (apart := link_by_ways(network, successors, beside)) > NEAR:
        network.remarks += (f"ends of lanes lie up to {apart:.2f} m apart: no vehicle drives across",)


# -- intersections -----------------------------------------------------------------------------------------------------


def add_intersections(network: Network, junctions: Sequence[Junction]) -> None:
    """Add the intersections and a maneuver for each way through them."""
    ways = [(number, way) for number, each in enumerate(junctions) for way in each.ways]
    network.maneuvers = tuple(
        maneuver(index, number, *(network.lanes[lane] for lane in way)) for index, (number, way) in enumerate(ways)
    )
    network.intersections = tuple(_intersection(network, number, *each) for number, each in enumerate(junctions))


def _intersection(network: Network, number: int, name: str, area: int, ways: Sequence[Way]) -> Intersection:
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


# -- surfaces ----------------------------------------------------------------------------------------------------------


def add_surfaces(network: Network, rows: Iterable[SurfaceRow]) -> None:
    """Add surfaces, and the area between the kerbs; crossings come last, and get the sidewalks at their ends."""
    found, walks = list[Surface](), None
    for each in rows:
        ends = None
        if each.kind is SurfaceKind.CROSSING:
            walks = walks or Sidewalks(tuple(other for other in found if other.kind is SurfaceKind.SIDEWALK))
            first, last = each.line[0], each.line[-1]
            ends = walks.nearest(first.pose(0.0)), walks.nearest(last.pose(last.length))
        found.append(Surface(network, len(found), *each, ends))
    network.surfaces = tuple(found)
    if shapes := [each.shape for each in found if each.kind in CARRIAGEWAY]:
        try:
            network.between_kerbs = merged([*shapes, network.regions.shape(ROAD_REGION)])
        except NoSurface:
            network.remarks += ("the area between the kerbs cannot be computed: vehicles start on the lanes only",)
