"""Meanings of the columns of a table: by names, synonyms and the unit in a name.

A unit is in brackets or after the last underscore: `speed [km/h]`, `yaw_deg`, `timestamp_ms`. Without a unit a column
is SI: seconds, metres, metres per second, radians.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from engine.errors import InterchangeError, cited, name_cure, near_name, quoted
from engine.interchange.tables.layouts import Layout
from engine.tables import Floats, Ints

TEXTS = frozenset({"actor", "type", "role", "name", "part"})
"""Columns that are read as text; all others are numbers."""
_PLAIN: Mapping[str, str] = {
    "time": "t seconds sec timestamp time_s sim_time simulation_time",
    "actor": "id name track track_id trackid object object_id agent agent_id vehicle_id car_id idx entity",
    "x": "x_m pos_x position_x x_center xcenter center_x x_utm utm_x",
    "y": "y_m pos_y position_y y_center ycenter center_y y_utm utm_y",
    "z": "z_m pos_z position_z z_center zcenter center_z z_utm utm_z altitude elevation",
    "heading": "yaw psi hdg theta orientation rotation angle",
    "speed": "v velocity vel speed_mps",
    "vel_x": "vx v_x velocity_x x_velocity xvelocity speed_x",
    "vel_y": "vy v_y velocity_y y_velocity yvelocity speed_y",
    "length": "l box_length bounding_box_length",
    "width": "w box_width bounding_box_width",
    "type": "class kind category agent_type object_type vehicle_type",
    "role": "",
    "frame": "frame_id frame_number frame_no frame_index frames timestep time_step step tick index",
}
"""Columns of a plain table, and their synonyms."""
PLAIN: Mapping[str, tuple[str, ...]] = MappingProxyType({n: (n, *words.split()) for n, words in _PLAIN.items()})
NEEDED = ("time", "actor", "x", "y")
VELOCITY = ("vel_x", "vel_y")
BOX = ("width", "height")
"""Size columns of a box in an image; its x and y are a corner."""
OMEGA = ("total_nanos", "idx", "x", "y", "z", "yaw", "vel_x", "vel_y", "length", "width", "type", "role", "subtype")
"""Columns of omega-prime that motion is read from."""
NAME = "name"
"""Column of names, an addition to those of omega-prime, whose readers ignore it."""
SLIDES = "slides"
"""Additional column if an actor slides: 1 at each sample at which it slides after an impact, else 0."""
OMEGA_NEEDED = ("total_nanos", "idx", "x", "y", "yaw", "vel_x", "vel_y", "length", "width")
OMEGA_READ = (*OMEGA, NAME, SLIDES)

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
        "x": {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "ft": 0.3048},
        "heading": {"rad": 1.0, "deg": math.pi / 180.0, "degrees": math.pi / 180.0, "°": math.pi / 180.0},
        "speed": {
            "ft/s": 0.3048,
            "m/s": 1.0,
            "mps": 1.0,
            "km/h": 1 / 3.6,
            "kmh": 1 / 3.6,
            "kph": 1 / 3.6,
            "mph": 0.44704,
            "ms": 1.0,
        },
    }
)
"""Factors to SI of the units of each dimension."""
MEASURED_AS = MappingProxyType({"y": "x", "z": "x", "length": "x", "width": "x", "vel_x": "speed", "vel_y": "speed"})
DATES = "dates"
"""The unit of a time that is written as dates, ISO 8601."""
FRAMES = "frames"
"""Unit of a time that counts samples; their rate is given elsewhere."""
NO_NAMES: Mapping[str, str] = MappingProxyType({})
NO_COLUMNS: Mapping[int, str] = MappingProxyType({})
MOST_NAMED = 8
"""Maximum number of columns that are named as not read."""
SUFFIX = re.compile(r"[\[(]([^\[\](){}]*)[\])]$")
LONGEST_NAME = 200
"""Maximum number of letters; no column with a longer name is read."""
MOST_COMPARED = 200
"""Maximum number of column names that are searched for a similar name."""


@dataclass(frozen=True)
class Column:
    """One column that is read."""

    index: int
    name: str
    """Name as written in the file."""
    factor: float = 1.0
    """Factor from its unit to SI."""
    unit: str = "SI"
    """Unit in the name; "" without one."""


@dataclass(frozen=True)
class Chosen:
    """Columns of a table that are read."""

    columns: Mapping[str, Column]
    """Columns by meaning: keys of `PLAIN`, or names of `OMEGA`."""
    omega_prime: bool
    unread: tuple[str, ...] = ()
    """Names of the remaining columns, as written in the file."""


@dataclass(frozen=True)
class Cells:
    """Columns that were read, by meaning, row-aligned, in SI units."""

    file: str
    numbers: Mapping[str, Floats]
    texts: Mapping[str, Sequence[str]]
    whole: Mapping[str, Ints]
    """Columns of omega-prime that hold whole numbers, int64."""
    lines: Sequence[int]
    """Line number of each row in its file, from 1; for Parquet, the row's number."""
    columns: Mapping[str, Column]
    """Name and unit of each column in the file."""
    omega_prime: bool
    begin: float = 0.0
    """The first time of a plain table, as the file counts [s]; `numbers` count from there."""
    known_names: Sequence[str] = ()
    """Names by idx; empty if the file has none."""
    host: int | None = None
    """idx of the ego; None if the file has none."""
    layout: Layout | None = None
    """Layout of the known tool that wrote the table."""
    unread: Sequence[str] = ()
    """Columns that are not read."""
    remarks: tuple[str, ...] = ()
    """Remarks on the notation of its cells."""

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, row: int, column: str = "") -> str:
        """Return the place of a row."""
        unit = "row" if self.file.endswith(".parquet") else "line"
        return f"{self.file}, {unit} {self.lines[row]}" + (f", column `{self.columns[column].name}`" if column else "")


