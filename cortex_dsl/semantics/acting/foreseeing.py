"""Prediction of conflicts by drivers of the library: where ways cross, when both are there, and whether braking helps.

The search for the area of conflict and the times are in `engine.kernels.crossing`; this module makes them terms. A
driver decides: can it stop before the area; if not, does it arrive after the other actor has left, or leave before the
other actor arrives?
"""

import math
from dataclasses import fields, replace

from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES
from cortex_dsl.semantics.evaluation.geometry import size_of, state
from cortex_dsl.semantics.evaluation.seeing import notice_reach
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import Term, maximum, minimum, sqrt, where
from engine.frozen import frozen
from engine.vocabulary import SAME_WAY, State

LINE = 1.0
"""Distance before the area at which a driver comes to rest [m]; *ours*."""
LEAST_LINE = 0.2
"""Distance to the line below which no stop is tried [m]."""
OUTSIDE = 0.01
"""Least distance from the area of an actor outside it [m]."""
GAP = 0.7
"""Time between the exit of one actor from the area and the entry of the other [s]; *ours*, about a reaction time."""
SHORTEST_GAP = 0.3
"""Least lead over an actor that can no longer stop and leaves the area first [s]; *ours*."""
MERGING_GAP = 1.5
"""Least lead over another actor at a merge into a common way [s]; *ours*: a short time gap."""
THEIRS = 3.0
"""Assumed acceleration of other vehicles: full throttle of a car here [m/s^2]."""
THROTTLE, BRAKES = 0.9, 0.9
"""Assumed shares of the actor's own engine and brakes."""
LATE = 0.05
"""Delay until brakes act: the next step [s]."""
SLACK = 0.01
"""Added to the distances beyond which an area does not matter, for rounding [m]."""
STANDING = 0.1
"""Speed below which an actor stands [m/s]."""


@frozen
class Sight:
    """How far [m], in which sector [rad], and with which delay [s] a driver sees."""

    reach: Term
    angle: Term
    latency: Term

    @staticmethod
    def of(job: Job) -> "Sight":
        """Return the sight that the weather permits, all around and without delay, unless the call gives a value."""
        reach = minimum(notice_reach(job.ev), job.number("range", math.inf))
        return Sight(reach, job.number("field_of_view", math.tau), job.number("latency", 0.0))


@frozen
class Extent:
    """Distance beyond which an area of conflict changes no decision of a driver [m].

    Most of the cost of a prediction is the search for the area along both ways.
    """

    near: Term | float = math.inf
    oncoming: Term | float = math.inf
    """The same for an actor that comes towards the driver; the greater of both is taken."""

    def unless(self, needed: Term) -> "Extent":
        """Return an extent without limits while a condition holds."""
        return Extent(where(needed, math.inf, self.near), where(needed, math.inf, self.oncoming))

    def farther(self, by: Term) -> "Extent":
        """Return an extent that is larger by a distance [m]."""
        return Extent(self.near + by, self.oncoming + by)


EVERYWHERE = Extent()


@frozen
class Conflict:
    """Predicted conflict with another actor: `engine.kernels.crossing.Crossing`, as terms."""

    enter: Term
    leave: Term
    arrives: Term
    clears: Term
    their_enter: Term
    their_leave: Term
    earliest: Term
    their_arrival: Term
    their_clearing: Term
    along: Term
    back: Term

    @property
    def exists(self) -> Term:
        """Return whether the ways meet and the other actor is seen."""
        return self.enter < math.inf

    def nearer(self, by: Term) -> "Conflict":
        """Return the conflict of an actor whose outline reaches farther than its way says, by this distance [m]."""
        return replace(self, enter=where(self.enter > 0.0, maximum(self.enter - by, OUTSIDE), self.enter))

    @property
    def parts(self) -> Term:
        """Return whether my way leaves the other way again: the ways cross and do not merge."""
        return self.leave < math.inf

    @property
    def is_ahead(self) -> Term:
        """Return whether the other actor is on my way already, in my direction."""
        return (self.their_enter <= 0.0) & (self.along > SAME_WAY)

    @property
    def is_behind(self) -> Term:
        """Return whether the other actor follows me, on a way that both share from here on."""
        return (self.enter <= 0.0) & (self.along > SAME_WAY) & (self.their_enter > 0.0)

    @property
    def comes(self) -> Term:
        """Return whether the other actor comes towards me on my way."""
        return (self.their_enter <= 0.0) & (self.along < -SAME_WAY)

    @property
    def crosses(self) -> Term:
        """Return whether there is an area of two ways that cross or join."""
        return self.exists & ~(self.is_ahead | self.is_behind | self.comes)

    def coincides(self, by: float) -> Term:
        """Return whether both are in the area together; at a merge, shortly after each other at present speeds."""
        crossing = (self.arrives < self.their_clearing + by) & (self.their_arrival < self.clears + by)
        return where(self.parts, crossing, abs(self.arrives - self.their_arrival) < MERGING_GAP)


