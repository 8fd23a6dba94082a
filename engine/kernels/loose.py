"""Loose bodies: how one that an impact has struck goes through a step, and back to a driver who may go on."""

import math

from engine.kernels.coasting import STILL, Coasting, Supports, coast, grips, has_axles, roll, supports_of
from engine.kernels.dynamics import WHEEL_RADIUS
from engine.kernels.jit import deferred, inlined
from engine.kernels.legs import Leg
from engine.kernels.run_state import LOOSE, Plan, Run, Slot, column_of
from engine.tables import SLIDING, Floats
from engine.vocabulary import Column, State


@deferred()
def step_loose(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """Write the next sample of a loose body, and hand it back to its driver where that is the setting."""
    leg = run.legs[actor]
    leg[Leg.BEGIN] = leg[Leg.STRUCK] = 0.0
    leg[Leg.X0], leg[Leg.Y0] = run.states[sample, actor, State.X], run.states[sample, actor, State.Y]
    leg[Leg.HEADING0] = run.states[sample, actor, State.HEADING]
    for column in range(3):
        leg[Leg.VX0 + column] = leg[Leg.VX1 + column]
    go_on(plan, run, actor, run.states[sample, actor, State.STEER], plan.layout.time_step)
    write_loose(plan, run, sample, actor)


@inlined
def go_on(plan: Plan, run: Run, actor: int, steer: float, duration: float) -> None:
    """Fill in where a leg ends, from where it begins."""
    leg = run.legs[actor]
    body = Coasting(leg[Leg.X0], leg[Leg.Y0], leg[Leg.HEADING0], leg[Leg.VX0], leg[Leg.VY0], leg[Leg.SPIN0])
    if body.vx != 0.0 or body.vy != 0.0 or body.spin != 0.0:
        supports = _supports(plan, run, actor, steer)
        if leg[Leg.ROLLING] != 0.0 or grips(body, supports):
            body = roll(body, supports, duration)
            leg[Leg.ROLLING] = 1.0
        else:
            body = coast(body, supports, duration)
    leg[Leg.X1], leg[Leg.Y1], leg[Leg.HEADING1] = body.x, body.y, body.heading
    leg[Leg.VX1], leg[Leg.VY1], leg[Leg.SPIN1] = body.vx, body.vy, body.spin


@inlined
def _supports(plan: Plan, run: Run, actor: int, steer: float) -> Supports:
    return supports_of(
        has_axles(plan.kinds[actor]),
        column_of(plan, run, actor, Column.LENGTH),
        column_of(plan, run, actor, Column.WIDTH),
        column_of(plan, run, actor, Column.WHEELBASE),
        column_of(plan, run, actor, Column.REAR_TO_CENTER),
        column_of(plan, run, actor, Column.FRICTION),
        steer,
        plan.layout.rolling,
        plan.gyration[actor],
    )


@inlined
def write_loose(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """The end of a loose body's leg, as the next sample: `SLIDING` also where its driver has it in hand again. A driver
    who goes on keeps hold of the wheel where a touch leaves the tyres their grip.
    """
    leg, row = run.legs[actor], run.states[sample + 1, actor]
    cos, sin = math.cos(leg[Leg.HEADING1]), math.sin(leg[Leg.HEADING1])
    speed = leg[Leg.VX1] * cos + leg[Leg.VY1] * sin
    row[State.X], row[State.Y], row[State.HEADING] = leg[Leg.X1], leg[Leg.Y1], leg[Leg.HEADING1]
    goes_on = plan.layout.drivers_go_on != 0 and _may_go_on(plan, leg, actor, speed)
    if not (goes_on and run.actors[actor, Slot.FREE] == 0.0):
        row[State.STEER] = run.states[sample, actor, State.STEER]
    row[State.SPEED] = speed
    row[State.ACCELERATION] = (speed - run.states[sample, actor, State.SPEED]) / plan.layout.time_step
    row[State.THROTTLE] = row[State.BRAKE] = 0.0
    row[State.PRESENT] = SLIDING
    run.actors[actor, Slot.FREE] = LOOSE
    if goes_on:
        to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
        run.actors[actor, Slot.REAR_X], run.actors[actor, Slot.REAR_Y] = (
            leg[Leg.X1] - to_center * cos,
            leg[Leg.Y1] - to_center * sin,
        )
        run.actors[actor, Slot.COS], run.actors[actor, Slot.SIN] = cos, sin
        run.actors[actor, Slot.FREE] = 0.0
        row[State.SPEED] = speed if abs(speed) >= STILL else max(0.0, speed)
        _let_tyres_roll(run.actors[actor], leg, speed, leg[Leg.VY1] * cos - leg[Leg.VX1] * sin)


@inlined
def _let_tyres_roll(slots: Floats, leg: Floats, ahead: float, aside: float) -> None:
    """A car whose tyres slip goes on as its body goes, not as it went before; its wheels roll."""
    slots[Slot.DRIFT_SPEED], slots[Slot.DRIFT_ANGLE] = math.hypot(ahead, aside), math.atan2(aside, ahead)
    slots[Slot.YAW_RATE] = leg[Leg.SPIN1]
    slots[Slot.FRONT_WHEEL] = slots[Slot.REAR_WHEEL] = ahead / WHEEL_RADIUS


@inlined
def _may_go_on(plan: Plan, leg: Floats, actor: int, speed: float) -> bool:
    """Whether a driver has the body in hand again: its wheels roll, or stand. Tyres that slip know forwards alone."""
    if plan.slides[actor] != 0 and speed < -STILL:
        return False
    stands = leg[Leg.VX1] == 0.0 and leg[Leg.VY1] == 0.0
    return has_axles(plan.kinds[actor]) and (leg[Leg.ROLLING] != 0.0 or stands)
