"""Literals, names, lists, and the operators of arithmetic, comparison and logic."""

import math
from collections.abc import Iterable, Iterator
from functools import partial
from itertools import permutations
from operator import add, and_, or_, sub

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.ir import Dimension
from cortex_dsl.semantics.errors.names import NOT_SUPPORTED, TEMPORAL_PLACE
from cortex_dsl.semantics.errors.values import (
    CONVERTED_TWICE,
    LIST_TOO_LONG,
    NEVER_EQUAL,
    NO_OPERATOR,
    NOT_FINITE,
    UNKNOWN_UNIT,
)
from cortex_dsl.semantics.evaluation import (
    alignments,
    attributes,
    geometry,
    lanes,
    numbers,
    over_run,
    random_values,
    signals,
    streets,
)
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.functions import RANGE_LIMIT, known_truth
from cortex_dsl.semantics.evaluation.random_values import Site, scaled
from cortex_dsl.semantics.evaluation.roads import named_constant
from cortex_dsl.semantics.evaluation.streets import REGIONS
from cortex_dsl.semantics.evaluation.texts import joined_text
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    Alignment,
    Closure,
    Items,
    Pose,
    Quantity,
    Truth,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.quantities.algebra import Constant, Term, equal, where
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import PURE, UNITS, Unit, dimension_name
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean, nearest
from cortex_dsl.syntax import nodes
from engine.operators import OPERATORS, Infix
from engine.vocabulary import ManeuverType

# -- literals and names -----------------------------------------------------------------------------------------------


def unit_named(word: str, span: Span) -> Unit:
    if word not in UNITS:
        raise UNKNOWN_UNIT.mistake(span, unit=word, suggestion=did_you_mean(word, UNITS))
    return UNITS[word]


def number(ev: Evaluator, node: nodes.Number) -> Value:
    """SI value = written value * factor, once."""
    if not math.isfinite(node.value):
        raise NOT_FINITE.mistake(node.span, reason="it is too large")
    if node.unit is None:
        return Quantity(ev.algebra.literal(node.value), None)
    unit = unit_named(node.unit, node.span)
    return numbers.literal(ev, node.value * unit.factor, unit.dimension, node.span)


def with_unit(ev: Evaluator, node: nodes.WithUnit) -> Value:
    return _in_unit(ev, node, node.value, unit_named(node.unit, node.span))


def degrees(ev: Evaluator, node: nodes.Degrees) -> Value:
    return _in_unit(ev, node, node.value, UNITS["deg"])


def _in_unit(ev: Evaluator, node: nodes.Expression, value: nodes.Expression, unit: Unit) -> Value:
    call = random_values.distribution_call(ev, node)
    if call is not None:
        return random_values.sample_call(ev, call, Site(node.span, unit))
    return scaled(Given(ev.evaluate(value), value.span), unit)


def string(_ev: Evaluator, node: nodes.String) -> Value:
    return node.value


def constant(ev: Evaluator, node: nodes.Constant) -> Value:
    return None if node.value is None else Truth(ev.algebra.truth(node.value))


def initial_scenario(ev: Evaluator, _node: nodes.InitialScenario) -> Value:
    return Truth(ev.algebra.truth(not ev.run.built.has_set_up))


def name(ev: Evaluator, node: nodes.Name) -> Value:
    if node.id == "self" and ev.moment.actor is not None:
        return ev.moment.actor
    if not ev.has(node.id):
        if node.id == "ego":
            return geometry.ego_of(ev, node.span, "this")
        if ev.moment.over and node.id in over_run.RESULTS:
            return over_run.result(ev, node)
        if (region := REGIONS.get(node.id)) is not None:
            return region(ev, node.span)
        if (known := named_constant(ev, node.id, node.span)) is not None:
            return known.value
    return ev.lookup(node.id, node.span)


def attribute(ev: Evaluator, node: nodes.Attribute) -> Value:
    return attributes.get(ev, ev.evaluate(node.value), node.name, node.name_span)


def lambda_(ev: Evaluator, node: nodes.Lambda) -> Value:
    def apply(*values: Value) -> Value:
        with ev.run.depth.call(node.span):
            return ev.inside(dict(zip(node.parameters, values, strict=True))).evaluate(node.body)

    return Closure(node.parameters, apply, None if ev.has("ManeuverType") else node.body)


