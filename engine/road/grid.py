"""The maker of grids: places and names of intersections and roads. Then their network: roads, ways through the
intersections, conflicts of maneuvers.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from engine.frozen import frozen
from engine.maps import RoadSpec
from engine.road.junction import CHORD_TOLERANCE, EPSILON, Direction, Junction, Turn
from engine.road.linking import link
from engine.road.network import (
    Arm,
    Intersection,
    Lane,
    LaneGroup,
    LaneRole,
    Maneuver,
    Network,
    Road,
    Surface,
    SurfaceKind,
)
from engine.road.paths import PathBook, Primitive
from engine.road.regions import (
    Shape,
    anticlockwise,
    ring_edges,
    shape_of,
    shape_of_parts,
    strip,
    triangulate,
    with_cores,
)
from engine.road.specification import crossing_depth, street_wall
from engine.road.streets import CLEAR, StreetBuilder, is_beside, lay_street, round_corner
from engine.tables import ROAD_REGION, Floats

# -- the plan ----------------------------------------------------------------------------------------------------------


@frozen
class Site:
    """Place of one intersection: centres are `block` apart, row 0 in the south, column 0 in the west."""

    id: int
    row: int
    col: int
    x: float
    y: float


@frozen
class Grid:
    """The plan of a network: copies of one junction on a grid. The first is at the origin."""

    spec: RoadSpec

    @cached_property
    def junction(self) -> Junction:
        return Junction(self.spec)

    @cached_property
    def sites(self) -> tuple[Site, ...]:
        block, cols = self.spec.block, self.spec.cols
        places = [(row, col) for row in range(self.spec.rows) for col in range(cols)]
        return tuple(Site(row * cols + col, row, col, col * block, row * block) for row, col in places)

    def arms(self) -> Iterator[tuple[Site, Direction]]:
        return ((site, arm) for site in self.sites for arm in self.junction.arms)

    def neighbour(self, site: Site, arm: Direction) -> int | None:
        """Return the intersection at the end of an arm, if it has an arm to meet it; else None."""
        row, col = site.row + arm.row, site.col + arm.col
        if arm.opposite in self.junction.arms and 0 <= row < self.spec.rows and 0 <= col < self.spec.cols:
            return row * self.spec.cols + col
        return None

    def arm_length(self, site: Site, arm: Direction) -> float:
        """Return the length from the stop line to the border or to the neighbour's stop line [m]."""
        if self.neighbour(site, arm) is None:
            return self.spec.approach
        return self.spec.block - 2.0 * self.junction.stop

    def site_name(self, site: Site) -> str:
        return "intersection" if len(self.sites) == 1 else f"r{site.row}c{site.col}"

    def name_at(self, site: Site, name: str) -> str:
        """Return a name that is unique in the network."""
        return name if len(self.sites) == 1 else f"{self.site_name(site)}.{name}"

    def road_name(self, site: Site, arm: Direction) -> str:
        """Return the name of a road, equal for both directions and both ends."""
        neighbour = self.neighbour(site, arm)
        if neighbour is not None and neighbour < site.id:
            return self.name_at(self.sites[neighbour], arm.opposite.name)
        return self.name_at(site, arm.name)

    # -- the whole road as a region

    @cached_property
    def shape(self) -> Shape:
        """Return all junctions and roads as one region. Where they touch, at the stop lines, there is no boundary."""
        kerbs = self.kerbs()
        boundary = [kerbs + (site.x, site.y) * 2 for site in self.sites]
        tile = triangulate(anticlockwise(self.junction.outline))
        tiles = [tile + (site.x, site.y) * 3 for site in self.sites]
        for site, arm in self.arms():
            ring = self.arm_ring(site, arm)
            is_border = self.neighbour(site, arm) is None
            if is_border or (arm.x, arm.y) in ((1, 0), (0, 1)):  # a road between two junctions counts once
                boundary.append(ring_edges(ring)[[0, 1, 2] if is_border else [0, 2]])
                tiles.append(np.array([[*ring[0], *ring[1], *ring[2]], [*ring[0], *ring[2], *ring[3]]]))
        return with_cores(shape_of_parts(np.vstack(boundary), np.vstack(tiles)), self.bands())

    def bands(self) -> list[tuple[float, float, float, float]]:
        """Return rectangles in the road that cover nearly all of it: the west-east roads, and the south-north ones."""
        half, reach = self.junction.half_width, self.junction.stop + self.spec.approach
        last_x, last_y = self.sites[-1].x, self.sites[-1].y
        rows = [(-reach, site.y - half, last_x + reach, site.y + half) for site in self.sites if site.col == 0]
        if self.spec.ways == 4:
            return rows + [
                (site.x - half, -reach, site.x + half, last_y + reach) for site in self.sites if site.row == 0
            ]
        return rows + [(site.x - half, site.y - reach, site.x + half, site.y + half) for site in self.sites]

    @cached_property
    def junction_shape(self) -> Shape:
        """Return the area of a junction around the origin, with the two crossing roads as cores."""
        half, stop = self.junction.half_width, self.junction.stop
        top = stop if self.spec.ways == 4 else half
        return with_cores(shape_of(self.junction.outline), [(-stop, -half, stop, half), (-half, -stop, half, top)])

    @cached_property
    def turn_strips(self) -> tuple[tuple[Shape, ...], ...]:
        """Return the area of each turn through each junction."""
        strips = [_turn_strip(turn, self.spec.lane_width) for turn in self.junction.turns]
        return tuple(tuple(strip.moved(site.x, site.y) for strip in strips) for site in self.sites)

    def kerbs(self) -> Floats:
        """Return the boundary edges of one junction: its outline without the stop lines."""
        outline = ring_edges(self.junction.outline)
        middle = 0.5 * (outline[:, :2] + outline[:, 2:])
        is_stop = np.zeros(len(outline), dtype=bool)
        for arm in self.junction.arms:
            is_stop |= np.hypot(*(middle - self.junction.stop * np.array([arm.x, arm.y])).T) < 1e-9
        return np.vstack([outline[~is_stop], *map(self._beside_arm, self.junction.arms)])

    def _beside_arm(self, arm: Direction) -> Floats:
        """Return the edges of a junction beside the lanes of an arm, where bicycle lanes and shoulders begin."""
        half, kerb, at = self.junction.half_width, self.junction.kerb, self.junction.stop * np.array([arm.x, arm.y])
        if kerb == half:
            return np.zeros((0, 4))
        left = np.array([-arm.y, arm.x])
        return np.array([[*(at - kerb * left), *(at - half * left)], [*(at + half * left), *(at + kerb * left)]])

    # -- buildings at the corners

    def buildings(self) -> Floats:
        """Return (n, 5) x, y, heading, length, width of blocks, one between each two arms that meet at a corner.

        A block extends from a street wall to the next street wall, or to the end of the roads.
        """
        if self.spec.buildings is None:
            return np.zeros((0, 5))
        blocks = [block for site in self.sites for block in self._blocks_at(site)]
        return np.array([(site_x, site_y, 0.0, length, width) for site_x, site_y, length, width in blocks])

    def _blocks_at(self, site: Site) -> Iterator[tuple[float, float, float, float]]:
        """Yield centres and sizes of the blocks at the corners of a site, without those of an earlier site."""
        spec, wall, end = self.spec, street_wall(self.spec), self.junction.stop + self.spec.approach
        arms = self.junction.arms
        for across, along in product((arm for arm in arms if arm.x), (arm for arm in arms if arm.y)):
            beside, behind = self._continues(site, across), self._continues(site, along)
            if (beside and across.x < 0) or (behind and along.y < 0 and spec.ways == 4):
                continue
            far_x = spec.block - wall if beside else end
            far_y = spec.block - wall if behind else end
            if spec.ways == 3:  # the stem ends before the next row, and so do its blocks
                far_y = min(far_y, end)
            x, y = site.x + 0.5 * across.x * (wall + far_x), site.y + 0.5 * along.y * (wall + far_y)
            yield x, y, far_x - wall, far_y - wall

    def _continues(self, site: Site, arm: Direction) -> bool:
        """Return True if there is an intersection in the direction of an arm, joined to it or not."""
        return 0 <= site.row + arm.row < self.spec.rows and 0 <= site.col + arm.col < self.spec.cols

    def arm_ring(self, site: Site, arm: Direction) -> Floats:
        """Return (4, 2) corners of an arm, anticlockwise: right kerb outwards, across the end, left kerb back."""
        near, far = self.junction.stop, self.junction.stop + self.arm_length(site, arm)
        ahead, left = np.array([arm.x, arm.y]), self.junction.half_width * np.array([-arm.y, arm.x])
        corners = np.array([near * ahead - left, far * ahead - left, far * ahead + left, near * ahead + left])
        return corners + np.array([site.x, site.y])


