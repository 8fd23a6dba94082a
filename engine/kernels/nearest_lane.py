"""Lane of a position: the lane with the nearest centre line."""

import math

from engine.kernels.jit import inlined, kernel
from engine.kernels.path import CURVATURE, LENGTH, ROUNDING, X, Y, chain_pose, chain_project_within, local_place
from engine.tables import RoadTables


@kernel
def lane_nearest(road: RoadTables, x: float, y: float, heading: float) -> int:
    """Return the lane with the nearest centre line; of equally near ones the first.

    With a heading (not NaN) the cost of a lane across it is increased by one lane width, of a lane against it by two.
    The cost of a likely lane is computed first, so that most others are rejected by a cheap test.
    """
    best, best_cost = 0, math.inf
    if len(road.lane_path) == 0:
        return best
    bound = _lane_cost(road, _likely_lane(road, x, y), x, y, heading, math.inf) + ROUNDING
    for lane in range(len(road.lane_path)):
        cost = _lane_cost(road, lane, x, y, heading, min(bound, best_cost))
        if cost < best_cost:
            best, best_cost = lane, cost
    return best


@kernel
def first_lane(road: RoadTables, actor: int, x: float, y: float, heading: float) -> int:
    """Return the nearest of the lanes on whose level an actor begins; -1 for an actor without such lanes."""
    best, best_cost = -1, math.inf
    for row in range(len(road.first_lanes)):
        if road.first_lanes[row, 0] == actor:
            lane = int(road.first_lanes[row, 1])
            cost = _lane_cost(road, lane, x, y, heading, math.inf)
            if best < 0 or cost < best_cost:
                best, best_cost = lane, cost
    return best


@inlined
def _likely_lane(road: RoadTables, x: float, y: float) -> int:
    """Return a near straight lane, if there is one, else lane 0."""
    likely, least = 0, math.inf
    for lane in range(len(road.lane_path)):
        row = int(road.path_start[road.lane_path[lane]])
        if road.primitives[row, CURVATURE] == 0.0:
            ahead, left = local_place(road.primitives, row, x, y)
            beyond = ahead - min(max(ahead, 0.0), road.primitives[row, LENGTH])
            if beyond * beyond + left * left < least:
                likely, least = lane, beyond * beyond + left * left
    return likely


@inlined
def _lane_cost(road: RoadTables, lane: int, x: float, y: float, heading: float, bound: float) -> float:
    """Return the cost of a lane as in `lane_nearest` [m]; infinite if it is at least `bound`, or nearly."""
    path = int(road.lane_path[lane])
    first, last = int(road.path_start[path]), int(road.path_start[path + 1])
    dx, dy = x - road.primitives[first, X], y - road.primitives[first, Y]
    reach = bound + road.path_length[path] + ROUNDING
    if dx * dx + dy * dy > reach * reach:
        return math.inf  # even its far end is farther away
    s, cost = chain_project_within(road.primitives, first, last, x, y, bound)
    if not cost < bound:
        return math.inf
    if not math.isnan(heading):
        turn = chain_pose(road.primitives, first, last, s).heading - heading
        cost += road.lane_width[lane] * (1.0 - math.cos(turn))
    return cost
