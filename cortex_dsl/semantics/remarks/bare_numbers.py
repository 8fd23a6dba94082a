"""A bare number that is added to, or compared with, what the file itself writes in km/h or another unit that is not SI.

`EGO_SPEED + 10` with a param in km/h adds 10 m/s, 36 km/h: right by the rule, and hardly ever meant.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.quantities.units import UNITS, Unit, si_word
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

SUMS = ("+", "-")
THROUGH = ("abs", "min", "max")
"""Functions whose result has the unit of what they are given."""


def bare_numbers(module: nodes.Module, genes: Mapping[str, ir.GeneInfo]) -> Iterator[Diagnostic]:
    for node in everything_in(module):
        for one, other in _pairs(node):
            for bare, partner in ((one, other), (other, one)):
                number = _bare(bare)
                written = next(_units(partner, genes), None)
                if number and written is not None:
                    yield _remark(bare.span, number, *written)


def _pairs(node: nodes.Node) -> Iterator[tuple[nodes.Expression, nodes.Expression]]:
    """What stands on both sides of a sum or comparison."""
    if isinstance(node, nodes.Binary) and node.operator in SUMS:
        yield node.left, node.right
    if isinstance(node, nodes.Compare):
        sides = [node.first, *(side for _, side in node.rest)]
        yield from pairwise(sides)


def _bare(node: nodes.Expression) -> float | None:
    """The number, where nothing but one without a unit is written; 0 is 0 in every unit."""
    if isinstance(node, nodes.Unary) and node.operator in SUMS:
        number = _bare(node.operand)
        return None if number is None else -number if node.operator == "-" else number
    return node.value if isinstance(node, nodes.Number) and node.unit is None else None


def _units(node: nodes.Expression, genes: Mapping[str, ir.GeneInfo]) -> Iterator[tuple[Unit, Span]]:
    """Units other than SI in which the file writes what an expression adds up, each with its place."""
    match node:
        case nodes.Number(unit=str(word)) | nodes.WithUnit(unit=word):
            unit = UNITS.get(word)
        case nodes.Name(id=name) | nodes.Attribute(name=name) if name in genes:
            unit = UNITS.get(genes[name].unit)
        case _:
            unit = None
            for part in _summands(node):
                yield from _units(part, genes)
    if unit is not None and unit.factor != 1.0:
        yield unit, node.span


def _summands(node: nodes.Expression) -> Iterator[nodes.Expression]:
    match node:
        case nodes.Binary(operator=operator, left=left, right=right) if operator in SUMS:
            yield from (left, right)
        case nodes.Unary(operand=operand):
            yield operand
        case nodes.Call(function=nodes.Name(id=name), arguments=arguments) if name in THROUGH:
            yield from (argument.value for argument in arguments)


def _remark(span: Span, value: float, unit: Unit, place: Span) -> Diagnostic:
    return errors.BARE_BESIDE_UNIT.at(
        span,
        secondary=(Label(place, f"in {unit.word}"),),
        value=value,
        si=si_word(unit.dimension),
        unit=unit.word,
        converted=value / unit.factor,
    )
