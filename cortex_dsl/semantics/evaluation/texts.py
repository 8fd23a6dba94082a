"""Texts made of values, numbers made of texts and truths, and classes: `f"{n} cars"`, `str`, `int`, `isinstance`."""

import re
from collections.abc import Mapping

from cortex_dsl.semantics.errors.values import LAYOUT, LONG_TEXT, NO_CLASS, NO_NUMBER_IN_TEXT, WRONG_KIND
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.arguments import Given
from cortex_dsl.semantics.evaluation.functions import Meaning, known_truth
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    BuiltinValue,
    ClassValue,
    Items,
    Pose,
    Quantity,
    Truth,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import NAMED, kind_name, number_text, option_name
from cortex_dsl.semantics.names.properties import CLASSES
from cortex_dsl.semantics.quantities.algebra import ceil, floor, maximum, minimum
from cortex_dsl.semantics.quantities.units import PURE, si_word
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.vocabulary import ActorKind

LONGEST = 10_000
"""Characters of a text that values are written into."""
_WIDE = re.compile(r"\d{4}")


# -- to text ----------------------------------------------------------------------------------------------------------


def formatted(ev: Evaluator, node: nodes.Formatted) -> Value:
    """Return a text with its values inserted; a random value must be a finite choice."""
    return joined_text(ev, [each if isinstance(each, str) else _placed(ev, each) for each in node.parts], node.span)


def joined_text(ev: Evaluator, texts: list[str], span: Span, between: str = "") -> str:
    length = sum(map(len, texts))
    if length > LONGEST:
        raise LONG_TEXT.mistake(span, limit=LONGEST)
    ev.file.budget.copy(span, length)
    return between.join(texts)


def _placed(ev: Evaluator, node: nodes.Placeholder) -> str:
    value = ev.evaluate(node.value)
    if not node.layout:
        return _written(ev, value, node.value.span)
    unit = ""
    known: str | float = ""
    if isinstance(value, Quantity):
        known, unit = ev.constant(value, node.value.span, "a number in a text"), si_word(value.dimension)
    else:
        known = _written(ev, value, node.value.span)
    if _WIDE.search(node.layout) or (laid_out := _laid_out(known, node.layout)) is None:
        kind = kind_name(value)
        raise LAYOUT.mistake(node.span, layout=node.layout, kind=kind)
    return f"{laid_out} {unit}".rstrip() if unit else laid_out


def _laid_out(value: str | float, layout: str) -> str | None:
    """Return a value in Python's format `layout`, whole numbers as `int` if possible; None for a wrong format."""
    whole = isinstance(value, float) and value.is_integer() and abs(value) < 1e16
    for each in (int(value), value) if whole else (value,):
        try:
            return format(each, layout)
        except (ValueError, OverflowError):
            continue
    return None


def _written(ev: Evaluator, value: Value, span: Span) -> str:
    """A value as `print` would show it; a number with its unit."""
    match value:
        case Quantity(dimension=dimension):
            number = number_text(ev.constant(value, span, "a number in a text"))
            return f"{number} {si_word(dimension)}".rstrip()
        case Truth():
            return str(known_truth(ev, value, span, "a truth in a text"))
        case None | str():
            return str(value)
        case Vector():
            x, y = (
                number_text(ev.constant(Quantity(each, None), span, "a place in a text")) for each in (value.x, value.y)
            )
            return f"({x}, {y})"
        case tuple():
            last = "]" if isinstance(value, Items) else ",)" if len(value) == 1 else ")"
            ev.file.budget.spend(span, len(value))
            inner = joined_text(ev, [_written(ev, item, span) for item in value], span, ", ")
            return f"{'[' if last == ']' else '('}{inner}{last}"
        case _ if isinstance(value, NAMED):
            return option_name(value)
    cure = "write its `.name`, or a text of your own"
    raise WRONG_KIND.mistake(span, what="this", expected="something with a text", actual=kind_name(value), cure=cure)