def choose(
    header: Sequence[str],
    place: str,
    layout: Layout | None = None,
    rate: float | None = None,
    named: Mapping[str, str] = NO_NAMES,
) -> Chosen:
    """Return the columns to read; `place`: that of their names.

    `layout`: that of a known tool; `rate`: samples per second, if the time counts samples; `named`: meanings of
    columns, with a unit if one is given (`time [ms]`), if their names do not show them.

    Raises:
        InterchangeError: a column is repeated, has an unknown unit, counts without a rate, or is named and missing.
    """
    names = [name.strip() for name in header]
    if named:
        found = _plain(names, place, rate, _told(names, place, named))
        taken = {column.index for column in found.values()}
        return Chosen(found, False, tuple(name for index, name in enumerate(names) if index not in taken and name))
    if "total_nanos" in names:
        return Chosen(_of_omega_prime(names, place), True)
    found = _plain(names, place, rate) if layout is None else _laid_out(names, layout, rate)
    taken = {column.index for column in found.values()}
    return Chosen(found, False, tuple(name for index, name in enumerate(names) if index not in taken and name))


def _laid_out(names: Sequence[str], layout: Layout, rate: float | None) -> dict[str, Column]:
    """Return the columns of a known layout, with its units."""
    places = {name.casefold(): index for index, name in reversed(list(enumerate(names)))}
    found: dict[str, Column] = {}
    for meaning, written in {**layout.columns, **({"part": layout.part} if layout.part else {})}.items():
        bracket = SUFFIX.search(written)
        name, unit = (written[: bracket.start()].strip(), bracket.group(1)) if bracket else (written, "SI")
        if (index := places.get(name.casefold())) is not None:
            factor = 1.0 / (rate or 1.0) if unit == FRAMES else _units(meaning).get(unit, 1.0)
            found[meaning] = Column(index, names[index], factor, unit)
    return found


def _told(names: Sequence[str], place: str, named: Mapping[str, str]) -> dict[int, str]:
    """Return the meaning that the user gives to columns, by index.

    Raises:
        InterchangeError: there is no such column, or nothing that it could be.
    """
    found: dict[int, str] = {}
    for name, column in named.items():
        meaning, _ = _meaning(name, place)
        if not meaning:
            raise InterchangeError(f"no column is read as {quoted(name)}", name_cure(name, PLAIN), place)
        if names.count(column) != 1:
            message = f"{names.count(column) or 'none'} of its columns is called {cited(column)}"
            raise InterchangeError(message, name_cure(column, names), place)
        found[names.index(column)] = name
    return found


def _plain(
    names: Sequence[str], place: str, rate: float | None, reported: Mapping[int, str] = NO_COLUMNS
) -> dict[str, Column]:
    """Return columns by their names, with the units in these; `reported`: meanings of some columns by number."""
    found: dict[str, Column] = {}
    taken = {_meaning(name, place)[0] for name in reported.values()}
    for index, name in enumerate(names):
        if index in reported:
            meaning, unit = _meaning(reported[index], place)
            own = SUFFIX.search(name)
            unit = unit or (own.group(1).strip() if own and own.group(1).strip() in _units(meaning) else "")
        else:
            meaning, unit = _meaning(name, place)
            meaning = "" if meaning in taken else meaning
        if meaning in found and meaning != "frame":
            message = f"{cited(found[meaning].name)} and {cited(name)} are both its {meaning}"
            raise InterchangeError(message, "leave one of them out, or rename it", place)
        if meaning:
            found.setdefault(meaning, Column(index, name, _units(meaning)[unit] if unit else 1.0, unit))
    if not all(each in found for each in VELOCITY) or "speed" in found:
        found = {key: column for key, column in found.items() if key not in VELOCITY}
    return _with_counted_time(found, place, rate)


