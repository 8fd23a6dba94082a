"""Expressions back to text.

Every expression is written with the level of its rule in the grammar, and put into brackets if its context needs a
tighter level.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from enum import IntEnum
from typing import Any

from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.formatted import write_formatted
from cortex_dsl.syntax.literals import write_number, write_string
from cortex_dsl.syntax.words import TEMPORAL_PREFIXES


class Level(IntEnum):
    """How tightly an expression holds together, loosest first; the rules of the grammar in their order."""

    CONDITION = -1
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

_OPERATOR_FIRST = re.compile(
    r"(?:along|can see|deg|implies|intersects|offset (?:along|by)|relative to|seconds|steps)\b"
)

_BINARY_LEVELS = {"+": Level.SUM, "-": Level.SUM} | dict.fromkeys(["*", "/", "//", "%", "@"], Level.TERM)


def write(node: nodes.Expression, least: Level = Level.EXPRESSION) -> str:
    """Return the text of an expression in a context that needs at least this level."""
    text, level = _EXPRESSIONS[type(node)](node)
    return text if level >= least else f"({text})"


def write_value(node: nodes.Expression, least: Level = Level.EXPRESSION) -> str:
    """Text of an expression after a word that is a name where an operator follows: brackets around such a beginning."""
    text = write(node, least)
    return f"({text})" if _OPERATOR_FIRST.match(text) else text


def _write_all(items: Iterable[nodes.Expression]) -> Iterator[str]:
    return (write(item) for item in items)


def _number(node: nodes.Number) -> Written:
    return write_number(node.value) + (f" {node.unit}" if node.unit else ""), Level.QUANTITY


def _with_unit(node: nodes.WithUnit) -> Written:
    return f"{write(node.value, Level.PRIMARY)} {node.unit}", Level.QUANTITY


def _constant(node: nodes.Constant) -> Written:
    return str(node.value), Level.ATOM


def _initial_scenario(_node: nodes.InitialScenario) -> Written:
    return "initial scenario", Level.ATOM


def _name(node: nodes.Name) -> Written:
    return node.id, Level.ATOM


def _attribute(node: nodes.Attribute) -> Written:
    return f"{write(node.value, Level.PRIMARY)}.{node.name}", Level.PRIMARY


def _index(node: nodes.Index) -> Written:
    return f"{write(node.value, Level.PRIMARY)}[{write(node.index)}]", Level.PRIMARY


def _call(node: nodes.Call) -> Written:
    function = write(node.function, Level.PRIMARY)
    if function in TEMPORAL_PREFIXES:
        function = f"({function})"  # or a `require` would read it as the operator
    return f"{function}({write_arguments(node.arguments)})", Level.PRIMARY


def write_arguments(arguments: Iterable[nodes.Argument]) -> str:
    return ", ".join((f"{each.name}=" if each.name else "") + write(each.value) for each in arguments)


def _starred(node: nodes.Starred) -> Written:
    return "*" + write(node.value, Level.RELATION), Level.EXPRESSION


def _list(node: nodes.ListDisplay) -> Written:
    return f"[{', '.join(_write_all(node.items))}]", Level.ATOM


def _tuple(node: nodes.TupleDisplay) -> Written:
    return f"({', '.join(_write_all(node.items))}{',' if len(node.items) == 1 else ''})", Level.ATOM


def _dict(node: nodes.DictDisplay) -> Written:
    entries = (f"{write(key, Level.OR)}: {write(value)}" for key, value in node.entries)
    return "{" + ", ".join(entries) + "}", Level.ATOM


def _comprehension(node: nodes.Comprehension) -> Written:
    clauses = "".join(" " + _for_clause(clause) for clause in node.clauses)
    return f"[{write(node.element, Level.OR)}{clauses}]", Level.ATOM


def _for_clause(node: nodes.ForClause) -> str:
    conditions = "".join(f" if {write(condition, Level.OR)}" for condition in node.conditions)
    return f"for {', '.join(node.targets)} in {write(node.iterable, Level.OR)}{conditions}"


def _lambda(node: nodes.Lambda) -> Written:
    parameters = " " + ", ".join(node.parameters) if node.parameters else ""
    return f"lambda{parameters}: {write(node.body)}", Level.EXPRESSION


def _conditional(node: nodes.Conditional) -> Written:
    then, condition = write(node.then, Level.OR), write(node.condition, Level.OR)
    return f"{then} if {condition} else {write(node.otherwise)}", Level.EXPRESSION


def _bool_op(node: nodes.BoolOp) -> Written:
    level = Level.OR if node.operator == "or" else Level.AND
    return f" {node.operator} ".join(write(each, Level(level + 1)) for each in node.operands), level


def _temporal(node: nodes.Temporal) -> Written:
    """Always, eventually and next take all that follows, so brackets say where it ends."""
    first, *rest = node.operands
    if not rest:
        bare = isinstance(first, nodes.Temporal) and first.operator != "until"
        operand = write(first, Level.CONDITION) if bare else write_value(first, Level.OR)
        return f"{node.operator} {operand}", Level.CONDITION
    return f"{write(first, Level.OR)} {node.operator} {write(rest[0], Level.OR)}", Level.CONDITION


def _unary(node: nodes.Unary) -> Written:
    if node.operator == "not":
        return "not " + write(node.operand, Level.NOT), Level.NOT
    return node.operator + write(node.operand, Level.FACTOR), Level.FACTOR


def _compare(node: nodes.Compare) -> Written:
    rest = "".join(f" {operator} {write(operand, Level.RELATION)}" for operator, operand in node.rest)
    return write(node.first, Level.RELATION) + rest, Level.COMPARISON


def _binary(node: nodes.Binary) -> Written:
    if node.operator == "**":
        return f"{write(node.left, Level.QUANTITY)} ** {write(node.right, Level.FACTOR)}", Level.POWER
    level = _BINARY_LEVELS[node.operator]
    return f"{write(node.left, level)} {node.operator} {write(node.right, Level(level + 1))}", level


def _can_see(node: nodes.CanSee) -> Written:
    return f"{write(node.viewer, Level.RELATION)} can see {write(node.target, Level.DISPLACED)}", Level.RELATION


def _intersects(node: nodes.Intersects) -> Written:
    return f"{write(node.left, Level.RELATION)} intersects {write(node.right, Level.DISPLACED)}", Level.RELATION


def _offset_along(node: nodes.OffsetAlong) -> Written:
    direction, offset = write(node.direction, Level.OFFSET), write(node.offset, Level.OFFSET)
    return f"{write(node.base, Level.DISPLACED)} offset along {direction} by {offset}", Level.DISPLACED


def _offset_by(node: nodes.OffsetBy) -> Written:
    return f"{write(node.base, Level.OFFSET)} offset by {write(node.offset, Level.MEASURE)}", Level.OFFSET


def _relative_to(node: nodes.RelativeTo) -> Written:
    return f"{write(node.value, Level.OFFSET)} relative to {write(node.base, Level.MEASURE)}", Level.OFFSET


def _field_at(node: nodes.FieldAt) -> Written:
    return f"({write(node.field, Level.OFFSET)} at {write(node.place, Level.MEASURE)})", Level.ATOM


def _seen_from(node: nodes.SeenFrom) -> Written:
    link = "of" if node.operator == "distance past" else "from"
    origin = "" if node.origin is None else f" {link} {_measured(node.origin)}"
    return f"{node.operator} {_measured(node.of)}{origin}", Level.MEASURE


def _angle(node: nodes.Angle) -> Written:
    origin = "" if node.origin is None else f" from {_measured(node.origin)}"
    target = "" if node.target is None else f" to {_measured(node.target)}"
    return f"angle{origin}{target}", Level.MEASURE


def _follow(node: nodes.Follow) -> Written:
    origin = "" if node.origin is None else f" from {_measured(node.origin)}"
    direction = write_value(node.direction, Level.SUM)
    return f"follow {direction}{origin} for {_measured(node.distance)}", Level.MEASURE


def _side_of(node: nodes.SideOf) -> Written:
    # In brackets, as after the comma of a `new` it would be a specifier.
    return f"({node.side} of {_measured(node.of)})", Level.ATOM


def _visible_part(node: nodes.VisiblePart) -> Written:
    words = "visible" if node.seen else "not visible"
    if node.viewer is not None:
        return f"({write(node.region, Level.OFFSET)} {words} from {write(node.viewer, Level.MEASURE)})", Level.ATOM
    return f"({words} {write_value(node.region, Level.SUM)})", Level.ATOM


def _slice(node: nodes.Slice) -> Written:
    bounds = [node.start, node.stop, *([] if node.step is None else [node.step])]
    return ":".join("" if each is None else write(each) for each in bounds), Level.EXPRESSION


def _distance(node: nodes.Distance) -> Written:
    words = "minimum distance" if node.between_outlines else "distance"
    origin = "" if node.origin is None else f" from {_measured(node.origin)}"
    return f"{words}{origin} to {_measured(node.target)}", Level.MEASURE


def _relative_heading(node: nodes.RelativeHeading) -> Written:
    origin = "" if node.origin is None else f" from {_measured(node.origin)}"
    return f"relative heading of {_measured(node.of)}{origin}", Level.MEASURE


def _measured(node: nodes.Expression) -> str:
    """An operand before `from` or `to`, where a name `distance` would be read as the operator."""
    text = write(node, Level.SUM)
    return f"({text})" if re.search(r"\bdistance\Z|^(?:deg|intersects)\b", text) else text


def _degrees(node: nodes.Degrees) -> Written:
    plain = isinstance(node.value, nodes.Name | nodes.Attribute | nodes.Index)
    return f"{write(node.value) if plain else f'({write(node.value)})'} deg", Level.TERM


def _new(node: nodes.New) -> Written:
    specifiers = ", ".join(write_specifier(specifier) for specifier in node.specifiers)
    return f"new {node.class_name} {specifiers}".rstrip(), Level.EXPRESSION


_EXPRESSIONS: dict[type[nodes.Expression], Callable[[Any], Written]] = {
    nodes.Number: _number,
    nodes.WithUnit: _with_unit,
    nodes.String: lambda node: (write_string(node.value), Level.ATOM),
    nodes.Formatted: lambda node: (write_formatted(node, lambda value: write(value, Level.OR)), Level.ATOM),
    nodes.Constant: _constant,
    nodes.InitialScenario: _initial_scenario,
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
    nodes.Temporal: _temporal,
    nodes.Unary: _unary,
    nodes.Compare: _compare,
    nodes.Binary: _binary,
    nodes.CanSee: _can_see,
    nodes.Intersects: _intersects,
    nodes.OffsetAlong: _offset_along,
    nodes.OffsetBy: _offset_by,
    nodes.Distance: _distance,
    nodes.RelativeHeading: _relative_heading,
    nodes.SeenFrom: _seen_from,
    nodes.Angle: _angle,
    nodes.Follow: _follow,
    nodes.SideOf: _side_of,
    nodes.VisiblePart: _visible_part,
    nodes.RelativeTo: _relative_to,
    nodes.FieldAt: _field_at,
    nodes.Slice: _slice,
    nodes.Degrees: _degrees,
    nodes.New: _new,
}

# -- specifiers -----------------------------------------------------------------------------------------------------


def write_specifier(node: nodes.Specifier) -> str:
    """Return the text of a specifier; operands never end in a `new`, whose specifiers would absorb the next ones."""
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
            direction = _operand(node.direction) if node.origin is None else _measured(node.direction)
            return f"following {direction}{_tail('from', node.origin)} for {_operand(node.distance)}"
        case nodes.Before():
            word = "after" if isinstance(node, nodes.After) else "before"
            return f"{word} {_operand(node.region)} by {_operand(node.distance)}" + _tail("along", node.trajectory)
        case nodes.Beyond():
            offset = _operand(node.offset) if node.viewer is None else _measured(node.offset)
            return f"beyond {_operand(node.place)} by {offset}" + _tail("from", node.viewer)
        case nodes.Meeting():
            other, place, time = map(_operand, (node.other, node.place, node.time))
            return f"meeting {other} at {place} after {time}{_tail('by', node.way)}"
        case nodes.InSight():
            return ("visible" if node.seen else "not visible") + _tail("from", node.viewer)
        case nodes.ContainedIn():
            return f"contained in {_operand(node.region)}"
        case nodes.Facing(mode="apparent"):
            heading = _operand(node.heading) if node.viewer is None else _measured(node.heading)
            return f"apparently facing {heading}" + _tail("from", node.viewer)
        case nodes.Facing():
            mode = {"": "", "toward": "toward ", "away": "away from "}[node.mode]
            return f"facing {mode}{_operand(node.heading)}"
        case nodes.With():
            return f"with {node.property} {_operand(node.value)}"
    raise AssertionError(f"unknown specifier {node!r}")


def _operand(node: nodes.Expression) -> str:
    """A name that begins like an operator would make `behind`, `facing` and their like a name before it."""
    text = write(node, Level.OR)
    return f"({text})" if re.match(r"(?:deg|intersects)\b|offset$", text) else text


def _tail(word: str, node: nodes.Expression | None) -> str:
    return "" if node is None else f" {word} {_operand(node)}"
