"""Motion of an entity's reference point: a `Position` of OpenSCENARIO as a pose, and its motion as legs over time.

A leg is a timed polyline, or coasting at a constant speed: along the lane if it is known, else straight. Between two
vertices position and heading are linear (esmini's mode `segment`); in the following mode `follow`, if vertices are far
apart, the acceleration is constant, as in esmini 3.6. Metres, seconds, radians.

Source: ASAM OpenSCENARIO XML 1.2, classes WorldPosition, LanePosition, RoadPosition and their relatives.
"""

import bisect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from engine.opendrive.curves import Pose
from engine.opendrive.roads import OdrNetwork
from engine.tables import Floats
from engine.xml import Node

# -- positions ---------------------------------------------------------------------------------------------------------


class RoadPosition(NamedTuple):
    """A place on a road: on a lane with an offset to the left of its middle, or left of the reference line."""

    road: str
    lane: int | None
    s: float
    offset: float


@dataclass(frozen=True)
class Placed:
    """A pose, with the place on a road if known."""

    pose: Pose
    """Pose with the given heading, or else the heading of the place."""
    given: bool
    """True if the file has a heading."""
    on_road: RoadPosition | None = None


@dataclass(frozen=True)
class Surroundings:
    """Objects to which positions may refer."""

    road: OdrNetwork | None
    others: Callable[[str, Node], Placed]
    """(entity, node) -> place of an entity at that time; the node is that of the reference."""


def place(position: Node, around: Surroundings) -> Placed:
    """Return the place of a `Position`.

    Raises:
        InterchangeError: of a kind that is not read, off the network, or relative to an unknown place.
    """
    known = position.every(*KINDS)  # other elements next to it are not read, but noted
    node = known[0] if len(known) == 1 else position.only()
    if node.tag not in KINDS:
        raise node.error(f"<{node.tag}> is not read here", f"write one of {', '.join(KINDS)}")
    return KINDS[node.tag](node, around)


def _world(node: Node, _: Surroundings) -> Placed:
    given = "h" in node.attributes
    return Placed(Pose(node.number("x"), node.number("y"), node.number("h", 0.0, *ANGLES)), given)


def _lane(node: Node, around: Surroundings) -> Placed:
    lane = RoadPosition(node.text("roadId"), node.integer("laneId"), node.number("s"), _offset(node, "offset", 0.0))
    return _on_road(lane, node, around)


def _road(node: Node, around: Surroundings) -> Placed:
    return _on_road(RoadPosition(node.text("roadId"), None, node.number("s"), _offset(node, "t")), node, around)


def _on_road(where: RoadPosition, node: Node, around: Surroundings) -> Placed:
    if around.road is None:
        raise node.error(
            f"<{node.tag}> needs the road, and the file names none that could be read",
            "name the .xodr in <RoadNetwork><LogicFile filepath=…/>",
        )
    return _oriented(around.road.pose(*where, place=node.place), node, where)


def _relative_object(node: Node, around: Surroundings) -> Placed:
    other = around.others(node.text("entityRef"), node).pose
    return _oriented(other.moved(_offset(node, "dx"), _offset(node, "dy")), node)


def _relative_world(node: Node, around: Surroundings) -> Placed:
    other = around.others(node.text("entityRef"), node).pose
    return _oriented(Pose(other.x + _offset(node, "dx"), other.y + _offset(node, "dy"), other.heading), node)


def _relative_lane(node: Node, around: Surroundings) -> Placed:
    where, lane = _other_on_road(node, around), node.integer("dLane")
    if where.lane is None:
        raise node.error("the other's lane is not known", "write a LanePosition")
    ds = _offset(node, "ds" if "ds" in node.attributes else "dsLane")
    moved = RoadPosition(where.road, _counted(where.lane, lane), where.s + ds, _offset(node, "offset", 0.0))
    return _on_road(moved, node, around)


def _relative_road(node: Node, around: Surroundings) -> Placed:
    where = _other_on_road(node, around)
    if where.lane is not None:
        row = around.road.road(where.road, node.place) if around.road else None
        where = where._replace(lane=None, offset=where.offset + (row.center(where.lane, where.s) if row else 0.0))
    moved = where._replace(s=where.s + _offset(node, "ds"), offset=where.offset + _offset(node, "dt"))
    return _on_road(moved, node, around)


