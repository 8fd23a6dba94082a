"""Motion of a body in a step: the kinematic bicycle at its rear axle, the pedestrian, the obstacle.

The bicycle, with (x, y) the middle of the rear axle, v its speed, psi the heading, delta the steering angle, L the
wheelbase (Rajamani, "Vehicle Dynamics and Control", 2nd ed., section 2.2; Althoff et al. 2017, model KS):

    x' = v cos psi      y' = v sin psi      psi' = v tan(delta) / L      v' = a      |delta'| bounded

A step of length h takes speed and steering at its middle and drives the circular arc they define, exactly:

    ds = (v + a h / 2) h          dpsi = ds tan(delta + delta' h / 2) / L
    (x, y) += ds sinc(dpsi / 2) (cos, sin)(psi + dpsi / 2)

which is of second order in h and exact for constant steering, with any change of speed. Under brake a vehicle stops at
v = 0. Demands beyond the grip of the tyres are reduced, see `within_grip`.

In reverse the same equations hold with v < 0. They are those of a vehicle that faces the other way and steers to the
other side, so `drive` is only called for speeds >= 0; see `rollout`.
"""

import math
from typing import NamedTuple

from engine.kernels.jit import inlined

GRAVITY = 9.81
"""[m/s^2]"""


SERIES = tuple((-1.0) ** (n // 2) / math.factorial(n) for n in range(12))
"""Coefficients of the series of sine (odd) and cosine (even)."""


class Vehicle(NamedTuple):
    """Capabilities of a body."""

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
    """Pose and motion of a body."""

    x: float
    """Middle of the rear axle [m]."""
    y: float
    heading: float
    """Heading, not wrapped [rad]."""
    cos: float
    """Cosine of the heading; stored, because every step and every follower needs it."""
    sin: float
    speed: float
    """[m/s]"""
    steer: float
    """[rad]"""


class Demand(NamedTuple):
    """Demand of the driver in a step: longitudinal acceleration [m/s^2] and steering angle [rad]."""

    acceleration: float
    steer: float


class Grip(NamedTuple):
    """The part of a demand that the tyres can hold: acceleration [m/s^2] and curvature [1/m]."""

    acceleration: float
    curvature: float


@inlined
def clip(value: float, low: float, high: float) -> float:
    """Return `value` limited to [low, high]; NaN stays NaN, so that a broken number is never hidden."""
    if value < low:
        return low
    if value > high:
        return high
    return value


@inlined
def powered(acceleration: float, speed: float, top_speed: float, time_step: float) -> float:
    """Return the acceleration, limited so that the speed does not exceed the top speed [m/s^2]."""
    if not acceleration > 0.0:
        return acceleration
    headroom = max(top_speed - speed, 0.0) / time_step
    return headroom if acceleration > headroom else acceleration


@inlined
def within_grip(acceleration: float, curvature: float, speed: float, grip: float, time_step: float) -> Grip:
    """Return the demand, reduced to the grip of the tyres; both laws hold at the middle of the step.

    First |yaw rate| <= mu g / v, that is |curvature| v^2 <= mu g: an actor too fast for a bend runs wide. Then the
    friction circle, sqrt(a_lon^2 + a_lat^2) <= mu g: both parts shrink by the same factor, so braking in a bend is
    possible.
    """
    # The fastest that the middle of the step may be: shortening an acceleration can only slow it down from there.
    speed = max(speed, speed + 0.5 * acceleration * time_step)
    lateral = speed * speed * curvature
    if abs(lateral) <= grip and acceleration * acceleration + lateral * lateral <= grip * grip:
        return Grip(acceleration, curvature)  # nearly always, without waiting for quotients and a root
    if abs(lateral) > grip:
        curvature *= grip / abs(lateral)
        lateral = math.copysign(grip, lateral)
    squared = acceleration * acceleration + lateral * lateral
    if squared > grip * grip:
        share = grip / math.sqrt(squared)
        return Grip(acceleration * share, curvature * share)
    return Grip(acceleration, curvature)


@inlined
def small_turn(angle: float) -> tuple[float, float, float]:
    """Return sin(x) / x, sin(x) and cos(x) of a turn within a step; by series if it is small, as nearly always."""
    if abs(angle) > 0.25:
        sin = math.sin(angle)
        return sin / angle, sin, math.cos(angle)
    y = angle * angle  # the first terms left out are below 2e-17
    sinc = 1.0 + y * (SERIES[3] + y * (SERIES[5] + y * (SERIES[7] + y * (SERIES[9] + y * SERIES[11]))))
    cos = 1.0 + y * (SERIES[2] + y * (SERIES[4] + y * (SERIES[6] + y * (SERIES[8] + y * SERIES[10]))))
    return sinc, angle * sinc, cos


@inlined
def travelled(speed: float, acceleration: float, time_step: float) -> tuple[float, float]:
    """Return the distance driven in a step [m] and the speed at its end [m/s]; braking ends at zero speed."""
    end_speed = speed + acceleration * time_step
    if end_speed < 0.0:
        return -0.5 * speed * speed / acceleration, 0.0
    return (speed + 0.5 * acceleration * time_step) * time_step, end_speed


@inlined
def drive(motion: Motion, demand: Demand, vehicle: Vehicle, time_step: float) -> Motion:
    """Return the motion of a vehicle with wheels after a step."""
    turn = vehicle.steer_rate * time_step
    target = clip(demand.steer, -vehicle.max_steer, vehicle.max_steer)
    steer = clip(target, motion.steer - turn, motion.steer + turn)
    curvature = math.tan(0.5 * (motion.steer + steer)) / vehicle.wheelbase
    acceleration = powered(demand.acceleration, motion.speed, vehicle.max_speed, time_step)
    held = within_grip(acceleration, curvature, motion.speed, vehicle.grip, time_step)
    way, speed = travelled(motion.speed, held.acceleration, time_step)
    half_turn = 0.5 * way * held.curvature
    sinc, sin, cos = small_turn(half_turn)
    heading = motion.heading + 2.0 * half_turn
    return Motion(
        motion.x + way * sinc * (motion.cos * cos - motion.sin * sin),
        motion.y + way * sinc * (motion.sin * cos + motion.cos * sin),
        heading,
        math.cos(heading),
        math.sin(heading),
        speed,
        steer,
    )


@inlined
def walk(motion: Motion, demand: Demand, vehicle: Vehicle, time_step: float) -> Motion:
    """Return the motion of a pedestrian after a step: a point that turns at once by the demanded angle."""
    acceleration = powered(demand.acceleration, motion.speed, vehicle.max_speed, time_step)
    way, speed = travelled(motion.speed, acceleration, time_step)
    heading = motion.heading + demand.steer
    cos, sin = math.cos(heading), math.sin(heading)
    return Motion(motion.x + way * cos, motion.y + way * sin, heading, cos, sin, speed, 0.0)


@inlined
def stand(motion: Motion) -> Motion:
    """Return the motion of an obstacle after a step: it stands."""
    return Motion(motion.x, motion.y, motion.heading, motion.cos, motion.sin, 0.0, 0.0)
