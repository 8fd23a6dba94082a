"""Library behaviours that react to others: braking for a close collision, giving way at an intersection, and people
on foot who cross another's way.

The emergency brake acts on the ways that both go, as `foreseeing` tells them; with `foresees=False` on time to
collision, exact for the outlines, at constant velocities. The default threshold of both is that of UN Regulation 157
(automated lane keeping), paragraph 5.2.5.2, for when a collision with a vehicle that cuts in must be avoided:

    TTC < v_rel / (2 * 6 m/s^2) + 0.35 s

the time that a steady 6 m/s^2 takes away from the relative speed while closing half as fast on average, and 0.35 s
before the brakes act. v_rel is the magnitude of the relative velocity here, which is the same for two in one lane and
larger, so earlier, for those who cross. Once it brakes it goes on until the actor stands or is off its collision
course: nothing would be hit within 4 s, the time to collision that parts safe from uncomfortable driving (Hirst and
Graham 1997, in Noy, "Ergonomics and Safety of Intelligent Driver Interfaces"). At standstill it holds while an actor is
close ahead in the lane or intersection.

Nobody acts on who is hidden behind others or buildings. Heads turn, so drivers notice in all directions,
as far as the weather lets anybody see.

Giving way waits at the entry of an intersection until the gap in conflicting traffic is long enough. Who conflicts is a
matter of the road network (`engine.road.linking`). A vehicle is waited for while it would come into the way within the
critical gap at its present speed, or is in the way already. Critical gaps by maneuver are the base values of the
Highway Capacity Manual (2000), exhibit 17-5, two-lane major street: the turn across oncoming traffic 4.1 s, the near
turn 6.2 s, straight across 6.5 s.
"""

import math
from itertools import accumulate

from cortex_dsl import ir
from cortex_dsl.semantics.acting.following import follow_lane
from cortex_dsl.semantics.acting.foreseeing import (
    GAP,
    LINE,
    Conflict,
    Sight,
    braking_helps,
    can_stop,
    foreseen,
    throttle,
)
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.errors.behaviours import NO_INTERSECTION
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES, actor_of, together
from cortex_dsl.semantics.evaluation.geometry import (
    between,
    current_pose,
    is_present,
    others,
    outline_of,
    size_of,
    state,
)
from cortex_dsl.semantics.evaluation.lanes import Trajectory, index_of, lane_at, looked_up, trajectory
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import notice_reach, sees, unhidden
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import Term, box_distance, cos, hypot, maximum, path_project, sin, where
from engine.road.linking import Window, windows
from engine.road.network import LaneRole, Maneuver
from engine.road.sections import maneuver_of
from engine.vocabulary import Command, ManeuverType, State

REFERENCE_DECELERATION = 6.0
REFERENCE_DELAY = 0.35
AVOIDANCE_THRESHOLD = 10.0
"""Default of Scenic's `DriveAvoidingCollisions` [m]."""
CLEAR = 4.0
"""Time to collision above which braking ends [s]."""
MARGIN = 0.3
"""Two who are in the area so shortly after one another count as being there at a time [s]; *ours*."""
RESUMED = 5.0
"""Speed that a driver at rest is taken to go on with [m/s]; *ours*."""
STANDSTILL = 0.01
"""[m/s]"""
HOLD_GAP = 3.0
"""Between the outlines, within which a standing actor keeps standing; *ours* [m]."""


def emergency_brake(job: Job) -> ir.Block:
    """Another behaviour; full brakes while a collision is close, until it is not or the actor stands."""
    span = job.call.spans["behavior"]
    call = as_behaviour(job.given("behavior"), span)
    if call is None:
        actual = kind_name(job.given("behavior"))
        raise WRONG_KIND.mistake(
            span, what="`behavior`", expected="a behavior", actual=actual, cure="as in `FollowLaneBehavior(10 m/s)`"
        )
    if job.flag("foresees", default=True):
        partners, sight = others(job.ev, job.actor), Sight.of(job)
        close = job.ev.algebra.any_of([_is_close(job, each, sight) for each in partners]) & _works(job)
        # It brakes on while it would begin to: a handler that ends at once would be entered again, without an action.
        on = close | job.ev.algebra.any_of([_stays_close(job, each, sight) for each in partners]) | _blocked(job)
    else:
        close = _collision_is_close(job)
        on = _on_collision_course(job) | _blocked(job)
    return (ir.TryInterrupt(job.call.span, job.inline(call), ((close, (_full_brake(job, on),)),)),)


