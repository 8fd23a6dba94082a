"""Conditions on the others during the run: who is near, in the same lane, on a collision course.

Names and meaning are those of Scenic's driving domain: distances are from centre to centre.
"""

import math

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.builtins import BUILTINS
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.evaluation.arguments import Given, number_for
from cortex_dsl.semantics.evaluation.motion import (
    all_of,
    any_of,
    between,
    current_pose,
    gathered,
    is_present,
    others,
    sees,
    size,
)
from cortex_dsl.semantics.quantities.units import LENGTH, TIME
from cortex_dsl.semantics.road.lanes import index_of, lane_at, looked_up
from cortex_dsl.semantics.road.roads import network_of
from cortex_dsl.semantics.things.classes import ACTOR_KINDS
from cortex_dsl.semantics.values import BuiltinValue, Pose, Quantity, Truth, Value
from cortex_dsl.semantics.wording import kind_name
from cortex_dsl.source import Span
from engine.vocabulary import ActorKind, Op

NOT_VEHICLES = frozenset({ActorKind.PEDESTRIAN, ActorKind.OBSTACLE})


def actor_of(argument: Given, what: str) -> Actor:
    if isinstance(argument.value, Actor):
        return argument.value
    actual = kind_name(argument.value)
    raise errors.WRONG_KIND.mistake(argument.span, what=what, expected="an object", actual=actual, cure="write `self`")


def while_running(ev: Evaluator, span: Span, name: str) -> None:
    if not ev.moment.running:
        raise errors.ONLY_WHILE_RUNNING.mistake(span, what=f"`{name}`")


def _near(ev: Evaluator, one: Pose, other: Pose, limit: ir.Expr) -> ir.Expr:
    return ev.algebra.apply(Op.LT, between(ev, one, other), limit)


def _limit(ev: Evaluator, name: str, distance: Given) -> ir.Expr:
    return number_for(ev, BUILTINS[name].parameters[1], distance)


def any_cars(ev: Evaluator, car: Given, distance: Given, span: Span) -> Value:
    """Whether another vehicle, seen or not, is near."""
    while_running(ev, span, "withinDistanceToAnyCars")
    actor, limit = actor_of(car, "`car`"), _limit(ev, "withinDistanceToAnyCars", distance)
    here = current_pose(ev, actor)
    return Truth(
        any_of(
            ev,
            [
                all_of(ev, (is_present(ev, each), _near(ev, here, current_pose(ev, each), limit)))
                for each in others(ev, actor)
                if each.kind not in NOT_VEHICLES
            ],
        )
    )


def any_pedestrians(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    """Whether a person that the vehicle sees is near its front."""
    while_running(ev, span, "withinDistanceToAnyPedestrians")
    actor, limit = actor_of(vehicle, "`vehicle`"), _limit(ev, "withinDistanceToAnyPedestrians", distance)
    front = _front(ev, actor)
    return Truth(
        any_of(
            ev,
            [
                all_of(
                    ev, (is_present(ev, each), _near(ev, front, current_pose(ev, each), limit), sees(ev, actor, each))
                )
                for each in others(ev, actor)
                if each.kind is ActorKind.PEDESTRIAN
            ],
        )
    )


def _front(ev: Evaluator, actor: Actor) -> Pose:
    """The middle of the front of the outline."""
    algebra, pose = ev.algebra, current_pose(ev, actor)
    half = algebra.mul(size(actor, "length"), algebra.literal(0.5))
    x = algebra.add(pose.x, algebra.mul(half, algebra.apply(Op.COS, pose.heading)))
    y = algebra.add(pose.y, algebra.mul(half, algebra.apply(Op.SIN, pose.heading)))
    return Pose(x, y, pose.heading)


def objects_in_lane(ev: Evaluator, vehicle: Given, distance: Given, span: Span) -> Value:
    """Whether the vehicle sees another that is near and in the same lane, or in the same intersection."""
    while_running(ev, span, "withinDistanceToObjsInLane")
    actor, limit = actor_of(vehicle, "`vehicle`"), _limit(ev, "withinDistanceToObjsInLane", distance)
    here = current_pose(ev, actor)
    return Truth(any_of(ev, [_in_lane(ev, actor, here, each, limit) for each in others(ev, actor)]))


def _in_lane(ev: Evaluator, actor: Actor, here: Pose, other: Actor, limit: ir.Expr) -> ir.Expr:
    there = current_pose(ev, other)
    near = _near(ev, here, there, limit)
    return all_of(ev, (is_present(ev, other), near, sees(ev, actor, other), together(ev, here, there)))


def together(ev: Evaluator, here: Pose, there: Pose) -> ir.Expr:
    """Whether two places lie in one intersection, or in one lane outside of it."""
    network, algebra = network_of(ev), ev.algebra
    lane = index_of(ev, lane_at(ev, here))
    assert lane is not None
    areas = [
        float(each.region if each.intersection is None or each.maneuvers else each.intersection.region)
        for each in network.lanes
    ]
    region = looked_up(ev, lane, areas, missing=0.0)
    return algebra.apply(Op.REGION_CONTAINS, region, there.x, there.y)


def distance_to_closest(ev: Evaluator, actor: Actor, kind: Value, span: Span) -> Value:
    """Distance to the nearest other object of a class; infinite without one."""
    if not isinstance(kind, BuiltinValue) or kind.name not in ACTOR_KINDS:
        raise errors.WRONG_KIND.mistake(
            span, what="`distanceToClosest`", expected="a class", actual=kind_name(kind), cure="as in `Car`"
        )
    while_running(ev, span, "distanceToClosest")
    wanted = ACTOR_KINDS[kind.name]
    return Quantity(closest(ev, actor, [each for each in others(ev, actor) if each.kind is wanted]), LENGTH)


def closest(ev: Evaluator, actor: Actor, candidates: list[Actor]) -> ir.Expr:
    """Least distance to one of several objects that take part [m]; infinite without one."""
    algebra, here, far = ev.algebra, current_pose(ev, actor), ev.algebra.literal(math.inf)
    distances = [
        algebra.apply(Op.SELECT, is_present(ev, each), between(ev, here, current_pose(ev, each)), far)
        for each in candidates
    ]
    return gathered(ev, Op.MIN, distances, math.inf)


def time_to_collision(ev: Evaluator, first: Given, second: Given | None, span: Span) -> Value:
    """Time until two outlines touch if both keep their velocities; of one alone, the least over all others."""
    while_running(ev, span, "timeToCollision")
    actor = actor_of(first, "`object`")
    other = -1 if second is None or second.value is None else actor_of(second, "`other`").index
    return Quantity(ev.algebra.apply(Op.TTC, immediates=(actor.index, other)), TIME)