def _other_on_road(node: Node, around: Surroundings) -> RoadPosition:
    name = node.text("entityRef")
    where = around.others(name, node).on_road
    if where is None:
        raise node.error(
            f"where on the road `{name[:40]}` is then is not known here",
            "write a LanePosition or a WorldPosition; relative ones are read where the other stands where it was put",
        )
    return where


def _counted(lane: int, change: int) -> int:
    """Return the lane `change` to the left of a lane; lane 0 cannot be driven on."""
    target = lane + change
    return target if (target > 0) == (lane > 0) and target else target + (1 if change > 0 else -1)


def _oriented(pose: Pose, node: Node, where: RoadPosition | None = None) -> Placed:
    """Return the pose with the element's `Orientation`: relative to the place's own heading, or absolute."""
    orientation = node.find("Orientation")
    if orientation is None or "h" not in orientation.attributes:
        return Placed(pose, False, where)
    heading = orientation.number("h", None, *ANGLES)
    if orientation.text("type", "absolute") == "relative":
        heading += pose.heading
    return Placed(pose._replace(heading=heading), True, where)


def _offset(node: Node, name: str, default: float | None = None) -> float:
    return node.number(name, default, -FARTHEST, FARTHEST)


ANGLES = (-1e4, 1e4)
FARTHEST = 1e5
"""Maximum distance from a road or from an entity [m]."""
KINDS: Mapping[str, Callable[[Node, Surroundings], Placed]] = MappingProxyType(
    {
        "WorldPosition": _world,
        "LanePosition": _lane,
        "RoadPosition": _road,
        "RelativeObjectPosition": _relative_object,
        "RelativeWorldPosition": _relative_world,
        "RelativeLanePosition": _relative_lane,
        "RelativeRoadPosition": _relative_road,
    }
)

# -- tracks ------------------------------------------------------------------------------------------------------------

COARSE = 0.2
"""Vertices further apart than this [s] get samples in between, and their mode matters."""
STANDING = 0.05
"""Speed below which an entity stands after its trajectory [m/s]."""
SAME_PLACE = 1e-6
"""Nearer vertices give no direction [m]."""
JUMP = 0.5
"""Distance between two legs from which on a remark names it [m]."""


@dataclass(frozen=True)
class Coast:
    """Motion from a place at a constant speed, from `begin` on."""

    begin: float
    placed: Placed
    speed: float
    road: OdrNetwork | None = None

    def placed_at(self, time: float) -> Placed:
        """Return the place at a time; along the lane to its end."""
        way = self.speed * max(time - self.begin, 0.0)
        where = self.placed.on_road
        if way == 0.0:
            return self.placed
        if where is None or self.road is None:
            return Placed(self.placed.pose.moved(way, 0.0), True)
        return self._along(where, way, self.road)

    def _along(self, where: RoadPosition, way: float, network: OdrNetwork) -> Placed:
        road = network.roads[where.road]
        turn = self.placed.pose.heading - network.pose(*where).heading
        back = math.cos(self.placed.pose.heading - road.reference(where.s).heading) < 0.0
        wanted = where.s - way if back else where.s + way
        s = min(max(wanted, 0.0), road.length)
        lanes = road.section(s).lanes
        if where.lane and where.lane not in lanes:  # the lane ends here: straight on
            return Placed(self.placed.pose.moved(way, 0.0), True)
        pose = network.pose(where.road, where.lane, s, where.offset)
        pose = pose._replace(heading=pose.heading + turn)
        left = abs(wanted - s)
        return Placed(pose.moved(left, 0.0), True, None if left else where._replace(s=s))

    def at(self, times: Floats) -> Floats:
        """Return (times, 3) poses."""
        if self.speed == 0.0:
            return np.tile(np.array(self.placed.pose, dtype=np.float64), (len(times), 1))
        return np.array([self.placed_at(time).pose for time in times.tolist()], dtype=np.float64).reshape(-1, 3)


