"""Where random numbers come from, and what every distribution does with its numbers."""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.builtins import BUILTINS
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.evaluation.arguments import Given, bind_builtin
from cortex_dsl.semantics.quantities import numbers, operations
from cortex_dsl.semantics.quantities.algebra import closed_value
from cortex_dsl.semantics.quantities.units import Unit, dimension_name, si_word
from cortex_dsl.semantics.values import Quantity
from cortex_dsl.source import Span
from engine.frozen import frozen


@frozen
class Site:
    """A distribution in the source: its place (with the unit behind it) and that unit."""

    span: Span
    unit: Unit | None = None


def bound_arguments(name: str, given: Sequence[Given], span: Span) -> list[Given]:
    row = BUILTINS[name]
    bound = bind_builtin(row, given, span)
    return [bound[parameter.name] for parameter in row.parameters]


def scaled(ev: Evaluator, argument: Given, unit: Unit | None) -> Quantity:
    """A number of a distribution, with the unit behind the call applied."""
    number = numbers.quantity(argument.value, argument.span, "a bound of a distribution")
    if unit is None:
        return number
    if number.dimension is not None:
        raise errors.TWO_UNITS.mistake(argument.span, kind=dimension_name(number.dimension))
    return Quantity(ev.algebra.mul(number.expr, ev.algebra.literal(unit.factor)), unit.dimension)


def alike(ev: Evaluator, arguments: Sequence[Given], site: Site) -> tuple[list[ir.Expr], ir.Dimension | None]:
    """Numbers of one dimension."""
    scaled_numbers = [scaled(ev, argument, site.unit) for argument in arguments]
    dimension = None
    for number in scaled_numbers:
        dimension = operations.common(dimension, number.dimension, site.span, "bounds of one distribution")
    return [number.expr for number in scaled_numbers], dimension


def uniform(ev: Evaluator) -> ir.Expr:
    return ev.algebra.random() if ev.moment.running else ev.run.new_draw()


def recorded(ev: Evaluator, site: Site, expr: ir.Expr, dimension: ir.Dimension | None) -> Quantity:
    """The drawn number, noted down for concrete copies."""
    if not ev.moment.running:
        ev.run.draw_sites.append(ir.DrawSite(site.span, "number", si_word(dimension), (expr,)))
    return Quantity(expr, dimension)


def check_order(name: str, low: float | None, high: float | None, span: Span) -> None:
    """Known bounds must hold more than one value."""
    if low is None or high is None:
        return
    if low > high:
        raise errors.REVERSED_RANGE.mistake(span, name=name, low=f"{low:g}", high=f"{high:g}")
    if low == high:
        raise errors.EMPTY_RANGE.mistake(span, low=f"{low:g}")
    if not math.isfinite(high - low):
        raise errors.NOT_FINITE.mistake(span, reason="its width is more than 1.8e308")


def check_deviation(value: float | None, span: Span) -> None:
    if value is not None and not value > 0.0:
        raise errors.BAD_DEVIATION.mistake(span, actual=f"{value:g}")


def plain(argument: Given) -> float | None:
    """A known number as it was written, for messages about it."""
    return closed_value(argument.value.expr) if isinstance(argument.value, Quantity) else None
