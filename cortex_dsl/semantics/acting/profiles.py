"""Library behaviours with a given course of speed, as that of the platforms that carry targets on test tracks.

The pedals of each step give the speed that the course has at its end. Within the limits of the actor, the speed in each
sample is that of the course. The place differs by at most a dt^2 / 8 where the acceleration a changes inside a step.
"""

from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.quantities.algebra import Term, maximum, minimum

INSTANT = 1e-9
"""Shortest time in which a deceleration builds up [s]."""

Course = Callable[[Term, Term], Term]
"""Speed [m/s] from the speed at the beginning [m/s] and the time since then [s]."""


def accelerate_then_keep(job: Job) -> ir.Block:
    """Change the speed at a constant rate over a distance, then keep it.

    The change lasts as long as the distance does at the mean of both speeds.
    """
    speed, distance = job.number("speed"), job.number("distance")

    def course(first: Term, time: Term) -> Term:
        share = minimum(1.0, time * (speed + first) / (2.0 * distance))
        return first + (speed - first) * share

    return _driven(job, course)


def brake_to(job: Job) -> ir.Block:
    """Brake by a deceleration that builds up linearly, down to a speed, then keep this speed."""
    end, rise = job.number("end_speed", 0.0), job.number("rise", 0.0)

    def course(first: Term, time: Term) -> Term:
        building = minimum(time, rise)
        lasted = building * building / (2.0 * maximum(rise, INSTANT)) + (time - building)
        return minimum(first, maximum(end, first - job.number("deceleration") * lasted))

    return _driven(job, course)


def _driven(job: Job, course: Course) -> ir.Block:
    """Return acts that give an actor the speed of a course, which begins after `delay`."""
    step, algebra = job.ev.file.settings.time_step, job.ev.algebra
    keep_speed, first = job.kept(job.speed())
    keep_time, begun = job.kept(algebra.time() + job.number("delay", 0.0))
    wanted = course(first, maximum(0.0, algebra.time() + step - begun))
    drive = ir.Take(job.call.span, job.pedals((wanted - job.speed()) / step))
    return (keep_speed, keep_time, job.forever(drive))
