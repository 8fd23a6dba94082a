"""What a driver has to know who changes lanes: where a lane ends beside another that goes on, as the acceleration lane
of a motorway does, and where those come from who are behind in a lane.
"""

import math
from itertools import chain

import numpy as np

from engine.road.kept import kept
from engine.road.network import Lane, Network
from engine.road.sections import to_left, to_right

GOES_ON = 20.0
"""Another lane goes on where it leads so much further [m]."""
FULL = 0.9
"""Of its greatest width: where a lane gets narrower, it ends to those who drive on it."""
BACK = 150.0
"""How far before a lane others are looked for [m]: 5 s at 30 m/s."""


def way_through(lane: Lane) -> int:
    """The path of a driver without a plan, from before the lane on: `BACK` or more, straight where that can be."""
    paths, before = lane.network.paths, list[Lane]()
    while sum(each.length for each in before) < BACK:
        first = before[0] if before else lane
        leading = [each for each in first.predecessors if paths.continues(each.path, first.path)]
        leading = [each for each in leading if each is not lane and each not in before]
        if not leading:
            break
        before.insert(0, min(leading, key=_turn))
    return paths.join([*(each.path for each in before), *paths.parts(lane.default_route)])


@kept
def ways_through(network: Network) -> tuple[int, ...]:
    """`way_through` of each lane: a driver asks for all of them many times over."""
    return tuple(map(way_through, network.lanes))


@kept
def all_left_by(network: Network) -> tuple[float, ...]:
    """`left_by` of each lane."""
    return tuple(map(left_by, network.lanes))


def _turn(lane: Lane) -> float:
    """By how much a lane turns from its start to its end [rad]."""
    paths = lane.network.paths
    return abs(
        math.remainder(paths.pose(lane.path, lane.length).heading - paths.pose(lane.path, 0.0).heading, math.tau)
    )


def left_by(lane: Lane) -> float:
    """Where on its `way_through` a driver has to have left a lane that ends beside another one that goes on [m];
    infinite where none does.
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
    """Whether the way of a lane leads past a point."""
    paths, way = lane.network.paths, lane.default_route
    near = paths.distance(way, x, y) < 2.0 * lane.width
    return near and paths.length(way) - paths.project(way, x, y) > GOES_ON


def _full_until(lane: Lane) -> float:
    """Up to where a lane keeps its width [m]."""
    if lane.id not in lane.network.bounds:
        return lane.length
    left, right = lane.network.bounds[lane.id]
    widths = np.hypot(*(left - right).T)
    at = int(np.flatnonzero(widths >= FULL * widths.max())[-1])
    return lane.network.paths.project(lane.path, *(0.5 * (left[at] + right[at])).tolist())
