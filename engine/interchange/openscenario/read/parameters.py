"""Substitution of references in a scenario, before it is read: `$name`, `${arithmetic}`, entries of catalogs.

Source: ASAM OpenSCENARIO XML 1.2, user guide, "Parameters" and "Expressions".
"""

import ast
import math
import operator
import re
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from engine.errors import InterchangeError, name_cure, quoted
from engine.xml import NUMBER, Limits, Node, read_xml

NAME = re.compile(r"\$([A-Za-z_]\w*)", re.ASCII)
NOTHING: Mapping[str, str] = MappingProxyType({})
LONGEST = 10_000
"""Maximum length of an expression [letters]; those of maneuver mode (`maneuvers`) have up to a thousand."""
NOT_READ = frozenset({"ObjectController", "AssignControllerAction", "Controller"})
"""Elements that a recording does not use: their references may be missing."""
Scope = ChainMap[str, str]
"""Values by name, innermost first; a chain makes many small scopes within a large scope cheap."""


def _divide(one: float, other: float) -> float:
    return one / other


def _sign(value: float) -> float:
    return math.copysign(1.0, value) if value else 0.0


OPERATORS: Mapping[type[ast.operator], Callable[[float, float], float]] = MappingProxyType(
    {
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: _divide,
        ast.Mod: math.fmod,
    }
)
FUNCTIONS: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {
        "pow": math.pow,
        "sqrt": math.sqrt,
        "abs": abs,
        "min": min,
        "max": max,
        "round": round,
        "floor": math.floor,
        "ceil": math.ceil,
        "sign": _sign,
        "sin": math.sin,
        "cos": math.cos,
        "tan": math.tan,
        "asin": math.asin,
        "acos": math.acos,
        "atan": math.atan,
    }
)


def substituted(node: Node, scope: Scope | None = None, assigned: Mapping[str, str] = NOTHING) -> Node:
    """Return the element with every parameter substituted; `assigned` are values that replace declared values.

    Raises:
        InterchangeError: an undeclared parameter, or a text that is not an expression.
    """
    if node.tag in NOT_READ:
        return node
    scope = ChainMap() if scope is None else scope
    attributes = {name: resolved(text, scope, node) for name, text in node.attributes.items()}
    if (declarations := node.find("ParameterDeclarations")) is not None:
        scope = _declared(declarations, scope, assigned)
    children = [child if child.tag == "ParameterDeclarations" else substituted(child, scope) for child in node.children]
    if attributes == node.attributes and all(a is b for a, b in zip(children, node.children, strict=True)):
        return node
    return replace(node, attributes=attributes, children=children)


def _declared(declarations: Node, scope: Scope, assigned: Mapping[str, str]) -> Scope:
    known = scope.new_child()
    for row in declarations.every("ParameterDeclaration"):
        name = row.text("name").removeprefix("$")  # some writers have a `$` here, against the standard
        known[name] = assigned[name] if name in assigned else resolved(row.text("value"), known, row)
    return known


def resolved(text: str, scope: Mapping[str, str], node: Node) -> str:
    """Return the text of one attribute with its parameter or expression evaluated."""
    if not text.startswith("$"):
        return text
    if text.startswith("${") and text.endswith("}"):
        return repr(_worked_out(text[2:-1], scope, node))
    if NAME.fullmatch(text):
        return _value(text[1:], scope, node)
    return text


def _value(name: str, scope: Mapping[str, str], node: Node) -> str:
    if name not in scope:
        cure = name_cure(name, scope) or "declare it in <ParameterDeclarations>"
        raise node.error(f"there is no parameter `${name[:40]}`", cure)
    return scope[name]


