"""Set up the parts of a program: the top level of a file, the files that it imports, and modular scenarios.

As in Scenic, an import brings the objects and requirements of a file along with its definitions. Each imported file
runs once in a variant, with variables of its own, and is then shared by name. Only the main file decides about the run
as a whole.

The scenario to run shares the run with the top level of its file. Scenarios that a `compose` starts are set up with the
scene too; their objects wait outside until the scenario starts, unless it certainly starts with the run.
Source: Scenic 3 reference, "Modular Scenario Definition", and its tutorial "Composing Scenarios".
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress

from cortex_dsl.semantics.acting.bodies import of_same_dimension
from cortex_dsl.semantics.acting.statements import TOP_LEVEL, Run
from cortex_dsl.semantics.errors.names import NOT_IN_FILE, NOT_IN_IMPORT, UNKNOWN_PROPERTY
from cortex_dsl.semantics.errors.problems import Findings, Mistake
from cortex_dsl.semantics.errors.runs import CANNOT_OVERRIDE, NEEDS_ARGUMENTS, UNKNOWN_SCENARIO, WHICH_SCENARIO
from cortex_dsl.semantics.errors.values import OVERRIDDEN_AND_SET, WRONG_KIND
from cortex_dsl.semantics.evaluation import making, mutation
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.geometry import NeedsRun
from cortex_dsl.semantics.evaluation.making import checked
from cortex_dsl.semantics.interpreter import control
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.marks import Marks, Rewind
from cortex_dsl.semantics.model.state import VariantState
from cortex_dsl.semantics.model.values import (
    POISON,
    Actor,
    BehaviourValue,
    Function,
    Instance,
    MonitorValue,
    Namespace,
    ScenarioValue,
    Value,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.linking import ImportedFile
from cortex_dsl.semantics.names.properties import FLAGS, IGNORED, PLACES, PROPERTIES, all_properties
from cortex_dsl.semantics.names.tree import assigned, bound_name, everything_in, speaks_of_run
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.vocabulary import ActorKind

# -- files -------------------------------------------------------------------------------------------------------------

OF_THE_RUN: Mapping[type, tuple[str, str]] = {
    nodes.Map: ("map", "all objects share the road of the file that is run"),
    nodes.Simulation: ("simulation", "the file that is run says how it is run"),
    nodes.Signals: ("signals", "the traffic lights belong to the road of the file that is run"),
    nodes.Environment: ("environment", "all objects share the weather of the file that is run"),
    nodes.TerminateWhen: ("terminate when", "the file that is run says when it ends"),
    nodes.TerminateAfter: ("terminate after", "the file that is run says when it ends"),
}
"""Statements that an imported file cannot have, and why."""


def run_statement(ev: Evaluator, statement: nodes.Statement) -> None:
    """Run one statement; after a mistake its names are marked as failed, so that they cause no further errors."""
    try:
        _execute(ev, statement)
    except Mistake as mistake:
        ev.report(mistake)
        ev.scope.update(dict.fromkeys(_targets(statement), POISON))


def _execute(ev: Evaluator, statement: nodes.Statement) -> None:
    if (compound := COMPOUND.get(type(statement))) is not None:
        compound(ev, statement, run_statement if ev.frame is None else _execute)
    else:
        STATEMENTS[type(statement)](ev, statement)


def _targets(statement: nodes.Statement) -> tuple[str, ...]:
    match statement:
        case nodes.Assign(targets=targets):
            return targets
        case nodes.AugmentedAssign(target=target):
            return (target,)
        case nodes.ClassDefinition(name=name):
            return (name,)
        case nodes.For() | nodes.If() | nodes.While():
            return tuple(assigned((statement,)))
        case nodes.Import() if (name := bound_name(statement)) is not None:
            return (name,)
        case nodes.ImportFrom(names=names):
            return tuple(each.alias or each.name for each in names)
    return ()


def run_module(
    ev: Evaluator, statements: Sequence[nodes.Statement], first: int = 0, marks: Marks | None = None
) -> None:
    """Run the statements of a file's top level, or continue with the statement numbered `first`.

    Behaviours, monitors and scenarios are known from the start of the file.
    """
    if not first:
        ev.names.update(_definitions(ev, statements))
        mutation.announce(ev, statements)
    for index, statement in enumerate(statements[first:], first):
        if marks is not None:
            marks.put(ev.run, index)
        with suppress(control.Leaving):  # said to stand in the wrong place
            run_statement(ev, statement)


def _definitions(ev: Evaluator, statements: Sequence[nodes.Statement]) -> dict[str, Value]:
    found: dict[str, Value] = {}
    for statement in statements:
        match statement:
            case nodes.BehaviorDefinition(name=name):
                found[name] = BehaviourValue(statement, ev.home, ev.scopes)
            case nodes.MonitorDefinition(name=name):
                found[name] = MonitorValue(statement, ev.home, ev.scopes)
            case nodes.ScenarioDefinition(name=name):
                found[name] = ScenarioValue(statement, ev.home)
            case nodes.FunctionDefinition(name=name):
                found[name] = control.function(ev, statement, _execute)
    return found


def _names_of(ev: Evaluator, span: Span) -> tuple[ImportedFile, dict[str, Value]]:
    """The file behind an import statement, and its variables."""
    file = ev.facts.imports.get(span)
    if file is None:
        raise Mistake  # the file was not read
    if file.name not in ev.run.imported:
        names = ev.run.imported[file.name] = {}
        with ev.naming(""):
            run_module(ev.at_home(names), [s for s in file.module.statements if _belongs(ev, s)])
    return file, ev.run.imported[file.name]


def _belongs(ev: Evaluator, statement: nodes.Statement) -> bool:
    """Return whether a statement of an imported file takes effect; report the reason if not."""
    if isinstance(statement, nodes.Model):
        return False
    word, reason = OF_THE_RUN.get(type(statement), ("", ""))
    if isinstance(statement, nodes.Assign) and "ego" in statement.targets:
        word, reason = "ego = ...", "the file that is run says which object is the ego"
    if word:
        ev.report(NOT_IN_IMPORT.at(statement.span, statement=word, reason=reason))
    return not word


def _import(ev: Evaluator, node: nodes.Import) -> None:
    file, names = _names_of(ev, node.span)
    name = bound_name(node)
    if name is not None:
        ev.scope[name] = Namespace(file.name, names)


def _import_from(ev: Evaluator, node: nodes.ImportFrom) -> None:
    file, names = _names_of(ev, node.span)
    for each in node.names:
        if each.name not in names:
            suggestion = did_you_mean(each.name, names)
            raise NOT_IN_FILE.mistake(each.span, file=file.name, name=each.name, suggestion=suggestion)
        ev.scope[each.alias or each.name] = names[each.name]
    if not node.names:
        ev.scope.update(names)


def _function(ev: Evaluator, node: nodes.FunctionDefinition) -> None:
    """Those of the top level are known from its start."""
    if not isinstance(ev.scope.get(node.name), Function):
        ev.scope[node.name] = control.function(ev, node, _execute)


def _class(ev: Evaluator, node: nodes.ClassDefinition) -> None:
    ev.scope[node.name] = making.define(ev, node)


STATEMENTS: Mapping[type, Run] = {
    **TOP_LEVEL,
    nodes.Import: _import,
    nodes.ImportFrom: _import_from,
    nodes.ClassDefinition: _class,
    nodes.Mutate: mutation.mutate,
    nodes.FunctionDefinition: _function,
    nodes.Assert: control.check_assertion,
    nodes.Break: control.leave,
    nodes.Continue: control.leave,
    nodes.Return: control.return_,
}  # type: ignore[dict-item]

COMPOUND: Mapping[type, Callable[..., None]] = {
    nodes.If: control.branch,
    nodes.For: control.loop_over,
    nodes.While: control.loop_while,
}
"""Statements with blocks; the runner of the surrounding statements runs them."""

# -- which scenario runs -----------------------------------------------------------------------------------------------

MAIN = "Main"


def entry(module: nodes.Module, name: str | None, findings: Findings) -> nodes.ScenarioDefinition | None:
    """Return the scenario to run: the named one, else `Main`, else the only unstarted one without arguments."""
    known = {s.name: s for s in module.statements if isinstance(s, nodes.ScenarioDefinition)}
    wanted = name or pinned_scenario(module) or (MAIN if MAIN in known else None)
    if wanted is not None:
        if wanted not in known:
            suggestion = did_you_mean(wanted, known) or "this file defines no scenarios"
            findings.add(UNKNOWN_SCENARIO.at(Span(0, 0), name=wanted, suggestion=suggestion))
            return None
        return _without_arguments(known[wanted], findings)
    started = set(_started(module))
    free = [s for s in known.values() if s.name not in started and not any(p.default is None for p in s.parameters)]
    if len(free) > 1:
        names = ", ".join(f"`{each.name}`" for each in free)
        findings.add(WHICH_SCENARIO.at(free[0].name_span, names=names))
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
            findings.add(NEEDS_ARGUMENTS.at(parameter.span, name=node.name, parameter=parameter.name))
            return None
    return node


# -- setting up a scenario ---------------------------------------------------------------------------------------------


def place_of(ev: Evaluator, scenario: ScenarioValue, instance: Instance) -> Evaluator:
    """Return the evaluator for the setup of a scenario."""
    return ev.at_home(scenario.home).inside(instance.names).at_moment(Moment(scenario=instance))


def set_up(ev: Evaluator, scenario: ScenarioValue, instance: Instance, arguments: dict[str, Value]) -> None:
    """Run the setup of a scenario: make and number its objects; store the statements about the run."""
    node, here = scenario.node, place_of(ev, scenario, instance)
    for parameter in node.parameters:
        if parameter.name in arguments:
            instance.names[parameter.name] = arguments[parameter.name]
        elif (default := parameter.default) is not None:
            instance.names[parameter.name] = here.tolerate(lambda default=default: here.evaluate(default))
    instance.names.update(_definitions(here, node.setup))
    mutation.announce(here, node.setup)
    before = len(ev.run.built.actors)
    with ev.naming(""):
        for statement in node.setup:
            with suppress(control.Leaving):  # said to stand in the wrong place
                _set_up_by(here, statement, instance)
    instance.actors = ev.run.built.actors[before:]
    ev.run.built.has_set_up |= bool(node.setup)
    if ev.run.ego is None:
        ev.run.built.first_ego = instance.ego
    number(ev.run)


def _set_up_by(ev: Evaluator, statement: nodes.Statement, instance: Instance) -> None:
    top = instance is ev.run.root
    if isinstance(statement, nodes.Override):
        try:
            override(ev, statement, instance)
        except Mistake as mistake:
            ev.report(mistake)
    elif speaks_of_run(statement) or (not top and isinstance(statement, nodes.RequireMonitor | nodes.TerminateAfter)):
        instance.rules.append(statement)
    elif not top and not instance.present and (made := _made_by(statement)) is not None:
        _make_or_wait(ev, statement, made, instance)
    else:
        run_statement(ev, statement)


def _made_by(statement: nodes.Statement) -> nodes.New | None:
    """Return the `new` of a statement that makes an object."""
    value = statement.value if isinstance(statement, nodes.Assign | nodes.ExpressionStatement) else None
    return value if isinstance(value, nodes.New) and value.class_name not in PLACES else None


def _make_or_wait(ev: Evaluator, statement: nodes.Statement, made: nodes.New, instance: Instance) -> None:
    """Make an object with the scene, or, if its place depends on where others are by then, when the scenario starts."""
    built, before = ev.run.built, Rewind(ev.run)
    built.may_appear = True
    try:
        run_statement(ev, statement)
        return
    except NeedsRun:
        before.restore()
    finally:
        built.may_appear = False
    names = statement.targets if isinstance(statement, nodes.Assign) else ()
    try:
        with ev.naming(names[0] if names else ""), built.collecting(instance.entering):
            value = ev.at_moment(Moment(running=True, scenario=instance)).evaluate(made)
        instance.names.update(dict.fromkeys(names, value))
    except Mistake as mistake:
        ev.report(mistake)
        instance.names.update(dict.fromkeys(names, POISON))


def number(run: VariantState) -> None:
    """Number the objects made so far: the ego, if it exists, is 0."""
    for actor in run.built.actors:
        if actor.index < 0 and actor is run.ego:
            actor.index = 0
        elif actor.index < 0:
            actor.index, run.built.numbered = run.built.numbered, run.built.numbered + 1


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


# -- `override x with property value` ----------------------------------------------------------------------------------


SETTLED = ("name", "allowCollisions", "regionContainedIn", "requireVisible", "level")
"""Properties that are used before the run only."""


def override(ev: Evaluator, node: nodes.Override, instance: Instance) -> None:
    """Override properties of an object.

    Raises:
        Mistake: it is no object, or the property cannot change.
    """
    target = ev.evaluate(node.target)
    if not isinstance(target, Actor):
        raise WRONG_KIND.mistake(
            node.target.span, what="what is overridden", expected="an object", actual=kind_name(target), cure=""
        )
    for specifier in node.specifiers:
        if not isinstance(specifier, nodes.With):
            raise CANNOT_OVERRIDE.mistake(
                specifier.span,
                name="the place of an object",
                here="",
                reason="its place follows from its motion",
                cure="override its behavior, as in `override x with behavior B()`",
            )
        _property(ev, target, specifier, instance)


def _property(ev: Evaluator, target: Actor, node: nodes.With, instance: Instance) -> None:
    name = node.property
    if name not in (*PROPERTIES, *FLAGS, *IGNORED) and name not in target.properties:
        suggestion = did_you_mean(name, {*all_properties(), *target.properties})
        raise UNKNOWN_PROPERTY.mistake(node.property_span, kind=f"`{target.name}`", name=name, suggestion=suggestion)
    own = name not in all_properties() and instance is not ev.run.root
    if own:
        _override_own(ev, target, node, instance)
        return
    _check_can_change(ev, node, instance)
    may_act = target.plain or target.kind is not ActorKind.OBSTACLE
    value = checked(ev, name, ev.evaluate(node.value), node.value.span, may_act=may_act)
    if name == "behavior" and instance is not ev.run.root:
        call = None if value is None else as_behaviour(value, node.value.span)
        target.overrides.append((instance.monitor, call))
    else:
        target.properties[name] = value


def _override_own(ev: Evaluator, target: Actor, node: nodes.With, instance: Instance) -> None:
    """Override a property of the file's own: reads during the run see the value of the running scenario."""
    name = node.property
    if name in ev.facts.attributes_set:
        raise OVERRIDDEN_AND_SET.mistake(node.property_span, name=name)
    value = of_same_dimension(name, target.properties[name], ev.evaluate(node.value), node.value.span)
    target.overridden.setdefault(name, []).append((instance.monitor, value))


def _check_can_change(ev: Evaluator, node: nodes.With, instance: Instance) -> None:
    name = node.property
    if name == "speed":
        reason, cure = "how fast it is follows from what it does", "override its behavior"
        raise CANNOT_OVERRIDE.mistake(node.property_span, name=name, here="", reason=reason, cure=cure)
    if name in SETTLED:
        reason, cure = "it is used only before the run", "set it where the object is made"
        raise CANNOT_OVERRIDE.mistake(node.property_span, name=name, here="", reason=reason, cure=cure)
    if name not in ("behavior", *IGNORED) and instance is not ev.run.root:
        raise CANNOT_OVERRIDE.mistake(
            node.property_span,
            name=name,
            here="by a scenario that another one starts",
            reason="it is the same from the first sample to the last",
            cure="set it where the object is made; only `behavior` can change during the run",
        )
