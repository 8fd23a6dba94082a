"""The maker of roundabouts: a ring, and arms that lead into it at equal angles, the first in the north.

Each arm meets the ring in its own intersection, from the give-way line of the arm to the tangent points of its kerbs at
the ring, as in map files. Lanes enter by one arc that touches the ring's, and leave by a second arc. All arcs of a
corner have one centre, and those of the ring the origin, so that lanes stay side by side.
"""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from engine.frozen import frozen
from engine.maps import Roundabout
from engine.road.junction import CHORD_TOLERANCE
from engine.road.linking import link_by_ways, maneuver
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
from engine.road.regions import Shape, anticlockwise, ring_edges, shape_of, shape_of_parts, strip, triangulate
from engine.road.specification import (
    LENGTHS,
    MAX_LANES,
    SHORTEST_ROAD,
    RoadError,
    setback,
    wrong_choice,
    wrong_length,
    wrong_street,
    wrong_street_numbers,
)
from engine.road.streets import CLEAR, StreetBuilder, lay_street, stretch
from engine.tables import ROAD_REGION, Floats

ARMS = range(3, 9)
RADII = (8.0, 500.0)
"""Limits of the radius of the ring's outer edge [m]."""
CORNERS = (3.0, 100.0)
"""Limits of the radii of the kerbs between arms and ring [m]."""
ISLAND = 3.0
"""Least radius of the island [m]."""
SAME = 9
"""Decimals to which corners that several parts share are rounded [m]."""


# -- what cannot be built ----------------------------------------------------------------------------------------------


def wrong_roundabout_numbers(spec: Roundabout) -> Iterator[RoadError]:
    """Yield the errors of single numbers that no roundabout allows."""
    yield from wrong_choice("arms", spec.arms, ARMS)
    yield from wrong_choice("lanes", spec.lanes, range(1, MAX_LANES + 1))
    yield from wrong_length("radius", spec.radius, *RADII)
    yield from wrong_length("corner_radius", spec.corner_radius, *CORNERS)
    for argument in ("approach", "lane_width"):
        yield from wrong_length(argument, getattr(spec, argument), *LENGTHS[argument])
    yield from wrong_street_numbers(spec)


def wrong_roundabout(spec: Roundabout) -> Iterator[RoadError]:
    """Yield the errors of numbers that are valid alone but not together."""
    yield from wrong_street(spec, spec.corner_radius)
    if (least := _crossing_end(spec)) > spec.approach:
        yield RoadError(
            f"`approach` is {spec.approach:g} m, shorter than the {least:g} m to the far side of the crossing",
            "approach",
            f"write `approach={math.ceil(least)} m` or more",
        )
    if not _fits(spec, spec.radius):
        least = next((radius for radius in range(*map(int, RADII)) if _fits(spec, radius)), None)
        width = spec.lanes * spec.lane_width + setback(spec)
        yield RoadError(
            f"`radius` is {spec.radius:g} m, too small for a ring of {width:g} m with an island, and {spec.arms} arms "
            f"of {2.0 * width:g} m whose corners are arcs of {spec.corner_radius:g} m",
            "radius",
            "write fewer lanes or arms, or a smaller `corner_radius`"
            if least is None
            else f"write `radius={least} m` or more, or a smaller `corner_radius`",
        )


CROSSING_SETBACK = 6.0
"""Distance from the line of an arm to its crossing [m]: one car may wait at the line; *ours*."""


def _crossing_end(spec: Roundabout) -> float:
    """Return the distance from the line of an arm to the far side of its crossing [m]; 0 without crossings."""
    return CROSSING_SETBACK + spec.crossing_width if spec.crossings else 0.0


def _fits(spec: Roundabout, radius: float) -> bool:
    """Return True if there is an island, and road between neighbouring arms."""
    half = spec.lanes * spec.lane_width + setback(spec)
    if radius - half < ISLAND or 2.0 * spec.corner_radius * (radius - half) < half * half:
        return False  # else the line of an arm would be in the ring
    between = math.tau / spec.arms - 2.0 * math.asin((half + spec.corner_radius) / (radius + spec.corner_radius))
    return between * (radius - half) >= SHORTEST_ROAD


