"""Where the ways of two actors cross, and when each of them is there: what drivers of the library foresee of others.

The way of an actor is the path that its driver follows (its indicator tells which), else the default route of the lane
that it is in, else straight on as it moves. Along its way its outline sweeps a strip. The area of conflict is where my
outline, going on along my way, reaches into the strip that is still before the other; the other has one of its own,
where its outline reaches into mine. Both are searched for along the ways: outlines keep to the ways with their rear
axles, as vehicles do, and count as touching from `CLEARANCE` on. Allen, Shin and Cooper (1978), "Analysis of traffic
conflicts and collisions", Transportation Research Record 667, look at the same area, in what has been driven.

Times follow from speeds along the ways, which nobody goes faster than its bends allow (`kernels.steering`): mine with
my acceleration up to my target speed; the other's at its present speed, and, at the earliest, with an acceleration of
its own. Who goes faster through a bend than is comfortable is taken to go on like that.
"""

import math
from typing import NamedTuple

from engine.kernels.conflict import shadow
from engine.kernels.geometry import Box, View, shortest_turn
from engine.kernels.impacts.motion import MotionSegment
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.nearest_lane import lane_nearest
from engine.kernels.noticing import visibility_past
from engine.kernels.path import chain_pose, chain_project, chain_speed_limit
from engine.kernels.run_state import Memory, Plan, Run, column_of, outline_of
from engine.kernels.sight import SEEN
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, Column, State

CLEARANCE = 0.2
"""Outlines nearer than this count as touching [m]; *ours*: more than a path follower is off its path."""
REACH = 120.0
"""How far along the ways is looked [m]; *ours*: what braking from 130 km/h takes."""
BESIDE = 1.25
"""Who is farther from the middle of a way [m] …"""
ASKEW = math.pi / 4.0
"""… or heads off it by more does not follow it [rad]; *ours*."""
BACK = 3.0
"""Who is in the area looks for a way out of it backwards so far [m]; *ours*: less than a car."""
INSIDE_STEP = 1.0
"""Of the search for the end of the area [m], for its beginning at least half of it."""
HALVINGS = 6
TIME_STEP = 1.5
"""Part of a way that is gone through at a time when times are added up [m]."""
BEND = 3.0
"""Lateral acceleration in bends, and deceleration before them: those of the library's drivers [m/s^2]."""
CREEPING = 0.05
"""Who is slower stands [m/s]."""


class Foresight(NamedTuple):
    """How a driver looks at another: what `Op.CROSSING` is given."""

    path: int
    """My path, or -1: the way that I am on."""
    reach: float
    """How far I see [m] …"""
    angle: float
    """… and in which sector about my heading [rad]."""
    latency: float
    """How old what I see is, of myself too [s]."""
    target: float
    """Speed that I am to go at [m/s] …"""
    acceleration: float
    """… and how I get there [m/s^2]."""
    theirs: float
    """Acceleration of the other's that I reckon with [m/s^2]."""


class Crossing(NamedTuple):
    """One actor and another; infinite where there is no area, or no end of it, as where two ways become one."""

    enter: float
    """How far I have to go until my outline is in the area; 0 inside [m] …"""
    leave: float
    """… until it is out again."""
    arrives: float
    """When I am in it [s] …"""
    clears: float
    """… and out of it."""
    their_enter: float
    their_leave: float
    earliest: float
    """When the other is in it at the earliest [s], …"""
    their_arrival: float
    """… when at its present speed, …"""
    their_clearing: float
    """… and when it is out again."""
    along: float
    """Cosine of the other's heading against that of my way beside it: 1 of who goes my way."""
    back: float
    """How far back I would be out of the area: 0 outside, infinite where that is more than `BACK` [m]."""


class Way(NamedTuple):
    """Rows of primitives, or (`first == last`) a straight line from a place on."""

    first: int
    last: int
    start: float
    """Arc length of the rear axle; on a straight line that of the outline's centre, 0 [m]."""
    end: float
    offset: float
    """How far left of it the actor goes [m]."""
    x: float
    y: float
    heading: float
    length: float
    width: float
    to_center: float
    """From the place that is on the way to the outline's centre [m]."""
    speed: float


