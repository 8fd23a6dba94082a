"""Elements of roads that a scenario can name: roads, intersections, lanes, maneuvers; filled by a maker.

`Network` describes a road of any maker (`engine.road.build`). Elements refer to each other by ids, which their network
resolves. Elements are equal only if they are identical.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property, wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from engine.frozen import frozen, frozen_identity
from engine.maps import MapFile, MapSpec
from engine.road.paths import PathBook, Pose, Primitive
from engine.road.regions import RegionBook, Shape, contains, shape_area
from engine.tables import Floats
from engine.vocabulary import HeightColumn, ManeuverType

# -- lights and signs of a file ----------------------------------------------------------------------------------------

TRAFFIC_LIGHT = "1000001"
"""OpenDRIVE's type of a traffic light of three colours, the only type that Scenic counts as one."""


@frozen
class RoadSign:
    """A traffic light or a sign, at one place at which it applies."""

    id: str
    """Id in the file."""
    name: str
    country: str
    type: str
    subtype: str
    value: float | None
    road: str
    """Name of the road to which it applies."""
    x: float
    y: float
    lanes: tuple[int, ...]
    """Ids of the lanes to which it applies."""

    @property
    def is_traffic_light(self) -> bool:
        return self.type == TRAFFIC_LIGHT


FACING = math.sqrt(0.5)
"""Cosine of the angle between two directions beyond which traffic is oncoming, or from behind: 45 degrees."""


class LaneRole(Enum):
    INCOMING = "incoming"
    """Lane from the border of the network to an intersection."""
    OUTGOING = "outgoing"
    """Lane from an intersection to the border."""
    LINK = "link"
    """Lane from one intersection to the next: outgoing for the first, incoming for the second."""
    THROUGH = "through"
    """Lane from border to border, without an intersection."""
    CONNECTING = "connecting"
    """Lane through an intersection, from stop line to stop line."""


@frozen_identity
class Lane:
    """One lane of one direction, with its centre line and the strip it covers."""

    network: "Network" = field(repr=False)
    id: int
    """Index in `network.lanes`."""
    name: str
    """Unique: `north.in.1` is lane 1 of the traffic coming in from the north; lane 1 is next to the kerb."""
    role: LaneRole
    width: float
    path: int
    """Id of the centre line in `network.paths`."""
    region: int
    """Id of the strip in `network.regions`."""
    road: str
    """Road of the lane: both directions of an arm share one; the intersection for connecting lanes."""
    number: int
    """1 next to the kerb; for a connecting lane, the number of its start lane."""
    forward: bool
    """True if it runs in the direction of its road; connecting lanes do."""

    @property
    def source(self) -> str:
        """Return the text that names this lane in the language."""
        return f"network.lanes[{self.id}]"

    @property
    def length(self) -> float:
        """Return the length [m]."""
        return self.network.paths.length(self.path)

    @property
    def maneuvers(self) -> "tuple[Maneuver, ...]":
        """Return the possible maneuvers at the lane's end: straight, left, right; () if the network ends there."""
        return tuple(self.network.maneuvers[i] for i in self.network.links.maneuvers[self.id])

    @property
    def intersection(self) -> "Intersection | None":
        """Return the intersection this lane leads into, or runs through."""
        index = self.network.links.intersection[self.id]
        return None if index is None else self.network.intersections[index]

    @property
    def speed_limit(self) -> float | None:
        """Return the speed limit of signs [m/s]; None without one."""
        return self.network.speed_limits.get(self.id)

    @property
    def ends_at_line(self) -> bool:
        """Return True if traffic waits at its end, at a line on the road; False in the ring of a roundabout."""
        first = self.network.links.gives_way
        if not self.maneuvers or first is None or self.role is LaneRole.INCOMING:
            return bool(self.maneuvers)
        return isinstance(self.network.spec, MapFile) and any(first[each.id] for each in self.maneuvers)

    @property
    def successors(self) -> "tuple[Lane, ...]":
        return tuple(self.network.lanes[i] for i in self.network.links.successors[self.id])

    @property
    def predecessors(self) -> "tuple[Lane, ...]":
        return tuple(self.network.lanes[i] for i in self.network.links.predecessors[self.id])

    @property
    def default_route(self) -> int:
        """Return the path of a driver without a plan: this lane, straight on (else the near, else the far turn), and
        on.
        """
        return self.network.links.default_route[self.id]


