"""The cells of a table, CSV or Parquet, as columns of numbers and texts. An error names the place of the cell.

Files of Parquet are opened by `parquet`.
"""

import csv
import math
import re
import sys
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, TextIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from engine.errors import InterchangeError, cited, quoted
from engine.interchange.tables.columns import (
    DATES,
    NO_NAMES,
    SLIDES,
    TEXTS,
    UNITS,
    Cells,
    Chosen,
    Column,
    check_complete,
    choose,
)
from engine.interchange.tables.conventions import applied, frame_rate, refuse_meta
from engine.interchange.tables.layouts import Layout, layout_of
from engine.interchange.tables.notation import DECIMAL_COMMA, WrittenRows, assumed_unit, begin_of, separator_of
from engine.interchange.tables.parquet import ParquetFile
from engine.tables import Floats

MOST_ROWS = 3_000_000
"""Maximum number of rows; an hour at 25 samples per second with 30 actors at a time has fewer."""
LONGEST_LINE = 100_000
LONGEST_TEXT = 10_000
"""Letters of a name or a type."""
LARGEST = 1e9
"""Largest position or speed of a real file, in its own unit."""
LATEST = 1e19
"""Largest time: times may count from 1970, in nanoseconds."""
WHOLE = re.compile(r"\s*[+-]?\d{1,19}\s*", re.ASCII)
LARGEST_WHOLE = 9e18
"""Largest whole number, of 64 bits."""
MAY_BE_EMPTY = ("z", "heading", "length", "width")
"""Columns in which an empty cell is an unknown value."""


Storage: TypeAlias = "array[float] | array[int] | list[str]"
"""Storage of a column: an array of doubles or of 64-bit integers, or a list of texts."""
OMEGA_WHOLE = ("total_nanos", "idx", "type", "role", "subtype", SLIDES)


