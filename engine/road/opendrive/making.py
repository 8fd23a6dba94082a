"""The network of an OpenDRIVE file, made of its plan element by element."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence

from engine.maps import MapFile
from engine.opendrive.near_roads import OdrSignal
from engine.opendrive.roads import OdrRoad
from engine.road.areas import CARRIAGEWAY
from engine.road.linking import link_by_ways, maneuver
from engine.road.network import (
    Arm,
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Network,
    Road,
    RoadSign,
    Surface,
    SurfaceKind,
)
from engine.road.opendrive.beside import Sidewalks
from engine.road.opendrive.contents import Contents, packed
from engine.road.opendrive.lanes import ALIKE, NEAR, THROUGH, Part, Sections
from engine.road.opendrive.linking import Links
from engine.road.opendrive.planning import LanePlan, Plan, plan_of
from engine.road.opendrive.surfaces import NoSurface, merged
from engine.road.paths import PathBook
from engine.tables import ROAD_REGION


def read(path: str, digest: str) -> Contents:
    """Return the contents of the file with this digest.

    Raises:
        InterchangeError: it is not an OpenDRIVE file with drivable roads.
    """
    return packed(built(path, digest), NEAR, ALIKE)


def built(path: str, digest: str) -> Network:
    """Return the network of that file, without a cache.

    Raises:
        InterchangeError: it is not an OpenDRIVE file with drivable roads.
    """
    plan = plan_of(path, digest)
    return _Builder(MapFile(path, path, digest, len(plan.junctions)), plan).build()


class _Builder:
    """The network under construction; each step adds one kind of element."""

    def __init__(self, spec: MapFile, plan: Plan) -> None:
        self.plan = plan
        self.network = Network(spec, plan.left_hand, PathBook(NEAR, ALIKE), drawn=plan.drawn)
        self.network.remarks, self.network.levels, self.network.unread = plan.remarks, plan.levels, plan.unread
        self.network.heights = plan.heights
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
        by_road: dict[str, list[Lane]] = defaultdict(list)
        for lane in network.lanes:
            by_road[lane.road].append(lane)
        roads = [self.road(name, lanes) for name, lanes in by_road.items()]
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
        self.add_surfaces()
        beside = {index: (each.left, each.right) for index, each in enumerate(plan.lanes)}
        if (apart := link_by_ways(network, plan.links.successors, beside)) > NEAR:
            network.remarks += (f"ends of lanes lie up to {apart:.2f} m apart: no vehicle drives across",)
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

    def add_surfaces(self) -> None:
        """Add all surfaces; crossings, which come last, get the sidewalks at their ends."""
        network, found = self.network, list[Surface]()
        numbers = {junction: index for index, junction in enumerate(self.plan.junctions)}
        seen: dict[tuple[str, SurfaceKind], int] = defaultdict(int)
        walks: Sidewalks | None = None
        for each in self.plan.surfaces:
            number, seen[each.road, each.kind] = seen[each.road, each.kind], seen[each.road, each.kind] + 1
            name, at, ends = f"road{each.road}.{each.kind.value}{number}", None, None
            if each.kind is SurfaceKind.CROSSING:
                walks = walks or Sidewalks(tuple(other for other in found if other.kind is SurfaceKind.SIDEWALK))
                at = numbers.get(self.plan.links.network.roads[each.road].junction)
                first, last = each.line[0], each.line[-1]
                ends = walks.nearest(first.pose(0.0)), walks.nearest(last.pose(last.length))
            about = (each.kind, name, each.line, each.shape, each.width, f"road{each.road}", each.forward, at, ends)
            found.append(Surface(network, len(found), *about))
        network.surfaces = tuple(found)
        if strips := [each.shape for each in found if each.kind in CARRIAGEWAY]:
            try:
                network.between_kerbs = merged([*strips, self.plan.surface])
            except NoSurface:
                network.remarks += ("the area between the kerbs cannot be computed: vehicles start on the lanes only",)

    def road(self, name: str, lanes: Sequence[Lane]) -> Road:
        lanes = sorted(lanes, key=lambda lane: lane.number)
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
            Arm(
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
        """Return heading of outgoing traffic, name and length of an arm, and its lanes at the junction."""
        paths = self.network.paths
        incoming = sorted((lane for lane in starts if lane.road == road), key=lambda lane: lane.number)
        outgoing = sorted((lane for lane in ends if lane.road == road), key=lambda lane: lane.number)
        lane = (outgoing or incoming)[0]
        at_end = 0.0 if outgoing else lane.length
        heading = paths.pose(lane.path, at_end).heading + (0.0 if outgoing else math.pi)
        return math.remainder(heading, math.tau), road, lane.length, tuple(incoming), tuple(outgoing)


# -- signals of the file, at their lanes -------------------------------------------------------------------------------


def signs_of(links: Links) -> Iterator[RoadSign]:
    """Yield all signs, road by road."""
    for sections in links.sections.values():
        road = sections.road
        for each in road.signals:
            place = road.reference(each.s).moved(0.0, each.t)
            lanes = tuple(dict.fromkeys(_lanes(links, sections, each)))
            about = (each.id, each.name, each.country, each.type, each.subtype, each.value)
            yield RoadSign(*about, f"road{road.id}", place.x, place.y, lanes)


def _lanes(links: Links, sections: Sections, signal: OdrSignal) -> Iterator[int]:
    """Yield the indices of the lanes to which a signal applies."""
    number = next((i for i, (_, end) in enumerate(sections.rows) if signal.s <= end), len(sections.rows) - 1)
    for lane in sections.drivable(number) if sections.rows else ():
        # Named lanes have priority: CARLA's towns have orientations that contradict them.
        meant = any(min(pair) <= lane <= max(pair) for pair in signal.lanes)
        if meant if signal.lanes else signal.along in (None, not sections.road.against(lane)):
            yield links.lane_of[sections.road.id, Part(number, lane)]
