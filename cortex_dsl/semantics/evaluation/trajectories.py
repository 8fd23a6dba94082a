"""Trajectories: lists of lanes that follow one another, joined into one path."""

from itertools import pairwise

from cortex_dsl.semantics.errors.objects import EMPTY_TRAJECTORY, NOT_CONNECTED
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
            follows = ", ".join(f"`{lane.name}`" for lane in before.successors) or "no lane"
            raise NOT_CONNECTED.mistake(span, number=number, before=before.name, after=after.name, follows=follows)
    return Trajectory(lanes, paths.join([lane.path for lane in lanes]))


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
        expected="a list of lanes",
        actual=kind_name(value),
        cure=_SPEED_FIRST if isinstance(value, Quantity) else _AS_IN,
    )
