"""esmini's `--csv_logger FILE.csv`: one row per time step, a block of columns for each entity.

Source: esmini's user guide, "Logging", and the columns that it writes: `#1 World_Position_X [m]` is the middle of the
rear axle of the first entity, `#1 bb_x [m]` the distance of its box's centre ahead of it.
"""

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from engine.errors import InterchangeError, quoted, reading
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.tables.layouts import Layout, Point
from engine.interchange.tables.notation import CsvRows
from engine.interchange.tables.track import Tracks
from engine.unread import Unread

LAYOUT = Layout(
    name="esmini's --csv_logger",
    known_by=(),
    columns={"time": "TimeStamp [s]", "actor": "Entitity_Name [-]"},
    point=Point.CENTER,
    said="positions are rear axles; they become centres with the logged boxes; kinds are not logged",
)
KEYS = ("time", "actor", "x", "y", "z", "heading", "speed", "length", "width")
NAME = "Entitity_Name [-]"
NUMBERS = {
    "x": "World_Position_X [m]",
    "y": "World_Position_Y [m]",
    "heading": "World_Heading_Angle [rad]",
    "speed": "Current_Speed [m/s]",
    "length": "bb_length [m]",
    "width": "bb_width [m]",
    "ahead": "bb_x [m]",
    "aside": "bb_y [m]",
}
HEIGHT = "World_Position_Z [m]"
BLOCK = re.compile(r"#(\d{1,6}) (.+)")
MOST_PREAMBLE = 100
"""Lines above the column names."""


def read_esmini_log(path: Path) -> Tracks:
    """Return the tracks of a log.

    Raises:
        InterchangeError: unreadable, or a column is missing or has a cell that is not a number.
    """
    try:
        with reading(path), path.open(encoding="utf-8-sig", newline="") as file:
            unread = Unread()
            tracks = tracks_of_rows(path, LAYOUT, KEYS, _rows(csv.reader(file), path.name, unread))
            return replace(tracks, remarks=(*tracks.remarks, *unread.notes()))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InterchangeError(
            f"this is not a log of esmini: {error}", "let esmini write it again", path.name
        ) from None


def _rows(lines: CsvRows, name: str, unread: Unread) -> Iterator[Row]:
    time, blocks = _columns(lines, name)
    for block in blocks:
        for column, index in block.items():
            if column not in (NAME, HEIGHT, *NUMBERS.values()):
                unread.add(column, f"{name}, line {lines.line_num}, column {index + 1}")
    for cells in lines:
        if len(cells) <= time or not cells[time].strip():
            continue
        place = f"{name}, line {lines.line_num}"
        now = _number(cells, time, place)
        for block in blocks:
            if len(cells) > block[NAME] and cells[block[NAME]].strip():
                yield lines.line_num, _row(cells, block, now, place)


def _columns(lines: CsvRows, name: str) -> tuple[int, list[Mapping[str, int]]]:
    """Return the column of the time, and the columns of each block."""
    names: list[str] = []
    for cells in lines:
        names = [cell.strip() for cell in cells]
        if LAYOUT.columns["time"] in names:
            break
        if lines.line_num > MOST_PREAMBLE:
            raise InterchangeError("its column names are missing", "let esmini write it again", name)
    else:
        raise InterchangeError("its column names are missing", "let esmini write it again", name)
    blocks: dict[str, dict[str, int]] = {}
    for index, cell in enumerate(names):
        if found := BLOCK.fullmatch(cell):
            blocks.setdefault(found.group(1), {})[found.group(2).strip()] = index
    for number, block in blocks.items():
        missing = next((column for column in (NAME, *NUMBERS.values()) if column not in block), None)
        if missing:
            message = f"there is no column `#{number} {missing}`"
            raise InterchangeError(message, "log with a newer esmini", f"{name}, line {lines.line_num}")
    return names.index(LAYOUT.columns["time"]), list(blocks.values())


def _row(cells: Sequence[str], block: Mapping[str, int], time: float, place: str) -> Mapping[str, float | str]:
    values = {key: _number(cells, block[column], place) for key, column in NUMBERS.items()}
    cos, sin = math.cos(values["heading"]), math.sin(values["heading"])
    ahead, aside = values.pop("ahead"), values.pop("aside")
    values["x"] += ahead * cos - aside * sin
    values["y"] += ahead * sin + aside * cos
    height = _number(cells, block[HEIGHT], place) if HEIGHT in block else 0.0
    return {"time": time, "actor": cells[block[NAME]].strip(), "z": height, **values}


def _number(cells: Sequence[str], index: int, place: str) -> float:
    text = cells[index] if index < len(cells) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        message = f"it should hold a number, and holds {quoted(text) if text.strip() else 'nothing'}"
        raise InterchangeError(message, "correct it, or leave out the row", f"{place}, column {index + 1}")
    return value
