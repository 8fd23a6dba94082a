"""What our own files say of an actor besides its positions: the samples of `engine.interchange.properties`.

Speeds do not follow exactly from positions, so they are written beside them; `reading.belief` holds them against these.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from engine.interchange.properties import Properties, samples_in
from engine.interchange.recording import SAME_INSTANT
from engine.interchange.resampling import OF_STEPS
from engine.tables import Floats
from engine.vocabulary import State


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
