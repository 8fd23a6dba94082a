"""Nodes back to text, in one canonical layout: `parse(unparse(module)) == module`.

Comments are not part of the tree, so they are lost.
"""

import re
from collections.abc import Callable, Iterable
from typing import Any

from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.literals import write_docstring, write_string
from cortex_dsl.syntax.unparse_expressions import Level, write, write_arguments, write_specifier, write_value
from cortex_dsl.syntax.words import RESERVED

INDENT = "    "
WIDE = 100
"""Columns after which an object's specifiers get lines of their own."""


_STATEMENT_WORD = re.compile(
    r"(?:abort|behavior|compose|environment|interrupt|invariant|map|model|monitor|mutate|override|param|precondition"
    r"|domain|expect|maximize|minimize|record|scenario|setup|signals|simulation|take|terminate|wait)\b"
)
_APART = (nodes.BehaviorDefinition, nodes.ClassDefinition, nodes.MonitorDefinition, nodes.ScenarioDefinition)
"""Definitions have an empty line before and after them."""
_NAME = re.compile(r"[^\W\d]\w*\Z")


def unparse(module: nodes.Module) -> str:
    """The text of a module."""
    lines = [write_docstring(module.docstring)] if module.docstring is not None else []
    for statement in module.statements:
        apart = isinstance(statement, _APART) or (lines and lines[-1].startswith(INDENT))
        lines += [""] if apart and lines else []
        lines += _statement(statement)
    return "\n".join(lines) + "\n" if lines else ""


# -- statements -----------------------------------------------------------------------------------------------------


def _statement(statement: nodes.Statement) -> list[str]:
    return _STATEMENTS[type(statement)](statement)


def _block(statements: Iterable[nodes.Statement]) -> list[str]:
    return [INDENT + line if line else line for statement in statements for line in _statement(statement)]


def _map(node: nodes.Map) -> list[str]:
    return [f"map {node.kind}({write_arguments(node.arguments)})"]


def _simulation(node: nodes.Simulation) -> list[str]:
    return [f"simulation({write_arguments(node.arguments)})"]


def _model(node: nodes.Model) -> list[str]:
    return [f"model {node.name}"]


def _signals(node: nodes.Signals) -> list[str]:
    return [f"signals({write_arguments(node.arguments)})"]


def _environment(node: nodes.Environment) -> list[str]:
    return [f"environment({write_arguments(node.arguments)})"]


def _import(node: nodes.Import) -> list[str]:
    return [f"import {_path(node)}" + ("" if node.alias is None else f" as {node.alias}")]


def _import_from(node: nodes.ImportFrom) -> list[str]:
    names = ", ".join(each.name + ("" if each.alias is None else f" as {each.alias}") for each in node.names)
    return [f"from {_path(node)} import {names or '*'}"]


def _path(node: nodes.Import | nodes.ImportFrom) -> str:
    return write_string(node.path) if node.quoted else node.path


def _mutate(node: nodes.Mutate) -> list[str]:
    amount = [] if node.amount is None else [f"by {write(node.amount)}"]
    return [" ".join(["mutate", *([", ".join(node.targets)] if node.targets else []), *amount])]


def _override(node: nodes.Override) -> list[str]:
    specifiers = ", ".join(write_specifier(each) for each in node.specifiers)
    return [f"override {write(node.target, Level.PRIMARY)} {specifiers}"]


def _param(node: nodes.Param) -> list[str]:
    return ["param " + ", ".join(f"{_param_name(entry.name)} = {write(entry.value)}" for entry in node.entries)]


def _param_name(name: str) -> str:
    return name if _NAME.match(name) and name not in RESERVED else write_string(name)


def _assign(node: nodes.Assign) -> list[str]:
    return _value_lines(", ".join(node.targets) + " = ", node.value)


def _augmented_assign(node: nodes.AugmentedAssign) -> list[str]:
    return _value_lines(f"{node.target} {node.operator}= ", node.value)


def _set_attribute(node: nodes.SetAttribute) -> list[str]:
    return _value_lines(f"{write(node.target)} {node.operator}= ", node.value)


def _expression_statement(node: nodes.ExpressionStatement) -> list[str]:
    lines = _value_lines("", node.value)
    return [f"({write(node.value)})"] if _STATEMENT_WORD.match(lines[0]) else lines


