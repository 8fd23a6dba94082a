"""The library's emergency brake, and the shared decisions of all braking drivers: for which actors to wait, and how
long.

The emergency brake acts on conflicts of ways, as `foreseeing` predicts them; with `foresees=False` on time to
collision, exact for the outlines, at constant velocities. The default threshold of both is that of UN Regulation 157
(automated lane keeping), paragraph 5.2.5.2, for when a collision with a vehicle that cuts in must be avoided:

    TTC < v_rel / (2 * 6 m/s^2) + 0.35 s

the time that a steady 6 m/s^2 takes away from the relative speed while closing half as fast on average, and 0.35 s
before the brakes act. v_rel is the magnitude of the relative velocity here, which is the same for two actors in one
lane and larger, so earlier, for crossing actors. Braking for an actor ahead on the way lasts until that actor has left
the way or is faster, or until the braking actor stands; it then holds. `min_speed` and `max_speed` are conditions to
begin: a brake that ended above standstill and could not begin again would let its vehicle roll into the obstacle. Other
braking ends if nothing would be hit within 4 s, the time to collision that separates safe from uncomfortable driving
(Hirst and Graham 1997, in Noy, "Ergonomics and Safety of Intelligent Driver Interfaces"). At standstill it also holds
while an actor is close ahead in the lane or intersection.
"""

import math
from collections.abc import Iterable, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.acting.crossings import goes_first
from cortex_dsl.semantics.acting.foreseeing import (
    EVERYWHERE,
    GAP,
    LINE,
    SLACK,
    Conflict,
    Extent,
    Sight,
    braking_helps,
    can_stop,
    foreseen,
    throttle,
)
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.acting.warning_signals import warned_near
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.driving import together
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, others, outline_of, state
from cortex_dsl.semantics.evaluation.seeing import notice_reach, sees
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import Term, box_distance, cos, hypot, maximum, sin, where
from engine.frozen import frozen
from engine.vocabulary import State

REFERENCE_DECELERATION = 6.0
REFERENCE_DELAY = 0.35
CLEAR = 4.0
"""Time to collision above which braking ends [s]."""
MARGIN = 0.3
"""Time between two actors in the area below which they count as being there together [s]; *ours*."""
RESUMED = 5.0
"""Assumed speed of a driver at rest that drives on [m/s]; *ours*."""
STANDSTILL = 0.01
"""[m/s]"""
HOLD_GAP = 3.0
"""Between the outlines, within which a standing actor keeps standing; *ours* [m]."""


def inner_acts(job: Job) -> ir.Block:
    """Return the acts of the argument `behavior`.

    Raises:
        Mistake: the argument is not a behaviour.
    """
    span = job.call.spans["behavior"]
    call = as_behaviour(job.given("behavior"), span)
    if call is None:
        actual = kind_name(job.given("behavior"))
        raise WRONG_KIND.mistake(
            span, what="`behavior`", expected="a behavior", actual=actual, cure="as in `FollowLaneBehavior(10 m/s)`"
        )
    return job.inline(call)


def emergency_brake(job: Job) -> ir.Block:
    """Run another behaviour; brake fully from the start of a close collision until it is over or the actor stands."""
    if job.flag("foresees", default=True):
        return warned_near(job, _brake_for_ways(job))
    on = _on_collision_course(job) | blocked(job)
    brakes = (ir.TryInterrupt(job.call.span, inner_acts(job), ((_collision_is_close(job), (_full_brake(job, on),)),)),)
    return warned_near(job, brakes)


def _brake_for_ways(job: Job) -> ir.Block:
    """Brake for conflicts of ways; speed limits apply to the first braking for an actor, not to later braking."""
    span, any_of, sight, partners = job.call.span, job.ev.algebra.any_of, Sight.of(job), others(job.ev, job.actor)
    numbers = [job.ev.run.new_local() for _ in partners]
    pairs = [(other, _now(job, other, sight, number)) for other, number in zip(partners, numbers, strict=True)]
    close = [_is_close(job, other, conflict) for other, conflict in pairs]
    on_way = [is_present(job.ev, other) & conflict.exists for other, conflict in pairs]
    targets = Targets.of(job, numbers, close, on_way)
    again = any_of([near & acted for near, acted in zip(close, targets.acted, strict=True)])
    begins = moves(job) & (again | (any_of(close) & _works(job)))
    stays = any_of([stays_close(job, each, sight) for each in partners])
    # It brakes on while it would begin to: a handler that ends at once would be entered again, without an action.
    on = begins | stays | targets.block(job, pairs) | blocked(job)
    handlers = (targets.gone, (begins, (*targets.note, ir.Loop(span, on, (*targets.note, _pedal(job))))))
    return (*targets.forget, ir.TryInterrupt(span, inner_acts(job), handlers))


