"""What one row of the table of results says: its unit, symbol and meaning, and whether it is of a scene, a pair or an
actor. The rows themselves are in `engine.outcomes`.
"""

import math
from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.frozen import frozen


class Per(Enum):
    """What a result is a number of, and so the shape of its array in `Outcomes`."""

    SCENE = "scene"
    """(n,)"""
    PAIR = "pair"
    """(n, pairs) one for each pair of the ego and another."""
    ACTOR = "actor"
    """(n, actors)"""
    CONTACT = "contact"
    """(n, 2) two in contact."""


class Kept(Enum):
    """Which of its values a scene keeps in `Assessment`."""

    OWN = "own"
    """The only one there is."""
    NEAREST = "nearest"
    """That of the pair that comes nearest."""
    DECIDING = "deciding"
    """That of the pair that decides the risk."""
    LEAST = "least"
    EGO = "ego"


Kind = type[float] | type[int] | type[bool] | type[IntEnum]


@frozen
class Result:
    """One row of the table."""

    sentence: str = ""
    """What the guide says of its columns; "" for a row that is told together with the one before."""
    unit: str = ""
    """SI unit word, "" for pure numbers."""
    symbol: str = ""
    """Of a metric that people know by one, such as MD: reports list it under this name."""
    meaning: str = ""
    """What a report says beside the symbol."""
    per: Per = Per.SCENE
    kind: Kind = float
    kept: Kept = Kept.OWN
    parts: tuple[str, ...] = ()
    """Of an array (n, k): the names of its k columns."""
    part_of: str = ""
    """The row whose parts they are."""
    when: str = ""
    """The row that holds its instant, of a metric that has one."""
    of_risk: bool = False
    """Whether it belongs to the metrics that the score comes from, which reports tell together with it."""
    in_document: bool = True
    """Of a metric of a pair: whether the JSON of a single run tells it."""
    formula: str = ""
    """Of a metric that people know by a symbol: what it comes from …"""
    source: str = ""
    """… and who defined it so."""
    name: str = ""
    """The attribute; filled in from the class."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Its columns in a journal and in CSV."""
        return self.parts or (self.name,)

    @property
    def fill(self) -> float | int | bool:
        """What an invalid scene has."""
        return math.nan if self.kind is float else self.kind is not bool and -1

    @property
    def dtype(self) -> Any:
        return {float: np.float64, bool: np.bool_}.get(self.kind, np.int32)

    @property
    def words(self) -> Mapping[int, str] | None:
        """The words of an enumeration by their codes; None for numbers."""
        if not issubclass(self.kind, IntEnum):
            return None
        return {-1: "", **{int(member): member.name.lower() for member in self.kind}}

    def blank(self, rows: int, actors: int) -> NDArray[Any]:
        """An array of `Outcomes` in which every scene is invalid."""
        shape = {Per.PAIR: (rows, actors - 1), Per.ACTOR: (rows, actors), Per.CONTACT: (rows, 2)}.get(self.per, (rows,))
        return np.full(shape, self.fill, self.dtype)