# -- where things lie --------------------------------------------------------------------------------------------------


@frozen
class Plan:
    """Measures, and the lines of lanes and kerbs. An arm is along +x here, and is then rotated to its place."""

    spec: Roundabout

    @property
    def half_width(self) -> float:
        """Return half the width of an arm from kerb to kerb, which is the whole width of the ring [m]."""
        return self.spec.lanes * self.spec.lane_width + setback(self.spec)

    @cached_property
    def line(self) -> float:
        """Return the distance from the centre to the give-way line of an arm [m]."""
        spec = self.spec
        return math.sqrt((spec.radius + spec.corner_radius) ** 2 - (self.half_width + spec.corner_radius) ** 2)

    @cached_property
    def reach(self) -> float:
        """Return half the angle of an arm's intersection along the ring [rad]."""
        return math.atan2(self.half_width + self.spec.corner_radius, self.line)

    @property
    def side(self) -> float:
        """Return 1 if traffic runs anticlockwise around the ring (right-hand traffic), else -1."""
        return -1.0 if self.spec.left_hand else 1.0

    def angle(self, arm: int) -> float:
        """Return the direction of an arm from the centre [rad]; arms are clockwise from the north."""
        return _within(0.5 * math.pi - arm * math.tau / self.spec.arms)

    def after(self, arm: int) -> int:
        """Return the next arm for traffic in the ring."""
        return (arm - int(self.side)) % self.spec.arms

    def out(self, number: int) -> float:
        """Return the distance from the kerb to the middle of a lane [m]."""
        return setback(self.spec) + (number - 0.5) * self.spec.lane_width

    # lines; `depth` is their distance from the kerb [m]

    def arm_line(self, arm: int, depth: float, *, inward: bool) -> Primitive:
        """Return the line along an arm, towards the centre or away from it."""
        beside, length = self.side * (self.half_width - depth), self.spec.approach
        if inward:
            return self._turned(Primitive(self.line + length, beside, math.pi, 0.0, length), arm)
        return self._turned(Primitive(self.line, -beside, 0.0, 0.0, length), arm)

    def entry(self, arm: int, depth: float) -> Primitive:
        """Return the arc from an arm into the ring."""
        return self._corner(arm, self.line, self.side * (self.half_width - depth), math.pi, depth)

    def exit(self, arm: int, depth: float) -> Primitive:
        """Return the arc from the ring into an arm."""
        x, y, heading = self._round(-self.reach, depth)
        return self._corner(arm, x, y, heading, depth)

    def passing(self, arm: int, depth: float) -> Primitive:
        """Return the arc along the ring past an arm."""
        return self._turned(self._arc(-self.reach, 2.0 * self.reach, depth), arm)

    def between(self, arm: int, depth: float) -> Primitive:
        """Return the arc along the ring from an arm to the next arm."""
        return self._turned(self._arc(self.reach, math.tau / self.spec.arms - 2.0 * self.reach, depth), arm)

    def _corner(self, arm: int, x: float, y: float, heading: float, depth: float) -> Primitive:
        radius = self.spec.corner_radius + depth
        arc = Primitive(x, y, heading, -self.side / radius, radius * (0.5 * math.pi - self.reach))
        return self._turned(arc, arm)

    def _arc(self, start: float, angle: float, depth: float) -> Primitive:
        radius = self.spec.radius - depth
        return Primitive(*self._round(start, depth), self.side / radius, radius * angle)

    def _round(self, angle: float, depth: float) -> tuple[float, float, float]:
        """Return the pose in the ring at an angle beyond the arm [rad]."""
        radius, at = self.spec.radius - depth, self.side * angle
        return radius * math.cos(at), radius * math.sin(at), at + self.side * 0.5 * math.pi

    def _turned(self, line: Primitive, arm: int) -> Primitive:
        angle = self.angle(arm)
        cos, sin = math.cos(angle), math.sin(angle)
        x, y = line.x * cos - line.y * sin, line.x * sin + line.y * cos
        return line._replace(x=x, y=y, heading=_within(line.heading + angle))

    # surfaces

    def mouth(self, arm: int) -> Floats:
        """Return (n, 2) outline of the intersection of an arm."""
        entry, leave = _points(self.entry(arm, 0.0)), _points(self.exit(arm, 0.0))
        inner = _points(self.passing(arm, self.half_width))
        return np.vstack([entry, inner[::-1], leave])

    def kerbs(self, arm: int) -> tuple[Floats, ...]:
        """Return the kerbs of an intersection: both corners, and the island's."""
        lines = self.entry(arm, 0.0), self.exit(arm, 0.0), self.passing(arm, self.half_width)
        return tuple(map(_points, lines))

    def surface(self) -> Shape:
        """Return the area between the kerbs. Where parts touch there is no boundary."""
        edges: list[Floats] = []
        tiles: list[Floats] = []
        beside = setback(self.spec)
        middle, width = 0.5 * (self.half_width + beside), self.half_width - beside
        for arm in range(self.spec.arms):
            paths = PathBook()
            ring = strip(paths, paths.add([self.between(arm, middle)]), width, CHORD_TOLERANCE)
            tiles += [triangulate(anticlockwise(self.mouth(arm))), ring.triangles, self._arm_tiles(arm)]
            across = len(ring.edges) // 2  # the ring's outline runs along one border and back along the second
            edges += [np.delete(ring.edges, [across - 1, len(ring.edges) - 1], axis=0), self._arm_edges(arm)]
            edges += [np.hstack([line[:-1], line[1:]]) for line in (*self.kerbs(arm), *self._beside_lanes(arm))]
        return shape_of_parts(np.round(np.vstack(edges), SAME), np.vstack(tiles))

    def _beside_lanes(self, arm: int) -> list[Floats]:
        """Return the borders of an intersection beside the lanes that meet it: from the kerbs to the outer lanes."""
        if (beside := setback(self.spec)) == 0.0:
            return []
        kerb, border = ([_points(line(arm, depth)) for line in (self.entry, self.exit)] for depth in (0.0, beside))
        return [np.array([one[at], other[at]]) for one, other in zip(kerb, border, strict=True) for at in (0, -1)]

    def _arm_corners(self, arm: int) -> Floats:
        """Return (4, 2): the end of the outer lane at the line, out along it, across the end, and back."""
        lines = [self.arm_line(arm, setback(self.spec), inward=way) for way in (True, False)]
        (far, near), (start, end) = (_points(line) for line in lines)
        return np.array([near, far, end, start])

    def _arm_edges(self, arm: int) -> Floats:
        return ring_edges(self._arm_corners(arm))[:3]

    def _arm_tiles(self, arm: int) -> Floats:
        corners = self._arm_corners(arm)
        return np.array([corners[[0, 1, 2]].ravel(), corners[[0, 2, 3]].ravel()])