def foreseen(
    job: Job,
    path: Term | float,
    other: Actor,
    sight: Sight,
    target: Term,
    acceleration: Term,
    extent: Extent = EVERYWHERE,
) -> Conflict:
    """Return the conflict with another actor of a driver along a path (-1: its own way), up to a target speed.

    An area beyond the extent may be reported as none.
    """
    algebra = job.ev.algebra
    mine, near, oncoming = (
        each if isinstance(each, Term) else algebra.literal(each) for each in (path, extent.near, extent.oncoming)
    )
    seen = (sight.reach, sight.angle, sight.latency)
    plan = (target, acceleration, _theirs(job, other))
    look = algebra.pack(mine, *seen, *plan, near, maximum(near, oncoming))
    return Conflict(*algebra.crossing(job.actor.index, other.index, look, len(fields(Conflict))))


def _theirs(job: Job, other: Actor) -> Term:
    """Return the assumed acceleration of the other actor [m/s^2]; 0 for a pedestrian.

    If both stand and wait for each other, the actor that is first in the file goes.
    """
    algebra = job.ev.algebra
    if other.kind in NOT_VEHICLES:
        return algebra.literal(0.0)
    if other.index < job.actor.index:
        return algebra.literal(THEIRS)
    return where(state(job.ev, other, State.SPEED) < STANDING, 0.0, algebra.literal(THEIRS))


def braking(job: Job) -> Term:
    """Deceleration that is reckoned with [m/s^2]."""
    return BRAKES * size_of(job.actor, "maxBraking")


def throttle(job: Job) -> Term:
    """Acceleration that is reckoned with [m/s^2]."""
    return THROTTLE * size_of(job.actor, "maxAcceleration")


def stopping_distance(job: Job) -> Term:
    """Return the stopping distance [m] under full braking from now on."""
    speed = job.speed()
    late = LATE + 0.5 * size_of(job.actor, "pedalTime")
    return speed * late + speed * speed / (2.0 * braking(job))


def can_stop(job: Job, conflict: Conflict) -> Term:
    """Return whether full braking ends before the area."""
    return stopping_distance(job) + LEAST_LINE < conflict.enter


def braking_helps(job: Job, conflict: Conflict, lost: Term | None = None) -> Term:
    """Return whether to brake if the actor can no longer stop before the area.

    It brakes if it then arrives after the other actor has left, or if neither that nor leaving before its arrival is
    possible. At a merge no actor leaves the area: braking helps unless the actor is long enough before the other, which
    then gains a time `lost` [s] (None: ignored). Inside the area it brakes only for an actor that is inside too.
    """
    speed, hard = job.speed(), braking(job)
    # The actor stops within its stopping distance, so beyond it the square root is of a negative number.
    slowed = speed * speed - 2.0 * hard * minimum(conflict.enter, 1000.0)
    late = (speed - sqrt(maximum(slowed, 0.0))) / hard
    outside = conflict.enter > 0.0
    passes_behind = outside & ((slowed <= 0.0) | (late > conflict.their_clearing))
    passes_before = is_out_before(conflict, lost)
    return passes_behind | (~passes_before & (outside | (conflict.their_enter <= 0.0)))


def is_out_before(conflict: Conflict, lost: Term | None = None) -> Term:
    """Return whether the actor leaves the area before the other arrives; at a merge, with the margin `lost` [s]."""
    over = conflict.clears
    if lost is not None:
        over = where(conflict.parts, over, conflict.arrives + (SHORTEST_GAP + lost))
    return over < conflict.their_arrival
