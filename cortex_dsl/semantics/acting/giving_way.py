"""The library's driver that gives way: it stops at a line before the area where ways cross.

It continues only if it clears the area before the other actor can be in it, even if that actor accelerates (gap
acceptance; at a merge: if it is there long enough before the other actor). Else it stops at the line and waits, by a
deceleration of 3 m/s^2 if that is enough. If it can no longer stop there, it acts so that both stay apart
(`foreseeing`), and brakes if it comes to rest before outlines touch.

An actor that has left its way, e.g. in a bend at high speed, returns to it only if no actor is next to it or approaches
from behind: the area of conflict, which is searched for along ways, does not cover that case. Else it stays aside, and
stands only if all of its outline is clear of that way.

An actor that has come to rest nearer to the area than 0.7 m, or just inside, e.g. after hard braking, backs up to the
line while another actor approaches: in a bend, fronts swing out of the strip of their way.

Behind other actors it drives as the Intelligent Driver Model (`following`) with the vehicle's own acceleration and
braking.
"""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.acting.crossings import clear_of_cyclists, goes_first, setback
from cortex_dsl.semantics.acting.following import idm_acceleration, path_to_follow
from cortex_dsl.semantics.acting.foreseeing import (
    GAP,
    LEAST_LINE,
    LINE,
    MERGING_GAP,
    SLACK,
    STANDING,
    Conflict,
    Extent,
    Sight,
    braking,
    braking_helps,
    can_stop,
    foreseen,
    is_out_before,
    stopping_distance,
    throttle,
)
from cortex_dsl.semantics.acting.job import SPEED_GAIN, STOPPING, Job, speed_to_stop
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, left_of_path, others, size_of, state
from cortex_dsl.semantics.evaluation.seeing import unhidden
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    box_distance,
    cos,
    hypot,
    maximum,
    minimum,
    path_distance,
    path_pose,
    path_project,
    sin,
    where,
)
from engine.frozen import frozen
from engine.vocabulary import FOR_ONE_STEP, Command, State

BEND_RADIUS = 8.0
"""Radius of the bends in which other actors turn [m]; *ours*: a turn to the near side."""
JOINING_SPEED = 5.0
"""Assumed speed of a turn into the way of another actor [m/s]: that of a bend of 8 m radius."""
STOP_PREVIEW = 0.25
"""Time ahead at which the plan of a stop is read [s]: the lag of the speed controller."""
HARD = -10.0
"""Target speed of full braking down to standstill [m/s]."""
OFF = 1.25
"""Distance from its way beyond which an actor has left the way [m]; as in `engine.kernels.crossing`."""
RETURN = 3.0
"""Duration of the return to the way [s]; *ours*: 10 degrees, as followers return, from a lane's width off the way."""
LATER = (0.0, 0.5)
"""Times at which another actor must be on that way to count, at its present velocity [s]: now, or soon; *ours*."""
EDGING = 3.0
"""Speed of an actor that has left its way and stays aside until it is clear of approaching actors [m/s]; it may stop.
*Ours*: it turns by a lane's width over ten metres.
"""
ROOM = 0.3
"""Distance that it then keeps from the approaching actor [m]; *ours*."""
AWAY = 5.0
"""Speed that is added for an actor that clears the area [m/s]."""
EDGE = 0.7
"""Distance to the area below which an actor backs up, as far as the line [m]; *ours*."""
SOON = 5.0
"""Time within which the arrival of another actor, or its presence in the area, makes the actor back up [s]; *ours*."""
TOUCHING = 0.2
"""Depth inside the area at which outlines touch [m]: `engine.kernels.crossing.CLEARANCE`."""
AT_ONCE = 0.1
"""Arrival time below which an actor counts as present [s]; *ours*."""
CRAWLING = 2.0
"""Speed below which an actor just inside the area backs out instead of passing before the other actor [m/s]; *ours*."""
BACKWARDS = 1.5
"""Greatest speed of backing up [m/s]; *ours*: walking pace."""
LEAST_TIME = 0.1
"""Time that is added to the travel time for leaving the area [s]; *ours*."""
BEHIND = 2.5
"""Free room behind the actor that backing up needs [m], at the times `WHILE`."""
WHILE = (0.0, 1.0)
"""Times at which the room behind must be free, with the present velocities of other actors [s]; *ours*."""
BRISK = 3.0
"""Acceleration and deceleration of the model if the call names none [m/s^2]."""


