"""The cells of a CSV file as columns of numbers and texts. What a cell cannot be is said with its line and column."""

import csv
import math
import re
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from engine.interchange.errors import InterchangeError, quoted
from engine.interchange.tables.columns import TEXTS, Chosen, Column, check_complete, choose
from engine.interchange.tables.parquet import ParquetFile
from engine.tables import Floats, Ints

MOST_ROWS = 1_000_000
"""A recording of twenty actors over an hour at ten samples a second has fewer."""
LONGEST_LINE = 100_000
LARGEST = 1e9
"""No position or speed of a real file is larger, in its own unit."""
LATEST = 1e13
"""Times may count from 1970, in milliseconds."""
WHOLE = re.compile(r"\s*[+-]?\d{1,19}\s*", re.ASCII)
LARGEST_WHOLE = 9e18
"""Whole numbers are held in 64 bits."""
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+\s*")


@dataclass(frozen=True)
class Cells:
    """What was read: columns by what they are, row-aligned, in SI units."""

    file: str
    numbers: Mapping[str, Floats]
    texts: Mapping[str, Sequence[str]]
    whole: Mapping[str, Ints]
    """Columns of omega-prime that hold whole numbers, int64."""
    lines: Sequence[int]
    """Where each row stands in its file, from 1; of Parquet, the row's number."""
    names: Mapping[str, str]
    """How the file calls each column."""
    omega_prime: bool
    known_names: Sequence[str] = ()
    """Names by idx, where the file tells them."""

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, row: int, column: str = "") -> str:
        """Where a row stands."""
        unit = "row" if self.file.endswith(".parquet") else "line"
        return f"{self.file}, {unit} {self.lines[row]}" + (f", column `{self.names[column]}`" if column else "")


OMEGA_WHOLE = ("total_nanos", "idx", "type", "role", "subtype")