@dataclass(frozen=True)
class Polyline:
    """A timed polyline, from `begin` on; it waits at its first vertex, and coasts beyond its last."""

    begin: float
    times: Floats
    """(vertices,) ascending."""
    poses: Floats
    """(vertices, 3), headings unwrapped."""
    end_speed: float
    paces: Floats | None = None
    """(vertices, 2) Speed at each vertex and acceleration to the next; None: constant speeds between vertices."""

    @property
    def _coast(self) -> Coast:
        return Coast(float(self.times[-1]), Placed(Pose(*self.poses[-1].tolist()), True), self.end_speed)

    def placed_at(self, time: float) -> Placed:
        return Placed(Pose(*self.at(np.array([time]))[0].tolist()), True)

    def at(self, times: Floats) -> Floats:
        """Return (times, 3) poses."""
        even = times if self.paces is None else self._evened(times, self.paces)
        poses: Floats = np.column_stack([np.interp(even, self.times, self.poses[:, n]) for n in range(3)])
        after = times > self.times[-1]
        if self.end_speed and after.any():
            poses[after] = self._coast.at(times[after])
        return poses

    def _evened(self, times: Floats, paces: Floats) -> Floats:
        """Return the times at which constant speeds between vertices would give the same places."""
        vertex = np.clip(np.searchsorted(self.times, times, "right") - 1, 0, len(self.times) - 2)
        span, (speed, acceleration) = np.diff(self.times)[vertex], paces[vertex].T
        since = np.clip(times - self.times[vertex], 0.0, span)
        until = np.where(acceleration < 0.0, -speed / np.minimum(acceleration, -1e-12), np.inf)
        since = np.minimum(since, until)  # it stops early
        way = np.hypot(*np.diff(self.poses[:, :2], axis=0).T)[vertex]
        part = (speed * since + 0.5 * acceleration * since * since) / np.maximum(way, SAME_PLACE)
        inside = (times >= self.times[0]) & (times <= self.times[-1])
        return np.where(inside, self.times[vertex] + np.clip(part, 0.0, 1.0) * span, times)


@dataclass(frozen=True)
class Track:
    """All legs of one entity, in order, with its absences."""

    legs: tuple[Coast | Polyline, ...] = ()
    absent: tuple[tuple[float, float], ...] = ()
    """Times from which (inclusive) and until which (exclusive) it is absent."""

    @property
    def follows(self) -> bool:
        return any(isinstance(leg, Polyline) for leg in self.legs)

    def with_leg(self, leg: Coast | Polyline) -> "Track":
        return replace(self, legs=(*self.legs, leg))

    def leaves(self, time: float) -> "Track":
        return replace(self, absent=(*self.absent, (time, math.inf)))

    def enters(self, time: float) -> "Track":
        """Return the track with the entity present from then on; without an earlier departure, it was absent until
        then.
        """
        last = self.absent[-1][0] if self.absent else -math.inf
        return replace(self, absent=(*self.absent[:-1], (last, time)))

    def placed_at(self, time: float) -> Placed | None:
        """Return the place at a time, or None if it is unknown."""
        begun = bisect.bisect_right(self.legs, time, key=lambda leg: leg.begin)
        return self.legs[begun - 1].placed_at(time) if begun else None

    def poses(self, times: Floats) -> Floats:
        """Return (times, 3) poses with continuous headings; before its first leg it waits at that leg's beginning."""
        leg_of = np.searchsorted([leg.begin for leg in self.legs[1:]], times, "right")
        poses = np.empty((len(times), 3))
        for number, leg in enumerate(self.legs):
            poses[leg_of == number] = leg.at(times[leg_of == number])
        poses[:, 2] = np.unwrap(poses[:, 2])
        return poses

    def there(self, times: Floats) -> np.ndarray:
        """Return (times,) True while it is present."""
        there = np.ones(len(times), dtype=bool)
        for start, end in self.absent:
            there &= (times < start) | (times >= end)
        return there

    def jumps(self) -> list[tuple[float, float]]:
        """Return times and distances of legs that do not begin at the end of the leg before, while it is present."""
        found: list[tuple[float, float]] = []
        entries = {end for _, end in self.absent}
        for before, leg in zip(self.legs, self.legs[1:], strict=False):
            moment = max(leg.begin, float(leg.times[0])) if isinstance(leg, Polyline) else leg.begin
            here, now = before.placed_at(leg.begin).pose, leg.placed_at(moment).pose
            distance = math.hypot(now.x - here.x, now.y - here.y)
            put_again = leg.begin == 0.0 and isinstance(leg, Coast)
            if distance > JUMP and not put_again and leg.begin not in entries:
                found.append((leg.begin, distance))
        return found
