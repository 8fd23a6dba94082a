"""Checks of arguments of Python calls: messages contain name, expectation and value."""

from operator import index
from pathlib import Path
from typing import Any

from engine.errors import ArgumentError, ArgumentKindError, RowError

LEFT_OUT = "leave it out for the default"


def whole(name: str, value: object, least: int) -> int:
    """Return the value if it is a whole number (Python or numpy) of at least `least`.

    Raises:
        ArgumentKindError: it is none.
        ArgumentError: it is below `least`.
    """
    try:
        number = None if isinstance(value, bool) else index(value)  # type: ignore[arg-type]
    except TypeError:  # an array of several has the method, too
        number = None
    if number is None:
        raise ArgumentKindError(f"{name}: expected a whole number, got {value!r}", LEFT_OUT)
    if number < least:
        raise ArgumentError(f"{name}: expected {least} or more, got {number}", LEFT_OUT)
    return number


def row_of(things: Any, row: int) -> int:
    """Return the index of an existing row, counted from 0.

    Raises:
        RowError: there is no such row.
    """
    if not -len(things) <= whole("row", row, -len(things)) < len(things):
        rows = f"its rows are 0 to {len(things) - 1}" if len(things) else "it has none"
        raise RowError(f"row: there is no {row} in {things!r}", rows)
    return range(len(things))[row]


def kind(name: str, value: object, expected: type | tuple[type, ...], cure: str) -> None:
    """Raise ArgumentKindError if a value is of another type than expected."""
    if not isinstance(value, expected):
        kinds = expected if isinstance(expected, tuple) else (expected,)
        wanted = " or ".join(each.__name__ for each in kinds)
        raise ArgumentKindError(f"{name}: expected {wanted}, got {type(value).__name__}", cure)


def path_of(name: str, value: object, cure: str = "name it by its path") -> Path:
    """Return the value as a path, if a file can have it.

    Raises:
        ArgumentKindError: it is none.
        ArgumentError: no file can have this name.
    """
    kind(name, value, (str, Path), cure)
    if "\0" in str(value):
        raise ArgumentError(f"{name}: no file can be called {str(value)!r}", cure)
    return Path(str(value))
