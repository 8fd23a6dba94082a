"""The interpreter of step code: one turn of an actor or monitor, or one look at a rule, at the current sample.

Behaviours are coroutines made of blocks. A block is a stretch of code with a resume row of its own, -1 while it is not
running; `YIELD` ends the turn and notes where its block goes on. A `try` is a row that each turn comes back to: it
asks its handlers, last one first, whether they are running or should start, and resumes the first that is, else the
body. Nothing here sees the effect of what another actor does in the same sample: states are those of the sample,
commands take effect in the step that follows.

What a behaviour may read about the other actors is here too: the leader along a path, and how soon outlines would
touch.
"""

import math
from typing import NamedTuple

from engine.kernels.conflict import Snapshot, shadow, time_to_collision
from engine.kernels.crossing import foresee
from engine.kernels.evaluate import evaluate
from engine.kernels.geometry import Box, View
from engine.kernels.jit import inlined, kernel, shared
from engine.kernels.legs import spin_of, velocity_of
from engine.kernels.noticing import can_see, look_past, notices, sees_within, view_of
from engine.kernels.pair import Rate, center_velocity
from engine.kernels.path import PathPoint, path_distance, path_pose, path_project, path_project_near
from engine.kernels.random_numbers import ATTEMPT_CHANNEL, open_stream, uniform
from engine.kernels.region import region_contains
from engine.kernels.replay import follow_track
from engine.kernels.sight import SEEN
from engine.kernels.stage import Plan, Run, Slot, Status, column_of, outline_of, place
from engine.kernels.steering import pedals_towards, planned_speed, steer_along, turn_along
from engine.opcodes import Op
from engine.tables import ROAD_REGION, SLIDING
from engine.vocabulary import ActorKind, Column, Command, Purpose, State

# -- the others around -------------------------------------------------------------------------------------------------


class Leader(NamedTuple):
    """The actor ahead on a path: the gap to it along the path [m] and its speed along the path [m/s]."""

    gap: float
    speed: float


@kernel
def leader(plan: Plan, run: Run, sample: int, me: int, path: int, reach: float) -> Leader:
    """Return the nearest actor ahead of `me` on a path; infinity and 0 with no actor ahead.

    An actor is on the path if it reaches into the strip that my width sweeps along it, and ahead if its centre's foot
    point lies beyond mine. One that is hidden from me, or beyond
    `reach`, does not count. The gap is measured along the path between the
    shadows of both outlines on its direction at their foot points, and is 0 where these overlap.
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
            if between < gap and notices(plan, run, sample, me, other, reach):
                gap, speed = between, run.states[sample, other, State.SPEED] * math.cos(box.heading - heading)
                if run.states[sample, other, State.PRESENT] == SLIDING:
                    rate = velocity_of(run, sample, other)
                    speed = rate.x * cos + rate.y * sin
    return Leader(gap, speed)


@kernel
def least_time_to_collision(plan: Plan, run: Run, sample: int, one: int, other: int, reach: float) -> float:
    """`conflict.time_to_collision` of two actors [s], or (`other` = -1) the least over all others; infinite for those
    that are absent, and, unless `reach` is negative, for those that are hidden from `one` or beyond that reach. What
    comes is unknown yet, so yaw rates are those of the step that ended at the sample.
    """
    least = math.inf
    if run.states[sample, one, State.PRESENT] == 0.0:
        return least
    for each in range(run.states.shape[1]):
        asked = each != one and (other < 0 or each == other)
        if asked and run.states[sample, each, State.PRESENT] != 0.0:
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
    """Of the outline's centre; of a body that slides, at the end of its leg, as the record has no later sample yet."""
    if run.states[sample, actor, State.PRESENT] == SLIDING:
        return velocity_of(run, sample, actor)
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    return center_velocity(run.states, sample + 1, sample, plan.layout.time_step, actor, to_center)


# -- the interpreter ---------------------------------------------------------------------------------------------------

END_OF_ROAD = 0.01
"""A path ends with the road where there is road so far before its end, and none so far behind it [m]."""
YIELDED, HALTED, RULE_TRIGGERED, SEGMENT_ENDED, OUT_OF_BUDGET = range(5)
"""How a turn ended."""
COMMANDED = tuple(
    int(slot)
    for slot in (
        Slot.THROTTLE, Slot.BRAKE, Slot.STEER, Slot.SET_SPEED, Slot.REVERSE, Slot.OFFSET, Slot.STOP, Slot.REVERSE,
    )
)  # fmt: skip
"""What each `Command` sets."""


class Turn(NamedTuple):
    """How a turn ended, and for a rule its number, out of budget the row."""

    signal: int
    detail: int


