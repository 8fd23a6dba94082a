"""Nodes back to text, in one canonical layout: `parse(unparse(module)) == module`.

Every expression is written with the level of its rule in the grammar, and put into brackets where a tighter one is
wanted. Comments are not part of the tree, so they are lost.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from enum import IntEnum
from typing import Any

from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.literals import write_docstring, write_number, write_string
from cortex_dsl.syntax.words import RESERVED

INDENT = "    "
WIDE = 100
"""Columns after which an object's specifiers get lines of their own."""


class Level(IntEnum):
    """How tightly an expression holds together, loosest first; the rules of the grammar in their order."""

    EXPRESSION = 0
    OR = 1
    AND = 2
    NOT = 3
    COMPARISON = 4
    RELATION = 5
    DISPLACED = 6
    OFFSET = 7
    MEASURE = 8
    SUM = 9
    TERM = 10
    FACTOR = 11
    POWER = 12
    QUANTITY = 13
    PRIMARY = 14
    ATOM = 15


Written = tuple[str, Level]

_BINARY_LEVELS = {"+": Level.SUM, "-": Level.SUM} | dict.fromkeys(["*", "/", "//", "%", "@"], Level.TERM)
_STATEMENT_WORD = re.compile(r"(?:abort|behavior|interrupt|map|model|param|simulation|take|terminate|wait)\b")
_NAME = re.compile(r"[^\W\d]\w*\Z")


def unparse(module: nodes.Module) -> str:
    """The text of a module."""
    lines = [write_docstring(module.docstring)] if module.docstring is not None else []
    for statement in module.statements:
        apart = isinstance(statement, nodes.BehaviorDefinition) or (lines and lines[-1].startswith(INDENT))
        lines += [""] if apart and lines else []
        lines += _statement(statement)
    return "\n".join(lines) + "\n" if lines else ""


def unparse_expression(expression: nodes.Expression) -> str:
    """The text of one expression."""
    return _write(expression)


# -- statements -----------------------------------------------------------------------------------------------------


def _statement(statement: nodes.Statement) -> list[str]:
    return _STATEMENTS[type(statement)](statement)


def _block(statements: Iterable[nodes.Statement]) -> list[str]:
    return [INDENT + line if line else line for statement in statements for line in _statement(statement)]


def _map(node: nodes.Map) -> list[str]:
    return [f"map {node.kind}({_arguments(node.arguments)})"]


def _simulation(node: nodes.Simulation) -> list[str]:
    return [f"simulation({_arguments(node.arguments)})"]


def _model(node: nodes.Model) -> list[str]:
    return [f"model {node.name}"]


def _param(node: nodes.Param) -> list[str]:
    return ["param " + ", ".join(f"{_param_name(entry.name)} = {_write(entry.value)}" for entry in node.entries)]


def _param_name(name: str) -> str:
    return name if _NAME.match(name) and name not in RESERVED else write_string(name)


def _assign(node: nodes.Assign) -> list[str]:
    return _value_lines(", ".join(node.targets) + " = ", node.value)


def _augmented_assign(node: nodes.AugmentedAssign) -> list[str]:
    return _value_lines(f"{node.target} {node.operator}= ", node.value)


def _expression_statement(node: nodes.ExpressionStatement) -> list[str]:
    lines = _value_lines("", node.value)
    return [f"({_write(node.value)})"] if _STATEMENT_WORD.match(lines[0]) else lines


def _value_lines(before: str, value: nodes.Expression) -> list[str]:
    """A value after `before`; a long `new` gets one line for each specifier."""
    line = before + _write(value)
    if not isinstance(value, nodes.New) or len(value.specifiers) < 2 or len(line) <= WIDE:
        return [line]
    first, *rest = [_specifier(specifier) for specifier in value.specifiers]
    lines = [f"{before}new {value.class_name} {first}", *(INDENT + text for text in rest)]
    return [text + "," for text in lines[:-1]] + lines[-1:]


