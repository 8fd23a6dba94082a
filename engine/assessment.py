"""Assessed simulations as a campaign stores them: verdict, counts, metrics and risk, one row per simulation.

`to_arrays` and `from_columns` turn the rows into flat named columns, for the journal and for result files, and back.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from engine.outcomes import RESULTS, Assessment, Result
from engine.tables import Bools, Floats, Ints

Table = TypeVar("Table")


Evaluate = Callable[[Floats, Ints], Assessment]
"""(genomes (n, d) in file units, stream keys (n, 6)) -> n rows. Row i depends on row i of both arrays at most."""


def map_arrays(table: Table, function: Callable[[Any], Any]) -> Table:
    """Return a table of the same type in which `function` has replaced every field (array or nested table)."""
    return type(table)(**{field.name: function(getattr(table, field.name)) for field in fields(table)})  # type: ignore[arg-type]


def take(table: Table, rows: Ints | Bools | slice | tuple[Ints, Ints]) -> Table:
    """Return the selected rows of every array; `rows` is an index array, a mask or a slice."""

    def taken(value: Any) -> Any:
        return cast("NDArray[Any]", value)[rows] if isinstance(value, np.ndarray) else take(value, rows)

    return map_arrays(table, taken)


def concatenate(tables: Sequence[Table]) -> Table:
    """Return one table with the rows of all `tables`, in their order; all have the same type."""
    first = tables[0]
    columns = {}
    for field in fields(first):  # type: ignore[arg-type]
        parts = [getattr(table, field.name) for table in tables]
        columns[field.name] = np.concatenate(parts) if isinstance(parts[0], np.ndarray) else concatenate(parts)
    return type(first)(**columns)


# -- flat columns ------------------------------------------------------------------------------------------------------

FLOATS: tuple[Result, ...] = tuple(row for row in RESULTS if row.kind is float)
COLUMNS: tuple[Result, ...] = (
    *(row for row in RESULTS if row.kind is not float and not row.parts),
    *(row for row in RESULTS if row.parts),
    *FLOATS,
)
"""All numbers of a simulation except the counts per requirement: integers, then parts, then floats."""
SCALARS: tuple[str, ...] = tuple(name for row in COLUMNS for name in row.columns)
"""Names of the columns."""


def to_arrays(runs: Assessment) -> dict[str, NDArray[Any]]:
    """Return arrays (n,) of int64 or float64 by the names of `SCALARS`, from arrays (n, …)."""
    columns: dict[str, NDArray[Any]] = {}
    for row in COLUMNS:
        array = getattr(runs, row.name).astype(np.float64 if row.kind is float else np.int64)
        columns |= dict(zip(row.columns, array.T if row.parts else [array], strict=True))
    return columns


def to_columns(runs: Assessment) -> dict[str, list[float | int]]:
    """Return `to_arrays` with a list in place of each array."""
    return {name: array.tolist() for name, array in to_arrays(runs).items()}


def from_columns(columns: Mapping[str, NDArray[Any]], **others: Any) -> Assessment:
    """Return the table of flat columns: inverse of `to_arrays`. `others` are the arrays that are not columns."""
    arrays: dict[str, Any] = dict(others)
    for row in COLUMNS:
        lists = [columns[name] for name in row.columns]
        arrays[row.name] = np.array(lists, dtype=row.dtype).T.copy() if row.parts else np.array(lists[0], row.dtype)
    return Assessment(**arrays)
