"""Braking for a collision that is close, whatever else is being done.

The reference emergency brake acts on time to collision: exact for the outlines, at constant velocities. Its default
threshold is that of UN Regulation 157 (automated lane keeping), paragraph 5.2.5.2, for when a collision with a vehicle
that cuts in must be avoided:

    TTC < v_rel / (2 * 6 m/s^2) + 0.35 s

the time that a steady 6 m/s^2 takes away from the relative speed while closing half as fast on average, and 0.35 s
before the brakes act. v_rel is the magnitude of the relative velocity here, which is the same for two in one lane and
larger, so earlier, for those who cross.

Once it brakes it goes on until the actor stands or is off its collision course: nothing would be hit within 4 s, the
time to collision that parts safe from uncomfortable driving (Hirst and Graham 1997, in Noy, "Ergonomics and Safety of
Intelligent Driver Interfaces"). At standstill it holds while somebody is close ahead in the lane or intersection.
"""

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.acting.library.following import follow_lane
from cortex_dsl.semantics.acting.library.job import Job
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.motion import (
    all_of,
    any_of,
    current_pose,
    is_present,
    others,
    outline,
    sees,
    state,
)
from cortex_dsl.semantics.evaluation.nearby import NOT_VEHICLES, closest, together
from cortex_dsl.semantics.wording import kind_name
from engine.vocabulary import Command, Op, State

REFERENCE_DECELERATION = 6.0
REFERENCE_DELAY = 0.35
AVOIDANCE_THRESHOLD = 10.0
AVOIDING_SPEED = 25.0
"""Defaults of Scenic's `DriveAvoidingCollisions` [m, m/s]."""
CLEAR = 4.0
"""Time to collision above which braking ends [s]."""
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
        raise errors.WRONG_KIND.mistake(
            span, what="`behavior`", expected="a behavior", actual=actual, cure="as in `FollowLaneBehavior(10 m/s)`"
        )
    close = _collision_is_close(job)
    on = job.ev.algebra.apply(Op.OR, _on_collision_course(job), _blocked(job))
    return (ir.TryInterrupt(job.call.span, job.inline(call), ((close, (_full_brake(job, on),)),)),)


def _on_collision_course(job: Job) -> ir.Expr:
    algebra = job.ev.algebra
    least = algebra.apply(Op.TTC, immediates=(job.actor.index, -1))
    return algebra.apply(Op.AND, _moves(job), algebra.apply(Op.LT, least, algebra.literal(CLEAR)))


def _blocked(job: Job) -> ir.Expr:
    """Whether the actor stands close behind somebody."""
    algebra = job.ev.algebra
    stands = algebra.apply(Op.NOT, _moves(job))
    return algebra.apply(
        Op.AND, stands, any_of(job.ev, [_close_ahead(job, each) for each in others(job.ev, job.actor)])
    )


def _close_ahead(job: Job, other: Actor) -> ir.Expr:
    ev, algebra = job.ev, job.ev.algebra
    gap = algebra.apply(Op.BOX_DISTANCE, outline(ev, job.actor), outline(ev, other))
    near = algebra.apply(Op.LT, gap, algebra.literal(HOLD_GAP))
    here, there = current_pose(ev, job.actor), current_pose(ev, other)
    return all_of(ev, (is_present(ev, other), near, sees(ev, job.actor, other), together(ev, here, there)))


def _moves(job: Job) -> ir.Expr:
    return job.ev.algebra.apply(Op.LT, job.ev.algebra.literal(STANDSTILL), job.speed())


def _full_brake(job: Job, while_: ir.Expr) -> ir.Act:
    pedal = job.number("brake", 1.0)
    return ir.Loop(job.call.span, while_, (ir.Take(job.call.span, ((Command.BRAKE, pedal),)),))


def _collision_is_close(job: Job) -> ir.Expr:
    algebra = job.ev.algebra
    if job.given("threshold") is not None:
        least = algebra.apply(Op.TTC, immediates=(job.actor.index, -1))
        close = algebra.apply(Op.LT, least, job.number("threshold"))
    else:
        close = any_of(job.ev, [_within_reference(job, other) for other in others(job.ev, job.actor)])
    return algebra.apply(Op.AND, _moves(job), close)


def _within_reference(job: Job, other: Actor) -> ir.Expr:
    algebra = job.ev.algebra
    braking = algebra.mul(algebra.literal(2.0), job.number("reference_deceleration", REFERENCE_DECELERATION))
    needed = algebra.apply(Op.DIV, _relative_speed(job, other), braking)
    threshold = algebra.add(needed, job.number("delay", REFERENCE_DELAY))
    time = algebra.apply(Op.TTC, immediates=(job.actor.index, other.index))
    return algebra.apply(Op.AND, is_present(job.ev, other), algebra.apply(Op.LT, time, threshold))


def _relative_speed(job: Job, other: Actor) -> ir.Expr:
    (x, y), (other_x, other_y) = _velocity(job, job.actor), _velocity(job, other)
    algebra = job.ev.algebra
    return algebra.apply(Op.HYPOT, algebra.sub(other_x, x), algebra.sub(other_y, y))


def _velocity(job: Job, actor: Actor) -> tuple[ir.Expr, ir.Expr]:
    algebra, heading, speed = job.ev.algebra, current_pose(job.ev, actor).heading, state(job.ev, actor, State.SPEED)
    return algebra.mul(speed, algebra.apply(Op.COS, heading)), algebra.mul(speed, algebra.apply(Op.SIN, heading))


def drive_avoiding(job: Job) -> ir.Block:
    """Follow the lane; full brakes while another vehicle is near."""
    algebra = job.ev.algebra
    vehicles = [each for each in others(job.ev, job.actor) if each.kind not in NOT_VEHICLES]
    near = algebra.apply(
        Op.LE, closest(job.ev, job.actor, vehicles), job.number("avoidance_threshold", AVOIDANCE_THRESHOLD)
    )
    brake = ir.Take(job.call.span, ((Command.BRAKE, algebra.literal(1.0)),))
    return (ir.TryInterrupt(job.call.span, follow_lane(job), ((near, (brake,)),)),)