def _require(node: nodes.Require) -> list[str]:
    probability = "" if node.probability is None else f"[{_write(node.probability)}]"
    condition = _write(node.condition)
    if condition.startswith("["):
        condition = f"({condition})"  # or it would be read as the probability
    return [f"require{probability} {condition}{_label(node.name)}"]


def _label(name: str | None) -> str:
    return "" if name is None else f" as {write_string(name)}"


def _terminate_when(node: nodes.TerminateWhen) -> list[str]:
    return [f"terminate when {_write(node.condition)}{_label(node.name)}"]


def _terminate_after(node: nodes.TerminateAfter) -> list[str]:
    return [f"terminate after {_duration(node.amount, node.in_steps)}"]


def _duration(amount: nodes.Expression, in_steps: bool) -> str:
    bare = isinstance(amount, nodes.Number) and amount.unit is None
    return _write(amount) + (" steps" if in_steps else " seconds" if bare else "")


def _behavior(node: nodes.BehaviorDefinition) -> list[str]:
    parameters = ", ".join(_parameter(parameter) for parameter in node.parameters)
    docstring = [] if node.docstring is None else [INDENT + write_docstring(node.docstring)]
    return [f"behavior {node.name}({parameters}):", *docstring, *_block(node.body)]


def _parameter(node: nodes.Parameter) -> str:
    return node.name if node.default is None else f"{node.name}={_write(node.default)}"


def _do(node: nodes.Do) -> list[str]:
    text = "do " + _write(node.behavior, Level.OR)
    if node.until is not None:
        return [f"{text} until {_write(node.until)}"]
    return [text if node.duration is None else f"{text} for {_duration(node.duration, node.in_steps)}"]


def _take(node: nodes.Take) -> list[str]:
    return ["take " + ", ".join(_write(action) for action in node.actions)]


def _try(node: nodes.Try) -> list[str]:
    lines = ["try:", *_block(node.body)]
    for handler in node.handlers:
        lines += [f"interrupt when {_write(handler.condition)}:", *_block(handler.body)]
    return lines


def _if(node: nodes.If) -> list[str]:
    lines: list[str] = []
    for condition, body in node.branches:
        lines += [f"{'elif' if lines else 'if'} {_write(condition)}:", *_block(body)]
    return lines + (["else:", *_block(node.otherwise)] if node.otherwise else [])


def _while(node: nodes.While) -> list[str]:
    return [f"while {_write(node.condition)}:", *_block(node.body)]


def _word(word: str) -> Callable[[Any], list[str]]:
    return lambda _node: [word]


_STATEMENTS: dict[type[nodes.Statement], Callable[[Any], list[str]]] = {
    nodes.Map: _map,
    nodes.Simulation: _simulation,
    nodes.Model: _model,
    nodes.Param: _param,
    nodes.Assign: _assign,
    nodes.AugmentedAssign: _augmented_assign,
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
    nodes.Wait: _word("wait"),
    nodes.Abort: _word("abort"),
    nodes.Terminate: _word("terminate"),
    nodes.Break: _word("break"),
    nodes.Continue: _word("continue"),
    nodes.Return: _word("return"),
    nodes.Pass: _word("pass"),
}

# -- expressions ----------------------------------------------------------------------------------------------------


def _write(node: nodes.Expression, least: Level = Level.EXPRESSION) -> str:
    """Text of an expression where one of at least this level is wanted."""
    text, level = _EXPRESSIONS[type(node)](node)
    return text if level >= least else f"({text})"


def _write_all(items: Iterable[nodes.Expression]) -> Iterator[str]:
    return (_write(item) for item in items)


def _number(node: nodes.Number) -> Written:
    return write_number(node.value) + (f" {node.unit}" if node.unit else ""), Level.QUANTITY


def _with_unit(node: nodes.WithUnit) -> Written:
    return f"{_write(node.value, Level.PRIMARY)} {node.unit}", Level.QUANTITY


def _string(node: nodes.String) -> Written:
    return write_string(node.value), Level.ATOM


def _constant(node: nodes.Constant) -> Written:
    return str(node.value), Level.ATOM


def _name(node: nodes.Name) -> Written:
    return node.id, Level.ATOM