def _on_collision_course(job: Job) -> Term:
    """Whether something would be hit soon, and no later than where braking begins."""
    soon = maximum(CLEAR, job.number("threshold")) if job.given("threshold") is not None else CLEAR
    return _moves(job) & (job.ev.algebra.time_to_contact(job.actor.index, reach=notice_reach(job.ev)) < soon)


def _collision_is_close(job: Job) -> Term:
    if job.given("threshold") is not None:
        close = job.ev.algebra.time_to_contact(job.actor.index, reach=notice_reach(job.ev)) < job.number("threshold")
    else:
        close = job.ev.algebra.any_of([_within_reference(job, other) for other in others(job.ev, job.actor)])
    return _moves(job) & close


def _within_reference(job: Job, other: Actor) -> Term:
    """TTC < v_rel / (2 b) + delay."""
    braking = 2.0 * job.number("reference_deceleration", REFERENCE_DECELERATION)
    threshold = _relative_speed(job, other) / braking + job.number("delay", REFERENCE_DELAY)
    time = job.ev.algebra.time_to_contact(job.actor.index, other.index, notice_reach(job.ev))
    return is_present(job.ev, other) & (time < threshold)


def _works(job: Job) -> Term:
    """Whether the actor moves, within the range of speeds in which its brake works."""
    speed = job.speed()
    return _moves(job) & (speed >= job.number("min_speed", 0.0)) & (speed <= job.number("max_speed", math.inf))


def _is_close(job: Job, other: Actor, sight: Sight) -> Term:
    """Whether it is time to brake for another: where ways cross, as long as one can stop before the area, or passes
    behind; in one lane by time to collision.
    """
    still = job.ev.algebra.literal(0.0)
    conflict = foreseen(job, -1.0, other, sight, job.speed(), still)
    speed, closing = job.speed(), _closing(job, other, conflict)
    braking = 2.0 * job.number("reference_deceleration", REFERENCE_DECELERATION)
    delay = job.number("delay", REFERENCE_DELAY)
    if job.given("threshold") is not None:
        threshold = job.number("threshold")
        last = maximum(conflict.arrives, conflict.their_arrival) < threshold
        in_lane = conflict.enter < closing * threshold
    else:
        last = conflict.enter < speed * (speed / braking + delay) + LINE
        # TTC < v_rel / (2 b) + delay
        in_lane = (closing > 0.0) & (conflict.enter < closing * (closing / braking + delay))
    crossing = conflict.crosses & conflict.coincides(MARGIN) & last
    crossing = crossing & (can_stop(job, conflict) | braking_helps(job, conflict))
    following = (conflict.is_ahead | conflict.comes) & conflict.exists & in_lane
    return is_present(job.ev, other) & (crossing | following)


def _stays_close(job: Job, other: Actor, sight: Sight) -> Term:
    """Whether to go on braking, or to wait: before an area until one who drives on is through before the other."""
    conflict = foreseen(job, -1.0, other, sight, maximum(job.speed(), RESUMED), throttle(job))
    last = where(conflict.parts, conflict.clears, conflict.arrives) + GAP
    waits = conflict.crosses & (conflict.enter > 0.0) & (last >= conflict.their_arrival)
    waits = waits & (can_stop(job, conflict) | braking_helps(job, conflict))
    inside = conflict.crosses & (conflict.enter <= 0.0) & (conflict.their_enter <= 0.0)
    closes = conflict.enter < _closing(job, other, conflict) * CLEAR
    follows = (conflict.is_ahead | conflict.comes) & conflict.exists & closes
    return is_present(job.ev, other) & (waits | ((follows | inside) & _moves(job)))


def _closing(job: Job, other: Actor, conflict: Conflict) -> Term:
    """How fast the gap to another shrinks that is on one's way [m/s]."""
    return job.speed() - hypot(*_velocity(job, other)) * conflict.along


