"""Area of conflict of two actors' ways, and the times at which each is in it, as foreseen by drivers of the library.

The way of an actor is the path that its driver follows (its indicator reveals it), else the default route of its lane,
else a straight line in its direction of motion. Along its way its outline sweeps a strip. The area of conflict is the
part of my way at which my outline overlaps the strip ahead of the other; the other has its own area, where its outline
overlaps my strip. Both are searched for along the ways: outlines follow the ways with their rear axles, as vehicles do,
and count as touching from `CLEARANCE` on. Allen, Shin and Cooper (1978), "Analysis of traffic conflicts and
collisions", Transportation Research Record 667, use the same area, for recorded motion.

Times follow from speeds along the ways, limited by their bends (`kernels.steering`): mine with my acceleration up to my
target speed; the other's at its present speed and, for the earliest time, with an acceleration. An actor that exceeds
the comfortable speed of a bend is assumed to continue to do so.
"""

import math
from typing import NamedTuple

from engine.kernels.conflict import shadow, turned_shadow
from engine.kernels.evaluate import operand
from engine.kernels.geometry import Box, View, shortest_turn
from engine.kernels.impacts.motion import MotionSegment
from engine.kernels.jit import deferred, inlined, kernel
from engine.kernels.levels import has_levels, look_ahead, look_back
from engine.kernels.nearest_lane import lane_nearest
from engine.kernels.noticing import visibility_past
from engine.kernels.path import PathPlace, chain_place, chain_pose, chain_project, chain_speed_limit
from engine.kernels.run_state import Memory, Plan, Run, column_of, on_one_level, outline_of
from engine.kernels.sight import SEEN
from engine.tables import SLIDING, Floats
from engine.vocabulary import SAME_WAY, ActorKind, Column, State

CLEARANCE = 0.2
"""Distance below which outlines count as touching [m]; a choice of cortexc: more than a path follower deviates."""
REACH = 120.0
"""Length of the ways that is searched [m]; a choice of cortexc: the braking distance from 130 km/h."""
BESIDE = 1.25
"""Distance from the centre line of a path beyond which an actor does not follow it [m]."""
ASKEW = math.pi / 4.0
"""Angle to the path beyond which an actor does not follow it [rad]; a choice of cortexc."""
BACK = 3.0
"""Distance that an actor in the area searches backwards for an exit [m]; a choice of cortexc: less than a car."""
INSIDE_STEP = 1.0
"""Step of the search for the end of the area [m]; for its beginning at least half of it."""
HALVINGS = 6
TIME_STEP = 1.5
"""Length of the parts of a way by which times are summed [m]."""
BEND = 3.0
"""Lateral acceleration in bends, and deceleration before them: those of the library's drivers [m/s^2]."""
CREEPING = 0.05
"""Speed below which an actor stands [m/s]."""


class Foresight(NamedTuple):
    """Perception and plan of a driver: the input of `Op.CROSSING`."""

    path: int
    """My path, or -1: the way on which I am."""
    reach: float
    """Distance of my sight [m]."""
    angle: float
    """Angle of my sector of sight, symmetric about my heading [rad]."""
    latency: float
    """Age of all that I perceive, my own state included [s]."""
    target: float
    """My target speed [m/s]."""
    acceleration: float
    """My acceleration towards it [m/s^2]."""
    theirs: float
    """Acceleration of the other that I assume [m/s^2]."""
    near: float
    """Distance beyond which I do not react to an area [m]: one that begins farther away may be reported as none."""
    oncoming: float
    """The same for an actor that comes towards me [m]."""


class Crossing(NamedTuple):
    """Areas and times of an actor and another; infinite without an area, or without its end, as for merging ways."""

    enter: float
    """Distance until my outline enters the area; 0 inside [m]."""
    leave: float
    """Distance until my outline leaves the area [m]."""
    arrives: float
    """Time at which I enter it [s]."""
    clears: float
    """Time at which I leave it [s]."""
    their_enter: float
    their_leave: float
    earliest: float
    """Earliest time at which the other enters its area [s]."""
    their_arrival: float
    """Time at which the other enters it at its present speed [s]."""
    their_clearing: float
    """Time at which the other leaves it at its present speed [s]."""
    along: float
    """Cosine of the angle between the other's heading and my way near it: 1 if it goes my way."""
    back: float
    """Distance backwards to the outside of the area [m]: 0 outside, infinite if more than `BACK`."""


