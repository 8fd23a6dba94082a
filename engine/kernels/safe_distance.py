"""Worst-case measures of a pair: the distances of responsibility-sensitive safety, and WTTC."""

import math
from typing import NamedTuple

from engine.kernels.conflict import SAME_WAY, Snapshot, shadow
from engine.kernels.geometry import half_diagonal, shortest_turn
from engine.kernels.jit import inlined, kernel

MEETING = 1e-9
"""Circles nearer than this touch [m]."""
MAX_ADVANCES = 10_000


class Responsibility(NamedTuple):
    """Assumed capabilities and obligations of all actors in responsibility-sensitive safety."""

    response: float
    """Time until an actor begins to brake [s]."""
    speeding_up: float
    """Largest acceleration until then [m/s^2]."""
    hardest_braking: float
    """Largest deceleration of an actor ahead [m/s^2]."""
    braking: float
    """Least deceleration of every other actor [m/s^2]."""
    braking_in_lane: float
    """Least deceleration of an actor in its own lane, in front of oncoming traffic [m/s^2]."""
    drifting: float
    """Largest lateral acceleration towards each other during the response [m/s^2]."""
    drift_braking: float
    """Least lateral deceleration afterwards [m/s^2]."""
    margin: float
    """Least lateral distance between the two [m]."""


@kernel
def is_dangerous(now: Snapshot, rules: Responsibility) -> bool:
    """Return True if the distance is less than safe both along the ego's direction and across it.

    Shalev-Shwartz, Shammah and Shashua (2017), "On a formal model of safe and scalable self-driving cars",
    arXiv:1708.06374, definitions 1, 2, 6 and 9, with the ego's heading instead of the lane's. They apply to two actors
    on the same road; for crossing actors, whose safety depends on their order, the result is False.
    """
    cos, sin = math.cos(now.ego.heading), math.sin(now.ego.heading)
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    ahead, aside = cos * x + sin * y, cos * y - sin * x
    turn = abs(shortest_turn(now.ego.heading, now.other.heading))
    if SAME_WAY <= turn <= math.pi - SAME_WAY:
        return False
    mine, theirs = cos * now.ego_rate.x + sin * now.ego_rate.y, cos * now.other_rate.x + sin * now.other_rate.y
    gap = abs(ahead) - 0.5 * now.ego.length - shadow(now.other, cos, sin)
    if turn < SAME_WAY:
        behind, leading = (mine, theirs) if ahead >= 0.0 else (theirs, mine)
        needed = safe_gap_behind(max(behind, 0.0), max(leading, 0.0), rules)
    elif ahead >= 0.0:
        needed = safe_gap_oncoming(max(mine, 0.0), max(-theirs, 0.0), rules)
    else:
        needed = 0.0
    across = abs(aside) - 0.5 * now.ego.width - shadow(now.other, -sin, cos)
    to_left = 1.0 if aside >= 0.0 else -1.0
    towards = to_left * (cos * now.ego_rate.y - sin * now.ego_rate.x)
    they_towards = -to_left * (cos * now.other_rate.y - sin * now.other_rate.x)
    return gap < needed and across < safe_gap_beside(towards, they_towards, rules)


@kernel
def safe_gap_behind(behind: float, leading: float, rules: Responsibility) -> float:
    """Return definition 1: the gap [m] that the follower needs if the leader may brake at its limit."""
    faster = behind + rules.response * rules.speeding_up
    way = 0.5 * (behind + faster) * rules.response + faster**2 / (2.0 * rules.braking)
    return max(0.0, way - leading**2 / (2.0 * rules.hardest_braking))


@kernel
def safe_gap_oncoming(in_lane: float, oncoming: float, rules: Responsibility) -> float:
    """Return definition 2: the gap [m] in which both stop, the first of them in its own lane."""
    mine, theirs = in_lane + rules.response * rules.speeding_up, oncoming + rules.response * rules.speeding_up
    way = 0.5 * (in_lane + mine + oncoming + theirs) * rules.response
    return way + mine**2 / (2.0 * rules.braking_in_lane) + theirs**2 / (2.0 * rules.braking)


@kernel
def safe_gap_beside(one: float, other: float, rules: Responsibility) -> float:
    """Return definition 6: the lateral gap [m] between two actors that approach each other at these speeds [m/s]."""
    return rules.margin + max(0.0, _drift(one, rules) + _drift(other, rules))


@inlined
def _drift(speed: float, rules: Responsibility) -> float:
    """Return the lateral distance that an actor covers until it must have stopped [m]; negative away from the other."""
    after = speed + rules.response * rules.drifting
    return 0.5 * (speed + after) * rules.response + after * abs(after) / (2.0 * rules.drift_braking)


@kernel
def worst_time_to_collision(now: Snapshot, agility: float) -> float:
    """Return WTTC [s]: the earliest contact if both accelerate in any direction, by `agility` [m/s^2] in sum.

    Wachenfeld, Junietz, Wenzel and Winner (2016), "The worst-time-to-collision metric for situation identification",
    IEEE Intelligent Vehicles Symposium: the first t with |p + v t| = r1 + r2 + agility t^2 / 2, where p and v are
    distance vector and relative velocity of the centres, r1 and r2 radii of circles about the outlines, and `agility`
    is the sum of both accelerations. Found by advances that can never overshoot; infinite if the two can never touch.
    """
    x, y = now.other.x - now.ego.x, now.other.y - now.ego.y
    vx, vy = now.other_rate.x - now.ego_rate.x, now.other_rate.y - now.ego_rate.y
    reach = half_diagonal(now.ego) + half_diagonal(now.other)
    speed = math.hypot(vx, vy)
    time = 0.0
    for _ in range(MAX_ADVANCES):
        apart = math.hypot(x + vx * time, y + vy * time) - reach - 0.5 * agility * time * time
        if apart <= MEETING:
            return time
        if agility == 0.0 and (x + vx * time) * vx + (y + vy * time) * vy >= 0.0:
            return math.inf
        fastest = speed + agility * time
        time += 2.0 * apart / (fastest + math.sqrt(fastest * fastest + 2.0 * agility * apart))
    return time
