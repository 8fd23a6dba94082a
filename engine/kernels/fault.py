"""Fault of a contact of the ego, as far as motion and road determine it: it may have been struck.

Two kinds of contact are no fault of the ego. Another runs into it from behind: contact is at the ego's rear, the ego
does not reverse, the other is the faster of the two along the ego's heading, and for the last second, or since both
were present, it was behind the ego on the ego's earlier path. (An ego that cuts in before another, or turns in, is not
struck.) Or the ego stands at a permitted place: it has stood for the last second, or since the run began, and no part
of it is in an intersection, or in a lane that leads against its heading or across it.
"""

import math

from engine.kernels.conflict import shadow
from engine.kernels.geometry import outline_at
from engine.kernels.jit import inlined, kernel, shared
from engine.kernels.nearest_lane import lane_nearest
from engine.kernels.pair import PairMetrics
from engine.kernels.path import chain_pose, chain_project
from engine.kernels.region import region_contains
from engine.tables import ROAD_REGION, Floats, RoadTables
from engine.vocabulary import Fault, Side, State

STANDING = 0.1
"""Speed below which an actor stands [m/s]."""
SETTLED = 1.0
"""Time for which it must have stood, or been followed [s]; a choice of cortexc: the time in which another sees it and
begins to brake.
"""
ACROSS = 1e-6
"""Cosines that are no greater may be rounding noise: exactly across counts as against."""
EGO, FROM_BEHIND, WHILE_STANDING = map(int, Fault)
REAR = int(Side.REAR)


@shared
def fault_of(
    states: Floats,
    last: int,
    time_step: float,
    other: int,
    outlines: Floats,
    met: PairMetrics,
    road: RoadTables,
    intersections: int,
) -> int:
    """Return the `Fault` of the contact of actor 0, the ego, with `other` in the step after sample `last`.

    `met` is the result of `pair.measure_pair` for the two, with the same `outlines`; the road's regions 1 to
    `intersections` are intersections. A road without regions permits standing everywhere.
    """
    forwards = met.ego_speed > -STANDING
    same_way = math.cos(met.approach_angle)
    faster = same_way > ACROSS and met.other_speed * same_way > max(0.0, met.ego_speed)
    if int(met.side) == REAR and forwards and faster and _was_followed(states, last, time_step, other, outlines):
        return FROM_BEHIND
    if _stood(states, last, time_step) and not _is_in_the_way(states, last, outlines, road, intersections):
        return WHILE_STANDING
    return EGO


@kernel
def _was_followed(states: Floats, last: int, time_step: float, other: int, outlines: Floats) -> bool:
    """Return True if the other was behind, in the strip that the ego swept, for `SETTLED` or since both were present.

    If it was abreast of an earlier pose of the ego, it must overlap the strip of the ego's width there; if it was
    behind all of them, it is compared with the first.
    """
    pose = last
    for k in range(last, max(0, last - math.ceil(SETTLED / time_step)) - 1, -1):
        if states[k, 0, State.PRESENT] == 0.0 or states[k, other, State.PRESENT] == 0.0:
            return True
        them = outline_at(states, k, other, outlines)
        pose = min(pose, k)
        ahead = 0.0
        while True:
            ego = outline_at(states, pose, 0, outlines)
            cos, sin = math.cos(ego.heading), math.sin(ego.heading)
            ahead = cos * (them.x - ego.x) + sin * (them.y - ego.y)
            if ahead >= 0.0 or pose == 0 or states[pose - 1, 0, State.PRESENT] == 0.0:
                break
            pose -= 1
        aside = cos * (them.y - ego.y) - sin * (them.x - ego.x)
        if (pose == k and ahead >= 0.0) or abs(aside) >= 0.5 * ego.width + shadow(them, -sin, cos):
            return False
    return True


@inlined
def _stood(states: Floats, last: int, time_step: float) -> bool:
    first = max(0, last - math.ceil(SETTLED / time_step))
    for k in range(first, last + 1):
        if abs(states[k, 0, State.SPEED]) >= STANDING or states[k, 0, State.PRESENT] == 0.0:
            return False
    return True


@kernel
def _is_in_the_way(states: Floats, last: int, outlines: Floats, road: RoadTables, intersections: int) -> bool:
    """Return True if the ego's centre or a corner lies in an intersection, or in a lane with another direction."""
    ego = outline_at(states, last, 0, outlines)
    cos, sin = math.cos(ego.heading), math.sin(ego.heading)
    for place in range(5):
        along = 0.0 if place == 4 else 0.5 * ego.length * (1.0 if place < 2 else -1.0)
        across = 0.0 if place == 4 else 0.5 * ego.width * (1.0 if place % 2 == 0 else -1.0)
        x, y = ego.x + along * cos - across * sin, ego.y + along * sin + across * cos
        for region in range(1, min(intersections, len(road.region_start) - 2) + 1):
            if region_contains(road, region, x, y):
                return True
        if _leads_against(road, x, y, ego.heading):
            return True
    return False


@inlined
def _leads_against(road: RoadTables, x: float, y: float, heading: float) -> bool:
    """Return True if the lane at (x, y) leads against a heading, or exactly across it; False off the road."""
    if len(road.lane_path) == 0 or not region_contains(road, ROAD_REGION, x, y):
        return False
    path = int(road.lane_path[lane_nearest(road, x, y, math.nan)])
    first, last = int(road.path_start[path]), int(road.path_start[path + 1])
    s, _ = chain_project(road.primitives, first, last, x, y)
    return math.cos(chain_pose(road.primitives, first, last, s).heading - heading) <= ACROSS