def _points(line: Primitive) -> Floats:
    paths = PathBook()
    return paths.points(paths.add([line]), CHORD_TOLERANCE)


# -- the network -------------------------------------------------------------------------------------------------------


def roundabout(spec: Roundabout) -> Network:
    """Return the network of a valid specification."""
    return _Builder(spec).build()


class _Builder:
    """The network under construction; each step adds one kind of element."""

    def __init__(self, spec: Roundabout) -> None:
        self.plan = Plan(spec)
        self.network = Network(spec, spec.left_hand)
        self.width = spec.lane_width
        self.arms, self.numbers = range(int(spec.arms)), range(1, int(spec.lanes) + 1)
        self.lanes: list[Lane] = []

    def build(self) -> Network:
        network, plan = self.network, self.plan
        assert network.regions.add(plan.surface()) == ROAD_REGION
        areas = [network.regions.add(shape_of(plan.mouth(arm))) for arm in self.arms]
        inward, outward = zip(*(self.arm(arm) for arm in self.arms), strict=True)
        ring = [self.ring(arm) for arm in self.arms]
        network.roads = (
            *(self.road(f"arm{arm + 1}", inward[arm], outward[arm], self.middle(arm)) for arm in self.arms),
            *(self.road(f"ring{arm + 1}", ring[arm], (), plan.between(arm, plan.half_width)) for arm in self.arms),
        )
        before = {plan.after(arm): ring[arm] for arm in self.arms}
        ways = [
            (arm, start, self.connecting(arm, name, line, number), end)
            for arm in self.arms
            for starts, name, lines, ends in (
                (inward[arm], "entry", plan.entry, ring[arm]),
                (before[arm], "ring", plan.passing, ring[arm]),
                (before[arm], "exit", plan.exit, outward[arm]),
            )
            for number, start, end in zip(self.numbers, starts, ends, strict=True)
            for line in [lines(arm, plan.out(number))]
        ]
        network.lanes = tuple(self.lanes)
        ways.sort(key=lambda way: (way[0], way[1].role is not LaneRole.INCOMING, way[1].number))
        network.maneuvers = tuple(maneuver(index, *way) for index, way in enumerate(ways))
        network.intersections = tuple(
            self.intersection(arm, areas[arm], inward[arm], outward[arm], before[arm], ring[arm]) for arm in self.arms
        )
        network.kerbs = tuple(kerb for arm in self.arms for kerb in plan.kerbs(arm))
        link_by_ways(network, {each.connecting: (each.end,) for each in network.maneuvers})
        network.links.gives_way = [self.gives_way(maneuver) for maneuver in network.maneuvers]
        lay_street(network, self.surfaces)
        return network

    def surfaces(self, network: Network) -> tuple[Surface, ...]:
        """Return all surfaces: beside the arms and the ring, around the corners, and the crossings over the arms."""
        street, plan = StreetBuilder(network), self.plan
        spec = plan.spec
        by_road: dict[str, list[Surface]] = {}
        first, last = CROSSING_SETBACK - CLEAR, _crossing_end(spec) + CLEAR
        for road in network.roads:
            is_ring = not road.backward.lanes
            for group in road.groups:
                lane = group.lanes[0]
                inward = lane.role is LaneRole.INCOMING
                near = (max(0.0, first), last) if spec.crossings else (0.0, CLEAR)
                clear = (lane.length - near[1], lane.length) if inward else (0.0, near[1])
                street.beside(lane, [clear], parking=not is_ring)
            by_road[road.name] = [each for each in street.surfaces if each.road == road.name]
        for arm in self.arms:
            for name, line in (("entry", plan.entry), ("exit", plan.exit)):
                place = f"{self.name(arm)}.{name}"
                if spec.sidewalk is not None:
                    walk = [line(arm, -0.5 * spec.sidewalk)]
                    kind, at = SurfaceKind.SIDEWALK, self.name(arm)
                    street.add(kind, f"{place}.sidewalk", walk, spec.sidewalk, at, intersection=arm)
                street.add_curb(place, [line(arm, 0.0)], self.name(arm), at=arm)
            if spec.crossings:
                self.add_crossing(street, arm, by_road[f"arm{arm + 1}"])
        return street.finish()

    def add_crossing(self, street: StreetBuilder, arm: int, beside: Sequence[Surface]) -> None:
        """Add the crossing over an arm, at a distance from its line."""
        plan, road = self.plan, f"arm{arm + 1}"
        axis = [plan.arm_line(arm, plan.half_width, inward=False)]
        part = stretch(axis, CROSSING_SETBACK, _crossing_end(plan.spec))
        walks = [each.id for each in beside if each.kind is SurfaceKind.SIDEWALK]
        # The arm's axis leads away from the ring: on its right are the lanes away from the ring, in left-hand traffic
        # those to the ring, which come first.
        ends = (walks[0], walks[1]) if plan.spec.left_hand else (walks[1], walks[0])
        street.cross(f"{road}.crossing", part, (plan.half_width, plan.half_width), road, ends)

    def arm(self, arm: int) -> tuple[tuple[Lane, ...], tuple[Lane, ...]]:
        """Return its lanes to the ring, and away from it."""
        inward, outward = (
            tuple(
                self.lane(
                    f"arm{arm + 1}.{'in' if way else 'out'}.{number}",
                    LaneRole.INCOMING if way else LaneRole.OUTGOING,
                    self.plan.arm_line(arm, self.plan.out(number), inward=way),
                    f"arm{arm + 1}",
                    number,
                    forward=way,
                )
                for number in self.numbers
            )
            for way in (True, False)
        )
        return inward, outward

    def ring(self, arm: int) -> tuple[Lane, ...]:
        """Return the lanes of the ring from an arm to the next arm."""
        road, line = f"ring{arm + 1}", self.plan.between
        return tuple(
            self.lane(f"{road}.{number}", LaneRole.LINK, line(arm, self.plan.out(number)), road, number)
            for number in self.numbers
        )

    def connecting(self, arm: int, name: str, line: Primitive, number: int) -> Lane:
        place = self.name(arm)
        return self.lane(f"{place}.{name}.{number}", LaneRole.CONNECTING, line, place, number)

    def name(self, arm: int) -> str:
        return f"junction{arm + 1}"

    def middle(self, arm: int) -> Primitive:
        return self.plan.arm_line(arm, self.plan.half_width, inward=True)

    def lane(self, name: str, role: LaneRole, line: Primitive, road: str, number: int, *, forward: bool = True) -> Lane:
        network = self.network
        path = network.paths.add([line])
        region = network.regions.add(strip(network.paths, path, self.width, CHORD_TOLERANCE))
        lane = Lane(network, len(self.lanes), name, role, self.width, path, region, road, number, forward)
        self.lanes.append(lane)
        return lane

    def road(self, name: str, forward: Sequence[Lane], backward: Sequence[Lane], middle: Primitive) -> Road:
        ways = ((True, forward), (False, backward))
        there, back = (LaneGroup(self.network, name, way, tuple(lanes)) for way, lanes in ways)
        return Road(self.network, name, there, back, (middle,))

    def intersection(self, arm: int, area: int, *lanes: tuple[Lane, ...]) -> Intersection:
        """Return the intersection of an arm; `lanes`: from the arm, into the arm, from the ring, into the ring."""
        plan, (inward, outward, before, after) = self.plan, lanes
        away, round_it = plan.angle(arm), plan.side * (plan.reach + 0.5 * math.pi)
        coming = next(other for other in self.arms if plan.after(other) == arm)
        legs = [
            Arm(inward[0].road, away, inward[0].length, inward, outward, None, 1),
            Arm(after[0].road, _within(away + round_it), after[0].length, (), after, plan.after(arm), 0),
            Arm(before[0].road, _within(away - round_it), before[0].length, before, (), coming, 0),
        ]
        legs.sort(key=lambda leg: -math.remainder(leg.heading - 0.5 * math.pi - 1e-9, math.tau))
        middle = 0.5 * (plan.line + plan.spec.radius - plan.half_width)
        center = middle * math.cos(away), middle * math.sin(away)
        return Intersection(self.network, arm, self.name(arm), 0, arm, center, area, tuple(legs))

    def gives_way(self, maneuver: Maneuver) -> tuple[int, ...]:
        """Return the maneuvers with priority: the ring's over an entry; in the ring, outer lanes over an exit of an
        inner lane.
        """
        conflicts = maneuver.conflicting_maneuvers
        if maneuver.start_lane.role is LaneRole.INCOMING:
            return tuple(other.id for other in conflicts if other.start_lane.role is LaneRole.LINK)
        if maneuver.end_lane.role is LaneRole.LINK:
            return ()
        on = (other for other in conflicts if other.start_lane.role is other.end_lane.role is LaneRole.LINK)
        return tuple(other.id for other in on)


def _within(angle: float) -> float:
    return math.remainder(angle, math.tau)
