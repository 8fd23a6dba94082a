"""The interpreter of step code: a turn of an actor or monitor, or the evaluation of a rule, at the current sample.

Behaviours are coroutines made of blocks. A block is a stretch of code with its own resume row, -1 while it is not
running; `YIELD` ends the turn and stores the row at which its block continues. A `try` is a row to which each turn
returns: it tests its handlers from last to first, whether they are running or should start, and resumes the first such
handler, else the body. Nothing here sees the effect of another actor's action in the same sample: states are those of
the sample, commands take effect in the following step. Instructions that read about other actors are in
`kernels.senses`.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.kernels.conflict import shadow
from engine.kernels.crossing import foresee
from engine.kernels.evaluate import SCALARS, evaluate, operand
from engine.kernels.jit import inlined, kernel
from engine.kernels.path import PathPoint, path_pose, path_project, path_project_near
from engine.kernels.region import region_contains
from engine.kernels.replay import follow_track
from engine.kernels.run_state import NO_OFFSET, Memory, Plan, Run, Status, column_of, current_sample, outline_of
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
from engine.kernels.steering import (
    LEAST_ROOM,
    Curve,
    begin_curve,
    curve_at,
    pedals_towards,
    planned_speed,
    steer_along,
    steer_beside,
    turn_along,
)
from engine.opcodes import Fused, Op
from engine.tables import ROAD_REGION, Floats, Ints
from engine.vocabulary import ActorKind, Column, Command, State

# -- the interpreter ---------------------------------------------------------------------------------------------------

END_OF_ROAD = 0.01
"""Distance before and after a path's end [m]: the road ends there if only the first point is on the road."""
YIELDED, HALTED, RULE_TRIGGERED, SEGMENT_ENDED, OUT_OF_BUDGET, UNDEFINED = range(6)
"""End of a turn; `UNDEFINED`: at a condition that is NaN."""
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
        Memory.ASIDE,
    )
)
"""Column of `Memory` that each `Command` sets."""
subtract, hypot, less = (SCALARS[op] for op in (Op.SUB, Op.HYPOT, Op.LT))


class Turn(NamedTuple):
    """End of a turn, with the number of a rule, or the row if the budget is exhausted."""

    signal: int
    detail: int