@frozen_identity
class Maneuver:
    """One way through an intersection."""

    network: "Network" = field(repr=False)
    id: int
    """Index in `network.maneuvers`."""
    name: str
    type: ManeuverType
    start: int = field(repr=False)
    connecting: int = field(repr=False)
    end: int = field(repr=False)
    intersection_id: int = field(repr=False)

    @property
    def source(self) -> str:
        """Return the text that names this maneuver in the language."""
        return f"{self.start_lane.source}.maneuvers[{self.start_lane.maneuvers.index(self)}]"

    @property
    def start_lane(self) -> Lane:
        return self.network.lanes[self.start]

    @property
    def connecting_lane(self) -> Lane:
        return self.network.lanes[self.connecting]

    @property
    def end_lane(self) -> Lane:
        return self.network.lanes[self.end]

    @property
    def lanes(self) -> tuple[Lane, Lane, Lane]:
        """Return start, connecting and end lane: the trajectory of the maneuver."""
        return self.start_lane, self.connecting_lane, self.end_lane

    @property
    def intersection(self) -> "Intersection":
        return self.network.intersections[self.intersection_id]

    @property
    def conflicting_maneuvers(self) -> "tuple[Maneuver, ...]":
        """Return the maneuvers from other lanes whose connecting lane's centre line crosses or joins this one's."""
        return tuple(self.network.maneuvers[i] for i in self.network.links.conflicts[self.id])

    @property
    def oncoming_maneuvers(self) -> "tuple[Maneuver, ...]":
        """Return the maneuvers of the intersection that begin against this one's direction, within 45 degrees."""
        here = self.intersection.maneuvers
        return tuple(m for m in here if self._faces(m) < -FACING and m.start_lane.road != self.start_lane.road)

    @property
    def crossing_maneuvers(self) -> "tuple[Maneuver, ...]":
        """Return the conflicting maneuvers that begin across this one's direction: from its left or its right."""
        return tuple(m for m in self.conflicting_maneuvers if abs(self._faces(m)) <= FACING)

    def _faces(self, other: "Maneuver") -> float:
        """Return the cosine of the angle between the directions in which both enter the intersection."""
        paths = self.network.paths
        mine, theirs = (paths.pose(each.path, each.length).heading for each in (self.start_lane, other.start_lane))
        return math.cos(mine - theirs)

    @property
    def gives_way_to(self) -> "tuple[Maneuver, ...]":
        """Return the maneuvers with priority: by signs in a roundabout, elsewhere all that conflict."""
        first = self.network.links.gives_way
        return self.conflicting_maneuvers if first is None else tuple(self.network.maneuvers[i] for i in first[self.id])

    @property
    def reverse_maneuvers(self) -> "tuple[Maneuver, ...]":
        """Return the maneuvers that start on the end road of this maneuver, and end on its start road."""
        start, end = self.start_lane.road, self.end_lane.road
        here = self.intersection.maneuvers
        return tuple(m for m in here if m.start_lane.road == end and m.end_lane.road == start)


class SurfaceKind(Enum):
    SIDEWALK = "sidewalk"
    CURB = "curb"
    """Line between the carriageway and the sidewalk; its region is a strip along the line."""
    SHOULDER = "shoulder"
    PARKING = "parking"
    BIKE_LANE = "bike_lane"
    CROSSING = "crossing"


LANE_TYPES: Mapping[SurfaceKind, tuple[str, ...]] = {
    SurfaceKind.SIDEWALK: ("sidewalk", "walking"),
    SurfaceKind.CURB: ("curb",),
    SurfaceKind.SHOULDER: ("shoulder", "border"),
    SurfaceKind.PARKING: ("parking",),
    SurfaceKind.BIKE_LANE: ("biking",),
}
"""Types of lanes in OpenDRIVE by the kind of surface that is read from them; the first is written."""


