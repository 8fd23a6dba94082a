"""Giving way: wait at the entry of an intersection until the gap in conflicting traffic is long enough.

Who conflicts is a matter of the road network (`engine.road.linking`). A vehicle is waited for while it would come into
the way within the critical gap at its present speed, or is in the way already. Critical gaps by maneuver are the base
values of the Highway Capacity Manual (2000), exhibit 17-5, two-lane major street: the turn across oncoming traffic
4.1 s, the near turn 6.2 s, straight across 6.5 s.
"""

import math
from itertools import accumulate

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.acting.library.job import Job
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.evaluation.motion import all_of, any_of, current_pose, is_present, others, size, state
from cortex_dsl.semantics.evaluation.nearby import NOT_VEHICLES
from cortex_dsl.semantics.road.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.road.roads import network_of
from cortex_dsl.semantics.road.trajectories import Trajectory, trajectory
from engine.road.linking import Window, windows
from engine.road.network import LaneRole, Maneuver
from engine.road.sections import maneuver_of
from engine.vocabulary import ManeuverType, Op, State

FAR_TURN_GAP = 4.1
NEAR_TURN_GAP = 6.2
STRAIGHT_GAP = 6.5


def accept_gap(job: Job) -> ir.Block:
    """Follow a trajectory, and stop before each intersection while somebody is in the way or comes into it."""
    way = trajectory(job.call.arguments["trajectory"], job.call.spans["trajectory"])
    entries = _entries(way)
    if not entries:
        raise errors.NO_INTERSECTION.mistake(job.call.spans["trajectory"])
    path, speed = job.ev.algebra.literal(float(way.path)), job.target_speed()
    for entry, maneuver in entries:
        room = _room(job, path, entry)
        speed = job.stopping(speed, _must_wait(job, maneuver, room), room)
    return (job.follow(path, speed),)


def _entries(way: Trajectory) -> list[tuple[float, Maneuver]]:
    """Arc length of every stop line on a trajectory, and the maneuver behind it."""
    starts = accumulate((lane.length for lane in way.lanes[:-1]), initial=0.0)
    pairs = zip(starts, way.lanes, strict=True)
    return [(start, maneuver_of(lane)) for start, lane in pairs if lane.role is LaneRole.CONNECTING and start > 0.0]


def _room(job: Job, path: ir.Expr, entry: float) -> ir.Expr:
    """From the front of the actor to a stop line [m]."""
    algebra, pose = job.ev.algebra, current_pose(job.ev, job.actor)
    front = algebra.add(algebra.apply(Op.PATH_PROJECT, path, pose.x, pose.y), _half_length(job, job.actor))
    return algebra.sub(algebra.literal(entry), front)


def _half_length(job: Job, actor: Actor) -> ir.Expr:
    return job.ev.algebra.mul(size(actor, "length"), job.ev.algebra.literal(0.5))


def _must_wait(job: Job, maneuver: Maneuver, room: ir.Expr) -> ir.Expr:
    """Whether somebody is to be waited for; not by who could no longer stop."""
    algebra, speed = job.ev.algebra, job.speed()
    energy = algebra.mul(algebra.literal(0.5), algebra.mul(speed, speed))
    can_stop = algebra.apply(Op.LE, energy, algebra.mul(size(job.actor, "maxBraking"), room))
    places, gap = windows(maneuver), job.number("critical_gap", _base_gap(maneuver))
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    return all_of(job.ev, (can_stop, any_of(job.ev, [_in_the_way(job, each, places, gap) for each in vehicles])))


def _base_gap(maneuver: Maneuver) -> float:
    if maneuver.type is ManeuverType.STRAIGHT:
        return STRAIGHT_GAP
    left_hand = maneuver.intersection.network.spec.left_hand
    near = ManeuverType.LEFT_TURN if left_hand else ManeuverType.RIGHT_TURN
    return NEAR_TURN_GAP if maneuver.type is near else FAR_TURN_GAP


def _in_the_way(job: Job, other: Actor, places: tuple[Window, ...], gap: ir.Expr) -> ir.Expr:
    ev, algebra = job.ev, job.ev.algebra
    pose, half = current_pose(ev, other), _half_length(job, other)
    lane = index_of(ev, lane_at(ev, pose))
    assert lane is not None
    path = looked_up(ev, lane, [each.path for each in network_of(ev).lanes], missing=0.0)
    s = algebra.apply(Op.PATH_PROJECT, path, pose.x, pose.y)
    enter = looked_up(ev, lane, [place.enter for place in places], missing=math.inf)
    leave = looked_up(ev, lane, [place.leave for place in places], missing=-math.inf)
    to_go = algebra.sub(enter, algebra.add(s, half))
    soon = algebra.apply(Op.LT, to_go, algebra.mul(gap, state(ev, other, State.SPEED)))
    not_past = algebra.apply(Op.LT, algebra.sub(s, half), leave)
    return all_of(ev, (is_present(ev, other), soon, not_past))
