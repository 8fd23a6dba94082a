"""The library's driver with lane choice: the Intelligent Driver Model within a lane, MOBIL for lane changes.

Kesting, Treiber and Helbing (2007), "General lane-changing model MOBIL for car-following models", Transportation
Research Record 1999, 86-94, equations 2 and 3, with symmetric rules. The driver changes lanes if the new follower
brakes by no more than `safe_deceleration`, and if its own gain, plus `politeness` times the gain of the new and the old
follower, exceeds `advantage`:

    a_c' - a_c + p (a_n' - a_n + a_o' - a_o) > advantage        a_n' > -safe_deceleration

Accelerations are those of the Intelligent Driver Model, also for the other drivers; their assumed parameters are those
of this driver, their desired speed is the greater of its desired speed and their present speed. It changes to lanes of
its own direction.

An ending lane next to a continuing lane, such as that of an on-ramp, counts as having a standing actor at its end:
braking for that actor makes the change worthwhile, and without a gap the driver waits there (Treiber and Kesting,
"Traffic Flow Dynamics", 2013, chapter 14, on mandatory changes).
"""

import math
from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.semantics.acting.following import (
    COMFORTABLE_DECELERATION,
    MAX_ACCELERATION,
    idm,
    move_over,
)
from cortex_dsl.semantics.acting.job import SPEED_GAIN, Job
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, others, size_of, state
from cortex_dsl.semantics.evaluation.lanes import NOBODY, looked_up
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import notice_reach, unhidden
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    lead_on,
    maximum,
    minimum,
    path_distance,
    path_project,
    where,
)
from engine.frozen import frozen
from engine.road.merging import all_left_by, ways_through
from engine.road.network import Lane
from engine.road.sections import to_left, to_right
from engine.vocabulary import State

POLITENESS = 0.2
ADVANTAGE = 0.1
SAFE_DECELERATION = 4.0
STAY, LEFT, RIGHT = -1.0, 1.0, 2.0
"""Choices of a lane."""


@frozen
class _Lane:
    """A lane as its driver would drive in it."""

    path: Term
    gap: Term
    """Gap to the actor ahead [m]."""
    lead: Term
    """Speed of the actor ahead [m/s]."""
    behind: Term
    """Gap to the actor behind [m]; infinite without such an actor."""
    speed: Term
    """Speed of the actor behind [m/s]."""


def choose_lane(job: Job) -> ir.Block:
    """Follow a lane behind the actor ahead, and change to a better lane."""
    job.must_steer()
    algebra, span = job.ev.algebra, job.call.span
    choice = job.ev.run.new_local()
    chosen = algebra.local(choice)

    def choose(what: float) -> ir.Act:
        return ir.SetLocal(span, choice, algebra.literal(what))

    keep, lane = job.kept(_lane_now(job))
    own, here = job.kept(_route(job, lane))
    left, right = (_beside(job, _lane_now(job), find) for find in (to_left, to_right))
    now = _lane(job, here, lane)
    drive = ir.Follow(span, here, _speed(job, now), job.max_lateral(), job.ev.run.new_local(), aside=job.aside())
    handlers: list[tuple[Term, ir.Block]] = []
    for what, beside in ((RIGHT, right), (LEFT, left)):
        better = _is_better(job, now, _lane(job, _route(job, beside), beside))
        handlers.append(((beside >= 0.0) & better, (choose(what), ir.Abort(span))))
    to, aim = job.kept(where(chosen < RIGHT, left, right))
    change, path = job.kept(_route(job, aim))
    # At the end of its way the driver has nothing to choose, and is done.
    over = ir.Branch(span, chosen > 0.0, (to, change, *move_over(job, path, _speed(job, _lane(job, path, aim)))), ())
    rounds = (keep, own, choose(STAY), ir.TryInterrupt(span, (drive,), tuple(handlers)), over)
    return (choose(LEFT), ir.Loop(span, chosen > 0.0, rounds))


def _lane_now(job: Job) -> Term:
    index = job.lane()
    assert index is not None
    return index


def _route(job: Job, lane: Term) -> Term:
    return looked_up(job.ev, lane, ways_through(network_of(job.ev)), missing=0.0)


