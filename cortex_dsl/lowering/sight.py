"""Occlusion at the start of a scene: the outlines that `Op.CAN_SEE` reads."""

from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.bounds import operands
from engine.opcodes import Op
from engine.vocabulary import Column

HIDING = (Column.X, Column.Y, Column.HEADING, Column.LENGTH, Column.WIDTH)
"""Columns of an outline that `Op.CAN_SEE` reads, before the flag for whether it hides others."""


def outlines_that_hide(actors: Sequence[ir.Actor]) -> tuple[ir.Expr, ...]:
    """Return all outlines at the start, in the order of the actors; an actor that appears later hides nothing yet."""
    items: list[ir.Expr] = []
    for actor in actors:
        items += [actor.columns[column] for column in HIDING]
        items.append(actor.columns[Column.OCCLUDING] if actor.present else ir.Literal(actor.span, 0.0))
    return tuple(items)


def looks_of_actors(actors: Sequence[ir.Actor]) -> dict[int, int]:
    """Return the number of the first actor that depends on a look, by the look's identity.

    If an object is placed or measured by visibility, only earlier objects hide others, since the object itself does not
    exist yet.
    """
    first: dict[int, int] = {}
    seen: set[int] = set()
    for number, actor in enumerate(actors):
        stack = list(actor.columns)
        while stack:
            if id(part := stack.pop()) in seen:
                continue
            seen.add(id(part))
            if isinstance(part, ir.Apply) and part.op == Op.CAN_SEE:
                first[id(part)] = number
            stack += operands(part)
    return first
