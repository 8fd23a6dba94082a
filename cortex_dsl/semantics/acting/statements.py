"""The statements of a file's top level and of a scenario's setup, run in order for one variant."""

from collections.abc import Callable, Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import (
    BAD_SETTING,
    BARE_EXPRESSION,
    NEVER_RUNS,
    NO_EFFECT,
    PROBABILITY_RANGE,
    SECOND_EGO,
    UNKNOWN_ARGUMENT,
)
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import CALLED_BEHAVIOUR, MONITOR_USED, NOT_A_MONITOR, SCENARIO_USED
from cortex_dsl.semantics.errors.scene import EGO_NOT_OBJECT, SCENIC_MAP, SCENIC_MODEL
from cortex_dsl.semantics.evaluation import maps, numbers, seeing, signals
from cortex_dsl.semantics.evaluation.arguments import Given, evaluate_each
from cortex_dsl.semantics.evaluation.calls import monitor_call
from cortex_dsl.semantics.evaluation.functions import known_truth, whole_number
from cortex_dsl.semantics.evaluation.genes import param_value
from cortex_dsl.semantics.evaluation.lists import unpack
from cortex_dsl.semantics.evaluation.operators import combine
from cortex_dsl.semantics.evaluation.ranges import in_range
from cortex_dsl.semantics.evaluation.roads import map_line, reasons_for_road
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    POISON,
    Actor,
    BehaviourCall,
    BehaviourValue,
    Effect,
    MonitorCall,
    MonitorValue,
    Quantity,
    ScenarioCall,
    ScenarioValue,
    Value,
)
from cortex_dsl.semantics.model.wording import kind_name, spoken_unit
from cortex_dsl.semantics.names.properties import Domain
from cortex_dsl.semantics.names.tree import SYSTEM, is_timed
from cortex_dsl.semantics.quantities.bounds import closed_value, margin_of, weight_of
from cortex_dsl.semantics.quantities.units import PURE, TIME
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.errors import ArgumentError
from engine.streams import parse_key
from engine.vocabulary import RuleKind

MAP_PARAMS = frozenset({"map", "carla_map", "lgsvl_map", "use2DMap"})
"""Params by which Scenic's scripts name a map file."""
IDLE_PARAMS = frozenset({"weather", "time_step", "timestep", "render", "record", "address", "port", "timeout", "time"})
"""Params that Scenic's simulators read and nothing here does."""
TIME_STEPS = (1e-4, 1.0)
"""Bounds of a time step [s]."""
SETTINGS = ("time_step", "max_time", "max_attempts", "stream", "scenario", SYSTEM, "fair", "late")


# -- names ------------------------------------------------------------------------------------------------------------


def _assign(ev: Evaluator, node: nodes.Assign) -> None:
    with ev.naming(", ".join(node.targets)):
        value = ev.evaluate(node.value)
    for name, item in unpack(node.targets, value, node.span).items():
        _bind(ev, name, item, node.value.span)


def _bind(ev: Evaluator, name: str, value: Value, span: Span) -> None:
    if name == "ego" and not isinstance(value, Actor):
        raise EGO_NOT_OBJECT.mistake(span, actual=kind_name(value))
    if name == "ego" and ev.scope.get("ego", value) is not value and isinstance(ev.scope["ego"], Actor):
        ev.report(SECOND_EGO.at(span))
    ev.scope[name] = value


def _augmented(ev: Evaluator, node: nodes.AugmentedAssign) -> None:
    name = nodes.Name(span=node.span, id=node.target)
    left, right = ev.evaluate_all((name, node.value))
    operation = nodes.Binary(span=node.span, operator=node.operator, left=name, right=node.value)
    _bind(ev, node.target, combine(ev, node.operator, left, right, operation), node.span)


def _expression(ev: Evaluator, node: nodes.ExpressionStatement) -> None:
    value = ev.evaluate(node.value)
    check_called(value, node.span)
    if not isinstance(value, Actor | str | Effect):
        cure = "write `require` in front of it, assign it, or remove the line"
        ev.report(BARE_EXPRESSION.at(node.span, cure=cure))


