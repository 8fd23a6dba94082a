"""Sidewalks, kerbs, shoulders, parking rows, bicycle lanes and crossings: regions, elements and their attributes.

The names and meanings are Scenic's; regions `crossing`, `bikeLane` and `parking` are added.
"""

import math
from collections.abc import Callable, Mapping, Sequence

from cortex_dsl.semantics.errors.problems import Rejection
from cortex_dsl.semantics.errors.runs import LANE_OF_THE_RUN
from cortex_dsl.semantics.errors.scene import NOT_ON_MAP
from cortex_dsl.semantics.evaluation.lanes import chosen, looked_up
from cortex_dsl.semantics.evaluation.ranges import require
from cortex_dsl.semantics.evaluation.roads import ROAD, network_of
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Centerline,
    GroupNow,
    LaneNow,
    Pose,
    Quantity,
    Region,
    Signal,
    SurfaceNow,
    Value,
)
from cortex_dsl.semantics.names.street_words import MADE_BY, OUTSIDE
from cortex_dsl.semantics.quantities.algebra import Term, equal, region_contains, table, where
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.source import Span
from engine.maps import LaneletFile, MapFile
from engine.road.areas import WALKABLE, region_of_kinds, surface_at, vehicle_region
from engine.road.network import Intersection, Lane, LaneGroup, Network, Road, Surface, SurfaceKind
from engine.road.sections import group_of, opposite_group, road_of

Kinds = tuple[SurfaceKind, ...]

SIDEWALK, CURB, CROSSING, PARKING, BIKE_LANE = (
    (kind,)
    for kind in (
        SurfaceKind.SIDEWALK,
        SurfaceKind.CURB,
        SurfaceKind.CROSSING,
        SurfaceKind.PARKING,
        SurfaceKind.BIKE_LANE,
    )
)
SHOULDER: Kinds = (SurfaceKind.SHOULDER, SurfaceKind.PARKING)
"""Scenic counts parking lanes as shoulders."""

# -- regions -----------------------------------------------------------------------------------------------------------


def missing(ev: Evaluator, kinds: Kinds, name: str, span: Span) -> None:
    """Raise Mistake: the map has no element of these kinds."""
    if isinstance(network_of(ev).spec, MapFile):
        types = " or ".join(f"`{each}`" for each in OUTSIDE[kinds[0]])
        lanelets = isinstance(network_of(ev).spec, LaneletFile)
        reason = "its file has no such lanelets" if lanelets else f"its file has no {types}"
        cure = "take a file that has some, or a road made by `map`"
    else:
        reason, cure = "its `map` line asks for none", f"write `{MADE_BY[kinds[0]]}` into it"
    raise NOT_ON_MAP.mistake(span, name=name, reason=reason, cure=cure)


def _region(kinds: Kinds, name: str) -> Callable[[Evaluator, Span], Value]:
    def find(ev: Evaluator, span: Span) -> Value:
        if (region := region_of_kinds(network_of(ev), kinds)) is None:
            missing(ev, kinds, name, span)
        assert region is not None
        return Region(region, f"`{name}`")

    return find


def _up_to_kerbs(ev: Evaluator, _: Span) -> Value:
    region = vehicle_region(network_of(ev))
    return ROAD if region == ROAD.id else Region(region, "`roadOrShoulder`")


REGIONS: Mapping[str, Callable[[Evaluator, Span], Value]] = {
    "sidewalk": _region(SIDEWALK, "sidewalk"),
    "curb": _region(CURB, "curb"),
    "shoulder": _region(SHOULDER, "shoulder"),
    "roadOrShoulder": _up_to_kerbs,
    "crossing": _region(CROSSING, "crossing"),
    "bikeLane": _region(BIKE_LANE, "bikeLane"),
    "parking": _region(PARKING, "parking"),
}
"""Regions by their names in the language."""


def walkable(ev: Evaluator, span: Span) -> Value:
    """Return the region of all sidewalks and crossings."""
    return _region(WALKABLE, "walkableRegion")(ev, span)


# -- elements ----------------------------------------------------------------------------------------------------------


def _of_network(kinds: Kinds, name: str) -> Callable[[Evaluator, Network], Value]:
    return lambda ev, _: _region(kinds, name)(ev, ev.algebra.span)


def _listed(kinds: Kinds, name: str) -> Callable[[Evaluator, Network], Value]:
    def find(ev: Evaluator, network: Network) -> Value:
        found = tuple(each for each in network.surfaces if each.kind in kinds)
        if not found and not isinstance(network.spec, MapFile):
            missing(ev, kinds, name, ev.algebra.span)
        return found

    return find


