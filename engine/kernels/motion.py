"""Motion of all actors from one sample to the next, by their commands."""

import math
from typing import NamedTuple

from engine.kernels.actuation import slide
from engine.kernels.bicycle import Demand, Motion, Vehicle, clip, drive, powered, stand, walk
from engine.kernels.impacts.motion import step_post_impact
from engine.kernels.jit import inlined
from engine.kernels.region import region_contains
from engine.kernels.replay import move_along_track
from engine.kernels.run_state import NO_SPEED, POST_IMPACT, Memory, Plan, Run, Status, column_of, vehicle_of
from engine.tables import ROAD_REGION
from engine.vocabulary import ActorKind, Column, State

REVERSE_SPEED = 13.9
"""Largest speed in reverse by engine power [m/s]; CommonRoad, vehicle 2."""


class PedalResult(NamedTuple):
    """Acceleration by the pedals in the direction of travel [m/s^2], and their positions at a step's end."""

    acceleration: float
    throttle: float
    brake: float


# -- one step ----------------------------------------------------------------------------------------------------------


@inlined
def step(plan: Plan, run: Run) -> None:
    """Write the next sample of all actors except those that a host moves."""
    sample = int(run.status[Status.SAMPLE])
    for actor in range(len(plan.kinds)):
        if run.actors[actor, Memory.FREE] != 0.0:
            if run.actors[actor, Memory.FREE] == POST_IMPACT:
                _watch_road(plan, run, sample, actor)
                step_post_impact(plan, run, sample, actor)
            continue
        if run.states[sample, actor, State.PRESENT] == 0.0 or run.actors[actor, Memory.LEAVING] != 0.0:
            for column in range(run.states.shape[2]):
                run.states[sample + 1, actor, column] = run.states[sample, actor, column]
            run.states[sample + 1, actor, State.PRESENT] = 0.0
            continue
        _watch_road(plan, run, sample, actor)
        if run.actors[actor, Memory.TRACK] != 0.0:
            move_along_track(plan, run, sample, actor)
        else:
            _move(plan, run, sample, actor)