# -- the network -------------------------------------------------------------------------------------------------------


def grid_network(spec: RoadSpec) -> Network:
    """Return all roads and intersections of a valid grid."""
    whole = {name: int(getattr(spec, name)) for name in ("ways", "lanes", "rows", "cols")}
    spec = replace(spec, **whole)
    return _Builder(planned_grid(spec), spec).build()


@lru_cache(maxsize=16)
def planned_grid(spec: RoadSpec) -> Grid:
    """Return the plan of a grid. Its shapes take most of the time of a network, and networks of one plan share them."""
    return Grid(spec)


class _Builder:
    """The network under construction; each step adds one kind of element."""

    def __init__(self, grid: Grid, spec: RoadSpec) -> None:
        self.grid = grid
        self.junction = grid.junction
        self.network = Network(spec, spec.left_hand)
        self.lanes: list[Lane] = []
        self.maneuvers: list[Maneuver] = []
        self.directions: dict[str, list[tuple[Lane, ...]]] = {}
        """Lanes in the direction of a road, and those against it, by the road's name."""
        self.incoming: dict[tuple[int, str], tuple[Lane, ...]] = {}
        """Lanes of an arm, by intersection and compass name, from the kerb to the middle."""
        self.outgoing: dict[tuple[int, str], tuple[Lane, ...]] = {}

    def build(self) -> Network:
        network, grid = self.network, self.grid
        road = network.regions.add(grid.shape)
        assert road == ROAD_REGION
        areas = [network.regions.add(grid.junction_shape.moved(site.x, site.y)) for site in grid.sites]
        for site, arm in grid.arms():
            self.add_road(site, arm)
        network.intersections = tuple(map(self.intersection, grid.sites, areas))
        for site, strips in zip(grid.sites, grid.turn_strips, strict=True):
            self.add_turns(site, strips)
        network.lanes, network.maneuvers = tuple(self.lanes), tuple(self.maneuvers)
        network.roads = self.roads()
        network.links = link(network, self.junction)
        network.kerbs = tuple(
            kerb + np.array([site.x, site.y]) for site in grid.sites for kerb in grid.junction.corner_kerbs
        )
        network.buildings = grid.buildings()
        lay_street(network, self.surfaces)
        return network

    # -- strips beside the lanes, corners and crossings

    def surfaces(self, network: Network) -> tuple[Surface, ...]:
        """Return all surfaces: beside the lanes of all roads, at the corners, and the crossings over the arms."""
        street = StreetBuilder(network)
        for road in network.roads:
            for group in road.groups:
                lane, depth = group.lanes[0], crossing_depth(street.spec)
                at_start, at_end = bool(lane.predecessors), bool(lane.maneuvers)
                clear = [(0.0, CLEAR)] * at_start + [(lane.length - CLEAR, lane.length)] * at_end
                street.beside(lane, clear, (depth * at_start, depth * at_end))
        for site, place in zip(self.grid.sites, network.intersections, strict=True):
            self.add_corners(street, site)
            if street.spec.crossings:
                for number, leg in enumerate(place.legs):
                    self.add_crossing(street, site, number, leg)
        return street.finish()

    def add_corners(self, street: StreetBuilder, site: Site) -> None:
        """Add kerbs and sidewalks around an intersection, along its traffic."""
        junction, width, name = self.junction, street.spec.sidewalk, self.grid.site_name(site)
        at = np.array([site.x, site.y])
        for right, left in junction.corners:
            corner = self.grid.name_at(site, f"{right.name}-{left.name}")
            if left is right.opposite:
                fillet, centre = None, at
                lines = [junction.opposite_stem(0.5 * depth) for depth in (0.0, width or 0.0)]
            elif self.grid.spec.corner_radius > EPSILON:
                fillet, centre = junction.fillet(right, left) + at, at + junction.corner_centre(right, left)
                lines = [junction.round_corner(right, left, 0.5 * depth) for depth in (0.0, width or 0.0)]
            else:
                continue
            kerb, walk = ([line.moved(site.x, site.y)] for line in lines)
            if self.network.left_hand:
                kerb, walk = ([line.turned() for line in each] for each in (kerb, walk))
            if width is not None:
                shape = None if fillet is None else round_corner(fillet, centre, width)
                kind, at_corner = SurfaceKind.SIDEWALK, f"{corner}.sidewalk"
                street.add(kind, at_corner, walk, width, name, shape=shape, intersection=site.id)
            street.add_curb(corner, kerb, name, at=site.id)

    def add_crossing(self, street: StreetBuilder, site: Site, number: int, leg: Arm) -> None:
        """Add the crossing over an arm, behind the stop line."""
        arm, junction = self.junction.arms[number], self.junction
        near = junction.corner
        middle = Primitive(arm.x * near, arm.y * near, arm.heading, 0.0, street.spec.crossing_width)
        ends = [
            next(each for each in street.surfaces if each.kind is SurfaceKind.SIDEWALK and is_beside(each, lanes[0]))
            for lanes in (leg.outgoing_lanes, leg.incoming_lanes)
        ]
        if self.network.left_hand:
            ends.reverse()
        name = self.grid.name_at(site, f"{arm.name}.crossing")
        reach, sides = (junction.kerb, junction.kerb), (ends[0].id, ends[1].id)
        at = self.grid.site_name(site)
        street.cross(name, [middle.moved(site.x, site.y)], reach, at, sides, intersection=site.id, arm=number)

    def add_road(self, site: Site, arm: Direction) -> None:
        """Add the incoming lanes of an arm, and its outgoing lanes unless they are incoming at the neighbour."""
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
            Arm(
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
        """Add connecting lanes and maneuvers of one intersection, in the order of `Junction.turns`."""
        for turn, shape in zip(self.junction.turns, strips, strict=True):
            start = self.incoming[site.id, turn.start.name][turn.start_lane - 1]
            end = self.outgoing[site.id, turn.end.name][turn.end_lane - 1]
            path = self.network.paths.add([primitive.moved(site.x, site.y) for primitive in turn.primitives])
            way = f"{turn.start.name}.{turn.start_lane}-{turn.end.name}.{turn.end_lane}"
            connecting = self.add_lane(
                self.grid.name_at(site, way),
                LaneRole.CONNECTING,
                path,
                shape,
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
    """Return the line along a straight lane's border towards the middle of the road."""
    start, shift = lane.network.paths.pose(lane.path, 0.0), 0.5 * lane.width
    to_left = -shift if lane.network.left_hand else shift
    cos, sin = round(math.cos(start.heading)), round(math.sin(start.heading))  # exact: roads run along the axes
    return Primitive(start.x - to_left * sin, start.y + to_left * cos, start.heading, 0.0, lane.length)


def _turn_strip(turn: Turn, width: float) -> Shape:
    paths = PathBook()
    return strip(paths, paths.add(turn.primitives), width, CHORD_TOLERANCE)
