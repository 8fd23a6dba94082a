"""Which column of a stranger's table is what: names, their synonyms, and the unit that a name says.

A unit stands in brackets or behind the last underscore: `speed [km/h]`, `yaw_deg`, `timestamp_ms`. Without one it is
SI: seconds, metres, metres a second, radians.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from engine.interchange.errors import InterchangeError, did_you_mean, quoted

TEXTS = frozenset({"actor", "type", "role", "name"})
"""Columns that are read as text; the others are numbers."""
_PLAIN: Mapping[str, str] = {
    "time": "t seconds sec timestamp time_s sim_time simulation_time",
    "actor": "id name track track_id trackid object object_id agent agent_id vehicle_id car_id idx entity",
    "x": "x_m pos_x position_x x_center xcenter center_x x_utm utm_x",
    "y": "y_m pos_y position_y y_center ycenter center_y y_utm utm_y",
    "heading": "yaw psi hdg theta orientation rotation angle",
    "speed": "v velocity vel speed_mps",
    "length": "l box_length bounding_box_length",
    "width": "w box_width bounding_box_width",
    "type": "class kind category agent_type object_type vehicle_type",
    "role": "",
}
"""Columns of a plain table, and what else they are called."""
PLAIN: Mapping[str, tuple[str, ...]] = MappingProxyType({n: (n, *words.split()) for n, words in _PLAIN.items()})
NEEDED = ("time", "actor", "x", "y")
OMEGA = ("total_nanos", "idx", "x", "y", "yaw", "vel_x", "vel_y", "length", "width", "type", "role", "subtype")
"""Columns of omega-prime that motion is read from."""
NAME = "name"
"""A column that we add to those of omega-prime, whose readers let it stand."""
OMEGA_NEEDED = ("total_nanos", "idx", "x", "y", "yaw", "vel_x", "vel_y", "length", "width")

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
        "x": {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "ft": 0.3048},
        "heading": {"rad": 1.0, "deg": math.pi / 180.0, "degrees": math.pi / 180.0, "°": math.pi / 180.0},
        "speed": {"m/s": 1.0, "mps": 1.0, "km/h": 1 / 3.6, "kmh": 1 / 3.6, "kph": 1 / 3.6, "mph": 0.44704, "ms": 1.0},
    }
)
"""Of one column of each dimension, in SI."""
MEASURED_AS = MappingProxyType({"y": "x", "length": "x", "width": "x"})
SUFFIX = re.compile(r"[\[(]([^\[\](){}]*)[\])]$")
LONGEST_NAME = 200
"""Letters; a longer name is that of no column that is read."""
MOST_COMPARED = 200
"""Names of columns that are looked through for the one that was meant."""


@dataclass(frozen=True)
class Column:
    """One column that is read."""

    index: int
    name: str
    """As the file writes it."""
    factor: float = 1.0
    """From its unit to SI."""
    unit: str = "SI"
    """What the name says; "" where it says none."""


@dataclass(frozen=True)
class Chosen:
    """What is read of a table."""

    columns: Mapping[str, Column]
    """By what they are: keys of `PLAIN`, or names of `OMEGA`."""
    omega_prime: bool


def choose(header: Sequence[str], file: str) -> Chosen:
    """The columns to read.

    Raises:
        InterchangeError: one that is needed is missing, stands twice, or has a unit that nobody knows.
    """
    place = f"{file}, line 1" if file.endswith(".csv") else file
    names = [name.strip() for name in header]
    if "total_nanos" in names:
        return Chosen(_of_omega_prime(names, place), True)
    found: dict[str, Column] = {}
    for index, name in enumerate(names):
        meaning, unit = _meaning(name, place)
        if meaning in found:
            message = f"{_cited(found[meaning].name)} and {_cited(name)} are both its {meaning}"
            raise InterchangeError(message, "leave one of them out, or rename it", place)
        if meaning:
            found[meaning] = Column(index, name, _units(meaning)[unit] if unit else 1.0, unit)
    return Chosen(found, False)


def _of_omega_prime(names: Sequence[str], place: str) -> dict[str, Column]:
    """Its names are exact, and its units SI."""
    twice = next((name for name in (*OMEGA, NAME) if names.count(name) > 1), None)
    if twice is not None:
        raise InterchangeError(f"two columns are called `{twice}`", "leave one of them out, or rename it", place)
    return {name: Column(names.index(name), name) for name in (*OMEGA, NAME) if name in names}


def check_complete(chosen: Chosen, header: Sequence[str], file: str) -> None:
    """Raises InterchangeError where a column is missing that motion cannot be read without."""
    needed = OMEGA_NEEDED if chosen.omega_prime else NEEDED
    missing = [name for name in needed if name not in chosen.columns]
    if not missing:
        return
    taken = {column.index for column in chosen.columns.values()}
    free = [name.strip() for index, name in enumerate(header[:MOST_COMPARED]) if index not in taken]
    words = {missing[0]} if chosen.omega_prime else {*PLAIN[missing[0]]}
    near = next((name for name in free if did_you_mean(name, words, few=0)), "")
    cure = f"is it {_cited(near)}? call that column `{missing[0]}`" if near else f"name a column `{missing[0]}`"
    there = ", ".join(map(_cited, (name.strip() for name in header[:12])))
    also = f", nor {', '.join(f'`{name}`' for name in missing[1:])}" if missing[1:] else ""
    message = f"there is no column `{missing[0]}`{also}; there are {there}"
    raise InterchangeError(message, cure, f"{file}, line 1" if file.endswith(".csv") else file)


def _meaning(name: str, place: str) -> tuple[str, str]:
    """What a column is, and its unit; "" for one that is not read, and for a unit that is not said."""
    if len(name) > LONGEST_NAME:
        return "", ""
    word, unit = _split(name)
    meaning = next((key for key, words in PLAIN.items() if word in words), "")
    if not meaning or meaning in TEXTS:
        return meaning, ""
    if unit and unit not in _units(meaning):
        cure = did_you_mean(unit, _units(meaning))
        raise InterchangeError(f"{_cited(name)}: no unit of its {meaning} is called {quoted(unit)}", cure, place)
    return meaning, unit


def _units(meaning: str) -> Mapping[str, float]:
    """Of columns of a kind, in SI."""
    return UNITS.get(MEASURED_AS.get(meaning, meaning), {})


def _split(name: str) -> tuple[str, str]:
    """A column's word in small letters, and its unit."""
    folded = name.casefold().strip()
    if bracket := SUFFIX.search(folded):
        return _word(folded[: bracket.start()]), bracket.group(1).strip()
    word = _word(folded)
    stem, _, unit = word.rpartition("_")
    known = next((key for key, words in PLAIN.items() if stem in words), "")
    return (stem, unit) if known and unit in _units(known) else (word, "")


def _word(text: str) -> str:
    return re.sub(r"[\s.\-]+", "_", text.strip())


def _cited(name: str) -> str:
    return f"`{quoted(name)[1:-1]}`"
