"""Finite choices: numbers stay symbolic as long as nobody needs to know them, anything else makes a variant each."""

import math
from collections.abc import Sequence

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.evaluation.arguments import Given, no_names
from cortex_dsl.semantics.problems import Rejection
from cortex_dsl.semantics.quantities import numbers
from cortex_dsl.semantics.quantities.units import dimension_name
from cortex_dsl.semantics.randomness.choices import VARIANT_LIMIT
from cortex_dsl.semantics.randomness.draws import Site, bound_arguments, recorded, scaled, uniform
from cortex_dsl.semantics.values import Quantity, Value, Weights, is_constant
from cortex_dsl.semantics.wording import option_name, source_text
from cortex_dsl.source import Span
from engine.frozen import frozen
from engine.vocabulary import Op


@frozen
class Option:
    """One value of a finite choice."""

    value: Value
    weight: float
    source: str
    """Text that names it again."""


def uniform_options(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> list[Option]:
    no_names(name, given)
    if len(given) == 1 and given[0].node is not None and isinstance(given[0].value, tuple):
        raise errors.LIST_AS_OPTION.mistake(given[0].span, text=shortened(ev, given[0].span))
    return [_option(ev, g.value, g.span, 1.0, site, starred=g.node is None) for g in given]


def weighted_options(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> list[Option]:
    (argument,) = bound_arguments(name, given, site.span)
    if not isinstance(argument.value, Weights):
        raise errors.BAD_WEIGHTS.mistake(argument.span, message="`Discrete` needs a dictionary of weights")
    options = []
    for (value, weight), span in zip(argument.value.entries, argument.value.spans, strict=True):
        number = ev.constant(numbers.quantity(weight, span, "a weight"), span, "a weight")
        if not 0.0 <= number < math.inf:
            raise errors.BAD_WEIGHTS.mistake(span, message=f"a weight is {number:g}")
        options.append(_option(ev, value, span, number, site, starred=False))
    if options and not any(option.weight for option in options):
        raise errors.BAD_WEIGHTS.mistake(argument.span, message="all weights are 0")
    return [option for option in options if option.weight]


def _option(ev: Evaluator, value: Value, span: Span, weight: float, site: Site, *, starred: bool) -> Option:
    if site.unit is not None:
        value = scaled(ev, Given(value, span), site.unit)
    source = source_text(value) or ("" if starred else ev.file.source.slice(span))
    return Option(value, weight, source)


def pick(ev: Evaluator, options: Sequence[Option], site: Site) -> Value:
    """One of the options: numbers stay symbolic as long as nobody needs to know them."""
    if not options:
        raise Rejection(f"`{shortened(ev, site.span)}` has nothing to choose from", site.span)
    if len(options) == 1:
        return options[0].value
    if all(isinstance(option.value, Quantity) for option in options) and site.span not in ev.file.expanded:
        return _numeric(ev, options, site)
    return choose(ev, options, site)


def shortened(ev: Evaluator, span: Span, width: int = 60) -> str:
    text = " ".join(ev.file.source.slice(span).split())
    return text if len(text) <= width else text[: width - 3] + "..."


def option_numbers(options: Sequence[Option], span: Span) -> tuple[list[Quantity], ir.Dimension | None]:
    """Options that are all numbers, and the dimension that they share."""
    values = [option.value for option in options if isinstance(option.value, Quantity)]
    dimension = None
    for value in values:
        if None not in (dimension, value.dimension) and dimension != value.dimension:
            raise errors.MIXED_OPTIONS.mistake(
                span, left=dimension_name(dimension), right=dimension_name(value.dimension)
            )
        dimension = dimension or value.dimension
    return values, dimension


def _numeric(ev: Evaluator, options: Sequence[Option], site: Site) -> Value:
    values, dimension = option_numbers(options, site.span)
    known = [value.expr.value for value in values if isinstance(value.expr, ir.Literal)]
    if len(known) == len(values) and len({option.weight for option in options}) == 1:
        index = whole_index(ev, len(values), site)
        table = ev.algebra.apply(Op.TABLE, index, immediates=(ev.file.pool.offset(known),))
        return recorded(ev, site, table, dimension)
    threshold = _by_threshold(ev, _finite_uniform(ev, site), options)
    return recorded(ev, site, threshold, dimension)


def _by_threshold(ev: Evaluator, number: ir.Expr, options: Sequence[Option]) -> ir.Expr:
    """The option whose share of [0, 1) holds the uniform number."""
    exprs = [option.value.expr for option in options if isinstance(option.value, Quantity)]
    shares = probabilities(options)
    result = exprs[-1]
    for i in range(len(exprs) - 2, -1, -1):
        below = ev.algebra.apply(Op.LT, number, ev.algebra.literal(math.fsum(shares[: i + 1])))
        result = ev.algebra.apply(Op.SELECT, below, exprs[i], result)
    return result


def check_count(count: int, site: Site) -> None:
    """Refuse early what would be more variants than there may be."""
    if count > VARIANT_LIMIT:
        raise errors.TOO_MANY_VARIANTS.mistake(site.span, limit=VARIANT_LIMIT, sizes=f"this one has {count} options")


def probabilities(options: Sequence[Option]) -> tuple[float, ...]:
    total = math.fsum(option.weight for option in options)
    return tuple(option.weight / total for option in options)


def choose(ev: Evaluator, options: Sequence[Option], site: Site, gene: int | None = None) -> Value:
    """One option as a decision of this variant: at random, or as a gene says."""
    if ev.moment.running and ev.moment.repeated:
        raise errors.RANDOM_WHILE_RUNNING.mistake(site.span)
    name = ev.run.assigning or shortened(ev, site.span)
    shares = probabilities(options) if gene is None else (1.0,) * len(options)
    option = options[ev.run.oracle.choose(name, site.span, shares, gene)]
    source = option.source or _name_of(ev, option.value)
    ev.run.choices.append(ir.Choice(name, option_name(option.value), source, site.span))
    return option.value


def _name_of(ev: Evaluator, value: Value) -> str:
    """A module variable that holds the value, for want of a text of its own."""
    return next((name for name, known in ev.names.items() if known is value), "")


def all_constant(options: Sequence[Option]) -> bool:
    return all(is_constant(o.value) or not isinstance(o.value, Quantity) for o in options)


def whole_index(ev: Evaluator, count: int, site: Site) -> ir.Expr:
    """A whole number below `count`, all equally likely."""
    number = _finite_uniform(ev, site)
    return ev.algebra.apply(Op.FLOOR, ev.algebra.mul(number, ev.algebra.literal(float(count))))


def _finite_uniform(ev: Evaluator, site: Site) -> ir.Expr:
    number = uniform(ev)
    if isinstance(number, ir.Draw):
        ev.run.finite_draws[number.index] = site.span
    return number
