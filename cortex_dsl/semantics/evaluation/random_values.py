"""Random values: continuous values are arithmetic over uniform draws, finite values are choices or tables.

Finite choices among numbers stay symbolic until their value is needed; any other finite choice makes a variant for each
option. In a behaviour the uniform numbers come from the scene's behaviour stream, a new number at each evaluation.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import Rejection
from cortex_dsl.semantics.errors.values import (
    BAD_DEVIATION,
    BAD_WEIGHTS,
    EMPTY_RANGE,
    FIXED_EXHAUSTED,
    LIST_AS_OPTION,
    MIXED_OPTIONS,
    NOT_FINITE,
    NOTHING_TO_RESAMPLE,
    RANDOM_WHILE_RUNNING,
    REVERSED_RANGE,
    TURNED_RANGE,
    TWO_UNITS,
)
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given, bind_builtin, evaluate_arguments, no_names, number_for
from cortex_dsl.semantics.evaluation.functions import Meaning, whole_number
from cortex_dsl.semantics.evaluation.ranges import at_most, in_range, require
from cortex_dsl.semantics.model.choices import check_count
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import LaneNow, Quantity, SurfaceNow, Value, Weights, is_constant
from cortex_dsl.semantics.model.wording import kind_name, option_name, source_text
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    floor,
    maximum,
    minimum,
    normal_cdf,
    normal_quantile,
    table,
    where,
)
from cortex_dsl.semantics.quantities.bounds import closed_value, is_dynamic
from cortex_dsl.semantics.quantities.units import PURE, SPEED, Unit, dimension_name, si_word
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.road.network import LISTED_IN, Lane, Surface

# -- arguments as written: their unit, the order of bounds, the permitted deviations


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
    """Return a number of a distribution, with the unit behind the call applied."""
    number = numbers.quantity(argument.value, argument.span, "a bound of a distribution")
    if unit is None:
        return number
    if number.dimension is not None:
        raise TWO_UNITS.mistake(argument.span, kind=dimension_name(number.dimension))
    return Quantity(number.expr * unit.factor, unit.dimension)


def alike(arguments: Sequence[Given], site: Site) -> tuple[list[Term], ir.Dimension | None]:
    """Return the numbers of a distribution, and their common dimension."""
    scaled_numbers = [scaled(argument, site.unit) for argument in arguments]
    dimension = None
    for number in scaled_numbers:
        dimension = numbers.common(dimension, number.dimension, site.span, "bounds of one distribution")
    return [number.expr for number in scaled_numbers], dimension


def check_order(name: str, low: float | None, high: float | None, span: Span) -> None:
    """Check that known bounds contain more than one value."""
    if low is None or high is None:
        return
    if low > high:
        raise REVERSED_RANGE.mistake(span, name=name, low=f"{low:g}", high=f"{high:g}")
    if low == high:
        raise EMPTY_RANGE.mistake(span, low=f"{low:g}")
    if not math.isfinite(high - low):
        raise NOT_FINITE.mistake(span, reason="its width is more than 1.8e308")


def in_order(ev: Evaluator, name: str, bounds: list[Given], span: Span) -> list[Given]:
    """Return the bounds of a `Range` in order: in a file of Scenic, reversed bounds are turned, with a note."""
    low, high = (plain(bound) for bound in bounds[-2:])
    if ev.facts.from_scenic and low is not None and high is not None and low > high and name.endswith("Range"):
        ev.report(TURNED_RANGE.at(span, low=f"{high:g}", high=f"{low:g}"))
        return bounds[::-1]
    return bounds


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


def check_deviation(value: float | None, span: Span) -> None:
    if value is not None and not value > 0.0:
        raise BAD_DEVIATION.mistake(span, actual=f"{value:g}")


def deviation_of(ev: Evaluator, argument: Given, value: Term, dimension: ir.Dimension | None) -> Term:
    """Return a standard deviation, which is above 0 in every scene.

    Raises:
        Mistake: it is not, or may be 0 or less.
    """
    check_deviation(plain(argument), argument.span)
    return in_range(ev, value, Domain("the standard deviation", dimension or PURE, above=True), argument.span)


def plain(argument: Given) -> float | None:
    """Return a known number as it was written, for messages; None for others."""
    return closed_value(argument.value.expr) if isinstance(argument.value, Quantity) else None


# -- values


def uniform(ev: Evaluator) -> Term:
    return ev.algebra.random() if ev.moment.running else ev.run.new_draw()


def recorded(ev: Evaluator, site: Site, expr: Term, dimension: ir.Dimension | None, kind: str = "number") -> Quantity:
    """The drawn number, noted down for concrete copies."""
    if not ev.moment.running:
        word = si_word(dimension) if kind == "number" else name_of_choice(ev, site)
        ev.run.decisions.draw_sites.append(ir.DrawSite(site.span, kind, word, (expr,)))
    return Quantity(expr, dimension)


# -- options -----------------------------------------------------------------------------------------------------------


@frozen
class Option:
    """One value of a finite choice."""

    value: Value
    weight: float
    source: str
    """Text that names it again."""


def uniform_options(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> list[Option]:
    no_names(name, given)
    if len(given) == 1 and given[0].node is not None and isinstance(given[0].value, tuple) and not ev.facts.from_scenic:
        raise LIST_AS_OPTION.mistake(given[0].span, text=shortened(ev, given[0].span))
    return [_option(ev, g.value, g.span, 1.0, site, starred=g.node is None) for g in given]


def weighted_options(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> list[Option]:
    (argument,) = bound_arguments(name, given, site.span)
    if not isinstance(argument.value, Weights):
        raise BAD_WEIGHTS.mistake(argument.span, message="`Discrete` needs a dictionary of weights")
    options = []
    for (value, weight), span in zip(argument.value.entries, argument.value.spans, strict=True):
        number = ev.constant(numbers.quantity(weight, span, "a weight"), span, "a weight")
        if not 0.0 <= number < math.inf:
            raise BAD_WEIGHTS.mistake(span, message=f"a weight is {number:g}")
        options.append(_option(ev, value, span, number, site, starred=False))
    if options and not any(option.weight for option in options):
        raise BAD_WEIGHTS.mistake(argument.span, message="all weights are 0")
    return [option for option in options if option.weight]


def _option(ev: Evaluator, value: Value, span: Span, weight: float, site: Site, *, starred: bool) -> Option:
    if site.unit is not None:
        value = scaled(Given(value, span), site.unit)
    source = source_text(value) or ("" if starred else ev.facts.source.slice(span))
    return Option(value, weight, source)


def pick(ev: Evaluator, options: Sequence[Option], site: Site) -> Value:
    """Return one option; numbers stay symbolic until their value is needed."""
    if not options:
        raise Rejection(f"`{shortened(ev, site.span)}` has nothing to choose from", site.span)
    if len(options) == 1:
        return options[0].value
    if all(isinstance(option.value, Quantity) for option in options) and site.span not in ev.file.choice_plan.expanded:
        return _numeric(ev, options, site)
    if (
        ev.file.choice_plan.draws_lanes
        and _are_lanes(options)
        and not ev.moment.running
        and site.span not in ev.file.choice_plan.expanded
    ):
        return _lane(ev, options, site)
    if _draws_surfaces(ev, options, site):
        return _surface(ev, options, site)
    return choose(ev, options, site)


def _are_lanes(options: Sequence[Option]) -> bool:
    return all(isinstance(option.value, Lane) for option in options)


def _lane(ev: Evaluator, options: Sequence[Option], site: Site) -> LaneNow:
    """The index of a lane, as a number that the scene draws."""
    ids = [(each, each.value.id) for each in options if isinstance(each.value, Lane)]
    numbered = [replace(each, value=Quantity(ev.algebra.literal(float(number)), None)) for each, number in ids]
    index = _numeric(ev, numbered, site, "lane")
    return LaneNow(index.expr, section=False, drawn=frozenset({site.span}))


def _draws_surfaces(ev: Evaluator, options: Sequence[Option], site: Site) -> bool:
    plan = ev.file.choice_plan
    return plan.draws_lanes and not ev.moment.running and site.span not in plan.expanded and _are_surfaces(options)


def _are_surfaces(options: Sequence[Option]) -> bool:
    """Return whether all options are elements of one tuple of the network."""
    listed = {LISTED_IN[each.value.kind] if isinstance(each.value, Surface) else "" for each in options}
    return len(listed) == 1 and "" not in listed


def _surface(ev: Evaluator, options: Sequence[Option], site: Site) -> SurfaceNow:
    """Return one of the elements of a tuple of the network, as a number that the scene draws."""
    meant = [(each, each.value) for each in options if isinstance(each.value, Surface)]
    first = meant[0][1]
    name, among = LISTED_IN[first.kind], first.network.elements_of(LISTED_IN[first.kind])
    numbers_of = {id(each): float(number) for number, each in enumerate(among)}
    numbered = [replace(each, value=Quantity(ev.algebra.literal(numbers_of[id(one)]), None)) for each, one in meant]
    index = _numeric(ev, numbered, site, name)
    chosen = {id(one) for _, one in meant}
    # An element that is no option needs no place in the tables of the program.
    return SurfaceNow(
        tuple(each if id(each) in chosen else first for each in among), index.expr, frozenset({site.span})
    )


def shortened(ev: Evaluator, span: Span, width: int = 60) -> str:
    text = ev.facts.source.words(span)
    return text if len(text) <= width else text[: width - 3] + "..."


def option_numbers(options: Sequence[Option], span: Span) -> tuple[list[Quantity], ir.Dimension | None]:
    """Options that are all numbers, and the dimension that they share."""
    values = [option.value for option in options if isinstance(option.value, Quantity)]
    dimension = None
    for value in values:
        if None not in (dimension, value.dimension) and dimension != value.dimension:
            raise MIXED_OPTIONS.mistake(span, left=dimension_name(dimension), right=dimension_name(value.dimension))
        dimension = dimension or value.dimension
    return values, dimension


def _numeric(ev: Evaluator, options: Sequence[Option], site: Site, kind: str = "number") -> Quantity:
    values, dimension = option_numbers(options, site.span)
    known = [value.expr.value for value in values if isinstance(value.expr, ir.Literal)]
    if len(known) == len(values) and len({option.weight for option in options}) == 1:
        index = whole_index(ev, len(values), site)
        return recorded(ev, site, table(index, ev.file.pool.offset(known)), dimension, kind)
    threshold = _by_threshold(_finite_uniform(ev, site), options)
    return recorded(ev, site, threshold, dimension, kind)


def _by_threshold(number: Term, options: Sequence[Option]) -> Term:
    """Return the option whose share of [0, 1) contains the uniform number."""
    exprs = [option.value.expr for option in options if isinstance(option.value, Quantity)]
    shares = probabilities(options)
    result = exprs[-1]
    for i in range(len(exprs) - 2, -1, -1):
        below = number < math.fsum(shares[: i + 1])
        result = where(below, exprs[i], result)
    return result


def probabilities(options: Sequence[Option]) -> tuple[float, ...]:
    total = math.fsum(option.weight for option in options)
    return tuple(option.weight / total for option in options)


def name_of_choice(ev: Evaluator, site: Site) -> str:
    return ev.run.assigning or shortened(ev, site.span)


def choose(ev: Evaluator, options: Sequence[Option], site: Site, gene: int | None = None) -> Value:
    """One option as a decision of this variant: at random, or as a gene says."""
    if ev.moment.running and ev.moment.repeated:
        raise RANDOM_WHILE_RUNNING.mistake(site.span)
    name = name_of_choice(ev, site)
    shares = probabilities(options) if gene is None else (1.0,) * len(options)
    drawable = gene is None and (_are_lanes(options) or _are_surfaces(options))
    option = options[ev.run.decisions.oracle.choose(name, site.span, shares, gene, drawable=drawable)]
    source = option.source or _name_of(ev, option.value)
    ev.run.decisions.choices.append(ir.Choice(name, option_name(option.value), source, site.span))
    return option.value


def _name_of(ev: Evaluator, value: Value) -> str:
    """A module variable that holds the value, for want of a text of its own."""
    return next((name for name, known in ev.names.items() if known is value), "")


def all_constant(options: Sequence[Option]) -> bool:
    return all(is_constant(o.value) or not isinstance(o.value, Quantity) for o in options)


def whole_index(ev: Evaluator, count: int, site: Site) -> Term:
    """A whole number below `count`, all equally likely."""
    number = _finite_uniform(ev, site)
    return floor(number * float(count))


def _finite_uniform(ev: Evaluator, site: Site) -> Term:
    number = uniform(ev)
    if isinstance(number, ir.Draw):
        ev.run.decisions.finite_draws[number.index] = site.span
    return number


# -- distributions -----------------------------------------------------------------------------------------------------

SMALLEST_UNIFORM = 2.0**-54
"""Replacement for a uniform number of exactly 0, which has an infinite normal quantile."""

Distribution = Callable[[Evaluator, str, Sequence[Given], Site], Value]


def sample_call(ev: Evaluator, call: nodes.Call, site: Site) -> Value:
    """The value of a distribution call."""
    assert isinstance(call.function, nodes.Name)
    name = call.function.id
    return drawn(ev, name, evaluate_arguments(ev, call.arguments), site)


def drawn(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    """Return the value of a distribution; for a number, store the function that draws another, for `resample`."""
    value = DISTRIBUTIONS[name](ev, name, given, site)
    if isinstance(value, Quantity) and not isinstance(value.expr, ir.Literal):
        ev.run.redrawn[value.expr] = lambda at, span: drawn(at, name, given, Site(span, site.unit))
    return value


def _resample(ev: Evaluator, x: Given, span: Span) -> Value:
    again = ev.run.redrawn.get(x.value.expr) if isinstance(x.value, Quantity) else None
    if again is None:
        raise NOTHING_TO_RESAMPLE.mistake(x.span, actual=kind_name(x.value))
    return again(ev, span)


def distribution_call(ev: Evaluator, node: nodes.Expression) -> nodes.Call | None:
    """The call behind a distribution, its unit taken off; None for any other expression."""
    if isinstance(node, nodes.WithUnit | nodes.Degrees):
        node = node.value
    if not isinstance(node, nodes.Call) or not isinstance(node.function, nodes.Name):
        return None
    name = node.function.id
    return node if name in DISTRIBUTIONS and not ev.has(name) else None


# -- continuous -------------------------------------------------------------------------------------------------------


def _range(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    arguments = in_order(ev, name, bound_arguments(name, given, site.span), site.span)
    (low, high), dimension = alike(arguments, site)
    check_order(name, plain(arguments[0]), plain(arguments[1]), site.span)
    if not ev.facts.from_scenic:
        require_order(ev, name, low, high, site.span)
    width = high - low
    return recorded(ev, site, low + uniform(ev) * width, dimension)


def _normal(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    arguments = bound_arguments(name, given, site.span)
    (mean, deviation), dimension = alike(arguments, site)
    deviation = deviation_of(ev, arguments[1], deviation, dimension)
    positive = maximum(uniform(ev), SMALLEST_UNIFORM)
    quantile = normal_quantile(positive)
    return recorded(ev, site, mean + deviation * quantile, dimension)


def _truncated_normal(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    arguments = bound_arguments(name, given, site.span)
    (mean, deviation, low, high), dimension = alike(arguments, site)
    deviation = deviation_of(ev, arguments[1], deviation, dimension)
    check_order(name, plain(arguments[2]), plain(arguments[3]), site.span)
    require_order(ev, name, low, high, site.span)

    def cumulative(bound: Term) -> Term:
        return normal_cdf((bound - mean) / deviation)

    least, greatest = cumulative(low), cumulative(high)
    probability = least + uniform(ev) * (greatest - least)
    free = mean + deviation * normal_quantile(probability)
    return recorded(ev, site, minimum(maximum(free, low), high), dimension)


YOUNGER, OLDER = 1.39, 1.16
"""Mean speeds of persons of up to 60 years, and of older persons, who cross a road [m/s].