class Way(NamedTuple):
    """Rows of primitives, or (`first == last`) a straight line from a place on."""

    first: int
    last: int
    start: float
    """Arc length of the rear axle; on a straight line that of the outline's centre, 0 [m]."""
    end: float
    offset: float
    """Offset of the actor to the left of its way [m]."""
    x: float
    y: float
    heading: float
    cos: float
    """Cosine of `heading`."""
    sin: float
    length: float
    width: float
    to_center: float
    """Distance from the point on the way to the outline's centre [m]."""
    speed: float


@kernel
def crossing(plan: Plan, run: Run, sample: int, me: int, other: int, look: Foresight) -> Crossing:
    """Return the areas and times of two actors; `_nothing()` if either is absent or not seen."""
    seen = sample - math.floor(look.latency / plan.layout.time_step + 0.5)
    states = run.states
    if seen < 0 or states[seen, me, State.PRESENT] == 0.0 or states[seen, other, State.PRESENT] == 0.0:
        return _nothing()
    if has_levels(plan):
        look_back(plan, run, sample, seen)
    found = _crossing_seen(plan, run, seen, me, other, look)
    if has_levels(plan):
        look_ahead(plan, run)
    return found


@kernel
def _crossing_seen(plan: Plan, run: Run, seen: int, me: int, other: int, look: Foresight) -> Crossing:
    """Return `crossing` of two actors that are present at the sample that is seen."""
    if not on_one_level(run, me, other):
        return _nothing()
    states = run.states
    mine = _way(plan, run, seen, me, look.path)
    theirs = _way(plan, run, seen, other, -1)
    primitives = plan.road.primitives
    if math.hypot(mine.x - theirs.x, mine.y - theirs.y) > 2.0 * REACH:
        return _nothing()
    along = math.cos(theirs.heading - _foot_heading(primitives, mine, theirs.x, theirs.y))
    near, areas, actors = look.oncoming if along < -SAME_WAY else look.near, run.areas, len(plan.kinds)
    enter, leave = _stretch(primitives, mine, theirs, near, areas[me * actors + other])
    if enter == math.inf:
        return _nothing()
    their_enter, their_leave = _stretch(primitives, theirs, mine, math.inf, areas[other * actors + me])
    if their_enter == math.inf:
        return _nothing()
    view = View(states[seen, me, State.X], states[seen, me, State.Y], mine.heading, look.angle, look.reach)
    if visibility_past(plan, run, seen, view, outline_of(plan, run, seen, other), me, other) != SEEN:
        return _nothing()
    arrives, clears = _times(primitives, mine, look.target, look.acceleration, enter, leave)
    soonest, _ = _times(primitives, theirs, math.inf, look.theirs, their_enter, their_enter)
    arrival, clearing = _times(primitives, theirs, theirs.speed, 0.0, their_enter, their_leave)
    back = 0.0 if enter > 0.0 else _way_back(primitives, mine, theirs)
    return Crossing(enter, leave, arrives, clears, their_enter, their_leave, soonest, arrival, clearing, along, back)


@deferred()
def foresee(plan: Plan, run: Run, sample: int, row: int) -> None:
    """Execute `Op.CROSSING` at a row of step code."""
    code, registers = plan.code, run.registers
    at = registers[operand(code, row, 4) :]
    look = Foresight(int(at[0]), at[1], at[2], at[3], at[4], at[5], at[6], at[7], at[8])
    found = crossing(plan, run, sample, operand(code, row, 2), operand(code, row, 3), look)
    dst = registers[operand(code, row, 1) :]
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
    """Return the way of a present actor; `path` is its known path, or -1."""
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
    """Return the way of an actor along a path."""
    first, last = int(plan.road.path_start[path]), int(plan.road.path_start[path + 1])
    to_center = column_of(plan, run, actor, Column.REAR_TO_CENTER)
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    x, y = box.x - to_center * cos, box.y - to_center * sin
    s, _ = chain_project(plan.road.primitives, first, last, x, y)
    foot = chain_place(plan.road.primitives, first, last, s)
    offset = (y - foot.y) * foot.cos - (x - foot.x) * foot.sin
    end, speed = plan.road.path_length[path], max(speed, 0.0)
    return Way(
        first, last, s, end, offset, box.x, box.y, box.heading, cos, sin, box.length, box.width, to_center, speed
    )


