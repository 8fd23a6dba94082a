"""`mutate`: normal noise on the pose of named objects.

`mutate` is below the objects in the file, but a place relative to a mutated object uses the mutated pose. So the
statements of a scope are collected before its objects are made. (Scenic adds the noise after all objects are placed.
Here a pose is the same wherever it is read, so that a concrete copy, which contains it, gives all other objects the
same places.)
"""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.errors.scene import CANNOT_MUTATE, MUTATED_ALIAS
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.random_values import SMALLEST_UNIFORM
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Pose
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Term, maximum, normal_quantile
from cortex_dsl.semantics.quantities.units import PURE
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

POSITION_DEVIATION = 1.0
"""Standard deviation of x and of y at scale 1, as in Scenic [m]."""
HEADING_DEVIATION = math.radians(5.0)
"""Standard deviation of the heading, as in Scenic [rad]."""


def announce(ev: Evaluator, statements: Sequence[nodes.Statement]) -> None:
    """Store the mutations of a scope before its statements run."""
    ev.run.built.mutations[ev.scope_name] = [s for s in statements if isinstance(s, nodes.Mutate)]


def mutated(ev: Evaluator, name: str, node: nodes.New, pose: Pose) -> Pose | None:
    """Return the pose with its noise; None if no statement mutates `name`."""
    statement = _statement(ev, name, node)
    if statement is None:
        return None
    if name:
        ev.run.built.mutated.add((ev.scope_name, name))
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
    """Return the last statement that mutates this object; a statement without names mutates all objects above it."""
    found = None
    for statement in ev.run.built.mutations.get(ev.scope_name, ()):
        everything = not statement.targets and node.span.start < statement.span.start
        if name in statement.targets or (everything and node.class_name not in ("Point", "OrientedPoint")):
            found = statement
    return found


def _scale(ev: Evaluator, node: nodes.Mutate) -> Term:
    if node.amount is None:
        return ev.algebra.literal(1.0)
    domain = Domain("the scale of `mutate`", PURE)
    scale = numbers.adopt(ev, ev.evaluate(node.amount), PURE, node.amount.span, domain.name)
    return in_range(ev, scale, domain, node.amount.span)


def _noisy(ev: Evaluator, number: Term, scale: Term, deviation: float) -> Term:
    positive = maximum(ev.run.new_draw(), SMALLEST_UNIFORM)
    noise = deviation * normal_quantile(positive)
    return number + scale * noise


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
        ev.run.decisions.draw_sites.append(ir.DrawSite(site, f"pose{suffix}", "", (*point, *heading)))
        return
    ev.run.decisions.draw_sites.append(ir.DrawSite(site, f"point{suffix}", "", point))
    ev.run.decisions.draw_sites.append(ir.DrawSite(facings[0].span, "heading", "", heading))


def mutate(ev: Evaluator, node: nodes.Mutate) -> None:
    """The statement itself: its objects must have been made under these names."""
    for name in node.targets:
        value = ev.lookup(name, node.span)
        if not isinstance(value, Actor | Pose):
            cure = did_you_mean(name, [name for name, value in ev.scope.items() if isinstance(value, Actor | Pose)])
            raise CANNOT_MUTATE.mistake(node.span, name=name, actual=kind_name(value), cure=cure)
        if (ev.scope_name, name) not in ev.run.built.mutated:
            raise MUTATED_ALIAS.mistake(node.span, name=name)
