"""Latest instants and least accelerations by which the ego avoids one other actor, by braking or steering.

The other's velocity and heading stay constant. So do the ego's up to some instant, then it accelerates steadily along
or across its direction of motion, its outline unturned: the point mass of Hillenbrand, Spieker and Kroschel (2006), "A
multilevel collision mitigation approach", IEEE Transactions on Intelligent Transportation Systems 7(4). Relative to the
ego the other then moves on a parabola, so that contact follows from quadratic equations and needs no steps in time.

Infinity means that nothing is needed; minus infinity, or an infinite acceleration, that nothing avoids contact.
"""

import math
from typing import NamedTuple

from engine.kernels.conflict import Snapshot, shadow, time_to_collision
from engine.kernels.jit import inlined, kernel
from engine.kernels.pair import NOISE_FLOOR

TOUCHING = 1e-9
"""Shadows that overlap by less than this far from it touch [m]: a root is where they do, but for rounding."""
INSTANTS = 64
"""Number of instants before contact at which a manoeuvre is tried: a later one may help even if an earlier does not."""
HALVINGS = 50
"""Number of bisections of an interval, to rounding precision."""
MOST = 1e4
"""Accelerations beyond this are none [m/s^2]."""


class Maneuver(NamedTuple):
    """A steady acceleration from `begin` to `end` [s], along the ego's motion and to its left [m/s^2]."""

    begin: float
    end: float
    along: float
    aside: float


class _Axes(NamedTuple):
    """Directions of both outlines, and how near the centres may come on each axis without an overlap of shadows [m]."""

    ego_cos: float
    ego_sin: float
    other_cos: float
    other_sin: float
    ego_along: float
    ego_across: float
    other_along: float
    other_across: float


class _Phase(NamedTuple):
    """A stretch of relative motion: way between the centres, its rate, its acceleration at the start; how long."""

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    lasts: float


@kernel
def evades(now: Snapshot, maneuver: Maneuver) -> bool:
    """Return True if the outlines never touch during and after the manoeuvre, with the other at constant velocity."""
    axes = _axes(now)
    ux, uy = _direction(now)
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    vx, vy = now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y
    ax, ay = maneuver.aside * uy - maneuver.along * ux, -maneuver.aside * ux - maneuver.along * uy
    lasts = maneuver.end - maneuver.begin
    if _meets(axes, _Phase(x, y, vx, vy, 0.0, 0.0, maneuver.begin)):
        return False
    x, y = x + vx * maneuver.begin, y + vy * maneuver.begin
    if _meets(axes, _Phase(x, y, vx, vy, ax, ay, lasts)):
        return False
    if lasts == math.inf:
        return True
    x, y = x + (vx + 0.5 * ax * lasts) * lasts, y + (vy + 0.5 * ay * lasts) * lasts
    vx, vy = vx + ax * lasts, vy + ay * lasts
    if abs(math.hypot(now.ego_rate.x, now.ego_rate.y) + maneuver.along * lasts) <= NOISE_FLOOR:
        vx, vy = now.other_rate.x, now.other_rate.y  # it stands: a speed from rounding would move it for ever
    return not _meets(axes, _Phase(x, y, vx, vy, 0.0, 0.0, math.inf))


@inlined
def _direction(now: Snapshot) -> tuple[float, float]:
    """Return the unit vector of the ego's motion; that of its heading if it stands."""
    speed = math.hypot(now.ego_rate.x, now.ego_rate.y)
    if speed > 0.0:
        return now.ego_rate.x / speed, now.ego_rate.y / speed
    return math.cos(now.ego.heading), math.sin(now.ego.heading)


@inlined
def _axes(now: Snapshot) -> _Axes:
    cos, sin = math.cos(now.ego.heading), math.sin(now.ego.heading)
    other_cos, other_sin = math.cos(now.other.heading), math.sin(now.other.heading)
    return _Axes(
        cos,
        sin,
        other_cos,
        other_sin,
        0.5 * now.ego.length + shadow(now.other, cos, sin),
        0.5 * now.ego.width + shadow(now.other, -sin, cos),
        0.5 * now.other.length + shadow(now.ego, other_cos, other_sin),
        0.5 * now.other.width + shadow(now.ego, -other_sin, other_cos),
    )


@kernel
def _meets(axes: _Axes, phase: _Phase) -> bool:
    """Return True if the outlines overlap at any time of a phase.

    An overlap begins at the phase's start, or when an overlap of the projections on an axis begins: only these instants
    are tested.
    """
    if _overlap_after(axes, phase, 0.0):
        return True
    for axis in range(4):
        nx, ny, reach = axes.ego_cos, axes.ego_sin, axes.ego_along
        if axis == 1:
            nx, ny, reach = -axes.ego_sin, axes.ego_cos, axes.ego_across
        elif axis == 2:
            nx, ny, reach = axes.other_cos, axes.other_sin, axes.other_along
        elif axis == 3:
            nx, ny, reach = -axes.other_sin, axes.other_cos, axes.other_across
        place, rate = nx * phase.x + ny * phase.y, nx * phase.vx + ny * phase.vy
        bend = 0.5 * (nx * phase.ax + ny * phase.ay)
        for side in range(2):
            first, second = _roots(bend, rate, place - reach if side == 0 else place + reach)
            for root in (first, second):
                if 0.0 < root <= phase.lasts and _overlap_after(axes, phase, root):
                    return True
    return False


