"""The network of an OpenDRIVE file, made of its plan element by element."""

from collections import defaultdict
from collections.abc import Iterator

from engine.maps import MapFile
from engine.opendrive.near_roads import OdrSignal
from engine.road.file_roads import (
    Junction,
    SurfaceRow,
    Way,
    add_intersections,
    add_roads,
    add_surfaces,
    link_lanes,
    role_of,
)
from engine.road.network import Lane, Network, RoadSign, SurfaceKind
from engine.road.opendrive.contents import Contents, packed
from engine.road.opendrive.lanes import ALIKE, NEAR, THROUGH, Part, Sections
from engine.road.opendrive.linking import Links
from engine.road.opendrive.planning import LanePlan, Plan, plan_of
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
        add_roads(network)
        add_intersections(
            network,
            [
                Junction(f"junction{each}", areas[each], [Way(*way[1:]) for way in ways])
                for each, ways in plan.junctions.items()
            ],
        )
        network.signs = tuple(signs_of(plan.links))
        add_surfaces(network, self.surfaces())
        beside = {index: (each.left, each.right) for index, each in enumerate(plan.lanes)}
        link_lanes(network, plan.links.successors, beside)
        return network

    def lane(self, index: int, each: LanePlan) -> Lane:
        path = self.network.paths.add(each.line)
        region = self.network.regions.add(each.shape)
        road = each.lane.road
        return Lane(
            self.network,
            index,
            each.name,
            role_of(
                index,
                connects=self.plan.links.sections[road].road.junction != THROUGH,
                starts=self.starts,
                ends=self.ends,
            ),
            each.width,
            path,
            region,
            f"road{road}",
            each.number,
            each.lane.forward,
        )

    def surfaces(self) -> Iterator[SurfaceRow]:
        """Yield all surfaces, crossings last."""
        numbers = {junction: index for index, junction in enumerate(self.plan.junctions)}
        seen: dict[tuple[str, SurfaceKind], int] = defaultdict(int)
        for each in self.plan.surfaces:
            number, seen[each.road, each.kind] = seen[each.road, each.kind], seen[each.road, each.kind] + 1
            name, at = f"road{each.road}.{each.kind.value}{number}", None
            if each.kind is SurfaceKind.CROSSING:
                at = numbers.get(self.plan.links.network.roads[each.road].junction)
            about = (each.line, each.shape, each.width, f"road{each.road}", each.forward, at)
            yield SurfaceRow(each.kind, name, *about)


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
