"""Surrogate measures of safety of one pair beside those of `pair`: TTC, DRAC, THW, time gap, PET.

"TTC" alone is not one number: the same left turn has 4.25 s, 4.06 s, 1.96 s or infinity under four usual definitions.
Each function says which one it is. Infinity means that the danger measured is not there.
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
    """One pair at an instant: the outlines and their centres' velocities."""

    ego: Box
    other: Box
    ego_rate: Rate
    other_rate: Rate


@kernel
def snapshot(
    states: Floats, samples: int, k: int, part: float, time_step: float, other: int, outlines: Floats
) -> Snapshot:
    """The pair at sample k, or a part (0..1) of a step later, in between linearly; arrays as in `measure_pair`."""
    after = min(k + 1, samples - 1)
    return Snapshot(
        outline_between(states, k, after, part, 0, outlines),
        outline_between(states, k, after, part, other, outlines),
        _rate_between(states, samples, k, after, part, time_step, 0, outlines),
        _rate_between(states, samples, k, after, part, time_step, other, outlines),
    )


@inlined
def _rate_between(
    states: Floats, samples: int, k: int, after: int, part: float, time_step: float, actor: int, outlines: Floats
) -> Rate:
    start = center_velocity(states, samples, k, time_step, actor, outlines[actor, 2])
    end = center_velocity(states, samples, after, time_step, actor, outlines[actor, 2])
    return Rate(start.x + part * (end.x - start.x), start.y + part * (end.y - start.y))


@kernel
def relative_speed(now: Snapshot) -> float:
    """Magnitude of the difference of the centres' velocities [m/s]."""
    return math.hypot(now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y)


@kernel
def time_to_collision(now: Snapshot) -> float:
    """TTC [s]: when the outlines would touch if both kept velocity and heading; infinity if never, 0 on overlap.

    Hayward (1972), "Near-miss determination through use of a scale of danger", Highway Research Record 384, with
    outlines in the plane as in Laureshyn, Svensson & Hyden (2010), Accid. Anal. Prev. 42(6). Exact: rectangles that
    only translate overlap while their shadows do on all four of their axes.
    """
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    vx, vy = now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y
    ego_cos, ego_sin = math.cos(now.ego.heading), math.sin(now.ego.heading)
    other_cos, other_sin = math.cos(now.other.heading), math.sin(now.other.heading)
    enter, leave = 0.0, math.inf
    for axis in range(4):
        heading = (now.ego.heading if axis < 2 else now.other.heading) + (0.5 * math.pi if axis % 2 else 0.0)
        nx, ny = math.cos(heading), math.sin(heading)
        reach = _shadow(now.ego, ego_cos, ego_sin, nx, ny) + _shadow(now.other, other_cos, other_sin, nx, ny)
        first, last = _within(nx * x + ny * y, nx * vx + ny * vy, reach)
        enter, leave = max(enter, first), min(leave, last)
        if enter > leave:
            return math.inf
    return enter if enter <= leave else math.inf


@inlined
def _within(position: float, speed: float, reach: float) -> tuple[float, float]:
    """From when to when |position + speed t| <= reach; an interval that starts at infinity is empty. A speed that may
    be rounding noise is none.
    """
    if abs(speed) <= NOISE_FLOOR:
        return (-math.inf, math.inf) if abs(position) <= reach else (math.inf, -math.inf)
    one, other = (-reach - position) / speed, (reach - position) / speed
    return min(one, other), max(one, other)


@inlined
def shadow(box: Box, nx: float, ny: float) -> float:
    """Half the length of an outline's shadow on a direction [m]."""
    return _shadow(box, math.cos(box.heading), math.sin(box.heading), nx, ny)


@inlined
def _shadow(box: Box, cos: float, sin: float, nx: float, ny: float) -> float:
    """The same, by the direction of the outline's heading."""
    return 0.5 * (box.length * abs(cos * nx + sin * ny) + box.width * abs(cos * ny - sin * nx))


@kernel
def required_deceleration(now: Snapshot) -> float:
    """DRAC [m/s^2]: deceleration that ends the relative motion on the way that is left before contact; 0 if none is.

    On the collision course that `time_to_collision` assumes, that way is |v| TTC, hence |v|^2 / (2 |v| TTC). For one
    car behind another this is the (v2 - v1)^2 / (2 gap) of Cooper & Ferguson (1976), "Traffic studies at
    T-junctions", Traffic Engineering & Control 17(7). Infinite on contact.
    """
    ttc = time_to_collision(now)
    if ttc == 0.0:
        return math.inf
    return 0.0 if ttc == math.inf else relative_speed(now) / (2.0 * ttc)


class Lead(NamedTuple):
    """The other as seen by one who follows it."""

    follows: bool
    """Whether the other leads; else the rest means nothing."""
    ahead: float
    """From centre to centre along the ego's heading [m]."""
    reach: float
    """Half the length of the other's shadow on that heading [m]."""
    speed: float
    """Of the ego, along its heading [m/s]; positive."""


@inlined
def _lead(now: Snapshot) -> Lead:
    """The other leads when it is ahead, heads the same way but for 45 degrees, and reaches into the strip that the
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
    """THW [s]: time until the ego's front is where the other's front is now, if the other leads; else infinity.

    Vogel (2003), "A comparison of headway and time to collision as safety indicators", Accid. Anal. Prev. 35(3). The
    leader's length counts; `time_gap` leaves it out.
    """
    lead = _lead(now)
    return max(0.0, lead.ahead + lead.reach - 0.5 * now.ego.length) / lead.speed if lead.follows else math.inf


@kernel
def time_gap(now: Snapshot) -> float:
    """Time gap [s]: time until the ego's front is where the other's rear is now, if the other leads; else infinity.

    SAE J2944 (2015), "Operational definitions of driving performance measures and statistics", tells it from headway.
    """
    lead = _lead(now)
    return max(0.0, lead.ahead - lead.reach - 0.5 * now.ego.length) / lead.speed if lead.follows else math.inf


@kernel
def post_encroachment_time(states: Floats, together: int, time_step: float, other: int, outlines: Floats) -> float:
    """PET [s]: the least time between the one's being at a place and the other's being there; infinity if no place
    is shared. Positive when the ego was there first, negative when the other was, 0 on contact.

    Allen, Shin & Cooper (1978), "Analysis of traffic conflicts and collisions", Transportation Research Record 667,
    define it for a given conflict area. Here the area is every place that both outlines cover: PET is the shift of
    one motion in time, least in magnitude, by which the two would have touched. It is found by conservative
    advancement of that shift: by a shift of t nobody comes nearer than (top speed) t. Of two equal ones the positive
    counts. Arrays as in `measure_pair`; the first `together` samples count.
    """
    longest = (together - 1) * time_step
    ego_first = _least_shift(states, together, time_step, 0, other, outlines, longest)
    other_first = _least_shift(states, together, time_step, other, 0, outlines, min(ego_first, longest))
    return ego_first if ego_first <= other_first else -other_first


@kernel
def _least_shift(
    states: Floats, together: int, time_step: float, first: int, second: int, outlines: Floats, longest: float
) -> float:
    """The least shift [s], up to `longest`, after which `second` would touch where `first` has been."""
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
    """The most that any point of an outline moves in a step, as a speed [m/s]."""
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
    """Least distance [m] between `first` and where `second` is `shift` steps later, over all times that both have.

    Shifted, a step of the one spans the end of one step and the start of the next of the other, so it is cut there.
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
    """An outline a part of a step after sample k, which is not the last."""
    return outline_between(states, k, k + 1, part, actor, outlines)