@frozen
class Answer:
    """Reaction of a driver to another actor."""

    stops: Term
    """Whether it stops at the line."""
    brakes: Term
    """Whether it brakes fully."""
    goes: Term
    """Whether it clears the area."""
    backs: Term
    """Whether it backs up to the line from standstill."""


def give_way(job: Job) -> ir.Block:
    """Follow a lane or trajectory behind the actor ahead, and stop before areas of conflict until they are free."""
    job.must_steer()
    acts, path = path_to_follow(job)
    sight, target = Sight.of(job), job.target_speed()
    speed = job.speed() + idm_acceleration(job, path, BRISK, BRISK) / SPEED_GAIN
    answers, any_of = list[Answer](), job.ev.algebra.any_of
    off, askew = _beside(job, path)
    aside_wanted = job.aside()
    if aside_wanted is not None:
        off = off - aside_wanted
    extent = _extent(job, askew)
    for other in others(job.ev, job.actor):
        first = goes_first(job, other)
        reach = extent if first is None else extent.farther(setback(job, other))
        conflict = foreseen(job, path, other, sight, target, throttle(job), reach)
        answer = _answer(job, other, conflict, askew, first)
        room = conflict.enter - LINE
        if first is not None:
            room = where(first, room - setback(job, other), room)
        speed = where(answer.stops, minimum(speed, _approach(job, room)), speed)
        answers.append(answer)
    away = minimum(job.speed() + AWAY, maximum(job.speed(), target))
    speed = where(any_of([each.goes for each in answers]), away, speed)
    aside = where(abs(off) > OFF, _kept_aside(job, path), 0.0)
    waits, stands = aside > 0.0, abs(off) - askew > aside
    speed = where(waits, where(stands, HARD, minimum(speed, EDGING)), speed)
    clear = clear_of_cyclists(job, path)
    usual = job.ev.algebra.literal(0.0) if clear is None else clear
    offset = where(waits, where(off > 0.0, maximum(off, aside + ROOM), minimum(off, -aside - ROOM)), usual)
    follow = job.follow(path, where(any_of([each.brakes for each in answers]), HARD, speed), offset)
    return (*acts, _backing_up(job, follow, any_of([each.backs for each in answers]) & _is_free_behind(job)))


def _answer(job: Job, other: Actor, conflict: Conflict, askew: Term, first: Term | None) -> Answer:
    """`askew`: how far its outline reaches beyond where its way has it; `first`: the other has the right of way."""
    lost, waits = _lost(job, other), ~_goes_before(job, other, conflict)
    waits = waits if first is None else waits | first
    soon, halts = _comes_soon(job, other, conflict), _halts_at_edge(job, conflict, lost)
    in_time = can_stop(job, conflict.nearer(askew))
    helps = braking_helps(job, conflict.nearer(askew), lost) | _retreats(job, conflict, lost) | halts
    crosses, comes = conflict.crosses & waits, conflict.comes & waits
    return Answer(
        stops=crosses & in_time,
        brakes=(crosses & ~in_time & helps) | (comes & halts & soon),
        goes=crosses & ~in_time & ~helps,
        backs=(crosses | comes) & soon & _is_at_edge(job, conflict),
    )


