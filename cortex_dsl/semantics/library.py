"""The library behaviours as acts of the IR."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.arguments import Given, number_for
from cortex_dsl.semantics.attributes import current_pose
from cortex_dsl.semantics.builtins import BUILTINS
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.roads import network_of
from cortex_dsl.semantics.trajectories import trajectory
from cortex_dsl.semantics.values import Actor, BehaviourCall, BuiltinValue, kind_name
from engine.road.network import Lane
from engine.vocabulary import Command, Op

DEFAULT_SPEED = 10.0
"""Target speed of the library's drivers, as in Scenic [m/s]."""
DEFAULT_LATERAL = 3.0
"""Lateral acceleration that they accept in turns: brisk [m/s^2]."""


@dataclass(frozen=True)
class Job:
    """One library behaviour to be run: its call, the actor, and the evaluator of the moment."""

    ev: Evaluator
    call: BehaviourCall
    actor: Actor
    at_start: bool
    """Whether it begins with the run, so that the actor still is where the scene put it."""

    def number(self, name: str, default: float | None = None) -> ir.Expr:
        if name not in self.call.arguments:
            assert default is not None
            return self.ev.algebra.literal(default)
        assert isinstance(self.call.behaviour, BuiltinValue)
        row = BUILTINS[self.call.behaviour.name]
        parameter = next(p for p in row.parameters if p.name == name)
        return number_for(self.ev, parameter, Given(self.call.arguments[name], self.call.spans[name]))

    def max_lateral(self) -> ir.Expr:
        """`none` switches the planning of speed off."""
        if "max_lateral" in self.call.arguments and self.call.arguments["max_lateral"] is None:
            return self.ev.algebra.literal(math.inf)
        return self.number("max_lateral", DEFAULT_LATERAL)

    def follow(self, path: ir.Expr) -> ir.Act:
        speed = self.number("target_speed", DEFAULT_SPEED)
        return ir.Follow(self.call.span, path, speed, self.max_lateral(), self.ev.run.new_local())

    def forever(self, act: ir.Act) -> ir.Act:
        return ir.Loop(self.call.span, self.ev.algebra.truth(True), (act,))


def acts(job: Job) -> ir.Block:
    """What a library behaviour does."""
    return LIBRARY[job.call.name](job)


def _follow_trajectory(job: Job) -> ir.Block:
    way = trajectory(job.call.arguments["trajectory"], job.call.spans["trajectory"])
    return (job.follow(job.ev.algebra.literal(float(way.path))),)


def _follow_lane(job: Job) -> ir.Block:
    """The lane given, or the lane the actor is on when this begins, and its default continuation."""
    lane = job.call.arguments.get("laneToFollow")
    if lane is None and job.at_start:
        lane = job.actor.pose.lane
    if isinstance(lane, Lane):
        return (job.follow(job.ev.algebra.literal(float(lane.default_route))),)
    if lane is not None:
        raise errors.WRONG_KIND.mistake(
            job.call.spans["laneToFollow"], what="`laneToFollow`", expected="a lane", actual=kind_name(lane), cure=""
        )
    network_of(job.ev)
    pose = job.actor.pose if job.at_start else current_pose(job.ev, job.actor)
    route = job.ev.algebra.apply(Op.LANE_ROUTE, job.ev.algebra.pack(pose.x, pose.y, pose.heading))
    local = job.ev.run.new_local()
    return (ir.SetLocal(job.call.span, local, route), job.follow(job.ev.algebra.local(local)))


def _constant_speed(job: Job) -> ir.Block:
    return (ir.HoldSpeed(job.call.span, job.number("speed")),)


def _brake(job: Job) -> ir.Block:
    return (job.forever(ir.Take(job.call.span, ((Command.BRAKE, job.number("pedal", 1.0)),))),)


def _idle(job: Job) -> ir.Block:
    return (job.forever(ir.Wait(job.call.span)),)


LIBRARY: dict[str, Callable[[Job], ir.Block]] = {
    "FollowTrajectoryBehavior": _follow_trajectory,
    "FollowLaneBehavior": _follow_lane,
    "ConstantSpeedBehavior": _constant_speed,
    "BrakeBehavior": _brake,
    "IdleBehavior": _idle,
}
