"""Numbers of a whole run, for `maximize` and `minimize`: reductions over all samples, and results by name.

Both are evaluated after the run. Until then they are unknown numbers, which expressions read as locals: the number of
the reading is the number of its local.
"""

from collections.abc import Callable, Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.errors.runs import NOBODY_ELSE, ONLY_WHILE_RUNNING
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Slot, bind, evaluate_arguments
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import Quantity, SimulationNow, Truth, Value
from cortex_dsl.semantics.names.builtins import REDUCERS
from cortex_dsl.semantics.quantities.algebra import rounded
from cortex_dsl.semantics.quantities.units import PURE, TIME, UNITS, product
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.judged import NAMED_RESULTS
from engine.vocabulary import Reducer, RuleKind

RESULTS = {row.name: row for row in NAMED_RESULTS}


def judged(ev: Evaluator, *, over: bool = False) -> Evaluator:
    """Return the evaluator for assessed runs: up to contact, with the ego as `self`."""
    return ev.at_moment(Moment(True, ev.run.ego, scenario=ev.moment.scenario, judged=True, over=over))


def reducer_of(ev: Evaluator, function: nodes.Expression) -> str | None:
    """The reducer that a call means, unless the file has something of its own by that name."""
    named = isinstance(function, nodes.Name) and function.id in REDUCERS and not ev.has(function.id)
    return function.id if named and isinstance(function, nodes.Name) else None


def reduced(ev: Evaluator, reducer: str, node: nodes.Call) -> Value:
    """Return one number that reduces a value over the run."""
    given = evaluate_arguments(judged(ev), node.arguments)
    argument = bind(reducer, f"{reducer}(x)", [Slot("x")], given, node.span)["x"]
    value = argument.value
    value = Quantity(value.expr, PURE) if isinstance(value, Truth) else value
    number = numbers.quantity(value, argument.span, f"the argument of `{reducer}`")
    name = ev.facts.source.words(argument.span)
    rule = ev.file.run.rule(argument.span, name, RuleKind.WATCH)
    ev.run.built.rule_conditions[argument.span, RuleKind.WATCH] = number.expr
    kind = Reducer[reducer.upper()]
    dimension = number.dimension if kind is not Reducer.TOTAL else product(number.dimension or PURE, TIME)
    return Quantity(ev.algebra.local(ev.file.run.reading(ir.Reading(kind, rule))), dimension)


def result(ev: Evaluator, node: nodes.Name) -> Value:
    """A result by name."""
    row = RESULTS[node.id]
    if row.of_pair and len(ev.run.built.actors) < 2:
        raise NOBODY_ELSE.mistake(node.span, name=row.name)
    reading = ev.file.run.reading(ir.Reading(Reducer.RESULT, result=row.name))
    return Quantity(ev.algebra.local(reading), UNITS[row.unit].dimension if row.unit else PURE)


# -- `simulation()`: the present run -----


def _simulation(ev: Evaluator, span: Span) -> Value:
    if not ev.moment.running:
        raise ONLY_WHILE_RUNNING.mistake(span, what="`simulation()`")
    return SimulationNow()


OF_SIMULATION: dict[str, Callable[[Evaluator, SimulationNow], Value]] = {
    "currentTime": lambda ev, _: Quantity(rounded(ev.algebra.time() / _time_step(ev)), None),
    "timestep": lambda ev, _: Quantity(ev.algebra.literal(_time_step(ev)), TIME),
}


def _time_step(ev: Evaluator) -> float:
    return ev.file.settings.time_step


MEANINGS: Mapping[str, Callable[..., Value]] = {"simulation": _simulation}
