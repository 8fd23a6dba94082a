"""Conventions of known tools' tables that are not in their columns: frames per second, accompanying files, directions
of axes. Cells come in as written, in SI units, and leave in the form that `tracks` expects.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from engine.errors import InterchangeError, cited, quoted
from engine.interchange.tables.columns import Cells
from engine.interchange.tables.layouts import LAYOUTS, Beside, Layout, Point

FASTEST = 100_000.0
"""Largest number of frames per second of a camera or simulator."""
MOST_META_BYTES = 20_000_000
MOST_PARTS = 3
"""Number of recordings in one table that a message names."""


def frame_rate(layout: Layout | None, path: Path, rate: float | None) -> float | None:
    """Return frames per second: as requested, of the data set, or of the accompanying file; None if times are seconds.

    Raises:
        InterchangeError: that file is missing, or has no rate.
    """
    if layout is None or rate is not None:
        return rate
    if layout.rate:
        return layout.rate
    beside = next((each for each in layout.beside if "rate" in each.columns), None)
    return None if beside is None else _rate_of(layout, path, beside)


def _rate_of(layout: Layout, path: Path, beside: Beside) -> float:
    column = beside.columns["rate"]
    file = _beside(layout, path, beside, f"the frames a second (column `{column}`), or say them, as in --rate 25")
    rows = _rows(file, (column,))
    try:
        rate = float(rows[0][0])
    except (ValueError, IndexError):
        rate = math.nan
    if not 0.0 < rate <= FASTEST:
        said = quoted(rows[0][0]) if rows else "nothing"
        message = f"it should hold the frames a second, and holds {said}"
        raise InterchangeError(message, "correct it, or say the rate with --rate", f"{file.name}, column `{column}`")
    return rate


def _beside(layout: Layout, path: Path, beside: Beside, what: str) -> Path:
    """Return the file that accompanies a table.

    Raises:
        InterchangeError: the table's name does not determine it, or it is missing.
    """
    stem = path.name.removesuffix(layout.end)
    name = f"{stem}{beside.end}"
    if stem == path.name:
        cure = f"call it as the data set does, `{layout.example}`"
        raise InterchangeError(
            f"a table of {layout.name} ends in `{layout.end}`, as do those beside it", cure, path.name
        )
    if not (file := path.with_name(name)).is_file():
        raise InterchangeError(f"`{name}` is missing beside it", f"put it there: it has {what}", path.name)
    return file


def _rows(file: Path, columns: Sequence[str]) -> list[list[str]]:
    """Return these columns of a small file.

    Raises:
        InterchangeError: unreadable, or without one of the columns.
    """
    try:
        if file.stat().st_size > MOST_META_BYTES:
            raise InterchangeError("it is too large for a file of descriptions", "name the table itself", file.name)
        with file.open(encoding="utf-8-sig", newline="") as text:
            rows = csv.reader(text, strict=True)
            header = [name.strip() for name in next(rows, list[str]())]
            missing = next((name for name in columns if name not in header), None)
            if missing is not None:
                cure = "take the file of the data set as it is"
                raise InterchangeError(f"there is no column `{missing}`", cure, f"{file.name}, line 1")
            places = [header.index(name) for name in columns]
            return [[row[place] for place in places] for row in rows if len(row) > max(places)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = str(getattr(error, "strerror", "") or error).lower()
        raise InterchangeError(f"it cannot be read: {reason}", "copy the file again", file.name) from None


def refuse_meta(header: Sequence[str], path: Path) -> None:
    """Raise InterchangeError if this file accompanies a table and is not the table."""
    for layout in LAYOUTS:
        for beside in layout.beside:
            if path.name.endswith(beside.end) and {*beside.columns.values()} <= {name.strip() for name in header}:
                table = f"{path.name.removesuffix(beside.end)}{layout.end}"
                raise InterchangeError("this describes a recording, and has no motion", f"name `{table}`", path.name)


def pedestrians_beside(layout: Layout | None, path: Path) -> Path | None:
    """Return the second file of a recording in two files; None if there is none."""
    if layout is None or not layout.also[0] or not path.name.startswith(layout.also[0]):
        return None
    other = path.with_name(layout.also[1] + path.name.removeprefix(layout.also[0]))
    return other if other.is_file() else None


# -- cells as their conventions mean them ------------------------------------------------------------------------------


def applied(cells: Cells, layout: Layout, path: Path) -> Cells:
    """Return the cells with the data of accompanying files, y up, angles anticlockwise from +x.

    Raises:
        InterchangeError: such a file is missing or does not fit; the table contains several recordings.
    """
    _refuse_parts(cells)
    numbers = dict(cells.numbers)
    if layout.point == Point.CORNER:
        numbers["x"], numbers["y"] = numbers["x"] + numbers["length"] / 2.0, numbers["y"] + numbers["width"] / 2.0
    if layout.compass and "heading" in numbers:
        numbers["heading"] = math.pi / 2.0 - numbers["heading"]
    if layout.y_down:
        numbers.update({key: -numbers[key] for key in ("y", "vel_y", "heading") if key in numbers})
    texts = {**cells.texts, **_described(cells, layout, path)}
    columns = {**cells.columns, **{key: cells.columns["actor"] for key in texts if key not in cells.columns}}
    return replace(cells, numbers=numbers, texts=texts, columns=columns, layout=layout)


def _refuse_parts(cells: Cells) -> None:
    parts = list(dict.fromkeys(cells.texts.get("part", ())))
    if len(parts) > 1:
        named = ", ".join(quoted(part) for part in parts[:MOST_PARTS]) + (", …" if len(parts) > MOST_PARTS else "")
        message = f"{len(parts):,} recordings are in it, by its column `{cells.columns['part'].name}`: {named}"
        raise InterchangeError(message, "leave the rows of one of them", cells.file)


def _described(cells: Cells, layout: Layout, path: Path) -> Mapping[str, Sequence[str]]:
    """Return the description of each actor in an accompanying file, a text per row."""
    beside = next((each for each in layout.beside if "actor" in each.columns), None)
    if beside is None:
        return {}
    keys = [key for key in beside.columns if key != "actor"]
    what = "what each actor is"
    file = _beside(layout, path, beside, what)
    rows = _rows(file, [beside.columns["actor"], *(beside.columns[key] for key in keys)])
    said = {row[0].strip(): row[1:] for row in rows}
    unknown = next((actor for actor in dict.fromkeys(cells.texts["actor"]) if actor not in said), None)
    if unknown is not None:
        cure = f"take both files of one recording: `{path.name}` and `{file.name}`"
        raise InterchangeError(f"it has no row for {cited(unknown)}", cure, file.name)
    return {key: [said[actor][place].strip() for actor in cells.texts["actor"]] for place, key in enumerate(keys)}


def ahead(point: Point, length: float, rear_to_center: float) -> float:
    """Return the distance of an actor's position ahead of its centre [m]."""
    return {Point.FRONT: length / 2.0, Point.REAR_AXLE: -rear_to_center}.get(point, 0.0)