def read_csv_cells(path: Path, rate: float | None = None, named: Mapping[str, str] = NO_NAMES) -> Cells:
    """Return the cells of a CSV file.

    `rate`: samples per second, if the time counts samples and nothing else states it; `named`: as in `choose`.

    Raises:
        InterchangeError: unreadable, not CSV, too many rows, a cell that is not a number, a missing column or file.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _read(file, path, rate, named)
    except UnicodeDecodeError:
        raise InterchangeError("this is not text in UTF-8", "save it as CSV, in UTF-8", path.name) from None
    except csv.Error as error:
        raise InterchangeError(f"this is not CSV: {error}", "save it as CSV, separated by commas", path.name) from None


def _read(file: TextIO, path: Path, rate: float | None, named: Mapping[str, str]) -> Cells:
    name = path.name
    lines, skipped = begin_of(_short_lines(file, name))
    first = next(lines)
    separator, lines = separator_of(first), chain([first], lines)
    spaced = separator == " "
    lines = map(str.strip, lines) if spaced else lines
    rows = csv.reader(lines, strict=True, delimiter=separator, skipinitialspace=spaced)
    header = next(rows, None)
    if header is None or not any(cell.strip() for cell in header):
        raise InterchangeError("the file is empty", "write a line of column names, then rows", name)
    refuse_meta(header, path)
    layout = None if named else layout_of(header)
    place = f"{name}, line {skipped + 1}"
    chosen = choose(header, place, layout, frame_rate(layout, path, rate), named)
    check_complete(chosen, header, place)
    written = WrittenRows(rows, separator, chosen, name, skipped)
    cells = _rows(written, header, skipped, layout, name)
    cells = replace(cells, remarks=(*written.remarks(), *cells.remarks))
    return cells if layout is None else applied(cells, layout, path)


def _rows(rows: WrittenRows, header: Sequence[str], skipped: int, layout: Layout | None, name: str) -> Cells:
    """Return all rows under the header, without those of a known tool that name no actor: empty instants."""
    chosen = rows.chosen
    actor = -1 if layout is None else chosen.columns["actor"].index
    gathered: dict[str, Any] = {key: _storage(key, chosen) for key in chosen.columns}
    lines = array("q")
    for row in rows:
        if not row or (len(row) == 1 and not row[0].strip()):
            continue
        if 0 <= actor < len(row) and not row[actor].strip():
            continue
        place = f"{name}, line {rows.line_num + skipped}"
        if len(lines) >= MOST_ROWS:
            raise InterchangeError(f"there are more than {MOST_ROWS:,} rows", "leave out actors or samples", place)
        if len(row) != len(header):
            _wrong_length(row, header, rows.separator, place)
        for key, column in chosen.columns.items():
            gathered[key].append(_value(row[column.index], key, column, chosen, place))
        lines.append(rows.line_num + skipped)
    return _cells(name, chosen, gathered, lines)


def _short_lines(file: TextIO, name: str) -> Iterator[str]:
    while line := file.readline(LONGEST_LINE):
        if len(line) >= LONGEST_LINE:
            raise InterchangeError(f"a line has {LONGEST_LINE:,} letters or more", "name a table of trajectories", name)
        if "\0" in line:
            raise InterchangeError("this is not text: it holds zero bytes", "save it as CSV, in UTF-8", name)
        yield line


def _storage(key: str, chosen: Chosen) -> Storage:
    """Return the storage of a column."""
    if chosen.omega_prime and key in OMEGA_WHOLE:
        return array("q")
    return [] if key in TEXTS else array("d")


def _cells(name: str, chosen: Chosen, gathered: Mapping[str, Storage], lines: Sequence[int]) -> Cells:
    if not lines:
        raise InterchangeError("there are no rows under its column names", "write one for each actor and time", name)
    arrays: dict[str, NDArray[Any]] = {
        key: np.array(values) for key, values in gathered.items() if isinstance(values, array)
    }
    numbers: dict[str, Floats] = {key: values for key, values in arrays.items() if values.dtype.kind == "f"}
    begin, columns, remarks = 0.0, dict(chosen.columns), list[str]()
    if "time" in numbers:
        time = columns["time"]
        if not time.unit and (unit := assumed_unit(numbers["time"])):
            columns["time"] = time = replace(time, factor=UNITS["time"][unit], unit=unit)
            remarks.append(f"{cited(time.name)} counts {unit}, by its size; `{time.name} [{unit}]` states it")
        numbers["time"], begin = _from_first(numbers["time"], time.factor)
    return Cells(
        file=name,
        numbers=numbers,
        texts={key: values for key, values in gathered.items() if isinstance(values, list)},
        whole={key: values for key, values in arrays.items() if values.dtype.kind == "i"},
        lines=lines,
        columns=columns,
        omega_prime=chosen.omega_prime,
        begin=begin,
        unread=chosen.unread,
        remarks=tuple(remarks),
    )


def gathered_cells(
    name: str,
    chosen: Chosen,
    numbers: Mapping[str, Sequence[float]],
    texts: Mapping[str, list[str]],
    lines: Sequence[int],
) -> Cells:
    """Return the cells of a log from gathered columns; SI units."""
    return _cells(name, chosen, {**{key: array("d", values) for key, values in numbers.items()}, **texts}, lines)


def _from_first(times: Floats, factor: float) -> tuple[Floats, float]:
    """Return seconds from the first time, and the first time [s]; `times` are as written, in units of `factor`.

    The difference of large numbers has noise in its last digits, so it is rounded to their precision.
    """
    first, largest = float(times.min()), float(np.abs(times).max())
    digits = max(0, math.floor(-math.log10(np.spacing(largest)))) if largest else 0
    return (times - first if first == 0.0 else np.round(times - first, digits)) * factor, first * factor


def _value(text: str, key: str, column: Column, chosen: Chosen, place: str) -> float | int | str:
    if chosen.omega_prime and key in OMEGA_WHOLE:
        if not WHOLE.fullmatch(text) or abs(int(text)) > LARGEST_WHOLE:
            raise _bad(text, "a whole number", column, place)
        return int(text)
    if key in TEXTS:
        return _text(text, key, column, place)
    if key in MAY_BE_EMPTY and not chosen.omega_prime and not text.strip():
        return math.nan
    try:
        value = float(text)
    except ValueError:
        raise _bad(text, "a number", column, place) from None
    if not abs(value) <= _largest(key) or "_" in text:
        raise _bad(text, "a number that can be", column, place)
    return value if key == "time" else value * column.factor


def _text(text: str, key: str, column: Column, place: str) -> str:
    """Return a name, or a type."""
    cut = text.strip()
    if not cut and key == "actor":
        raise _bad(text, "the name of an actor", column, place)
    if len(cut) > LONGEST_TEXT:
        raise _bad(cut, f"at most {LONGEST_TEXT:,} letters", column, place)
    return sys.intern(cut)  # each once, however many rows hold it


def _largest(key: str) -> float:
    """Return the limit in the column's own unit."""
    return LATEST if key == "time" else LARGEST


