"""People on foot, and whoever crosses another's way."""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.library.job import Job
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.motion import between, current_pose, state
from cortex_dsl.semantics.evaluation.nearby import actor_of
from engine.vocabulary import Command, Op, State

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
    algebra, least = job.ev.algebra, job.number("min_speed", CROSSING_SPEED)
    last = least if job.given("final_speed") is None else job.number("final_speed")
    apart = between(job.ev, current_pose(job.ev, job.actor), current_pose(job.ev, other))
    ahead, across = _seen_from(job, other)
    ratio = algebra.apply(Op.DIV, state(job.ev, other, State.SPEED), ahead)
    speed = algebra.apply(Op.MAX, least, algebra.mul(algebra.apply(Op.ABS, across), ratio))
    far = algebra.apply(Op.LT, job.number("threshold", CROSSING_THRESHOLD), apart)
    coming = algebra.apply(Op.LT, algebra.literal(0.0), ahead)
    return (
        ir.Loop(job.call.span, far, (ir.Wait(job.call.span),)),
        ir.Loop(job.call.span, coming, (ir.Take(job.call.span, ((Command.SPEED, speed),)),)),
        job.forever(ir.Take(job.call.span, ((Command.SPEED, last),))),
    )


def _seen_from(job: Job, other: Actor) -> tuple[ir.Expr, ir.Expr]:
    """How far ahead of the other, and to its left, the actor is [m]."""
    algebra, here, there = job.ev.algebra, current_pose(job.ev, job.actor), current_pose(job.ev, other)
    dx, dy = algebra.sub(here.x, there.x), algebra.sub(here.y, there.y)
    cos, sin = algebra.apply(Op.COS, there.heading), algebra.apply(Op.SIN, there.heading)
    ahead = algebra.add(algebra.mul(dx, cos), algebra.mul(dy, sin))
    return ahead, algebra.sub(algebra.mul(dy, cos), algebra.mul(dx, sin))