def _attribute(node: nodes.Attribute) -> Written:
    return f"{_write(node.value, Level.PRIMARY)}.{node.name}", Level.PRIMARY


def _index(node: nodes.Index) -> Written:
    return f"{_write(node.value, Level.PRIMARY)}[{_write(node.index)}]", Level.PRIMARY


def _call(node: nodes.Call) -> Written:
    return f"{_write(node.function, Level.PRIMARY)}({_arguments(node.arguments)})", Level.PRIMARY


def _arguments(arguments: Iterable[nodes.Argument]) -> str:
    return ", ".join((f"{each.name}=" if each.name else "") + _write(each.value) for each in arguments)


def _starred(node: nodes.Starred) -> Written:
    return "*" + _write(node.value, Level.RELATION), Level.EXPRESSION


def _list(node: nodes.ListDisplay) -> Written:
    return f"[{', '.join(_write_all(node.items))}]", Level.ATOM


def _tuple(node: nodes.TupleDisplay) -> Written:
    return f"({', '.join(_write_all(node.items))}{',' if len(node.items) == 1 else ''})", Level.ATOM


def _dict(node: nodes.DictDisplay) -> Written:
    entries = (f"{_write(key, Level.OR)}: {_write(value)}" for key, value in node.entries)
    return "{" + ", ".join(entries) + "}", Level.ATOM


def _comprehension(node: nodes.Comprehension) -> Written:
    clauses = "".join(" " + _for_clause(clause) for clause in node.clauses)
    return f"[{_write(node.element, Level.OR)}{clauses}]", Level.ATOM


def _for_clause(node: nodes.ForClause) -> str:
    conditions = "".join(f" if {_write(condition, Level.OR)}" for condition in node.conditions)
    return f"for {', '.join(node.targets)} in {_write(node.iterable, Level.OR)}{conditions}"


def _lambda(node: nodes.Lambda) -> Written:
    parameters = " " + ", ".join(node.parameters) if node.parameters else ""
    return f"lambda{parameters}: {_write(node.body)}", Level.EXPRESSION


def _conditional(node: nodes.Conditional) -> Written:
    then, condition = _write(node.then, Level.OR), _write(node.condition, Level.OR)
    return f"{then} if {condition} else {_write(node.otherwise)}", Level.EXPRESSION


def _bool_op(node: nodes.BoolOp) -> Written:
    level = Level.OR if node.operator == "or" else Level.AND
    return f" {node.operator} ".join(_write(each, Level(level + 1)) for each in node.operands), level


def _unary(node: nodes.Unary) -> Written:
    if node.operator == "not":
        return "not " + _write(node.operand, Level.NOT), Level.NOT
    return node.operator + _write(node.operand, Level.FACTOR), Level.FACTOR


def _compare(node: nodes.Compare) -> Written:
    rest = "".join(f" {operator} {_write(operand, Level.RELATION)}" for operator, operand in node.rest)
    return _write(node.first, Level.RELATION) + rest, Level.COMPARISON


def _binary(node: nodes.Binary) -> Written:
    if node.operator == "**":
        return f"{_write(node.left, Level.QUANTITY)} ** {_write(node.right, Level.FACTOR)}", Level.POWER
    level = _BINARY_LEVELS[node.operator]
    return f"{_write(node.left, level)} {node.operator} {_write(node.right, Level(level + 1))}", level


def _can_see(node: nodes.CanSee) -> Written:
    return f"{_write(node.viewer, Level.RELATION)} can see {_write(node.target, Level.DISPLACED)}", Level.RELATION


def _intersects(node: nodes.Intersects) -> Written:
    return f"{_write(node.left, Level.RELATION)} intersects {_write(node.right, Level.DISPLACED)}", Level.RELATION


def _offset_along(node: nodes.OffsetAlong) -> Written:
    direction, offset = _write(node.direction, Level.OFFSET), _write(node.offset, Level.OFFSET)
    return f"{_write(node.base, Level.DISPLACED)} offset along {direction} by {offset}", Level.DISPLACED


