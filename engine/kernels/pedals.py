"""What the pedals of an actor do in one step: how far they are pressed, and the acceleration that they ask for.

A throttle pushes the way that the gear is in; against it, it slows like a brake. Brakes and drag oppose the motion and
stop at rest. Formula of the mean of a pedal p that rises at 1 / T from p0 to p1 within a step of length h, and is held
from then on: p1 - (p1 - p0)^2 T / (2 h).
"""

from typing import NamedTuple

from engine.kernels.bicycle import Vehicle, clip, powered
from engine.kernels.jit import inlined
from engine.kernels.stage import Plan, Run, Slot, column_of
from engine.vocabulary import ActorKind, Column, State

REVERSE_SPEED = 13.9
"""The fastest that any engine drives backwards [m/s]; CommonRoad, vehicle 2."""


@inlined
def heads(speed: float, reverse: float, kind: int) -> float:
    """1 of who goes or will go forwards, -1 of a vehicle that goes backwards, or stands with the reverse gear in."""
    if speed < 0.0 or (speed == 0.0 and reverse != 0.0 and kind != ActorKind.PEDESTRIAN):
        return -1.0
    return 1.0


@inlined
def built_up(asked: float, before: float, build_up: float, time_step: float) -> tuple[float, float]:
    """A pedal at the end of a step, and its mean over the step: it is pressed at 1 / `build_up` and let go at once."""
    if not (asked > before and build_up > 0.0):  # a pedal that is NaN comes back as it is
        return asked, asked
    after = min(asked, before + time_step / build_up)
    rise = after - before
    return after, after - 0.5 * rise * rise * build_up / time_step


class Pushed(NamedTuple):
    """What the pedals do in a step: acceleration along the way one goes [m/s^2], and where they are at its end."""

    acceleration: float
    throttle: float
    brake: float


@inlined
def push(plan: Plan, run: Run, sample: int, actor: int, vehicle: Vehicle, speed: float, way: float) -> Pushed:
    """Pedals to acceleration; `speed` is along the way, which is -1 backwards. A throttle of the other gear slows."""
    states, slots, step = run.states, run.actors, plan.layout.time_step
    build_up = column_of(plan, run, actor, Column.PEDAL_TIME)
    pressing, stop = slots[actor, Slot.BRAKE], slots[actor, Slot.STOP]
    if not (stop == 0.0 or stop < pressing):
        pressing = stop
    asked = clip(slots[actor, Slot.THROTTLE], 0.0, 1.0), clip(pressing, 0.0, 1.0)
    throttle, open_throttle = built_up(asked[0], states[sample, actor, State.THROTTLE], build_up, step)
    brake, pressed = built_up(asked[1], states[sample, actor, State.BRAKE], build_up, step)
    # Not `brake > 0`: a pedal that is NaN must break the run.
    if brake != 0.0:
        acceleration = -pressed * vehicle.max_braking
    elif throttle == 0.0:
        acceleration = -column_of(plan, run, actor, Column.DRAG)
    elif (slots[actor, Slot.REVERSE] != 0.0) == (way < 0.0):
        acceleration = open_throttle * vehicle.max_acceleration
    else:
        acceleration = -open_throttle * vehicle.max_acceleration
    if way < 0.0:
        acceleration = powered(acceleration, speed, REVERSE_SPEED, step)
    return Pushed(acceleration, throttle, brake)