def _extent(job: Job, askew: Term) -> Extent:
    """Return the distance from which on an area neither asks for a stop now nor lowers the speed.

    The stop is in time, and its speed is no less than the greatest that the model behind other actors gives.
    """
    speed = abs(job.speed())
    most = speed + job.number("max_acceleration", BRISK) / SPEED_GAIN
    room = maximum(most * most / (2.0 * STOPPING), most / SPEED_GAIN)
    near = maximum(LINE + STOP_PREVIEW * speed + room, stopping_distance(job) + (LEAST_LINE + askew)) + SLACK
    return Extent(near, near)


def _backing_up(job: Job, follow: ir.Act, backs: Term) -> ir.Act:
    """Follow, but from a standstill go backwards for as long as a condition holds, which is looked at only there.

    The reverse gear is in for a turn at a time, so that whatever takes over next drives forwards.
    """
    algebra, span, looked = job.ev.algebra, job.call.span, job.ev.run.new_local()
    throttle = minimum(1.0, SPEED_GAIN * maximum(BACKWARDS + job.speed(), 0.0) / size_of(job.actor, "maxAcceleration"))
    back = (
        (Command.THROTTLE, throttle),
        (Command.BRAKE, algebra.literal(0.0)),
        (Command.BACK, algebra.literal(FOR_ONE_STEP)),
    )
    halt = (Command.THROTTLE, algebra.literal(0.0)), (Command.BRAKE, algebra.literal(1.0))
    backwards = (
        ir.Loop(span, backs & (job.speed() < STANDING), (ir.Take(span, back),)),
        ir.Loop(span, job.speed() < 0.0, (ir.Take(span, halt),)),
    )
    look = ir.SetLocal(span, looked, algebra.time())
    stands = (abs(job.speed()) < STANDING) & (algebra.local(looked) < algebra.time())
    return ir.TryInterrupt(span, (follow,), ((stands, (look, *backwards)),))


def _is_at_edge(job: Job, conflict: Conflict) -> Term:
    """Return whether the actor is so near to the area, or so little inside, that it should back up to the line."""
    near = conflict.enter < where(job.speed() < 0.0, LINE, EDGE)
    clear = (conflict.enter > 0.0) | (conflict.back < TOUCHING)
    return near & ((job.speed() < 0.0) | clear | (_time_to_back_out(conflict) < conflict.their_arrival))


def _time_to_back_out(conflict: Conflict) -> Term:
    """[s]; infinite where there is no way back."""
    return conflict.back / BACKWARDS + LEAST_TIME


def _comes_soon(job: Job, other: Actor, conflict: Conflict) -> Term:
    return (state(job.ev, other, State.SPEED) > STANDING) & (conflict.their_arrival < SOON)


def _retreats(job: Job, conflict: Conflict, lost: Term) -> Term:
    """Return whether an actor just inside cannot leave before the other arrives, but can stop and back out."""
    inside = (conflict.enter <= 0.0) & (job.speed() < CRAWLING)
    time = job.speed() / braking(job) + _time_to_back_out(conflict)
    return inside & ~is_out_before(conflict, lost) & (time < conflict.their_arrival)


def _halts_at_edge(job: Job, conflict: Conflict, lost: Term) -> Term:
    """Return whether to brake just inside the area, since the actor cannot leave it before the other arrives.

    It comes to rest before outlines touch, or the other actor is about to arrive.
    """
    inside = (conflict.enter <= 0.0) & (conflict.back < math.inf)
    comes_to_rest = conflict.back + stopping_distance(job) < TOUCHING
    return inside & ~is_out_before(conflict, lost) & (comes_to_rest | (conflict.their_arrival < AT_ONCE))


