"""The `environment` statement, and its effect on the properties of objects: less grip, a shorter view.

Friction multiplies that of every object. The view of an object reaches to `visibleDistance` times the light, and no
further than the sight. The properties themselves stay as in the file.
"""

from cortex_dsl.semantics.errors.names import DUPLICATE, NOT_SUPPORTED, UNKNOWN_ARGUMENT
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.scene import ENVIRONMENT_LATE, ENVIRONMENT_TWICE
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_arguments
from cortex_dsl.semantics.evaluation.ranges import within
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.state import Environment
from cortex_dsl.semantics.names.properties import ENVIRONMENT, Domain
from cortex_dsl.semantics.quantities.algebra import Term, minimum
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes


def set_environment(ev: Evaluator, node: nodes.Environment) -> None:
    """`environment(...)`: the weather of the whole run."""
    if ev.run.built.environment is not None:
        raise ENVIRONMENT_TWICE.mistake(node.span)
    ev.run.built.environment = Environment({}, node.span)
    if ev.run.built.actors:
        raise ENVIRONMENT_LATE.mistake(node.span, name=ev.run.built.actors[0].name)
    values: dict[str, Term] = {}
    for argument in evaluate_arguments(ev, node.arguments):
        try:
            name = _name(argument, values)
            values[name] = _value(ev, argument, ENVIRONMENT[name])
        except Mistake as mistake:
            ev.report(mistake)
    ev.run.built.environment = Environment(values, node.span)


def _name(argument: Given, seen: dict[str, Term]) -> str:
    name = argument.name
    if name is None:
        what = "`environment` takes its arguments by name"
        raise NOT_SUPPORTED.mistake(argument.span, what=what, reason="", cure="as in `friction=0.4`")
    if name not in ENVIRONMENT:
        suggestion = did_you_mean(name, ENVIRONMENT)
        raise UNKNOWN_ARGUMENT.mistake(argument.place, function="environment", name=name, suggestion=suggestion)
    if name in seen:
        raise DUPLICATE.mistake(argument.place, what="the argument", name=name)
    return name


def _value(ev: Evaluator, argument: Given, spec: Domain) -> Term:
    what = f"the {spec.name} of the environment"
    expr = numbers.adopt(ev, argument.value, spec.dimension, argument.span, what)
    return within(ev, expr, spec, argument.span, what)


def in_environment(ev: Evaluator, name: str, value: Term) -> Term:
    """Return a property of an object under the conditions of the environment."""
    given = {} if ev.run.built.environment is None else ev.run.built.environment.values
    if name == "friction" and "friction" in given:
        return value * given["friction"]
    if name == "visibleDistance":
        value = value * given["light"] if "light" in given else value
        return minimum(value, given["sight"]) if "sight" in given else value
    return value
