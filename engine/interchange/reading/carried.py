"""What our own files say of an actor besides its positions: properties `cortexc.…`, one number for each sample.

Speeds do not follow exactly from positions, so they are written beside them. They are believed as long as they fit
what the vertices say.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from engine.interchange.reading.node import LARGEST, NUMBER
from engine.tables import Floats
from engine.vocabulary import State

LINEAR = (State.SPEED, State.STEER)
OF_STEPS = (State.ACCELERATION, State.THROTTLE, State.BRAKE)
"""What a sample tells of the step that ended there, so that it holds all through that step."""
SAME_INSTANT = 1e-9
NEEDED = frozenset({State.SPEED, State.ACCELERATION})
LONGEST = 10_000_000
"""Letters of one property: half a million numbers."""
FITS = 0.02
"""How far the way of one step may be from speed times time [m], apart from a twentieth of it."""


@dataclass(frozen=True)
class Carried:
    """One actor's samples, as its own file has them."""

    time: Floats
    columns: Mapping[State, Floats]

    def at(self, column: State, times: Floats) -> Floats:
        """A column at any times within the samples."""
        values = self.columns[column]
        if column in LINEAR:
            return np.interp(times, self.time, values)
        return values[np.minimum(np.searchsorted(self.time, times - SAME_INSTANT), len(values) - 1)]

    def there(self, times: Floats) -> np.ndarray:
        """Whether each time is one of the samples."""
        return near(self.time, times)

    def fits(self, poses: Floats, step: float) -> bool:
        """Whether most steps are as long as the speeds say; `poses` (samples, 3) are those of the vertices.

        Samples further apart than one and a half steps [s] have a time between them in which the actor is not there.
        """
        steps = np.diff(self.time)
        speed = self.columns[State.SPEED]
        heading = (poses[1:, 2] + poses[:-1, 2]) / 2.0
        way = np.diff(poses[:, 0]) * np.cos(heading) + np.diff(poses[:, 1]) * np.sin(heading)
        wanted = (speed[1:] + speed[:-1]) / 2.0 * steps
        wrong = np.abs(way - wanted) > FITS + 0.05 * np.abs(way)
        together = steps < 1.5 * step
        return bool(2 * np.count_nonzero(wrong & together) <= np.count_nonzero(together))


def read_carried(properties: Mapping[str, str]) -> Carried | None:
    """What the properties hold, or None where they are missing, incomplete or not of one length."""
    time = _numbers(properties.get("cortexc.time", ""))
    written = [column for column in LINEAR + OF_STEPS if f"cortexc.{column.name.lower()}" in properties]
    columns = {column: _numbers(properties[f"cortexc.{column.name.lower()}"]) for column in written}
    if time is None or not len(time) or not (np.diff(time) > 0.0).all():
        return None
    full = {column: values for column, values in columns.items() if values is not None and len(values) == len(time)}
    return Carried(time, full) if len(full) == len(columns) and full.keys() >= NEEDED else None


def read_step(properties: Mapping[str, str]) -> float | None:
    """The step of the simulation that wrote the file [s]."""
    text = properties.get("cortexc.step", "")
    return float(text) if NUMBER.fullmatch(text) and SAME_INSTANT < float(text) < LARGEST else None


def near(times: Floats, wanted: Floats) -> np.ndarray:
    """Whether each of `wanted` is one of the ascending `times`."""
    after = np.minimum(np.searchsorted(times, wanted - SAME_INSTANT), len(times) - 1)
    return np.abs(times[after] - wanted) <= SAME_INSTANT


def _numbers(text: str) -> Floats | None:
    if len(text) > LONGEST:
        return None
    parts = text.split()
    if not all(map(NUMBER.fullmatch, parts)):
        return None
    values = np.array([float(part) for part in parts], dtype=np.float64)
    return values if (np.abs(values) <= LARGEST).all() else None
