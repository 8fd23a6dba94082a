"""`param`: which values a search chooses, which are drawn for each scene, and which are constants."""

import math
from collections.abc import Sequence
from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import OVERRIDE_OUTSIDE
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.values import (
    GENE_BOUNDS,
    GENE_VARIES,
    NOT_CONSTANT,
    NUISANCE_PARAM,
    UNKNOWN_UNIT,
    WRONG_KIND,
)
from cortex_dsl.semantics.evaluation import numbers, random_values
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_arguments
from cortex_dsl.semantics.evaluation.functions import whole_number
from cortex_dsl.semantics.evaluation.random_values import Option, Site
from cortex_dsl.semantics.model.choices import check_count
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Quantity, Value
from cortex_dsl.semantics.model.wording import option_name
from cortex_dsl.semantics.names.tree import unit_word
from cortex_dsl.semantics.quantities.algebra import table
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import UNITS, Unit, si_word
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.frozen import frozen
from engine.vocabulary import Distribution, GeneKind


def param_value(ev: Evaluator, entry: nodes.ParamEntry) -> Value:
    """The value of one `NAME = value` of a `param` statement."""
    if entry.name in ev.facts.overrides:
        try:
            return _overridden(ev, entry, ev.facts.overrides[entry.name])
        except Mistake as mistake:
            raise _from_command_line(mistake, entry.name) from None
    call = random_values.distribution_call(ev, entry.value)
    if call is None:
        return ev.evaluate(entry.value)
    assert isinstance(call.function, nodes.Name)
    name = call.function.id
    if name in ("Normal", "Fixed"):
        if name == "Normal":
            reason = "a normal distribution has no bounds for a search"
            ev.report(NUISANCE_PARAM.at(entry.value.span, name=entry.name, reason=reason))
        return ev.evaluate(entry.value)
    given = evaluate_arguments(ev, call.arguments)
    request = _Request(ev, entry.name, name, given, Site(entry.value.span, unit_behind(entry.value)))
    if name in ("Uniform", "VerifaiOptions", "Discrete"):
        return request.index_gene()
    if name in ("DiscreteRange", "VerifaiDiscreteRange"):
        return request.integer_gene()
    return request.continuous_gene()


def unit_behind(node: nodes.Expression) -> Unit | None:
    """The unit after a distribution call."""
    match node:
        case nodes.WithUnit(unit=word):
            if word not in UNITS:
                raise UNKNOWN_UNIT.mistake(node.span, unit=word, suggestion=did_you_mean(word, UNITS))
            return UNITS[word]
        case nodes.Degrees():
            return UNITS["deg"]
    return None