@inlined
def _watch_road(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Note when an actor's centre is first outside the road, at the samples from which it steps."""
    if math.isnan(run.actors[actor, Memory.LEFT_ROAD]):
        x, y = run.states[sample, actor, State.X], run.states[sample, actor, State.Y]
        if not region_contains(plan.road, ROAD_REGION, x, y):
            run.actors[actor, Memory.LEFT_ROAD] = sample * plan.layout.time_step


@inlined
def _move(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Move one actor by a step according to its commands.

    A vehicle in reverse is computed as one that faces the other way and steers to the other side.
    """
    memory = run.actors
    vehicle = vehicle_of(plan, run, actor)
    speed = run.states[sample, actor, State.SPEED]
    if memory[actor, Memory.SET_SPEED] != NO_SPEED:
        speed = clip(memory[actor, Memory.SET_SPEED], 0.0, vehicle.max_speed)
        memory[actor, Memory.SET_SPEED] = NO_SPEED
    way = direction_of_travel(speed, memory[actor, Memory.REVERSE], plan.kinds[actor])
    pushed = push(plan, run, sample, actor, vehicle, way * speed, way)
    faces = 1.0 if plan.slides[actor] != 0 else way  # a slipping car is turned back only by a spin
    heading, steer = run.states[sample, actor, State.HEADING], run.states[sample, actor, State.STEER]
    motion = Motion(
        memory[actor, Memory.REAR_X],
        memory[actor, Memory.REAR_Y],
        heading,
        faces * memory[actor, Memory.COS],
        faces * memory[actor, Memory.SIN],
        faces * speed,
        faces * steer,
    )
    demand = Demand(way * faces * pushed.acceleration, faces * memory[actor, Memory.STEER])
    kind = plan.kinds[actor]
    if kind == ActorKind.OBSTACLE:
        after = stand(motion)
    elif kind == ActorKind.PEDESTRIAN:
        after = walk(motion, demand, vehicle, plan.layout.time_step)
        memory[actor, Memory.STEER] = 0.0  # a turn is made once, an angle of wheels stays
    elif plan.slides[actor] != 0:
        mass, rear = column_of(plan, run, actor, Column.MASS), column_of(plan, run, actor, Column.REAR_TO_CENTER)
        after = slide(motion, demand, vehicle, mass, rear, memory[actor], plan.layout.time_step)
    else:
        after = drive(motion, demand, vehicle, plan.layout.time_step)
    memory[actor, Memory.REAR_X], memory[actor, Memory.REAR_Y] = after.x, after.y
    memory[actor, Memory.COS], memory[actor, Memory.SIN] = after.cos, after.sin
    _record(plan, run, sample, actor, after, faces, speed)
    run.states[sample + 1, actor, State.THROTTLE] = pushed.throttle
    run.states[sample + 1, actor, State.BRAKE] = pushed.brake


@inlined
def _record(plan: Plan, run: Run, before: int, actor: int, after: Motion, faces: float, speed: float) -> None:
    """Write the motion of the sample after `before`, at which the speed was `speed`.

    `faces` -1 reverts the sign of a reversed motion.
    """
    states, sample = run.states, before + 1
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    states[sample, actor, State.X] = after.x + to_center * after.cos
    states[sample, actor, State.Y] = after.y + to_center * after.sin
    states[sample, actor, State.HEADING] = after.heading
    states[sample, actor, State.SPEED] = faces * after.speed + 0.0  # never -0.0
    states[sample, actor, State.STEER] = faces * after.steer + 0.0
    states[sample, actor, State.ACCELERATION] = (faces * after.speed - speed) / plan.layout.time_step
    states[sample, actor, State.PRESENT] = 1.0


# -- pedals: positions in a step, and acceleration ---------------------------------------------------------------------


@inlined
def direction_of_travel(speed: float, reverse: float, kind: int) -> float:
    """Return 1.0 for forward travel, -1.0 for a vehicle that moves backwards, or stands with reverse gear."""
    if speed < 0.0 or (speed == 0.0 and reverse != 0.0 and kind != ActorKind.PEDESTRIAN):
        return -1.0
    return 1.0


@inlined
def pedal_response(asked: float, before: float, build_up: float, time_step: float) -> tuple[float, float]:
    """Return a pedal's position at the end of a step, and its mean; it rises at 1 / `build_up` [1/s] and falls at once.

    Formula of the mean of a pedal p that rises at 1 / T from p0 to p1 within a step of length h, and is held from then
    on: p1 - (p1 - p0)^2 T / (2 h).
    """
    if not (asked > before and build_up > 0.0):  # a pedal that is NaN is returned unchanged
        return asked, asked
    after = min(asked, before + time_step / build_up)
    rise = after - before
    return after, after - 0.5 * rise * rise * build_up / time_step


@inlined
def push(plan: Plan, run: Run, sample: int, actor: int, vehicle: Vehicle, speed: float, way: float) -> PedalResult:
    """Return the effect of the pedals; `speed` is along the direction of travel `way`, which is -1 in reverse.

    A throttle accelerates in the direction of the gear; against it, it decelerates like a brake. Brakes and drag oppose
    the motion and end at rest.
    """
    states, memory, time_step = run.states, run.actors, plan.layout.time_step
    build_up = column_of(plan, run, actor, Column.PEDAL_TIME)
    pressing, stop = memory[actor, Memory.BRAKE], memory[actor, Memory.STOP]
    if not (stop == 0.0 or stop < pressing):
        pressing = stop
    asked = clip(memory[actor, Memory.THROTTLE], 0.0, 1.0), clip(pressing, 0.0, 1.0)
    throttle, open_throttle = pedal_response(asked[0], states[sample, actor, State.THROTTLE], build_up, time_step)
    brake, pressed = pedal_response(asked[1], states[sample, actor, State.BRAKE], build_up, time_step)
    # Not `brake > 0`: a pedal that is NaN must break the run.
    if brake != 0.0:
        acceleration = -pressed * vehicle.max_braking
    elif throttle == 0.0:
        acceleration = -column_of(plan, run, actor, Column.DRAG)
    elif (memory[actor, Memory.REVERSE] != 0.0) == (way < 0.0):
        acceleration = open_throttle * vehicle.max_acceleration
    else:
        acceleration = -open_throttle * vehicle.max_acceleration
    if way < 0.0:
        acceleration = powered(acceleration, speed, REVERSE_SPEED, time_step)
    return PedalResult(acceleration, throttle, brake)
