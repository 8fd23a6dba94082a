"""Library behaviours of people on foot: walking along a sidewalk, and using a crossing.

A person walks at a speed drawn by the property `age` (35 years without it, *ours*) from the distribution of
`WalkingSpeed`. Groups are slower by 0.12 to 0.18 m/s (Gates, Noyce, Bill and Van Ee 2006, Transportation Research
Record 1982, 38-47).

At a crossing without a light a person waits at the kerb for a gap of the form of the Highway Capacity Manual, the
length of the crossing over 1.2 m/s and 3 s for the start (not verified): no vehicle that the person sees
is on the crossing, or reaches it within that time at its present speed, by any way. So a vehicle that stops lets the
person go. With a light a person waits for green, and with the probability `on_red` only for a gap.
"""

import math

from cortex_dsl import ir
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.errors.names import NOT_ON_FOOT
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation import signals, streets
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES
from cortex_dsl.semantics.evaluation.geometry import (
    bearing,
    between,
    current_pose,
    is_present,
    moved,
    others,
    size_of,
    state,
)
from cortex_dsl.semantics.evaluation.lanes import chosen, index_of, lane_at, looked_up
from cortex_dsl.semantics.evaluation.random_values import uniform, walking_speed
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import unhidden
from cortex_dsl.semantics.model.state import GREEN
from cortex_dsl.semantics.model.values import Actor, Pose, Quantity, Vector
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    cos,
    equal,
    maximum,
    minimum,
    path_pose,
    path_project,
    sin,
    where,
    wrapped,
)
from engine.road.approaches import approaches
from engine.road.linking import Window
from engine.road.network import Surface, SurfaceKind
from engine.vocabulary import ActorKind, Command, State

USUAL_AGE = 35.0
"""Age of a person without the property `age` in years; *ours*."""
SLOWER = 0.12, 0.18
"""Least and largest speed that persons in groups lose [m/s]."""
START_UP = 3.0
"""Time for the start in the accepted gap [s]; Highway Capacity Manual, not verified."""
GAP_SPEED = 1.2
"""Walking speed in the accepted gap [m/s]; Highway Capacity Manual, not verified."""
KERB = 0.5
"""Distance of a waiting person from the kerb [m]; *ours*."""
BEYOND = 1.0
"""Distance behind the far kerb at which a person has crossed [m]; *ours*: the body is clear of the road."""
ARRIVED = 0.15
"""Distance at which a person has reached a place [m]; *ours*."""


def _element(job: Job, argument: str, kinds: tuple[SurfaceKind, ...], expected: str, cure: str) -> Surface:
    """Return the element of the road that an argument names; refuse actors that do not walk."""
    if job.actor.kind is not ActorKind.PEDESTRIAN:
        raise NOT_ON_FOOT.mistake(job.call.span, behaviour=job.call.name, actual=kind_name(job.actor))
    value = chosen(job.given(argument))
    if isinstance(value, Surface) and value.kind in kinds:
        return value
    span, actual = job.call.spans[argument], kind_name(value)
    raise WRONG_KIND.mistake(span, what=f"`{argument}`", expected=expected, actual=actual, cure=cure)


def _speed(job: Job) -> Term:
    """Return the walking speed [m/s]: the given one, or one drawn by the age; lower in a group."""
    grouped = job.flag("in_group")
    if job.given("speed") is not None:
        speed = job.number("speed")
    else:
        years = job.actor.properties.get("age")
        age = years.expr if isinstance(years, Quantity) else job.ev.algebra.literal(USUAL_AGE)
        speed = walking_speed(job.ev, age)
    if grouped:
        least, most = SLOWER
        speed = maximum(0.0, speed - (least + uniform(job.ev) * (most - least)))
    return speed


def _walk(job: Job, heading: Term, speed: Term) -> ir.Act:
    turn = wrapped(heading - current_pose(job.ev, job.actor).heading)
    return ir.Take(job.call.span, ((Command.STEER, turn), (Command.SPEED, speed)))


def _halt(job: Job) -> ir.Act:
    return ir.Take(job.call.span, ((Command.SPEED, job.ev.algebra.literal(0.0)),))


def walk_along(job: Job) -> ir.Block:
    """Walk along the middle of a sidewalk to its end, in the direction that is nearer to the heading, and stand."""
    cure = "as in `network.sidewalks[0]`, or `lane.group.sidewalk`"
    kinds = (SurfaceKind.SIDEWALK, SurfaceKind.SHOULDER, SurfaceKind.CROSSING, SurfaceKind.PARKING)
    walkway = _element(job, "sidewalk", kinds, "a sidewalk", cure)
    paths, here = walkway.network.paths, current_pose(job.ev, job.actor)
    ahead, back = (job.ev.algebra.literal(float(each)) for each in (walkway.path, paths.reverse(walkway.path)))
    foot = path_pose(ahead, path_project(ahead, here.x, here.y))
    choose, path = job.kept(where(cos(here.heading - foot[2]) < 0.0, back, ahead))
    draw, speed = job.kept(_speed(job))
    follow = ir.Follow(
        job.call.span, path, speed, job.ev.algebra.literal(math.inf), job.ev.run.new_local(), aside=job.aside()
    )
    return (choose, draw, follow, _halt(job))