@kernel
def crossing(plan: Plan, run: Run, sample: int, me: int, other: int, look: Foresight) -> Crossing:
    """Where the ways of two actors cross, and when they are there; nothing of one that is absent or not seen."""
    seen = sample - math.floor(look.latency / plan.layout.time_step + 0.5)
    states = run.states
    if seen < 0 or states[seen, me, State.PRESENT] == 0.0 or states[seen, other, State.PRESENT] == 0.0:
        return _nothing()
    mine = _way(plan, run, seen, me, look.path)
    theirs = _way(plan, run, seen, other, -1)
    primitives = plan.road.primitives
    if math.hypot(mine.x - theirs.x, mine.y - theirs.y) > 2.0 * REACH:
        return _nothing()
    enter, leave = _stretch(primitives, mine, theirs)
    if enter == math.inf:
        return _nothing()
    their_enter, their_leave = _stretch(primitives, theirs, mine)
    if their_enter == math.inf:
        return _nothing()
    view = View(states[seen, me, State.X], states[seen, me, State.Y], mine.heading, look.angle, look.reach)
    if visibility_past(plan, run, seen, view, outline_of(plan, run, seen, other), me, other) != SEEN:
        return _nothing()
    arrives, clears = _times(primitives, mine, look.target, look.acceleration, enter, leave)
    soonest, _ = _times(primitives, theirs, math.inf, look.theirs, their_enter, their_enter)
    arrival, clearing = _times(primitives, theirs, theirs.speed, 0.0, their_enter, their_leave)
    along = math.cos(theirs.heading - _foot_heading(primitives, mine, theirs.x, theirs.y))
    back = 0.0 if enter > 0.0 else _way_back(primitives, mine, theirs)
    return Crossing(enter, leave, arrives, clears, their_enter, their_leave, soonest, arrival, clearing, along, back)


@deferred()
def foresee(plan: Plan, run: Run, sample: int, row: int) -> None:
    """`Op.CROSSING`, at a row of step code."""
    code, registers = plan.code, run.registers
    at = registers[int(code[row, 4]) :]
    look = Foresight(int(at[0]), at[1], at[2], at[3], at[4], at[5], at[6])
    found = crossing(plan, run, sample, int(code[row, 2]), int(code[row, 3]), look)
    dst = registers[int(code[row, 1]) :]
    dst[0], dst[1], dst[2], dst[3], dst[4] = found.enter, found.leave, found.arrives, found.clears, found.their_enter
    dst[5], dst[6], dst[7] = found.their_leave, found.earliest, found.their_arrival
    dst[8], dst[9], dst[10] = found.their_clearing, found.along, found.back


@inlined
def _nothing() -> Crossing:
    far = math.inf
    return Crossing(far, far, far, far, far, far, far, far, far, 1.0, 0.0)


# -- ways --------------------------------------------------------------------------------------------------------------


@kernel
def _way(plan: Plan, run: Run, sample: int, actor: int, path: int) -> Way:
    """The way of an actor that takes part; `path`: the one that it surely goes, or -1."""
    box = outline_of(plan, run, sample, actor)
    speed = run.states[sample, actor, State.SPEED]
    if run.states[sample, actor, State.PRESENT] == SLIDING:
        x, y = run.segments[actor, MotionSegment.VX1], run.segments[actor, MotionSegment.VY1]
        return _straight(plan, box, math.atan2(y, x), math.hypot(x, y))
    if path >= 0:
        return _along(plan, run, box, actor, path, speed)
    if plan.kinds[actor] != ActorKind.OBSTACLE and speed >= 0.0:
        followed = int(run.actors[actor, Memory.PATH]) - 1
        if followed >= 0:
            way = _along(plan, run, box, actor, followed, speed)
            if _is_on(plan.road.primitives, way):
                return way
        if plan.kinds[actor] != ActorKind.PEDESTRIAN and len(plan.road.lane_path) > 0:
            lane = lane_nearest(plan.road, box.x, box.y, box.heading)
            way = _along(plan, run, box, actor, int(plan.road.lane_route[lane]), speed)
            if _is_on(plan.road.primitives, way):
                return way
    return _straight(plan, box, box.heading if speed >= 0.0 else box.heading + math.pi, abs(speed))


@inlined
def _along(plan: Plan, run: Run, box: Box, actor: int, path: int, speed: float) -> Way:
    """The way of an actor along a path."""
    first, last = int(plan.road.path_start[path]), int(plan.road.path_start[path + 1])
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    x, y = box.x - to_center * math.cos(box.heading), box.y - to_center * math.sin(box.heading)
    s, _ = chain_project(plan.road.primitives, first, last, x, y)
    pose = chain_pose(plan.road.primitives, first, last, s)
    offset = (y - pose.y) * math.cos(pose.heading) - (x - pose.x) * math.sin(pose.heading)
    end = plan.road.path_length[path]
    return Way(
        first, last, s, end, offset, box.x, box.y, box.heading, box.length, box.width, to_center, max(speed, 0.0)
    )


@inlined
def _straight(plan: Plan, box: Box, heading: float, speed: float) -> Way:
    """Straight on from where an outline is; what moves aslant sweeps as wide a strip as its outline casts a shadow."""
    length = 2.0 * shadow(box, math.cos(heading), math.sin(heading))
    width = 2.0 * shadow(box, -math.sin(heading), math.cos(heading))
    row = int(plan.road.path_start[0])
    return Way(row, row, 0.0, math.inf, 0.0, box.x, box.y, heading, length, width, 0.0, speed)


@inlined
def _is_on(primitives: Floats, way: Way) -> bool:
    """Whether who is beside a path follows it."""
    turn = shortest_turn(chain_pose(primitives, way.first, way.last, way.start).heading, way.heading)
    return abs(way.offset) < BESIDE and abs(turn) < ASKEW


