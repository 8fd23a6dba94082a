"""Surrogate measures of safety of a pair in addition to those of `pair`: TTC, DRAC, THW, time gap, PET.

"TTC" alone is not one number: the same left turn has 4.25 s, 4.06 s, 1.96 s or infinity under four usual definitions.
Each function names its definition. Infinity means that the measured danger does not exist.
"""

import math
from typing import NamedTuple

from engine.kernels.approach import closest_in_step
from engine.kernels.geometry import Box, outline_between, shortest_turn
from engine.kernels.jit import inlined, kernel
from engine.kernels.pair import NOISE_FLOOR, Rate, center_velocity
from engine.tables import Floats
from engine.vocabulary import State

SAME_WAY = math.pi / 4.0
"""A leader's heading differs by less than this from the follower's [rad]."""
OVERLAP = 1e-4
"""Outlines nearer than this share a place [m]; as in `approach.TOUCH`."""
MAX_SHIFTS = 10_000


class Snapshot(NamedTuple):
    """A pair at an instant: the outlines and their centres' velocities."""

    ego: Box
    other: Box
    ego_rate: Rate
    other_rate: Rate


@kernel
def snapshot(
    states: Floats, samples: int, k: int, part: float, time_step: float, other: int, outlines: Floats
) -> Snapshot:
    """Return the pair at sample k plus a part (0..1) of a step, interpolated linearly; arrays as in `measure_pair`."""
    after = min(k + 1, samples - 1)
    return Snapshot(
        outline_between(states, k, after, part, 0, outlines),
        outline_between(states, k, after, part, other, outlines),
        _rate_between(states, samples, k, part, time_step, 0, outlines),
        _rate_between(states, samples, k, part, time_step, other, outlines),
    )


@inlined
def _rate_between(
    states: Floats, samples: int, k: int, part: float, time_step: float, actor: int, outlines: Floats
) -> Rate:
    after = min(k + 1, samples - 1)
    start = center_velocity(states, samples, k, time_step, actor, outlines[actor, 2])
    end = center_velocity(states, samples, after, time_step, actor, outlines[actor, 2])
    return Rate(start.x + part * (end.x - start.x), start.y + part * (end.y - start.y))


@kernel
def relative_speed(now: Snapshot) -> float:
    """Return the magnitude of the difference of the centres' velocities [m/s]."""
    return math.hypot(now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y)


@kernel
def time_to_collision(now: Snapshot) -> float:
    """Return TTC [s]: time until contact at constant velocities and headings; infinity if never, 0 on overlap.

    Hayward (1972), "Near-miss determination through use of a scale of danger", Highway Research Record 384, with
    outlines in the plane as in Laureshyn, Svensson & Hyden (2010), Accid. Anal. Prev. 42(6). Exact: rectangles that
    only translate overlap while their projections do on all four of their axes.
    """
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    vx, vy = now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y
    ego_cos, ego_sin = math.cos(now.ego.heading), math.sin(now.ego.heading)
    other_cos, other_sin = math.cos(now.other.heading), math.sin(now.other.heading)
    enter, leave = 0.0, math.inf
    for axis in range(4):
        heading = (now.ego.heading if axis < 2 else now.other.heading) + (0.5 * math.pi if axis % 2 else 0.0)
        nx, ny = math.cos(heading), math.sin(heading)
        reach = turned_shadow(now.ego.length, now.ego.width, ego_cos, ego_sin, nx, ny)
        reach += turned_shadow(now.other.length, now.other.width, other_cos, other_sin, nx, ny)
        first, last = _within(nx * x + ny * y, nx * vx + ny * vy, reach)
        enter, leave = max(enter, first), min(leave, last)
        if enter > leave:
            return math.inf
    return enter if enter <= leave else math.inf


@inlined
def _within(position: float, speed: float, reach: float) -> tuple[float, float]:
    """Return the begin and end of |position + speed t| <= reach; an interval that begins at infinity is empty. A speed
    that may be rounding noise counts as 0.
    """
    if abs(speed) <= NOISE_FLOOR:
        return (-math.inf, math.inf) if abs(position) <= reach else (math.inf, -math.inf)
    one, other = (-reach - position) / speed, (reach - position) / speed
    return min(one, other), max(one, other)


@inlined
def shadow(box: Box, nx: float, ny: float) -> float:
    """Return half the length of an outline's projection on a direction [m]."""
    return turned_shadow(box.length, box.width, math.cos(box.heading), math.sin(box.heading), nx, ny)


@inlined
def turned_shadow(length: float, width: float, cos: float, sin: float, nx: float, ny: float) -> float:
    """Return the same as `shadow`, from an outline's size [m], and the cosine and sine of its heading."""
    return 0.5 * (length * abs(cos * nx + sin * ny) + width * abs(cos * ny - sin * nx))


@kernel
def required_deceleration(now: Snapshot) -> float:
    """Return DRAC [m/s^2]: deceleration that ends the relative motion before contact; 0 without a collision course.

    On the collision course that `time_to_collision` assumes, the distance left is |v| TTC, hence |v|^2 / (2 |v| TTC).
    For one car behind another this is the (v2 - v1)^2 / (2 gap) of Cooper & Ferguson (1976), "Traffic studies at
    T-junctions", Traffic Engineering & Control 17(7). Infinite on contact.
    """
    ttc = time_to_collision(now)
    if ttc == 0.0:
        return math.inf
    return 0.0 if ttc == math.inf else relative_speed(now) / (2.0 * ttc)