def _str(ev: Evaluator, x: Given, span: Span) -> Value:
    return joined_text(ev, [_written(ev, x.value, x.span)], span)


# -- to numbers -------------------------------------------------------------------------------------------------------


def _int(ev: Evaluator, x: Given, span: Span) -> Value:
    """Towards zero, as in Python."""
    given = _number(ev, x, span, "int")
    dimension = None if given.dimension is None else PURE
    term = numbers.adopt(ev, given, PURE, x.span, "the argument of `int`")
    return Quantity(maximum(floor(term), 0.0) + minimum(ceil(term), 0.0), dimension)


def _float(ev: Evaluator, x: Given, span: Span) -> Value:
    return _number(ev, x, span, "float")


def _number(ev: Evaluator, x: Given, span: Span, name: str) -> Quantity:
    """The argument as a number; a truth is 1 or 0, a text is read as Python reads it."""
    if isinstance(x.value, Truth):
        return Quantity(x.value.expr, None)
    if not isinstance(x.value, str):
        return numbers.quantity(x.value, x.span, f"the argument of `{name}`")
    try:
        read = float(int(x.value)) if name == "int" else float(x.value)
    except (ValueError, OverflowError):
        kind = "whole number" if name == "int" else "number"
        text = f"`{x.value[:40]}`" if x.value.strip() else "a text without anything in it"
        raise NO_NUMBER_IN_TEXT.mistake(x.span, text=text, kind=kind) from None
    return numbers.literal(ev, read, None, span)


# -- classes ----------------------------------------------------------------------------------------------------------


def _isinstance(ev: Evaluator, x: Given, classinfo: Given, _span: Span) -> Value:
    """Return whether x has one of the classes; a random number is an `int` or a `float`, but which is unknown."""
    classes = classinfo.value if isinstance(classinfo.value, tuple) else (classinfo.value,)
    names = {each.name for each in classes if isinstance(each, BuiltinValue)}
    if isinstance(x.value, Quantity) and names >= _NUMBERS:
        return Truth(ev.algebra.truth(True))
    known = [_is_a(ev, x, each, classinfo.span) for each in classes]  # all, to report every wrong class
    return Truth(ev.algebra.truth(any(known)))


def _is_a(ev: Evaluator, x: Given, kind: Value, span: Span) -> bool:
    if isinstance(kind, ClassValue):
        return isinstance(x.value, Actor) and kind in x.value.classes
    if isinstance(kind, BuiltinValue) and kind.name in CLASSES:
        return _is_of(x.value, kind.name)
    if isinstance(kind, BuiltinValue) and (kind.name in _PYTHON or kind.name in _NUMBERS):
        return _is_python(ev, x, kind.name)
    raise NO_CLASS.mistake(span, actual=kind_name(kind))


def _is_of(value: Value, name: str) -> bool:
    """Return whether a value is of a class of the language; each object is an `Object`, which is an oriented point."""
    match value:
        case Actor(kind=kind, builtin=builtin):
            above = name in ("Object", "OrientedPoint", "Point")
            return above or name == builtin or (name == kind.name.capitalize() and kind is not ActorKind.OBSTACLE)
        case Pose():
            return name in ("OrientedPoint", "Point")
        case Vector():
            return name == "Point"
    return False


def _is_python(ev: Evaluator, x: Given, name: str) -> bool:
    """Return whether x has the class of this name: whole numbers are `int`, others `float`."""
    match x.value:
        case Quantity() as number if name in _NUMBERS:
            known = ev.constant(number, x.span, "a number whose class is tested")
            return known.is_integer() == (name == "int")
        case Truth():
            return name == "int"
    return type(x.value) is _PYTHON.get(name)


_NUMBERS = frozenset({"int", "float"})
_PYTHON: Mapping[str, type] = {"str": str, "list": Items, "tuple": tuple}

MEANINGS: Mapping[str, Meaning] = {"str": _str, "int": _int, "float": _float, "isinstance": _isinstance}
