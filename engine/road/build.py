"""From a specification to a network: roads, then ways through the intersections, then conflicts of maneuvers."""

from collections.abc import Sequence
from dataclasses import replace

from engine.program import RoadSpec
from engine.road.grid import Grid, Site
from engine.road.junction import CHORD_TOLERANCE, Direction, Turn
from engine.road.linking import link
from engine.road.network import Intersection, Lane, LaneRole, Leg, Maneuver, Network
from engine.road.paths import PathBook, Primitive
from engine.road.regions import Shape, strip
from engine.road.specification import check_spec
from engine.tables import ROAD_REGION


def build_network(spec: RoadSpec) -> Network:
    """Lay out all roads and intersections of a grid.

    Raises:
        RoadError: when no road fits the specification.

    """
    check_spec(spec)
    whole = {name: int(getattr(spec, name)) for name in ("ways", "lanes", "rows", "cols")}
    return _Builder(Grid(replace(spec, **whole))).build()


class _Builder:
    """The network while it grows; each step adds one kind of element."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.junction = grid.junction
        self.network = Network(grid.spec)
        self.lanes: list[Lane] = []
        self.maneuvers: list[Maneuver] = []
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
        network.links = link(network, self.junction)
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
        lanes: list[Lane] = []
        for number, line in enumerate(lines, 1):
            name = self.grid.name_at(site, f"{arm.name}.{way}.{number}")
            path = self.network.paths.add([line])
            lanes.append(self.add_lane(name, role, path, self.strip(path), road, number))
        return tuple(lanes)

    def add_lane(self, name: str, role: LaneRole, path: int, shape: Shape, road: str, number: int) -> Lane:
        region = self.network.regions.add(shape)
        lane = Lane(
            self.network, len(self.lanes), name, role, self.grid.spec.lane_width, path, region, road, number
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
            )
            name = f"{self.grid.name_at(site, way)} {turn.type.name.lower()}"
            maneuver = Maneuver(
                self.network, len(self.maneuvers), name, turn.type, start.id, connecting.id, end.id, site.id
            )  # fmt: skip
            self.maneuvers.append(maneuver)


def _turn_strip(turn: Turn, width: float) -> Shape:
    paths = PathBook()
    return strip(paths, paths.add(turn.primitives), width, CHORD_TOLERANCE)
