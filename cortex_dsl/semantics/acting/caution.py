"""Library behaviours that react to other actors: giving way at an intersection, and crossing pedestrians.

No driver reacts to an actor hidden behind actors or buildings. Heads turn, so drivers notice in all directions, within
the visibility of the weather.

Giving way waits at the entry of an intersection until the gap in conflicting traffic is long enough. The road network
defines conflicts (`engine.road.linking`). The driver waits for a vehicle that would come into the way within the
critical gap at its present speed, or is in the way already. Critical gaps by maneuver are the base values of the
Highway Capacity Manual (2000), exhibit 17-5, two-lane major street: the turn across oncoming traffic 4.1 s, the near
turn 6.2 s, straight across 6.5 s.

These behaviours are Python, not text of the language: as text, avoiding, walking and crossing drove the same scenes to
the last bit, but 51 lines of text and 89 of Python replaced 64 lines. Giving way cannot be text, because it changes the
target speed in each step, and the arguments of a behavior are evaluated once, where it starts.
"""

import math
from itertools import accumulate

from cortex_dsl import ir
from cortex_dsl.semantics.acting.crossings import goes_first, setback
from cortex_dsl.semantics.acting.following import follow_lane
from cortex_dsl.semantics.acting.foreseeing import LINE, Sight, can_stop, foreseen
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.errors.runs import NO_INTERSECTION
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES, actor_of
from cortex_dsl.semantics.evaluation.geometry import (
    between,
    current_pose,
    is_present,
    others,
    size_of,
    state,
)
from cortex_dsl.semantics.evaluation.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import unhidden
from cortex_dsl.semantics.evaluation.trajectories import Trajectory, trajectory
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import Term, cos, maximum, path_project, sin
from engine.maps import Roundabout
from engine.road.linking import Window, windows
from engine.road.network import LaneRole, Maneuver
from engine.road.sections import maneuver_of
from engine.vocabulary import Command, ManeuverType, State

AVOIDANCE_SPEED, AVOIDANCE_THRESHOLD = 25.0, 10.0
"""Defaults of Scenic's `DriveAvoidingCollisions` [m/s, m]."""


def drive_avoiding(job: Job) -> ir.Block:
    """Follow the lane; full brakes while another vehicle is near."""
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    limit = job.number("avoidance_threshold", AVOIDANCE_THRESHOLD)
    near = job.ev.algebra.any_of([_noticed_near(job, each, limit) for each in vehicles])
    brake = job.braking(job.ev.algebra.literal(1.0))
    return (ir.TryInterrupt(job.call.span, follow_lane(job, AVOIDANCE_SPEED), ((near, (brake,)),)),)


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
    entries = entries_of(way)
    if not entries:
        raise NO_INTERSECTION.mistake(job.call.spans["trajectory"])
    path, speed = job.ev.algebra.literal(float(way.path)), job.target_speed()
    for entry, maneuver in entries:
        room = room_before(job, path, entry)
        speed = job.stopping(speed, must_wait(job, maneuver, room), room)
    sight = Sight.of(job)
    for other in others(job.ev, job.actor):
        if (first := goes_first(job, other)) is not None:
            conflict = foreseen(job, path, other, sight, job.speed(), job.ev.algebra.literal(0.0))
            stops = first & conflict.crosses & can_stop(job, conflict)
            speed = job.stopping(speed, stops, conflict.enter - setback(job, other) - LINE)
    return (job.follow(path, speed),)


def entries_of(way: Trajectory) -> list[tuple[float, Maneuver]]:
    """Arc length of every stop line on a trajectory, and the maneuver behind it."""
    starts = accumulate((lane.length for lane in way.lanes[:-1]), initial=0.0)
    pairs = zip(starts, way.lanes, strict=True)
    found = [(start, maneuver_of(lane)) for start, lane in pairs if lane.role is LaneRole.CONNECTING and start > 0.0]
    return [(start, maneuver) for start, maneuver in found if _may_wait(maneuver)]


def _may_wait(maneuver: Maneuver) -> bool:
    """Return whether there may be traffic to wait for; signs of a roundabout rule it out for some maneuvers."""
    return maneuver.intersection.network.links.gives_way is None or bool(maneuver.gives_way_to)


def room_before(job: Job, path: Term, entry: float) -> Term:
    """Return the distance from the front of the actor to a stop line [m]."""
    pose = current_pose(job.ev, job.actor)
    return entry - (path_project(path, pose.x, pose.y) + _half_length(job.actor))


def _half_length(actor: Actor) -> Term:
    return size_of(actor, "length") * 0.5


def must_wait(job: Job, maneuver: Maneuver, room: Term) -> Term:
    """Return whether the actor must wait for another actor; False if it can no longer stop."""
    speed = job.speed()
    energy = 0.5 * (speed * speed)
    can_stop = energy <= size_of(job.actor, "maxBraking") * room
    places, gap = windows(maneuver), job.number("critical_gap", _base_gap(maneuver))
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    somebody = job.ev.algebra.any_of([_in_the_way(job, each, places, gap) for each in vehicles])
    return can_stop & somebody


def _base_gap(maneuver: Maneuver) -> float:
    if isinstance(maneuver.intersection.network.spec, Roundabout):
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


# -- pedestrians, and actors that cross the way of others --------------------------------------------------------------

WALKING_SPEED = 0.5
CROSSING_SPEED = 1.0
CROSSING_THRESHOLD = 10.0
"""Defaults of the behaviours of the same names in Scenic's CARLA model [m/s, m]."""
ABREAST = 0.01
"""Distance to the other actor's way below which an actor counts as abreast [m].

Exactly abreast it is 0 but for rounding, and its inverse gives a speed.
"""


def walk_forward(job: Job) -> ir.Block:
    speed = job.number("speed", WALKING_SPEED)
    return (job.forever(ir.Take(job.call.span, ((Command.SPEED, speed),))),)


def cross(job: Job) -> ir.Block:
    """Wait until the other actor is near; meet it where the ways cross; walk on after it has passed.

    In the frame of the other actor, y is ahead and x across: the walker has |x| to go while the other has y, so its
    speed is |x| v / y, at least `min_speed`.
    """
    other = actor_of(Given(job.given("reference_actor"), job.call.spans["reference_actor"]), "`reference_actor`")
    least = job.number("min_speed", CROSSING_SPEED)
    last = least if job.given("final_speed") is None else job.number("final_speed")
    apart = between(current_pose(job.ev, job.actor), current_pose(job.ev, other))
    ahead, across = _seen_from(job, other)
    ratio = state(job.ev, other, State.SPEED) / ahead
    speed = maximum(least, abs(across) * ratio)
    far = job.number("threshold", CROSSING_THRESHOLD) < apart
    coming = ahead > ABREAST
    return (
        ir.Loop(job.call.span, far, (ir.Wait(job.call.span),)),
        ir.Loop(job.call.span, coming, (ir.Take(job.call.span, ((Command.SPEED, speed),)),)),
        job.forever(ir.Take(job.call.span, ((Command.SPEED, last),))),
    )


def _seen_from(job: Job, other: Actor) -> tuple[Term, Term]:
    """Return the position of the actor in the frame of the other actor: ahead and to the left [m]."""
    here, there = current_pose(job.ev, job.actor), current_pose(job.ev, other)
    dx, dy = here.x - there.x, here.y - there.y
    c, s = cos(there.heading), sin(there.heading)
    return dx * c + dy * s, dy * c - dx * s