def _with_counted_time(found: dict[str, Column], place: str, rate: float | None) -> dict[str, Column]:
    """Return the columns without `frame`, which is the time if a rate is known; an index alone is not a time."""
    frame = found.pop("frame", None)
    if rate is not None and (counted := found.get("time", frame)) is not None:
        return {**found, "time": Column(counted.index, counted.name, 1.0 / rate, FRAMES)}
    if frame is not None and "time" not in found:
        cure = "say how many there are in a second, as in --rate 25, or add a column `time` in seconds"
        raise InterchangeError(f"{cited(frame.name)} counts samples and is not a time", cure, place)
    return found


def unread_remark(unread: Sequence[str]) -> str:
    """Return the remark on columns that are not read; "" without any."""
    if not unread:
        return ""
    named, more = ", ".join(map(cited, unread[:MOST_NAMED])), len(unread) - MOST_NAMED
    return f"columns that are not read: {named}" + (f" and {more:,} more" if more > 0 else "")


def _of_omega_prime(names: Sequence[str], place: str) -> dict[str, Column]:
    """Return the columns of omega-prime, with exact names and SI units."""
    twice = next((name for name in OMEGA_READ if names.count(name) > 1), None)
    if twice is not None:
        raise InterchangeError(f"two columns are called `{twice}`", "leave one of them out, or rename it", place)
    return {name: Column(names.index(name), name) for name in OMEGA_READ if name in names}


def check_complete(chosen: Chosen, header: Sequence[str], place: str) -> None:
    """Raise InterchangeError if a column is missing that motion requires; `place`: that of the columns' names."""
    needed = OMEGA_NEEDED if chosen.omega_prime else NEEDED
    missing = [name for name in needed if name not in chosen.columns]
    if not missing:
        return
    taken = {column.index for column in chosen.columns.values()}
    free = [name.strip() for index, name in enumerate(header[:MOST_COMPARED]) if index not in taken]
    words = {missing[0]} if chosen.omega_prime else {*PLAIN[missing[0]]}
    near = next((name for name in free if near_name(name, words)), "")
    cure = f"is it {cited(near)}? call that column `{missing[0]}`" if near else f"name a column `{missing[0]}`"
    cure += "" if chosen.omega_prime else f", or say which it is: --columns {missing[0]}=COLUMN"
    there = ", ".join(map(cited, (name.strip() for name in header[:12])))
    also = f", nor {', '.join(f'`{name}`' for name in missing[1:])}" if missing[1:] else ""
    message = f"there is no column `{missing[0]}`{also}; there are {there}"
    raise InterchangeError(message, cure, place)


def _meaning(name: str, place: str) -> tuple[str, str]:
    """Return meaning and unit of a column; "" for one that is not read, and for a missing unit."""
    if len(name) > LONGEST_NAME:
        return "", ""
    word, unit = _split(name)
    meaning = next((key for key, words in PLAIN.items() if word in words), "")
    if not meaning or meaning in TEXTS:
        return meaning, ""
    if unit and unit not in _units(meaning):
        cure = name_cure(unit, _units(meaning))
        raise InterchangeError(f"{cited(name)}: no unit of its {meaning} is called {quoted(unit)}", cure, place)
    return meaning, unit


def _units(meaning: str) -> Mapping[str, float]:
    """Return the factors to SI for columns of a meaning."""
    return UNITS.get(MEASURED_AS.get(meaning, meaning), {})


def _split(name: str) -> tuple[str, str]:
    """Return a column's word in small letters, and its unit."""
    folded = name.casefold().strip()
    if bracket := SUFFIX.search(folded):
        return _word(folded[: bracket.start()]), bracket.group(1).strip()
    word = _word(folded)
    stem, _, unit = word.rpartition("_")
    known = next((key for key, words in PLAIN.items() if stem in words), "")
    return (stem, unit) if known and unit in _units(known) else (word, "")


def _word(text: str) -> str:
    return re.sub(r"[\s.\-]+", "_", text.strip())