@inlined
def interpret(plan: Plan, run: Run, actor: int, row: int) -> Turn:
    """Run step code from a row until the turn is over. Inlined into its caller: call it in one place.

    Instructions are counted at jumps and at the end of the turn, a fused one as those that it stands for.

    `actor` is the actor whose turn it is; it has no meaning for rules and monitors, whose code sets no commands.
    """
    code, registers = plan.code, run.registers
    run.status[Status.TURN], run.status[Status.ARRIVALS] = actor, 0
    left, first, detail = plan.layout.budget, row, -1
    while True:
        op, dst, a, b = operand(code, row, 0), operand(code, row, 1), operand(code, row, 2), operand(code, row, 3)
        row += 1
        target = -1
        if op < Op.STATE:
            evaluate(code, row - 1, registers, plan.pool, plan.road)
        elif op == Op.STATE:
            _read_state(run, code, row - 1)
        elif op == Op.TIME:
            registers[np.uintp(dst)] = current_sample(run) * plan.layout.time_step
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
            registers[dst] = run.actions[current_sample(run) // plan.layout.hold, a]
        elif op == Op.CROSSING:
            foresee(plan, run, current_sample(run), row - 1)
        elif op == Op.IS_RUNNING:
            registers[np.uintp(dst)] = 1.0 if run.resume[np.uintp(a)] >= 0 else 0.0
        elif op == Op.JUMP:
            target = a
        elif op == Op.JUMP_UNLESS:
            if registers[np.uintp(a)] == 0.0:
                target = b
            elif math.isnan(registers[np.uintp(a)]):
                signal = UNDEFINED
                break
        elif op == Op.JUMP_IF_FALSE:
            if registers[np.uintp(a)] == 0.0:
                target = b
        elif op == Op.JUMP_IF_RUNNING:
            if run.resume[np.uintp(a)] >= 0:
                target = b
        elif op == Op.SET_RESUME:
            run.resume[np.uintp(a)] = b
        elif op == Op.RESUME:
            target = int(run.resume[np.uintp(a)])
        elif op == Op.YIELD:
            run.resume[np.uintp(a)] = row
            signal = YIELDED
            break
        elif op == Op.COMMAND:
            if a == Command.REVERSE and math.isnan(registers[b]):
                signal = UNDEFINED
                break
            _command(run, _me(run), a, registers[b])
        elif op == Op.FOLLOW or op == Fused.FOLLOW_ON:
            if _follow(plan, run, current_sample(run), _me(run), row - 1):
                target = operand(code, row - 1, 5)
                run.status[Status.ARRIVALS] += 1
            elif op == Fused.FOLLOW_ON:
                row += 1
                run.resume[np.uintp(operand(code, row - 1, 2))] = row
                signal = YIELDED
                break
        elif op == Op.REPLAY:
            if follow_track(plan, run, _me(run), row - 1):
                target = operand(code, row - 1, 4)
                run.status[Status.ARRIVALS] += 1
        elif op == Op.HOLD_SPEED:
            _hold_speed(plan, run, current_sample(run), _me(run), registers[a])
        elif op == Op.TERMINATE:
            signal, detail = RULE_TRIGGERED, a
            break
        elif op == Op.HALT:
            signal = HALTED
            break
        elif op == Op.SPAWN:
            appear(plan, run, a)
        elif op == Fused.HANDLE:
            if run.resume[np.uintp(a)] >= 0:
                target = b
            else:
                see_within(plan, run, row)
                row += 2
                holds = registers[np.uintp(operand(code, row - 1, 2))]
                if holds == 0.0:
                    target = operand(code, row - 1, 3)
                elif math.isnan(holds):
                    signal = UNDEFINED
                    break
        elif op == Fused.IS_FAR or op == Fused.ARE_FAR:
            row = _compare_distance(run, code, row - 1, 1 if op == Fused.IS_FAR else 2)
            if operand(code, row, 0) == Op.END:
                row += 1
                signal = SEGMENT_ENDED
                break
        else:
            signal = SEGMENT_ENDED
            break
        if target >= 0:
            left -= row - first
            if left <= 0:
                row = target if left == 0 else row + left
                signal = OUT_OF_BUDGET
                break
            row = first = target
    if signal != OUT_OF_BUDGET and row - first > left:
        signal, row = OUT_OF_BUDGET, first + left
    if signal == OUT_OF_BUDGET and run.status[Status.ARRIVALS] > 1:  # it arrives at the end of a path again and again
        signal = HALTED
    return Turn(signal, row if signal == OUT_OF_BUDGET else detail)


@inlined
def _read_state(run: Run, code: Ints, row: int) -> None:
    """Execute `Op.STATE`."""
    value = run.states[current_sample(run), np.uintp(operand(code, row, 2)), np.uintp(operand(code, row, 3))]
    run.registers[np.uintp(operand(code, row, 1))] = value


@inlined
def _numbers(registers: Floats, code: Ints, row: int) -> tuple[float, float]:
    """Return the operands of a scalar instruction."""
    return registers[np.uintp(operand(code, row, 2))], registers[np.uintp(operand(code, row, 3))]


@inlined
def _compare_distance(run: Run, code: Ints, row: int, actors: int) -> int:
    """Execute `Fused.IS_FAR` (1 actor) or `Fused.ARE_FAR` (2 actors) from a row on; return the row after it."""
    registers = run.registers
    for _ in range(2):
        for _ in range(actors):
            _read_state(run, code, row)
            row += 1
        x, y = _numbers(registers, code, row)
        registers[np.uintp(operand(code, row, 1))] = subtract(x, y)
        row += 1
    x, y = _numbers(registers, code, row)
    registers[np.uintp(operand(code, row, 1))] = hypot(x, y)
    x, y = _numbers(registers, code, row + 1)
    registers[np.uintp(operand(code, row + 1, 1))] = less(x, y)
    return row + 2


@inlined
def _me(run: Run) -> int:
    return int(run.status[Status.TURN])


@inlined
def _command(run: Run, actor: int, command: int, value: float) -> None:
    kept = (1.0 if value != 0.0 else 0.0) if command == Command.REVERSE else value
    run.actors[actor, COMMANDED[command]] = kept


@inlined
def _follow(plan: Plan, run: Run, sample: int, actor: int, row: int) -> bool:
    """Steer and pedal along a path; true when the actor has come to its end, and nothing is commanded."""
    progress, path = operand(plan.code, row, 1), int(run.registers[operand(plan.code, row, 2)])
    target_speed, max_lateral = run.registers[operand(plan.code, row, 3)], run.registers[operand(plan.code, row, 4)]
    x, y = run.actors[actor, Memory.REAR_X], run.actors[actor, Memory.REAR_Y]
    heading, speed = run.states[sample, actor, State.HEADING], run.states[sample, actor, State.SPEED]
    guess = run.registers[progress]
    begins = not guess >= 0.0
    if begins:
        guess = path_project(plan.road, path, x, y)
    point = path_project_near(plan.road, path, x, y, guess)
    run.registers[progress] = point.s
    run.actors[actor, Memory.PATH] = path + 1.0
    if _arrives(plan, run, sample, actor, path, plan.road.path_length[path] - point.s):
        run.actors[actor, Memory.ROUTE_DONE] = 1.0
        return True
    run.actors[actor, Memory.ROUTE_DONE] = 0.0
    aside, offset, direction = run.actors[actor, Memory.ASIDE], run.actors[actor, Memory.OFFSET], point.heading
    curve = Curve(0.0, 0.0, 0.0, 1.0, 0.0)
    if aside != NO_OFFSET:
        curve = _curve(run, actor, progress, begins, point, heading, speed, aside)
        d, slope, _ = curve_at(curve, point.s)
        offset += d
        direction += math.atan(slope / max(LEAST_ROOM, 1.0 - point.curvature * d))
    point = PathPoint(point.s, point.offset - offset, direction, point.curvature)
    if plan.kinds[actor] == ActorKind.PEDESTRIAN:
        run.actors[actor, Memory.STEER] = turn_along(point, heading)
        _hold_speed(plan, run, sample, actor, target_speed)
        return False
    wheelbase = column_of(plan, run, actor, Column.WHEELBASE)
    time_step = plan.layout.time_step * plan.layout.hold
    if aside == NO_OFFSET:
        run.actors[actor, Memory.STEER] = steer_along(plan.road, path, point, heading, speed, wheelbase, time_step)
    else:
        run.actors[actor, Memory.STEER] = steer_beside(
            plan.road, path, point, curve, heading, speed, wheelbase, time_step
        )
    target = planned_speed(plan.road, path, point.s, speed, target_speed, max_lateral)
    _hold_speed(plan, run, sample, actor, target)
    return False


@kernel
def _curve(
    run: Run, actor: int, progress: int, begins: bool, point: PathPoint, heading: float, speed: float, target: float
) -> Curve:
    """Return the curve on which a follower approaches an offset; one that begins, or takes over, begins a curve."""
    memory = run.actors[actor]
    if begins or memory[Memory.CURVE_OWNER] != progress + 1.0:
        curve = begin_curve(point, heading, speed, target)
        memory[Memory.CURVE_OWNER] = progress + 1.0
        memory[Memory.CURVE_START], memory[Memory.CURVE_OFFSET] = curve.start, curve.offset
        memory[Memory.CURVE_SLOPE], memory[Memory.CURVE_LENGTH] = curve.slope, curve.length
        return curve
    return Curve(
        memory[Memory.CURVE_START],
        memory[Memory.CURVE_OFFSET],
        memory[Memory.CURVE_SLOPE],
        memory[Memory.CURVE_LENGTH],
        target,
    )


@inlined
def _arrives(plan: Plan, run: Run, sample: int, actor: int, path: int, left: float) -> bool:
    """Return True if an actor whose rear axle has `left` [m] to go has reached the end of its path: its centre reaches
    it, or, if the road ends there, its outline would pass it before the next turn.
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
    """Return True if a path ends with the road and the outline, with `left` [m] to go, extends past it."""
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
