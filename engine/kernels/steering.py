"""Following a path: the steering angle and the pedal that a driver chooses at one sample.

Steering: the curvature of the path a little ahead, plus corrections of heading and offset over a look-ahead ld:

    kappa = kappa_ref(s + 0.2 s * v) + (2 / ld) sin(psi_ref - psi) - clip(e, +-0.35 ld) / ld^2
    delta = atan(L kappa)            ld = max(3 m, 0.4 s * v)

with e the offset of the rear axle to the left of the path. Linearised, e'' = -(2 / ld) e' - e / ld^2 in way driven:
critically damped at every speed, so offsets up to the clipped 0.35 ld decay without overshoot; the clip keeps the
approach from a larger offset at a moderate angle. The preview of 0.2 s is the lag of a rate-limited steering wheel;
half a step is added to it, because a demand at a sample is reached, on average, that much later.

A follower with an offset steers along a curve beside the path instead: from its place and direction at the beginning to
the offset, as the quintic of least jerk (`cortex_dsl.semantics.acting.following` has the source). A curve d(s) beside a
path of curvature k has the direction theta = atan(d' / (1 - k d)) against the path and the curvature
((d'' + k d' tan theta) cos^2 theta / (1 - k d) + k) cos theta / (1 - k d). Source: Werling, Ziegler, Kammel and Thrun
(2010), "Optimal trajectory generation for dynamic street scenarios in a Frenet frame", ICRA, appendix I.

Speed: proportional, a = 4/s (v_target - v), between full braking and full throttle. In front of bends the target is the
result of `speed_limit_ahead`: v_bend = sqrt(max_lateral / |kappa|), reached by a steady 3 m/s^2 (the comfortable
deceleration of traffic engineering: ITE 3.05, AASHTO 3.4 m/s^2). A proportional controller lags a falling target by 3 /
4 m/s; looking 0.5 s = two time constants ahead leaves a tenth of a m/s of that at the bend's start.
"""

import math
from typing import NamedTuple

from engine.kernels.bicycle import clip
from engine.kernels.evaluate import wrap_angle
from engine.kernels.jit import inlined
from engine.kernels.path import PathPoint, path_curvature, speed_limit_ahead
from engine.tables import RoadTables

PREVIEW = 0.2
"""Time ahead at which the path's curvature is taken [s]."""
LOOK_AHEAD = 0.4
"""[s]"""
MIN_LOOK_AHEAD = 3.0
"""[m]"""
OFFSET_SHARE = 0.35
"""Offsets above this share of the look-ahead are treated as this share."""
SPEED_GAIN = 4.0
"""[1/s]"""
PLANNED_BRAKING = 3.0
"""Deceleration that is planned in front of bends [m/s^2]."""
SPEED_PREVIEW = 0.5
"""Time ahead at which the speed plan is read [s]."""
MAX_BRAKING = 8.0
"""Largest deceleration that the speed controller demands [m/s^2]."""
MAX_ACCELERATION = 3.0
"""Largest acceleration that the speed controller demands [m/s^2]."""
CURVE_TIME = 3.5
"""Time in which an offset is approached [s]: `DURATION` of the library's lane change."""
CURVE_BEND = 0.05
"""Largest curvature of that curve against the path [1/m]: slow actors need a longer time instead."""
STEEPEST = 0.5
"""Largest slope against the path with which a curve begins."""
HALF_WAY_SLOPE = 1.875
"""Largest slope of a curve that begins along the path, in changes of offset over its length."""
LEAST_ROOM = 0.1
"""Least share of a bend's radius that is left between its centre and the curve."""
WALKING_LOOK_AHEAD = 1.0
"""Distance from the nearest point of the path to the point at which a pedestrian aims [m]."""


class Pedals(NamedTuple):
    """Positions in [0, 1]; the brake beats the throttle."""

    throttle: float
    brake: float


@inlined
def path_curvature_wanted(point: PathPoint, curvature_ahead: float, heading: float, speed: float) -> float:
    """Return the curvature to drive from here [1/m]; `point` is the rear axle's place on the path."""
    look_ahead = max(MIN_LOOK_AHEAD, LOOK_AHEAD * speed)
    offset = clip(point.offset, -OFFSET_SHARE * look_ahead, OFFSET_SHARE * look_ahead)
    heading_error = math.sin(point.heading - heading)
    return curvature_ahead + 2.0 / look_ahead * heading_error - offset / (look_ahead * look_ahead)


@inlined
def steer_along(
    road: RoadTables, path: int, point: PathPoint, heading: float, speed: float, wheelbase: float, time_step: float
) -> float:
    """Return the steering angle of a vehicle that follows a path [rad]."""
    curvature_ahead = path_curvature(road, path, point.s + (PREVIEW + 0.5 * time_step) * speed)
    return math.atan(wheelbase * path_curvature_wanted(point, curvature_ahead, heading, speed))