OF_NETWORK: Mapping[str, Callable[[Evaluator, Network], Value]] = {
    "sidewalks": _listed(SIDEWALK, "sidewalks"),
    "crossings": _listed(CROSSING, "crossings"),
    "shoulders": _listed(SHOULDER, "shoulders"),
    "bikeLanes": _listed(BIKE_LANE, "bikeLanes"),
    "sidewalkRegion": _of_network(SIDEWALK, "sidewalkRegion"),
    "crossingRegion": _of_network(CROSSING, "crossingRegion"),
    "curbRegion": _of_network(CURB, "curbRegion"),
    "shoulderRegion": _of_network(SHOULDER, "shoulderRegion"),
    "walkableRegion": _of_network(WALKABLE, "walkableRegion"),
}


def _along(road: Road, kinds: Kinds) -> tuple[Surface, ...]:
    """Return the elements of a road, those of the forward direction first."""
    return tuple(each for each in road.network.surfaces if each.road == road.name and each.kind in kinds)


OF_ROAD: Mapping[str, Callable[[Evaluator, Road], Value]] = {
    "sidewalks": lambda _, road: _along(road, SIDEWALK),
    "crossings": lambda _, road: _along(road, CROSSING),
}


def crossings_of(intersection: Intersection) -> tuple[Surface, ...]:
    """Return the crossings at an intersection, clockwise from the north."""

    def turned(crossing: Surface) -> float:
        start, end = crossing.ends_at
        x, y = 0.5 * (start.x + end.x) - intersection.center[0], 0.5 * (start.y + end.y) - intersection.center[1]
        return (math.atan2(x, y) + 1e-9) % math.tau

    own = (each for each in intersection.network.surfaces if each.intersection_id == intersection.id)
    return tuple(sorted((each for each in own if each.kind is SurfaceKind.CROSSING), key=turned))


def element_at(network: Network, x: float, y: float) -> Value:
    """Return the intersection, else the road, the shoulder, the sidewalk at a point; None without one."""
    inside = (each for each in network.intersections if network.regions.contains(each.region, x, y))
    lanes = (lane for lane in network.lanes if network.regions.contains(lane.region, x, y))
    return next(inside, None) or next(map(road_of, lanes), None) or surface_at(network, (*SHOULDER, *SIDEWALK), x, y)


def light_of(crossing: Surface) -> Signal | None:
    """Return the light of the people on a crossing: that of an arm with the other phase; None without one."""
    if crossing.arm is None or crossing.intersection_id is None:
        return None
    place = crossing.network.intersections[crossing.intersection_id]
    phase = place.legs[crossing.arm].phase
    others = (arm for arm, leg in enumerate(place.legs) if leg.phase != phase and leg.incoming_lanes)
    return next((Signal(place, arm) for arm in others), None)


def _end(at: int) -> Callable[[Evaluator, Surface], Value]:
    def find(ev: Evaluator, crossing: Surface) -> Value:
        if (found := crossing.sidewalks[at]) is None:
            raise Rejection(f"`{crossing.name}` has no sidewalk at its {('start', 'end')[at]}", ev.algebra.span)
        return found

    return find


_ANY: Mapping[str, Callable[[Evaluator, Surface], Value]] = {
    "name": lambda _, surface: surface.name,
    "width": lambda ev, surface: Quantity(ev.algebra.literal(surface.width), LENGTH),
    "length": lambda ev, surface: Quantity(ev.algebra.literal(surface.length), LENGTH),
    "centerline": lambda _, surface: Centerline(surface),
    "road": lambda _, surface: surface.network.road_named.get(surface.road),
}
OF_SURFACE: Mapping[SurfaceKind, Mapping[str, Callable[[Evaluator, Surface], Value]]] = {
    **dict.fromkeys(SurfaceKind, _ANY),
    SurfaceKind.SIDEWALK: {**_ANY, "crossings": lambda _, sidewalk: sidewalk.crossings},
    SurfaceKind.CROSSING: {
        **_ANY,
        "parent": lambda _, crossing: crossing.parent,
        "startSidewalk": _end(0),
        "endSidewalk": _end(1),
        "signal": lambda _, crossing: light_of(crossing),
    },
}
"""Attributes of elements, by their kind."""

# -- beside the lanes of one direction ---------------------------------------------------------------------------------

BESIDE: Mapping[str, Kinds] = {"curb": CURB, "sidewalk": SIDEWALK, "shoulder": SHOULDER, "bikeLane": BIKE_LANE}
"""Elements beside a group of lanes, by attribute; without one, a leading `_` gives None, else the scene is rejected."""