@kernel
def _outline(primitives: Floats, way: Way, s: float) -> Box:
    """The outline at an arc length of its way."""
    x, y, heading = way.x + s * math.cos(way.heading), way.y + s * math.sin(way.heading), way.heading
    if way.last > way.first:
        pose = chain_pose(primitives, way.first, way.last, s)
        x, y, heading = pose.x, pose.y, pose.heading
    cos, sin = math.cos(heading), math.sin(heading)
    x, y = x - way.offset * sin + way.to_center * cos, y + way.offset * cos + way.to_center * sin
    return Box(x, y, heading, way.length, way.width)


@inlined
def _foot_heading(primitives: Floats, way: Way, x: float, y: float) -> float:
    """The heading of a way beside a place."""
    if way.last == way.first:
        return way.heading
    s, _ = chain_project(primitives, way.first, way.last, x, y)
    return chain_pose(primitives, way.first, way.last, s).heading


@kernel
def _apart(primitives: Floats, way: Way, s: float, other: Way) -> float:
    """How far the outline at an arc length of its way is from the strip before the other [m]; negative inside."""
    box = _outline(primitives, way, s)
    x, y, heading, foot, end = other.x, other.y, other.heading, 0.0, math.inf
    if other.last > other.first:
        foot, _ = chain_project(primitives, other.first, other.last, box.x, box.y)
        pose = chain_pose(primitives, other.first, other.last, foot)
        x, y, heading, end = pose.x, pose.y, pose.heading, other.end
    cos, sin = math.cos(heading), math.sin(heading)
    foot += (box.x - x) * cos + (box.y - y) * sin
    left = (box.y - y) * cos - (box.x - x) * sin - other.offset
    ahead, half = shadow(box, cos, sin), 0.5 * other.length
    aside = abs(left) - 0.5 * other.width - shadow(box, -sin, cos)
    behind = other.start + other.to_center - half - (foot + ahead)
    beyond = foot - ahead - (end + other.to_center + half)
    return max(aside, behind, beyond) - CLEARANCE


@kernel
def _stretch(primitives: Floats, way: Way, other: Way) -> tuple[float, float]:
    """From where to where along a way its outline is in what lies before the other, from where it is now [m]."""
    end = min(way.end, way.start + REACH)
    before, s = way.start, way.start
    apart = _apart(primitives, way, s, other)
    while apart >= 0.0:
        if s >= end:
            return math.inf, math.inf
        before, s = s, min(end, s + max(0.5 * INSIDE_STEP, 0.7 * apart))
        apart = _apart(primitives, way, s, other)
    enter = _border(primitives, way, other, before, s) if s > way.start else way.start
    while apart < 0.0:
        if s >= end:
            return enter - way.start, math.inf
        before, s = s, min(end, s + INSIDE_STEP)
        apart = _apart(primitives, way, s, other)
    return enter - way.start, _border(primitives, way, other, s, before) - way.start


@inlined
def _way_back(primitives: Floats, way: Way, other: Way) -> float:
    """How far back along its way an outline that is in the area would be out of it [m]."""
    behind = way.start - BACK if way.last == way.first else max(way.start - BACK, 0.0)
    if _apart(primitives, way, behind, other) < 0.0:
        return math.inf
    return way.start - _border(primitives, way, other, behind, way.start)


@inlined
def _border(primitives: Floats, way: Way, other: Way, outside: float, inside: float) -> float:
    """Where the area begins or ends; on its outer side."""
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        if _apart(primitives, way, middle, other) < 0.0:
            inside = middle
        else:
            outside = middle
    return outside


# -- times -------------------------------------------------------------------------------------------------------------


@kernel
def _times(
    primitives: Floats, way: Way, target: float, acceleration: float, enter: float, leave: float
) -> tuple[float, float]:
    """When an actor has gone so far [s], and when so far, at most at a target speed and as its bends allow."""
    speed, time, gone, entered = way.speed, 0.0, 0.0, 0.0 if enter <= 0.0 else math.inf
    usual = _limit(primitives, way, 0.0)
    bold = max(1.0, speed / usual) if usual > 0.0 else 1.0
    last = enter if leave == math.inf else leave
    while gone < last:
        to = min(gone + TIME_STEP, enter if gone < enter else last)
        step = to - gone
        most = min(target, bold * _limit(primitives, way, to))
        after = math.sqrt(max(0.0, speed * speed + 2.0 * acceleration * step))
        if after > most:
            # Nobody slows down harder than this for a target or a bend.
            after = max(most, math.sqrt(max(0.0, speed * speed - 2.0 * BEND * step)))
        if speed + after < CREEPING:
            return entered, math.inf
        time += 2.0 * step / (speed + after)
        gone, speed = to, after
        if gone >= enter and entered == math.inf:
            entered = time
    return entered, math.inf if leave == math.inf else time


@inlined
def _limit(primitives: Floats, way: Way, gone: float) -> float:
    """The speed that the bends ahead allow [m/s]."""
    if way.last == way.first:
        return math.inf
    return chain_speed_limit(primitives, way.first, way.last, way.start + gone, BEND, BEND)
