"""Arguments of distributions as written: their unit, the order of bounds, and the permitted deviations."""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.errors.values import (
    BAD_DEVIATION,
    EMPTY_RANGE,
    NOT_FINITE,
    REVERSED_RANGE,
    TURNED_RANGE,
    TWO_UNITS,
)
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given, bind_builtin
from cortex_dsl.semantics.evaluation.ranges import at_most, in_range, require
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Quantity
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.bounds import closed_value, is_dynamic
from cortex_dsl.semantics.quantities.units import PURE, Unit, dimension_name
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


def scaled(argument: Given, unit: Unit | None) -> Quantity:
    """A number of a distribution, with the unit behind the call applied."""
    number = numbers.quantity(argument.value, argument.span, "a bound of a distribution")
    if unit is None:
        return number
    if number.dimension is not None:
        raise TWO_UNITS.mistake(argument.span, kind=dimension_name(number.dimension))
    return Quantity(number.expr * unit.factor, unit.dimension)


def alike(arguments: Sequence[Given], site: Site) -> tuple[list[Term], ir.Dimension | None]:
    """Numbers of one dimension."""
    scaled_numbers = [scaled(argument, site.unit) for argument in arguments]
    dimension = None
    for number in scaled_numbers:
        dimension = numbers.common(dimension, number.dimension, site.span, "bounds of one distribution")
    return [number.expr for number in scaled_numbers], dimension


def check_order(name: str, low: float | None, high: float | None, span: Span) -> None:
    """Known bounds must hold more than one value."""
    if low is None or high is None:
        return
    if low > high:
        raise REVERSED_RANGE.mistake(span, name=name, low=f"{low:g}", high=f"{high:g}")
    if low == high:
        raise EMPTY_RANGE.mistake(span, low=f"{low:g}")
    if not math.isfinite(high - low):
        raise NOT_FINITE.mistake(span, reason="its width is more than 1.8e308")


def require_order(ev: Evaluator, name: str, low: Term, high: Term, span: Span) -> None:
    """Require of the scene that drawn bounds are in order, unless they certainly are.

    Raises:
        Mistake: they never are.
    """
    least, greatest = ev.interval(high - low)
    if greatest < 0.0:
        ends = ev.interval(low)[0], ev.interval(high)[1]
        raise REVERSED_RANGE.mistake(span, name=name, low=f"{ends[0]:g}", high=f"{ends[1]:g}")
    if least < 0.0 and not (is_dynamic(low) or is_dynamic(high)):
        require(ev, at_most(low, high), f"bounds of `{name}` in order", span)


def in_order(ev: Evaluator, name: str, bounds: list[Given], span: Span) -> list[Given]:
    """Bounds of a `Range`; a reversed one means the same in Scenic's files, which is said."""
    low, high = (plain(bound) for bound in bounds[-2:])
    if ev.facts.from_scenic and low is not None and high is not None and low > high and name.endswith("Range"):
        ev.report(TURNED_RANGE.at(span, low=f"{high:g}", high=f"{low:g}"))
        return bounds[::-1]
    return bounds


def check_deviation(value: float | None, span: Span) -> None:
    if value is not None and not value > 0.0:
        raise BAD_DEVIATION.mistake(span, actual=f"{value:g}")


def deviation(ev: Evaluator, argument: Given, value: Term, dimension: ir.Dimension | None) -> Term:
    """Return a standard deviation, which is above 0 in every scene.

    Raises:
        Mistake: it is not, or may be 0 or less.
    """
    check_deviation(plain(argument), argument.span)
    return in_range(ev, value, Domain("the standard deviation", dimension or PURE, above=True), argument.span)


def plain(argument: Given) -> float | None:
    """A known number as it was written, for messages about it."""
    return closed_value(argument.value.expr) if isinstance(argument.value, Quantity) else None
