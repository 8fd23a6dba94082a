"""Statements in the wrong place: `take` at the top level, `param` in a behaviour, `break` outside a loop."""

from dataclasses import replace

from cortex_dsl.semantics.errors.names import STATEMENT_PLACE
from cortex_dsl.semantics.errors.problems import Findings
from cortex_dsl.semantics.errors.runs import MONITOR_ACTS, SETTING_IN_SCENARIO
from cortex_dsl.semantics.names.tree import is_timed
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.errors import ATTRIBUTE_CURE, no_target
from engine.frozen import frozen

TOP_LEVEL: dict[type, str] = {
    nodes.Map: "map",
    nodes.Simulation: "simulation",
    nodes.Signals: "signals",
    nodes.Environment: "environment",
    nodes.Model: "model",
    nodes.Param: "param",
    nodes.TerminateWhen: "terminate when",
    nodes.TerminateAfter: "terminate after",
    nodes.RequireMonitor: "require monitor",
    nodes.Expect: "expect",
    nodes.Optimize: "maximize",
    nodes.Record: "record",
    nodes.Domain: "domain",
    nodes.BehaviorDefinition: "behavior",
    nodes.MonitorDefinition: "monitor",
    nodes.ScenarioDefinition: "scenario",
    nodes.ClassDefinition: "class",
    nodes.Import: "import",
    nodes.ImportFrom: "from",
    nodes.Mutate: "mutate",
    nodes.FunctionDefinition: "def",
}

NOT_IN_SETUP: dict[type, str] = {
    nodes.Map: "all objects share one road",
    nodes.Simulation: "it says how the whole file is run",
    nodes.Signals: "the traffic lights belong to the road",
    nodes.Environment: "all objects share one weather",
    nodes.Model: "it is the same for the whole file",
    nodes.Import: "imports are read before anything runs",
    nodes.ImportFrom: "imports are read before anything runs",
    nodes.ScenarioDefinition: "scenarios are shared by all scenarios",
}
"""Statements that a scenario cannot have, and why."""

OF_THE_FILE = ("map", "timestep")
"""Params of Scenic's scripts for the road and the time step."""

INSIDE: dict[type, str] = {
    nodes.Do: "do",
    nodes.Take: "take",
    nodes.Wait: "wait",
    nodes.Try: "try",
    nodes.Abort: "abort",
    nodes.Terminate: "terminate",
}
IN_LOOPS: dict[type, str] = {nodes.Break: "break", nodes.Continue: "continue"}

COMPILED = (
    nodes.Assign, nodes.AugmentedAssign, nodes.ExpressionStatement, nodes.Require, nodes.Assert, nodes.If, nodes.For,
    nodes.While, nodes.Break, nodes.Continue, nodes.Return, nodes.Pass,
)  # fmt: skip
"""Statements that may be in a loop, a branch or a function that the compiler runs."""


CURES = {
    "in a behavior": "write `behavior NAME():` with this line indented below it, and give it to an object: `with "
    "behavior NAME()`",
    "in the `compose` of a scenario": "write `scenario Main():`, below it, indented, `compose:`, and below that, "
    "indented again, this line",
}
"""Cure by the proper place of a statement."""


IN_FUNCTION = "in a function"


@frozen
class _Around:
    """Surroundings of a statement."""

    behaviour: bool = False
    monitor: bool = False
    loop: bool = False
    attempt: bool = False
    setup: bool = False
    compose: bool = False
    compiled: str = ""
    """The loop, branch or function that the compiler runs."""


def check_placement(module: nodes.Module, findings: Findings) -> None:
    scenarios = {s.name for s in module.statements if isinstance(s, nodes.ScenarioDefinition)}
    for statement in module.statements:
        if isinstance(statement, nodes.Do) and _names(statement) & scenarios:
            _report(findings, statement, "do", "at the top level", "in the `compose` of a scenario")
            continue
        _check(statement, _Around(), findings)


def _names(statement: nodes.Do) -> set[str]:
    calls = [each.function if isinstance(each, nodes.Call) else each for each in statement.invocations]
    return {each.id for each in calls if isinstance(each, nodes.Name)}


