"""Conversion of JSON values to the types of a dataclass, with checks."""

import sys
from dataclasses import MISSING, fields, is_dataclass
from types import MappingProxyType, UnionType
from typing import Any, get_args, get_origin, get_type_hints

from engine.errors import Signal

LARGEST = MappingProxyType({int: 2**63 - 1, float: sys.float_info.max})


class ManifestError(Signal, ValueError):
    """The manifest was changed from outside: its content is not that of `make_manifest`."""


def typed(kind: Any, value: Any, place: str) -> Any:
    """Return a JSON value converted to the type of a field."""
    origin, arguments = get_origin(kind), get_args(kind)
    if is_dataclass(kind):
        return _table(kind, _of(dict, "a table", value, place), place)
    if origin is tuple:
        rows = _of(list, "a list", value, place)
        return tuple(typed(arguments[0], each, f"{place}[{i}]") for i, each in enumerate(rows))
    if origin is dict:
        table = _of(dict, "a table", value, place)
        return {name: typed(arguments[1], each, f"{place}.{name}") for name, each in table.items()}
    if origin is UnionType:
        return None if value is None else typed(arguments[0], value, place)
    if kind is Any:
        return value
    return _scalar(kind, value, place)


def _table(kind: Any, value: dict[str, Any], place: str) -> Any:
    prefix = f"{place}." if place else ""
    needed = {each.name for each in fields(kind) if each.default is MISSING and each.default_factory is MISSING}
    hints = get_type_hints(kind)
    for name in sorted(needed - value.keys()):
        raise ManifestError(f"its manifest has no `{prefix}{name}`")
    for name in sorted(value.keys() - hints.keys()):
        raise ManifestError(f"its manifest has `{prefix}{name}`, which there is not")
    return kind(**{name: typed(hints[name], each, f"{prefix}{name}") for name, each in value.items()})


def _scalar(kind: type, value: Any, place: str) -> Any:
    """Return a text, a truth value or a finite number of at most 64 bits; a whole number is accepted for any number."""
    if kind is str or kind is bool:
        return _of(kind, "a text" if kind is str else "true or false", value, place)
    kinds = int if kind is int else (int, float)
    if isinstance(value, bool) or not isinstance(value, kinds) or not abs(value) <= LARGEST[kind]:
        raise ManifestError(f"`{place}` of its manifest must be a {'whole ' if kind is int else ''}number")
    return value


def _of(kind: type, what: str, value: Any, place: str) -> Any:
    if not isinstance(value, kind):
        raise ManifestError(f"`{place}` of its manifest must be {what}")
    return value
