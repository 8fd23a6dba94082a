"""What a scenario can point at: roads, intersections, lanes, maneuvers; filled by a maker (`engine.road.build`).

`Network` describes a road, whoever made it. Elements refer to one another (a lane to its maneuvers, those to their
lanes) by ids, which their network resolves. Two elements are equal only if they are the same one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

import numpy as np

from engine.frozen import frozen, frozen_identity
from engine.maps import MapSpec
from engine.road.paths import PathBook, Primitive
from engine.road.regions import RegionBook
from engine.road.signs import RoadSign
from engine.tables import Floats
from engine.vocabulary import ManeuverType


class LaneRole(Enum):
    INCOMING = "incoming"
    """From the border of the network to an intersection."""
    OUTGOING = "outgoing"
    """From an intersection to the border."""
    LINK = "link"
    """From one intersection to the next: outgoing for the one, incoming for the other."""
    THROUGH = "through"
    """From border to border: there is no intersection."""
    CONNECTING = "connecting"
    """Through an intersection, from stop line to stop line."""


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
    """The road it belongs to: both directions of an arm share one; an intersection for connecting lanes."""
    number: int
    """1 next to the kerb; of a connecting lane, that of the lane it starts from."""
    forward: bool
    """Whether it runs as its road does; connecting lanes do."""

    @property
    def source(self) -> str:
        """Text that names this lane in the language."""
        return f"network.lanes[{self.id}]"

    @property
    def length(self) -> float:
        """[m]"""
        return self.network.paths.length(self.path)

    @property
    def maneuvers(self) -> "tuple[Maneuver, ...]":
        """What a driver may do at the lane's end: straight, left, right; () where the network ends."""
        return tuple(self.network.maneuvers[i] for i in self.network.links.maneuvers[self.id])

    @property
    def intersection(self) -> "Intersection | None":
        """The intersection this lane leads into, or runs through."""
        index = self.network.links.intersection[self.id]
        return None if index is None else self.network.intersections[index]

    @property
    def speed_limit(self) -> float | None:
        """What signs allow [m/s]; None where they say nothing."""
        return self.network.speed_limits.get(self.id)

    @property
    def ends_at_line(self) -> bool:
        """Whether traffic waits at its end, at a line on the road: not in the ring of a roundabout."""
        return bool(self.maneuvers) and (self.network.links.gives_way is None or self.role is LaneRole.INCOMING)

    @property
    def successors(self) -> "tuple[Lane, ...]":
        return tuple(self.network.lanes[i] for i in self.network.links.successors[self.id])

    @property
    def predecessors(self) -> "tuple[Lane, ...]":
        return tuple(self.network.lanes[i] for i in self.network.links.predecessors[self.id])

    @property
    def default_route(self) -> int:
        """Path of a driver without a plan: this lane, straight on where it can (else the near turn, else the far
        one), and the lane after that; a connecting lane and its end lane; or the lane alone.
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
        """Text that names this maneuver in the language."""
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
        """Start, connecting and end lane: the trajectory of a driver who does this."""
        return self.start_lane, self.connecting_lane, self.end_lane

    @property
    def intersection(self) -> "Intersection":
        return self.network.intersections[self.intersection_id]

    @property
    def conflicting_maneuvers(self) -> "tuple[Maneuver, ...]":
        """Maneuvers from other lanes whose connecting lane's centre line meets this one's: they cross or merge."""
        return tuple(self.network.maneuvers[i] for i in self.network.links.conflicts[self.id])

    @property
    def gives_way_to(self) -> "tuple[Maneuver, ...]":
        """Those that have to pass first: of a roundabout as its signs say, elsewhere all that conflict."""
        first = self.network.links.gives_way
        return self.conflicting_maneuvers if first is None else tuple(self.network.maneuvers[i] for i in first[self.id])

    @property
    def reverse_maneuvers(self) -> "tuple[Maneuver, ...]":
        """Maneuvers that start on the road where this one ends, and end on the road where this one starts."""
        start, end = self.start_lane.road, self.end_lane.road
        here = self.intersection.maneuvers
        return tuple(m for m in here if m.start_lane.road == end and m.end_lane.road == start)


@frozen
class LaneGroup:
    """The lanes of one road that run the same way."""

    network: "Network" = field(repr=False)
    road: str
    forward: bool
    lanes: tuple[Lane, ...]
    """From the kerb to the middle."""

    @property
    def name(self) -> str:
        return f"{self.road} {'forward' if self.forward else 'backward'}"


@frozen
class Road:
    """What lies outside intersections: an arm, or what joins two intersections; both directions together."""

    network: "Network" = field(repr=False)
    name: str
    forward: LaneGroup
    """Of an arm at the border, the lanes that lead into the intersection."""
    backward: LaneGroup
    """Without lanes on a one-way road."""
    middle: tuple[Primitive, ...] = field(repr=False)
    """The line between the two directions, as its forward lanes run; one primitive for each of theirs."""

    @property
    def source(self) -> str:
        """Text that names this road in the language."""
        return f"network.roads[{self.network.roads.index(self)}]"

    @property
    def lanes(self) -> tuple[Lane, ...]:
        return (*self.forward.lanes, *self.backward.lanes)

    @property
    def groups(self) -> tuple[LaneGroup, ...]:
        """The directions in which there are lanes."""
        return tuple(group for group in (self.forward, self.backward) if group.lanes)


@frozen_identity
class Leg:
    """One arm of an intersection."""

    name: str
    """`north`, `east`, `south` or `west`: where it lies, seen from the centre."""
    heading: float
    """Heading of the traffic that leaves by it [rad]."""
    length: float
    """From the stop line to the end of the road, or to the next stop line [m]."""
    incoming_lanes: tuple[Lane, ...]
    """From the kerb to the middle."""
    outgoing_lanes: tuple[Lane, ...]
    neighbour: int | None
    """Id of the intersection at its other end; None at the border."""
    phase: int
    """0 or 1: lights of one phase are green together."""


@frozen_identity
class Intersection:
    """Where roads meet: the area between the stop lines."""

    network: "Network" = field(repr=False)
    id: int
    """Index in `network.intersections`."""
    name: str
    row: int
    """From 0, counted northwards."""
    col: int
    """From 0, counted eastwards."""
    center: tuple[float, float]
    """[m]"""
    region: int
    """Id of its area in `network.regions`."""
    legs: tuple[Leg, ...] = field(repr=False)
    """Clockwise from the north."""

    @property
    def source(self) -> str:
        """Text that names this intersection in the language."""
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
    """How elements refer to one another, by id; filled while the network is built and fixed from then on."""

    maneuvers: list[tuple[int, ...]] = field(default_factory=list)
    """Per lane."""
    intersection: list[int | None] = field(default_factory=list)
    successors: list[tuple[int, ...]] = field(default_factory=list)
    predecessors: list[tuple[int, ...]] = field(default_factory=list)
    default_route: list[int] = field(default_factory=list)
    conflicts: list[tuple[int, ...]] = field(default_factory=list)
    """Per maneuver."""
    beside: Mapping[int, tuple[int | None, int | None]] | None = None
    """Per lane those to its left and right; None where their numbers say it."""
    gives_way: Sequence[tuple[int, ...]] | None = None
    """Per maneuver those that pass first; None where no sign says it."""


@frozen
class Lines:
    """Polylines, each (n, 2) [m]."""

    kerbs: tuple[Floats, ...]
    middle: tuple[Floats, ...]
    """Between the two directions of a road."""
    between: tuple[Floats, ...]
    """Between lanes of one direction."""


@dataclass(eq=False)
class Network:
    """Roads, and the intersections that they meet in. A maker fills it once; paths and regions are added later, too.

    What a maker has to see to: lanes follow one another with a joint as `PathBook.continues` wants it; a lane keeps its
    width; lanes are numbered from the kerb to the middle; maneuvers of an intersection stand together.
    """

    spec: MapSpec
    """What it was made from: whoever has that can have it made again."""
    left_hand: bool
    paths: PathBook = field(default_factory=PathBook)
    """Centre lines of all lanes, default routes, and what a scenario joins."""
    regions: RegionBook = field(default_factory=RegionBook)
    """Region 0 is the whole drivable road; then those of its elements, and what a scenario asks for."""
    roads: tuple[Road, ...] = ()
    """In the order of their lanes."""
    intersections: tuple[Intersection, ...] = ()
    lanes: tuple[Lane, ...] = ()
    """Lanes of all roads first, connecting lanes last."""
    maneuvers: tuple[Maneuver, ...] = ()
    links: Links = field(default_factory=Links, repr=False)
    connecting_roads: tuple[Road, ...] = ()
    """Roads of connecting lanes, in a file that has them."""
    kerbs: tuple[Floats, ...] = ()
    """Kerb lines that are no lane's border, each (n, 2): round the corners of intersections."""
    drawn: Lines | None = None
    """What to draw of lanes that do not keep their width; None: their borders are drawn."""
    remarks: tuple[str, ...] = ()
    """On what was mended or left out."""
    levels: tuple[str, ...] = ()
    """Remarks on roads that pass over others; all lanes lie in one plane."""
    unread: str = ""
    """What a file states and nothing here reads, kind by kind."""
    bounds: Mapping[int, tuple[Floats, Floats]] = field(default_factory=dict[int, tuple[Floats, Floats]])
    """Left and right border of the lanes of a file, by id: (n, 2) each, as traffic runs. Others keep their width."""
    speed_limits: Mapping[int, float] = field(default_factory=dict[int, float])
    """Of the lanes that have one, by id [m/s]."""
    signs: tuple[RoadSign, ...] = ()
    """Traffic lights and signs of a file."""
    buildings: Floats = field(default_factory=lambda: np.zeros((0, 5)))
    """(n, 5): x, y, heading, length, width of blocks between the arms."""

    @cached_property
    def road_named(self) -> Mapping[str, Road]:
        return {road.name: road for road in (*self.roads, *self.connecting_roads)}

    @cached_property
    def arms(self) -> int:
        """Lights of an intersection are numbered by its arms; so many numbers each has."""
        return max([4, *(len(intersection.legs) for intersection in self.intersections)])