@frozen
class _Request:
    """A distribution that a `param` names, on its way to becoming a gene."""

    ev: Evaluator
    param: str
    distribution: str
    given: Sequence[Given]
    site: Site

    def continuous_gene(self) -> Value:
        arguments = random_values.bound_arguments(self.distribution, self.given, self.site.span)
        arguments = random_values.in_order(self.ev, self.distribution, arguments, self.site.span)
        unit, values = self._written(arguments)
        low, high = values[-2:]
        random_values.check_order(self.distribution, low, high, self.site.span)
        truncated = self.distribution == "TruncatedNormal"
        if truncated:
            random_values.check_deviation(values[1], arguments[1].span)
        gene = self._info(
            GeneKind.CONTINUOUS, unit, low, high, Distribution.TRUNCATED_NORMAL if truncated else Distribution.UNIFORM
        )
        if truncated:
            gene = replace(gene, mean=values[0], deviation=values[1])
        return self._value(gene, unit)

    def integer_gene(self) -> Value:
        arguments = random_values.bound_arguments(self.distribution, self.given, self.site.span)
        low, high = (whole_number(self.ev, g.value, g.span, "a bound of a `DiscreteRange`") for g in arguments)
        random_values.check_order(self.distribution, low, high, self.site.span)
        unit = "" if self.site.unit is None else self.site.unit.word
        gene = self._info(GeneKind.INTEGER, unit, float(low), float(high), Distribution.UNIFORM)
        if self.site.span not in self.ev.file.choice_plan.expanded:
            return self._value(gene, unit)
        check_count(high - low + 1, self.site.span)
        dimension = None if self.site.unit is None else self.site.unit.dimension
        options = [
            Option(Quantity(self.ev.algebra.literal(n * gene.scale), dimension), 1.0, f"{n} {unit}".rstrip())
            for n in range(low, high + 1)
        ]
        return random_values.choose(self.ev, options, self.site, self._register(gene))

    def index_gene(self) -> Value:
        find = random_values.weighted_options if self.distribution == "Discrete" else random_values.uniform_options
        options = find(self.ev, self.distribution, self.given, self.site)
        if not random_values.all_constant(options):
            raise GENE_BOUNDS.mistake(self.site.span, name=self.param)
        if len(options) < 2:
            return random_values.pick(self.ev, options, self.site)
        weighted = len({option.weight for option in options}) > 1
        gene = replace(
            self._info(
                GeneKind.INDEX, "", 0.0, len(options) - 1.0, Distribution.DISCRETE if weighted else Distribution.UNIFORM
            ),
            options=tuple(option.source for option in options),
            weights=random_values.probabilities(options) if weighted else (),
        )
        index = self._register(gene)
        numeric = all(isinstance(option.value, Quantity) for option in options)
        if not numeric or self.site.span in self.ev.file.choice_plan.expanded:
            return random_values.choose(self.ev, options, self.site, index)
        values, dimension = random_values.option_numbers(options, self.site.span)
        known = [value.expr.value for value in values if isinstance(value.expr, ir.Literal)]
        offset = self.ev.file.pool.offset(known)
        return Quantity(table(self.ev.algebra.gene(index), offset), dimension)

    def _info(self, kind: GeneKind, unit: str, low: float, high: float, distribution: Distribution) -> ir.GeneInfo:
        return ir.GeneInfo(
            name=self.param,
            unit=unit,
            scale=UNITS[unit].factor if unit else 1.0,
            kind=kind,
            low=low,
            high=high,
            distribution=distribution,
            mean=0.0,
            deviation=0.0,
            options=(),
            weights=(),
            span=self.site.span,
        )

    def _value(self, gene: ir.GeneInfo, unit: str) -> Value:
        index = self._register(gene)
        return Quantity(self.ev.algebra.gene(index), UNITS[unit].dimension if unit else None)

    def _register(self, gene: ir.GeneInfo) -> int:
        number = self.ev.file.genes.number(gene)
        if number is None:
            raise GENE_VARIES.mistake(self.site.span, name=self.param)
        return number

    def _written(self, arguments: Sequence[Given]) -> tuple[str, list[float]]:
        """The unit of the file for this gene, and the numbers in it."""
        exprs = [random_values.scaled(argument, self.site.unit) for argument in arguments]
        dimension = None
        for number in exprs:
            dimension = numbers.common(dimension, number.dimension, self.site.span, "bounds of one distribution")
        known = [closed_value(numbers.quantity(argument.value, argument.span).expr) for argument in arguments]
        values = [value for value in known if value is not None and math.isfinite(value)]
        if len(values) < len(arguments):
            raise GENE_BOUNDS.mistake(self.site.span, name=self.param)
        if self.site.unit is not None:
            return self.site.unit.word, values
        literals = [_literal(argument.node) for argument in arguments]
        words = {word for _, word in literals}
        if len(words) == 1 and (word := words.pop()):
            return word, [value for value, _ in literals]
        if dimension is None:
            return "", values
        return si_word(dimension), values


def _literal(node: nodes.Expression | None) -> tuple[float, str | None]:
    """Value and unit word of a literal, with its sign."""
    match node:
        case nodes.Number(value=value, unit=unit):
            return value, unit
        case nodes.Unary(operator="-", operand=nodes.Number(value=value, unit=unit)):
            return -value, unit
    return 0.0, None