def _check(statement: nodes.Statement, around: _Around, findings: Findings) -> None:
    kind = type(statement)
    if isinstance(statement, nodes.SetAttribute) and (not around.behaviour or around.compose):
        findings.add(no_target(statement.target.span, ATTRIBUTE_CURE))
    elif around.compiled and (kind not in COMPILED or _speaks_of_time(statement)):
        word = {**TOP_LEVEL, **INSIDE, nodes.Override: "override"}.get(kind, "require")
        outside = f"{'in the setup of a scenario' if kind is nodes.Override else 'at the top level'}, outside of it"
        there = "in a behavior" if kind in INSIDE else outside
        _report(findings, statement, word, around.compiled, there)
    elif kind is nodes.Override and not around.setup:
        here = "in a `compose`" if around.compose else "in a behavior" if around.behaviour else "at the top level"
        _report(findings, statement, "override", here, "in the setup of a scenario")
    elif (around.setup or around.compose) and kind in NOT_IN_SETUP:
        _refuse(findings, statement, TOP_LEVEL[kind], NOT_IN_SETUP[kind])
    elif around.setup and isinstance(statement, nodes.Param) and any(e.name in OF_THE_FILE for e in statement.entries):
        _refuse(findings, statement, "param", "it applies to the whole file")
    elif around.setup and kind in INSIDE:
        _report(findings, statement, INSIDE[kind], "in a setup", "in a behavior or a `compose`")
    elif around.compose and kind in TOP_LEVEL:
        _report(findings, statement, TOP_LEVEL[kind], "in a `compose`", "in the `setup` of a scenario")
    elif around.compose and kind is nodes.Take:
        _report(findings, statement, "take", "in a `compose`", "in a behavior: a scenario drives no object")
    elif around.behaviour and kind in TOP_LEVEL:
        here = "in a monitor" if around.monitor else "in a behavior"
        _report(findings, statement, TOP_LEVEL[kind], here, "at the top level")
    elif around.monitor and isinstance(statement, nodes.Do | nodes.Take):
        findings.add(MONITOR_ACTS.at(statement.span, statement=INSIDE[kind]))
    elif not around.behaviour and kind in INSIDE:
        _report(findings, statement, INSIDE[kind], "at the top level", "in a behavior")
    elif kind in IN_LOOPS and not around.loop:
        _report(findings, statement, IN_LOOPS[kind], "outside a loop", "in a `while` or `for`")
    elif isinstance(statement, nodes.Return) and not around.behaviour and around.compiled != IN_FUNCTION:
        _report(findings, statement, "return", "at the top level", "in a behavior or a function")
    elif isinstance(statement, nodes.Return) and around.behaviour and statement.value is not None:
        _report(findings, statement, "return VALUE", "in a behavior", "in a function")
    elif kind is nodes.Abort and not around.attempt:
        _report(findings, statement, "abort", "outside a `try`", "in a `try` or its handlers")
    else:
        _check_inside(statement, around, findings)


def _check_inside(statement: nodes.Statement, around: _Around, findings: Findings) -> None:
    match statement:
        case nodes.BehaviorDefinition(body=body):
            _check_all(body, _Around(behaviour=True), findings)
        case nodes.MonitorDefinition(body=body):
            _check_all(body, _Around(behaviour=True, monitor=True), findings)
        case nodes.ScenarioDefinition(setup=setup, compose=compose):
            _check_all(setup, _Around(setup=True), findings)
            _check_all(compose, _Around(behaviour=True, compose=True), findings)
        case nodes.FunctionDefinition(body=body):
            _check_all(body, _Around(compiled=IN_FUNCTION), findings)
        case nodes.While(body=body) | nodes.For(body=body):
            _check_all(body, replace(_compiled(around), loop=True), findings)
        case nodes.If(branches=branches, otherwise=otherwise):
            around = _compiled(around)
            for _, body in branches:
                _check_all(body, around, findings)
            _check_all(otherwise, around, findings)
        case nodes.Try(body=body, handlers=handlers):
            for block in (body, *(handler.body for handler in handlers)):
                _check_all(block, replace(around, attempt=True), findings)


def _compiled(around: _Around) -> _Around:
    """Inside a loop or a branch: in a behaviour the run goes through it, elsewhere the compiler."""
    return around if around.behaviour or around.compiled else replace(around, compiled="in a loop or a branch")


def _speaks_of_time(statement: nodes.Statement) -> bool:
    return isinstance(statement, nodes.Require) and is_timed(statement.condition)


def _check_all(statements: tuple[nodes.Statement, ...], around: _Around, findings: Findings) -> None:
    for statement in statements:
        _check(statement, around, findings)


def _refuse(findings: Findings, statement: nodes.Statement, word: str, reason: str) -> None:
    span = Span(statement.span.start, statement.span.start + len(word))
    findings.add(SETTING_IN_SCENARIO.at(span, statement=word, reason=reason))


def _report(findings: Findings, statement: nodes.Statement, word: str, here: str, there: str) -> None:
    word = statement.sense if isinstance(statement, nodes.Optimize) else word
    span = Span(statement.span.start, statement.span.start + len(word))
    cure = CURES.get(there, "move it there, or remove it")
    findings.add(STATEMENT_PLACE.at(span, statement=word, here=here, there=there, cure=cure))