@frozen_identity
class Surface:
    """A strip beside the lanes of one direction, along a corner, or across a road: no lane of motor vehicles."""

    network: "Network" = field(repr=False)
    id: int
    """Index in `network.surfaces`."""
    kind: SurfaceKind
    name: str
    line: tuple[Primitive, ...] = field(repr=False)
    """Centre line: with the traffic beside it; over a crossing, from sidewalk to sidewalk."""
    shape: Shape = field(repr=False)
    """Area."""
    width: float
    road: str
    """Road of the surface; the intersection for a corner, or for a crossing at an intersection."""
    forward: bool = True
    """True beside the lanes in the direction of the road."""
    intersection_id: int | None = None
    """Intersection of a corner or of a crossing."""
    ends: tuple[int | None, int | None] | None = None
    """Ids of the sidewalks at the start and end of a crossing; None where there is none."""
    arm: int | None = None
    """Index in `Intersection.legs` of the arm that a crossing at an intersection leads across."""

    @property
    def source(self) -> str:
        """Return the text that names this element in the language."""
        listed = LISTED_IN[self.kind]
        return f"network.{listed}[{self.network.elements_of(listed).index(self)}]" if listed else self.name

    @property
    def length(self) -> float:
        """Return the length of the centre line [m]."""
        return sum(each.length for each in self.line)

    @property
    def area(self) -> float:
        """Return the area [m^2]."""
        return shape_area(self.shape)

    def contains(self, x: float, y: float) -> bool:
        """Return True if a point is inside."""
        return contains(self.shape, x, y)

    @property
    def ends_at(self) -> tuple[Pose, Pose]:
        """Return the poses at the start and the end of the centre line."""
        return self.line[0].pose(0.0), self.line[-1].pose(self.line[-1].length)

    @property
    def path(self) -> int:
        """Return the id of the centre line in `network.paths`, to which the first use adds it."""
        added = self.network.added_paths
        return added[self.id] if self.id in added else added.setdefault(self.id, self.network.paths.add(self.line))

    @property
    def region(self) -> int:
        """Return the id of the area in `network.regions`, to which the first use adds it."""
        added = self.network.added_regions
        return added[self.id] if self.id in added else added.setdefault(self.id, self.network.regions.add(self.shape))

    @property
    def parent(self) -> "Road | Intersection | None":
        """Return the intersection of a crossing or a corner, else the road."""
        if self.intersection_id is not None:
            return self.network.intersections[self.intersection_id]
        return self.network.road_named.get(self.road)

    @property
    def sidewalks(self) -> "tuple[Surface | None, ...]":
        """Return the sidewalks at the start and end of a crossing."""
        return tuple(None if each is None else self.network.surfaces[each] for each in self.ends or ())

    @property
    def crossings(self) -> "tuple[Surface, ...]":
        """Return the crossings that begin or end at a sidewalk."""
        return tuple(each for each in self.network.surfaces if self.id in (each.ends or ()))


LISTED_IN: Mapping[SurfaceKind, str] = {
    SurfaceKind.SIDEWALK: "sidewalks",
    SurfaceKind.CURB: "",
    SurfaceKind.SHOULDER: "shoulders",
    SurfaceKind.PARKING: "shoulders",
    SurfaceKind.BIKE_LANE: "bikeLanes",
    SurfaceKind.CROSSING: "crossings",
}
"""Tuple of the network that lists the elements of a kind, by its name in the language; "" without one."""


@frozen
class LaneGroup:
    """The lanes of one road in one direction."""

    network: "Network" = field(repr=False)
    road: str
    forward: bool
    lanes: tuple[Lane, ...]
    """Lanes from the kerb to the middle."""

    @property
    def name(self) -> str:
        return f"{self.road} {'forward' if self.forward else 'backward'}"


@frozen
class Road:
    """A road outside intersections, with both directions: an arm, or a link between two intersections."""

    network: "Network" = field(repr=False)
    name: str
    forward: LaneGroup
    """Forward lanes; at the border, those that lead into the intersection."""
    backward: LaneGroup
    """Backward lanes; without lanes on a one-way road."""
    middle: tuple[Primitive, ...] = field(repr=False)
    """Line between the two directions, along the forward lanes; one primitive for each of theirs."""

    @property
    def source(self) -> str:
        """Return the text that names this road in the language."""
        return f"network.roads[{self.network.roads.index(self)}]"

    @property
    def lanes(self) -> tuple[Lane, ...]:
        return (*self.forward.lanes, *self.backward.lanes)

    @property
    def groups(self) -> tuple[LaneGroup, ...]:
        """Return the directions with lanes."""
        return tuple(group for group in (self.forward, self.backward) if group.lanes)


