"""Variable numbers of a maneuver: arithmetic over the parameters of a file.

Written, a formula is an expression of OpenSCENARIO 1.1 or later: `${$EGO_SPEED / 3.6}`. Of functions all versions have
sqrt. 1.3 has max and min, too (ASAM OpenSCENARIO XML 1.3.1, 9.2.1), but ASAM's own checker (asam-qc-openscenarioxml
1.0.0) takes them for errors there, so max(x, 0) is always written as (x + sqrt(x^2)) / 2.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from engine.interchange.xml_writing import decimal

OPERATORS: Mapping[str, tuple[int, Callable[[float, float], float]]] = {
    "+": (1, lambda a, b: a + b),
    "-": (1, lambda a, b: a - b),
    "*": (2, lambda a, b: a * b),
    "/": (2, lambda a, b: a / b if b else math.nan),
}
"""Binding strength and function of each operator."""
FUNCTIONS: Mapping[str, Callable[[float], float]] = {
    "sqrt": lambda a: math.sqrt(a) if a >= 0.0 else math.nan,
    "floor": math.floor,
    "ceil": math.ceil,
    "round": round,
    "square": lambda a: a * a,
    "positive": lambda a: max(a, 0.0),
}
"""Functions of one operand; the last two are not functions of OpenSCENARIO."""
ATOM = 3
DIGITS = 12
"""Decimals of numbers that were added here."""


@dataclass(frozen=True)
class Formula:
    """A number (`number`), a parameter (`name`), or `operator` of operands."""

    operator: str = ""
    operands: tuple["Formula", ...] = ()
    number: float = 0.0
    name: str = ""

    @property
    def plain(self) -> bool:
        """Return True if it depends on no parameter."""
        return not self.parameters()

    def parameters(self) -> frozenset[str]:
        own = frozenset({self.name} if self.name else ())
        return own.union(*(operand.parameters() for operand in self.operands))

    def value(self, parameters: Mapping[str, float]) -> float:
        """Return its value; NaN if it has none."""
        if self.name:
            return parameters[self.name]
        values = [operand.value(parameters) for operand in self.operands]
        if not values:
            return self.number
        if self.operator in FUNCTIONS:
            return float(FUNCTIONS[self.operator](values[0]))
        return OPERATORS[self.operator][1](values[0], values[1])

    def expression(self) -> str:
        """Return an attribute of OpenSCENARIO 1.1 or later: a number, `$NAME`, or `${…}`."""
        text, _ = _written(self)
        return f"${{{text}}}" if self.operands else text


def number(value: float) -> Formula:
    return Formula(number=float(value))


def parameter(name: str) -> Formula:
    return Formula(name=name)


ZERO = number(0.0)


def add(one: Formula, other: Formula) -> Formula:
    """Return a sum without brackets, with adjacent numbers added."""
    if other.operator == "+":
        return add(add(one, other.operands[0]), other.operands[1])
    if other.operator == "-":
        return subtract(add(one, other.operands[0]), other.operands[1])
    if _is_number(other):
        return _shifted(one, other.number)
    return other if one == ZERO else _combined("+", one, other)


def subtract(one: Formula, other: Formula) -> Formula:
    if other.operator == "+":
        return subtract(subtract(one, other.operands[0]), other.operands[1])
    if other.operator == "-":
        return add(subtract(one, other.operands[0]), other.operands[1])
    return _shifted(one, -other.number) if _is_number(other) else _combined("-", one, other)


def _shifted(formula: Formula, by: float) -> Formula:
    """Return the formula plus a number, which is added to the first number of a sum that begins with one."""
    if by == 0.0:
        return formula
    if _is_number(formula):
        return number(round(formula.number + by, DIGITS))
    if formula.operator in ("+", "-"):
        first, second = formula.operands
        if _is_number(second):
            return _shifted(first, (second.number if formula.operator == "+" else -second.number) + by)
        if _first(formula) is not None:
            return _combined(formula.operator, _shifted(first, by), second)
    return _combined("+", formula, number(by)) if by > 0.0 else _combined("-", formula, number(-by))


def _first(formula: Formula) -> Formula | None:
    """Return the number at the beginning of a sum, or None."""
    while formula.operator in ("+", "-"):
        formula = formula.operands[0]
    return formula if _is_number(formula) else None


def _is_number(formula: Formula) -> bool:
    return not formula.operands and not formula.name


def multiply(one: Formula, other: Formula) -> Formula:
    if one == number(1.0):
        return other
    return one if other == number(1.0) else _combined("*", one, other)


def divide(one: Formula, other: Formula) -> Formula:
    return one if other == number(1.0) else _combined("/", one, other)


def scaled(formula: Formula, scale: float) -> Formula:
    """Return `formula * scale`, as a quotient if that is the shorter text: km/h become m/s by / 3.6."""
    inverse = round(1.0 / scale, 12) if scale else math.inf
    if abs(inverse * scale - 1.0) < 1e-15 and len(repr(inverse)) < len(repr(scale)):
        return divide(formula, number(inverse))
    return multiply(formula, number(scale))


def positive(formula: Formula) -> Formula:
    """Return max(formula, 0)."""
    return _combined("positive", formula)


def applied(function: str, formula: Formula) -> Formula:
    """Return the formula under a function of `FUNCTIONS`."""
    return _combined(function, formula)


def least(one: Formula, other: Formula) -> Formula:
    if one == other:
        return one
    return _folded(subtract(one, positive(subtract(one, other))))


def most(one: Formula, other: Formula) -> Formula:
    if one == other:
        return one
    return _folded(add(one, positive(subtract(other, one))))


def square(formula: Formula) -> Formula:
    return _combined("square", formula)


def _combined(operator: str, *operands: Formula) -> Formula:
    return _folded(Formula(operator, operands))


def _folded(formula: Formula) -> Formula:
    return number(formula.value({})) if formula.plain else formula


# -- text -------------------------------------------------------------------------------------------------------------


def _written(formula: Formula) -> tuple[str, int]:
    """Return text and binding strength."""
    if formula.name:
        return f"${formula.name}", ATOM
    if not formula.operands:
        return decimal(formula.number), ATOM if formula.number >= 0.0 else 0
    if formula.operator in FUNCTIONS:
        return _call(formula.operator, _written(formula.operands[0]))
    strength = OPERATORS[formula.operator][0]
    left, right = (_written(operand) for operand in formula.operands)
    return f"{_inside(left, strength)} {formula.operator} {_inside(right, strength + 1)}", strength


def _call(function: str, inner: tuple[str, int]) -> tuple[str, int]:
    """Return the text of a function; `pow` is not used, as the schema of 1.1.0 allows no comma in an expression."""
    strength = OPERATORS["*"][0]
    square = f"{_inside(inner, strength)} * {_inside(inner, strength + 1)}"
    if function == "square":
        return square, strength
    if function == "positive":
        return f"({inner[0]} + sqrt({square})) / 2", OPERATORS["/"][0]
    return f"{function}({inner[0]})", ATOM


def _inside(part: tuple[str, int], strength: int) -> str:
    text, own = part
    return text if own >= strength else f"({text})"
