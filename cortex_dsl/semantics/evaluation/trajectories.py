"""Trajectories: lists of connected lanes, joined into one path."""

import math
from itertools import pairwise

from cortex_dsl.semantics.errors.scene import EMPTY_TRAJECTORY, NOT_CONNECTED
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.lanes import chosen
from cortex_dsl.semantics.model.values import Centerline, Quantity, Value
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.source import Span
from engine.frozen import frozen
from engine.road.network import Intersection, Lane, LaneRole, Maneuver


@frozen
class Trajectory:
    lanes: tuple[Lane, ...]
    path: int
    """Id of the joined centre lines."""

    @property
    def length(self) -> float:
        return self.lanes[0].network.paths.length(self.path)

    def entry(self, intersection: Intersection) -> float | None:
        """Arc length at which the trajectory enters an intersection [m]; None if it never does."""
        s = 0.0
        for lane in self.lanes:
            if any(maneuver.intersection is intersection for maneuver in lane.maneuvers):
                return s + lane.length
            s += lane.length
        return None

    def leaving(self, intersection: Intersection) -> float | None:
        """Arc length at which the trajectory leaves an intersection [m]; None if it never does."""
        s = 0.0
        for lane in self.lanes:
            if lane.intersection is intersection and lane.role is LaneRole.CONNECTING:
                return s + lane.length
            s += lane.length
        return None


def trajectory(value: Value, span: Span) -> Trajectory:
    """A list of lanes (or a maneuver, or one lane) as a path.

    Raises:
        Mistake: when it is something else, or has a gap.
    """
    lanes = _lanes(value, span)
    if not lanes:
        raise EMPTY_TRAJECTORY.mistake(span)
    paths = lanes[0].network.paths
    for number, (before, after) in enumerate(pairwise(lanes), 2):
        if not paths.continues(before.path, after.path):
            gap, cure = _gap(before, after)
            raise NOT_CONNECTED.mistake(span, number=number, gap=gap, cure=cure)
    return Trajectory(lanes, paths.join([lane.path for lane in lanes]))


def _gap(before: Lane, after: Lane) -> tuple[str, str]:
    """Return why a lane does not continue in another one, and the cure."""
    if after not in before.successors:
        follows = ", ".join(f"`{lane.name}`" for lane in before.successors) or "no lane"
        return f"`{before.name}` leads to {follows}, not to `{after.name}`", _ONE_MANEUVER
    paths = before.network.paths
    end, start = paths.pose(before.path, before.length), paths.pose(after.path, 0.0)
    turn = abs(math.degrees(math.remainder(end.heading - start.heading, math.tau)))
    way = math.hypot(end.x - start.x, end.y - start.y)
    linked = f"the map links `{before.name}` to `{after.name}`"
    where = f"which begins {way:.2g} m from its end and is turned by {turn:.2g} degrees against it"
    return f"{linked}, {where}", "correct the file of the map there, or take a trajectory that does not lead over it"


_ONE_MANEUVER = (
    "take the lanes of one maneuver: `[m.startLane, m.connectingLane, m.endLane]`, or ask for a route: `a.routeTo(b)`"
)
_AS_IN = "as in `[maneuver.startLane, maneuver.connectingLane, maneuver.endLane]`"
_SPEED_FIRST = "are the arguments in the wrong order? As in `FollowTrajectoryBehavior(target_speed, trajectory)`"


def _lanes(value: Value, span: Span) -> tuple[Lane, ...]:
    chosen(value)
    match value:
        case Lane():
            return (value,)
        case Centerline(lane):
            return _lanes(lane, span)
        case Maneuver():
            return value.lanes
        case tuple():
            return tuple(lane for item in value for lane in _lanes(item, span))
    raise WRONG_KIND.mistake(
        span,
        what="a trajectory",
        expected="a list of lanes, or a `Path`",
        actual=kind_name(value),
        cure=_SPEED_FIRST if isinstance(value, Quantity) else _AS_IN,
    )
