"""Estimates of a probability beside the journal of a run, one a method and condition, for whoever reports it later."""

import json
from dataclasses import MISSING, Field, asdict, fields
from pathlib import Path
from typing import Any

from engine.search.estimated import PARAMS, Probability
from engine.search.journal import finite
from engine.search.statistics import Interval
from engine.search.store import StoreError, store_errors

KEPT = "probability.json"


def keep(folder: Path, found: Probability, program_digest: str, seed: int) -> Path:
    """Write an estimate for the program of this digest in place of an earlier one of its kind; its file.

    Raises:
        StoreError: it cannot be written.
    """
    path = folder / KEPT
    rows = {_place(row): row for row in _rows(path) if row.get("program_digest") == program_digest}
    intervals = {name: list(getattr(found, name)) for name in _INTERVALS}
    row = {**asdict(found), **intervals, "seed": seed, "program_digest": program_digest}
    rows[_place(row)] = row
    with store_errors(path):
        text = json.dumps(finite(list(rows.values())), indent=2, allow_nan=False)
        path.write_text(text + "\n", encoding="utf-8")
    return path


def kept(folder: Path, program_digest: str) -> tuple[Probability, ...]:
    """The estimates for the program of this digest in a folder, by method and condition; others are passed over.

    Raises:
        StoreError: the file cannot be read as one of ours.
    """
    rows = [row for row in _rows(folder / KEPT) if row.get("program_digest") == program_digest]
    try:
        return tuple(sorted(map(_probability, rows), key=lambda found: (found.method, found.condition)))
    except (KeyError, TypeError, ValueError) as error:
        raise _damaged(folder / KEPT) from error


def _rows(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise _damaged(path) from error
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise _damaged(path)
    return rows


def _damaged(path: Path) -> StoreError:
    return StoreError(f"`{path}` cannot be read", "remove it; `cortexc probability` of the run writes it again")


def _place(row: dict[str, Any]) -> tuple[Any, Any]:
    return row.get("method"), row.get("condition", PARAMS)


def _probability(row: dict[str, Any]) -> Probability:
    """Of a row; what an earlier version did not write is not known."""
    return Probability(**{field.name: _value(field.name, row[field.name]) for field in _needed(row)})


def _needed(row: dict[str, Any]) -> list[Field[Any]]:
    return [field for field in fields(Probability) if field.default is MISSING or field.name in row]


_TEXTS = ("method", "condition")
_TUPLES = ("levels", "by_partner")
_INTERVALS = ("interval", "avoidable_interval")


def _value(name: str, value: Any) -> Any:
    if name in _TEXTS:
        return str(value)
    if name in _INTERVALS:
        return Interval(*map(_number, value))
    return tuple(map(_number, value)) if name in _TUPLES else _number(value)


def _number(value: Any) -> Any:
    if value is None:
        return float("nan")
    if not isinstance(value, int | float):
        raise TypeError
    return value