@frozen_identity
class Arm:
    """One arm of an intersection."""

    name: str
    """`north`, `east`, `south` or `west`, as seen from the centre."""
    heading: float
    """Heading of outgoing traffic [rad]."""
    length: float
    """Length from the stop line to the end of the road, or to the next stop line [m]."""
    incoming_lanes: tuple[Lane, ...]
    """Incoming lanes from the kerb to the middle."""
    outgoing_lanes: tuple[Lane, ...]
    neighbour: int | None
    """Id of the intersection at the far end of the arm; None at the border."""
    phase: int
    """0 or 1: lights of one phase are green together."""


@frozen_identity
class Intersection:
    """The area between the stop lines where roads meet."""

    network: "Network" = field(repr=False)
    id: int
    """Index in `network.intersections`."""
    name: str
    row: int
    """Row from 0, counted northwards."""
    col: int
    """Column from 0, counted eastwards."""
    center: tuple[float, float]
    """[m]"""
    region: int
    """Id of its area in `network.regions`."""
    legs: tuple[Arm, ...] = field(repr=False)
    """Clockwise from the north."""

    @property
    def source(self) -> str:
        """Return the text that names this intersection in the language."""
        return f"network.intersections[{self.id}]"

    @property
    def incoming_lanes(self) -> tuple[Lane, ...]:
        return tuple(lane for leg in self.legs for lane in leg.incoming_lanes)

    @property
    def outgoing_lanes(self) -> tuple[Lane, ...]:
        return tuple(lane for leg in self.legs for lane in leg.outgoing_lanes)

    @property
    def maneuvers(self) -> tuple[Maneuver, ...]:
        return tuple(maneuver for lane in self.incoming_lanes for maneuver in lane.maneuvers)

    @property
    def is_3way(self) -> bool:
        return len(self.legs) == 3

    @property
    def is_4way(self) -> bool:
        return len(self.legs) == 4


@dataclass(eq=False)
class Links:
    """References between elements by id; filled while the network is built and fixed from then on."""

    maneuvers: list[tuple[int, ...]] = field(default_factory=list)
    """Per lane."""
    intersection: list[int | None] = field(default_factory=list)
    successors: list[tuple[int, ...]] = field(default_factory=list)
    predecessors: list[tuple[int, ...]] = field(default_factory=list)
    default_route: list[int] = field(default_factory=list)
    conflicts: list[tuple[int, ...]] = field(default_factory=list)
    """Per maneuver."""
    beside: Mapping[int, tuple[int | None, int | None]] | None = None
    """Left and right neighbour per lane; None if they follow from lane numbers."""
    gives_way: Sequence[tuple[int, ...]] | None = None
    """Maneuvers with priority per maneuver; None without signs."""


@frozen
class Lines:
    """Polylines, each (n, 2) [m]."""

    kerbs: tuple[Floats, ...]
    middle: tuple[Floats, ...]
    """Lines between the two directions of a road."""
    between: tuple[Floats, ...]
    """Lines between lanes of one direction."""


