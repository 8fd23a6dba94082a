"""What a behaviour may ask about the others around it: who leads along a path, and how soon outlines would touch."""

import math
from typing import NamedTuple

from engine.kernels.conflict import Snapshot, shadow, time_to_collision
from engine.kernels.geometry import Box
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.kernels.measure import Rate, center_velocity
from engine.kernels.path import path_distance, path_pose, path_project
from engine.kernels.stage import Plan, Run, column_of, outline_of
from engine.vocabulary import Column, State


class Leader(NamedTuple):
    """Who is ahead on a path: the gap to it along the path [m] and its speed along the path [m/s]."""

    gap: float
    speed: float


@kernel
def leader(plan: Plan, run: Run, sample: int, me: int, path: int) -> Leader:
    """The nearest actor ahead of `me` on a path; infinity and 0 with nobody ahead.

    Somebody is on the path who reaches into the strip that my width sweeps along it, and ahead whose centre's foot
    point lies beyond mine. The gap is measured along the path between the shadows of both outlines on its direction at
    their foot points, and is 0 where these overlap.
    """
    mine = outline_of(plan, run, sample, me)
    start = path_project(plan.road, path, mine.x, mine.y)
    heading = path_pose(plan.road, path, start).heading
    front = start + shadow(mine, math.cos(heading), math.sin(heading))
    gap, speed = math.inf, 0.0
    for other in range(run.states.shape[1]):
        if other == me or run.states[sample, other, State.PRESENT] == 0.0:
            continue
        box = outline_of(plan, run, sample, other)
        foot = path_project(plan.road, path, box.x, box.y)
        heading = path_pose(plan.road, path, foot).heading
        cos, sin = math.cos(heading), math.sin(heading)
        aside = path_distance(plan.road, path, box.x, box.y)
        if foot > start and aside < 0.5 * mine.width + shadow(box, -sin, cos):
            between = max(0.0, foot - shadow(box, cos, sin) - front)
            if between < gap:
                gap, speed = between, run.states[sample, other, State.SPEED] * math.cos(box.heading - heading)
    return Leader(gap, speed)


@kernel
def least_time_to_collision(plan: Plan, run: Run, sample: int, one: int, other: int) -> float:
    """`conflict.time_to_collision` of two actors [s], or (`other` = -1) the least over all others; infinite for those
    who are absent. What comes is unknown yet, so yaw rates are those of the step that ended at the sample.
    """
    least = math.inf
    if run.states[sample, one, State.PRESENT] == 0.0:
        return least
    for each in range(run.states.shape[1]):
        asked = each != one and (other < 0 or each == other)
        if asked and run.states[sample, each, State.PRESENT] != 0.0:
            least = min(least, time_to_collision(_pair(plan, run, sample, one, each)))
    return least


@inlined
def _pair(plan: Plan, run: Run, sample: int, one: int, other: int) -> Snapshot:
    first: Box = outline_of(plan, run, sample, one)
    return Snapshot(
        first, outline_of(plan, run, sample, other), _rate(plan, run, sample, one), _rate(plan, run, sample, other)
    )


@inlined
def _rate(plan: Plan, run: Run, sample: int, actor: int) -> Rate:
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    return center_velocity(run.states, sample + 1, sample, plan.layout.time_step, actor, to_center)
