"""`mutate`: normal noise on the pose of what is made under a name.

The statement stands below the objects, but what is placed relative to a mutated object sees the mutated pose. So the
statements of a scope are known before its objects are made. (Scenic adds the noise when all has been placed. Here a
pose is the same wherever it is read, so that a concrete copy, which writes it down, places all others where they were.)
"""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.quantities import numbers
from cortex_dsl.semantics.quantities.units import PURE
from cortex_dsl.semantics.values import Pose, Value
from cortex_dsl.semantics.wording import kind_name
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.vocabulary import Op

POSITION_DEVIATION = 1.0
"""Standard deviation of x and of y at scale 1, as in Scenic [m]."""
HEADING_DEVIATION = math.radians(5.0)
"""Of the heading, as in Scenic [rad]."""
SMALLEST_UNIFORM = 2.0**-54
"""Stands in for a uniform number of exactly 0, whose normal quantile would be infinite."""


def announce(ev: Evaluator, statements: Sequence[nodes.Statement]) -> None:
    """Remember what a scope will mutate, before its statements run."""
    ev.run.mutations[id(ev.scope)] = [s for s in statements if isinstance(s, nodes.Mutate)]


def mutated(ev: Evaluator, name: str, node: nodes.New, pose: Pose) -> Pose | None:
    """The pose with its noise; None where nothing mutates what is called `name`."""
    statement = _statement(ev, name, node)
    if statement is None:
        return None
    if name:
        ev.run.mutated.add((id(ev.scope), name))
    scale = _scale(ev, statement)
    x, y, heading = (
        _noisy(ev, number, scale, deviation)
        for number, deviation in (
            (pose.x, POSITION_DEVIATION),
            (pose.y, POSITION_DEVIATION),
            (pose.heading, HEADING_DEVIATION),
        )
    )
    return Pose(x, y, heading)


def _statement(ev: Evaluator, name: str, node: nodes.New) -> nodes.Mutate | None:
    """The last one that means this object; without names it means all objects above it."""
    found = None
    for statement in ev.run.mutations.get(id(ev.scope), ()):
        everything = not statement.targets and node.span.start < statement.span.start
        if name in statement.targets or (everything and node.class_name not in ("Point", "OrientedPoint")):
            found = statement
    return found


def _scale(ev: Evaluator, node: nodes.Mutate) -> ir.Expr:
    if node.amount is None:
        return ev.algebra.literal(1.0)
    scale = numbers.adopt(ev, ev.evaluate(node.amount), PURE, node.amount.span, "the scale of `mutate`")
    return numbers.in_range(ev, scale, 0.0, math.inf, PURE, node.amount.span, "the scale of `mutate`")


def _noisy(ev: Evaluator, number: ir.Expr, scale: ir.Expr, deviation: float) -> ir.Expr:
    algebra = ev.algebra
    positive = algebra.apply(Op.MAX, ev.run.new_draw(), algebra.literal(SMALLEST_UNIFORM))
    noise = algebra.mul(algebra.literal(deviation), algebra.apply(Op.NORMAL_QUANTILE, positive))
    return algebra.add(number, algebra.mul(scale, noise))


def record(
    ev: Evaluator,
    node: nodes.New,
    places: Sequence[nodes.Specifier],
    facings: Sequence[nodes.Facing],
    pose: Pose,
) -> None:
    """Note down the mutated pose where a concrete copy will say it."""
    point, heading = (pose.x, pose.y), (pose.heading,)
    site = places[0].span if places else node.class_span
    suffix = "" if places else " added"
    if not facings:
        ev.run.draw_sites.append(ir.DrawSite(site, f"pose{suffix}", "", (*point, *heading)))
        return
    ev.run.draw_sites.append(ir.DrawSite(site, f"point{suffix}", "", point))
    ev.run.draw_sites.append(ir.DrawSite(facings[0].span, "heading", "", heading))


def mutate(ev: Evaluator, node: nodes.Mutate) -> None:
    """The statement itself: its objects must have been made under these names."""
    for name in node.targets:
        value = ev.lookup(name, node.span)
        if not isinstance(value, Actor | Pose):
            cure = did_you_mean(name, _objects(ev))
            raise errors.CANNOT_MUTATE.mistake(node.span, name=name, actual=kind_name(value), cure=cure)
        if (id(ev.scope), name) not in ev.run.mutated:
            raise errors.MUTATED_ALIAS.mistake(node.span, name=name)


def _objects(ev: Evaluator) -> list[str]:
    return [name for name, value in ev.scope.items() if isinstance(value, Actor | Pose)]


def is_mutated(ev: Evaluator, value: Value) -> bool:
    """Whether the object of this name carries noise."""
    return any(ev.scope.get(name) is value for scope, name in ev.run.mutated if scope == id(ev.scope))
