"""How a loose body moves: it slides with yaw until its wheels grip again, and then rolls out where they point.

A wheel without a driver rolls: its axle resists sideways only, by Coulomb's law with at most mu times its static load,
and along its heading by the small resistance of rolling. Two-wheelers fall over, and they and whatever has no wheels
slide: their two supports resist in every direction. Within a substep friction gives at most the impulse that stops its
point, so that it reverses no motion and energy never rises.
"""

import math
from typing import NamedTuple

from engine.kernels.bicycle import GRAVITY, clip, small_turn, travelled
from engine.kernels.jit import inlined, kernel
from engine.vocabulary import ActorKind

SUBSTEP = 0.005
"""Of a slide [s]."""
STILL = 0.01
"""A body slower than this stands [m/s], and so does one that turns no faster [rad/s]."""
GRIPS = 0.05
"""Axles that slip sideways no faster have their grip again [m/s]."""


class Supports(NamedTuple):
    """Where a body stands on the road, per unit of its mass."""

    rolls: bool
    """Whether its supports are axles; else they slide in every direction."""
    rear: float
    """Ahead of the centre, negative [m]."""
    front: float
    rear_grip: float
    """What friction holds there: mu g times the share of the weight [m/s^2]."""
    front_grip: float
    rolling: float
    """Deceleration of rolling [m/s^2]."""
    steer: float
    """Angle of the front wheels [rad]."""
    gyration: float
    """Yaw inertia over mass [m^2]."""


class Coasting(NamedTuple):
    """Where a body is and how it moves: centre [m], heading [rad], its velocity [m/s] and spin [rad/s] in the plane."""

    x: float
    y: float
    heading: float
    vx: float
    vy: float
    spin: float


@kernel
def coast(body: Coasting, supports: Supports, duration: float) -> Coasting:
    """Slide for a time [s]."""
    count = max(1, math.ceil(duration / SUBSTEP - 1e-9))
    step = duration / count
    for _ in range(count):
        after = _rub(body, supports, step)
        body = Coasting(
            body.x + 0.5 * step * (body.vx + after.vx),
            body.y + 0.5 * step * (body.vy + after.vy),
            body.heading + 0.5 * step * (body.spin + after.spin),
            after.vx,
            after.vy,
            after.spin,
        )
        if body.vx == 0.0 and body.vy == 0.0 and body.spin == 0.0:
            break
    return body


@kernel
def slowed(body: Coasting, supports: Supports, step: float) -> Coasting:
    """The velocities after the friction of a step, for a host that moves bodies itself."""
    return _rub(body, supports, step)


@inlined
def _rub(body: Coasting, supports: Supports, step: float) -> Coasting:
    """The velocities after the friction of both supports; what is slow enough stands."""
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    if supports.rolls:
        body = _rub_axle(body, supports, supports.rear, supports.rear_grip, cos, sin, 0.0, step)
        body = _rub_axle(body, supports, supports.front, supports.front_grip, cos, sin, supports.steer, step)
    else:
        body = _rub_support(body, supports, supports.rear, supports.rear_grip, cos, sin, step)
        body = _rub_support(body, supports, supports.front, supports.front_grip, cos, sin, step)
    if body.vx * body.vx + body.vy * body.vy < STILL * STILL and abs(body.spin) < STILL:
        return Coasting(body.x, body.y, body.heading, 0.0, 0.0, 0.0)
    return body


@inlined
def _rub_axle(
    body: Coasting, supports: Supports, offset: float, grip: float, cos: float, sin: float, steer: float, step: float
) -> Coasting:
    """Resist sideways by the grip, and along the wheels by the rolling."""
    turned_cos, turned_sin = math.cos(steer), math.sin(steer)
    x, y = cos * turned_cos - sin * turned_sin, sin * turned_cos + cos * turned_sin
    body = _resist(body, supports, offset * cos, offset * sin, -y, x, grip * step)
    return _resist(body, supports, offset * cos, offset * sin, x, y, 0.5 * supports.rolling * step)