def _blocked(job: Job) -> Term:
    """Return whether the actor stands close behind another."""
    close = job.ev.algebra.any_of([_close_ahead(job, each) for each in others(job.ev, job.actor)])
    return ~_moves(job) & close


def _close_ahead(job: Job, other: Actor) -> Term:
    ev = job.ev
    near = box_distance(outline_of(ev, job.actor), outline_of(ev, other)) < HOLD_GAP
    here, there = current_pose(ev, job.actor), current_pose(ev, other)
    return ev.algebra.all_of((is_present(ev, other), near, sees(ev, job.actor, other), together(ev, here, there)))


def _moves(job: Job) -> Term:
    return job.speed() > STANDSTILL


def _full_brake(job: Job, while_: Term) -> ir.Act:
    pedal = job.number("brake", 1.0)
    return ir.Loop(job.call.span, while_, (ir.Take(job.call.span, ((Command.BRAKE, pedal),)),))


def _relative_speed(job: Job, other: Actor) -> Term:
    (x, y), (other_x, other_y) = _velocity(job, job.actor), _velocity(job, other)
    return hypot(other_x - x, other_y - y)


def _velocity(job: Job, actor: Actor) -> tuple[Term, Term]:
    """Of the rear axle, along the heading; somebody whom a third may strike can slide across it."""
    if actor is not job.actor and len(others(job.ev, job.actor)) > 1:
        x, y = job.ev.algebra.velocity(actor.index)
        return x, y
    heading, speed = current_pose(job.ev, actor).heading, state(job.ev, actor, State.SPEED)
    return speed * cos(heading), speed * sin(heading)


def drive_avoiding(job: Job) -> ir.Block:
    """Follow the lane; full brakes while another vehicle is near."""
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    limit = job.number("avoidance_threshold", AVOIDANCE_THRESHOLD)
    near = job.ev.algebra.any_of([_noticed_near(job, each, limit) for each in vehicles])
    brake = ir.Take(job.call.span, ((Command.BRAKE, job.ev.algebra.literal(1.0)),))
    return (ir.TryInterrupt(job.call.span, follow_lane(job), ((near, (brake,)),)),)


def _noticed_near(job: Job, other: Actor, limit: Term) -> Term:
    near = between(current_pose(job.ev, job.actor), current_pose(job.ev, other)) <= limit
    return job.ev.algebra.all_of((is_present(job.ev, other), near, unhidden(job.ev, job.actor, other)))


# -- giving way --------------------------------------------------------------------------------------------------------

FAR_TURN_GAP = 4.1
NEAR_TURN_GAP = 6.2
STRAIGHT_GAP = 6.5
ROUNDABOUT_GAP = 5.0
"""Mean critical headway of roundabouts with one lane [s]: NCHRP Report 572, Transportation Research Board, 2007."""


def accept_gap(job: Job) -> ir.Block:
    """Follow a trajectory, and stop before each intersection while another actor is in the way or comes into it."""
    way = trajectory(job.call.arguments["trajectory"], job.call.spans["trajectory"])
    entries = _entries(way)
    if not entries:
        raise NO_INTERSECTION.mistake(job.call.spans["trajectory"])
    path, speed = job.ev.algebra.literal(float(way.path)), job.target_speed()
    for entry, maneuver in entries:
        room = _room(job, path, entry)
        speed = job.stopping(speed, _must_wait(job, maneuver, room), room)
    return (job.follow(path, speed),)


def _entries(way: Trajectory) -> list[tuple[float, Maneuver]]:
    """Arc length of every stop line on a trajectory, and the maneuver behind it."""
    starts = accumulate((lane.length for lane in way.lanes[:-1]), initial=0.0)
    pairs = zip(starts, way.lanes, strict=True)
    found = [(start, maneuver_of(lane)) for start, lane in pairs if lane.role is LaneRole.CONNECTING and start > 0.0]
    return [(start, maneuver) for start, maneuver in found if _may_wait(maneuver)]


def _may_wait(maneuver: Maneuver) -> bool:
    """Whether there may be somebody to wait for; signs of a roundabout say that for some there never is."""
    return maneuver.intersection.network.links.gives_way is None or bool(maneuver.gives_way_to)