def _value_lines(before: str, value: nodes.Expression) -> list[str]:
    """A value after `before`; a long `new` gets one line for each specifier."""
    line = before + write(value)
    if not isinstance(value, nodes.New) or len(value.specifiers) < 2 or len(line) <= WIDE:
        return [line]
    first, *rest = [write_specifier(specifier) for specifier in value.specifiers]
    lines = [f"{before}new {value.class_name} {first}", *(INDENT + text for text in rest)]
    return [text + "," for text in lines[:-1]] + lines[-1:]


def _require(node: nodes.Require) -> list[str]:
    probability = "" if node.probability is None else f"[{write(node.probability)}]"
    condition = write(node.condition, Level.CONDITION)
    if condition.startswith("["):
        condition = f"({condition})"  # or it would be read as the probability
    return [f"require{probability} {condition}{_label(node.name)}"]


def _require_monitor(node: nodes.RequireMonitor) -> list[str]:
    return [f"require monitor {write(node.monitor)}{_label(node.name)}"]


def _expect(node: nodes.Expect) -> list[str]:
    return [f"expect {write(node.condition, Level.CONDITION)}{_label(node.name)}"]


def _optimize(node: nodes.Optimize) -> list[str]:
    return [f"{node.sense} {write(node.value)}{_label(node.name)}"]


def _record(node: nodes.Record) -> list[str]:
    value = write_value(node.value) if node.when else write(node.value)
    return [f"record {f'{node.when} ' if node.when else ''}{value}{_label(node.name)}"]


def _domain(node: nodes.Domain) -> list[str]:
    if node.low is None or node.high is None:
        cells = write(node.cells)
    else:
        step, low, high = (write(part, Level.SUM) for part in (node.cells, node.low, node.high))
        cells = f"{step} steps from {low} to {high}"
    return [f"domain {write_string(node.name)} {write(node.value, Level.RELATION)} at {node.when} in {cells}"]


def _label(name: str | None) -> str:
    return "" if name is None else f" as {write_string(name)}"


def _terminate_when(node: nodes.TerminateWhen) -> list[str]:
    words = "terminate simulation when" if node.simulation else "terminate when"
    return [f"{words} {write(node.condition)}{_label(node.name)}"]


def _terminate_after(node: nodes.TerminateAfter) -> list[str]:
    return [f"terminate after {_duration(node.amount, node.in_steps)}"]


def _duration(amount: nodes.Expression, in_steps: bool) -> str:
    bare = isinstance(amount, nodes.Number) and amount.unit is None
    return write(amount) + (" steps" if in_steps else " seconds" if bare else "")


def _terminate(node: nodes.Terminate) -> list[str]:
    return ["terminate simulation" if node.simulation else "terminate"]


def _class(node: nodes.ClassDefinition) -> list[str]:
    base = "" if node.base is None else f"({node.base})"
    lines = [f"{INDENT}{each.name}: {write(each.value)}" for each in node.properties]
    return [f"class {node.name}{base}:", *_documented(node.docstring), *(lines or [INDENT + "pass"])]


def _behavior(node: nodes.BehaviorDefinition) -> list[str]:
    head = f"behavior {node.name}({_parameters(node.parameters)}):"
    return [head, *_documented(node.docstring), *_guards(node), *_block(node.body)]


def _monitor(node: nodes.MonitorDefinition) -> list[str]:
    head = f"monitor {node.name}({_parameters(node.parameters)}):"
    return [head, *_documented(node.docstring), *_block(node.body)]


def _scenario(node: nodes.ScenarioDefinition) -> list[str]:
    head = [f"scenario {node.name}({_parameters(node.parameters)}):", *_documented(node.docstring), *_guards(node)]
    if not node.compose:
        return [*head, *(_block(node.setup) or [INDENT + "pass"])]
    setup = ["setup:", *_block(node.setup)] if node.setup else []
    return [*head, *(INDENT + line for line in (*setup, "compose:", *_block(node.compose)))]


def _documented(docstring: str | None) -> list[str]:
    return [] if docstring is None else [INDENT + write_docstring(docstring)]


def _guards(node: nodes.BehaviorDefinition | nodes.ScenarioDefinition) -> list[str]:
    words = [("precondition", guard) for guard in node.preconditions]
    words += [("invariant", guard) for guard in node.invariants]
    return [f"{INDENT}{word}: {write(guard.condition)}" for word, guard in words]


