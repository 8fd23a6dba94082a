"""The geometry of one intersection around the origin. All intersections of a network are translated copies of it.

Right-hand traffic is drawn; in left-hand traffic lanes are on the opposite side of the middle (`offset` is negative)
and left and right turns change roles. Stop lines are at the beginning of the corner fillets, so the junction's outline
is the square between the stop lines less four quarter discs (on a T less two, its north side straight along the kerb).
"""

import math
from functools import cached_property

import numpy as np

from engine.frozen import frozen
from engine.maps import RoadSpec
from engine.road.paths import Pose, Primitive, chord_count
from engine.road.specification import half_width, kerb_distance, stop_distance
from engine.tables import Floats
from engine.vocabulary import ManeuverType

CHORD_TOLERANCE = 0.01
"""Largest distance of the chords of region outlines from the true arcs [m]."""
EPSILON = 1e-9


@frozen
class Direction:
    """One of the four arms of a crossing."""

    name: str
    x: int
    """Unit vector away from the centre."""
    y: int
    heading: float
    """Heading of traffic that leaves by this arm [rad]."""
    row: int
    """Step to the neighbouring intersection: rows count northwards, columns eastwards."""
    col: int

    @cached_property
    def opposite(self) -> "Direction":
        return next(other for other in COMPASS if other.x == -self.x and other.y == -self.y)


NORTH = Direction("north", 0, 1, math.pi / 2, 1, 0)
EAST = Direction("east", 1, 0, 0.0, 0, 1)
SOUTH = Direction("south", 0, -1, -math.pi / 2, -1, 0)
WEST = Direction("west", -1, 0, math.pi, 0, -1)
COMPASS = (NORTH, EAST, SOUTH, WEST)


@frozen
class Turn:
    """One way through the junction: from lane to lane, numbered from 1 at the kerb."""

    start: Direction
    start_lane: int
    end: Direction
    end_lane: int
    type: ManeuverType
    primitives: tuple[Primitive, ...]


