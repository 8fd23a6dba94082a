"""`ExternalBehavior`: an actor with an external controller, which is named when the file is run and never by the file.

At each turn the actor applies the decision of the controller: pedals and steering, or a target speed and an offset from
its path. The behaviour is an ordinary one, so a `try` may give a brake precedence over a policy. It ends at the end of
the path.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.following import path_to_follow
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.acting.warning_signals import WARNING, warned_by
from cortex_dsl.semantics.errors.runs import CONTROLLED_TWICE, NOT_A_DRIVER
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.geometry import current_pose, size_of
from cortex_dsl.semantics.model.values import Quantity
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import TOP_SPEED, WIDEST
from cortex_dsl.semantics.quantities.algebra import Term, path_length, path_project
from cortex_dsl.semantics.quantities.units import ANGLE, TIME
from cortex_dsl.spelling import did_you_mean
from engine.control import Action, Control, numbers_decided
from engine.vocabulary import ActorKind, Command

PEDALS, SPEED = "pedals", "speed"
ARRIVED = 1e-6
"""[m]"""


def drive_from_outside(job: Job) -> ir.Block:
    """Return the acts of an external controller, until the path ends."""
    if job.actor.kind is ActorKind.OBSTACLE:
        raise NOT_A_DRIVER.mistake(job.call.span, behaviour=job.call.name, actual=kind_name(job.actor))
    acts, path = path_to_follow(job)
    by_pedals = _word(job, "actions", PEDALS, (PEDALS, SPEED)) == PEDALS
    actions = _pedals(job) if by_pedals else _speed(job)
    warns = job.ev.facts.reads_warnings
    first = _controlled(job, (*actions, WARNING) if warns else actions)
    driven = (_pedalling if by_pedals else _following)(job, path, first)
    return (*acts, *(warned_by(job, driven, first + len(actions)) if warns else driven))


def _pedalling(job: Job, path: Term, first: int) -> ir.Block:
    commands = (Command.THROTTLE, Command.BRAKE, Command.STEER)
    taken = tuple((command, _decided(job, first + number)) for number, command in enumerate(commands))
    take = ir.Take(job.call.span, (*taken, (Command.REVERSE, job.ev.algebra.truth(False))))
    pose = current_pose(job.ev, job.actor)
    at_end = path_length(path) - path_project(path, pose.x, pose.y) <= ARRIVED
    arriving = ir.Follow(job.call.span, path, job.speed(), job.ev.algebra.literal(float("inf")), job.ev.run.new_local())
    return (job.until((job.forever(take),), at_end), arriving)


def _following(job: Job, path: Term, first: int) -> ir.Block:
    lateral = job.ev.algebra.literal(float("inf"))
    speed, offset = _decided(job, first), _decided(job, first + 1)
    return (ir.Follow(job.call.span, path, speed, lateral, job.ev.run.new_local(), offset),)


def _decided(job: Job, number: int) -> Term:
    return job.ev.algebra.decided_outside(number)


# -- decisions ---------------------------------------------------------------------------------------------------------


def _controlled(job: Job, actions: tuple[Action, ...]) -> int:
    """The number of the first of these actions among all that are decided outside."""
    name = _word(job, "controller", job.actor.name)
    control = Control(name, job.actor.index, actions, _time(job, "every"), _time(job, "delay"))
    span = job.call.spans.get("controller", job.call.span)
    known = job.ev.file.run.controls.setdefault(name, control)
    if known != control:
        raise CONTROLLED_TWICE.mistake(span, name=name)
    before = list(job.ev.file.run.controls).index(name)
    return numbers_decided(list(job.ev.file.run.controls.values())[:before])


def _pedals(job: Job) -> tuple[Action, ...]:
    steer = job.ev.constant(Quantity(size_of(job.actor, "maxSteer"), ANGLE), job.call.span, "`maxSteer`")
    return Action("throttle", "", 0.0, 1.0), Action("brake", "", 0.0, 1.0), Action("steer", "rad", -steer, steer)


def _speed(job: Job) -> tuple[Action, ...]:
    del job
    return Action("target_speed", "m/s", 0.0, TOP_SPEED), Action("offset", "m", -WIDEST, WIDEST)


def _time(job: Job, name: str) -> float:
    span = job.call.spans.get(name, job.call.span)
    return job.ev.constant(Quantity(job.number(name, 0.0), TIME), span, f"`{name}`")


def _word(job: Job, name: str, default: str, words: tuple[str, ...] = ()) -> str:
    """Return a quoted text; if `words` is not empty, one of `words`."""
    value = job.given(name)
    if value is None:
        return default
    if isinstance(value, str) and value and (not words or value in words):
        return value
    expected = " or ".join(f'"{word}"' for word in words) or "a name in quotes"
    actual = f'"{value}"' if isinstance(value, str) else kind_name(value)
    cure = did_you_mean(value, words) if isinstance(value, str) and words else f'as in `{name}="{default}"`'
    raise WRONG_KIND.mistake(job.call.spans[name], what=f"`{name}`", expected=expected, actual=actual, cure=cure)