@inlined
def _straight(plan: Plan, box: Box, heading: float, speed: float) -> Way:
    """Return the straight way from an outline's place; an outline that moves obliquely sweeps the width of its
    projection.
    """
    cos, sin = math.cos(heading), math.sin(heading)
    length, width = 2.0 * shadow(box, cos, sin), 2.0 * shadow(box, -sin, cos)
    row = int(plan.road.path_start[0])
    return Way(row, row, 0.0, math.inf, 0.0, box.x, box.y, heading, cos, sin, length, width, 0.0, speed)


@inlined
def _is_on(primitives: Floats, way: Way) -> bool:
    """Return True if an actor near a path follows it."""
    turn = shortest_turn(chain_pose(primitives, way.first, way.last, way.start).heading, way.heading)
    return abs(way.offset) < BESIDE and abs(turn) < ASKEW


@inlined
def _place(primitives: Floats, way: Way, s: float) -> PathPlace:
    """Return the place of a way at an arc length; a straight line has no ends."""
    if way.last > way.first:
        return chain_place(primitives, way.first, way.last, s)
    return PathPlace(way.x + s * way.cos, way.y + s * way.sin, way.cos, way.sin)


@inlined
def _foot_heading(primitives: Floats, way: Way, x: float, y: float) -> float:
    """Return the heading of a way at the point nearest to (x, y)."""
    if way.last == way.first:
        return way.heading
    s, _ = chain_project(primitives, way.first, way.last, x, y)
    return chain_pose(primitives, way.first, way.last, s).heading


@kernel
def _apart(primitives: Floats, way: Way, s: float, other: Way) -> float:
    """Return the distance of the outline at an arc length from the strip ahead of the other [m]; negative inside."""
    mine = _place(primitives, way, s)
    x = mine.x - way.offset * mine.sin + way.to_center * mine.cos
    y = mine.y + way.offset * mine.cos + way.to_center * mine.sin
    foot, end = 0.0, math.inf
    if other.last > other.first:
        foot, _ = chain_project(primitives, other.first, other.last, x, y)
        end = other.end
    theirs = _place(primitives, other, foot)
    cos, sin = theirs.cos, theirs.sin
    foot += (x - theirs.x) * cos + (y - theirs.y) * sin
    left = (y - theirs.y) * cos - (x - theirs.x) * sin - other.offset
    ahead, half = turned_shadow(way.length, way.width, mine.cos, mine.sin, cos, sin), 0.5 * other.length
    aside = abs(left) - 0.5 * other.width - turned_shadow(way.length, way.width, mine.cos, mine.sin, -sin, cos)
    behind = other.start + other.to_center - half - (foot + ahead)
    beyond = foot - ahead - (end + other.to_center + half)
    return max(aside, behind, beyond) - CLEARANCE


@kernel
def _stretch(primitives: Floats, way: Way, other: Way, near: float, kept: Floats) -> tuple[float, float]:
    """Return the distances along a way at which its outline enters and leaves the strip ahead of the other [m].

    The search for the entry ends with the first outline that is farther away than `near`. It takes the same steps
    whatever `near` is, so that an area within it has the same bits. `kept` holds the last search for these actors: the
    search for the same ways continues there.
    """
    end = min(way.end, way.start + REACH)
    if not _is_kept(kept, way, other):
        _keep(kept, way, other, _apart(primitives, way, way.start, other))
    before, s, apart = kept[BEFORE], kept[REACHED], kept[APART]
    while apart >= 0.0:
        if s >= end or s - way.start > near:
            kept[BEFORE], kept[REACHED], kept[APART] = before, s, apart
            return math.inf, math.inf
        before, s = s, min(end, s + max(0.5 * INSIDE_STEP, 0.7 * apart))
        apart = _apart(primitives, way, s, other)
    if kept[LEAVE] == UNKNOWN:
        kept[BEFORE], kept[REACHED], kept[APART] = before, s, apart
        kept[ENTER] = _border(primitives, way, other, before, s) - way.start if s > way.start else 0.0
        kept[LEAVE] = _end(primitives, way, other, s, end)
    if s > way.start and before - way.start > near:
        return math.inf, math.inf
    return kept[ENTER], kept[LEAVE]


