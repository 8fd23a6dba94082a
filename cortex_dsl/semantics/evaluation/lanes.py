"""Lanes, their sections, groups and roads as in Scenic's scripts, also for lanes that only the run knows.

The present lane of an object is a number, the index of the lane; its attributes are looked up in tables.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import NeedsExpansion, Rejection
from cortex_dsl.semantics.errors.runs import LANE_OF_THE_RUN
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.roads import NEIGHBOURS, network_of
from cortex_dsl.semantics.model.areas import RoadSection
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Centerline,
    Closure,
    DirectionField,
    LaneNow,
    Pose,
    Quantity,
    Region,
    SurfaceNow,
    Truth,
    Value,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    equal,
    lane_nearest,
    path_pose,
    path_project,
    table,
)
from cortex_dsl.semantics.quantities.units import LENGTH, SPEED
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from engine.road.linking import shortest_way
from engine.road.network import Intersection, Lane, LaneGroup, Maneuver, Network, Road, Surface
from engine.road.sections import (
    LaneSection,
    group_of,
    opposite_group,
    road_of,
    to_left,
    to_right,
)

NOBODY = -1.0
"""Index of a lane that is not there."""

Getter = Callable[[Evaluator, Lane, Span], Value]


def _neighbour(name: str, find: Callable[[Lane], Lane | None], *, must: bool) -> Getter:
    def get(_ev: Evaluator, lane: Lane, span: Span) -> Value:
        found = find(lane)
        if found is None and must:
            raise Rejection(f"`{lane.name}` has no `{name}`", span)
        return None if found is None else LaneSection(found)

    return get


def _speed_limit(ev: Evaluator, lane: Lane) -> Value:
    return None if lane.speed_limit is None else Quantity(ev.algebra.literal(lane.speed_limit), SPEED)


def limit_on(ev: Evaluator, lane: Term) -> Term:
    """Return the speed limit of a lane by its index [m/s]; infinite without a sign."""
    limits = [each.speed_limit or math.inf for each in network_of(ev).lanes]
    return looked_up(ev, lane, limits, missing=math.inf)


def _route(ev: Evaluator, lane: Lane, end: Value) -> tuple[Lane, ...]:
    """Return the lanes of the shortest way from one lane to another; reject the scene if there is no way."""
    to = chosen(end.lane if isinstance(end, LaneSection) else end)
    if not isinstance(to, Lane):
        what = "what a route leads to"
        raise WRONG_KIND.mistake(ev.algebra.span, what=what, expected="a lane", actual=kind_name(to), cure="")
    if not (way := shortest_way(lane, to)):
        raise Rejection(f"no way leads from `{lane.name}` to `{to.name}`", ev.algebra.span)
    return way


def maneuver_by_arms(intersection: Intersection, span: Span, start: Value, end: Value) -> Maneuver:
    """Return the maneuver from one arm to another; of several, that of the lanes nearest to the kerb.

    Raises:
        Mistake: an arm is unknown, or no maneuver leads from one to the other.
    """
    legs = {leg.name: leg for leg in intersection.legs}
    for arm in (start, end):
        if not isinstance(arm, str) or arm not in legs:
            actual = f'"{arm}"' if isinstance(arm, str) else kind_name(arm)
            names = " or ".join(f'"{name}"' for name in legs)
            cure = did_you_mean(arm, legs) if isinstance(arm, str) else ""
            raise WRONG_KIND.mistake(span, what="an arm of `route`", expected=names, actual=actual, cure=cure)
    one, other = legs[str(start)].incoming_lanes, legs[str(end)].outgoing_lanes
    found = [each for each in intersection.maneuvers if each.start_lane in one and each.end_lane in other]
    if not found:
        ways = [each.end_lane for each in intersection.maneuvers if each.start_lane in one]
        ends = [f'"{name}"' for name, leg in legs.items() if any(lane in leg.outgoing_lanes for lane in ways)]
        expected = f'a way from "{start}", which leads to {" or ".join(ends) or "nothing"}'
        what = f'`route("{start}", "{end}")`'
        raise WRONG_KIND.mistake(span, what=what, expected=expected, actual="none", cure="name another arm")
    return min(found, key=lambda each: (each.start_lane.number, each.end_lane.number))


def _neighbour_getters() -> dict[str, Getter]:
    """Scenic's spelling with `_` gives None where there is no neighbour; the other one rejects the scene."""
    public = {name: _neighbour(name, find, must=True) for name, find in NEIGHBOURS.items()}
    return {**public, **{f"_{name}": _neighbour(name, find, must=False) for name, find in NEIGHBOURS.items()}}


def along(ev: Evaluator, lane: Lane) -> DirectionField:
    """The direction of one lane at the point of its centre line that is nearest, also where lanes cross."""
    path = ev.algebra.literal(float(lane.path))
    return DirectionField(lambda point: path_pose(path, path_project(path, point.x, point.y))[2])


