"""Estimates of a probability beside the journal of a run, one for each method, for whoever reports the run later."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from engine.search.journal import finite
from engine.search.probability import Probability
from engine.search.statistics import Interval
from engine.search.store import StoreError, store_errors

KEPT = "probability.json"


def keep(folder: Path, found: Probability, program_digest: str, seed: int) -> Path:
    """Write an estimate for the program of this digest in place of an earlier one by the same method; its file.

    Raises:
        StoreError: it cannot be written.
    """
    path = folder / KEPT
    rows = {row["method"]: row for row in _rows(path) if row.get("program_digest") == program_digest}
    rows[found.method] = {**asdict(found), "interval": list(found.interval), "seed": seed}
    rows[found.method]["program_digest"] = program_digest
    with store_errors(path):
        text = json.dumps(finite(list(rows.values())), indent=2, allow_nan=False)
        path.write_text(text + "\n", encoding="utf-8")
    return path


def kept(folder: Path, program_digest: str) -> tuple[Probability, ...]:
    """The estimates for the program of this digest that lie in a folder, by name of method; others are passed over.

    Raises:
        StoreError: the file cannot be read as one of ours.
    """
    rows = [row for row in _rows(folder / KEPT) if row.get("program_digest") == program_digest]
    try:
        return tuple(sorted(map(_probability, rows), key=lambda found: found.method))
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


def _probability(row: dict[str, Any]) -> Probability:
    fields = {name: _number(row[name]) for name in Probability.__dataclass_fields__ if name not in _OTHER}
    return Probability(
        method=str(row["method"]),
        interval=Interval(*map(_number, row["interval"])),
        levels=tuple(map(_number, row["levels"])),
        **fields,
    )


_OTHER = ("method", "interval", "levels")


def _number(value: Any) -> Any:
    if value is None:
        return float("nan")
    if not isinstance(value, int | float):
        raise TypeError
    return value