@frozen
class Junction:
    """Directions and measures of the intersections of a network."""

    spec: RoadSpec

    @cached_property
    def arms(self) -> tuple[Direction, ...]:
        """Return the arms clockwise from the north; a T has no north arm."""
        return COMPASS if self.spec.ways == 4 else (EAST, SOUTH, WEST)

    @property
    def half_width(self) -> float:
        return half_width(self.spec)

    @property
    def kerb(self) -> float:
        """Return the distance from the middle of a road to its kerb [m]."""
        return kerb_distance(self.spec)

    @property
    def corner(self) -> float:
        """Return the distance from the centre to the beginning of the corner fillets [m]."""
        return self.kerb + self.spec.corner_radius

    @property
    def stop(self) -> float:
        return stop_distance(self.spec)

    def offset(self, lane: int) -> float:
        """Return the offset of lane `lane` to the right of the road's middle, for its driver [m]; lane 1 is at the
        kerb.
        """
        offset = self.half_width - (lane - 0.5) * self.spec.lane_width
        return -offset if self.spec.left_hand else offset

    def incoming(self, arm: Direction, lane: int, distance: float) -> Pose:
        """Return the pose on an incoming lane, `distance` from the centre."""
        offset, heading = self.offset(lane), arm.opposite.heading
        return Pose(arm.x * distance - arm.y * offset, arm.y * distance + arm.x * offset, heading)

    def outgoing(self, arm: Direction, lane: int, distance: float) -> Pose:
        """Return the pose on an outgoing lane, `distance` from the centre."""
        offset = self.offset(lane)
        return Pose(arm.x * distance + arm.y * offset, arm.y * distance - arm.x * offset, arm.heading)

    @cached_property
    def turns(self) -> tuple[Turn, ...]:
        """Return all ways through, in the order of arms, lanes, and straight, left, right."""
        return tuple(
            self._turn(start, lane, end, end_lane)
            for start in self.arms
            for lane in range(1, self.spec.lanes + 1)
            for end in sorted(self.arms, key=lambda end: turn_type(start, end))
            if self._is_allowed(start, lane, end)
            for end_lane in self._end_lanes(start, lane, end)
        )

    def _is_allowed(self, start: Direction, lane: int, end: Direction) -> bool:
        """Return True for straight on from every lane, the near turn from the kerb, and the far turn from the middle.

        Without a way straight on (the stem of a T), the kerb's half of the lanes makes the near turn, the middle's half
        the far turn, and a middle lane may do both.
        """
        kind = turn_type(start, end)
        if kind in (ManeuverType.STRAIGHT, ManeuverType.U_TURN):
            return kind is ManeuverType.STRAIGHT
        is_near = kind is self.near_turn
        if start.opposite in self.arms:
            return lane == (1 if is_near else self.spec.lanes)
        return self._is_in_half(lane, near_kerb=is_near)

    def _end_lanes(self, start: Direction, lane: int, end: Direction) -> tuple[int, ...]:
        """Return the lanes in which a way may end. A turn keeps its lane's number, so that parallel turns stay side by
        side.

        Into a road without a straight way to it (the stem of a T), a turn may take any lane of its own half.
        """
        if end.opposite in self.arms or lane not in (1, self.spec.lanes):
            return (lane,)
        is_near = turn_type(start, end) is self.near_turn
        lanes = range(1, self.spec.lanes + 1)
        half = [other for other in lanes if self._is_in_half(other, near_kerb=is_near)]
        return tuple(sorted(half, key=lambda other: abs(other - lane)))

    def _is_in_half(self, lane: int, *, near_kerb: bool) -> bool:
        """Return True if a lane is in the kerb's half of its road, or in the middle's; a middle lane is in both."""
        middle = (self.spec.lanes + 1) / 2
        return lane <= middle if near_kerb else lane >= middle

    @property
    def near_turn(self) -> ManeuverType:
        """Return the turn that crosses no oncoming lane."""
        return ManeuverType.LEFT_TURN if self.spec.left_hand else ManeuverType.RIGHT_TURN

    def _turn(self, start: Direction, lane: int, end: Direction, end_lane: int) -> Turn:
        first, last = self.incoming(start, lane, self.stop), self.outgoing(end, end_lane, self.stop)
        return Turn(start, lane, end, end_lane, turn_type(start, end), connect(first, last))

    @cached_property
    def outline(self) -> Floats:
        """Return (n, 2) ring of the junction, anticlockwise, chords within `CHORD_TOLERANCE` of the fillets."""
        ring = np.vstack([self._corner(arm, _left_neighbour(arm)) for arm in reversed(COMPASS)])
        keep = np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > EPSILON
        return ring[keep]

    @cached_property
    def corner_kerbs(self) -> tuple[Floats, ...]:
        """Return (n, 2) kerb lines of the junction: its fillets, and the straight line opposite a T's stem."""
        pairs = [(arm, _left_neighbour(arm)) for arm in self.arms]
        fillets = tuple(self._corner(right, left) for right, left in pairs if left in self.arms)
        if self.spec.ways == 4:
            return fillets
        return (*fillets, np.array([(self.stop, self.kerb), (-self.stop, self.kerb)]))

    @cached_property
    def corners(self) -> tuple[tuple[Direction, Direction], ...]:
        """Return the arms before and after each side of the junction, anticlockwise; opposite ones beside a T."""
        pairs = [(arm, _left_neighbour(arm)) for arm in self.arms]
        return tuple((right, left if left in self.arms else right.opposite) for right, left in pairs)

    def corner_centre(self, right: Direction, left: Direction) -> Floats:
        """Return the centre of the fillet between neighbouring arms."""
        return np.array([right.x + left.x, right.y + left.y]) * self.corner

    def round_corner(self, right: Direction, left: Direction, depth: float) -> Primitive:
        """Return the arc around a corner, `depth` behind its kerb [m], from `right` to `left`."""
        centre, radius = self.corner_centre(right, left), self.spec.corner_radius - depth
        x, y = (centre - radius * np.array([left.x, left.y])).tolist()
        return Primitive(x, y, right.opposite.heading, -1.0 / radius, radius * math.pi / 2)

    def opposite_stem(self, depth: float) -> Primitive:
        """Return the line opposite a T's stem, `depth` behind its kerb [m], from east to west."""
        return Primitive(self.corner, self.kerb + depth, math.pi, 0.0, 2.0 * self.corner)

    def _corner(self, right: Direction, left: Direction) -> Floats:
        """Return (n, 2) kerb between neighbouring arms, from the stop line of `right` to that of `left`."""
        first, last = self._beside(right, left, self.stop), self._beside(left, right, self.stop)
        present = right in self.arms, left in self.arms
        if not all(present):
            return np.array([first] if present[0] else [last])
        fillet = self.fillet(right, left)
        return fillet if self.stop == self.corner else np.vstack([first, fillet, last])

    def _beside(self, arm: Direction, side: Direction, distance: float) -> Floats:
        """Return the point of an arm's kerb on one side of the arm, `distance` from the centre."""
        return np.array([arm.x * distance, arm.y * distance]) + self.kerb * np.array([side.x, side.y])

    def fillet(self, right: Direction, left: Direction) -> Floats:
        """Return (n, 2) kerb of the corner between neighbouring arms, from `right` to `left`."""
        first, last = self._beside(right, left, self.corner), self._beside(left, right, self.corner)
        if self.spec.corner_radius < EPSILON:
            return np.array([first])
        return self._arc(first, last, self.corner_centre(right, left))

    def _arc(self, first: Floats, last: Floats, centre: Floats) -> Floats:
        radius = self.spec.corner_radius
        count = chord_count(Primitive(0.0, 0.0, 0.0, 1.0 / radius, radius * math.pi / 2), CHORD_TOLERANCE)
        angles = np.arange(1, count) * (math.pi / 2 / count)
        # An interpolation of the radii to both ends is exact at the ends, in any quadrant.
        inner = centre + np.outer(np.cos(angles), first - centre) + np.outer(np.sin(angles), last - centre)
        return np.vstack([first, inner, last])


