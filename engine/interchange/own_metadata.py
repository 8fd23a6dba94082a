"""Metadata of files of cortexc in addition to a standard, written and read only here.

An actor has properties `cortexc.…`: its own name and kind, fields that its element lacks, and one number per sample at
which it is present for each quantity that does not follow exactly from its positions. A file has parameters
`cortexc_…`.

Speeds do not follow exactly from positions, so they are stored; `openscenario.read.speeds` compares the two. For an
actor that slides after an impact, the samples at which it slides are stored, too: `PRESENT`, 1 or 2.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from engine.interchange.recording import OF_STEPS, SAME_INSTANT, RecordedActor, Recording
from engine.interchange.xml_writing import number
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, State
from engine.xml import INFINITE, LARGEST, NUMBER

FILE_PREFIX = "cortexc_"
"""Prefix of the parameters with a file's provenance."""
PREFIX = "cortexc."
NAME, KIND, STEP, TIME = (f"{PREFIX}{word}" for word in ("name", "kind", "step", "time"))
FIELDS = ("mass", "wheelbase", "max_acceleration", "max_braking", "max_steer", "max_speed")
"""Fields of an actor for which its element may have no place."""
MOTION = (State.SPEED, State.ACCELERATION)
COMMANDS = (State.STEER, State.THROTTLE, State.BRAKE)
"""Columns that do not follow exactly from positions."""
COLUMNS: Mapping[str, State] = {f"{PREFIX}{state.name.lower()}": state for state in (*MOTION, *COMMANDS, State.PRESENT)}
LONGEST = 10_000_000
"""Maximum number of letters of one property: half a million numbers."""

Properties = Mapping[str, str]


class Samples(NamedTuple):
    """Samples of one actor, as stored in its file."""

    time: Floats
    columns: Mapping[State, Floats]


# -- written ----------------------------------------------------------------------------------------------------------


def of_actor(actor: RecordedActor, fields: Iterable[str]) -> dict[str, str]:
    """Return name, kind and those of `FIELDS` that have no other place."""
    own = {f"{PREFIX}{field}": number(getattr(actor, field)) for field in fields}
    return {NAME: _escaped(actor.name), KIND: actor.kind.name.lower(), **own}


def _escaped(text: str) -> str:
    """Return the text with escaped `$`, by which readers recognize a parameter, so that it can be restored."""
    return text.replace("\\", "\\\\").replace("$", "\\d")


def of_samples(recording: Recording, actor: int) -> dict[str, str]:
    """Return the step, and one number for each sample at which the actor is present."""
    there = recording.there[:, actor]
    carried = (*MOTION, *(COMMANDS if recording.commands else ()))
    carried = (*carried, State.PRESENT) if recording.slides[actor] else carried
    columns = {key: state for key, state in COLUMNS.items() if state in carried}
    return {
        STEP: number(recording.step),
        TIME: _text(recording.time[there]),
        **{key: _text(recording.states[there, actor, state]) for key, state in columns.items()},
    }


def _text(values: Floats) -> str:
    return " ".join(map(number, values.tolist()))


# -- read -------------------------------------------------------------------------------------------------------------


def name_in(properties: Properties, default: str) -> str:
    """Return the stored name, which may be empty, or `default`."""
    said = properties.get(NAME)
    return default if said is None else re.sub(r"\\(.)", lambda sign: "$" if sign[1] == "d" else sign[1], said)


def kind_in(properties: Properties) -> ActorKind | None:
    """Return the stored kind, since a category may stand for two kinds of cortexc."""
    said = properties.get(KIND, "").upper()
    return ActorKind[said] if said in ActorKind.__members__ else None


def fields_in(properties: Properties) -> dict[str, float]:
    """Return those of `FIELDS` that are stored; each is at least 0, and may be infinite."""
    known = {field: properties.get(f"{PREFIX}{field}", "") for field in FIELDS}
    read = {field: float(text) for field, text in known.items() if NUMBER.fullmatch(text) or text in INFINITE}
    return {field: value for field, value in read.items() if value >= 0.0}


def step_in(properties: Properties) -> float | None:
    """Return the step of the simulation that wrote the file [s]."""
    text = properties.get(STEP, "")
    return float(text) if NUMBER.fullmatch(text) and SAME_INSTANT < float(text) < LARGEST else None


def samples_in(properties: Properties) -> Samples | None:
    """Return the samples of the properties, or None if they are missing, incomplete or of different lengths."""
    time = _numbers(properties.get(TIME, ""))
    columns = {state: _numbers(properties[key]) for key, state in COLUMNS.items() if key in properties}
    if time is None or not len(time) or not (np.diff(time) > 0.0).all():
        return None
    full = {state: values for state, values in columns.items() if values is not None and len(values) == len(time)}
    known = np.isin(full.get(State.PRESENT, 1.0), (1.0, SLIDING)).all()
    return Samples(time, full) if len(full) == len(columns) and full.keys() >= set(MOTION) and known else None


def _numbers(text: str) -> Floats | None:
    if len(text) > LONGEST:
        return None
    parts = text.split()
    if not all(map(NUMBER.fullmatch, parts)):
        return None
    values = np.array([float(part) for part in parts], dtype=np.float64)
    return values if (np.abs(values) <= LARGEST).all() else None


# -- an actor's samples, read back -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Carried:
    """Samples of one actor, as stored in its file."""

    time: Floats
    columns: Mapping[State, Floats]

    def at(self, column: State, times: Floats) -> Floats:
        """Return a column at any times within the samples."""
        values = self.columns[column]
        if column in OF_STEPS:
            return values[np.minimum(np.searchsorted(self.time, times - SAME_INSTANT), len(values) - 1)]
        if column == State.PRESENT:
            return values[np.maximum(np.searchsorted(self.time, times + SAME_INSTANT) - 1, 0)]
        return np.interp(times, self.time, values)

    def there(self, times: Floats) -> np.ndarray:
        """Return (times,) True where a time is one of the samples."""
        return near(self.time, times)


def read_carried(properties: Properties) -> Carried | None:
    """Return the samples in the properties of one actor; None if they are incomplete."""
    samples = samples_in(properties)
    return None if samples is None else Carried(samples.time, samples.columns)


def near(times: Floats, wanted: Floats) -> np.ndarray:
    """Return True for each of `wanted` that is one of the ascending `times`."""
    after = np.minimum(np.searchsorted(times, wanted - SAME_INSTANT), len(times) - 1)
    return np.abs(times[after] - wanted) <= SAME_INSTANT
