"""Conversion of a log's rows into tracks, with the checks and assumptions for tables."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from engine.errors import InterchangeError
from engine.interchange.tables.cells import MOST_ROWS, gathered_cells
from engine.interchange.tables.columns import TEXTS, Chosen, Column
from engine.interchange.tables.conventions import applied
from engine.interchange.tables.facing import with_assumed_headings
from engine.interchange.tables.layouts import Layout
from engine.interchange.tables.track import Tracks
from engine.interchange.tables.tracks import tracks_of

Row = tuple[int, Mapping[str, float | str]]
"""Line number of a row, and its values by meaning (see `tables.columns.PLAIN`), SI units."""


def tracks_of_rows(path: Path, layout: Layout, keys: tuple[str, ...], rows: Iterable[Row]) -> Tracks:
    """Return the tracks of rows; every row has the meanings `keys`.

    Raises:
        InterchangeError: no rows, too many, or no motion.
    """
    values: dict[str, list[float | str]] = {key: [] for key in keys}
    lines: list[int] = []
    for line, row in rows:
        if len(lines) >= MOST_ROWS:
            place = f"{path.name}, line {line}"
            raise InterchangeError(f"there are more than {MOST_ROWS:,} rows", "leave out actors or samples", place)
        for key in keys:
            values[key].append(row[key])
        lines.append(line)
    if not lines:
        raise InterchangeError("nobody moves in it", "record one actor at least", path.name)
    chosen = Chosen({key: Column(0, layout.columns.get(key, key)) for key in keys}, omega_prime=False)
    texts = {key: [str(value) for value in values[key]] for key in keys if key in TEXTS}
    numbers = {key: [float(value) for value in values[key]] for key in keys if key not in TEXTS}
    cells = applied(gathered_cells(path.name, chosen, numbers, texts, lines), layout, path)
    return with_assumed_headings(tracks_of(cells))