Older: Gates, Noyce, Bill and Van Ee (2006), Transportation Research Record 1982, 38-47: mean 3.81 ft/s. Younger: the
15th percentile of 1.15 m/s of Fitzpatrick, Brewer and Turner (2006), the same record, 21-29, whose groups part at 60
years, and the deviation of the older. Children walk at 5 km/h in tests of Euro NCAP, which is `YOUNGER`.
"""
WALKING_DEVIATION = 0.233
"""Standard deviation [m/s]: older persons have a 15th percentile of 0.92 m/s (both sources)."""
WIDEST_DEVIATION = 3.0
"""Number of standard deviations at which speeds are cut off; *ours*: 0.46 to 2.1 m/s."""


def _walking_speed(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    (age,) = bound_arguments(name, given, site.span)
    years = number_for(ev, BUILTINS[name].parameters[0], age)
    return recorded(ev, site, walking_speed(ev, years), SPEED)


def walking_speed(ev: Evaluator, years: Term) -> Term:
    """Return a drawn walking speed [m/s] of a person of an age in years."""
    least, greatest = (normal_cdf(ev.algebra.literal(end)) for end in (-WIDEST_DEVIATION, WIDEST_DEVIATION))
    quantile = normal_quantile(least + uniform(ev) * (greatest - least))
    mean = where(years > 60.0, OLDER, YOUNGER)
    limited = minimum(maximum(quantile, -WIDEST_DEVIATION), WIDEST_DEVIATION)
    return mean + WALKING_DEVIATION * limited


# -- finite -----------------------------------------------------------------------------------------------------------


def _discrete_range(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    low_given, high_given = bound_arguments(name, given, site.span)
    low, high = (whole_number(ev, g.value, g.span, "a bound of a `DiscreteRange`") for g in (low_given, high_given))
    check_order(name, low, high, site.span)
    dimension = None if site.unit is None else site.unit.dimension
    factor = ev.algebra.literal(1.0 if site.unit is None else site.unit.factor)
    if site.span in ev.file.choice_plan.expanded:
        check_count(high - low + 1, site.span)
        written = (Quantity(float(n) * factor, dimension) for n in range(low, high + 1))
        return choose(ev, [Option(value, 1.0, source_text(value) or "") for value in written], site)
    index = whole_index(ev, high - low + 1, site)
    number = (float(low) + index) * factor
    return recorded(ev, site, number, dimension)


def _among(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    return pick(ev, uniform_options(ev, name, given, site), site)


def _weighted(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    return pick(ev, weighted_options(ev, name, given, site), site)


def _fixed(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    no_names(name, given)
    visit = ev.run.decisions.visits[site.span]
    ev.run.decisions.visits[site.span] += 1
    if visit >= len(given):
        raise FIXED_EXHAUSTED.mistake(site.span, count=visit + 1, given=len(given))
    return given[visit].value if site.unit is None else scaled(given[visit], site.unit)


DISTRIBUTIONS: dict[str, Distribution] = {
    "Range": _range,
    "VerifaiRange": _range,
    "Normal": _normal,
    "TruncatedNormal": _truncated_normal,
    "WalkingSpeed": _walking_speed,
    "DiscreteRange": _discrete_range,
    "VerifaiDiscreteRange": _discrete_range,
    "Uniform": _among,
    "VerifaiOptions": _among,
    "Discrete": _weighted,
    "Fixed": _fixed,
}

MEANINGS: Mapping[str, Meaning] = {"resample": _resample}
