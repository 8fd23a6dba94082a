"""Warnings that drivers give, and a person who brakes after one.

A driver warns by a number of its own (`ExternalBehavior`), or while a collision is near (`warning_ttc`). If a file
reads warnings, three locals of the actor hold whether it warns, since when, and the time to collision at that moment.
"""

from collections.abc import Sequence
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.driving import time_since_warning, warning_cells
from cortex_dsl.semantics.evaluation.geometry import size_of
from cortex_dsl.semantics.evaluation.seeing import notice_reach
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.quantities.algebra import Term, maximum, minimum, where
from engine import control
from engine.control import Action, Control, numbers_decided
from engine.vocabulary import Command

WARNING = Action(control.WARNING, "", control.NO_WARNINGS, 1.0)
LONGEST = 60.0
"""Largest time to collision at a warning that is reported [s]; without a collision course it is infinite."""
DECELERATION, REACTION = 4.0, 1.2
"""Brake of a person after a warning [m/s^2, s]: those of the robot in tests of forward collision warnings. Source: Euro
NCAP, Crash Avoidance - Frontal Collisions, Protocol v1.1 (2025).
"""
MOVING = 0.1
"""Speed below which a collision is no reason for a warning [m/s]."""


def warned_by(job: Job, inner: ir.Block, number: int) -> ir.Block:
    """Return acts with the warnings of a controller, whose number says whether it warns."""
    return _noted(job, inner, job.ev.algebra.decided_outside(number) > 0.5)


def warned_near(job: Job, inner: ir.Block) -> ir.Block:
    """Return acts with a warning while the time to collision is below `warning_ttc`; without it, the same acts."""
    if job.given("warning_ttc") is None:
        return inner
    near = _time_to_collision(job) < job.number("warning_ttc")
    return _noted(job, inner, near & (job.speed() > MOVING))


def _time_to_collision(job: Job) -> Term:
    return job.ev.algebra.time_to_contact(job.actor.index, reach=notice_reach(job.ev))


def _noted(job: Job, inner: ir.Block, warns: Term) -> ir.Block:
    """Return acts that keep the locals of the warnings of the actor, if the file reads warnings."""
    ev, span = job.ev, job.call.span
    if not ev.facts.reads_warnings:
        return inner
    cells = warning_cells(ev, job.actor)
    local, literal = ev.algebra.local, ev.algebra.literal
    now, begun = local(cells.now) > 0.0, local(cells.begun) > 0.0
    first = warns & ~begun
    note = (
        ir.SetLocal(span, cells.ttc, where(first, minimum(_time_to_collision(job), LONGEST), local(cells.ttc))),
        ir.SetLocal(span, cells.begun, where(first, ev.algebra.time() + 1.0, local(cells.begun))),
        ir.SetLocal(span, cells.now, where(warns, literal(1.0), literal(0.0))),
    )
    # The handler acts once for each change, so that it is no turn of its own.
    return (ir.TryInterrupt(span, inner, (((warns & ~now) | (now & ~warns), note),)),)


# -- a person who brakes -----------------------------------------------------------------------------------------------


def brake_after_warning(job: Job) -> ir.Block:
    """Run another behaviour; after the first warning, brake at least by a deceleration.

    If that behavior runs an inner behavior, the person drives the inner one: an emergency brake still brakes harder.
    """
    span = job.call.spans["behavior"]
    call = as_behaviour(job.given("behavior"), span)
    if call is None:
        raise WRONG_KIND.mistake(
            span,
            what="`behavior`",
            expected="a behavior",
            actual=kind_name(job.given("behavior")),
            cure="as in `EmergencyBrakeBehavior(FollowLaneBehavior(10 m/s), warning_ttc=2 s)`",
        )
    row = BUILTINS.get(call.name)
    if row is not None and any(each.name == "behavior" for each in row.parameters):
        within = replace(job.call, arguments={**job.call.arguments, "behavior": call.arguments["behavior"]})
        return job.inline(replace(call, arguments={**call.arguments, "behavior": within}))
    inner = job.inline(call)
    pedal = minimum(1.0, job.number("deceleration", DECELERATION) / size_of(job.actor, "maxBraking"))
    commands = ((Command.BRAKE, pedal), (Command.THROTTLE, job.ev.algebra.literal(0.0)))
    if (decided := _decided(job)) is not None:
        throttle, brake, steer = decided
        del throttle
        commands = ((Command.BRAKE, maximum(pedal, brake)), commands[1], (Command.STEER, steer))
    brakes = time_since_warning(job.ev, job.actor) >= job.number("delay", REACTION)
    braking = ir.Loop(job.call.span, job.ev.algebra.truth(True), (ir.Take(job.call.span, commands),))
    return (ir.TryInterrupt(job.call.span, inner, ((brakes, (braking,)),)),)


def _decided(job: Job) -> Sequence[Term] | None:
    """Return throttle, brake and steering angle of the controller of the actor; None without one that has pedals."""
    controls: list[Control] = list(job.ev.file.run.controls.values())
    for number, each in enumerate(controls):
        if each.actor == job.actor.index and each.names[0] == "throttle":
            first = numbers_decided(controls[:number])
            return [job.ev.algebra.decided_outside(first + column) for column in range(3)]
    return None