@inlined
def _rub_support(
    body: Coasting, supports: Supports, offset: float, grip: float, cos: float, sin: float, step: float
) -> Coasting:
    """Resist against the motion of the support."""
    x, y = body.vx - body.spin * offset * sin, body.vy + body.spin * offset * cos
    slide = math.hypot(x, y)
    if slide == 0.0:
        return body
    return _resist(body, supports, offset * cos, offset * sin, x / slide, y / slide, grip * step)


@inlined
def _resist(
    body: Coasting, supports: Supports, arm_x: float, arm_y: float, x: float, y: float, limit: float
) -> Coasting:
    """An impulse per mass at an arm against the motion along a unit vector: what stops it there, at most the limit."""
    speed = (body.vx - body.spin * arm_y) * x + (body.vy + body.spin * arm_x) * y
    lever = arm_x * y - arm_y * x
    impulse = clip(speed / (1.0 + lever * lever / supports.gyration), -limit, limit)
    return Coasting(
        body.x,
        body.y,
        body.heading,
        body.vx - impulse * x,
        body.vy - impulse * y,
        body.spin - impulse * lever / supports.gyration,
    )


# -- grip --------------------------------------------------------------------------------------------------------------


@kernel
def grips(body: Coasting, supports: Supports) -> bool:
    """Whether both axles go where their wheels point, no faster than their grip holds in that bend."""
    if not supports.rolls:
        return False
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    ahead, aside = body.vx * cos + body.vy * sin, body.vy * cos - body.vx * sin
    rear = aside + body.spin * supports.rear
    front = (aside + body.spin * supports.front) * math.cos(supports.steer) - ahead * math.sin(supports.steer)
    bend = ahead * ahead * abs(_curvature(supports))
    return abs(rear) <= GRIPS and abs(front) <= GRIPS and bend <= supports.rear_grip + supports.front_grip


@inlined
def _curvature(supports: Supports) -> float:
    return math.tan(supports.steer) / (supports.front - supports.rear)


@kernel
def roll(body: Coasting, supports: Supports, duration: float) -> Coasting:
    """Roll for a time [s], forwards or backwards, along the arc of the wheels, slower and slower (`bicycle.drive`)."""
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    speed = body.vx * cos + body.vy * sin
    way, slower = travelled(abs(speed), -supports.rolling, duration)
    way, slower = math.copysign(way, speed), math.copysign(slower, speed)
    curvature = _curvature(supports)
    sinc, half_sin, half_cos = small_turn(0.5 * way * curvature)
    heading = body.heading + way * curvature
    x, y = body.x + supports.rear * cos, body.y + supports.rear * sin
    x += way * sinc * (cos * half_cos - sin * half_sin)
    y += way * sinc * (sin * half_cos + cos * half_sin)
    cos, sin = math.cos(heading), math.sin(heading)
    spin = slower * curvature
    swing = -supports.rear * spin
    return Coasting(
        x - supports.rear * cos,
        y - supports.rear * sin,
        heading,
        slower * cos - swing * sin,
        slower * sin + swing * cos,
        spin,
    )


@inlined
def has_axles(kind: int) -> bool:
    """Whether a kind stays on wheels that roll when nobody drives: two-wheelers fall over."""
    return kind == ActorKind.CAR or kind == ActorKind.TRUCK or kind == ActorKind.BUS


@inlined
def supports_of(
    rolls: bool,
    length: float,
    width: float,
    wheelbase: float,
    rear_to_center: float,
    friction: float,
    steer: float,
    rolling: float,
    gyration: float,
) -> Supports:
    """Axles with their static loads; what has no wheels stands a quarter of its length from the centre either way."""
    grip = friction * GRAVITY
    inertia = gyration * (length * length + width * width)
    if not (0.0 < rear_to_center < wheelbase):
        quarter = 0.25 * length
        return Supports(False, -quarter, quarter, 0.5 * grip, 0.5 * grip, 0.0, 0.0, inertia)
    ahead = wheelbase - rear_to_center
    rear, front = grip * ahead / wheelbase, grip * rear_to_center / wheelbase
    return Supports(rolls, -rear_to_center, ahead, rear, front, rolling * GRAVITY, steer, inertia)
