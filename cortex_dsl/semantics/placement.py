"""Statements in the wrong place: `take` at the top level, `param` in a behaviour, `break` outside a loop."""

from dataclasses import dataclass, replace

from cortex_dsl.semantics import errors
from cortex_dsl.semantics.findings import Findings
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

TOP_LEVEL: dict[type, str] = {
    nodes.Map: "map",
    nodes.Simulation: "simulation",
    nodes.Model: "model",
    nodes.Param: "param",
    nodes.Require: "require",
    nodes.TerminateWhen: "terminate when",
    nodes.TerminateAfter: "terminate after",
    nodes.BehaviorDefinition: "behavior",
}

INSIDE: dict[type, str] = {
    nodes.Do: "do",
    nodes.Take: "take",
    nodes.Wait: "wait",
    nodes.Try: "try",
    nodes.Abort: "abort",
    nodes.Terminate: "terminate",
    nodes.If: "if",
    nodes.While: "while",
    nodes.Break: "break",
    nodes.Continue: "continue",
    nodes.Return: "return",
}


@dataclass(frozen=True)
class _Around:
    """What a statement stands in."""

    behaviour: bool = False
    loop: bool = False
    attempt: bool = False


def check_placement(module: nodes.Module, findings: Findings) -> None:
    for statement in module.statements:
        _check(statement, _Around(), findings)


def _check(statement: nodes.Statement, around: _Around, findings: Findings) -> None:
    kind = type(statement)
    if around.behaviour and kind in TOP_LEVEL:
        _report(findings, statement, TOP_LEVEL[kind], "in a behavior", "at the top level")
    elif not around.behaviour and kind in INSIDE:
        _report(findings, statement, INSIDE[kind], "at the top level", "in a behavior")
    elif kind in (nodes.Break, nodes.Continue) and not around.loop:
        _report(findings, statement, INSIDE[kind], "outside a loop", "in a `while`")
    elif kind is nodes.Abort and not around.attempt:
        _report(findings, statement, "abort", "outside a `try`", "in a `try` or its handlers")
    else:
        _check_inside(statement, around, findings)


def _check_inside(statement: nodes.Statement, around: _Around, findings: Findings) -> None:
    match statement:
        case nodes.BehaviorDefinition(body=body):
            _check_all(body, _Around(behaviour=True), findings)
        case nodes.While(body=body):
            _check_all(body, replace(around, loop=True), findings)
        case nodes.If(branches=branches, otherwise=otherwise):
            for _, body in branches:
                _check_all(body, around, findings)
            _check_all(otherwise, around, findings)
        case nodes.Try(body=body, handlers=handlers):
            for block in (body, *(handler.body for handler in handlers)):
                _check_all(block, replace(around, attempt=True), findings)


def _check_all(statements: tuple[nodes.Statement, ...], around: _Around, findings: Findings) -> None:
    for statement in statements:
        _check(statement, around, findings)


def _report(findings: Findings, statement: nodes.Statement, word: str, here: str, there: str) -> None:
    span = Span(statement.span.start, statement.span.start + len(word))
    findings.add(errors.STATEMENT_PLACE.at(span, statement=word, here=here, there=there))
