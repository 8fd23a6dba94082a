"""Repetition of recorded motion: in each step an actor moves, from its present pose, as the recording did in that time.

A track is stored in the pool: its number of rows, then `time, x, y, heading, speed` of each row (SI units, radians that
are not wrapped, times from 0 on, ascending; positions are centres of outlines). Between rows all of them are linear.
Steps are relative to the actor: an actor that begins at another pose than the recording, or is pushed aside, never
jumps.
"""

import math
from typing import NamedTuple

from engine.kernels.evaluate import operand
from engine.kernels.jit import deferred, kernel
from engine.kernels.run_state import Memory, Plan, Run, column_of
from engine.tables import Floats
from engine.vocabulary import Column, State

NUMBERS = 5
"""Numbers per row of a track."""
AT_END = 1e-9
"""Time before its last row at which a track ends [s]: times are sums of steps."""


class Recorded(NamedTuple):
    """Pose of a track at one of its times: centre [m], heading [rad], speed [m/s]."""

    x: float
    y: float
    heading: float
    speed: float


@deferred()
def follow_track(plan: Plan, run: Run, actor: int, row: int) -> bool:
    """Execute `Op.REPLAY`: move the actor along its track in this turn; return True, without effect, after its end."""
    clock, track, pace = (
        operand(plan.code, row, 1),
        operand(plan.code, row, 2),
        run.registers[operand(plan.code, row, 3)],
    )
    time = run.registers[clock]
    if time >= plan.pool[track + 1 + NUMBERS * (int(plan.pool[track]) - 1)] - AT_END:
        run.actors[actor, Memory.ROUTE_DONE] = 1.0
        return True
    run.actors[actor, Memory.ROUTE_DONE] = 0.0
    run.actors[actor, Memory.TRACK], run.actors[actor, Memory.TRACK_TIME] = track + 1.0, time
    run.actors[actor, Memory.PACE] = pace
    run.registers[clock] = time + pace * plan.layout.time_step * plan.layout.hold
    return False


@kernel
def recorded_at(pool: Floats, track: int, time: float) -> Recorded:
    """Return the pose of a track at a time, limited to its span."""
    low, high = 0, int(pool[track]) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if pool[track + 1 + NUMBERS * middle] <= time:
            low = middle
        else:
            high = middle
    before = track + 1 + NUMBERS * low
    after = before + NUMBERS
    part = min(1.0, max(0.0, (time - pool[before]) / (pool[after] - pool[before])))
    return Recorded(
        pool[before + 1] + part * (pool[after + 1] - pool[before + 1]),
        pool[before + 2] + part * (pool[after + 2] - pool[before + 2]),
        pool[before + 3] + part * (pool[after + 3] - pool[before + 3]),
        pool[before + 4] + part * (pool[after + 4] - pool[before + 4]),
    )


@deferred()
def move_along_track(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Write the next sample of an actor that goes along its track: within a turn its time passes on with the steps."""
    memory, states, step = run.actors, run.states, plan.layout.time_step
    track, pace = int(memory[actor, Memory.TRACK]) - 1, memory[actor, Memory.PACE]
    begin = memory[actor, Memory.TRACK_TIME] + pace * step * (sample % plan.layout.hold)
    one, other = recorded_at(plan.pool, track, begin), recorded_at(plan.pool, track, begin + pace * step)
    turned = states[sample, actor, State.HEADING] - one.heading
    cos, sin = math.cos(turned), math.sin(turned)
    x = states[sample, actor, State.X] + cos * (other.x - one.x) - sin * (other.y - one.y)
    y = states[sample, actor, State.Y] + sin * (other.x - one.x) + cos * (other.y - one.y)
    heading = states[sample, actor, State.HEADING] + (other.heading - one.heading)
    for column in range(states.shape[2]):
        states[sample + 1, actor, column] = 0.0
    states[sample + 1, actor, State.X], states[sample + 1, actor, State.Y] = x, y
    states[sample + 1, actor, State.HEADING] = heading
    states[sample + 1, actor, State.SPEED] = pace * other.speed
    states[sample + 1, actor, State.ACCELERATION] = (pace * other.speed - states[sample, actor, State.SPEED]) / step
    states[sample + 1, actor, State.PRESENT] = 1.0
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    memory[actor, Memory.COS], memory[actor, Memory.SIN] = math.cos(heading), math.sin(heading)
    memory[actor, Memory.REAR_X] = x - to_center * memory[actor, Memory.COS]
    memory[actor, Memory.REAR_Y] = y - to_center * memory[actor, Memory.SIN]