def check_called(value: Value, span: Span) -> None:
    """Refuse a plain call of a behaviour, monitor or scenario: it would do nothing.

    Raises:
        Mistake: the value is one of these.
    """
    if isinstance(value, BehaviourCall | BehaviourValue):
        name = value.name if isinstance(value, BehaviourCall) else value.node.name
        raise CALLED_BEHAVIOUR.mistake(span, name=name)
    if isinstance(value, MonitorCall | MonitorValue):
        name = value.name if isinstance(value, MonitorCall) else value.node.name
        raise MONITOR_USED.mistake(span, name=name)
    if isinstance(value, ScenarioCall | ScenarioValue):
        name = value.name if isinstance(value, ScenarioCall) else value.node.name
        raise SCENARIO_USED.mistake(span, name=name)


def _param(ev: Evaluator, node: nodes.Param) -> None:
    for entry in node.entries:
        with ev.naming(entry.name):
            value = ev.tolerate(lambda entry=entry: param_value(ev, entry))
        ev.run.params[entry.name] = value
        if entry.name != "map":
            ev.scope[entry.name] = value
        elif maps.read_named(ev, value, entry.span):
            continue
        if entry.name == "timestep" and ev.facts.from_scenic:
            _take_timestep(ev, Given(value, entry.value.span))
        else:
            _note_idle_param(ev, entry)


def _take_timestep(ev: Evaluator, given: Given) -> None:
    """Scenic's simulators step as this param says; `simulation(time_step=...)` comes first."""
    settings, what = ev.file.settings, "`timestep`"
    if given.value is not POISON and (settings.given.time_step is None or (what, given.span) in settings.stated):
        step = known_number(ev, given, Domain(what, TIME, *TIME_STEPS), may_vary=False)
        settings.put(given.span, what, time_step=step)


def _note_idle_param(ev: Evaluator, entry: nodes.ParamEntry) -> None:
    if entry.name == "map":
        road = ev.facts.default_road
        ev.report(SCENIC_MAP.at(entry.span, reason=reasons_for_road(road), road=map_line(road)))
    elif entry.name in MAP_PARAMS and "map" in ev.run.params:
        return  # said of the map itself
    elif entry.name in MAP_PARAMS or entry.name in IDLE_PARAMS:
        reason = (
            "the map is a grid of intersections" if entry.name in MAP_PARAMS else "no part of the simulation reads it"
        )
        ev.report(NO_EFFECT.at(entry.name_span, name=entry.name, reason=reason))


# -- the run ----------------------------------------------------------------------------------------------------------


def _map(ev: Evaluator, node: nodes.Map) -> None:
    maps.lay_out(ev, node)


def _model(ev: Evaluator, node: nodes.Model) -> None:
    ev.report(SCENIC_MODEL.at(node.span))


def _simulation(ev: Evaluator, node: nodes.Simulation) -> None:
    given, _ = evaluate_each(ev, [given for given in node.arguments if given.name != SYSTEM])
    for argument in given:
        try:
            _set(ev, argument)
        except Mistake as mistake:
            ev.report(mistake)


def _set(ev: Evaluator, argument: Given) -> None:
    name = argument.name or ""
    if name not in SETTINGS:
        suggestion = did_you_mean(name, SETTINGS)
        raise UNKNOWN_ARGUMENT.mistake(argument.place, function="simulation", name=name, suggestion=suggestion)
    if name == "scenario":
        _check_text(name, argument)
        return
    if name == "late":
        count = _count(ev, argument, Domain("`late`", PURE, 1.0, 32.0))
        ev.file.settings.check(argument.span, "`late`", count)
        ev.file.settings.late = count
        return
    ev.file.settings.put(argument.span, f"`{name}`", **{name: _setting(ev, name, argument)})