OF_LANE: Mapping[str, Callable[[Evaluator, Lane], Value]] = {
    "sections": lambda _, lane: (LaneSection(lane),),
    "sectionAt": lambda _, lane: Closure(("point",), lambda _point: LaneSection(lane)),
    "orientation": along,
    "group": lambda _, lane: group_of(lane),
    "road": lambda _, lane: road_of(lane),
    "isForward": lambda ev, lane: Truth(ev.algebra.truth(lane.forward)),
    "speedLimit": _speed_limit,
    "adjacentLanes": lambda _, lane: tuple(filter(None, (to_left(lane), to_right(lane)))),
    "routeTo": lambda ev, lane: Closure(("lane",), lambda end: _route(ev, lane, end)),
}
"""Attributes of a lane except its geometry."""

OF_SECTION: Mapping[str, Callable[[Evaluator, LaneSection], Value]] = {
    "lane": lambda _, section: section.lane,
    "centerline": lambda _, section: Centerline(section.lane),
    "orientation": lambda ev, section: along(ev, section.lane),
    "group": lambda _, section: group_of(section.lane),
    "road": lambda _, section: road_of(section.lane),
    "isForward": lambda ev, section: Truth(ev.algebra.truth(section.lane.forward)),
    "speedLimit": lambda ev, section: _speed_limit(ev, section.lane),
    "adjacentLanes": lambda _, section: tuple(
        LaneSection(lane) for lane in (to_left(section.lane), to_right(section.lane)) if lane is not None
    ),
}

OF_GROUP: Mapping[str, Callable[[Evaluator, LaneGroup], Value]] = {
    "lanes": lambda _, group: group.lanes,
    "orientation": lambda *_: DirectionField(),
    "road": lambda _, group: road_of(group.lanes[0]),
    "opposite": lambda _, group: opposite_group(group.lanes[0]),
    "_opposite": lambda _, group: opposite_group(group.lanes[0]),
    "name": lambda _, group: group.name,
}

OF_ROAD: Mapping[str, Callable[[Evaluator, Road], Value]] = {
    "lanes": lambda _, road: road.lanes,
    "orientation": lambda *_: DirectionField(),
    "forwardLanes": lambda _, road: road.forward,
    "backwardLanes": lambda _, road: road.backward if road.backward.lanes else None,
    "laneGroups": lambda _, road: road.groups,
    "sections": lambda _, road: (RoadSection(road),),
    "speedLimit": lambda ev, road: _speed_limit(ev, road.lanes[0]),
    "is1Way": lambda ev, road: Truth(ev.algebra.truth(len(road.groups) == 1)),
    "name": lambda _, road: road.name,
    "signals": lambda _, road: tuple(sign for sign in road.network.signs if sign.road == road.name),
}

OF_ROAD_SECTION: Mapping[str, Callable[[Evaluator, RoadSection], Value]] = {
    "road": lambda _, section: section.road,
    "lanes": lambda _, section: tuple(map(LaneSection, section.road.lanes)),
    "forwardLanes": lambda _, section: tuple(map(LaneSection, section.road.forward.lanes)),
    "backwardLanes": lambda _, section: tuple(map(LaneSection, section.road.backward.lanes)),
}

OF_SECTION_BESIDE: Mapping[str, Getter] = _neighbour_getters()


# -- lanes that only the run knows ------------------------------------------------------------------------------------


def looked_up(ev: Evaluator, lane: Term, values: Sequence[float], *, missing: float = NOBODY) -> Term:
    """The entry of a lane in a table over `network.lanes`; `missing` where there is no such lane."""
    if isinstance(lane, ir.Literal):
        return ev.algebra.literal(float(values[int(lane.value)]) if lane.value >= 0.0 else missing)
    shifted = lane + 1.0
    offset = ev.file.pool.offset([missing, *map(float, values)])
    return table(shifted, offset)


def _id(lane: Lane | None) -> float:
    return NOBODY if lane is None else float(lane.id)


def of_each(ev: Evaluator, lane: Lane | LaneNow | Surface, name: str) -> Term:
    """Return a number of a lane by its name in `Lane`; for a random lane, a lookup in a table."""
    if isinstance(lane, Lane | Surface):
        return ev.algebra.literal(float(getattr(lane, name)))
    return looked_up(ev, lane.id, [getattr(each, name) for each in network_of(ev).lanes])


def chosen(value: Value) -> Value:
    """The value; a lane or surface that the scene draws is chosen by variants instead.

    Raises:
        NeedsExpansion: it is such a lane.
    """
    if isinstance(value, LaneNow | SurfaceNow) and value.drawn:
        raise NeedsExpansion(value.drawn)
    return value


def index_of(ev: Evaluator, value: Value) -> Term | None:
    """Index of a lane or section, known now or only during the run; None for anything else."""
    match value:
        case LaneNow(id=index):
            return index
        case Lane():
            return ev.algebra.literal(float(value.id))
        case LaneSection(lane):
            return ev.algebra.literal(float(lane.id))
    return None