# -- arithmetic -------------------------------------------------------------------------------------------------------

_ARITHMETIC = {
    row.spelling.sign: partial(numbers.combined, op)
    for op, row in OPERATORS.items()
    if isinstance(row.spelling, Infix) and row.spelling.rule is not None
}


def unary(ev: Evaluator, node: nodes.Unary) -> Value:
    value = ev.evaluate(node.operand)
    if node.operator == "not":
        return Truth(~numbers.truth(ev, value, node.operand.span))
    operand = numbers.quantity(value, node.operand.span, f"the operand of `{node.operator}`")
    return numbers.negated(operand) if node.operator == "-" else operand


def binary(ev: Evaluator, node: nodes.Binary) -> Value:
    left, right = ev.evaluate_all((node.left, node.right))
    return combine(ev, node.operator, left, right, node)


def combine(ev: Evaluator, operator: str, left: Value, right: Value, node: nodes.Binary) -> Value:
    if operator == "@":
        return geometry.vector(ev, (left, right), node.span)
    if isinstance(left, Quantity) and isinstance(right, Quantity):
        for warning in converted_twice(operator, left, right, node) if operator in ("*", "/") else ():
            ev.report(warning)
        with numbers.sides((node.left.span, left), (node.right.span, right)):
            return _ARITHMETIC[operator](left, right, node.span)
    if isinstance(left, str) and isinstance(right, str) and operator == "+":
        return joined_text(ev, [left, right], node.span)
    if isinstance(left, tuple) and isinstance(right, tuple) and operator == "+":
        if len(left) + len(right) > RANGE_LIMIT:
            raise LIST_TOO_LONG.mistake(node.span, limit=RANGE_LIMIT)
        ev.file.budget.copy(node.span, len(left) + len(right))
        joined = (*left, *right)
        return Items(joined) if isinstance(left, Items) else joined
    if operator in ("+", "-") and isinstance(left, Vector | Pose) and isinstance(right, Vector | Pose):
        join = add if operator == "+" else sub
        return Vector(join(left.x, right.x), join(left.y, right.y))
    displaced = {type(left), type(right)} & {Vector, Pose, Actor} and Quantity in (type(left), type(right))
    cure = _DISPLACED if operator in ("+", "-") and displaced else _NUMBER_OF_IT
    if isinstance(left, str) != isinstance(right, str):
        cure = _TO_TEXT if operator == "+" else "`int(...)` or `float(...)` reads the number in a text"
    raise NO_OPERATOR.mistake(node.span, operator=operator, left=kind_name(left), right=kind_name(right), cure=cure)


_NUMBER_OF_IT = "use a number, such as `ego.speed`, or `distance from ego to lane`"
_TO_TEXT = 'to write it into the text use `f"{x}"`, or `str(x)`; `int("3")` reads the number in a text'
_DISPLACED = "to displace a place write `place offset by (0 m, 10 m)`: so far to the right, and so far ahead"


# -- comparison and logic ---------------------------------------------------------------------------------------------


def compare(ev: Evaluator, node: nodes.Compare) -> Value:
    """A chain holds when every link does; operands are evaluated once."""
    operands = [node.first, *(operand for _, operand in node.rest)]
    values = ev.evaluate_all(operands)
    result: Term = ev.algebra.truth(True)
    for i, (operator, operand) in enumerate(node.rest):
        span = operands[i].span.to(operand.span)
        with numbers.sides((operands[i].span, values[i]), (operand.span, values[i + 1])):
            result = result & _link(ev, operator, values[i], values[i + 1], span)
    return Truth(result)


def _link(ev: Evaluator, operator: str, left: Value, right: Value, span: Span) -> Term:
    if operator in ("in", "not in"):
        found = _contains(ev, right, left, span)
        return found if operator == "in" else ~found
    if isinstance(left, Quantity) and isinstance(right, Quantity):
        if operator in ("is", "is not"):
            operator = "==" if operator == "is" else "!="
        return numbers.compare(ev, operator, left, right, span)
    if operator in ("<", "<=", ">", ">="):
        raise NO_OPERATOR.mistake(
            span, operator=operator, left=kind_name(left), right=kind_name(right), cure=_NUMBER_OF_IT
        )
    same = _same(ev, left, right)
    return same if operator in ("is", "==") else ~same