def _beside(job: Job, lane: Term, find: Callable[[Lane], Lane | None]) -> Term:
    """Return the neighbouring lane that leads the same way; -1 without one."""
    lanes = [(each, find(each)) for each in network_of(job.ev).lanes]
    same = [NOBODY if other is None or other.forward != each.forward else float(other.id) for each, other in lanes]
    return looked_up(job.ev, lane, same)


def _pair(job: Job) -> tuple[Term, Term]:
    """A and b of the model."""
    acceleration = job.number("max_acceleration", MAX_ACCELERATION)
    return acceleration, job.number("comfortable_deceleration", COMFORTABLE_DECELERATION)


def _speed(job: Job, lane: _Lane) -> Term:
    """The target speed by which the speed controller gives the model's acceleration in a lane."""
    return job.speed() + idm(job, job.speed(), job.target_speed(), lane.gap, lane.lead, _pair(job)) / SPEED_GAIN


def _lane(job: Job, path: Term, lane: Term) -> _Lane:
    algebra = job.ev.algebra
    gap, lead = _ahead(job, path, lane)
    behind, speed = algebra.literal(math.inf), algebra.literal(0.0)
    for other in others(job.ev, job.actor):
        if other.kind not in NOT_VEHICLES:
            distance = _distance_behind(job, path, other)
            speed = where(distance < behind, state(job.ev, other, State.SPEED), speed)
            behind = where(distance < behind, distance, behind)
    return _Lane(path, gap, lead, behind, speed)


def _ahead(job: Job, path: Term, lane: Term) -> tuple[Term, Term]:
    """Return gap and speed of the actor ahead on a lane's path [m, m/s]; an ending lane ends in a standing actor."""
    gap, lead = lead_on(path, job.actor.index, notice_reach(job.ev))
    ends = all_left_by(network_of(job.ev))
    if min(ends) == math.inf:
        return gap, lead
    pose = current_pose(job.ev, job.actor)
    front = path_project(path, pose.x, pose.y) + 0.5 * size_of(job.actor, "length")
    rest = maximum(looked_up(job.ev, lane, ends, missing=math.inf) - front, 0.0)
    return minimum(gap, rest), where(rest < gap, 0.0, lead)


def _distance_behind(job: Job, path: Term, other: Actor) -> Term:
    """Return the distance from another actor's front to my rear along a lane [m]; infinite if unseen or not behind."""
    ev = job.ev
    here, there = current_pose(ev, job.actor), current_pose(ev, other)
    wide = 0.5 * (size_of(job.actor, "width") + size_of(other, "width"))
    long = 0.5 * (size_of(job.actor, "length") + size_of(other, "length"))
    apart = path_project(path, here.x, here.y) - path_project(path, there.x, there.y)
    in_it = path_distance(path, there.x, there.y) < wide
    is_behind = ev.algebra.all_of((is_present(ev, other), in_it, apart >= 0.0, unhidden(ev, job.actor, other)))
    return where(is_behind, maximum(apart - long, 0.0), math.inf)


def _is_better(job: Job, now: _Lane, then: _Lane) -> Term:
    """Return whether a lane change is safe and worthwhile."""
    speed, pair = job.speed(), _pair(job)
    target = job.target_speed()

    def model(of: Term, gap: Term, lead: Term) -> Term:
        return idm(job, of, maximum(target, of), gap, lead, pair)

    long = size_of(job.actor, "length")
    mine = idm(job, speed, target, then.gap, then.lead, pair) - idm(job, speed, target, now.gap, now.lead, pair)
    forced = model(then.speed, then.behind, speed)
    new = where(then.behind < math.inf, forced - model(then.speed, then.behind + long + then.gap, then.lead), 0.0)
    old_gap = now.behind + long + now.gap
    old = model(now.speed, old_gap, now.lead) - model(now.speed, now.behind, speed)
    others_gain = new + where(now.behind < math.inf, old, 0.0)
    gain = mine + job.number("politeness", POLITENESS) * others_gain
    is_safe = forced > -job.number("safe_deceleration", SAFE_DECELERATION)
    return is_safe & (gain > job.number("advantage", ADVANTAGE))
