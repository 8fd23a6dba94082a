"""`record`: values of the running simulation that are kept, each as a column of numbers."""

from collections.abc import Iterator

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.definitions import Actor
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH, PURE, dimension_name
from cortex_dsl.semantics.values import Pose, Quantity, Truth, Value, Vector
from cortex_dsl.semantics.wording import kind_name
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.vocabulary import RuleKind

Column = tuple[str, ir.Expr, ir.Dimension]
"""What follows the record's name, the number, and its dimension."""


def record(ev: Evaluator, node: nodes.Record) -> None:
    """A record, at a running moment."""
    name = node.name or " ".join((node.when + " " + ev.file.source.slice(node.value.span)).split())
    for i, (suffix, value, dimension) in enumerate(_columns(ev.evaluate(node.value), node.value.span)):
        # Rules are known by their places: each column of one value gets a place of its own.
        place = Span(node.value.span.start, node.value.span.start + i)
        watch = ev.file.rule(place, name + suffix, RuleKind.WATCH)
        ev.run.rule_conditions[place, RuleKind.WATCH] = value
        made = ir.Record(name + suffix, node.when or "series", watch, dimension, ev.file.line(node.span))
        _keep(ev, node, made)


def _keep(ev: Evaluator, node: nodes.Record, made: ir.Record) -> None:
    """The same column in all variants, and no other of its name.

    Raises:
        Mistake: where there is another.
    """
    first, known = ev.file.records.setdefault(made.name, (node.span, made))
    if known.watch != made.watch:
        where = (Label(first, "first here"),)
        raise errors.DUPLICATE.mistake(node.span, secondary=where, what="the record", name=made.name)
    if known.dimension != made.dimension:
        here, there = dimension_name(known.dimension), dimension_name(made.dimension)
        raise errors.RECORD_VARIES.mistake(node.value.span, here=here, there=there)


def _columns(value: Value, span: Span) -> Iterator[Column]:
    match value:
        case Quantity(expr, dimension):
            yield "", expr, dimension or PURE
        case Truth(expr):
            yield "", expr, PURE
        case Vector(x, y):
            yield from ((".x", x, LENGTH), (".y", y, LENGTH))
        case Pose(x, y, heading):
            yield from ((".x", x, LENGTH), (".y", y, LENGTH), (".heading", heading, ANGLE))
        case Actor():
            cure = "record one of its numbers: `.position`, `.speed`, `.heading`"
            raise errors.UNRECORDABLE.mistake(span, actual=kind_name(value), cure=cure)
        case tuple():
            raise errors.UNRECORDABLE.mistake(span, actual="a list", cure="write one `record` for each item")
        case _:
            raise errors.UNRECORDABLE.mistake(span, actual=kind_name(value), cure="record a number that it decides")