def _is_free_behind(job: Job) -> Term:
    """Return whether the room for backing up is free now and soon.

    The room begins at the rear end of the actor, so an actor next to it or ahead is not in it. This needs no comparison
    of positions along its heading, which for an actor exactly abreast would depend on rounding.
    """
    ev, here = job.ev, current_pose(job.ev, job.actor)
    back = 0.5 * (size_of(job.actor, "length") + BEHIND)
    x, y = here.x - back * cos(here.heading), here.y - back * sin(here.heading)
    room = ev.algebra.pack(x, y, here.heading, ev.algebra.literal(BEHIND), size_of(job.actor, "width"))
    blocked = []
    for other in others(ev, job.actor):
        there, size = current_pose(ev, other), (size_of(other, "length"), size_of(other, "width"))
        outlines = [ev.algebra.pack(*place, there.heading, *size) for place in _places(job, other, WHILE)]
        near = ev.algebra.any_of([box_distance(room, outline) < ROOM for outline in outlines])
        blocked.append(is_present(ev, other) & near)
    return ~ev.algebra.any_of(blocked)


def _goes_before(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Return whether the actor passes before another; at a merge, also fast enough not to be hit from behind."""
    joining = conflict.arrives + (MERGING_GAP + _lost(job, other))
    return where(conflict.parts, conflict.clears + GAP, joining) < conflict.earliest


def _lost(job: Job, other: Actor) -> Term:
    """Return the time by which another actor gains from behind [s]: dv^2 / 2 a over its speed.

    dv is the speed that the actor lacks, a its acceleration.
    """
    theirs = maximum(state(job.ev, other, State.SPEED), 1.0)
    slower = maximum(theirs - JOINING_SPEED, 0.0)
    return slower * slower / (2.0 * throttle(job) * theirs)


def _beside(job: Job, path: Term) -> tuple[Term, Term]:
    """Return the actor's offset to the left of its way, and the extra reach of its oblique outline [m]."""
    here = current_pose(job.ev, job.actor)
    s = path_project(path, here.x, here.y)
    off, heading = left_of_path(path, s, here), path_pose(path, s)[2]
    askew = 0.5 * size_of(job.actor, "length") * abs(sin(here.heading - heading))
    return off, askew


def _kept_aside(job: Job, path: Term) -> Term:
    """Return the offset from its way [m] at which the actor is clear of actors on that way; 0 without any.

    Actors count that are next to it or will be before it is back.
    """
    here, aside = current_pose(job.ev, job.actor), job.ev.algebra.literal(0.0)
    s = path_project(path, here.x, here.y)
    for other in others(job.ev, job.actor):
        there, theirs = current_pose(job.ev, other), state(job.ev, other, State.SPEED)
        behind = s - path_project(path, there.x, there.y)
        long = 0.5 * (size_of(job.actor, "length") + size_of(other, "length")) + LINE
        wide = 0.5 * (size_of(job.actor, "width") + size_of(other, "width")) + _swing(other)
        comes = (behind > -long) & (behind < long + theirs * RETURN)
        on_it = job.ev.algebra.any_of([path_distance(path, *place) < wide for place in _places(job, other, LATER)])
        near = is_present(job.ev, other) & comes & on_it & unhidden(job.ev, job.actor, other)
        aside = maximum(aside, where(near, wide, 0.0))
    return aside


def _places(job: Job, other: Actor, times: Sequence[float]) -> list[tuple[Term, Term]]:
    """Return the positions (x, y) [m] of another actor at future times [s], with its present velocity."""
    there, speed = current_pose(job.ev, other), state(job.ev, other, State.SPEED)
    along, across = speed * cos(there.heading), speed * sin(there.heading)
    return [(there.x + along * later, there.y + across * later) for later in times]


def _swing(other: Actor) -> Term:
    """Return the distance by which the front of another actor swings out of its way in a bend [m]."""
    front, beside = 0.5 * size_of(other, "length") + size_of(other, "rearToCenter"), 0.5 * size_of(other, "width")
    return hypot(BEND_RADIUS + beside, front) - (BEND_RADIUS + beside)


def _approach(job: Job, room: Term) -> Term:
    """Speed from which a planned stop ends within so much room [m/s]."""
    return speed_to_stop(room - STOP_PREVIEW * job.speed())
