"""Motion of one entity as legs over time, of its reference point: where it is at any instants.

A leg is a timed polyline, or coasting: on along the lane where that is known, else straight on, at a constant speed.
Between two vertices position and heading run linearly (esmini's mode `segment`). Metres, seconds, radians.
"""

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.interchange.reading.node import Node
from engine.interchange.reading.opendrive import OdrNetwork
from engine.interchange.reading.planview import Pose
from engine.interchange.reading.positions import Placed, RoadPlace
from engine.tables import Floats

STANDING = 0.05
"""Slower than this nobody drives on after a trajectory [m/s]."""
SAME_PLACE = 1e-6
"""Nearer vertices give no direction [m]."""
JUMP = 0.5
"""From one leg to the next, further than this is worth a remark [m]."""


@dataclass(frozen=True)
class Coast:
    """From a place on at a constant speed, from `begin` on."""

    begin: float
    placed: Placed
    speed: float
    road: OdrNetwork | None = None

    def placed_at(self, time: float) -> Placed:
        """Where it is then; on a lane as long as that lasts."""
        way = self.speed * max(time - self.begin, 0.0)
        where = self.placed.on_road
        if way == 0.0:
            return self.placed
        if where is None or self.road is None:
            return Placed(self.placed.pose.moved(way, 0.0), True)
        return self._along(where, way, self.road)

    def _along(self, where: RoadPlace, way: float, network: OdrNetwork) -> Placed:
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
        """(times, 3) poses."""
        if self.speed == 0.0:
            return np.tile(np.array(self.placed.pose, dtype=np.float64), (len(times), 1))
        return np.array([self.placed_at(time).pose for time in times.tolist()], dtype=np.float64).reshape(-1, 3)


@dataclass(frozen=True)
class Path:
    """A timed polyline, from `begin` on; it waits at its first vertex, and coasts beyond its last."""

    begin: float
    times: Floats
    """(vertices,) ascending."""
    poses: Floats
    """(vertices, 3), headings unwrapped."""
    end_speed: float

    @property
    def _coast(self) -> Coast:
        return Coast(float(self.times[-1]), Placed(Pose(*self.poses[-1].tolist()), True), self.end_speed)

    def placed_at(self, time: float) -> Placed:
        return Placed(Pose(*self.at(np.array([time]))[0].tolist()), True)

    def at(self, times: Floats) -> Floats:
        """(times, 3) poses."""
        poses = np.column_stack([np.interp(times, self.times, column) for column in self.poses.T])
        after = times > self.times[-1]
        if self.end_speed and after.any():
            poses[after] = self._coast.at(times[after])
        return poses


@dataclass(frozen=True)
class Track:
    """All legs of one entity, in order, and when it comes and goes."""

    legs: tuple[Coast | Path, ...] = ()
    absent: tuple[tuple[float, float], ...] = ()
    """Times from which (inclusive) and until when (exclusive) it is not there."""

    @property
    def follows(self) -> bool:
        return any(isinstance(leg, Path) for leg in self.legs)

    def with_leg(self, leg: Coast | Path) -> "Track":
        return replace(self, legs=(*self.legs, leg))

    def leaves(self, time: float) -> "Track":
        return replace(self, absent=(*self.absent, (time, math.inf)))

    def enters(self, time: float) -> "Track":
        """From then on it is there again; who was never said to have left was not there before."""
        last = self.absent[-1][0] if self.absent else -math.inf
        return replace(self, absent=(*self.absent[:-1], (last, time)))

    def placed_at(self, time: float) -> Placed | None:
        """Where it is then, or None where nothing says so."""
        begun = bisect.bisect_right(self.legs, time, key=lambda leg: leg.begin)
        return self.legs[begun - 1].placed_at(time) if begun else None

    def poses(self, times: Floats) -> Floats:
        """(times, 3) poses with headings that run on; before its first leg it waits where that begins."""
        leg_of = np.searchsorted([leg.begin for leg in self.legs[1:]], times, "right")
        poses = np.empty((len(times), 3))
        for number, leg in enumerate(self.legs):
            poses[leg_of == number] = leg.at(times[leg_of == number])
        poses[:, 2] = np.unwrap(poses[:, 2])
        return poses

    def there(self, times: Floats) -> np.ndarray:
        """(times,) whether it takes part."""
        there = np.ones(len(times), dtype=bool)
        for start, end in self.absent:
            there &= (times < start) | (times >= end)
        return there

    def jumps(self) -> list[tuple[float, float]]:
        """Times and distances of legs that begin elsewhere than the last one led, while it is there."""
        found, entries = [], {end for _, end in self.absent}
        for before, leg in zip(self.legs, self.legs[1:], strict=False):
            moment = max(leg.begin, float(leg.times[0])) if isinstance(leg, Path) else leg.begin
            here, now = before.placed_at(leg.begin).pose, leg.placed_at(moment).pose
            distance = math.hypot(now.x - here.x, now.y - here.y)
            put_again = leg.begin == 0.0 and isinstance(leg, Coast)
            if distance > JUMP and not put_again and leg.begin not in entries:
                found.append((leg.begin, distance))
        return found


def along_polyline(poses: Floats, given: Sequence[bool], node: Node) -> Floats:
    """Poses whose missing headings are those of the way to the next vertex elsewhere, as esmini has it.

    Given ones are turned by whole turns to be next to the one before.
    """
    ways = np.diff(poses[:, :2], axis=0)
    moving = np.flatnonzero(np.hypot(ways[:, 0], ways[:, 1]) > SAME_PLACE)
    if not len(moving) and not all(given):
        raise node.error("a trajectory at one place has no direction", "write a heading into each vertex")
    headings = poses[:, 2].copy()
    for vertex in np.flatnonzero(~np.asarray(given, dtype=bool)).tolist():
        way = ways[moving[min(int(np.searchsorted(moving, vertex)), len(moving) - 1)]]
        headings[vertex] = math.atan2(way[1], way[0])
    return np.column_stack([poses[:, :2], np.unwrap(headings)])


def final_speed(times: Floats, poses: Floats) -> float:
    """Signed speed over the last segment; 0 for a single vertex or who stands."""
    if len(times) < 2:
        return 0.0
    way = poses[-1, :2] - poses[-2, :2]
    speed = float(way @ [math.cos(poses[-1, 2]), math.sin(poses[-1, 2])]) / float(times[-1] - times[-2])
    return speed if abs(speed) > STANDING else 0.0