def _room(job: Job, path: Term, entry: float) -> Term:
    """From the front of the actor to a stop line [m]."""
    pose = current_pose(job.ev, job.actor)
    return entry - (path_project(path, pose.x, pose.y) + _half_length(job.actor))


def _half_length(actor: Actor) -> Term:
    return size_of(actor, "length") * 0.5


def _must_wait(job: Job, maneuver: Maneuver, room: Term) -> Term:
    """Return whether the actor must wait for another; never where it could no longer stop."""
    speed = job.speed()
    energy = 0.5 * (speed * speed)
    can_stop = energy <= size_of(job.actor, "maxBraking") * room
    places, gap = windows(maneuver), job.number("critical_gap", _base_gap(maneuver))
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    somebody = job.ev.algebra.any_of([_in_the_way(job, each, places, gap) for each in vehicles])
    return can_stop & somebody


def _base_gap(maneuver: Maneuver) -> float:
    if maneuver.intersection.network.links.gives_way is not None:
        return ROUNDABOUT_GAP
    if maneuver.type is ManeuverType.STRAIGHT:
        return STRAIGHT_GAP
    left_hand = maneuver.intersection.network.left_hand
    near = ManeuverType.LEFT_TURN if left_hand else ManeuverType.RIGHT_TURN
    return NEAR_TURN_GAP if maneuver.type is near else FAR_TURN_GAP


def _in_the_way(job: Job, other: Actor, places: tuple[Window, ...], gap: Term) -> Term:
    ev = job.ev
    pose, half = current_pose(ev, other), _half_length(other)
    lane = index_of(ev, lane_at(ev, pose))
    assert lane is not None
    path = looked_up(ev, lane, [each.path for each in network_of(ev).lanes], missing=0.0)
    s = path_project(path, pose.x, pose.y)
    enter = looked_up(ev, lane, [place.enter for place in places], missing=math.inf)
    leave = looked_up(ev, lane, [place.leave for place in places], missing=-math.inf)
    to_go = enter - (s + half)
    soon = to_go < gap * state(ev, other, State.SPEED)
    not_past = s - half < leave
    return ev.algebra.all_of((is_present(ev, other), soon, not_past, unhidden(ev, job.actor, other)))


# -- people on foot, and others who cross another's way ----------------------------------------------------------------

WALKING_SPEED = 0.5
CROSSING_SPEED = 1.0
CROSSING_THRESHOLD = 10.0
"""Defaults of the behaviours of the same names in Scenic's CARLA model [m/s, m]."""


def walk_forward(job: Job) -> ir.Block:
    speed = job.number("speed", WALKING_SPEED)
    return (job.forever(ir.Take(job.call.span, ((Command.SPEED, speed),))),)


def cross(job: Job) -> ir.Block:
    """Wait until the other is near; go so fast as to meet it where the ways cross, until it has passed; go on.

    With the other's place as origin, y ahead of it and x across, the walker has |x| to go while the other has y, so it
    takes |x| v / y, at least `min_speed`.
    """
    other = actor_of(Given(job.given("reference_actor"), job.call.spans["reference_actor"]), "`reference_actor`")
    least = job.number("min_speed", CROSSING_SPEED)
    last = least if job.given("final_speed") is None else job.number("final_speed")
    apart = between(current_pose(job.ev, job.actor), current_pose(job.ev, other))
    ahead, across = _seen_from(job, other)
    ratio = state(job.ev, other, State.SPEED) / ahead
    speed = maximum(least, abs(across) * ratio)
    far = job.number("threshold", CROSSING_THRESHOLD) < apart
    coming = ahead > 0.0
    return (
        ir.Loop(job.call.span, far, (ir.Wait(job.call.span),)),
        ir.Loop(job.call.span, coming, (ir.Take(job.call.span, ((Command.SPEED, speed),)),)),
        job.forever(ir.Take(job.call.span, ((Command.SPEED, last),))),
    )


def _seen_from(job: Job, other: Actor) -> tuple[Term, Term]:
    """How far ahead of the other, and to its left, the actor is [m]."""
    here, there = current_pose(job.ev, job.actor), current_pose(job.ev, other)
    dx, dy = here.x - there.x, here.y - there.y
    c, s = cos(there.heading), sin(there.heading)
    return dx * c + dy * s, dy * c - dx * s