def lane_at(ev: Evaluator, pose: Pose) -> Value:
    """The lane at a pose: the lane itself where it is known, else the nearest one during the run.

    A heading of NaN asks for the nearest lane of any direction.
    """
    if pose.lane is not None:
        return pose.lane
    network_of(ev)
    nearest = lane_nearest(ev.algebra.pack(pose.x, pose.y, pose.heading))
    return LaneNow(nearest, section=False)


def as_section(value: Value) -> Value:
    """The section of a lane."""
    if isinstance(value, Lane):
        return LaneSection(value)
    return replace(value, section=True) if isinstance(value, LaneNow) else value


def of_lane_now(ev: Evaluator, lane: LaneNow, name: str, span: Span) -> Value:
    """An attribute of a lane that only the run knows.

    Raises:
        Mistake: when it cannot be had then.
    """
    network = network_of(ev)
    if name in ("lane", "sections", "sectionAt"):
        return _same_lane(lane, name)
    if name == "centerline" and lane.drawn:
        return Centerline(lane)
    if name not in (*_NUMBERS, "isForward"):
        chosen(lane)
    if (find := NEIGHBOURS.get(name.removeprefix("_"))) is not None and lane.section:
        return LaneNow(looked_up(ev, lane.id, [_id(find(each)) for each in network.lanes]), section=True)
    if name in _NUMBERS:
        return Quantity(looked_up(ev, lane.id, [_NUMBERS[name](each) for each in network.lanes]), LENGTH)
    if name == "speedLimit":
        return Quantity(limit_on(ev, lane.id), SPEED)
    if name == "isForward":
        return Truth(looked_up(ev, lane.id, [float(each.forward) for each in network.lanes]))
    beside = NEIGHBOURS if lane.section else ()
    known = ("lane", "sections", "sectionAt", "isForward", "speedLimit", *_NUMBERS, *beside)
    suggestion = LIGHT_OF_THE_RUN if name == "signal" else did_you_mean(name, known)
    raise LANE_OF_THE_RUN.mistake(span, name=name, suggestion=suggestion)


LIGHT_OF_THE_RUN = "ask with `getClosestTrafficLightStatus(car)` what the light shows at the end of the lane of a car"
"""Replacement for the signal of a lane that only the run knows."""

_NUMBERS: Mapping[str, Callable[[Lane], float]] = {
    "width": lambda lane: lane.width,
    "length": lambda lane: lane.length,
}


def _same_lane(lane: LaneNow, name: str) -> Value:
    section = replace(lane, section=True)
    if name == "lane":
        return replace(lane, section=False)
    return (section,) if name == "sections" else Closure(("point",), lambda _point: section)


def same(ev: Evaluator, left: Value, right: Value) -> Term | None:
    """Return whether two values are the same lane, as a term that the run evaluates; None where both are known."""
    if not (isinstance(left, LaneNow) or isinstance(right, LaneNow)):
        return None
    if left is None or right is None:
        index = index_of(ev, right if left is None else left)
        assert index is not None
        return index < 0.0
    one, other = index_of(ev, left), index_of(ev, right)
    if one is None or other is None:
        return ev.algebra.truth(False)
    return equal(one, other)


def some_lane(ev: Evaluator, value: Value, span: Span, what: str) -> Term:
    """Index of the lane that an argument names.

    Raises:
        Mistake: when the argument is no lane.
    """
    index = index_of(ev, value)
    if index is None:
        cure = "check it with `is not None` first" if value is None else ""
        raise WRONG_KIND.mistake(span, what=what, expected="a lane", actual=kind_name(value), cure=cure)
    return index


def all_sections(network: Network) -> tuple[LaneSection, ...]:
    return tuple(map(LaneSection, network.lanes))


# -- lines and areas --------------------------------------------------------------------------------------------------


def ends(ev: Evaluator, line: Centerline) -> tuple[Pose, Pose]:
    """Return the first and last point of a centre line, with its heading there."""
    lane = line.lane
    if isinstance(lane, LaneNow):
        path, ahead = of_each(ev, lane, "path"), of_each(ev, lane, "length")
        return Pose(*path_pose(path, ev.algebra.literal(0.0))), Pose(*path_pose(path, ahead))
    start, end = (lane.network.paths.pose(lane.path, s) for s in (0.0, lane.length))
    known = ev.algebra.literal
    first, last = (Pose(known(place.x), known(place.y), known(place.heading)) for place in (start, end))
    return first, last


OF_CENTERLINE: Mapping[str, Callable[[Evaluator, Centerline], Value]] = {
    "length": lambda ev, line: Quantity(of_each(ev, line.lane, "length"), LENGTH),
    "lane": lambda _, line: line.lane,
    "start": lambda ev, line: ends(ev, line)[0],
    "end": lambda ev, line: ends(ev, line)[1],
}


def region_of(value: Value) -> Region | None:
    """Return the region that a value covers; None if the value has no area."""
    value = chosen(value)
    if isinstance(value, LaneSection):
        value = value.lane
    if isinstance(value, Lane | Intersection | Surface):
        return Region(value.region, value.name)
    return value if isinstance(value, Region) else None
