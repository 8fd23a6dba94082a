"""Exposure: a CSV file with a weight for each cell of a domain, for failure rates as they occur in traffic.

The head names the coordinates of the cells, and `weight` last: `speed,light,weight` for domains of a file,
`cell,weight` for the cells of a suite, `file,weight` for the files of a comparison.
"""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from cortex_dsl.spelling import nearest
from engine.errors import ArgumentError, UnreadableFileError
from engine.search.store import without_folders

WEIGHT = "weight"


@dataclass(frozen=True)
class Exposure:
    """Weights of cells, as a file gives them."""

    path: Path
    columns: tuple[str, ...]
    """Names of the coordinates."""
    weights: Mapping[tuple[str, ...], float]
    """Weight of each cell, by its coordinates."""
    lines: Mapping[tuple[str, ...], int]
    """Line of each cell."""
    digest: str
    """SHA-256 of the file."""

    @property
    def name(self) -> str:
        """Return the path without the folders of this computer."""
        return without_folders(str(self.path))

    def weights_of(self, cells: Sequence[tuple[str, ...]], has_draws: Callable[[int], bool]) -> list[float]:
        """Return the weight of each cell; 0 for a cell without draws that the file does not name.

        Raises:
            ArgumentError: the file names an unknown cell, has no weight for a cell with draws, or only weights of 0.
        """
        known = set(cells)
        for cell, line in self.lines.items():
            if cell not in known:
                shown = ", ".join(cell)
                near = nearest(shown, [", ".join(each) for each in cells])
                cure = f"did you mean `{near}`?" if near else f"there are {', '.join(map(_shown, cells[:5]))}"
                raise ArgumentError(f"`{self.path}`, line {line}: there is no cell `{shown}`", cure)
        for number, cell in enumerate(cells):
            if cell not in self.weights and has_draws(number):
                what = f"`{self.path}` has no weight for the cell {_shown(cell)}, in which draws lie"
                raise ArgumentError(what, "give it a weight, 0 if it does not occur")
        if not sum(self.weights.values()) > 0.0:
            raise ArgumentError(f"`{self.path}`: every weight is 0", "give a weight above 0 to a cell that occurs")
        return [self.weights.get(cell, 0.0) for cell in cells]


def _shown(cell: tuple[str, ...]) -> str:
    return f"`{', '.join(cell)}`"


def read_exposure(path: Path) -> Exposure:
    """Return the weights in a file.

    Raises:
        ArgumentError: it is no such table, or a weight is negative or not a finite number.
        UnreadableFileError: it cannot be read.
    """
    try:
        content = path.read_bytes()
        rows = list(csv.reader(content.decode("utf-8-sig").splitlines()))
    except OSError as error:
        raise UnreadableFileError(path, error) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ArgumentError(f"`{path}` is no table: {error}", "write CSV: a head, and a line for each cell") from error
    head = tuple(word.strip() for word in rows[0]) if rows else ()
    columns = head[:-1]
    if len(head) < 2 or head[-1] != WEIGHT or not all(head) or len(set(columns)) < len(columns):
        what = f"`{path}`, line 1: expected the names of coordinates and `{WEIGHT}`, found `{','.join(head)}`"
        raise ArgumentError(what, f"write a head such as `speed,{WEIGHT}` or `cell,{WEIGHT}`")
    weights: dict[tuple[str, ...], float] = {}
    lines: dict[tuple[str, ...], int] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not any(word.strip() for word in row):
            continue
        place = f"`{path}`, line {number}"
        if len(row) != len(head):
            raise ArgumentError(f"{place}: expected {len(head)} values, found {len(row)}", "give one for each column")
        *names, text = (word.strip() for word in row)
        cell = tuple(names)
        if cell in weights:
            raise ArgumentError(f"{place}: the cell {_shown(cell)} has a weight in line {lines[cell]}", "remove one")
        weights[cell], lines[cell] = _weight(text, place), number
    if not weights:
        raise ArgumentError(f"`{path}` has no cell", "write a line for each cell")
    return Exposure(path, columns, weights, lines, sha256(content).hexdigest())


def _weight(text: str, place: str) -> float:
    """Return a weight.

    Raises:
        ArgumentError: it is negative or not a finite number.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0):
        raise ArgumentError(f"{place}: the weight is `{text}`", "give a number from 0 on")
    return value
