"""The library's driver who gives way: it stops at a line before the area where ways cross, and never in it.

It goes on only where it clears the area before the other can be in it, though that one sped up (gap acceptance; where
two ways become one: where it is there long enough before the other). Else it stops at the line and waits, by a
deceleration of 3 m/s^2 where that is enough. Where it can no longer stop there, it does what keeps the two apart
(`foreseeing`).

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
from cortex_dsl.semantics.evaluation.geometry import others, state
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import Term, maximum, minimum, sqrt, where
from engine.vocabulary import State

JOINING_SPEED = 5.0
"""With which it is taken to turn into another's way [m/s]: that of a bend of 8 m radius."""
STOP_PREVIEW = 0.25
"""How far ahead the plan of a stop is read [s]: the lag of the speed controller."""
HARD = -10.0
"""Target speed of full braking down to standstill [m/s]."""
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


def _approach(job: Job, room: Term) -> Term:
    """Speed from which a planned stop ends within so much room [m/s]."""
    left = maximum(room - STOP_PREVIEW * job.speed(), 0.0)
    return sqrt(2.0 * STOPPING * left)
