"""The library's cyclist: it keeps its side, looks back before it turns across its lane, and filters past queues.

It rides along a bicycle lane, or along lanes 1 m from their outer edge: cars leave the most room to cyclists who ride
0.9 to 1.2 m from the kerb (Florida DOT 2011). Behind others it rides as the Intelligent Driver Model (`following`), and
gives way at intersections as `caution` does. A standing vehicle beside its line is passed if 0.5 m are left (an
estimate); otherwise it waits behind it.

Before a turn across its lane (to the left in right-hand traffic) it looks over its shoulder from 30 m before the
intersection on, and moves to the middle of the lane once no vehicle from behind would be there within 2 s (both
*ours*). Until then it keeps its side, and stops before the intersection. After the turn it returns to its side.
"""

from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.acting.caution import entries_of, must_wait, room_before
from cortex_dsl.semantics.acting.following import LEAST_GAP, idm, path_to_follow
from cortex_dsl.semantics.acting.job import SPEED_GAIN, Job
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, left_of_path, others, size_of, state
from cortex_dsl.semantics.evaluation.lanes import chosen, looked_up
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import notice_reach, unhidden
from cortex_dsl.semantics.evaluation.trajectories import Trajectory, trajectory
from cortex_dsl.semantics.model.values import Actor, LaneNow
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    cos,
    lead_on,
    maximum,
    path_pose,
    path_project,
    where,
)
from engine.frozen import frozen
from engine.road.network import Lane, LaneRole, Surface
from engine.road.sections import LaneSection, maneuver_of
from engine.vocabulary import ManeuverType, State

CYCLING_SPEED = 15.0 / 3.6
"""Target speed [m/s]: a cyclist in the tests of Euro NCAP."""
EDGE = 1.0
"""Distance from the outer edge of the lane [m]."""
CLEARANCE = 0.5
"""Distance at which a standing vehicle is passed [m]; an estimate."""
ACCELERATION, DECELERATION = 1.0, 2.0
"""a and b of the model [m/s^2]; *ours*: an easy start, and half of the hardest braking of a bicycle."""
LOOK_FROM = 30.0
"""Distance before the intersection from which on it looks back [m]; *ours*."""
LOOK_TIME = 2.0
"""Time within which a vehicle from behind keeps it from moving over [s]; *ours*."""
STANDING = 0.5
"""Speed below which a vehicle is passed as one that stands [m/s]; *ours*."""
BEHIND_TURN = 2.0
"""Distance behind the turn from which on it returns to its side [m]; *ours*."""


@frozen
class _Ride:
    """The path of a cyclist, its place on it, and the offset of its side [m]."""

    job: Job
    path: Term
    side: Term
    at: Term
    """Arc length of its place [m]."""
    speed: Term
    """Target speed of one that is alone [m/s]."""

    def follow(self, offset: Term, limit: Term | None = None) -> ir.Act:
        """Follow the path at an offset, no faster than others allow."""
        speed = self.speed if limit is None else where(limit < self.speed, limit, self.speed)
        follow = self.job.follow(self.path, speed)
        assert isinstance(follow, ir.Follow)
        return replace(follow, aside=offset)


def ride(job: Job) -> ir.Block:
    """Ride on one's side; look back before a turn across the lane."""
    job.must_steer()
    given, span = job.given("trajectory"), job.call.spans.get("trajectory", job.call.span)
    on_path = chosen(given) if not isinstance(given, LaneNow) else given
    algebra, way = job.ev.algebra, None
    if isinstance(on_path, Surface):
        acts, path, side = (), algebra.literal(float(on_path.path)), algebra.literal(0.0)
    else:
        acts, path = path_to_follow(job)
        keep, side = job.kept(_side(job))
        acts = (*acts, keep)
        if given is not None and not isinstance(on_path, LaneNow | Lane | LaneSection):
            way = trajectory(on_path, span)
    here = current_pose(job.ev, job.actor)
    at = path_project(path, here.x, here.y)
    speed = job.speed() + _acceleration(job, path, at) / SPEED_GAIN
    for entry, maneuver in () if way is None else entries_of(way):
        room = room_before(job, path, entry)
        speed = job.stopping(speed, must_wait(job, maneuver, room), room)
    ridden = _Ride(job, path, side, at, speed)
    turn = None if way is None else _turn(way)
    return (*acts, *(_looking_back(ridden, *turn) if turn is not None else (ridden.follow(side),)))