def _offset_by(node: nodes.OffsetBy) -> Written:
    return f"{_write(node.base, Level.OFFSET)} offset by {_write(node.offset, Level.MEASURE)}", Level.OFFSET


def _distance(node: nodes.Distance) -> Written:
    words = "minimum distance" if node.between_outlines else "distance"
    origin = "" if node.origin is None else f" from {_measured(node.origin)}"
    return f"{words}{origin} to {_measured(node.target)}", Level.MEASURE


def _relative_heading(node: nodes.RelativeHeading) -> Written:
    origin = "" if node.origin is None else f" from {_measured(node.origin)}"
    return f"relative heading of {_measured(node.of)}{origin}", Level.MEASURE


def _measured(node: nodes.Expression) -> str:
    """An operand before `from` or `to`, where a name `distance` would be read as the operator."""
    text = _write(node, Level.SUM)
    return f"({text})" if re.search(r"\bdistance\Z", text) else text


def _degrees(node: nodes.Degrees) -> Written:
    plain = isinstance(node.value, nodes.Name | nodes.Attribute | nodes.Index)
    return f"{_write(node.value) if plain else f'({_write(node.value)})'} deg", Level.TERM


def _new(node: nodes.New) -> Written:
    specifiers = ", ".join(_specifier(specifier) for specifier in node.specifiers)
    return f"new {node.class_name} {specifiers}".rstrip(), Level.EXPRESSION


_EXPRESSIONS: dict[type[nodes.Expression], Callable[[Any], Written]] = {
    nodes.Number: _number,
    nodes.WithUnit: _with_unit,
    nodes.String: _string,
    nodes.Constant: _constant,
    nodes.Name: _name,
    nodes.Attribute: _attribute,
    nodes.Index: _index,
    nodes.Call: _call,
    nodes.Starred: _starred,
    nodes.ListDisplay: _list,
    nodes.TupleDisplay: _tuple,
    nodes.DictDisplay: _dict,
    nodes.Comprehension: _comprehension,
    nodes.Lambda: _lambda,
    nodes.Conditional: _conditional,
    nodes.BoolOp: _bool_op,
    nodes.Unary: _unary,
    nodes.Compare: _compare,
    nodes.Binary: _binary,
    nodes.CanSee: _can_see,
    nodes.Intersects: _intersects,
    nodes.OffsetAlong: _offset_along,
    nodes.OffsetBy: _offset_by,
    nodes.Distance: _distance,
    nodes.RelativeHeading: _relative_heading,
    nodes.Degrees: _degrees,
    nodes.New: _new,
}

# -- specifiers -----------------------------------------------------------------------------------------------------


def _specifier(node: nodes.Specifier) -> str:
    """Operands never end in a `new`, whose own specifiers would swallow the following ones."""
    match node:
        case nodes.At():
            return f"at {_operand(node.position)}"
        case nodes.InRegion():
            return f"{node.keyword} {_operand(node.region)}"
        case nodes.OffsetBySpecifier():
            return f"offset by {_operand(node.offset)}"
        case nodes.OffsetAlongSpecifier():
            return f"offset along {_operand(node.direction)} by {_operand(node.offset)}"
        case nodes.Beside():
            side = "behind" if node.side == "behind" else f"{node.side} of"
            return f"{side} {_operand(node.reference)}" + _tail("by", node.distance)
        case nodes.Following():
            direction = _measured(node.direction)
            return f"following {direction}{_tail('from', node.origin)} for {_operand(node.distance)}"
        case nodes.Before():
            return f"before {_operand(node.region)} by {_operand(node.distance)}" + _tail("along", node.trajectory)
        case nodes.Facing():
            mode = {"": "", "toward": "toward ", "away": "away from "}[node.mode]
            return f"facing {mode}{_operand(node.heading)}"
        case nodes.With():
            return f"with {node.property} {_operand(node.value)}"
    raise AssertionError(f"unknown specifier {node!r}")


def _operand(node: nodes.Expression) -> str:
    return _write(node, Level.OR)


def _tail(word: str, node: nodes.Expression | None) -> str:
    return "" if node is None else f" {word} {_operand(node)}"
