"""Measures of one pair that assume the worst of others: the distances of responsibility-sensitive safety, and WTTC."""

import math
from typing import NamedTuple

from engine.kernels.conflict import SAME_WAY, Snapshot, shadow
from engine.kernels.geometry import half_diagonal, shortest_turn
from engine.kernels.jit import inlined, kernel

MEETING = 1e-9
"""Circles nearer than this touch [m]."""
MAX_ADVANCES = 10_000


class Responsibility(NamedTuple):
    """What responsibility-sensitive safety takes everybody to be able to do, and to be bound to do."""

    response: float
    """Until somebody begins to brake [s]."""
    speeding_up: float
    """At most, until then [m/s^2]."""
    hardest_braking: float
    """Of one ahead, at most [m/s^2]."""
    braking: float
    """That everybody else reaches at least [m/s^2] …"""
    braking_in_lane: float
    """… and one whose own lane it is, in front of oncoming traffic [m/s^2]."""
    drifting: float
    """Towards each other, at most, during the response [m/s^2] …"""
    drift_braking: float
    """… and at least, afterwards and away from each other [m/s^2]."""
    margin: float
    """That must be left between the two beside one another [m]."""


@kernel
def is_dangerous(now: Snapshot, rules: Responsibility) -> bool:
    """Whether the two are nearer than safe, both along the ego's direction and across it.

    Shalev-Shwartz, Shammah and Shashua (2017), "On a formal model of safe and scalable self-driving cars",
    arXiv:1708.06374, definitions 1, 2, 6 and 9, with the ego's heading in the place of the lane's. They are of two on
    the same road: of two who cross, whose safety hangs on who goes first, this says nothing (False).
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
    """Definition 1: the gap [m] that the one behind needs, if the one ahead may brake as hard as can be."""
    faster = behind + rules.response * rules.speeding_up
    way = 0.5 * (behind + faster) * rules.response + faster**2 / (2.0 * rules.braking)
    return max(0.0, way - leading**2 / (2.0 * rules.hardest_braking))


@kernel
def safe_gap_oncoming(in_lane: float, oncoming: float, rules: Responsibility) -> float:
    """Definition 2: the gap [m] in which both come to a stand, the first of them in its own lane."""
    mine, theirs = in_lane + rules.response * rules.speeding_up, oncoming + rules.response * rules.speeding_up
    way = 0.5 * (in_lane + mine + oncoming + theirs) * rules.response
    return way + mine**2 / (2.0 * rules.braking_in_lane) + theirs**2 / (2.0 * rules.braking)


@kernel
def safe_gap_beside(one: float, other: float, rules: Responsibility) -> float:
    """Definition 6: the gap [m] between two beside one another who move towards each other at these speeds."""
    return rules.margin + max(0.0, _drift(one, rules) + _drift(other, rules))


@inlined
def _drift(speed: float, rules: Responsibility) -> float:
    """How far somebody comes sideways before it has stopped to; negative away from the other [m]."""
    after = speed + rules.response * rules.drifting
    return 0.5 * (speed + after) * rules.response + after * abs(after) / (2.0 * rules.drift_braking)


@kernel
def worst_time_to_collision(now: Snapshot, agility: float) -> float:
    """WTTC [s]: the earliest contact if both, from now on, may accelerate anywhere, by `agility` [m/s^2] in all.

    Wachenfeld, Junietz, Wenzel and Winner (2016), "The worst-time-to-collision metric for situation identification",
    IEEE Intelligent Vehicles Symposium: the first t with |p + v t| = r1 + r2 + agility t^2 / 2, where p and v are way
    and relative velocity of the centres, r1 and r2 radii of circles about the outlines, and `agility` is the sum of
    both accelerations. Found by advances that can never overshoot; infinite if the two can never touch.
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
