"""The five reference drivers in NumPy, written from their sources and without code of the project.

The ego drives straight along the x axis. Motion comes as arrays of samples: x [m], y [m], heading [rad], speed [m/s]
and acceleration [m/s^2] of the other, x and speed of the ego.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81
TOUCH = 1e-4
"""Distance below which outlines touch [m]."""


@dataclass
class Encounter:
    """A collision to be judged."""

    step: float
    ego_x: Array
    ego_speed: Array
    """Motion of the ego as it would be without contact, for as long as drives last."""
    other: Array
    """(samples, 5) Motion of the other."""
    ego_size: tuple[float, float]
    other_size: tuple[float, float]
    other_ahead: float = 0.0
    """Distance from the point that moves along the heading to the centre of the other [m]."""
    brakes: float = 8.0
    """Full braking of the ego's brakes, or of its tyres if that is less [m/s^2]."""
    build_up: float = 0.0
    """Time in which the ego's brakes build up to that [s]."""

    @cached_property
    def contact(self) -> int:
        """The sample after first contact."""
        for k in range(len(self.ego_x) - 1):
            if self.touch(k, self.ego_x[k], self.ego_x[k + 1]):
                return k + 1
        raise AssertionError("no contact")

    def touch(self, k: int, x: float, x_after: float) -> bool:
        """Whether the outlines touch between the samples k and k + 1."""
        now, after = self.other[k], self.other[k + 1]
        start, end = np.array([[now[0] - x, now[1]]]), np.array([[after[0] - x_after, after[1]]])
        turn = np.array([0.5 * (now[2] + after[2])])
        return bool(meet(start, end, turn, self.ego_size, self.other_size)[0])

    def touch_at(self, k: int, x: float, part: float) -> bool:
        """Whether the outlines touch at a part of the step after sample k, with the ego at x."""
        now, after = self.other[k], self.other[k + 1]
        there = now + part * (after - now)
        place = np.array([[there[0] - x, there[1]]])
        return bool(meet(place, place, there[2:3], self.ego_size, self.other_size)[0])

    @cached_property
    def conflicts(self) -> list[bool]:
        """Whether there is a conflict at each sample before contact."""
        return [conflict_from(self, k, self.ego_x[k], self.ego_speed[k]) for k in range(self.contact)]

    @cached_property
    def distances(self) -> list[float]:
        """Distance to the other at each of these samples [m]."""
        return [distance(self, k, self.ego_x[k]) for k in range(self.contact)]

    def own_braking(self) -> Array:
        return np.append(np.maximum(0.0, self.ego_speed[:-1] - self.ego_speed[1:]) / self.step, 0.0)


