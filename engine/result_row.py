"""One row of the table of results: unit, symbol, meaning, and whether it is of a scene, a pair or an actor. The rows
themselves are in `engine.outcomes`.
"""

import math
from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.frozen import frozen


class Per(Enum):
    """Reference of a result, which determines the shape of its array in `Outcomes`."""

    SCENE = "scene"
    """(n,)"""
    PAIR = "pair"
    """(n, pairs) One for each pair of the ego and another actor."""
    ACTOR = "actor"
    """(n, actors)"""
    CONTACT = "contact"
    """(n, 2) The two actors in contact."""


class Retention(Enum):
    """Choice of the value that a scene stores in `Assessment`."""

    OWN = "own"
    """The only value."""
    NEAREST = "nearest"
    """Value of the pair that comes nearest."""
    DECIDING = "deciding"
    """Value of the pair that decides the risk."""
    LEAST = "least"
    EGO = "ego"


Kind = type[float] | type[int] | type[bool] | type[IntEnum]


@frozen
class Result:
    """One row of the table."""

    sentence: str = ""
    """Description of its columns in the guide; "" for a row that is described with the row before."""
    unit: str = ""
    """SI unit word, "" for pure numbers."""
    symbol: str = ""
    """Symbol of a metric, such as MD, under which reports list it; "" without one."""
    meaning: str = ""
    """Text of a report next to the symbol."""
    per: Per = Per.SCENE
    kind: Kind = float
    retention: Retention = Retention.OWN
    parts: tuple[str, ...] = ()
    """Names of the k columns of an array (n, k)."""
    part_of: str = ""
    """Name of the row to which they belong."""
    when: str = ""
    """Name of the row with its instant, for a metric that has one."""
    of_risk: bool = False
    """True for the metrics of which the score consists, which reports show together with it."""
    in_document: bool = True
    """True if the JSON of a single run contains this metric of a pair."""
    formula: str = ""
    """Definition of a metric with a symbol."""
    source: str = ""
    """Source of the definition."""
    name: str = ""
    """The attribute; filled in from the class."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Return its columns in a journal and in CSV."""
        return self.parts or (self.name,)

    @property
    def fill(self) -> float | int | bool:
        """Return the value of an invalid scene."""
        return math.nan if self.kind is float else self.kind is not bool and -1

    @property
    def dtype(self) -> Any:
        return {float: np.float64, bool: np.bool_}.get(self.kind, np.int32)

    @property
    def words(self) -> Mapping[int, str] | None:
        """Return the words of an enumeration by their codes; None for numbers."""
        if not issubclass(self.kind, IntEnum):
            return None
        return {-1: "", **{int(member): member.name.lower() for member in self.kind}}

    def blank(self, rows: int, actors: int) -> NDArray[Any]:
        """Return an array of `Outcomes` in which every scene is invalid."""
        shape = {Per.PAIR: (rows, actors - 1), Per.ACTOR: (rows, actors), Per.CONTACT: (rows, 2)}.get(self.per, (rows,))
        return np.full(shape, self.fill, self.dtype)