def _setting(ev: Evaluator, name: str, argument: Given) -> float | int | str:
    value, span = argument.value, argument.span
    if name == "fair":
        return known_truth(ev, value, span, "`fair`", may_vary=False)
    if name == "stream":
        return _stream(_check_text(name, argument), span)
    if name == "max_attempts":
        return _count(ev, argument, Domain("`max_attempts`", PURE, 1.0, 1e9))
    low, high = TIME_STEPS if name == "time_step" else (1e-4, 1e5)
    return known_number(ev, argument, Domain(f"`{name}`", TIME, low, high), may_vary=False)


def _count(ev: Evaluator, argument: Given, domain: Domain) -> int:
    """Return a whole number that is a constant of a range."""
    count = whole_number(ev, argument.value, argument.span, domain.name, may_vary=False)
    in_range(ev, ev.algebra.literal(float(count)), domain, argument.span)
    return count


def _check_text(name: str, argument: Given) -> str:
    """The text of a setting; the scenario to run was read before anything else."""
    if not isinstance(argument.value, str):
        actual = kind_name(argument.value)
        raise BAD_SETTING.mistake(argument.span, name=name, expected="text", actual=actual, reason="")
    return argument.value


def _stream(text: str, span: Span) -> str:
    """Return a stream key, as in concrete scenarios."""
    try:
        parse_key(text)
    except ArgumentError as error:
        raise BAD_SETTING.mistake(
            span, name="stream", expected="a stream key", actual=f"`{text[:40]}`", reason=error.message
        ) from None
    return text


def known_number(ev: Evaluator, argument: Given, domain: Domain, *, may_vary: bool) -> float:
    """Return a constant inside its legal range; `may_vary`: variants may differ in it."""
    expr = numbers.adopt(ev, argument.value, domain.dimension, argument.span, domain.name)
    value = ev.constant(Quantity(expr, domain.dimension), argument.span, domain.name, may_vary=may_vary)
    in_range(ev, ev.algebra.literal(value), domain, argument.span)
    return value


def _require(ev: Evaluator, node: nodes.Require) -> None:
    if is_timed(node.condition):
        return  # it speaks of the run
    probability = soft_probability(ev, node.probability)
    condition = numbers.truth(ev, ev.evaluate(node.condition), node.condition.span)
    name = node.name or ev.facts.source.words(node.condition.span)
    margin = margin_of(condition, ev.run.compared)
    unit = spoken_unit(node.condition, condition, margin[1], ev.file.genes.infos)
    ev.run.built.requirements.append(
        ir.Requirement(condition, probability, name, ev.facts.line(node.span), *margin, unit)
    )
    weight = weight_of(condition, ev.truth_of(condition), certain=probability == 1.0)
    ev.file.scene.weights[node.condition.span] = weight.joined(ev.file.scene.weights.get(node.condition.span))


TIME_LIMIT = Domain("the time of `terminate after`", TIME, 1e-4, 1e5)


def soft_probability(ev: Evaluator, node: nodes.Expression | None) -> float:
    """The number in `require[p]`; 1 without."""
    if node is None:
        return 1.0
    expr = numbers.adopt(ev, ev.evaluate(node), PURE, node.span, "a probability")
    value = ev.constant(Quantity(expr, PURE), node.span, "a probability")
    if not 0.0 < value <= 1.0:
        raise PROBABILITY_RANGE.mistake(node.span, actual=f"{value:g}")
    return value


def _terminate_after(ev: Evaluator, node: nodes.TerminateAfter) -> None:
    settings, limit = ev.file.settings, known_limit(ev, node, may_vary=False)
    if node.in_steps:
        settings.check(node.amount.span, TIME_LIMIT.name, limit)
        settings.max_steps = int(limit)
    else:
        settings.put(node.amount.span, TIME_LIMIT.name, max_time=limit)