@kernel
def _end(primitives: Floats, way: Way, other: Way, inside: float, end: float) -> float:
    """Return the distance along a way at which its outline leaves the strip in which it is at `inside` [m]."""
    before, s, apart = inside, inside, -1.0
    while apart < 0.0:
        if s >= end:
            return math.inf
        before, s = s, min(end, s + INSIDE_STEP)
        apart = _apart(primitives, way, s, other)
    return _border(primitives, way, other, s, before) - way.start


BEFORE, REACHED, APART, ENTER, LEAVE, FIRST_KEY = range(6)
"""Columns of a kept search: the last two arc lengths [m], the distance at the second [m], and the result [m]."""
KEYS = 10
KEPT = FIRST_KEY + 2 * KEYS
"""Numbers of a kept search (`Run.areas`)."""
UNKNOWN = -1.0
"""`LEAVE` of a search that has not found the entry."""


@inlined
def _is_kept(kept: Floats, way: Way, other: Way) -> bool:
    """Return True if the kept search is that of these ways."""
    return _is_key(kept, FIRST_KEY, way) and _is_key(kept, FIRST_KEY + KEYS, other)


@inlined
def _is_key(kept: Floats, at: int, way: Way) -> bool:
    """Return True if all that an area depends on is equal; it does not depend on speeds."""
    return (
        kept[at] == way.start
        and kept[at + 1] == way.x
        and kept[at + 2] == way.y
        and kept[at + 3] == way.heading
        and kept[at + 4] == way.offset
        and kept[at + 5] == way.first
        and kept[at + 6] == way.last
        and kept[at + 7] == way.length
        and kept[at + 8] == way.width
        and kept[at + 9] == way.to_center
    )


@inlined
def _keep(kept: Floats, way: Way, other: Way, apart: float) -> None:
    """Begin a kept search: at the start of the way."""
    kept[BEFORE], kept[REACHED], kept[APART], kept[LEAVE] = way.start, way.start, apart, UNKNOWN
    _write_key(kept, FIRST_KEY, way)
    _write_key(kept, FIRST_KEY + KEYS, other)


@inlined
def _write_key(kept: Floats, at: int, way: Way) -> None:
    kept[at], kept[at + 1], kept[at + 2], kept[at + 3] = way.start, way.x, way.y, way.heading
    kept[at + 4], kept[at + 5], kept[at + 6] = way.offset, way.first, way.last
    kept[at + 7], kept[at + 8], kept[at + 9] = way.length, way.width, way.to_center


@inlined
def _way_back(primitives: Floats, way: Way, other: Way) -> float:
    """Return the distance backwards along its way at which an outline in the area is out of it [m]."""
    behind = way.start - BACK if way.last == way.first else max(way.start - BACK, 0.0)
    if _apart(primitives, way, behind, other) < 0.0:
        return math.inf
    return way.start - _border(primitives, way, other, behind, way.start)


@inlined
def _border(primitives: Floats, way: Way, other: Way, outside: float, inside: float) -> float:
    """Return the arc length of the area's begin or end [m], on its outer side."""
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
    """Return the times at which an actor has gone `enter` and `leave` [m], limited by target speed and bends [s]."""
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
            # No driver brakes harder than this for a target or a bend.
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
    """Return the speed that the bends ahead permit [m/s]."""
    if way.last == way.first:
        return math.inf
    return chain_speed_limit(primitives, way.first, way.last, way.start + gone, BEND, BEND)