@inlined
def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the times t with a t^2 + b t + c = 0; -1 for a missing root."""
    if a == 0.0:
        return (-c / b if b != 0.0 else -1.0), -1.0
    inside = b * b - 4.0 * a * c
    if inside < 0.0:
        return -1.0, -1.0
    half = -0.5 * (b + math.copysign(math.sqrt(inside), b))  # no difference of nearly equal numbers
    return half / a, (c / half if half != 0.0 else -1.0)


@inlined
def _overlap_after(axes: _Axes, phase: _Phase, time: float) -> bool:
    x = phase.x + (phase.vx + 0.5 * phase.ax * time) * time
    y = phase.y + (phase.vy + 0.5 * phase.ay * time) * time
    return (
        abs(axes.ego_cos * x + axes.ego_sin * y) <= axes.ego_along + TOUCHING
        and abs(axes.ego_cos * y - axes.ego_sin * x) <= axes.ego_across + TOUCHING
        and abs(axes.other_cos * x + axes.other_sin * y) <= axes.other_along + TOUCHING
        and abs(axes.other_cos * y - axes.other_sin * x) <= axes.other_across + TOUCHING
    )


# -- how late ---------------------------------------------------------------------------------------------------------


@kernel
def time_to_brake(now: Snapshot, braking: float) -> float:
    """Return TTB [s]: the latest instant at which braking by `braking` [m/s^2] to a stop still avoids contact.

    Hillenbrand et al. (2006). Behind a vehicle at constant lower speed it is TTC - dv / (2 braking).
    """
    return _latest(now, -braking, 0.0, math.inf)


@kernel
def time_to_kick_down(now: Snapshot, acceleration: float, top_speed: float) -> float:
    """Return TTK [s]: the latest instant at which accelerating, up to `top_speed` [m/s], still avoids contact.

    Hillenbrand et al. (2006).
    """
    return _latest(now, acceleration, 0.0, top_speed)


@kernel
def time_to_steer(now: Snapshot, grip: float) -> float:
    """Return TTS [s]: the latest instant at which swerving by `grip` [m/s^2], to the better side, avoids contact.

    Hillenbrand et al. (2006). Straight behind another it is TTC - sqrt(2 lateral distance / grip).
    """
    return max(_latest(now, 0.0, grip, math.inf), _latest(now, 0.0, -grip, math.inf))


@kernel
def _latest(now: Snapshot, along: float, aside: float, top_speed: float) -> float:
    """Return the latest instant before contact at which the manoeuvre avoids it [s]; minus infinity if none."""
    ttc = time_to_collision(now)
    if ttc == math.inf:
        return math.inf
    lasts = _lasts(now, along, aside, top_speed)
    for number in range(INSTANTS, -1, -1):
        helps = ttc * number / INSTANTS
        if lasts > 0.0 and evades(now, Maneuver(helps, helps + lasts, along, aside)):
            too_late = ttc * min(number + 1, INSTANTS) / INSTANTS
            for _ in range(HALVINGS):
                middle = 0.5 * (helps + too_late)
                if evades(now, Maneuver(middle, middle + lasts, along, aside)):
                    helps = middle
                else:
                    too_late = middle
            return helps
    return -math.inf


@inlined
def _lasts(now: Snapshot, along: float, aside: float, top_speed: float) -> float:
    """Return the longest duration of such an acceleration [s]; 0 for braking or swerving at a stand."""
    speed = math.hypot(now.ego_rate.x, now.ego_rate.y)
    if along < 0.0:
        return -speed / along
    if along > 0.0:
        return max(0.0, top_speed - speed) / along
    return math.inf if aside != 0.0 and speed > 0.0 else 0.0


# -- how hard ---------------------------------------------------------------------------------------------------------


@kernel
def braking_needed(now: Snapshot) -> float:
    """Return a_req [m/s^2]: the least deceleration of the ego alone, from now to a stop, that avoids contact.

    Jansson (2005), "Collision avoidance theory", PhD thesis, Linkoping, section 5.3.5: behind a vehicle at constant
    lower speed it is dv^2 / (2 gap). DRAC is that of the relative motion instead, which on crossing paths is that of
    neither vehicle. 0 without a contact ahead, infinite if no braking avoids it.
    """
    return _least(now, -1.0, 0.0)


@kernel
def swerving_needed(now: Snapshot) -> float:
    """Return a_lat_req [m/s^2]: the least lateral acceleration of the ego alone, from now on, that avoids contact.

    Jansson (2005), section 5.3.8: straight behind another it is 2 (lateral distance) / TTC^2. To the better side.
    """
    return min(_least(now, 0.0, 1.0), _least(now, 0.0, -1.0))


@kernel
def _least(now: Snapshot, along: float, aside: float) -> float:
    """Return the least acceleration in a direction that avoids contact [m/s^2]; infinity above `MOST`."""
    if time_to_collision(now) == math.inf:
        return 0.0
    low, high = 0.0, 1.0
    while not _avoided_by(now, along * high, aside * high):
        low, high = high, 2.0 * high
        if high > MOST:
            return math.inf
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _avoided_by(now, along * middle, aside * middle):
            high = middle
        else:
            low = middle
    return high


@inlined
def _avoided_by(now: Snapshot, along: float, aside: float) -> bool:
    lasts = _lasts(now, along, aside, math.inf)
    return lasts > 0.0 and evades(now, Maneuver(0.0, lasts, along, aside))
