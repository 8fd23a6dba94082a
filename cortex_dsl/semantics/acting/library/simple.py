"""Behaviours that look at nothing."""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.library.job import Job
from engine.vocabulary import Command


def constant_speed(job: Job) -> ir.Block:
    return (ir.HoldSpeed(job.call.span, job.number("speed")),)


def constant_throttle(job: Job) -> ir.Block:
    return (job.forever(ir.Take(job.call.span, ((Command.THROTTLE, job.number("x")),))),)


def brake(job: Job) -> ir.Block:
    return (job.forever(ir.Take(job.call.span, ((Command.BRAKE, job.number("pedal", 1.0)),))),)


def idle(job: Job) -> ir.Block:
    return (job.forever(ir.Wait(job.call.span)),)
