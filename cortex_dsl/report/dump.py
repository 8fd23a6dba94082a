"""Any of the compiler's data as indented lines: one line a leaf, short things on one line, repeats by number."""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np

from cortex_dsl.source import Source, Span

ONE_LINE = 88
"""Maximum number of characters of an expression on one line."""
ROWS = 400
"""Rows of an array that are printed."""
ROAD = "engine.road"
"""Package with a large web of objects, which a dump abbreviates."""
HIDDEN = (Span, Source)
"""Places in the text say nothing here."""


def dump(value: Any) -> str:
    """The dump; walks with a stack of its own, so that no depth is too deep."""
    return "\n".join(_Writer().write(value))


class _Writer:
    """Stores the written expressions, so that a shared expression is written once and then referred to by name."""

    def __init__(self) -> None:
        self.numbers: dict[int, int] = {}
        self.alive: list[Any] = []

    def write(self, value: Any) -> Iterator[str]:
        stack: list[tuple[int, str, Any]] = [(0, "", value)]
        while stack:
            depth, label, item = stack.pop()
            line = _short(item)
            if line is not None and len(line) + 2 * depth + len(label) <= ONE_LINE:
                yield "  " * depth + label + line
                continue
            if id(item) in self.numbers:
                yield "  " * depth + f"{label}see #{self.numbers[id(item)]}"
                continue
            title, children = self._open(item)
            yield "  " * depth + label + title
            stack.extend((depth + 1, name, child) for name, child in reversed(children))

    def _open(self, item: Any) -> tuple[str, list[tuple[str, Any]]]:
        """A title line and labelled children."""
        if isinstance(item, np.ndarray):
            return _array(item)
        if type(item).__module__.startswith(ROAD):
            return f"<{type(item).__name__}>", []
        if isinstance(item, Mapping):
            return "", [(f"{key}: ", child) for key, child in item.items()]
        if is_dataclass(item) or hasattr(item, "_asdict"):
            self.alive.append(item)
            self.numbers[id(item)] = len(self.numbers) + 1
            return f"{type(item).__name__} #{self.numbers[id(item)]}", list(_fields(item))
        if isinstance(item, list | tuple):
            return f"{len(item)} items" if item else "none", [(f"{i}: ", child) for i, child in enumerate(item)]
        text = repr(item) if isinstance(item, str) else f"<{type(item).__name__}>"
        return text if len(text) < 400 else text[:400] + " ...", []


def _fields(item: Any) -> Iterator[tuple[str, Any]]:
    if hasattr(item, "_asdict"):
        yield from ((f"{name}: ", child) for name, child in item._asdict().items())
        return
    for field in fields(item):
        child = getattr(item, field.name)
        if not isinstance(child, HIDDEN):
            yield f"{field.name}: ", child


def _array(array: np.ndarray) -> tuple[str, list[tuple[str, Any]]]:
    rows = [(f"{i}: ", _row(row)) for i, row in enumerate(array[:ROWS])]
    more = f", the first {ROWS} shown" if len(array) > ROWS else ""
    return f"{array.dtype} {'x'.join(map(str, array.shape))}{more}", rows


class _Line(str):
    """Text that is printed as it is."""


def _row(row: Any) -> str:
    return _Line(" ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in np.ravel(row).tolist()))


def _short(value: Any, room: int = ONE_LINE) -> str | None:
    """The value on one line, or None where it is too long or too deep for that."""
    if isinstance(value, _Line):
        return str(value)
    if isinstance(value, Enum):
        return value.name
    if value is None or isinstance(value, bool | int | float | str):
        text = repr(value)
        return text if len(text) <= room else None
    if room < 8 or isinstance(value, np.ndarray):
        return _short_array(value) if isinstance(value, np.ndarray) and value.size <= 8 else None
    if isinstance(value, list | tuple) and not hasattr(value, "_asdict"):
        return _joined("[", ((("", item)) for item in value), "]", room)
    if is_dataclass(value) and not isinstance(value, HIDDEN) and not type(value).__module__.startswith(ROAD):
        return _joined(f"{type(value).__name__}(", ((n.replace(": ", "="), c) for n, c in _fields(value)), ")", room)
    return None


def _short_array(array: np.ndarray) -> str:
    return f"{array.dtype} [{_row(array)}]" if array.ndim < 2 else f"{array.dtype} {array.tolist()}"


def _joined(opening: str, items: Any, closing: str, room: int) -> str | None:
    parts: list[str] = []
    room -= len(opening) + len(closing)
    for name, item in items:
        text = _short(item, room - len(name))
        if text is None:
            return None
        parts.append(name + text)
        room -= len(name) + len(text) + 2
        if room < 0:
            return None
    return opening + ", ".join(parts) + closing