def _parameters(parameters: Iterable[nodes.Parameter]) -> str:
    return ", ".join(_parameter(parameter) for parameter in parameters)


def _parameter(node: nodes.Parameter) -> str:
    if node.rest:
        return f"*{node.name}"
    return node.name if node.default is None else f"{node.name}={write(node.default)}"


def _do(node: nodes.Do) -> list[str]:
    text = "do " + ", ".join(write(each, Level.OR) for each in node.invocations)
    if node.mode:
        text = f"do {node.mode} " + ", ".join(write_value(each, Level.OR) for each in node.invocations)
    if node.until is not None:
        return [f"{text} until {write(node.until)}"]
    return [text if node.duration is None else f"{text} for {_duration(node.duration, node.in_steps)}"]


def _take(node: nodes.Take) -> list[str]:
    return ["take " + ", ".join(write(action) for action in node.actions)]


def _try(node: nodes.Try) -> list[str]:
    lines = ["try:", *_block(node.body)]
    for handler in node.handlers:
        lines += [f"interrupt when {write(handler.condition)}:", *_block(handler.body)]
    return lines


def _if(node: nodes.If) -> list[str]:
    lines: list[str] = []
    for condition, body in node.branches:
        lines += [f"{'elif' if lines else 'if'} {write(condition)}:", *_block(body)]
    return lines + (["else:", *_block(node.otherwise)] if node.otherwise else [])


def _while(node: nodes.While) -> list[str]:
    return [f"while {write(node.condition)}:", *_block(node.body)]


def _for(node: nodes.For) -> list[str]:
    return [f"for {', '.join(node.targets)} in {write(node.iterable)}:", *_block(node.body)]


def _function(node: nodes.FunctionDefinition) -> list[str]:
    head = f"def {node.name}({_parameters(node.parameters)}):"
    return [head, *_documented(node.docstring), *_block(node.body)]


def _return(node: nodes.Return) -> list[str]:
    return ["return" if node.value is None else f"return {write(node.value)}"]


def _wait(node: nodes.Wait) -> list[str]:
    if node.until is not None:
        return [f"wait until {write(node.until)}"]
    return ["wait" if node.duration is None else f"wait for {_duration(node.duration, node.in_steps)}"]


def _assert(node: nodes.Assert) -> list[str]:
    return [f"assert {write(node.condition)}" + ("" if node.message is None else f", {write(node.message)}")]


def _word(word: str) -> Callable[[Any], list[str]]:
    return lambda _node: [word]


_STATEMENTS: dict[type[nodes.Statement], Callable[[Any], list[str]]] = {
    nodes.Map: _map,
    nodes.Simulation: _simulation,
    nodes.Model: _model,
    nodes.Param: _param,
    nodes.Assign: _assign,
    nodes.AugmentedAssign: _augmented_assign,
    nodes.SetAttribute: _set_attribute,
    nodes.ExpressionStatement: _expression_statement,
    nodes.Require: _require,
    nodes.TerminateWhen: _terminate_when,
    nodes.TerminateAfter: _terminate_after,
    nodes.BehaviorDefinition: _behavior,
    nodes.Do: _do,
    nodes.Take: _take,
    nodes.Try: _try,
    nodes.If: _if,
    nodes.While: _while,
    nodes.Wait: _wait,
    nodes.Assert: _assert,
    nodes.For: _for,
    nodes.FunctionDefinition: _function,
    nodes.Abort: _word("abort"),
    nodes.Terminate: _terminate,
    nodes.Signals: _signals,
    nodes.Environment: _environment,
    nodes.Import: _import,
    nodes.ImportFrom: _import_from,
    nodes.Mutate: _mutate,
    nodes.Override: _override,
    nodes.RequireMonitor: _require_monitor,
    nodes.Expect: _expect,
    nodes.Optimize: _optimize,
    nodes.Record: _record,
    nodes.Domain: _domain,
    nodes.ClassDefinition: _class,
    nodes.MonitorDefinition: _monitor,
    nodes.ScenarioDefinition: _scenario,
    nodes.Break: _word("break"),
    nodes.Continue: _word("continue"),
    nodes.Return: _return,
    nodes.Pass: _word("pass"),
}
