"""Assessed simulations as a campaign stores them: verdict, counts, metrics and risk, one row per simulation.

`to_arrays` turns the rows into flat named columns, for the journal and for result files.
"""

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, Generic, TypeVar

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
    return _each_array(table, lambda array: array[rows])


def concatenate(tables: Sequence[Table]) -> Table:
    """Return one table with the rows of all `tables`, in their order; all have the same type."""
    first = tables[0]
    columns = {}
    for field in fields(first):  # type: ignore[arg-type]
        parts = [getattr(table, field.name) for table in tables]
        columns[field.name] = np.concatenate(parts) if isinstance(parts[0], np.ndarray) else concatenate(parts)
    return type(first)(**columns)


class Rows(Generic[Table]):
    """The rows of blocks that arrive one after the other, in one table that has room for more.

    A row is copied a few times in all, and blocks never lie beside a copy of all others. `table`: rows that are there
    already; in arrays with room behind them (`with_room`) they stay where they are.
    """

    def __init__(self, table: Table | None = None) -> None:
        self._arrays: list[NDArray[Any]] = []
        self._like = table
        if table is not None:
            _each_array(table, lambda array: self._arrays.append(_whole(array)))

    def put(self, block: Table, first: int) -> None:
        """Write the rows of a block from row `first` on; rows before it are not touched."""
        arrays: list[NDArray[Any]] = []
        _each_array(block, arrays.append)
        self._arrays = self._arrays or [array[:0] for array in arrays]
        for number, array in enumerate(arrays):
            last = first + len(array)
            if last > len(self._arrays[number]):
                self._arrays[number] = with_room(self._arrays[number][:first], last + last // 2)
            self._arrays[number][first:last] = array
        self._like = block

    def table(self, count: int) -> Table:
        """Return the first `count` rows, as views; at least one block was put."""
        assert self._like is not None
        arrays = iter(self._arrays)
        return _each_array(self._like, lambda _: next(arrays)[:count])


def _each_array(table: Table, function: Callable[[Any], Any]) -> Table:
    """Return the table with what `function` makes of every array, also of those of its tables."""
    return map_arrays(
        table, lambda value: function(value) if isinstance(value, np.ndarray) else _each_array(value, function)
    )


def with_room(array: NDArray[Any], rows: int) -> NDArray[Any]:
    """Return a copy with room for `rows` rows; memory that nothing is written to costs nothing."""
    larger = np.empty((rows, *array.shape[1:]), dtype=array.dtype)
    larger[: len(array)] = array
    return larger


def _whole(array: NDArray[Any]) -> NDArray[Any]:
    """Return the array whose first rows these are, as far as it differs from them in its length alone."""
    whole = array.base
    if not isinstance(whole, np.ndarray) or whole.ctypes.data != array.ctypes.data:
        return array
    alike = (whole.dtype, whole.strides, whole.shape[1:]) == (array.dtype, array.strides, array.shape[1:])
    return whole if alike and len(whole) >= len(array) else array


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