class Lead(NamedTuple):
    """The other actor as leader of the ego."""

    follows: bool
    """True if the ego follows the other; else the other fields have no meaning."""
    ahead: float
    """Distance from centre to centre along the ego's heading [m]."""
    reach: float
    """Half the length of the other's projection on that heading [m]."""
    speed: float
    """Speed of the ego along its heading [m/s]; positive."""


@inlined
def _lead(now: Snapshot) -> Lead:
    """Return the other as leader: it is ahead, heads the same way within 45 degrees, and overlaps the strip that the
    ego's width sweeps straight ahead, while the ego moves.
    """
    cos, sin = math.cos(now.ego.heading), math.sin(now.ego.heading)
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    ahead, aside = cos * x + sin * y, cos * y - sin * x
    speed = cos * now.ego_rate.x + sin * now.ego_rate.y
    side_by_side = abs(aside) < 0.5 * now.ego.width + shadow(now.other, -sin, cos)
    same_way = abs(shortest_turn(now.ego.heading, now.other.heading)) < SAME_WAY
    follows = speed > 0.0 and ahead > 0.0 and side_by_side and same_way
    return Lead(follows, ahead, shadow(now.other, cos, sin), speed)


@kernel
def time_headway(now: Snapshot) -> float:
    """Return THW [s]: time until the ego's front reaches the other's present front, if the other leads; else infinity.

    Vogel (2003), "A comparison of headway and time to collision as safety indicators", Accid. Anal. Prev. 35(3). The
    leader's length counts; `time_gap` leaves it out.
    """
    lead = _lead(now)
    return max(0.0, lead.ahead + lead.reach - 0.5 * now.ego.length) / lead.speed if lead.follows else math.inf


@kernel
def time_gap(now: Snapshot) -> float:
    """Return the time [s] until the ego's front reaches the other's present rear, if the other leads; else infinity.

    SAE J2944 (2015), "Operational definitions of driving performance measures and statistics", distinguishes it from
    headway.
    """
    lead = _lead(now)
    return max(0.0, lead.ahead - lead.reach - 0.5 * now.ego.length) / lead.speed if lead.follows else math.inf


@kernel
def post_encroachment_time(states: Floats, together: int, time_step: float, other: int, outlines: Floats) -> float:
    """Return PET [s]: the least time between the presence of both at a place; infinity if they share no place. Positive
    if the ego was there first, negative if the other was, 0 on contact.

    Allen, Shin & Cooper (1978), "Analysis of traffic conflicts and collisions", Transportation Research Record 667,
    define it for a given conflict area. Here the area is every place that both outlines cover: PET is the shift of one
    motion in time, least in magnitude, by which the two would have touched. It is found by conservative advancement of
    that shift: a shift of t reduces the distance by at most (top speed) t. Of two equal shifts the positive counts.
    Arrays as in `measure_pair`; the first `together` samples count.
    """
    longest = (together - 1) * time_step
    ego_first = _least_shift(states, together, time_step, 0, other, outlines, longest)
    other_first = _least_shift(states, together, time_step, other, 0, outlines, min(ego_first, longest))
    return ego_first if ego_first <= other_first else -other_first


@kernel
def _least_shift(
    states: Floats, together: int, time_step: float, first: int, second: int, outlines: Floats, longest: float
) -> float:
    """Return the least shift [s], up to `longest`, at which `second` touches the earlier place of `first`; else
    infinity.
    """
    speed = _top_speed(states, together, time_step, second, outlines)
    shift = 0.0
    for _ in range(MAX_SHIFTS):
        distance = _distance_shifted(states, together, first, second, outlines, shift / time_step)
        if distance < OVERLAP:
            return shift
        if not distance < speed * (longest - shift):
            return math.inf
        shift += distance / speed
    return shift


@kernel
def _top_speed(states: Floats, together: int, time_step: float, actor: int, outlines: Floats) -> float:
    """Return the largest motion of any point of an outline in a step, as a speed [m/s]."""
    radius = 0.5 * math.hypot(outlines[actor, 0], outlines[actor, 1])
    top = 0.0
    for k in range(together - 1):
        dx = states[k + 1, actor, State.X] - states[k, actor, State.X]
        dy = states[k + 1, actor, State.Y] - states[k, actor, State.Y]
        turn = shortest_turn(states[k, actor, State.HEADING], states[k + 1, actor, State.HEADING])
        top = max(top, (math.hypot(dx, dy) + abs(turn) * radius) / time_step)
    return top


@kernel
def _distance_shifted(states: Floats, together: int, first: int, second: int, outlines: Floats, shift: float) -> float:
    """Return the least distance [m] between `first` and `second` `shift` steps later, over all their common times.

    A shifted step of `second` spans parts of two steps of `first`, so it is cut there.
    """
    whole = math.floor(shift)
    part = shift - whole
    best = math.inf
    for k in range(together - 1 - whole):
        j = k + whole
        a0, b0 = _at(states, k, 0.0, first, outlines), _at(states, j, part, second, outlines)
        a1, b1 = _at(states, k, 1.0 - part, first, outlines), _at(states, j, 1.0, second, outlines)
        best, _ = closest_in_step(a0, a1, b0, b1, best)
        if part > 0.0 and j + 2 < together:
            a2, b2 = _at(states, k, 1.0, first, outlines), _at(states, j + 1, part, second, outlines)
            best, _ = closest_in_step(a1, a2, b1, b2, best)
    return best


@inlined
def _at(states: Floats, k: int, part: float, actor: int, outlines: Floats) -> Box:
    """Return an outline at a part of a step after sample k, which is not the last sample."""
    return outline_between(states, k, k + 1, part, actor, outlines)