def _worked_out(text: str, scope: Mapping[str, str], node: Node) -> float:
    """Return the value of the inside of `${…}`. Arithmetic is on floats, so that no number grows without bound."""
    wrong = node.error(f"the expression ${{{quoted(text)[1:-1]}}} cannot be evaluated", "write a number")
    values: dict[str, float] = {}

    def parameter(match: re.Match[str]) -> str:
        value = _value(match[1], scope, node)
        if not NUMBER.fullmatch(value):
            raise node.error(f"the parameter `{match[0]}` is {quoted(value)}, no number", "declare it as a number")
        values[f"parameter{len(values)}"] = float(value)
        return f"(parameter{len(values) - 1})"

    if len(text) > LONGEST:
        raise wrong
    try:
        tree = ast.parse(NAME.sub(parameter, text).strip(), mode="eval")
        value = float(_evaluated(tree.body, {**values, "pi": math.pi, "PI": math.pi, "e": math.e}))
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError, MemoryError, KeyError):
        raise wrong from None
    if not math.isfinite(value):
        raise wrong
    return value


def _evaluated(tree: ast.expr, values: Mapping[str, float]) -> float:
    match tree:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case ast.Name(id=name):
            return values[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_evaluated(operand, values)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _evaluated(operand, values)
        case ast.BinOp(left=left, op=op, right=right):
            return OPERATORS[type(op)](_evaluated(left, values), _evaluated(right, values))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            return float(FUNCTIONS[name](*(_evaluated(argument, values) for argument in arguments)))
        case _:
            raise ValueError(tree)


# -- entries of a scenario's catalogs, with their parameters -----------------------------------------------------------

MOST_FILES = 100
"""Maximum number of files in one catalog folder."""


class Catalogs:
    """The catalog files that a scenario's `CatalogLocations` name, read at their first use."""

    def __init__(self, scenario: Node, folder: Path, limits: Limits) -> None:
        self._folders = [
            folder / node.text("path").replace("\\", "/")
            for node in (scenario.find("CatalogLocations") or scenario).walk()
            if node.tag == "Directory"
        ]
        self._limits = limits
        self._read: dict[str, list[Node]] | None = None

    def entry(self, reference: Node) -> Node:
        """Return the element that a `CatalogReference` names, with its parameters assigned.

        Raises:
            InterchangeError: no such catalog or entry; the message names it.
        """
        catalog, entry = reference.text("catalogName"), reference.text("entryName")
        if self._read is None:
            self._read = self._by_name()
        if catalog not in self._read:
            cure = name_cure(catalog, self._read) or "put the catalog there, or write the element in its place"
            raise reference.error(f"the catalog {quoted(catalog)} is not beside the scenario", cure)
        each = (node for found in reversed(self._read[catalog]) for node in found.children)
        rows = {node.attributes.get("name", ""): node for node in each}
        if entry not in rows:
            raise reference.error(
                f"{quoted(catalog)} has no entry {quoted(entry)}", name_cure(entry, rows) or "fill it"
            )
        assignments = reference.find("ParameterAssignments")
        rows_assigned = assignments.every("ParameterAssignment") if assignments else []
        assigned = {row.text("parameterRef").lstrip("$"): row.text("value") for row in rows_assigned}
        return substituted(rows[entry], assigned=assigned)

    def _by_name(self) -> dict[str, list[Node]]:
        """Return all catalogs by name; of entries with equal names in two of them, the first counts."""
        found: dict[str, list[Node]] = {}
        for name, catalog in self._files():
            found.setdefault(name, []).append(catalog)
        return found

    def _files(self) -> Iterator[tuple[str, Node]]:
        """Yield catalogs by name, and by the name of their file, to which some writers refer."""
        for folder in self._folders:
            for path in self._paths(folder):
                root = read_xml(path, "OpenSCENARIO", self._limits)
                if (catalog := root.find("Catalog")) is not None:
                    yield path.stem, catalog
                    yield catalog.text("name"), catalog

    def _paths(self, folder: Path) -> list[Path]:
        try:
            paths = sorted(folder.glob("*.xosc"))
        except (OSError, ValueError):
            return []
        if len(paths) > MOST_FILES:
            raise InterchangeError(
                f"there are {len(paths)} catalogs", f"keep at most {MOST_FILES} in one folder", folder.name
            )
        return paths
