"""Data for lane changes: lanes that end while a neighbour continues, such as the acceleration lane of a motorway, and
the ways from which followers in a lane come.
"""

import math
from itertools import chain

import numpy as np

from engine.road.network import Lane, Network, once_per_network
from engine.road.sections import to_left, to_right

GOES_ON = 20.0
"""Length beyond the end of a lane from which on its neighbour continues [m]."""
FULL = 0.9
"""Share of its greatest width below which a narrowing lane ends for its drivers."""
BACK = 150.0
"""Distance before a lane within which followers are considered [m]: 5 s at 30 m/s."""


def way_through(lane: Lane) -> int:
    """Return the path of a driver without a plan, from `BACK` or more before the lane on, straight if possible."""
    paths, before = lane.network.paths, list[Lane]()
    while sum(each.length for each in before) < BACK:
        first = before[0] if before else lane
        leading = [each for each in first.predecessors if paths.continues(each.path, first.path)]
        leading = [each for each in leading if each is not lane and each not in before]
        if not leading:
            break
        before.insert(0, min(leading, key=_turn))
    return paths.join([*(each.path for each in before), *paths.parts(lane.default_route)])


@once_per_network
def ways_through(network: Network) -> tuple[int, ...]:
    """Return `way_through` of each lane; cached, as drivers use all of them many times."""
    return tuple(map(way_through, network.lanes))


@once_per_network
def all_left_by(network: Network) -> tuple[float, ...]:
    """Return `left_by` of each lane."""
    return tuple(map(left_by, network.lanes))


def _turn(lane: Lane) -> float:
    """Return the angle by which a lane turns from its start to its end [rad]."""
    paths = lane.network.paths
    return abs(
        math.remainder(paths.pose(lane.path, lane.length).heading - paths.pose(lane.path, 0.0).heading, math.tau)
    )


def left_by(lane: Lane) -> float:
    """Return the arc length on `way_through` by which a driver must leave a lane that ends while a neighbour continues
    [m].

    Infinite if no neighbour continues.
    """
    network, paths = lane.network, lane.network.paths
    last_path = paths.parts(lane.default_route)[-1]
    last = next(each for each in chain((lane,), network.lanes) if each.path == last_path)
    end = paths.pose(last.path, last.length)
    beside = (other for other in (to_left(last), to_right(last)) if other is not None and other.forward == last.forward)
    if not any(_goes_on(other, end.x, end.y) for other in beside):
        return math.inf
    return paths.length(way_through(lane)) - last.length + _full_until(last)


def _goes_on(lane: Lane, x: float, y: float) -> bool:
    """Return True if the way of a lane leads past a point."""
    paths, way = lane.network.paths, lane.default_route
    near = paths.distance(way, x, y) < 2.0 * lane.width
    return near and paths.length(way) - paths.project(way, x, y) > GOES_ON


def _full_until(lane: Lane) -> float:
    """Return the arc length up to which a lane has its full width [m]."""
    if lane.id not in lane.network.bounds:
        return lane.length
    left, right = lane.network.bounds[lane.id]
    widths = np.hypot(*(left - right).T)
    at = int(np.flatnonzero(widths >= FULL * widths.max())[-1])
    return lane.network.paths.project(lane.path, *(0.5 * (left[at] + right[at])).tolist())
