"""Units converted by hand: a quantity that has a unit, times or over the factor between two units of its dimension."""

import math
from collections.abc import Iterable, Iterator
from itertools import permutations

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.ir import Dimension
from cortex_dsl.semantics.errors.values import CONVERTED_TWICE
from cortex_dsl.semantics.model.values import Quantity
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import PURE, UNITS, Unit, dimension_name
from cortex_dsl.syntax import nodes

NEAR = 1e-3
"""Relative error of the digits that people write of a factor, such as 0.278 of 1/3.6."""


def converted_twice(operator: str, left: Quantity, right: Quantity, node: nodes.Binary) -> Iterator[Diagnostic]:
    """A warning for a product or quotient like `V * 3.6` or `a * pi / 180`, where `V` and `a` have their units."""
    written, factor = node.left, closed_value(right.expr)
    quantity, bare = left, right
    if operator == "*" and left.dimension in (None, PURE):
        written, factor = node.right, closed_value(left.expr)
        quantity, bare = right, left
    if bare.dimension is not None or quantity.dimension in (None, PURE) or not factor:
        return
    factor = 1.0 / factor if operator == "/" else factor
    for start, end in _conversions(quantity.dimension, {factor, factor * _factor(written)}):
        yield CONVERTED_TWICE.at(node.span, kind=dimension_name(quantity.dimension), start=start.word, end=end.word)
        return


def _conversions(dimension: Dimension, factors: Iterable[float]) -> Iterator[tuple[Unit, Unit]]:
    """Yield the pairs of units between which one of the factors converts; whole ratios also have other uses."""
    units = [unit for unit in UNITS.values() if unit.dimension == dimension]
    for start, end in permutations(units, 2):
        ratio = start.factor / end.factor
        if any(math.isclose(each, round(each)) for each in (ratio, 1.0 / ratio)):
            continue
        if any(math.isclose(factor, ratio, rel_tol=NEAR) for factor in factors):
            yield start, end


def _factor(node: nodes.Expression) -> float:
    """The product of the bare constants that a product or quotient is written with."""
    match node:
        case nodes.Binary(operator="*", left=left, right=right):
            return _factor(left) * _factor(right)
        case nodes.Binary(operator="/", left=left, right=right):
            return _factor(left) / (_factor(right) or 1.0)
        case nodes.Number(value=value, unit=None):
            return value
        case nodes.Name(id="pi"):
            return math.pi
    return 1.0
