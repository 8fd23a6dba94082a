"""The instructions by which a behavior reads about other actors: sight, the leader along a path, times to contact.

Each function executes the instruction of a row at the current sample. A program without the instruction does not wait
for its compilation.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from engine.kernels.conflict import Snapshot, shadow, time_to_collision
from engine.kernels.crossing import foresee
from engine.kernels.evaluate import has_nan, operand
from engine.kernels.geometry import Box, View
from engine.kernels.impacts.motion import spin_of, velocity_of
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.levels import enter_level, has_levels
from engine.kernels.noticing import can_see, notices, sees_within, view_of, visibility_past
from engine.kernels.pair import Rate, center_velocity
from engine.kernels.path import path_distance, path_pose, path_project
from engine.kernels.random_numbers import ATTEMPT_CHANNEL, open_stream, uniform
from engine.kernels.replay import follow_track, move_along_track
from engine.kernels.run_state import (
    NO_OFFSET,
    Memory,
    Plan,
    Run,
    Status,
    column_of,
    current_sample,
    on_one_level,
    outline_of,
    place,
)
from engine.kernels.sight import SEEN
from engine.opcodes import Op
from engine.tables import SLIDING
from engine.vocabulary import Column, Purpose, State


@deferred()
def draw_number(run: Run, register: int) -> None:
    """Execute `Op.RANDOM`: the next uniform number of the behavior stream of the scene."""
    number = run.status[Status.DRAWS]
    run.status[Status.DRAWS] = number + 1
    run.registers[register] = uniform(open_stream(run.key, Purpose.BEHAVIOUR, ATTEMPT_CHANNEL), number)


@deferred()
def appear(plan: Plan, run: Run, actor: int) -> None:
    """Execute `Op.SPAWN`: place an absent actor at its pose in the scene."""
    if run.states[current_sample(run), actor, State.PRESENT] == 0.0:
        place(plan, run, current_sample(run), actor, 1.0)
        if has_levels(plan):
            enter_level(plan, run, current_sample(run), actor)
        run.status[Status.SHADED] = -1


@deferred()
def read_velocity(plan: Plan, run: Run, row: int) -> None:
    """Execute `Op.VELOCITY`."""
    dst, actor = operand(plan.code, row, 1), operand(plan.code, row, 2)
    run.registers[dst], run.registers[dst + 1] = velocity_of(run, current_sample(run), actor)
    run.registers[dst + 2] = spin_of(plan, run, current_sample(run), actor)


# -- sight -------------------------------------------------------------------------------------------------------------


@deferred()
def see_within(plan: Plan, run: Run, row: int) -> None:
    """Execute `Op.WITHIN`."""
    actor, distance = operand(plan.code, row, 2), run.registers[operand(plan.code, row, 3)]
    sees = sees_within(plan, run, current_sample(run), actor, distance)
    run.registers[operand(plan.code, row, 1)] = math.nan if math.isnan(distance) else 1.0 if sees else 0.0


@deferred()
def see(plan: Plan, run: Run, row: int) -> None:
    """Execute `Op.SEES`."""
    viewer, target = operand(plan.code, row, 2), operand(plan.code, row, 3)
    if viewer >= 0 and target >= 0:
        sees = can_see(plan, run, current_sample(run), viewer, target)
    else:
        sees = _sees_place(plan, run, current_sample(run), row)
    unknown = (viewer < 0 and has_nan(run.registers, operand(plan.code, row, 4), 5)) or (
        target < 0 and has_nan(run.registers, operand(plan.code, row, 5), 5)
    )
    run.registers[operand(plan.code, row, 1)] = math.nan if unknown else 1.0 if sees else 0.0


@deferred()
def notice(plan: Plan, run: Run, row: int) -> None:
    """Execute `Op.NOTICES`."""
    viewer, target = operand(plan.code, row, 2), operand(plan.code, row, 3)
    reach = run.registers[operand(plan.code, row, 4)]
    run.registers[operand(plan.code, row, 1)] = (
        1.0 if notices(plan, run, current_sample(run), viewer, target, reach) else 0.0
    )


@kernel
def _sees_place(plan: Plan, run: Run, sample: int, row: int) -> bool:
    """Return the result of `Op.SEES` if the viewer or the target is a place."""
    code, registers = plan.code, run.registers
    viewer, target, at, there = (
        operand(code, row, 2),
        operand(code, row, 3),
        operand(code, row, 4),
        operand(code, row, 5),
    )
    for actor in (viewer, target):
        if actor >= 0 and run.states[sample, actor, State.PRESENT] == 0.0:
            return False
    if viewer >= 0:
        view = view_of(plan, run, sample, viewer)
    else:
        view = View(registers[at], registers[at + 1], registers[at + 2], registers[at + 3], registers[at + 4])
    if target >= 0:
        box = outline_of(plan, run, sample, target)
    else:
        box = Box(
            registers[there], registers[there + 1], registers[there + 2], registers[there + 3], registers[there + 4]
        )
    return bool(visibility_past(plan, run, sample, view, box, viewer, target) == SEEN)


# -- the actor ahead, and times to contact -----------------------------------------------------------------------------


class Leader(NamedTuple):
    """The actor ahead on a path: the gap to it along the path [m] and its speed along the path [m/s]."""

    gap: float
    speed: float


@kernel
def leader(plan: Plan, run: Run, sample: int, me: int, path: int, reach: float) -> Leader:
    """Return the nearest actor ahead of `me` on a path; infinity and 0 with no actor ahead.

    An actor is on the path if it overlaps the strip that my width sweeps along it (if I follow it at an offset: from my
    place to that offset), and ahead if its centre's foot point
    is beyond mine. An actor that is hidden from me, or beyond `reach`, does not count. The gap is measured along the
    path between the projections of both outlines on its direction at their foot points, and is 0 if these overlap.
    """
    mine = outline_of(plan, run, sample, me)
    start = path_project(plan.road, path, mine.x, mine.y)
    place = path_pose(plan.road, path, start)
    front = start + shadow(mine, math.cos(place.heading), math.sin(place.heading))
    wanted = run.actors[me, Memory.ASIDE]
    left, reach_aside = 0.0, 0.5 * mine.width
    if wanted != NO_OFFSET:
        now = (mine.y - place.y) * math.cos(place.heading) - (mine.x - place.x) * math.sin(place.heading)
        left, reach_aside = 0.5 * (now + wanted), reach_aside + 0.5 * abs(now - wanted)
    gap, speed = math.inf, 0.0
    for other in range(run.states.shape[1]):
        if other == me or run.states[sample, other, State.PRESENT] == 0.0:
            continue
        box = outline_of(plan, run, sample, other)
        foot = path_project(plan.road, path, box.x, box.y)
        there = path_pose(plan.road, path, foot)
        heading = there.heading
        cos, sin = math.cos(heading), math.sin(heading)
        aside = path_distance(plan.road, path, box.x, box.y)
        if left != 0.0:
            aside = abs((box.y - there.y) * cos - (box.x - there.x) * sin - left)
        if foot > start and aside < reach_aside + shadow(box, -sin, cos):
            between = max(0.0, foot - shadow(box, cos, sin) - front)
            if between < gap and notices(plan, run, sample, me, other, reach):
                gap, speed = between, run.states[sample, other, State.SPEED] * math.cos(box.heading - heading)
                if run.states[sample, other, State.PRESENT] == SLIDING:
                    rate = velocity_of(run, sample, other)
                    speed = rate.x * cos + rate.y * sin
    return Leader(gap, speed)


@deferred()
def find_leader(plan: Plan, run: Run, row: int) -> None:
    """Execute `Op.LEAD`."""
    dst, actor, path = (
        operand(plan.code, row, 1),
        operand(plan.code, row, 2),
        int(run.registers[operand(plan.code, row, 3)]),
    )
    reach = run.registers[operand(plan.code, row, 4)]
    run.registers[dst], run.registers[dst + 1] = leader(plan, run, current_sample(run), actor, path, reach)


@deferred()
def foresee_contact(plan: Plan, run: Run, row: int) -> None:
    """Execute `Op.TTC`."""
    one, other = operand(plan.code, row, 2), operand(plan.code, row, 3)
    reach = run.registers[operand(plan.code, row, 5)] if operand(plan.code, row, 4) != 0 else -1.0
    run.registers[operand(plan.code, row, 1)] = least_time_to_collision(
        plan, run, current_sample(run), one, other, reach
    )


@kernel
def least_time_to_collision(plan: Plan, run: Run, sample: int, one: int, other: int, reach: float) -> float:
    """Return `conflict.time_to_collision` of two actors [s], or (`other` = -1) the least over all others; infinite for
    absent actors, and, unless `reach` is negative, for actors hidden from `one` or beyond that reach. Later samples are
    unknown, so yaw rates are those of the step that ended at the sample.
    """
    least = math.inf
    if run.states[sample, one, State.PRESENT] == 0.0:
        return least
    for each in range(run.states.shape[1]):
        asked = each != one and (other < 0 or each == other)
        if asked and run.states[sample, each, State.PRESENT] != 0.0 and on_one_level(run, one, each):
            time = time_to_collision(_pair(plan, run, sample, one, each))
            if time < least and (reach < 0.0 or notices(plan, run, sample, one, each, reach)):
                least = time
    return least


@inlined
def _pair(plan: Plan, run: Run, sample: int, one: int, other: int) -> Snapshot:
    first: Box = outline_of(plan, run, sample, one)
    return Snapshot(
        first, outline_of(plan, run, sample, other), _rate(plan, run, sample, one), _rate(plan, run, sample, other)
    )


@inlined
def _rate(plan: Plan, run: Run, sample: int, actor: int) -> Rate:
    """Return the velocity of an outline's centre; for a sliding body at the end of its segment, as no later sample
    exists.
    """
    if run.states[sample, actor, State.PRESENT] == SLIDING:
        return velocity_of(run, sample, actor)
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    return center_velocity(run.states, sample + 1, sample, plan.layout.time_step, actor, to_center)


DEFERRED: dict[Op, tuple[Callable[..., Any], ...]] = {
    Op.RANDOM: (draw_number,),
    Op.WITHIN: (see_within,),
    Op.LEAD: (find_leader,),
    Op.TTC: (foresee_contact,),
    Op.SEES: (see,),
    Op.NOTICES: (notice,),
    Op.VELOCITY: (read_velocity,),
    Op.CROSSING: (foresee,),
    Op.REPLAY: (follow_track, move_along_track),
    Op.SPAWN: (appear,),
}
"""The kernels that a program with an instruction needs."""