def known_limit(ev: Evaluator, node: nodes.TerminateAfter, *, may_vary: bool) -> float:
    """Return the time [s] of `terminate after`, or its number of steps, inside its legal range."""
    if not node.in_steps:
        return known_number(ev, Given(ev.evaluate(node.amount), node.amount.span), TIME_LIMIT, may_vary=may_vary)
    steps = whole_number(ev, ev.evaluate(node.amount), node.amount.span, "a number of steps", may_vary=may_vary)
    in_range(ev, ev.algebra.literal(float(steps)), Domain("a number of steps", PURE, 1.0, 1e9), node.amount.span)
    return steps


def terminate_when(ev: Evaluator, node: nodes.TerminateWhen) -> None:
    """A condition over the running simulation; evaluated with everything that the file defines."""
    condition = numbers.truth(ev, ev.evaluate(node.condition), node.condition.span)
    ev.run.built.rule_conditions[node.span, RuleKind.TERMINATE] = condition
    ev.file.run.rule(node.span, node.name or ev.facts.source.words(node.condition.span))
    if closed_value(condition) not in (None, 0.0):
        ev.report(NEVER_RUNS.at(node.condition.span))


NOTHING_GIVEN: tuple[Given, ...] = ()


def required_monitor(ev: Evaluator, node: nodes.RequireMonitor) -> MonitorCall:
    """The monitor that a `require monitor` names, with its arguments.

    Raises:
        Mistake: when it names something else.
    """
    value = ev.evaluate(node.monitor)
    match value:
        case MonitorCall():
            return value
        case MonitorValue():
            return monitor_call(value, NOTHING_GIVEN, node.monitor.span)
    raise NOT_A_MONITOR.mistake(
        node.monitor.span, actual=kind_name(value), cure=_instead_of_monitor(ev, value, node.monitor)
    )


def _instead_of_monitor(ev: Evaluator, value: Value, node: nodes.Expression) -> str:
    monitors = [name for name, known in ev.names.items() if isinstance(known, MonitorValue)]
    name = node.function if isinstance(node, nodes.Call) else node
    if isinstance(name, nodes.Name) and (suggestion := did_you_mean(name.id, monitors)):
        return suggestion
    if isinstance(value, BehaviourCall | BehaviourValue):
        return "give a behavior to an object, `with behavior ...`; what only watches is defined by `monitor`"
    return "define it with `monitor`; a plain condition goes after `require always`"


def require_monitor(ev: Evaluator, node: nodes.RequireMonitor) -> None:
    ev.run.built.required_monitors.append((node.name, required_monitor(ev, node), node.span))


def _nothing(_ev: Evaluator, _node: nodes.Statement) -> None:
    """Do nothing: behaviours are known from the start, rules run at the end, misplaced statements were reported."""


Run = Callable[[Evaluator, nodes.Statement], None]

TOP_LEVEL: Mapping[type, Run] = {
    **dict.fromkeys(
        (
            nodes.BehaviorDefinition,
            nodes.MonitorDefinition,
            nodes.ScenarioDefinition,
            nodes.Override,
            nodes.TerminateWhen,
            nodes.Record,
            nodes.Expect,
            nodes.Optimize,
            nodes.Domain,
            nodes.Do,
            nodes.Take,
            nodes.Wait,
            nodes.Try,
            nodes.Abort,
            nodes.Terminate,
            nodes.Pass,
            nodes.SetAttribute,
        ),
        _nothing,
    ),
    nodes.Assign: _assign,
    nodes.AugmentedAssign: _augmented,
    nodes.ExpressionStatement: _expression,
    nodes.Param: _param,
    nodes.Map: _map,
    nodes.Model: _model,
    nodes.Simulation: _simulation,
    nodes.Signals: signals.set_up,
    nodes.Environment: seeing.set_environment,
    nodes.Require: _require,
    nodes.RequireMonitor: require_monitor,
    nodes.TerminateAfter: _terminate_after,
}  # type: ignore[dict-item]
"""Function that runs each statement except definitions and imports, which `setting_up` runs."""