@dataclass(eq=False)
class Network:
    """Roads and intersections. A maker fills it once; paths and regions are added later, too.

    Duties of a maker: consecutive lanes meet as `PathBook.continues` requires; a lane has a constant width; lanes are
    numbered from the kerb to the middle; maneuvers of an intersection are adjacent.
    """

    spec: MapSpec
    """Specification, from which the network can be made again."""
    left_hand: bool
    paths: PathBook = field(default_factory=PathBook)
    """Centre lines of all lanes, default routes, and paths that a scenario joins."""
    regions: RegionBook = field(default_factory=RegionBook)
    """Region 0 is the whole drivable road; then those of its elements, and those of a scenario."""
    roads: tuple[Road, ...] = ()
    """Roads in the order of their lanes."""
    intersections: tuple[Intersection, ...] = ()
    lanes: tuple[Lane, ...] = ()
    """Lanes of all roads first, connecting lanes last."""
    maneuvers: tuple[Maneuver, ...] = ()
    links: Links = field(default_factory=Links, repr=False)
    connecting_roads: tuple[Road, ...] = ()
    """Roads of connecting lanes, in a file that has them."""
    kerbs: tuple[Floats, ...] = ()
    """Kerb lines, each (n, 2), that are not a lane's border: around the corners of intersections."""
    drawn: Lines | None = None
    """Lines of lanes with variable widths; None: the borders of lanes are drawn."""
    remarks: tuple[str, ...] = ()
    """Warnings about parts of the map that were repaired or omitted."""
    levels: tuple[str, ...] = ()
    """Remarks on roads that pass over others."""
    heights: Floats = field(default_factory=lambda: np.zeros((0, len(HeightColumn))))
    """(n, len(HeightColumn)): points along the centres of all lanes; none on a single level."""
    unread: str = ""
    """Content of a file that the reader does not read, by kind."""
    bounds: Mapping[int, tuple[Floats, Floats]] = field(default_factory=dict[int, tuple[Floats, Floats]])
    """Left and right border of a file's lanes, by id: (n, 2) each, in driving direction."""
    speed_limits: Mapping[int, float] = field(default_factory=dict[int, float])
    """Speed limits by id of the lane [m/s]."""
    signs: tuple[RoadSign, ...] = ()
    """Traffic lights and signs of a file."""
    buildings: Floats = field(default_factory=lambda: np.zeros((0, 5)))
    """(n, 5): x, y, heading, length, width of blocks between the arms, then of parked cars."""

    lay: "Callable[[Network], tuple[Surface, ...]] | None" = field(default=None, repr=False)
    """Function that makes the surfaces, which few scenarios use."""
    added_paths: dict[int, int] = field(default_factory=dict[int, int], repr=False)
    """Paths of the surfaces that were used, by their ids."""
    added_regions: dict[int, int] = field(default_factory=dict[int, int], repr=False)
    between_kerbs: Shape | None = field(default=None, repr=False)
    """Road, shoulders, parking rows and bicycle lanes of a file, as one region; None without such strips."""
    parked: int = 0
    """Number of the last rows of `buildings` that are parked cars."""

    @cached_property
    def surfaces(self) -> tuple[Surface, ...]:
        """Return sidewalks, kerbs, shoulders, parking rows, bicycle lanes and crossings; along a road in the order of
        its traffic.
        """
        return () if self.lay is None else self.lay(self)

    def elements_of(self, listed: str) -> tuple[Surface, ...]:
        """Return the surfaces of a tuple that `LISTED_IN` names."""
        return tuple(each for each in self.surfaces if LISTED_IN[each.kind] == listed)

    def beside(self, road: str, kind: SurfaceKind, *, forward: bool) -> "Surface | None":
        """Return the longest surface of a kind beside the lanes of one direction; None without one."""
        along = (each for each in self.surfaces if each.kind is kind and each.intersection_id is None)
        there = (each for each in along if each.road == road and each.forward is forward)
        return max(there, key=lambda each: each.length, default=None)

    @cached_property
    def road_named(self) -> Mapping[str, Road]:
        return {road.name: road for road in (*self.roads, *self.connecting_roads)}

    @cached_property
    def arms(self) -> int:
        """Return the numbers of arms that an intersection may have; lights are numbered by arms."""
        return max([4, *(len(intersection.legs) for intersection in self.intersections)])


# -- results kept for the lifetime of a network ------------------------------------------------------------------------

Found = TypeVar("Found")


def once_per_network(find: Callable[[Network], Found]) -> Callable[[Network], Found]:
    """Return `find` with a cache per network. A result must not refer to its network, or both are never freed."""
    found: WeakKeyDictionary[Network, Found] = WeakKeyDictionary()

    @wraps(find)
    def find_once(network: Network) -> Found:
        if network not in found:
            found[network] = find(network)
        return found[network]

    return find_once
