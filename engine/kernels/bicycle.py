"""How a body moves in one step: the kinematic bicycle at its rear axle, the walker, the thing that stands.

The bicycle, with (x, y) the middle of the rear axle, v its speed, psi the heading, delta the steering angle, L the
wheelbase (Rajamani, "Vehicle Dynamics and Control", 2nd ed., section 2.2; Althoff et al. 2017, model KS):

    x' = v cos psi      y' = v sin psi      psi' = v tan(delta) / L      v' = a      |delta'| bounded

A step of length h takes speed and steering at its middle and drives the circular arc they define, exactly:

    ds = (v + a h / 2) h          dpsi = ds tan(delta + delta' h / 2) / L
    (x, y) += ds sinc(dpsi / 2) (cos, sin)(psi + dpsi / 2)

which is of second order in h and exact for constant steering, whatever the speed does. Under brake a vehicle stops
at v = 0 and never reverses. What tyres cannot hold is not driven, see `within_grip`.
"""

import math
from typing import NamedTuple

from engine.kernels.inline import inlined

GRAVITY = 9.81
"""[m/s^2]"""


class Vehicle(NamedTuple):
    """What a body can do."""

    wheelbase: float
    """L [m]"""
    max_steer: float
    """[rad]"""
    steer_rate: float
    """[rad/s]"""
    max_acceleration: float
    """[m/s^2]"""
    max_braking: float
    """Deceleration at full pedal [m/s^2]."""
    grip: float
    """mu g: the largest acceleration in any direction [m/s^2]."""
    max_speed: float
    """[m/s]"""


class Motion(NamedTuple):
    """Where a body is and how it moves: rear axle x, y [m], heading [rad, not wrapped], speed [m/s], steering [rad]."""

    x: float
    y: float
    heading: float
    speed: float
    steer: float


class Demand(NamedTuple):
    """What the driver wants of one step: longitudinal acceleration [m/s^2] and steering angle [rad]."""

    acceleration: float
    steer: float


class Grip(NamedTuple):
    """What the tyres hold of a demand: acceleration [m/s^2] and curvature [1/m]."""

    acceleration: float
    curvature: float


@inlined
def clip(value: float, low: float, high: float) -> float:
    """`value` brought into [low, high]; NaN stays NaN, so that a broken number is never hidden."""
    if value < low:
        return low
    if value > high:
        return high
    return value


@inlined
def within_grip(acceleration: float, curvature: float, speed: float, grip: float, time_step: float) -> Grip:
    """The demand, shortened until the tyres hold it; both laws hold at the middle of the step.

    First |yaw rate| <= mu g / v, that is |curvature| v^2 <= mu g: whoever is too fast for a bend runs wide. Then the
    friction circle, sqrt(a_lon^2 + a_lat^2) <= mu g: both parts are shortened alike, so one can still brake in a bend.
    """
    # The fastest that the middle of the step may be: shortening an acceleration can only slow it down from there.
    speed = max(speed, speed + 0.5 * acceleration * time_step)
    lateral = speed * speed * curvature
    if abs(lateral) > grip:
        curvature *= grip / abs(lateral)
        lateral = math.copysign(grip, lateral)
    squared = acceleration * acceleration + lateral * lateral
    if squared > grip * grip:
        share = grip / math.sqrt(squared)
        return Grip(acceleration * share, curvature * share)
    return Grip(acceleration, curvature)


@inlined
def sinc(x: float) -> float:
    """sin(x) / x."""
    if abs(x) < 0.25:  # the next term of the series is below 2e-17 there
        y = x * x
        return 1.0 - y / 6.0 * (1.0 - y / 20.0 * (1.0 - y / 42.0 * (1.0 - y / 72.0 * (1.0 - y / 110.0))))
    return math.sin(x) / x


@inlined
def travelled(speed: float, acceleration: float, time_step: float) -> tuple[float, float]:
    """Way driven in a step and speed at its end; braking ends where the speed reaches zero."""
    end_speed = speed + acceleration * time_step
    if end_speed < 0.0:
        return -0.5 * speed * speed / acceleration, 0.0
    return (speed + 0.5 * acceleration * time_step) * time_step, end_speed


@inlined
def drive(motion: Motion, demand: Demand, vehicle: Vehicle, time_step: float) -> Motion:
    """One step of a vehicle with wheels."""
    turn = vehicle.steer_rate * time_step
    target = clip(demand.steer, -vehicle.max_steer, vehicle.max_steer)
    steer = clip(target, motion.steer - turn, motion.steer + turn)
    curvature = math.tan(0.5 * (motion.steer + steer)) / vehicle.wheelbase
    held = within_grip(demand.acceleration, curvature, motion.speed, vehicle.grip, time_step)
    way, speed = travelled(motion.speed, held.acceleration, time_step)
    half_turn = 0.5 * way * held.curvature
    middle = motion.heading + half_turn
    chord = way * sinc(half_turn)
    return Motion(
        motion.x + chord * math.cos(middle),
        motion.y + chord * math.sin(middle),
        motion.heading + 2.0 * half_turn,
        speed,
        steer,
    )


@inlined
def walk(motion: Motion, demand: Demand, vehicle: Vehicle, time_step: float) -> Motion:
    """One step of a pedestrian: a point that turns at once by the demanded angle and then goes straight on."""
    headroom = max(vehicle.max_speed - motion.speed, 0.0) / time_step
    acceleration = demand.acceleration
    if acceleration > headroom:
        acceleration = headroom
    way, speed = travelled(motion.speed, acceleration, time_step)
    heading = motion.heading + demand.steer
    return Motion(motion.x + way * math.cos(heading), motion.y + way * math.sin(heading), heading, speed, 0.0)


@inlined
def stand(motion: Motion) -> Motion:
    """One step of an obstacle."""
    return Motion(motion.x, motion.y, motion.heading, 0.0, 0.0)
