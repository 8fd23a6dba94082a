"""The maker of grids: roads, then ways through the intersections, then conflicts of maneuvers."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from engine.maps import RoadSpec
from engine.road.grid import Grid, Site
from engine.road.junction import CHORD_TOLERANCE, Direction, Turn
from engine.road.linking import link
from engine.road.network import Intersection, Lane, LaneGroup, LaneRole, Leg, Maneuver, Network, Road
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape, strip
from engine.tables import ROAD_REGION


def grid_network(spec: RoadSpec) -> Network:
    """All roads and intersections of a grid that is one."""
    whole = {name: int(getattr(spec, name)) for name in ("ways", "lanes", "rows", "cols")}
    return _Builder(Grid(replace(spec, **whole))).build()


class _Builder:
    """The network while it grows; each step adds one kind of element."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.junction = grid.junction
        self.network = Network(grid.spec, grid.spec.left_hand)
        self.lanes: list[Lane] = []
        self.maneuvers: list[Maneuver] = []
        self.directions: dict[str, list[tuple[Lane, ...]]] = {}
        """By the name of a road, the lanes that run as it does, and the others."""
        self.incoming: dict[tuple[int, str], tuple[Lane, ...]] = {}
        """Lanes of an arm, by intersection and compass name, from the kerb to the middle."""
        self.outgoing: dict[tuple[int, str], tuple[Lane, ...]] = {}

    def build(self) -> Network:
        network, grid = self.network, self.grid
        road = network.regions.add(grid.shape())
        assert road == ROAD_REGION
        area = grid.junction_shape()
        areas = [network.regions.add(area.moved(site.x, site.y)) for site in grid.sites]
        for site, arm in grid.arms():
            self.add_road(site, arm)
        network.intersections = tuple(map(self.intersection, grid.sites, areas))
        strips = [_turn_strip(turn, grid.spec.lane_width) for turn in self.junction.turns]
        for site in grid.sites:
            self.add_turns(site, strips)
        network.lanes, network.maneuvers = tuple(self.lanes), tuple(self.maneuvers)
        network.roads = self.roads()
        network.links = link(network, self.junction)
        network.kerbs = tuple(
            kerb + np.array([site.x, site.y]) for site in grid.sites for kerb in grid.junction.corner_kerbs
        )
        network.buildings = grid.buildings()
        return network

    def add_road(self, site: Site, arm: Direction) -> None:
        """Incoming lanes of an arm; and its outgoing ones, unless they are incoming at the neighbour."""
        neighbour, length = self.grid.neighbour(site, arm), self.grid.arm_length(site, arm)
        numbers = range(1, self.grid.spec.lanes + 1)
        starts = [self.junction.incoming(arm, number, self.junction.stop + length) for number in numbers]
        role = LaneRole.INCOMING if neighbour is None else LaneRole.LINK
        lines = [Primitive(*start, 0.0, length).moved(site.x, site.y) for start in starts]
        lanes = self.add_lanes(site, arm, role, lines)
        self.incoming[site.id, arm.name] = lanes
        if neighbour is not None:
            self.outgoing[neighbour, arm.opposite.name] = lanes
            return
        starts = [self.junction.outgoing(arm, number, self.junction.stop) for number in numbers]
        lines = [Primitive(*start, 0.0, length).moved(site.x, site.y) for start in starts]
        self.outgoing[site.id, arm.name] = self.add_lanes(site, arm, LaneRole.OUTGOING, lines)

    def add_lanes(self, site: Site, arm: Direction, role: LaneRole, lines: Sequence[Primitive]) -> tuple[Lane, ...]:
        way = "out" if role is LaneRole.OUTGOING else "in"
        road = self.grid.road_name(site, arm)
        forward = road not in self.directions
        lanes: list[Lane] = []
        for number, line in enumerate(lines, 1):
            name = self.grid.name_at(site, f"{arm.name}.{way}.{number}")
            path = self.network.paths.add([line])
            lanes.append(self.add_lane(name, role, path, self.strip(path), road, number, forward))
        self.directions.setdefault(road, []).append(tuple(lanes))
        return tuple(lanes)

    def roads(self) -> tuple[Road, ...]:
        return tuple(self.road(name, *directions) for name, directions in self.directions.items())

    def road(self, name: str, forward: tuple[Lane, ...], backward: tuple[Lane, ...]) -> Road:
        network = self.network
        groups = LaneGroup(network, name, True, forward), LaneGroup(network, name, False, backward)
        return Road(network, name, *groups, (_beside(forward[-1]),))

    def add_lane(
        self, name: str, role: LaneRole, path: int, shape: Shape, road: str, number: int, forward: bool
    ) -> Lane:
        region = self.network.regions.add(shape)
        lane = Lane(
            self.network, len(self.lanes), name, role, self.grid.spec.lane_width, path, region, road, number, forward
        )  # fmt: skip
        self.lanes.append(lane)
        return lane

    def strip(self, path: int) -> Shape:
        return strip(self.network.paths, path, self.grid.spec.lane_width, CHORD_TOLERANCE)

    def intersection(self, site: Site, area: int) -> Intersection:
        legs = tuple(
            Leg(
                name=arm.name,
                heading=arm.heading,
                length=self.grid.arm_length(site, arm),
                incoming_lanes=self.incoming[site.id, arm.name],
                outgoing_lanes=self.outgoing[site.id, arm.name],
                neighbour=self.grid.neighbour(site, arm),
                phase=0 if arm.x == 0 else 1,
            )
            for arm in self.junction.arms
        )
        return Intersection(
            self.network, site.id, self.grid.site_name(site), site.row, site.col, (site.x, site.y), area, legs
        )  # fmt: skip

    def add_turns(self, site: Site, strips: Sequence[Shape]) -> None:
        """Connecting lanes and maneuvers of one intersection, in the order of `Junction.turns`."""
        for turn, shape in zip(self.junction.turns, strips, strict=True):
            start = self.incoming[site.id, turn.start.name][turn.start_lane - 1]
            end = self.outgoing[site.id, turn.end.name][turn.end_lane - 1]
            path = self.network.paths.add([primitive.moved(site.x, site.y) for primitive in turn.primitives])
            way = f"{turn.start.name}.{turn.start_lane}-{turn.end.name}.{turn.end_lane}"
            connecting = self.add_lane(
                self.grid.name_at(site, way),
                LaneRole.CONNECTING,
                path,
                shape.moved(site.x, site.y),
                self.grid.site_name(site),
                turn.start_lane,
                True,
            )
            name = f"{self.grid.name_at(site, way)} {turn.type.name.lower()}"
            maneuver = Maneuver(
                self.network, len(self.maneuvers), name, turn.type, start.id, connecting.id, end.id, site.id
            )  # fmt: skip
            self.maneuvers.append(maneuver)


def _beside(lane: Lane) -> Primitive:
    """The line along a straight lane's border to the middle of the road."""
    start, shift = lane.network.paths.pose(lane.path, 0.0), 0.5 * lane.width
    to_left = -shift if lane.network.left_hand else shift
    cos, sin = round(math.cos(start.heading)), round(math.sin(start.heading))  # exact: roads run along the axes
    return Primitive(start.x - to_left * sin, start.y + to_left * cos, start.heading, 0.0, lane.length)


def _turn_strip(turn: Turn, width: float) -> Shape:
    paths = PathBook()
    return strip(paths, paths.add(turn.primitives), width, CHORD_TOLERANCE)
