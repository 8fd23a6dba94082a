"""What is asked of the Python interface, checked: a slip is answered by its name, what was expected, and the cure."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import Any

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.spelling import nearest
from engine.config import SearchConfig

COUNTS = tuple(field.name for field in fields(SearchConfig) if field.type in (int, "int"))


def whole(name: str, value: object, least: int) -> int:
    """A whole number, of Python or of numpy, that is not too small.

    Raises:
        TypeError: it is none.
        ValueError: it is below `least`.
    """
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"{name}: expected a whole number, got {value!r}")
    number = int(value.__index__())  # type: ignore[attr-defined]
    if number < least:
        raise ValueError(f"{name}: expected {least} or more, got {number}")
    return number


def row_of(things: Any, row: int) -> int:
    """A row that there is.

    Raises:
        IndexError: there is none.
    """
    if not -len(things) <= whole("row", row, -len(things)) < len(things):
        raise IndexError(f"row: there is no {row} in {things!r}, whose rows are 0 to {len(things) - 1}")
    return range(len(things))[row]


def kind(name: str, value: object, expected: type, cure: str) -> None:
    """Raises TypeError where a thing is of another kind."""
    if not isinstance(value, expected):
        raise TypeError(f"{name}: expected {expected.__name__}, got {type(value).__name__}; {cure}")


def settings(given: Mapping[str, object]) -> None:
    """Raises TypeError where a search has no such setting, or a count is no number; ValueError where it is too low."""
    known = [field.name for field in fields(SearchConfig)]
    for name, value in given.items():
        if name not in known:
            near = nearest(name, known)
            meant = f"did you mean `{near}`?" if near else f"there are {', '.join(known)}"
            raise TypeError(f"a search has no setting `{name}`; {meant}")
        if name in COUNTS:
            whole(name, value, 0 if name in ("seed", "run", "probes") else 1)


def in_python(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """The same for somebody who fixed a param by a keyword, and knows of no `-p`."""
    return tuple(
        replace(each, message=_words(each.message), reason=_words(each.reason), cure=_words(each.cure))
        for each in diagnostics
    )


def _words(text: str) -> str:
    text = re.sub(r'`-p "(\w+)=([^"`]+)"`', r'`\1="\2"`', text)
    return re.sub(r"`-p (\w+)", r"`\1", text).replace("`-p`", "a keyword")