def _side(job: Job) -> Term:
    """Return the offset [m] at which a cyclist is `edge` from the outer edge of the lane that it is on."""
    network, lane = network_of(job.ev), job.lane()
    assert lane is not None
    width = looked_up(job.ev, lane, [each.width for each in network.lanes], missing=0.0)
    inside = maximum(0.0, 0.5 * width - job.number("edge", EDGE))
    return inside if network.left_hand else 0.0 - inside


def _turn(way: Trajectory) -> tuple[float, float] | None:
    """Return the arc lengths at which the first turn across the lane begins and ends [m]; None without one."""
    s, across = 0.0, (ManeuverType.LEFT_TURN, ManeuverType.U_TURN)
    if way.lanes[0].network.left_hand:
        across = (ManeuverType.RIGHT_TURN, ManeuverType.U_TURN)
    for lane in way.lanes:
        if lane.role is LaneRole.CONNECTING and maneuver_of(lane).type in across:
            return s, s + lane.length
        s += lane.length
    return None


def _looking_back(ride: _Ride, begin: float, end: float) -> ir.Block:
    """Keep the side until it is free behind, turn from the middle of the lane, and return to the side."""
    job, middle = ride.job, ride.job.ev.algebra.literal(0.0)
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    free = ~job.ev.algebra.any_of([_comes_up(ride, each) for each in vehicles])
    near, room = ride.at >= begin - LOOK_FROM, room_before(job, ride.path, begin)
    waiting = job.stopping(ride.speed, near, room)
    return (
        job.until((ride.follow(ride.side, waiting),), near & free),
        job.until((ride.follow(middle),), ride.at >= end + BEHIND_TURN),
        ride.follow(ride.side),
    )


def _comes_up(ride: _Ride, other: Actor) -> Term:
    """Return whether a vehicle is beside a cyclist, or reaches it from behind within `LOOK_TIME`."""
    job, ev = ride.job, ride.job.ev
    there = current_pose(ev, other)
    at = path_project(ride.path, there.x, there.y)
    aside = abs(left_of_path(ride.path, at, there))
    long = 0.5 * (size_of(job.actor, "length") + size_of(other, "length"))
    closing = state(ev, other, State.SPEED) * cos(there.heading - path_pose(ride.path, at)[2]) - job.speed()
    gap = ride.at - at - long
    near = (gap < closing * LOOK_TIME) | (gap < 0.0)
    in_lane = aside < 0.5 * size_of(other, "width") + EDGE
    behind = is_present(ev, other) & (at < ride.at + long)
    return behind & near & in_lane & unhidden(ev, job.actor, other)


def _acceleration(job: Job, path: Term, at: Term) -> Term:
    """Return the acceleration of the model [m/s^2], behind the lead and standing vehicles without room beside."""
    gap, lead = lead_on(path, job.actor.index, notice_reach(job.ev))
    for other in others(job.ev, job.actor):
        if other.kind not in NOT_VEHICLES:
            blocked = _blocks(job, path, at, other)
            lead, gap = where(blocked < gap, 0.0, lead), where(blocked < gap, blocked, gap)
    pair = job.number("max_acceleration", ACCELERATION), job.number("comfortable_deceleration", DECELERATION)
    return idm(job, job.speed(), job.target_speed(CYCLING_SPEED), maximum(gap, LEAST_GAP), lead, pair)


def _blocks(job: Job, path: Term, at: Term, other: Actor) -> Term:
    """Return the gap to a standing vehicle that leaves too little room beside it [m], else infinity."""
    ev, here, there = job.ev, current_pose(job.ev, job.actor), current_pose(job.ev, other)
    s = path_project(path, there.x, there.y)
    aside = left_of_path(path, s, there) - left_of_path(path, at, here)
    apart = abs(aside) - 0.5 * (size_of(job.actor, "width") + size_of(other, "width"))
    gap = s - at - 0.5 * (size_of(job.actor, "length") + size_of(other, "length"))
    stands = abs(state(ev, other, State.SPEED)) < STANDING
    close = (apart < job.number("clearance", CLEARANCE)) & (gap > 0.0) & (s > at)
    on_road = is_present(ev, other) & stands & close & unhidden(ev, job.actor, other)
    return where(on_road, gap, float("inf"))
