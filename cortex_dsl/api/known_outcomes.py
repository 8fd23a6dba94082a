"""Outcomes of scenes that a driver has just driven, so that they are not simulated a second time."""

from dataclasses import fields
from hashlib import blake2b
from typing import TYPE_CHECKING

import numpy as np

from engine.assessment import map_arrays

if TYPE_CHECKING:
    from engine.driving.blocks import Driven
    from engine.outcomes import Outcomes
    from engine.scenes import Scenes


class KnownOutcomes:
    """The outcomes of the scenes that were driven last, found by the content of the scenes."""

    def __init__(self) -> None:
        self._digest = b""
        self._outcomes: Outcomes | None = None

    def keep(self, done: "Driven") -> "Scenes":
        """Store the outcomes of driven scenes, in place of earlier ones, and return the scenes."""
        self._digest, self._outcomes = _digest(done.scenes), done.outcomes
        return done.scenes

    def of(self, scenes: "Scenes") -> "Outcomes | None":
        """Return a copy of the outcomes of scenes; None if any of their arrays has changed since they were driven."""
        if self._outcomes is None or _digest(scenes) != self._digest:
            return None
        return map_arrays(self._outcomes, np.copy)


def _digest(scenes: "Scenes") -> bytes:
    """Return a hash of all arrays, with their types and shapes."""
    digest = blake2b()
    for field in fields(scenes):
        array = np.ascontiguousarray(getattr(scenes, field.name))
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(array.data.cast("B") if array.size else b"")
    return digest.digest()