def _beside(group: LaneGroup, kinds: Kinds) -> Surface | None:
    found = (group.network.beside(group.road, kind, forward=group.forward) for kind in kinds)
    return next((each for each in found if each is not None), None)


def _of_group(name: str, *, must: bool) -> Callable[[Evaluator, LaneGroup], Value]:
    def find(ev: Evaluator, group: LaneGroup) -> Value:
        found = _beside(group, BESIDE[name])
        if found is None and must:
            if not any(each.kind in BESIDE[name] for each in group.network.surfaces):
                missing(ev, BESIDE[name], name, ev.algebra.span)
            raise Rejection(f"`{group.name}` has no `{name}`", ev.algebra.span)
        return found

    return find


OF_GROUP: Mapping[str, Callable[[Evaluator, LaneGroup], Value]] = {
    **{name: _of_group(name, must=True) for name in BESIDE},
    **{f"_{name}": _of_group(name, must=False) for name in BESIDE},
}


def group_now(lane: Value, *, opposite: bool) -> Value:
    """Return the group of a lane, or the opposite group; for a lane that only the scene knows, a group by its lane."""
    known = chosen(lane)
    if isinstance(known, LaneNow):
        return GroupNow(known, opposite)
    if not isinstance(known, Lane):
        return None
    return opposite_group(known) if opposite else group_of(known)


def of_group_now(ev: Evaluator, group: GroupNow, name: str, span: Span) -> Value:
    """Return an attribute of a group that only the scene knows.

    Raises:
        Mistake: when it cannot be had then.
    """
    if name.removeprefix("_") == "opposite":
        return GroupNow(group.lane, not group.opposite)
    if (kinds := BESIDE.get(name.removeprefix("_"))) is not None:
        return _beside_now(ev, group, kinds, name)
    suggestion = "place it along a lane, as in `on lane.centerline`, to know its lanes"
    raise LANE_OF_THE_RUN.mistake(span, name=name, suggestion=suggestion)


def _beside_now(ev: Evaluator, group: GroupNow, kinds: Kinds, name: str) -> SurfaceNow | None:
    network = network_of(ev)
    groups = [opposite_group(lane) if group.opposite else group_of(lane) for lane in network.lanes]
    found = [None if each is None else _beside(each, kinds) for each in groups]
    options = (None, *dict.fromkeys(each for each in found if each is not None))
    if len(options) == 1 and name.startswith("_"):
        return None
    if len(options) == 1:
        missing(ev, kinds, name, ev.algebra.span)
    return SurfaceNow(
        options, looked_up(ev, group.lane.id, [float(options.index(each)) for each in found], missing=0.0)
    )


def crossing_now(ev: Evaluator, at: Pose, span: Span, *, must: bool) -> Value:
    """Return the crossing at a place that only the scene or the run knows; None on a map without crossings.

    With `must`, a scene without a crossing there is rejected.
    """
    options = tuple(each for each in network_of(ev).surfaces if each.kind is SurfaceKind.CROSSING)
    if not options and must:
        missing(ev, CROSSING, "crossing", span)
    if not options:
        return None
    index: Term = ev.algebra.literal(0.0)
    for number, each in reversed(list(enumerate(options, 1))):
        index = where(region_contains(float(each.region), at.x, at.y), float(number), index)
    if must and not ev.moment.running:
        require(ev, index > 0.0, f"`{ev.facts.source.words(span)}` is there", span)
    return SurfaceNow((None, *options), index)


def same(left: Value, right: Value) -> Term | None:
    """Return whether an element that only the scene or the run knows is another one, or None; None for other values."""
    if not isinstance(left, SurfaceNow):
        left, right = right, left
    if not isinstance(left, SurfaceNow) or isinstance(right, SurfaceNow):
        return None
    number = next((float(n) for n, each in enumerate(left.options) if each is right), -1.0)
    return equal(left.index, number)


def found_now(ev: Evaluator, surface: SurfaceNow) -> tuple[Term, Term, Term]:
    """Return region, path and length [m] of an element that only the scene knows; the length is 0 where there is none.

    Region and path are then those of the road and its first lane, so that a place can still be drawn.
    """

    def column(values: Sequence[float]) -> Term:
        return table(surface.index, ev.file.pool.offset(list(values)))

    every = surface.options
    region = column([float(ROAD.id if each is None else each.region) for each in every])
    path = column([0.0 if each is None else float(each.path) for each in every])
    return region, path, column([0.0 if each is None else each.length for each in every])