def _same(ev: Evaluator, left: Value, right: Value) -> Term:
    """Identity of objects, equality of text and lists."""
    if (lane := lanes.same(ev, left, right)) is not None:
        return lane
    if (element := streets.same(left, right)) is not None:
        return element
    if (colour := signals.same_colour(ev, left, right, ev.algebra.span)) is not None:
        return colour
    if isinstance(left, Truth) and isinstance(right, Truth):
        return equal(left.expr, right.expr)
    if isinstance(left, Quantity) and isinstance(right, Quantity):
        return equal(left.expr, right.expr)
    if isinstance(left, tuple) and isinstance(right, tuple) and len(left) == len(right):
        result: Term = ev.algebra.truth(True)
        ev.file.budget.spend(ev.algebra.span, len(left) + len(right))
        for one, other in zip(left, right, strict=True):
            result = result & _same(ev, one, other)
        return result
    if isinstance(left, str) != isinstance(right, str) and None not in (left, right):
        cure = _instead_of_text(left, right)
        finding = NEVER_EQUAL.at(ev.algebra.span, left=kind_name(left), right=kind_name(right), cure=cure)
        ev.report(finding)
    return ev.algebra.truth(type(left) is type(right) and left == right)


def _instead_of_text(left: Value, right: Value) -> str:
    text, other = (left, right) if isinstance(left, str) else (right, left)
    if not isinstance(other, ManeuverType):
        return "compare it with a thing of its own kind"
    meant = nearest(str(text), [member.name for member in ManeuverType]) or ManeuverType.STRAIGHT.name
    return f"write a maneuver type, without quotes: `ManeuverType.{meant}`"


def _contains(ev: Evaluator, container: Value, item: Value, span: Span) -> Term:
    if isinstance(container, str) and isinstance(item, str):
        return ev.algebra.truth(item in container)
    if not isinstance(container, tuple):
        return geometry.inside(ev, item, container, span)
    ev.file.budget.spend(span, len(container))
    result: Term = ev.algebra.truth(False)
    for candidate in container:
        result = result | _same(ev, item, candidate)
    return result


def boolean(ev: Evaluator, node: nodes.BoolOp) -> Value:
    """`and` / `or`, stopping at the first operand that is known to decide."""
    join, decisive = (and_, 0.0) if node.operator == "and" else (or_, 1.0)
    result: Term = ev.algebra.truth(join is and_)
    for operand in node.operands:
        result = join(result, numbers.truth(ev, ev.evaluate(operand), operand.span))
        if isinstance(result, Constant) and result.value == decisive:
            break
    return Truth(result)


def conditional(ev: Evaluator, node: nodes.Conditional) -> Value:
    condition = numbers.truth(ev, ev.evaluate(node.condition), node.condition.span)
    if isinstance(condition, ir.Literal):
        return ev.evaluate(node.then if condition.value else node.otherwise)
    then, otherwise = ev.evaluate_all((node.then, node.otherwise))
    if isinstance(then, Quantity) and isinstance(otherwise, Quantity):
        with numbers.sides((node.then.span, then), (node.otherwise.span, otherwise)):
            return numbers.select(condition, then, otherwise, node.span)
    if isinstance(then, Truth) and isinstance(otherwise, Truth):
        return Truth(where(condition, then.expr, otherwise.expr))
    if isinstance(then, Alignment) and isinstance(otherwise, Alignment):
        return alignments.select(condition, then, otherwise)
    known = known_truth(ev, Truth(condition), node.condition.span, "a condition that chooses between objects")
    return then if known else otherwise


def starred(_ev: Evaluator, node: nodes.Starred) -> Value:
    raise NOT_SUPPORTED.mistake(node.span, what="`*` unpacks only in calls and lists", reason="", cure="remove it")


def implication(ev: Evaluator, node: nodes.Temporal) -> Value:
    """`a implies b` of one moment."""
    if node.operator != "implies":
        raise TEMPORAL_PLACE.mistake(node.span, operator=node.operator, cure="")
    premise, conclusion = (numbers.truth(ev, ev.evaluate(part), part.span) for part in node.operands)
    return Truth(~premise | conclusion)


# -- a class of the engine ---------------------------------------------------------------------------------------------


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
