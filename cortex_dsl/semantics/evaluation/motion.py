"""Where objects are and how they move, at the moment at which an expression is evaluated."""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.values import Pose
from engine.vocabulary import Op, State


def current_pose(ev: Evaluator, actor: Actor) -> Pose:
    """Where an object is: at the start for the scene, at the moment during the run."""
    if not ev.moment.running:
        check_settled(ev, actor)
        return actor.pose
    x, y, heading = (state(ev, actor, column) for column in (State.X, State.Y, State.HEADING))
    return Pose(x, y, heading)


def check_settled(ev: Evaluator, actor: Actor) -> None:
    """What an object is at the start says nothing about a scenario that starts later."""
    scenario = ev.moment.scenario
    if actor.scenario is not None and actor.scenario is scenario and not ev.moment.later:
        return
    if ev.moment.later or (scenario is not None and not scenario.present):
        started = () if scenario is None or scenario.span is None else (Label(scenario.span, "started here"),)
        raise errors.LATER_PLACE.mistake(ev.algebra.span, name=actor.name, secondary=started)


NORTH = math.pi / 2
"""Heading of the north, counted from the east [rad]."""


def as_written(ev: Evaluator, heading: ir.Expr) -> ir.Expr:
    """A heading as the file counts it: from the north in Scenic's files, from the east in others."""
    return ev.algebra.sub(heading, ev.algebra.literal(NORTH)) if ev.file.from_scenic else heading


def as_meant(ev: Evaluator, written: ir.Expr) -> ir.Expr:
    """A heading that the file gives as a number, from the east."""
    return ev.algebra.add(written, ev.algebra.literal(NORTH)) if ev.file.from_scenic else written


def state(ev: Evaluator, actor: Actor, column: State) -> ir.Expr:
    return ev.algebra.apply(Op.STATE, immediates=(actor.index, int(column)))


def size(actor: Actor, name: str) -> ir.Expr:
    """A number among the properties of an object."""
    value = actor.properties[name]
    assert isinstance(value, ir.Expr)
    return value


def is_present(ev: Evaluator, actor: Actor) -> ir.Expr:
    return state(ev, actor, State.PRESENT)


def others(ev: Evaluator, actor: Actor) -> tuple[Actor, ...]:
    """All objects of the scene but one."""
    return tuple(each for each in ev.run.actors if each is not actor)


def gathered(ev: Evaluator, op: Op, items: Sequence[ir.Expr], empty: float) -> ir.Expr:
    """All items joined by an associative operation, as a tree: long chains of operations are refused."""
    if len(items) < 2:
        return items[0] if items else ev.algebra.literal(empty)
    half = len(items) // 2
    return ev.algebra.apply(op, gathered(ev, op, items[:half], empty), gathered(ev, op, items[half:], empty))


def any_of(ev: Evaluator, items: Sequence[ir.Expr]) -> ir.Expr:
    return gathered(ev, Op.OR, items, 0.0)


def all_of(ev: Evaluator, items: Sequence[ir.Expr]) -> ir.Expr:
    return gathered(ev, Op.AND, items, 1.0)


def chosen(ev: Evaluator, index: ir.Expr, items: Sequence[ir.Expr], first: int = 0) -> ir.Expr:
    """The item of a number that only the run knows, found by halving."""
    if len(items) == 1:
        return items[0]
    half = len(items) // 2
    below = ev.algebra.apply(Op.LT, index, ev.algebra.literal(float(first + half)))
    return ev.algebra.apply(
        Op.SELECT, below, chosen(ev, index, items[:half], first), chosen(ev, index, items[half:], first + half)
    )


def between(ev: Evaluator, one: Pose, other: Pose) -> ir.Expr:
    """Distance of two places [m]."""
    algebra = ev.algebra
    return algebra.apply(Op.HYPOT, algebra.sub(other.x, one.x), algebra.sub(other.y, one.y))


def outline(ev: Evaluator, actor: Actor) -> ir.Expr:
    """Packed x, y, heading, length, width."""
    pose = current_pose(ev, actor)
    return ev.algebra.pack(pose.x, pose.y, pose.heading, size(actor, "length"), size(actor, "width"))


def sees(ev: Evaluator, viewer: Actor, other: Actor) -> ir.Expr:
    """Whether a corner or the centre of the other lies in the viewer's sector."""
    pose = current_pose(ev, viewer)
    sector = (size(viewer, "viewAngle"), size(viewer, "visibleDistance"))
    view = ev.algebra.pack(pose.x, pose.y, pose.heading, *sector)
    return ev.algebra.apply(Op.CAN_SEE, view, outline(ev, other))