def _left_neighbour(arm: Direction) -> Direction:
    """Return the arm a quarter turn anticlockwise."""
    return next(other for other in COMPASS if (other.x, other.y) == (-arm.y, arm.x))


def turn_type(start: Direction, end: Direction) -> ManeuverType:
    """Return the maneuver of a driver from arm `start` to arm `end`."""
    if end is start:
        return ManeuverType.U_TURN
    if end is start.opposite:
        return ManeuverType.STRAIGHT
    # The driver heads for the opposite arm; an arm to the left of that heading is a left turn.
    ahead = start.opposite
    return ManeuverType.LEFT_TURN if ahead.x * end.y - ahead.y * end.x > 0 else ManeuverType.RIGHT_TURN


def connect(first: Pose, last: Pose) -> tuple[Primitive, ...]:
    """Return line, arc, line between poses at a right angle, with the largest arc; one line if they are aligned."""
    dx, dy = last.x - first.x, last.y - first.y
    cos, sin = round(math.cos(first.heading)), round(math.sin(first.heading))
    ahead, left = dx * cos + dy * sin, dy * cos - dx * sin
    if abs(left) < EPSILON:
        return (Primitive(*first, 0.0, ahead),)
    radius = min(ahead, abs(left))
    side = math.copysign(1.0, left)
    before = Primitive(*first, 0.0, ahead - radius)
    x, y, heading = before.pose(before.length)
    arc = Primitive(x, y, heading, side / radius, radius * math.pi / 2)
    x, y, _ = arc.pose(arc.length)
    after = Primitive(x, y, last.heading, 0.0, abs(left) - radius)
    return tuple(primitive for primitive in (before, arc, after) if primitive.length > EPSILON)