def use_crossing(job: Job) -> ir.Block:
    """Walk to the kerb, wait, cross, and stand behind the far kerb."""
    cure = "as in `network.crossings[0]`, or `intersection.crossings[0]`"
    crossing = _element(job, "crossing", (SurfaceKind.CROSSING,), "a crossing", cure)
    ev, algebra, span = job.ev, job.ev.algebra, job.call.span
    ends = [Vector(algebra.literal(end.x), algebra.literal(end.y)) for end in crossing.ends_at]
    here = current_pose(ev, job.actor)
    choose, first = job.kept(between(here, ends[0]) <= between(here, ends[1]))
    draw, speed = job.kept(_speed(job))
    begin = Vector(where(first, ends[0].x, ends[1].x), where(first, ends[0].y, ends[1].y))
    heading = crossing.ends_at[0].heading
    way = where(first, algebra.literal(heading), algebra.literal(heading + math.pi))
    along, across = _within(begin, way, here)
    free = maximum(0.0, 0.5 * crossing.width - 0.5 * size_of(job.actor, "width"))
    aim, aside = job.kept(minimum(free, maximum(-free, across)))
    kerb, beyond = (moved(begin, way, aside, algebra.literal(ahead)) for ahead in (-KERB, crossing.length + BEYOND))
    near = maximum(ARRIVED, speed * ev.file.settings.time_step)
    position = Vector(here.x, here.y)
    approach = (along < -KERB) & (between(position, kerb) > near)
    goes, acts = _may_go(job, crossing)
    return (
        choose,
        draw,
        aim,
        *acts,
        ir.Loop(span, approach, (_walk(job, bearing(position, kerb), speed),)),
        ir.Loop(span, (along < 0.0) & ~goes, (_walk(job, way, algebra.literal(0.0)),)),
        ir.Loop(span, along < crossing.length + BEYOND, (_walk(job, _towards(position, beyond, way), speed),)),
        _halt(job),
    )


def _within(begin: Vector, way: Term, pose: Pose) -> tuple[Term, Term]:
    """Return how far a place is along and to the right of a direction from a point [m]."""
    dx, dy, c, s = pose.x - begin.x, pose.y - begin.y, cos(way), sin(way)
    return dx * c + dy * s, dx * s - dy * c


def _towards(here: Vector, target: Vector, way: Term) -> Term:
    """Return the heading to a target, or near it the direction of the way, which does not turn."""
    return where(between(here, target) > 2.0 * BEYOND, bearing(here, target), way)


def _may_go(job: Job, crossing: Surface) -> tuple[Term, ir.Block]:
    """Return whether a person may step onto a crossing, and the acts that draw the attitude towards red."""
    ev = job.ev
    windows = approaches(crossing)
    gap = job.number("gap", crossing.length / GAP_SPEED + START_UP)
    vehicles = [each for each in others(ev, job.actor) if each.kind not in NOT_VEHICLES]
    free = ~ev.algebra.any_of([_comes(job, each, windows, gap) for each in vehicles])
    light, plan = streets.light_of(crossing), signals.plan_of(ev)
    if light is None or plan is None or not signals.is_there(light):
        return free, ()
    green = equal(signals.colour_of(ev, light, plan), float(GREEN))
    if job.given("on_red") is None:
        return green, ()
    keep, ignores = job.kept(uniform(ev) < job.number("on_red"))
    return green | ((ignores > 0.0) & free), (keep,)


def _comes(job: Job, other: Actor, windows: tuple[Window, ...], gap: Term) -> Term:
    """Return whether a vehicle that is seen is on the crossing, or reaches it within the gap."""
    ev = job.ev
    pose, half = current_pose(ev, other), size_of(other, "length") * 0.5
    lane = index_of(ev, lane_at(ev, pose))
    assert lane is not None
    path = looked_up(ev, lane, [each.path for each in network_of(ev).lanes], missing=0.0)
    s = path_project(path, pose.x, pose.y)
    enter = looked_up(ev, lane, [window.enter for window in windows], missing=math.inf)
    leave = looked_up(ev, lane, [window.leave for window in windows], missing=-math.inf)
    soon = enter - (s + half) < gap * maximum(state(ev, other, State.SPEED), 0.0)
    return ev.algebra.all_of((is_present(ev, other), soon, s - half < leave, unhidden(ev, job.actor, other)))
