"""The interpreter of step code: one turn of an actor or monitor, or one look at a rule, at the current sample.

Behaviours are coroutines made of blocks. A block is a stretch of code with a resume row of its own, -1 while it is not
running; `YIELD` ends the turn and notes where its block goes on. A `try` is a row that each turn comes back to: it
asks its handlers, last one first, whether they are running or should start, and resumes the first that is, else the
body. Nothing here sees the effect of what another actor does in the same sample: states are those of the sample,
commands take effect in the step that follows. Instructions that read about other actors are in `kernels.senses`.
"""

import math
from typing import NamedTuple

from engine.kernels.conflict import shadow
from engine.kernels.crossing import foresee
from engine.kernels.evaluate import evaluate
from engine.kernels.jit import inlined, kernel
from engine.kernels.path import PathPoint, path_pose, path_project, path_project_near
from engine.kernels.region import region_contains
from engine.kernels.replay import follow_track
from engine.kernels.run_state import Memory, Plan, Run, Status, column_of, outline_of
from engine.kernels.senses import (
    appear,
    draw_number,
    find_leader,
    foresee_contact,
    notice,
    read_velocity,
    see,
    see_within,
)
from engine.kernels.steering import pedals_towards, planned_speed, steer_along, turn_along
from engine.opcodes import Op
from engine.tables import ROAD_REGION
from engine.vocabulary import ActorKind, Column, Command, State

# -- the interpreter ---------------------------------------------------------------------------------------------------

END_OF_ROAD = 0.01
"""A path ends with the road where there is road so far before its end, and none so far behind it [m]."""
YIELDED, HALTED, RULE_TRIGGERED, SEGMENT_ENDED, OUT_OF_BUDGET = range(5)
"""How a turn ended."""
COMMANDED = tuple(
    int(column)
    for column in (
        Memory.THROTTLE,
        Memory.BRAKE,
        Memory.STEER,
        Memory.SET_SPEED,
        Memory.REVERSE,
        Memory.OFFSET,
        Memory.STOP,
        Memory.REVERSE,
    )
)
"""Column of `Memory` that each `Command` sets."""


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
            draw_number(run, dst)
        elif op == Op.WITHIN:
            see_within(plan, run, row - 1)
        elif op == Op.LEAD:
            find_leader(plan, run, row - 1)
        elif op == Op.TTC:
            foresee_contact(plan, run, row - 1)
        elif op == Op.SEES:
            see(plan, run, row - 1)
        elif op == Op.NOTICES:
            notice(plan, run, row - 1)
        elif op == Op.VELOCITY:
            read_velocity(plan, run, row - 1)
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
            appear(plan, run, a)
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
def _command(run: Run, actor: int, command: int, value: float) -> None:
    kept = (1.0 if abs(value) > 0.0 else 0.0) if command == Command.REVERSE else value  # NaN is not true
    run.actors[actor, COMMANDED[command]] = kept


@inlined
def _follow(plan: Plan, run: Run, sample: int, actor: int, row: int) -> bool:
    """Steer and pedal along a path; true when the actor has come to its end, and nothing is commanded."""
    progress, path = int(plan.code[row, 1]), int(run.registers[int(plan.code[row, 2])])
    target_speed, max_lateral = run.registers[int(plan.code[row, 3])], run.registers[int(plan.code[row, 4])]
    x, y = run.actors[actor, Memory.REAR_X], run.actors[actor, Memory.REAR_Y]
    heading, speed = run.states[sample, actor, State.HEADING], run.states[sample, actor, State.SPEED]
    guess = run.registers[progress]
    if not guess >= 0.0:
        guess = path_project(plan.road, path, x, y)
    point = path_project_near(plan.road, path, x, y, guess)
    run.registers[progress] = point.s
    run.actors[actor, Memory.PATH] = path + 1.0
    if _arrives(plan, run, sample, actor, path, plan.road.path_length[path] - point.s):
        run.actors[actor, Memory.ROUTE_DONE] = 1.0
        return True
    run.actors[actor, Memory.ROUTE_DONE] = 0.0
    point = PathPoint(point.s, point.offset - run.actors[actor, Memory.OFFSET], point.heading, point.curvature)
    if plan.kinds[actor] == ActorKind.PEDESTRIAN:
        run.actors[actor, Memory.STEER] = turn_along(point, heading)
        _hold_speed(plan, run, sample, actor, target_speed)
        return False
    wheelbase = column_of(plan, run, actor, Column.WHEELBASE)
    time_step = plan.layout.time_step * plan.layout.hold
    run.actors[actor, Memory.STEER] = steer_along(plan.road, path, point, heading, speed, wheelbase, time_step)
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
    run.actors[actor, Memory.THROTTLE] = pedals.throttle
    run.actors[actor, Memory.BRAKE] = pedals.brake
    run.actors[actor, Memory.REVERSE] = 0.0  # target speeds are forward