@inlined
def steer_beside(
    road: RoadTables,
    path: int,
    point: PathPoint,
    curve: "Curve",
    heading: float,
    speed: float,
    wheelbase: float,
    time_step: float,
) -> float:
    """Return the steering angle of a vehicle that follows a curve beside a path [rad]; `point` is relative to it."""
    half = 0.5 * time_step
    bend = path_curvature(road, path, point.s + (PREVIEW + half) * speed)
    d, slope, second = curve_at(curve, point.s + half * speed)  # smooth: the wheel keeps up with it
    room = max(LEAST_ROOM, 1.0 - bend * d)
    theta = math.atan(slope / room)
    cos = math.cos(theta)
    curvature_ahead = ((second + bend * slope * math.tan(theta)) * cos * cos / room + bend) * cos / room
    return math.atan(wheelbase * path_curvature_wanted(point, curvature_ahead, heading, speed))


class Curve(NamedTuple):
    """A curve beside a path: where it begins, and its end."""

    start: float
    """Arc length of the path [m]."""
    offset: float
    """Offset to the left of the path at the beginning [m]."""
    slope: float
    """Slope against the path at the beginning."""
    length: float
    """[m]"""
    target: float
    """Offset at the end and after it [m]."""


@inlined
def begin_curve(point: PathPoint, heading: float, speed: float, target: float) -> Curve:
    """Return the curve from an actor's place to an offset from its path [m]."""
    theta = math.atan2(math.sin(heading - point.heading), max(math.cos(heading - point.heading), LEAST_ROOM))
    room = max(LEAST_ROOM, 1.0 - point.curvature * point.offset)
    slope = clip(math.tan(theta) * room, -STEEPEST, STEEPEST)
    change, length = target - point.offset, speed * CURVE_TIME
    if slope * change > 0.0:  # on its way already: longer curves overshoot
        length = min(length, HALF_WAY_SLOPE * change / slope)
    # The second derivative of the curve is at most 5.78 changes over length^2, and 3.9 slopes over length.
    least = max(math.sqrt(5.78 * abs(change) / CURVE_BEND), 3.9 * abs(slope) / CURVE_BEND)
    return Curve(point.s, point.offset, slope, max(least, length, 1.0), target)


@inlined
def curve_at(curve: Curve, s: float) -> tuple[float, float, float]:
    """Return offset [m], slope and second derivative [1/m] at an arc length of the path.

    The quintics 10 u^3 - 15 u^4 + 6 u^5 and u - 6 u^3 + 8 u^4 - 3 u^5 carry the change of offset and the first slope.
    """
    u = clip((s - curve.start) / curve.length, 0.0, 1.0)
    rest, change, first = 1.0 - u, curve.target - curve.offset, curve.slope * curve.length
    square, other = u * u, rest * rest
    offset = change * square * u * (10.0 + u * (6.0 * u - 15.0)) + first * u * rest * other * (1.0 + 3.0 * u)
    slope = 30.0 * change * square * other + first * other * (1.0 + u * (2.0 - 15.0 * u))
    bend = 60.0 * change * u * rest * (rest - u) - 12.0 * first * u * rest * (3.0 - 5.0 * u)
    return curve.offset + offset, slope / curve.length, bend / (curve.length * curve.length)


@inlined
def turn_along(point: PathPoint, heading: float) -> float:
    """Return the turn of a pedestrian that follows a path [rad]: towards it and along it, without overshoot."""
    return wrap_angle(point.heading - math.atan(point.offset / WALKING_LOOK_AHEAD) - heading)


@inlined
def planned_speed(
    road: RoadTables, path: int, s: float, speed: float, target_speed: float, max_lateral: float
) -> float:
    """Return the target speed, limited by the bends at and ahead of arc length `s` [m/s].

    `max_lateral` is the largest lateral acceleration in bends [m/s^2]; infinity disables planning.
    """
    if max_lateral == math.inf:
        return target_speed
    limit = speed_limit_ahead(road, path, s, max_lateral, PLANNED_BRAKING)
    if limit < math.inf:
        limit = min(limit, speed_limit_ahead(road, path, s + SPEED_PREVIEW * speed, max_lateral, PLANNED_BRAKING))
    return target_speed if limit > target_speed else limit


@inlined
def pedals_towards(target_speed: float, speed: float, max_acceleration: float, max_braking: float) -> Pedals:
    """Return the pedals of the proportional speed controller; NaN for a target that is NaN."""
    wanted = clip(SPEED_GAIN * (target_speed - speed), -MAX_BRAKING, MAX_ACCELERATION)
    if wanted < 0.0:
        return Pedals(0.0, min(-wanted / max_braking, 1.0) if max_braking > 0.0 else 0.0)
    return Pedals(clip(wanted / max_acceleration, 0.0, 1.0) if max_acceleration > 0.0 else 0.0, 0.0)
