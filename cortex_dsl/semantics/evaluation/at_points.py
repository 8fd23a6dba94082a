"""`network.laneAt(point)` and similar queries of the map at a position; lanes are known during the run, too."""

import math
from collections.abc import Callable, Mapping

from cortex_dsl.semantics.errors.runs import LANE_OF_THE_RUN
from cortex_dsl.semantics.evaluation.geometry import current_pose, position
from cortex_dsl.semantics.evaluation.lanes import as_section, chosen, lane_at
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Closure, Pose, Value, Vector
from cortex_dsl.semantics.quantities.bounds import closed_value
from engine.road.network import Lane, LaneRole, Network
from engine.road.sections import group_of, road_of


def lane_under(ev: Evaluator, place: Value) -> Value:
    """The lane at a point, whatever its direction, or on which an object or an oriented point lies."""
    if isinstance(place, Actor):
        return lane_at(ev, current_pose(ev, place))
    if isinstance(place, Pose):
        return lane_at(ev, place)
    point = position(ev, place, ev.algebra.span, "the point whose lane is needed")
    if (only := _only_lane(ev, point)) is not None:
        return only
    return lane_at(ev, Pose(point.x, point.y, ev.algebra.literal(math.nan)))


def _only_lane(ev: Evaluator, point: Vector) -> Lane | None:
    """Return the lane at a known point if no other lane covers it; all of its attributes are then available."""
    x, y = closed_value(point.x), closed_value(point.y)
    if x is None or y is None:
        return None
    network = network_of(ev)
    found = [lane for lane in network.lanes if network.regions.contains(lane.region, x, y)]
    return found[0] if len(found) == 1 else None


Point = tuple[float, float]


def _intersection(network: Network, at: Lane | Point) -> Value:
    if isinstance(at, Lane):
        return at.intersection if at.role is LaneRole.CONNECTING else None
    return next((each for each in network.intersections if network.regions.contains(each.region, *at)), None)


def _of_lane(find: Callable[[Lane], Value]) -> Callable[[Network, Lane | Point], Value]:
    def found(network: Network, at: Lane | Point) -> Value:
        if isinstance(at, Lane):
            return find(at)
        lanes = (lane for lane in network.lanes if network.regions.contains(lane.region, *at))
        return next(map(find, lanes), None)

    return found


_KINDS: Mapping[str, Callable[[Network, Lane | Point], Value]] = {
    "roadAt": _of_lane(road_of),
    "laneGroupAt": _of_lane(group_of),
    "intersectionAt": _intersection,
}


def _known(ev: Evaluator, place: Value, name: str) -> Lane | Point:
    """Return the lane on which an object was placed, or a point with known coordinates.

    Raises:
        Mistake: only the run knows it, or it is no place.
    """
    where = current_pose(ev, place) if isinstance(place, Actor) else place
    if isinstance(where, Pose) and isinstance(lane := chosen(where.lane), Lane):
        return lane
    point = position(ev, where, ev.algebra.span, f"the argument of `{name}`")
    x, y = closed_value(point.x), closed_value(point.y)
    if x is None or y is None:
        suggestion = "ask at a point that is known before the run, as in `(3 m, 40 m)`"
        raise LANE_OF_THE_RUN.mistake(ev.algebra.span, name=name, suggestion=suggestion)
    return x, y


def _asked(ev: Evaluator, name: str) -> Closure:
    return Closure(("point",), lambda place: _KINDS[name](network_of(ev), _known(ev, place, name)))


AT_POINTS: Mapping[str, Callable[[Evaluator, Network], Value]] = {
    "laneAt": lambda ev, _: Closure(("point",), lambda point: lane_under(ev, point)),
    "laneSectionAt": lambda ev, _: Closure(("point",), lambda point: as_section(lane_under(ev, point))),
    "roadAt": lambda ev, _: _asked(ev, "roadAt"),
    "laneGroupAt": lambda ev, _: _asked(ev, "laneGroupAt"),
    "intersectionAt": lambda ev, _: _asked(ev, "intersectionAt"),
}
