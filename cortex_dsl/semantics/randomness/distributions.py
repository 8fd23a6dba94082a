"""Random values: continuous ones become arithmetic over uniform draws, finite ones choices or tables.

In a behaviour the uniform numbers come from the scene's behaviour stream, anew at each evaluation.
"""

from collections.abc import Callable, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_arguments, no_names
from cortex_dsl.semantics.evaluation.functions import whole_number
from cortex_dsl.semantics.randomness.draws import (
    Site,
    alike,
    bound_arguments,
    check_deviation,
    check_order,
    plain,
    recorded,
    scaled,
    uniform,
)
from cortex_dsl.semantics.randomness.options import (
    Option,
    check_count,
    choose,
    pick,
    uniform_options,
    weighted_options,
    whole_index,
)
from cortex_dsl.semantics.values import Quantity, Value
from cortex_dsl.semantics.wording import source_text
from cortex_dsl.syntax import nodes
from engine.vocabulary import Op

SMALLEST_UNIFORM = 2.0**-54
"""Stands in for a uniform number of exactly 0, whose normal quantile would be infinite."""

Distribution = Callable[[Evaluator, str, Sequence[Given], Site], Value]


def sample_call(ev: Evaluator, call: nodes.Call, site: Site) -> Value:
    """The value of a distribution call."""
    assert isinstance(call.function, nodes.Name)
    name = call.function.id
    return DISTRIBUTIONS[name](ev, name, evaluate_arguments(ev, call.arguments), site)


def distribution_call(ev: Evaluator, node: nodes.Expression) -> nodes.Call | None:
    """The call behind a distribution, its unit taken off; None for any other expression."""
    if isinstance(node, nodes.WithUnit | nodes.Degrees):
        node = node.value
    match node:
        case nodes.Call(function=nodes.Name(id=name)) if name in DISTRIBUTIONS and not ev.has(name):
            return node
    return None


# -- continuous -------------------------------------------------------------------------------------------------------


def _range(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    arguments = bound_arguments(name, given, site.span)
    (low, high), dimension = alike(ev, arguments, site)
    check_order(name, plain(arguments[0]), plain(arguments[1]), site.span)
    width = ev.algebra.sub(high, low)
    return recorded(ev, site, ev.algebra.add(low, ev.algebra.mul(uniform(ev), width)), dimension)


def _normal(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    arguments = bound_arguments(name, given, site.span)
    (mean, deviation), dimension = alike(ev, arguments, site)
    check_deviation(plain(arguments[1]), arguments[1].span)
    positive = ev.algebra.apply(Op.MAX, uniform(ev), ev.algebra.literal(SMALLEST_UNIFORM))
    quantile = ev.algebra.apply(Op.NORMAL_QUANTILE, positive)
    return recorded(ev, site, ev.algebra.add(mean, ev.algebra.mul(deviation, quantile)), dimension)


def _truncated_normal(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    arguments = bound_arguments(name, given, site.span)
    (mean, deviation, low, high), dimension = alike(ev, arguments, site)
    check_deviation(plain(arguments[1]), arguments[1].span)
    check_order(name, plain(arguments[2]), plain(arguments[3]), site.span)
    algebra = ev.algebra

    def cumulative(bound: ir.Expr) -> ir.Expr:
        return algebra.apply(Op.NORMAL_CDF, algebra.apply(Op.DIV, algebra.sub(bound, mean), deviation))

    least, greatest = cumulative(low), cumulative(high)
    probability = algebra.add(least, algebra.mul(uniform(ev), algebra.sub(greatest, least)))
    free = algebra.add(mean, algebra.mul(deviation, algebra.apply(Op.NORMAL_QUANTILE, probability)))
    return recorded(ev, site, algebra.apply(Op.MIN, algebra.apply(Op.MAX, free, low), high), dimension)


# -- finite -----------------------------------------------------------------------------------------------------------


def _discrete_range(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    low_given, high_given = bound_arguments(name, given, site.span)
    low, high = (whole_number(ev, g.value, g.span, "a bound of a `DiscreteRange`") for g in (low_given, high_given))
    check_order(name, low, high, site.span)
    dimension = None if site.unit is None else site.unit.dimension
    factor = ev.algebra.literal(1.0 if site.unit is None else site.unit.factor)
    if site.span in ev.file.expanded:
        check_count(high - low + 1, site)
        written = (
            Quantity(ev.algebra.mul(ev.algebra.literal(float(n)), factor), dimension) for n in range(low, high + 1)
        )
        return choose(ev, [Option(value, 1.0, source_text(value) or "") for value in written], site)
    index = whole_index(ev, high - low + 1, site)
    number = ev.algebra.mul(ev.algebra.add(ev.algebra.literal(float(low)), index), factor)
    return recorded(ev, site, number, dimension)


def _among(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    return pick(ev, uniform_options(ev, name, given, site), site)


def _weighted(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    return pick(ev, weighted_options(ev, name, given, site), site)


def _fixed(ev: Evaluator, name: str, given: Sequence[Given], site: Site) -> Value:
    no_names(name, given)
    visit = ev.run.visits[site.span]
    ev.run.visits[site.span] += 1
    if visit >= len(given):
        raise errors.FIXED_EXHAUSTED.mistake(site.span, count=visit + 1, given=len(given))
    return given[visit].value if site.unit is None else scaled(ev, given[visit], site.unit)


DISTRIBUTIONS: dict[str, Distribution] = {
    "Range": _range,
    "VerifaiRange": _range,
    "Normal": _normal,
    "TruncatedNormal": _truncated_normal,
    "DiscreteRange": _discrete_range,
    "VerifaiDiscreteRange": _discrete_range,
    "Uniform": _among,
    "VerifaiOptions": _among,
    "Discrete": _weighted,
    "Fixed": _fixed,
}