@frozen
class Targets:
    """Actors for which braking has begun and that have been on the way since: a local for each.

    Braking for them lasts to standstill, which is then held: after an earlier end, it may be too late or too slow to
    begin again.
    """

    acted: tuple[Term, ...]
    forget: ir.Block
    """Acts that forget all of them."""
    note: ir.Block
    """Acts that update them."""
    gone: tuple[Term, ir.Block]
    """Condition that one of them has left the way, and its handler."""

    @staticmethod
    def of(job: Job, numbers: Sequence[int], close: Sequence[Term], on_way: Sequence[Term]) -> "Targets":
        """From a local for each, whether it is time to brake for each, and whether each is on the way."""
        algebra, span = job.ev.algebra, job.call.span
        acted = tuple(is_target(job, each) for each in numbers)
        rows = list(zip(numbers, acted, close, on_way, strict=True))
        no, yes = algebra.literal(0.0), algebra.literal(1.0)
        note = tuple(ir.SetLocal(span, each, where(near | (was & on), yes, no)) for each, was, near, on in rows)
        forget = tuple(ir.SetLocal(span, each, no) for each in numbers)
        return Targets(acted, forget, note, (algebra.any_of([was & ~on for _, was, _, on in rows]), note))

    def block(self, job: Job, pairs: Iterable[tuple[Actor, Conflict]]) -> Term:
        """Return whether one of them is ahead on the way and no faster."""
        return job.ev.algebra.any_of(
            [
                acted & _is_before(job, other, conflict)
                for acted, (other, conflict) in zip(self.acted, pairs, strict=True)
            ]
        )


def is_target(job: Job, number: int) -> Term:
    """Return whether an actor with this local is one of the `Targets`."""
    return job.ev.algebra.local(number) > 0.0