def meet(
    start: Array, end: Array, turn: Array, size: tuple[float, float], other: tuple[float, float]
) -> NDArray[np.bool_]:
    """Whether rectangles meet while the second moves from `start` to `end` (n, 2), seen from the first, along x.

    Exact for rectangles that do not turn: they overlap while their projections do on all four of their axes.
    """
    (a, b), (c, d) = size, other
    cos, sin = np.cos(turn), np.sin(turn)
    zero, one = np.zeros_like(cos), np.ones_like(cos)
    axes = (
        (one, zero, a + c * np.abs(cos) + d * np.abs(sin)),
        (zero, one, b + c * np.abs(sin) + d * np.abs(cos)),
        (cos, sin, c + a * np.abs(cos) + b * np.abs(sin)),
        (-sin, cos, d + a * np.abs(sin) + b * np.abs(cos)),
    )
    first, last = zero.copy(), one.copy()
    for u, v, sizes in axes:
        both = sizes + 2.0 * TOUCH
        here, there = u * start[:, 0] + v * start[:, 1], u * end[:, 0] + v * end[:, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            edges = [(side * 0.5 * both - here) / (there - here) for side in (-1.0, 1.0)]
        still, inside = there == here, np.abs(here) <= 0.5 * both
        low, high = np.minimum(*edges), np.maximum(*edges)
        first = np.maximum(first, np.where(still, np.where(inside, 0.0, 2.0), low))
        last = np.minimum(last, np.where(still, np.where(inside, 1.0, -1.0), high))
    return first <= last


# -- driving on from a sample ------------------------------------------------------------------------------------------


def avoids(case: Encounter, begins: int | None, wanted) -> bool:
    """Whether the ego touches nothing if it decelerates by `wanted(k, x, speed, last)` from the sample `begins` on.

    It brakes no less than it had begun to before the contact of the case.
    """
    if begins is None or begins >= case.contact:
        return False
    own, contact = case.own_braking(), case.contact
    x, speed = case.ego_x[begins], case.ego_speed[begins]
    last = (speed - case.ego_speed[begins - 1]) / case.step if begins else 0.0
    held = own[max(begins - 1, 0)]
    for k in range(begins, last_sample(case)):
        held = max(held, own[k]) if k < contact else held
        braking = max(min(held, limit(case, wanted)), wanted(k, x, speed, last))
        slower = max(0.0, speed - braking * case.step)
        after = x + 0.5 * (speed + slower) * case.step
        if case.touch(k, x, after):
            return False
        x, last, speed = after, (slower - speed) / case.step, slower
    return True


def limit(case: Encounter, wanted) -> float:
    """The hardest braking that the ego's own pedal may give."""
    return min(case.brakes, getattr(wanted, "hardest", math.inf))


def last_sample(case: Encounter) -> int:
    """A case is followed until the careful driver has stopped, for at least six seconds after contact."""
    hardest = min(0.774 * GRAVITY, case.brakes)
    ramp = max(0.6, case.build_up * hardest / case.brakes)
    fastest = case.ego_speed[: case.contact].max()
    return case.contact + math.ceil(max(6.0, fastest / hardest + ramp) / case.step - 1e-9)


# -- the careful driver of UN R157, with a horizon of 4 s --------------------------------------------------------------


class CarefulBrakes:
    def __init__(self, case: Encounter, begins: int) -> None:
        self.case, self.begins = case, begins
        self.hardest = min(0.774 * GRAVITY, case.brakes)
        self.ramp = max(0.6, case.build_up * self.hardest / case.brakes)

    def __call__(self, k: int, x: float, speed: float, last: float) -> float:
        return self.hardest * min(1.0, (k - self.begins + 0.5) * self.case.step / self.ramp)


def careful(case: Encounter, sees: Callable[[int], bool] | None = None) -> bool:
    """Perceives what has been a conflict for 0.4 s, brakes 0.75 s later."""
    begins = careful_begins(case, sees or case.conflicts.__getitem__)
    return begins is not None and avoids(case, begins, CarefulBrakes(case, begins))


def careful_begins(case: Encounter, sees: Callable[[int], bool]) -> int | None:
    seen, needed = 0, math.ceil(0.4 / case.step - 1e-9)
    for k in range(case.contact):
        seen = seen + 1 if sees(k) else 0
        if seen > needed:
            return k + math.ceil(0.75 / case.step - 1e-9)
    return None


def conflict_from(case: Encounter, k: int, ego_x: float, ego_speed: float) -> bool:
    """Contact within 4 s if both go on; or a leader within 4 s of time gap that brakes by more than 5 m/s^2."""
    x, y, turn, speed, acceleration = case.other[k]
    if k and acceleration < -5.0 and time_gap(case, k, ego_x, ego_speed) < 4.0:
        return True
    rate = turn - case.other[max(k - 1, 0), 2]
    x, y = x - case.other_ahead * math.cos(turn), y - case.other_ahead * math.sin(turn)
    ahead = np.arange(math.ceil(4.0 / case.step - 1e-9) + 1)
    headings = turn + ahead * rate
    middles = headings[:-1] + 0.5 * rate
    xs = x + np.concatenate([[0.0], np.cumsum(speed * case.step * np.cos(middles))])
    ys = y + np.concatenate([[0.0], np.cumsum(speed * case.step * np.sin(middles))])
    xs, ys = xs + case.other_ahead * np.cos(headings), ys + case.other_ahead * np.sin(headings)
    places = np.column_stack([xs - ego_x - ahead * ego_speed * case.step, ys])
    turns = 0.5 * (headings[:-1] + headings[1:])
    return bool(meet(places[:-1], places[1:], turns, case.ego_size, case.other_size).any())


def time_gap(case: Encounter, k: int, ego_x: float, ego_speed: float) -> float:
    """Time until the ego's front reaches the present rear of a leader, in its way and of its direction."""
    x, y, turn, _, _ = case.other[k]
    (a, b), (c, d) = case.ego_size, case.other_size
    cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
    if abs(y) >= 0.5 * (b + c * sin + d * cos) or x <= ego_x or abs(turn) >= math.pi / 4 or ego_speed <= 1e-9:
        return math.inf
    return max(0.0, x - ego_x - 0.5 * (a + c * cos + d * sin)) / ego_speed


# -- counterfactuals: what each value of one quantity comes to ---------------------------------------------------------


def avoids_braking_at(case: Encounter, k: int) -> bool:
    return avoids(case, k, CarefulBrakes(case, k))


def avoids_with_sight(case: Encounter, sight: float) -> bool:
    """The careful driver, to whom the other is visible up to a distance of its centre to the other's outline."""
    return careful(case, lambda k: case.conflicts[k] and case.distances[k] <= sight)


def avoids_on(case: Encounter, friction: float, brakes: float, sight: float) -> bool:
    """The careful driver, who perceives as before, on a road of another friction; `brakes`: those of the car."""
    begins = careful_begins(case, lambda k: case.conflicts[k] and case.distances[k] <= sight)
    if begins is None:
        return False
    driver = CarefulBrakes(case, begins)
    driver.hardest = min(0.774 * GRAVITY, brakes, friction * GRAVITY)
    driver.ramp = max(0.6, case.build_up * driver.hardest / brakes)
    return avoids(case, begins, driver)


def distance(case: Encounter, k: int, ego_x: float) -> float:
    """Distance from the ego's centre to the other's outline [m]."""
    x, y, turn, _, _ = case.other[k]
    dx, dy, cos, sin = ego_x - x, -y, math.cos(turn), math.sin(turn)
    along = max(0.0, abs(cos * dx + sin * dy) - 0.5 * case.other_size[0])
    return math.hypot(along, max(0.0, abs(cos * dy - sin * dx) - 0.5 * case.other_size[1]))


def avoids_slower(case: Encounter, fastest: float, place: float = math.inf, sight: float = math.inf) -> bool:
    """The careful driver after an approach no faster than `fastest`; unseen, it can stop before `place`."""
    x, speed, seen, begins, held, limit = case.ego_x[0], case.ego_speed[0], 0, None, 0.0, fastest
    needed, delay = math.ceil(0.4 / case.step - 1e-9), math.ceil(0.75 / case.step - 1e-9)
    own, slowed, brakes = case.own_braking(), False, CarefulBrakes(case, last_sample(case))
    for k in range(last_sample(case)):
        if begins is None:
            visible = distance(case, k, x) <= sight
            seen = seen + 1 if visible and conflict_from(case, k, x, speed) else 0
            if seen > needed:
                begins = k + delay
                brakes = CarefulBrakes(case, begins)
            elif not visible and place < math.inf:
                limit = min(limit, stopping_speed(case, place - 0.1 - x))
        if k == 0:
            slowed, speed = slowed or limit < speed, min(limit, speed)
        if begins is not None and k >= begins:
            if k == begins:
                held = own[max(k - 1, 0)]
            held = max(held, own[k]) if k < case.contact else held
            slower = max(0.0, speed - max(min(held, brakes.hardest), brakes(k, x, speed, 0.0)) * case.step)
            slowed = True
        else:
            slower = min(case.ego_speed[k + 1], max(limit, speed - brakes.hardest * case.step))
            slowed = slowed or limit < case.ego_speed[k + 1]
        after = x + 0.5 * (speed + slower) * case.step if slowed else case.ego_x[k + 1]
        if case.touch(k, x, after):
            return False
        x, speed = after, slower
    return True


def stopping_speed(case: Encounter, room: float) -> float:
    """The greatest speed from which the careful driver stops within `room`, if it sees the other one step later."""
    brakes, speeds = CarefulBrakes(case, 0), np.linspace(0.0, 60.0, 6001)
    a, ramp = brakes.hardest, brakes.ramp
    waiting = speeds * (0.4 + 0.75 + case.step)
    early = 2.0 / 3.0 * speeds * np.sqrt(2.0 * speeds * ramp / a)
    later = speeds * ramp - a * ramp**2 / 6.0 + (speeds - 0.5 * a * ramp) ** 2 / (2.0 * a)
    stops = waiting + np.where(speeds < 0.5 * a * ramp, early, later) <= room
    return float(speeds[stops].max(initial=0.0))


# -- the models of JRC-FSM ---------------------------------------------------------------------------------------------


@dataclass
class Situation:
    gap: float
    beside: float
    passed: float
    mine: float
    last: float
    lead: float
    coming: float
    braking: float


def situation(case: Encounter, k: int, x: float, speed: float, last: float) -> Situation | None:
    """The other along and across the lane; None if it is behind."""
    u, v, turn, theirs, acceleration = case.other[k]
    if u < x:
        return None
    (a, b), (c, d) = case.ego_size, case.other_size
    cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
    long, wide = 0.5 * (a + c * cos + d * sin), 0.5 * (b + c * sin + d * cos)
    coming = -theirs * math.sin(turn) * (1.0 if v >= 0.0 else -1.0)
    lead = theirs * math.cos(turn)
    return Situation(u - x - long, abs(v) - wide, u - x + long, speed, last, lead, coming, -acceleration)


def reg157(now: Situation) -> float:
    closing = now.mine - now.lead
    if now.beside > 0.5 or closing <= 0.0 or abs(now.gap) / closing > closing / 12.0 + 0.35 + 0.1:
        return 0.0
    return 6.0


def rss(now: Situation) -> float:
    reached = now.mine + 0.75 * 3.0
    safe = now.mine * 0.75 + 3.0 * 0.75**2 / 2.0 + reached**2 / 12.0 - now.lead**2 / 12.0
    aside = abs(now.coming)
    across = 0.3 + (2.0 * aside + 0.75) * 0.75 / 2.0 + (aside + 0.75) ** 2 / 2.0
    return 0.774 * GRAVITY if now.gap < safe and now.beside < across else 0.0


def fsm(now: Situation) -> float:
    closing = now.mine - now.lead
    apart = now.coming <= 0.0 or closing <= 0.0
    if now.beside > 0.0 and (apart or now.beside / now.coming > now.passed / closing + 0.1):
        return 0.0
    critical, slowing = 0.0, max(now.last, -4.0)
    if closing > 0.0:
        after = now.mine + 0.75 * slowing
        if after < now.lead:
            critical = float(now.gap < closing**2 / abs(2.0 * now.last))
        else:
            gone = (now.mine + slowing * 0.75 / 2.0 - now.lead) * 0.75
            critical = fuzzy(now.gap, *(gone + (after - now.lead) ** 2 / (2.0 * each) for each in (6.0, 4.0)))
    if critical > 0.0:
        return 4.0 + 2.0 * critical
    reach = now.mine * 0.75 - now.lead**2 / 14.0
    return 4.0 * fuzzy(now.gap - 2.0, reach + now.mine**2 / 12.0, reach + now.mine**2 / 8.0 + 2.0)


def fuzzy(gap: float, unsafe: float, safe: float) -> float:
    if gap > safe:
        return 0.0
    return 1.0 if gap < unsafe else (gap - safe) / (unsafe - safe)


def cc(now: Situation) -> float:
    closing = now.mine - now.lead
    near = closing > 0.0 and abs(now.gap) / closing <= 2.0
    alarming = now.braking > 5.0 and now.gap < 2.0 * now.mine
    return 0.774 * GRAVITY if now.beside <= 0.0 and (near or alarming) else 0.0


JRC = {"reg157": (reg157, 0.35, math.inf, 0.0), "rss": (rss, 0.75, 12.65, 0.0)}
JRC |= {"fsm": (fsm, 0.75, 12.65, 0.0), "cc": (cc, 0.75, 12.65, 0.4)}
"""Judgement, reaction [s], jerk [m/s^3], deceleration while it reacts [m/s^2]."""


class JrcBrakes:
    def __init__(self, case: Encounter, name: str, unsafe: int = 0) -> None:
        self.case, self.unsafe, self.deceleration = case, unsafe, 0.0
        self.judge, reaction, self.jerk, self.release = JRC[name]
        self.delay = math.ceil(reaction / case.step - 1e-9)

    def __call__(self, k: int, x: float, speed: float, last: float) -> float:
        now = situation(self.case, k, x, speed, last)
        demand = 0.0 if now is None else self.judge(now)
        if demand == 0.0:
            return 0.0
        if self.unsafe < self.delay:
            self.unsafe += 1
            self.deceleration = self.release
            return self.release
        self.deceleration = min(self.deceleration + self.jerk * self.case.step, demand)
        return self.deceleration


def jrc(case: Encounter, name: str) -> bool:
    """Counts unsafe samples in the case as it was; from its first act on the ego drives as the model says."""
    brakes = JrcBrakes(case, name)
    waits = 0 if brakes.release else brakes.delay
    unsafe = 0
    for k in range(case.contact):
        last = (case.ego_speed[k] - case.ego_speed[k - 1]) / case.step if k else 0.0
        now = situation(case, k, case.ego_x[k], case.ego_speed[k], last)
        if now is not None and brakes.judge(now) > 0.0:
            if unsafe >= waits:
                return avoids(case, k, JrcBrakes(case, name, unsafe))
            unsafe += 1
    return False


DRIVERS = {"careful": lambda case: careful(case)} | {name: lambda case, name=name: jrc(case, name) for name in JRC}
