"""The library's driver who gives way: it stops at a line before the area where ways cross, and never in it.

It goes on only where it clears the area before the other can be in it, though that one sped up (gap acceptance; where
two ways become one: where it is there long enough before the other). Else it stops at the line and waits, by a
deceleration of 3 m/s^2 where that is enough. Where it can no longer stop there, it does what keeps the two apart
(`foreseeing`).

Who has left its way, as one that comes into a bend too fast, goes back to it only where nobody is beside it or comes
from behind: the area of conflict, which is searched for along ways, says nothing of that.

Behind others it drives as the Intelligent Driver Model (`following`) with the vehicle's own acceleration and braking.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.following import idm_acceleration, path_to_follow
from cortex_dsl.semantics.acting.foreseeing import (
    GAP,
    LINE,
    MERGING_GAP,
    Conflict,
    Sight,
    braking_helps,
    can_stop,
    foreseen,
    throttle,
)
from cortex_dsl.semantics.acting.job import SPEED_GAIN, STOPPING, Job
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, others, size_of, state
from cortex_dsl.semantics.evaluation.seeing import unhidden
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import Term, maximum, minimum, path_distance, path_project, sqrt, where
from engine.vocabulary import State

JOINING_SPEED = 5.0
"""With which it is taken to turn into another's way [m/s]: that of a bend of 8 m radius."""
STOP_PREVIEW = 0.25
"""How far ahead the plan of a stop is read [s]: the lag of the speed controller."""
HARD = -10.0
"""Target speed of full braking down to standstill [m/s]."""
OFF = 1.25
"""Who is farther from its way has left it [m]; as in `engine.kernels.crossing`."""
RETURN = 3.0
"""Time that the way back takes [s]; *ours*: 10 degrees, which is how followers go back, from a lane's width off it."""
AWAY = 5.0
"""What is added to the speed of who gets out of the way [m/s]."""
BRISK = 3.0
"""Acceleration and deceleration of the model where the call names none [m/s^2]."""


def give_way(job: Job) -> ir.Block:
    """Follow a lane or trajectory, behind whoever is ahead, and stop before areas of conflict until they are free."""
    job.must_steer()
    acts, path = path_to_follow(job)
    sight, target = Sight.of(job), job.target_speed()
    speed = job.speed() + idm_acceleration(job, path, BRISK, BRISK) / SPEED_GAIN
    brakes, goes = [], []
    for other in others(job.ev, job.actor):
        conflict = foreseen(job, path, other, sight, target, throttle(job))
        must, stops = conflict.crosses & ~_goes_before(job, other, conflict), can_stop(job, conflict)
        helps = braking_helps(job, conflict)
        speed = where(must & stops, minimum(speed, _approach(job, conflict.enter - LINE)), speed)
        brakes.append(must & ~stops & helps)
        goes.append(must & ~stops & ~helps)
    speed = where(job.ev.algebra.any_of(goes), job.speed() + AWAY, speed)
    brakes.append(_has_left(job, path) & _is_taken(job, path))
    return (*acts, job.follow(path, where(job.ev.algebra.any_of(brakes), HARD, speed)))


def _goes_before(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Whether it is through before another; where ways join, also fast enough not to be run into: while it gains dv by
    its acceleration a, the other comes nearer by dv^2 / 2 a.
    """
    theirs = maximum(state(job.ev, other, State.SPEED), 1.0)
    slower = maximum(theirs - JOINING_SPEED, 0.0)
    caught_up = slower * slower / (2.0 * throttle(job) * theirs)
    joining = conflict.arrives + (MERGING_GAP + caught_up)
    return where(conflict.parts, conflict.clears + GAP, joining) < conflict.earliest


def _has_left(job: Job, path: Term) -> Term:
    here = current_pose(job.ev, job.actor)
    return path_distance(path, here.x, here.y) > OFF


def _is_taken(job: Job, path: Term) -> Term:
    """Whether another is beside the actor on its way, or will be before the actor is back."""
    here, near = current_pose(job.ev, job.actor), []
    s = path_project(path, here.x, here.y)
    for other in others(job.ev, job.actor):
        there = current_pose(job.ev, other)
        behind = s - path_project(path, there.x, there.y)
        long = 0.5 * (size_of(job.actor, "length") + size_of(other, "length")) + LINE
        wide = 0.5 * (size_of(job.actor, "width") + size_of(other, "width"))
        comes = (behind > -long) & (behind < long + state(job.ev, other, State.SPEED) * RETURN)
        on_it = path_distance(path, there.x, there.y) < wide
        near.append(is_present(job.ev, other) & comes & on_it & unhidden(job.ev, job.actor, other))
    return job.ev.algebra.any_of(near)


def _approach(job: Job, room: Term) -> Term:
    """Speed from which a planned stop ends within so much room [m/s]."""
    left = maximum(room - STOP_PREVIEW * job.speed(), 0.0)
    return sqrt(2.0 * STOPPING * left)