def _is_before(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Return whether another actor on the way, ahead or oncoming, moves away no faster than the actor follows."""
    before = is_present(job.ev, other) & conflict.exists & (conflict.is_ahead | conflict.comes)
    return before & (closing_speed(job, other, conflict) > -STANDSTILL)


def _on_collision_course(job: Job) -> Term:
    """Return whether a collision is due soon, and no later than the time at which braking begins."""
    soon = maximum(CLEAR, job.number("threshold")) if job.given("threshold") is not None else CLEAR
    return moves(job) & (job.ev.algebra.time_to_contact(job.actor.index, reach=notice_reach(job.ev)) < soon)


def _collision_is_close(job: Job) -> Term:
    if job.given("threshold") is not None:
        close = job.ev.algebra.time_to_contact(job.actor.index, reach=notice_reach(job.ev)) < job.number("threshold")
    else:
        close = job.ev.algebra.any_of([_within_reference(job, other) for other in others(job.ev, job.actor)])
    return moves(job) & close


def _within_reference(job: Job, other: Actor) -> Term:
    """TTC < v_rel / (2 b) + delay."""
    braking = 2.0 * job.number("reference_deceleration", REFERENCE_DECELERATION)
    threshold = _relative_speed(job, other) / braking + job.number("delay", REFERENCE_DELAY)
    time = job.ev.algebra.time_to_contact(job.actor.index, other.index, notice_reach(job.ev))
    return is_present(job.ev, other) & (time < threshold)


def _works(job: Job) -> Term:
    """Return whether the actor is in the range of speeds in which its brake begins to act."""
    speed = job.speed()
    return (speed >= job.number("min_speed", 0.0)) & (speed <= job.number("max_speed", math.inf))


def _now(job: Job, other: Actor, sight: Sight, number: int) -> Conflict:
    """Return the conflict foreseen at the present motion of the actor; `number` of the local in `Targets`.

    Only targets matter beyond the distances at which `_is_close` may hold.
    """
    extent = _extent(job, other).unless(is_target(job, number))
    return foreseen(job, -1.0, other, sight, job.speed(), job.ev.algebra.literal(0.0), extent)


def _extent(job: Job, other: Actor) -> Extent:
    """Return the greatest distances at which it may be time to brake: those of `_is_close` for the fastest closing."""
    if job.given("latency") is not None:
        return EVERYWHERE  # the speeds of what is foreseen are older than those known here
    speed = abs(job.speed())
    fastest = speed + ground_speed(job, other)
    if job.given("threshold") is not None:
        threshold = job.number("threshold")
        return Extent(speed * threshold + SLACK, fastest * threshold + SLACK)
    braking = 2.0 * job.number("reference_deceleration", REFERENCE_DECELERATION)
    delay = job.number("delay", REFERENCE_DELAY)
    near, oncoming = (each * (each / braking + delay) + (LINE + SLACK) for each in (speed, fastest))
    return Extent(near, oncoming)


def _is_close(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Return whether it is time to brake for another actor.

    At a crossing: while the actor can stop before the area or pass behind. In one lane: by time to collision.
    """
    speed, closing = job.speed(), closing_speed(job, other, conflict)
    braking = 2.0 * job.number("reference_deceleration", REFERENCE_DECELERATION)
    delay = job.number("delay", REFERENCE_DELAY)
    if job.given("threshold") is not None:
        threshold = job.number("threshold")
        last = latest_arrival(job, other, conflict) < threshold
        in_lane = conflict.enter < closing * threshold
    else:
        last = conflict.enter < speed * (speed / braking + delay) + LINE
        # TTC < v_rel / (2 b) + delay
        in_lane = (closing > 0.0) & (conflict.enter < closing * (closing / braking + delay))
    crossing = conflict.crosses & meets(job, other, conflict) & last
    crossing = crossing & (can_stop(job, conflict) | braking_helps(job, conflict))
    following = (conflict.is_ahead | conflict.comes) & in_lane
    return is_present(job.ev, other) & conflict.exists & (crossing | following)


def meets(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Return whether both are in an area together, or the other actor has the right of way on a crossing."""
    coincides, first = conflict.coincides(MARGIN), goes_first(job, other)
    return coincides if first is None else coincides | first


def latest_arrival(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Return the time until both have arrived at an area [s]; that of the actor for a person with the right of way."""
    both, first = maximum(conflict.arrives, conflict.their_arrival), goes_first(job, other)
    return both if first is None else where(first, conflict.arrives, both)


def stays_close(job: Job, other: Actor, sight: Sight) -> Term:
    """Return whether to continue braking, or to wait."""
    conflict = _going_on(job, other, sight)
    inside = conflict.crosses & (conflict.enter <= 0.0) & (conflict.their_enter <= 0.0)
    closes = conflict.enter < closing_speed(job, other, conflict) * CLEAR
    follows = (conflict.is_ahead | conflict.comes) & closes
    return (
        is_present(job.ev, other)
        & conflict.exists
        & (_awaited(job, other, conflict) | ((follows | inside) & moves(job)))
    )


def waits(job: Job, other: Actor, sight: Sight) -> Term:
    """Return whether to wait before an area until another actor has passed."""
    return is_present(job.ev, other) & _awaited(job, other, _going_on(job, other, sight))


def _going_on(job: Job, other: Actor, sight: Sight) -> Conflict:
    """Return the conflict that is foreseen if the actor releases the brake and drives on."""
    return foreseen(job, -1.0, other, sight, maximum(job.speed(), RESUMED), throttle(job))


def _awaited(job: Job, other: Actor, conflict: Conflict) -> Term:
    last, first = where(conflict.parts, conflict.clears, conflict.arrives) + GAP, goes_first(job, other)
    later = last >= conflict.their_arrival
    comes_first = conflict.crosses & (conflict.enter > 0.0) & (later if first is None else later | first)
    return comes_first & (can_stop(job, conflict) | braking_helps(job, conflict))


def closing_speed(job: Job, other: Actor, conflict: Conflict) -> Term:
    """Return the speed at which the gap to another actor on the way shrinks [m/s]."""
    return job.speed() - ground_speed(job, other) * conflict.along


def ground_speed(job: Job, actor: Actor) -> Term:
    """Return the magnitude of the velocity of an actor [m/s], which may slide after an impact."""
    return hypot(*_velocity(job, actor))


def blocked(job: Job) -> Term:
    """Return whether the actor stands close behind another actor."""
    close = job.ev.algebra.any_of([_close_ahead(job, each) for each in others(job.ev, job.actor)])
    return ~moves(job) & close


def _close_ahead(job: Job, other: Actor) -> Term:
    ev = job.ev
    near = box_distance(outline_of(ev, job.actor), outline_of(ev, other)) < HOLD_GAP
    here, there = current_pose(ev, job.actor), current_pose(ev, other)
    return ev.algebra.all_of((is_present(ev, other), near, sees(ev, job.actor, other), together(ev, here, there)))


def moves(job: Job) -> Term:
    return job.speed() > STANDSTILL


def _full_brake(job: Job, while_: Term) -> ir.Act:
    return ir.Loop(job.call.span, while_, (_pedal(job),))


def _pedal(job: Job) -> ir.Act:
    return job.braking(job.number("brake", 1.0))


def _relative_speed(job: Job, other: Actor) -> Term:
    (x, y), (other_x, other_y) = _velocity(job, job.actor), _velocity(job, other)
    return hypot(other_x - x, other_y - y)


def _velocity(job: Job, actor: Actor) -> tuple[Term, Term]:
    """Return the velocity (x, y) of the rear axle [m/s].

    It points along the heading, except for another actor among three or more: an impact can make that actor slide
    sideways.
    """
    if actor is not job.actor and len(others(job.ev, job.actor)) > 1:
        x, y, _ = job.ev.algebra.velocity(actor.index)
        return x, y
    heading, speed = current_pose(job.ev, actor).heading, state(job.ev, actor, State.SPEED)
    return speed * cos(heading), speed * sin(heading)
