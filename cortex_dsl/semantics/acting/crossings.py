"""Right of way of people on crossings, and the distance that drivers keep from cyclists.

A person on a crossing, or within 1 m of it and walking towards it, has the right of way: where the person's way and
that of a driver cross, the driver does not go first, however much time it has. The driver continues when the ways no
longer cross because the person has passed. On a map without crossings nobody has this right.
"""

from cortex_dsl.semantics.acting.foreseeing import STANDING
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, left_of_path, others, size_of, state
from cortex_dsl.semantics.evaluation.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import unhidden
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    cos,
    maximum,
    minimum,
    path_project,
    region_contains,
    sin,
    where,
)
from engine.errors import InterchangeError
from engine.maps import Street
from engine.road.areas import region_of_kinds
from engine.road.network import Network, SurfaceKind
from engine.vocabulary import ActorKind, State

NEAR = 1.0
"""Distance of a walking person from a crossing from which on the person has the right of way [m]; *ours*."""
CLEAR = 1.5
"""Distance that a driver keeps from a cyclist where its lane allows it [m]: StVO, section 5 (4), in towns. Measured
distances of cars are 1.58 m on average (Florida DOT 2011)."""
EARLY, LATE = 40.0, 6.0
"""Gaps to a cyclist ahead at which a driver begins to move aside, and behind at which it is back [m]; *ours*."""
MOVED = 15.0
"""Gap to a cyclist ahead at which the driver has moved aside [m]; *ours*."""
MOST = 1.0
"""Largest offset of a driver that keeps clear of a cyclist [m]; *ours*: it stays on its way, see `giving_way.OFF`."""


def _surfaces(network: Network, kind: SurfaceKind) -> bool:
    """Return whether a map has surfaces of a kind; for a street, by its specification, without building them."""
    spec = network.spec
    if isinstance(spec, Street):
        return bool(spec.crossings if kind is SurfaceKind.CROSSING else spec.bike_lane)
    return any(each.kind is kind for each in network.surfaces)


def _regions(network: Network) -> tuple[int, ...]:
    """Return the regions of all crossings: one, or one for each crossing where they have no common region."""
    try:
        region = region_of_kinds(network, (SurfaceKind.CROSSING,))
    except InterchangeError:
        return tuple(each.region for each in network.surfaces if each.kind is SurfaceKind.CROSSING)
    return () if region is None else (region,)


def goes_first(job: Job, other: Actor) -> Term | None:
    """Return whether another actor is a person with the right of way on a crossing; None if it never is."""
    ev = job.ev
    if other.kind is not ActorKind.PEDESTRIAN or not job.flag("yields_at_crossings", default=True):
        return None
    network = network_of(ev)
    if not _surfaces(network, SurfaceKind.CROSSING):
        return None
    here, reach = current_pose(ev, other), NEAR + 0.5 * size_of(other, "length")
    x, y = here.x + reach * cos(here.heading), here.y + reach * sin(here.heading)
    regions = [float(each) for each in _regions(network)]
    on_it = ev.algebra.any_of([region_contains(each, here.x, here.y) for each in regions])
    towards = ev.algebra.any_of([region_contains(each, x, y) for each in regions])
    return is_present(ev, other) & (on_it | (towards & (state(ev, other, State.SPEED) > STANDING)))


def setback(job: Job, other: Actor) -> Term:
    """Return the distance from a person in the middle of a crossing to the border of the crossing [m]."""
    surfaces = (each for each in network_of(job.ev).surfaces if each.kind is SurfaceKind.CROSSING)
    return maximum(0.0, 0.5 * max(each.width for each in surfaces) - 0.5 * size_of(other, "width"))


# -- cyclists ----------------------------------------------------------------------------------------------------------


def clear_of_cyclists(job: Job, path: Term) -> Term | None:
    """Return the offset to the left of a path [m] at which a driver keeps `CLEAR` from cyclists beside the path.

    The outline stays in the lane, and within `MOST` of the path. None without cyclists, and on a map that has neither
    crossings nor bicycle lanes.
    """
    ev, network = job.ev, network_of(job.ev)
    cyclists = [each for each in others(ev, job.actor) if each.kind is ActorKind.BICYCLE]
    has_streets = _surfaces(network, SurfaceKind.CROSSING) or _surfaces(network, SurfaceKind.BIKE_LANE)
    if not cyclists or not has_streets or not job.flag("yields_at_crossings", default=True):
        return None
    here, none = current_pose(ev, job.actor), ev.algebra.literal(0.0)
    s, right, left = path_project(path, here.x, here.y), none, none
    for each in cyclists:
        there = current_pose(ev, each)
        at = path_project(path, there.x, there.y)
        aside = left_of_path(path, at, there)
        apart = abs(aside) - 0.5 * (size_of(job.actor, "width") + size_of(each, "width"))
        long = 0.5 * (size_of(job.actor, "length") + size_of(each, "length"))
        ahead = at - s
        coming = minimum(1.0, maximum(0.0, (EARLY - (ahead - long)) / (EARLY - MOVED)))
        passing = minimum(1.0, maximum(0.0, (ahead + long + LATE) / LATE))
        counts = is_present(ev, each) & (apart > 0.0) & unhidden(ev, job.actor, each)
        needed = where(counts, maximum(0.0, CLEAR - apart) * minimum(coming, passing), 0.0)
        right = maximum(right, where(aside < 0.0, needed, 0.0))
        left = maximum(left, where(aside < 0.0, 0.0, needed))
    lane = index_of(ev, lane_at(ev, here))
    assert lane is not None
    width = looked_up(ev, lane, [each.width for each in network.lanes], missing=0.0)
    room = minimum(MOST, maximum(0.0, 0.5 * (width - size_of(job.actor, "width"))))
    return minimum(room, maximum(-room, right - left))