def read_csv_cells(path: Path) -> Cells:
    """Raises InterchangeError: unreadable, no CSV, too many rows, a cell that is no number, a missing column."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _read(file, path.name)
    except UnicodeDecodeError:
        raise InterchangeError("this is not text in UTF-8", "save it as CSV, in UTF-8", path.name) from None
    except csv.Error as error:
        raise InterchangeError(f"this is not CSV: {error}", "save it as CSV, separated by commas", path.name) from None


def _read(file: TextIO, name: str) -> Cells:
    rows = csv.reader(_short_lines(file, name), strict=True)
    header = next(rows, None)
    if header is None or not any(cell.strip() for cell in header):
        raise InterchangeError("the file is empty", "write a line of column names, then rows", name)
    _check_separator(header, name)
    chosen = choose(header, name)
    check_complete(chosen, header, name)
    gathered: dict[str, Any] = {key: _storage(key, chosen) for key in chosen.columns}
    lines = array("q")
    for row in rows:
        if not row or (len(row) == 1 and not row[0].strip()):
            continue
        place = f"{name}, line {rows.line_num}"
        if len(lines) >= MOST_ROWS:
            raise InterchangeError(f"there are more than {MOST_ROWS:,} rows", "leave out actors or samples", place)
        if len(row) != len(header):
            _wrong_length(row, header, place)
        for key, column in chosen.columns.items():
            gathered[key].append(_value(row[column.index], key, column, chosen, place))
        lines.append(rows.line_num)
    return _cells(name, chosen, gathered, lines)


def _short_lines(file: TextIO, name: str) -> Iterator[str]:
    while line := file.readline(LONGEST_LINE):
        if len(line) >= LONGEST_LINE:
            raise InterchangeError(f"a line has {LONGEST_LINE:,} letters or more", "name a table of trajectories", name)
        if "\0" in line:
            raise InterchangeError("this is not text: it holds zero bytes", "save it as CSV, in UTF-8", name)
        yield line


def _storage(key: str, chosen: Chosen) -> Any:
    """Where a column is gathered: an array of doubles or of 64-bit integers, or a list of texts."""
    if chosen.omega_prime and key in OMEGA_WHOLE:
        return array("q")
    return [] if key in TEXTS else array("d")


def _cells(name: str, chosen: Chosen, gathered: Mapping[str, Sequence], lines: Sequence[int]) -> Cells:
    if not lines:
        raise InterchangeError("there are no rows under its column names", "write one for each actor and time", name)
    arrays = {key: values for key, values in gathered.items() if isinstance(values, array)}
    return Cells(
        file=name,
        numbers={key: np.array(values) for key, values in arrays.items() if values.typecode == "d"},
        texts={key: values for key, values in gathered.items() if isinstance(values, list)},
        whole={key: np.array(values) for key, values in arrays.items() if values.typecode == "q"},
        lines=lines,
        names={key: column.name for key, column in chosen.columns.items()},
        omega_prime=chosen.omega_prime,
    )


def _value(text: str, key: str, column: Column, chosen: Chosen, place: str) -> float | int | str:
    if chosen.omega_prime and key in OMEGA_WHOLE:
        if not WHOLE.fullmatch(text) or abs(int(text)) > LARGEST_WHOLE:
            raise _bad(text, "a whole number", column, place)
        return int(text)
    if key in TEXTS:
        if not text.strip() and key == "actor":
            raise _bad(text, "the name of an actor", column, place)
        return text.strip()
    try:
        value = float(text) * column.factor
    except ValueError:
        raise _bad(text, "a number", column, place) from None
    if not math.isfinite(value) or abs(value) > _largest(key, column) or "_" in text:
        raise _bad(text, "a number that can be", column, place)
    return value


def _largest(key: str, column: Column) -> float:
    return (LATEST if key == "time" else LARGEST) * column.factor


def _bad(text: str, wanted: str, column: Column, place: str) -> InterchangeError:
    cure = "write a point in numbers, not a comma" if DECIMAL_COMMA.fullmatch(text) else "mend it, or leave the row out"
    said = quoted(text) if text.strip() else "nothing"
    return InterchangeError(f"it should hold {wanted}, and holds {said}", cure, f"{place}, column `{column.name}`")


def _check_separator(header: Sequence[str], name: str) -> None:
    """Other programs separate columns otherwise, and then write numbers with a comma."""
    for mark, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
        if len(header) <= 2 and any(mark in cell for cell in header):
            cure = "save it separated by commas, with points in its numbers"
            raise InterchangeError(f"its columns are separated by {word}", cure, f"{name}, line 1")


def _wrong_length(row: Sequence[str], header: Sequence[str], place: str) -> None:
    more = len(row) > len(header)
    cure = "write a point in numbers, not a comma" if more else "write all of its cells, or leave it out"
    raise InterchangeError(f"{len(row)} cells stand under {len(header)} column names", cure, place)


# -- Parquet ----------------------------------------------------------------------------------------------------------


def read_parquet_cells(path: Path) -> Cells:
    """The same of a Parquet file.

    Raises:
        InterchangeError: pyarrow is not installed; no Parquet, too many rows, a cell that is no number, …
    """
    file = ParquetFile(path)
    if file.rows > MOST_ROWS:
        message = f"there are {file.rows:,} rows, more than {MOST_ROWS:,}"
        raise InterchangeError(message, "leave out actors or samples", path.name)
    chosen = choose(file.header, path.name)
    check_complete(chosen, file.header, path.name)
    gathered = {key: _stored(file, key, column, chosen) for key, column in chosen.columns.items()}
    cells = _cells(path.name, chosen, gathered, range(1, file.rows + 1))
    return Cells(**{**vars(cells), "known_names": file.names()})


def _stored(file: ParquetFile, key: str, column: Column, chosen: Chosen) -> Any:
    values = file.column(column.name)
    storage = _storage(key, chosen)
    if isinstance(storage, list):
        return [str(value).strip() for value in values.tolist()]
    place = f"{file.file}, column `{column.name}`"
    if values.dtype.kind not in "iuf" or (storage.typecode == "q" and values.dtype.kind == "f"):
        wanted = "whole numbers" if storage.typecode == "q" else "numbers"
        raise InterchangeError(f"it should hold {wanted}, and holds {values.dtype}", "convert the column", place)
    if storage.typecode == "q":
        return array("q", values.astype(np.int64).tobytes())
    scaled = values.astype(np.float64) * column.factor
    wrong = np.flatnonzero(~(np.abs(scaled) <= _largest(key, column)))
    if len(wrong):
        message = f"it should hold a number that can be, and holds {values[wrong[0]]}"
        raise InterchangeError(
            message, "mend it, or leave the row out", f"{file.file}, row {wrong[0] + 1}, column `{column.name}`"
        )
    return array("d", scaled.tobytes())
