"""What our own files say beside a standard's words, written and read here alone.

An actor has properties `cortexc.…`: its own name and kind, what its element has no place for, and one number for each
sample at which it is there, of what does not follow exactly from its positions. A file has parameters `cortexc_…`.

Speeds do not follow exactly from positions, so they are written beside them; `openscenario.read.speeds` holds the two
against each other. Of who slides after an impact the samples at which it does are written, too: `PRESENT`, 1 or 2.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from engine.interchange.recording import OF_STEPS, SAME_INSTANT, RecordedActor, Recording
from engine.interchange.xml import INFINITE, LARGEST, NUMBER
from engine.interchange.xml_writing import number
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, State

FILE_PREFIX = "cortexc_"
"""How parameters begin in which a file says where it comes from."""
PREFIX = "cortexc."
NAME, KIND, STEP, TIME = (f"{PREFIX}{word}" for word in ("name", "kind", "step", "time"))
FIELDS = ("mass", "wheelbase", "max_acceleration", "max_braking", "max_steer", "max_speed")
"""Of an actor, that may have no place in its element."""
MOTION = (State.SPEED, State.ACCELERATION)
COMMANDS = (State.STEER, State.THROTTLE, State.BRAKE)
"""Columns that do not follow exactly from positions."""
COLUMNS: Mapping[str, State] = {f"{PREFIX}{state.name.lower()}": state for state in (*MOTION, *COMMANDS, State.PRESENT)}
LONGEST = 10_000_000
"""Letters of one property: half a million numbers."""

Properties = Mapping[str, str]


class Samples(NamedTuple):
    """Of one actor, as its own file has them."""

    time: Floats
    columns: Mapping[State, Floats]


# -- written ----------------------------------------------------------------------------------------------------------


def of_actor(actor: RecordedActor, fields: Iterable[str]) -> dict[str, str]:
    """Name, kind and those of `FIELDS` that have no other place."""
    own = {f"{PREFIX}{field}": number(getattr(actor, field)) for field in fields}
    return {NAME: _escaped(actor.name), KIND: actor.kind.name.lower(), **own}


def _escaped(text: str) -> str:
    """Without the `$` by which readers know a parameter, so that the very text comes back."""
    return text.replace("\\", "\\\\").replace("$", "\\d")


def of_samples(recording: Recording, actor: int) -> dict[str, str]:
    """The step, and one number for each sample at which the actor is there."""
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
    """The name that is said, which may be empty."""
    said = properties.get(NAME)
    return default if said is None else re.sub(r"\\(.)", lambda sign: "$" if sign[1] == "d" else sign[1], said)


def kind_in(properties: Properties) -> ActorKind | None:
    """The kind that is said, since a category may stand for two of ours."""
    said = properties.get(KIND, "").upper()
    return ActorKind[said] if said in ActorKind.__members__ else None


def fields_in(properties: Properties) -> dict[str, float]:
    """Those of `FIELDS` that are said; each is at least 0, and may be infinite."""
    known = {field: properties.get(f"{PREFIX}{field}", "") for field in FIELDS}
    read = {field: float(text) for field, text in known.items() if NUMBER.fullmatch(text) or text in INFINITE}
    return {field: value for field, value in read.items() if value >= 0.0}


def step_in(properties: Properties) -> float | None:
    """The step of the simulation that wrote the file [s]."""
    text = properties.get(STEP, "")
    return float(text) if NUMBER.fullmatch(text) and SAME_INSTANT < float(text) < LARGEST else None


def samples_in(properties: Properties) -> Samples | None:
    """What the properties hold, or None where they are missing, incomplete or not of one length."""
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
    """One actor's samples, as its own file has them."""

    time: Floats
    columns: Mapping[State, Floats]

    def at(self, column: State, times: Floats) -> Floats:
        """A column at any times within the samples."""
        values = self.columns[column]
        if column in OF_STEPS:
            return values[np.minimum(np.searchsorted(self.time, times - SAME_INSTANT), len(values) - 1)]
        if column == State.PRESENT:
            return values[np.maximum(np.searchsorted(self.time, times + SAME_INSTANT) - 1, 0)]
        return np.interp(times, self.time, values)

    def there(self, times: Floats) -> np.ndarray:
        """Whether each time is one of the samples."""
        return near(self.time, times)


def read_carried(properties: Properties) -> Carried | None:
    """What the properties of one actor hold; None where that is not complete."""
    samples = samples_in(properties)
    return None if samples is None else Carried(samples.time, samples.columns)


def near(times: Floats, wanted: Floats) -> np.ndarray:
    """Whether each of `wanted` is one of the ascending `times`."""
    after = np.minimum(np.searchsorted(times, wanted - SAME_INSTANT), len(times) - 1)
    return np.abs(times[after] - wanted) <= SAME_INSTANT