# -- `-p NAME=VALUE` --------------------------------------------------------------------------------------------------


def _overridden(ev: Evaluator, entry: nodes.ParamEntry, node: nodes.Expression) -> Value:
    """The constant of the command line; a bare number has the unit that the file gives the param."""
    options = _option_names(ev, entry)
    if options is not None:
        return _overriding_option(ev, entry, node, options)
    value = ev.evaluate(node)
    if isinstance(value, Quantity) and closed_value(value.expr) is None:
        raise NOT_CONSTANT.mistake(entry.value.span, purpose=f"`-p {entry.name}`")
    unit = UNITS.get(unit_word(entry.value) or "")
    if isinstance(value, Quantity) and unit is not None:
        if value.dimension is None:
            value = Quantity(value.expr * unit.factor, unit.dimension)
        else:
            numbers.adopt(ev, value, unit.dimension, entry.value.span, f"`-p {entry.name}`")
    if isinstance(value, Quantity):
        _warn_if_outside(ev, entry, value)
    return value


BOUNDED = ("Range", "VerifaiRange", "TruncatedNormal", "DiscreteRange", "VerifaiDiscreteRange")
"""Distributions with bounds as their last two arguments."""


def _warn_if_outside(ev: Evaluator, entry: nodes.ParamEntry, value: Quantity) -> None:
    """A constant of the command line that the file could never draw."""
    call = random_values.distribution_call(ev, entry.value)
    if call is None or not isinstance(call.function, nodes.Name) or call.function.id not in BOUNDED:
        return
    arguments = random_values.bound_arguments(
        call.function.id, evaluate_arguments(ev, call.arguments), entry.value.span
    )
    low, high = (
        closed_value(random_values.scaled(argument, unit_behind(entry.value)).expr) for argument in arguments[-2:]
    )
    known = closed_value(value.expr)
    if low is None or high is None or known is None:
        return
    slack = numbers.ROUNDING * max(abs(low), abs(high))
    if not low - slack <= known <= high + slack:
        word = unit_word(entry.value) or ""
        shown, *ends = (
            f"{number / (UNITS[word].factor if word else 1.0):g} {word}".rstrip() for number in (known, low, high)
        )
        span = entry.value.span
        ev.report(OVERRIDE_OUTSIDE.at(span, name=entry.name, value=shown, low=ends[0], high=ends[1]))


def _from_command_line(mistake: Mistake, name: str) -> Mistake:
    """The file is not to blame."""
    if mistake.diagnostic is None:
        return mistake
    option = f"`-p {name}`"
    message = mistake.diagnostic.message
    return Mistake(replace(mistake.diagnostic, message=message if option in message else f"{option}: {message}"))


def _option_names(ev: Evaluator, entry: nodes.ParamEntry) -> dict[str, Value] | None:
    call = random_values.distribution_call(ev, entry.value)
    if call is None or not isinstance(call.function, nodes.Name):
        return None
    site = Site(entry.value.span, unit_behind(entry.value))
    find = {
        "Uniform": random_values.uniform_options,
        "VerifaiOptions": random_values.uniform_options,
        "Discrete": random_values.weighted_options,
    }.get(call.function.id)
    if find is None:
        return None
    options = find(ev, call.function.id, evaluate_arguments(ev, call.arguments), site)
    if all(isinstance(option.value, Quantity) for option in options):
        return None
    return {option_name(option.value): option.value for option in options}


def _overriding_option(
    ev: Evaluator, entry: nodes.ParamEntry, node: nodes.Expression, options: dict[str, Value]
) -> Value:
    written = node.id if isinstance(node, nodes.Name) else option_name(ev.evaluate(node))
    if written not in options:
        raise WRONG_KIND.mistake(
            entry.value.span,
            what=f"`-p {entry.name}`",
            expected="one of its options",
            actual=f"`{written}`",
            cure=did_you_mean(written, options),
        )
    return options[written]
