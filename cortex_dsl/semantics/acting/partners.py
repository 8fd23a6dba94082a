"""Other actors as the models of safe driving see them: on the actor's way, crossing it, or on a neighbouring lane."""

import math
from collections.abc import Callable

from cortex_dsl.semantics.acting.braking import STANDSTILL, closing_speed, meets
from cortex_dsl.semantics.acting.foreseeing import Conflict, Extent, Sight, braking_helps, can_stop, foreseen
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.evaluation.driving import NOT_VEHICLES
from cortex_dsl.semantics.evaluation.geometry import current_pose, is_present, left_of_path, others, size_of, state
from cortex_dsl.semantics.evaluation.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.evaluation.seeing import unhidden
from cortex_dsl.semantics.model.values import Actor, Pose
from cortex_dsl.semantics.quantities.algebra import Term, cos, path_distance, path_pose, path_project, sin, where
from engine.frozen import frozen
from engine.vocabulary import SAME_WAY, State


@frozen
class Seen:
    """Another actor as the models see it."""

    other: Actor
    conflict: Conflict
    in_lane: Term
    """Whether it is on my way already, before me."""
    speed: Term
    """Its speed along my way [m/s]; negative for an oncoming actor."""
    closing: Term
    """Rate at which the gap shrinks [m/s]."""
    crosses: Term
    """Whether both are in an area of crossing ways together, and the actor can react."""
    beside: "Beside | None"
    """Place on a lane next to that of the actor; None for one that is never in a lane."""

    @property
    def gap(self) -> Term:
        """Return the gap to the actor or to the area [m]."""
        return self.conflict.enter


@frozen
class Beside:
    """Another actor relative to my lane."""

    ahead: Term
    """Gap from the front of the actor to its rear along the lane, negative if they overlap [m]."""
    apart: Term
    """Gap between the sides of both outlines, across my lane [m]."""
    along: Term
    """Cosine of its heading against that of my lane."""
    speed: Term
    """Speed along my lane [m/s]."""
    nearing: Term
    """Speed towards me, across my lane [m/s]."""
    deviation: Term
    """Lateral offset from the middle of its lane [m]."""

    @property
    def comes_over(self) -> Term:
        """Return whether an actor drives my way next to me and moves towards me.

        The test is a cone and a least speed, not signs: for motion exactly along or across my lane, a component of the
        velocity is 0 but for rounding. Definition 6 does not cover crossing actors.
        """
        return (self.along > SAME_WAY) & (self.speed > STANDSTILL) & (self.apart > 0.0) & (self.nearing > STANDSTILL)


def seen_by(job: Job, other: Actor, extent: Extent) -> Seen:
    still = job.ev.algebra.literal(0.0)
    conflict = foreseen(job, -1.0, other, Sight.of(job), job.speed(), still, extent)
    present, closing = is_present(job.ev, other), closing_speed(job, other, conflict)
    in_lane = present & conflict.exists & (conflict.is_ahead | conflict.comes)
    crosses = present & conflict.crosses & meets(job, other, conflict) & (conflict.enter > 0.0)
    crosses = crosses & (can_stop(job, conflict) | braking_helps(job, conflict))
    beside = None if other.kind in NOT_VEHICLES else _beside(job, other)
    return Seen(other, conflict, in_lane, job.speed() - closing, closing, crosses, beside)


def _beside(job: Job, other: Actor) -> Beside:
    ev, network = job.ev, network_of(job.ev)
    here, there = current_pose(ev, job.actor), current_pose(ev, other)
    path = _lane_path(job, here, [each.default_route for each in network.lanes])
    s, foot = path_project(path, there.x, there.y), path_project(path, here.x, here.y)
    long = 0.5 * (size_of(job.actor, "length") + size_of(other, "length"))
    wide = 0.5 * (size_of(job.actor, "width") + size_of(other, "width"))
    aside = left_of_path(path, s, there) - left_of_path(path, foot, here)
    _, _, heading = path_pose(path, s)
    speed, turn = state(ev, other, State.SPEED), there.heading - heading
    across, along = speed * sin(turn), cos(turn)
    own = _lane_path(job, there, [each.path for each in network.lanes])
    return Beside(
        ahead=where(unhidden(ev, job.actor, other), s - foot - long, math.inf),
        apart=abs(aside) - wide,
        along=along,
        speed=speed * along,
        nearing=where(aside > 0.0, -across, across),
        deviation=path_distance(own, there.x, there.y),
    )


def _lane_path(job: Job, pose: Pose, paths: list[int]) -> Term:
    lane = index_of(job.ev, lane_at(job.ev, pose))
    assert lane is not None
    return looked_up(job.ev, lane, [float(path) for path in paths], missing=0.0)


def partners_of(job: Job, extent: Callable[[Actor], Extent]) -> list[Seen]:
    """Return the other actors; `extent` of each: how far away an area of conflict with it matters."""
    return [seen_by(job, other, extent(other)) for other in others(job.ev, job.actor)]