def _bad(text: str, wanted: str, column: Column, place: str) -> InterchangeError:
    cure = (
        "write a point in numbers, not a comma" if DECIMAL_COMMA.fullmatch(text) else "correct it or leave out the row"
    )
    said = quoted(text) if text.strip() else "nothing"
    return InterchangeError(f"it should hold {wanted}, and holds {said}", cure, f"{place}, column `{column.name}`")


def _wrong_length(row: Sequence[str], header: Sequence[str], separator: str, place: str) -> None:
    cure = "write all of its cells, or leave it out"
    if len(row) > len(header):
        cure = "quote names with spaces" if separator == " " else "write a point in numbers, not a comma"
    raise InterchangeError(f"{len(row)} cells stand under {len(header)} column names", cure, place)


# -- cells of Parquet --------------------------------------------------------------------------------------------------


def read_parquet_cells(path: Path, rate: float | None = None, named: Mapping[str, str] = NO_NAMES) -> Cells:
    """Return the cells of a Parquet file, as `read_csv_cells`.

    Raises:
        InterchangeError: pyarrow is not installed; not Parquet, too many rows, a cell that is not a number, …
    """
    file = ParquetFile(path)
    if file.rows > MOST_ROWS:
        message = f"there are {file.rows:,} rows, more than {MOST_ROWS:,}"
        raise InterchangeError(message, "leave out actors or samples", path.name)
    layout = None if named else layout_of(file.header)
    chosen = choose(file.header, path.name, layout, frame_rate(layout, path, rate), named)
    if "time" in chosen.columns and file.is_dated(chosen.columns["time"].name):
        time = replace(chosen.columns["time"], factor=1e-9, unit=DATES)
        chosen = replace(chosen, columns={**chosen.columns, "time": time})
    check_complete(chosen, file.header, path.name)
    gathered = {key: _stored(file, key, column, chosen) for key, column in chosen.columns.items()}
    cells = _cells(path.name, chosen, gathered, range(1, file.rows + 1))
    if layout is not None:
        return applied(cells, layout, path)
    return replace(cells, known_names=file.names(), host=file.host()) if chosen.omega_prime else cells


def _stored(file: ParquetFile, key: str, column: Column, chosen: Chosen) -> Storage:
    storage = _storage(key, chosen)
    place = f"{file.file}, column `{column.name}`"
    if isinstance(storage, list):
        choices, numbers = file.texts(column.name)
        texts = [_text(text, key, column, f"{file.file}, row {row + 1}") for text, row in choices]
        return [texts[number] for number in numbers.tolist()]
    may_be_empty = key in MAY_BE_EMPTY and not chosen.omega_prime
    values = file.column(column.name, may_be_empty=may_be_empty)
    if values.dtype.kind not in "iuf" or (storage.typecode == "q" and values.dtype.kind == "f"):
        wanted = "whole numbers" if storage.typecode == "q" else "numbers"
        raise InterchangeError(f"it should hold {wanted}, and holds {values.dtype}", "convert the column", place)
    largest = LARGEST_WHOLE if storage.typecode == "q" else _largest(key)
    possible = np.abs(values.astype(np.float64)) <= largest
    wrong = np.flatnonzero(~(possible | np.isnan(values) if may_be_empty else possible))
    if len(wrong):
        message = f"it should hold a number that can be, and holds {values[wrong[0]]}"
        raise InterchangeError(
            message, "correct it or leave out the row", f"{file.file}, row {wrong[0] + 1}, column `{column.name}`"
        )
    if storage.typecode == "q":
        return array("q", values.astype(np.int64).tobytes())
    return array("d", (values.astype(np.float64) * (1.0 if key == "time" else column.factor)).tobytes())