@inlined
def interpret(plan: Plan, run: Run, actor: int, row: int) -> Turn:
    """Run step code from a row on until the turn is over. Inlined into its caller: call it in one place.

    `actor` is the actor whose turn it is; it has no meaning for rules and monitors, whose code sets no commands.
    """
    code, registers = plan.code, run.registers
    run.status[Status.TURN], run.status[Status.ARRIVALS] = actor, 0
    signal, detail = OUT_OF_BUDGET, -1
    for _ in range(plan.layout.budget):
        op, dst, a, b = int(code[row, 0]), int(code[row, 1]), int(code[row, 2]), int(code[row, 3])
        row += 1
        if op < Op.STATE:
            evaluate(op, dst, a, b, int(code[row - 1, 4]), registers, plan.pool, plan.road)
        elif op == Op.STATE:
            registers[dst] = run.states[_now(run), a, b]
        elif op == Op.TIME:
            registers[dst] = _now(run) * plan.layout.time_step
        elif op == Op.RANDOM:
            registers[dst] = _draw(run)
        elif op == Op.WITHIN:
            registers[dst] = 1.0 if sees_within(plan, run, _now(run), a, registers[b]) else 0.0
        elif op == Op.LEAD:
            reach = registers[int(code[row - 1, 4])]
            registers[dst], registers[dst + 1] = leader(plan, run, _now(run), a, int(registers[b]), reach)
        elif op == Op.TTC:
            registers[dst] = least_time_to_collision(plan, run, _now(run), a, b, _reach(plan, run, row - 1))
        elif op == Op.SEES:
            actors = a >= 0 and b >= 0
            sees = can_see(plan, run, _now(run), a, b) if actors else _sees_place(plan, run, _now(run), row - 1)
            registers[dst] = 1.0 if sees else 0.0
        elif op == Op.NOTICES:
            registers[dst] = 1.0 if notices(plan, run, _now(run), a, b, registers[int(code[row - 1, 4])]) else 0.0
        elif op == Op.VELOCITY:
            registers[dst], registers[dst + 1] = velocity_of(run, _now(run), a)
            registers[dst + 2] = spin_of(plan, run, _now(run), a)
        elif op == Op.TOUCHES:
            touched = run.status[Status.CONTACT_ONE] >= 0
            registers[dst] = 1.0 if touched and (a < 0 or a == run.status[Status.CONTACT_OTHER]) else 0.0
        elif op == Op.ACTION:
            registers[dst] = run.actions[_now(run) // plan.layout.hold, a]
        elif op == Op.CROSSING:
            foresee(plan, run, _now(run), row - 1)
        elif op == Op.IS_RUNNING:
            registers[dst] = 1.0 if run.resume[a] >= 0 else 0.0
        elif op == Op.JUMP:
            row = a
        elif op == Op.JUMP_UNLESS:
            if not abs(registers[a]) > 0.0:  # NaN is not true
                row = b
        elif op == Op.JUMP_IF_RUNNING:
            if run.resume[a] >= 0:
                row = b
        elif op == Op.SET_RESUME:
            run.resume[a] = b
        elif op == Op.RESUME:
            row = int(run.resume[a])
        elif op == Op.YIELD:
            run.resume[a] = row
            signal = YIELDED
            break
        elif op == Op.COMMAND:
            _command(run, _me(run), a, registers[b])
        elif op == Op.FOLLOW:
            if _follow(plan, run, _now(run), _me(run), row - 1):
                row = int(code[row - 1, 5])
                run.status[Status.ARRIVALS] += 1
        elif op == Op.REPLAY:
            if follow_track(plan, run, _me(run), row - 1):
                row = int(code[row - 1, 4])
                run.status[Status.ARRIVALS] += 1
        elif op == Op.HOLD_SPEED:
            _hold_speed(plan, run, _now(run), _me(run), registers[a])
        elif op == Op.TERMINATE:
            signal, detail = RULE_TRIGGERED, a
            break
        elif op == Op.HALT:
            signal = HALTED
            break
        elif op == Op.SPAWN:
            if run.states[_now(run), a, State.PRESENT] == 0.0:
                place(plan, run, _now(run), a, 1.0)
                run.status[Status.SHADED] = -1
        else:
            signal = SEGMENT_ENDED
            break
    if signal == OUT_OF_BUDGET and run.status[Status.ARRIVALS] > 1:  # at the end of a way, round and round
        signal = HALTED
    return Turn(signal, row if signal == OUT_OF_BUDGET else detail)


@inlined
def _now(run: Run) -> int:
    """The current sample. Instructions read it from memory, and whose turn it is: of variables the compiler would work
    out before each turn all that any instruction might make of them.
    """
    return int(run.status[Status.SAMPLE])


@inlined
def _me(run: Run) -> int:
    return int(run.status[Status.TURN])


@inlined
def _draw(run: Run) -> float:
    """The next uniform number of the scene's behaviour stream."""
    number = run.status[Status.DRAWS]
    run.status[Status.DRAWS] = number + 1
    return uniform(open_stream(run.key, Purpose.BEHAVIOUR, ATTEMPT_CHANNEL), number)


@inlined
def _reach(plan: Plan, run: Run, row: int) -> float:
    """Of `Op.TTC`: how far those are noticed that count, or -1 where all do."""
    return run.registers[int(plan.code[row, 5])] if plan.code[row, 4] != 0 else -1.0


@shared
def _sees_place(plan: Plan, run: Run, sample: int, row: int) -> bool:
    """`Op.SEES` where the viewer or what it looks at is a place."""
    code, registers = plan.code, run.registers
    viewer, target, at, there = int(code[row, 2]), int(code[row, 3]), int(code[row, 4]), int(code[row, 5])
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
    return bool(look_past(plan, run, sample, view, box, viewer, target) == SEEN)


@inlined
def _command(run: Run, actor: int, command: int, value: float) -> None:
    kept = (1.0 if abs(value) > 0.0 else 0.0) if command == Command.REVERSE else value  # NaN is not true
    run.actors[actor, COMMANDED[command]] = kept


@inlined
def _follow(plan: Plan, run: Run, sample: int, actor: int, row: int) -> bool:
    """Steer and pedal along a path; true when the actor has come to its end, and nothing is commanded."""
    progress, path = int(plan.code[row, 1]), int(run.registers[int(plan.code[row, 2])])
    target_speed, max_lateral = run.registers[int(plan.code[row, 3])], run.registers[int(plan.code[row, 4])]
    x, y = run.actors[actor, Slot.REAR_X], run.actors[actor, Slot.REAR_Y]
    heading, speed = run.states[sample, actor, State.HEADING], run.states[sample, actor, State.SPEED]
    guess = run.registers[progress]
    if not guess >= 0.0:
        guess = path_project(plan.road, path, x, y)
    point = path_project_near(plan.road, path, x, y, guess)
    run.registers[progress] = point.s
    run.actors[actor, Slot.PATH] = path + 1.0
    if _arrives(plan, run, sample, actor, path, plan.road.path_length[path] - point.s):
        run.actors[actor, Slot.ROUTE_DONE] = 1.0
        return True
    run.actors[actor, Slot.ROUTE_DONE] = 0.0
    point = PathPoint(point.s, point.offset - run.actors[actor, Slot.OFFSET], point.heading, point.curvature)
    if plan.kinds[actor] == ActorKind.PEDESTRIAN:
        run.actors[actor, Slot.STEER] = turn_along(point, heading)
        _hold_speed(plan, run, sample, actor, target_speed)
        return False
    wheelbase = column_of(plan, run, actor, Column.WHEELBASE)
    time_step = plan.layout.time_step * plan.layout.hold
    run.actors[actor, Slot.STEER] = steer_along(plan.road, path, point, heading, speed, wheelbase, time_step)
    target = planned_speed(plan.road, path, point.s, speed, target_speed, max_lateral)
    _hold_speed(plan, run, sample, actor, target)
    return False


@inlined
def _arrives(plan: Plan, run: Run, sample: int, actor: int, path: int, left: float) -> bool:
    """Whether an actor whose rear axle has so far to go [m] has come to the end of its path: with its centre, or, where
    the road ends too, so near that its outline would pass the end before its next turn.
    """
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    if left <= to_center:
        return True
    length, width = column_of(plan, run, actor, Column.LENGTH), column_of(plan, run, actor, Column.WIDTH)
    step, speed = plan.layout.time_step * plan.layout.hold, run.states[sample, actor, State.SPEED]
    way = (speed + 0.5 * column_of(plan, run, actor, Column.MAX_ACCELERATION) * step) * step
    if left > to_center + 0.5 * (length + width) + way:
        return False
    return plan.kinds[actor] != ActorKind.PEDESTRIAN and _passes_end(plan, run, sample, actor, path, left - way)


@kernel
def _passes_end(plan: Plan, run: Run, sample: int, actor: int, path: int, left: float) -> bool:
    """Whether a path ends with the road, and an outline whose rear axle has so far to go reaches beyond."""
    end = path_pose(plan.road, path, plan.road.path_length[path])
    cos, sin = math.cos(end.heading), math.sin(end.heading)
    inside = region_contains(plan.road, ROAD_REGION, end.x - END_OF_ROAD * cos, end.y - END_OF_ROAD * sin)
    if not inside or region_contains(plan.road, ROAD_REGION, end.x + END_OF_ROAD * cos, end.y + END_OF_ROAD * sin):
        return False
    front = column_of(plan, run, actor, Column.REAR_TO_CENTER) + shadow(outline_of(plan, run, sample, actor), cos, sin)
    return front > left


@inlined
def _hold_speed(plan: Plan, run: Run, sample: int, actor: int, target_speed: float) -> None:
    max_acceleration = column_of(plan, run, actor, Column.MAX_ACCELERATION)
    max_braking = column_of(plan, run, actor, Column.MAX_BRAKING)
    speed = run.states[sample, actor, State.SPEED]
    pedals = pedals_towards(target_speed, speed, max_acceleration, max_braking)
    run.actors[actor, Slot.THROTTLE] = pedals.throttle
    run.actors[actor, Slot.BRAKE] = pedals.brake
    run.actors[actor, Slot.REVERSE] = 0.0  # target speeds are forward
