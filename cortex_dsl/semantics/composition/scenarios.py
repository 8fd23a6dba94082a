"""Modular scenarios: what a scenario sets up, and the coroutine that runs it.

The scenario that the run is shares the run with the top level of its file. Those that a `compose` starts are set up
with the scene too; their objects wait outside until the scenario starts, unless it surely starts with the run.
Source: Scenic 3 reference, "Modular Scenario Definition", and its tutorial "Composing Scenarios".
"""

from collections.abc import Iterator, Sequence

from cortex_dsl.semantics import errors
from cortex_dsl.semantics.context import Evaluator, Moment
from cortex_dsl.semantics.definitions import Instance, ScenarioValue
from cortex_dsl.semantics.findings import Findings
from cortex_dsl.semantics.problems import Mistake
from cortex_dsl.semantics.running.rules import speaks_of_run
from cortex_dsl.semantics.state import Variant
from cortex_dsl.semantics.statements import run_statement
from cortex_dsl.semantics.things import mutation
from cortex_dsl.semantics.things.overriding import override
from cortex_dsl.semantics.tree import everything_in
from cortex_dsl.semantics.values import Value
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

MAIN = "Main"

# -- which one runs ---------------------------------------------------------------------------------------------------


def entry(module: nodes.Module, name: str | None, findings: Findings) -> nodes.ScenarioDefinition | None:
    """The one to run: the one named, else `Main`, else the only one that can run by itself and that none starts."""
    known = {s.name: s for s in module.statements if isinstance(s, nodes.ScenarioDefinition)}
    wanted = name or pinned_scenario(module) or (MAIN if MAIN in known else None)
    if wanted is not None:
        if wanted not in known:
            suggestion = did_you_mean(wanted, known) or "this file defines no scenarios"
            findings.add(errors.UNKNOWN_SCENARIO.at(Span(0, 0), name=wanted, suggestion=suggestion))
            return None
        return _without_arguments(known[wanted], findings)
    started = set(_started(module))
    free = [s for s in known.values() if s.name not in started and not any(p.default is None for p in s.parameters)]
    if len(free) > 1:
        names = ", ".join(f"`{each.name}`" for each in free)
        findings.add(errors.WHICH_SCENARIO.at(free[0].name_span, names=names))
        return None
    return free[0] if free else None


def pinned_scenario(module: nodes.Module) -> str | None:
    """The name in `simulation(scenario="...")`, as a concrete copy has it."""
    for statement in module.statements:
        for argument in statement.arguments if isinstance(statement, nodes.Simulation) else ():
            if argument.name == "scenario" and isinstance(argument.value, nodes.String):
                return argument.value.value
    return None


def _started(module: nodes.Module) -> Iterator[str]:
    """Names that the scenarios of a file mention."""
    for statement in module.statements:
        if isinstance(statement, nodes.ScenarioDefinition):
            yield from (node.id for node in everything_in(statement) if isinstance(node, nodes.Name))


def _without_arguments(node: nodes.ScenarioDefinition, findings: Findings) -> nodes.ScenarioDefinition | None:
    for parameter in node.parameters:
        if parameter.default is None:
            findings.add(errors.NEEDS_ARGUMENTS.at(parameter.span, name=node.name, parameter=parameter.name))
            return None
    return node


# -- setting up -------------------------------------------------------------------------------------------------------


def place_of(ev: Evaluator, scenario: ScenarioValue, instance: Instance) -> Evaluator:
    """Where the setup of a scenario is evaluated."""
    return ev.at_home(scenario.home).inside(instance.names).at_moment(Moment(scenario=instance))


def set_up(ev: Evaluator, scenario: ScenarioValue, instance: Instance, arguments: dict[str, Value]) -> None:
    """Run the setup of a scenario: its objects are made and numbered; what speaks of the run is kept for later."""
    node, here = scenario.node, place_of(ev, scenario, instance)
    for parameter in node.parameters:
        if parameter.name in arguments:
            instance.names[parameter.name] = arguments[parameter.name]
        elif (default := parameter.default) is not None:
            instance.names[parameter.name] = here.tolerate(lambda default=default: here.evaluate(default))
    mutation.announce(here, node.setup)
    before = len(ev.run.actors)
    with ev.naming(""):
        for statement in node.setup:
            _run(here, statement, instance)
    instance.actors = ev.run.actors[before:]
    if ev.run.ego is None:
        ev.run.first_ego = instance.ego
    number(ev.run)


def _run(ev: Evaluator, statement: nodes.Statement, instance: Instance) -> None:
    top = instance is ev.run.root
    if isinstance(statement, nodes.Override):
        try:
            override(ev, statement, instance)
        except Mistake as mistake:
            ev.report(mistake)
    elif speaks_of_run(statement) or (not top and isinstance(statement, nodes.RequireMonitor | nodes.TerminateAfter)):
        instance.rules.append(statement)
    else:
        run_statement(ev, statement)


def number(run: Variant) -> None:
    """Number the objects made so far: the ego is 0, once there is one."""
    for actor in run.actors:
        if actor.index < 0 and actor is run.ego:
            actor.index = 0
        elif actor.index < 0:
            actor.index, run.numbered = run.numbered, run.numbered + 1


def surely_first(statements: Sequence[nodes.Statement]) -> frozenset[Span]:
    """Places of the invocations that start with the `compose` itself. An interrupt may come before those in a `try`;
    their objects are there all the same.
    """
    for statement in statements:
        if isinstance(statement, nodes.Try):
            return surely_first(statement.body)
        if isinstance(statement, nodes.Do) and not statement.mode:
            return frozenset(each.span for each in statement.invocations)
        if not isinstance(statement, nodes.Assign | nodes.Pass | nodes.Require | nodes.ExpressionStatement):
            return frozenset()
    return frozenset()
