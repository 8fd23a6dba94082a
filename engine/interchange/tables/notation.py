"""Notation of CSV files: separators, comments, decimal commas, times as dates, times without a unit."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from itertools import chain
from types import MappingProxyType
from typing import Protocol

import numpy as np

from engine.errors import InterchangeError, cited, quoted
from engine.interchange.tables.columns import DATES, TEXTS, Chosen, Column
from engine.tables import Floats


class CsvRows(Protocol):
    """A reader of the module `csv`, which names no type."""

    @property
    def line_num(self) -> int: ...
    def __iter__(self) -> Iterator[list[str]]: ...
    def __next__(self) -> list[str]: ...


SEPARATORS: Mapping[str, str] = MappingProxyType({";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"})
"""Separators of columns in tables of other programs."""
PREAMBLE = "Version:"
"""Beginning of the line that esmini writes above its column names."""
COMMENT = "#"
"""Beginning of a line that is not a row."""
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")
SINCE_1970: Mapping[str, float] = MappingProxyType({"ns": 1e17, "us": 1e14, "ms": 1e11})
"""Least number that counts from 1970 in this unit; in seconds, 1e11 is in the year 5138."""
STEPS: Mapping[str, float] = MappingProxyType({"ns": 1e7, "us": 1e4})
"""Least usual step of a time that counts from 0 in this unit: in milliseconds, 1e4 is a row every 10 s."""


def separator_of(header: str) -> str:
    """Return the separator of columns: a comma, unless the line of column names has more of another mark.

    Spaces separate only where there is no other mark: names have spaces, too.
    """
    mark = max((mark for mark in SEPARATORS if mark != " "), key=header.count)
    if header.count(mark) > header.count(","):
        return mark
    return " " if "," not in header and len(header.split()) > 1 else ","


def begin_of(lines: Iterator[str]) -> tuple[Iterator[str], int]:
    """Return the lines from that of column names on, and the number of lines before it.

    Comments go before it. Where no names follow, the last comment has them, as `numpy.savetxt` writes it.
    """
    line, before, comment = next(lines, ""), 0, ""
    if line.startswith(PREAMBLE):
        line, before = next(lines, ""), 1
    while line.startswith(COMMENT) or line.isspace():
        comment = line if line.startswith(COMMENT) else comment
        line, before = next(lines, ""), before + 1
    if comment and any(map(_is_number, re.split(r"[\s,;|]+", line))):
        return chain([comment.lstrip(COMMENT).lstrip(), line], lines), before - 1
    return chain([line], lines), before


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


class WrittenRows:
    """Rows of a CSV, converted to decimal points and to times in seconds.

    Iteration raises InterchangeError for points and commas in one table, or times that are dates in part.
    """

    def __init__(self, rows: CsvRows, separator: str, chosen: Chosen, file: str, skipped: int) -> None:
        self._rows, self._file, self._skipped = rows, file, skipped
        self.separator = separator
        self._cells = max((column.index for column in chosen.columns.values()), default=0)
        self._named = any(column.index == 0 and key in TEXTS for key, column in chosen.columns.items())
        self._first = next((row for row in rows if any(map(str.strip, row)) and not self._is_comment(row)), None)
        self._numbers = {
            column.index: column for key, column in chosen.columns.items() if key not in TEXTS and separator != ","
        }
        self._with_comma = self._with_point = ""
        self._time = chosen.columns.get("time")
        self._dated = self._time is not None and self._first is not None and self._is_dated(self._first, self._time)
        if self._dated and self._time is not None:
            self._numbers.pop(self._time.index, None)
            time = replace(self._time, factor=1.0, unit=DATES)
            chosen = replace(chosen, columns={**chosen.columns, "time": time})
        self.chosen = chosen

    @property
    def line_num(self) -> int:
        """Return the line of the file at which the last row ended."""
        return self._rows.line_num

    def __iter__(self) -> Iterator[list[str]]:
        if self._first is not None:
            yield self._plain(self._first)
        for row in self._rows:
            if not self._is_comment(row):
                yield self._plain(row)

    def remarks(self) -> Iterator[str]:
        """Yield remarks on the notation, after all rows are read."""
        if self.separator != "," and self._with_comma:
            yield f"columns are separated by {SEPARATORS[self.separator]}, and numbers have decimal commas"
        elif self.separator != ",":
            yield f"columns are separated by {SEPARATORS[self.separator]}"
        if self._dated and self._time is not None:
            yield f"{cited(self._time.name)} is written as dates (ISO 8601; without a zone they are UTC)"

    def _is_comment(self, row: list[str]) -> bool:
        """Return True for a line that begins with a mark; an actor may be called so."""
        return bool(row) and row[0].startswith(COMMENT) and not (self._named and len(row) > self._cells)

    def _is_dated(self, row: list[str], time: Column) -> bool:
        return time.index < len(row) and seconds_of_date(row[time.index]) is not None

    def _plain(self, row: list[str]) -> list[str]:
        if self._dated and self._time is not None and self._time.index < len(row):
            row[self._time.index] = self._seconds(row[self._time.index], self._time)
        for index, column in self._numbers.items():
            if index < len(row):
                row[index] = self._with_points(row[index], column)
        return row

    def _seconds(self, text: str, column: Column) -> str:
        seconds = seconds_of_date(text)
        if seconds is None and text.strip():
            message = f"it should hold a date, as its first row does, and holds {quoted(text)}"
            raise InterchangeError(message, "write all times in one way", self._place(column))
        return text if seconds is None else repr(seconds)

    def _with_points(self, text: str, column: Column) -> str:
        comma = DECIMAL_COMMA.fullmatch(text) is not None
        self._with_comma = self._with_comma or (text if comma else "")
        self._with_point = self._with_point or (text if "." in text else "")
        if self._with_comma and self._with_point:
            message = f"there are numbers with a comma ({quoted(self._with_comma)}) and with a point"
            raise InterchangeError(f"{message} ({quoted(self._with_point)})", "use one of them", self._place(column))
        return text.replace(",", ".") if comma else text

    def _place(self, column: Column) -> str:
        return f"{self._file}, line {self.line_num + self._skipped}, column `{column.name}`"


def seconds_of_date(text: str) -> float | None:
    """Return a date of ISO 8601 as seconds since 1970, in UTC unless it has a zone; None for any other text."""
    cut = text.strip()
    if len(cut) < len("2026-11-28") or "-" not in cut[1:] or not cut[0].isdigit():  # not a date, the usual case
        return None
    try:
        date = datetime.fromisoformat(cut)
        return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        return None


def assumed_unit(times: Floats) -> str:
    """Return the unit of times without one, by their size; "" for seconds, from any begin."""
    largest = float(np.abs(times).max())
    if unit := next((unit for unit, least in SINCE_1970.items() if largest >= least), ""):
        return unit
    steps = np.diff(np.unique(times))
    usual = float(np.median(steps)) if len(steps) else 0.0
    return next((unit for unit, least in STEPS.items() if usual > least), "")
