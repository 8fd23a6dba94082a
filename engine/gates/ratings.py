"""Colours of rating tests by the speed at contact, and the points of a scenario. Plain numpy.

Source: the Euro NCAP rating calculator 2026 (package `euroncap-rating-2026` 5.4.9), which follows the protocol of
Frontal Collisions 1.2: `ComputedTestPoint`, `compute_predicted_score` and `apply_extended_range_bands`. Its bands are
half open: a speed at the upper end of a band belongs to the next one.
"""

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Literal

import numpy as np

from engine.tables import Bools, Floats, Ints

STANDARD, EXTENDED = "standard", "extended"
"""Ranges of the cells of a scenario."""
VERIFIED, UNVERIFIED = "verified", "unverified"
"""Status of a cell: whether its values were read in the document."""


class Colour(StrEnum):
    """Colour of a cell, the best first."""

    GREEN = "green"
    YELLOW = "yellow"
    ORANGE = "orange"
    BROWN = "brown"
    RED = "red"


POINTS: Mapping[Colour, float] = {
    Colour.GREEN: 1.0,
    Colour.YELLOW: 0.75,
    Colour.ORANGE: 0.5,
    Colour.BROWN: 0.25,
    Colour.RED: 0.0,
}
"""Points of a cell of the standard range."""
Bands = Sequence[tuple[float, Colour]]
"""Upper ends [km/h] with colours; above the last one the colour is red."""
FASTEST = 50.0
"""Speed [km/h] from which on the bands are the same."""
MITIGATION_OR_AVOIDANCE: Mapping[float, Bands] = {
    10.0: (),
    20.0: (),
    30.0: ((10.0, Colour.BROWN),),
    40.0: ((10.0, Colour.ORANGE), (20.0, Colour.BROWN)),
    FASTEST: ((10.0, Colour.YELLOW), (20.0, Colour.ORANGE), (30.0, Colour.BROWN)),
}
"""Bands above 0 of the relative speed at contact, by the speed of the ego [km/h]."""
REDUCTION: Bands = ((10.0, Colour.RED), (20.0, Colour.ORANGE), (30.0, Colour.GREEN))
"""Bands of the reduction of the ego's speed at contact; the upper end belongs to a band."""


class Rule(StrEnum):
    """Criterion of a cell."""

    MITIGATION_OR_AVOIDANCE = "mitigation or avoidance"
    AVOIDANCE = "avoidance"
    MITIGATION = "mitigation"
    LIMIT = "limit"
    """The speed at contact is at most that of the cell."""
    EXPECT = "expect"
    """Every `expect` of the scenario is kept."""


COLOURS = tuple(Colour)
RED = COLOURS.index(Colour.RED)


def colours(rule: Rule, speed: float, contact: Bools, impact: Floats, reduction: Floats, limit: float = 0.0) -> Ints:
    """Return (n,) the places of the colours of runs in `COLOURS`.

    Args:
        rule: the criterion.
        speed: nominal speed of the ego [km/h]; one of `MITIGATION_OR_AVOIDANCE`, or above `FASTEST`, for that rule.
        contact: (n,) True if the ego touched the target.
        impact: (n,) relative speed at contact [km/h].
        reduction: (n,) reduction of the ego's speed until contact [km/h].
        limit: largest impact speed of `Rule.LIMIT` [km/h].
    """
    if rule is Rule.MITIGATION:
        found = _banded(REDUCTION, reduction, "left")
    else:
        bands = MITIGATION_OR_AVOIDANCE[min(speed, FASTEST)] if rule is Rule.MITIGATION_OR_AVOIDANCE else ()
        avoided = impact <= (limit if rule is Rule.LIMIT else 0.0)
        found = np.where(avoided, 0, _banded(bands, impact, "right"))
    return np.where(contact, found, 0)


def _banded(bands: Bands, values: Floats, side: Literal["left", "right"]) -> Ints:
    """Return (n,) the places of the colours of the bands in which values lie."""
    places = np.array([*(COLOURS.index(colour) for _, colour in bands), RED])
    return places[np.searchsorted([end for end, _ in bands], values, side=side)]


def standard_points(found: Sequence[Colour], total: float) -> float:
    """Return the points of the standard range: the mean of its cells times the total."""
    return math.fsum(POINTS[each] for each in found) / len(found) * total if found else 0.0


def extended_points(found: Sequence[Colour], total: float) -> float:
    """Return the points of the extended range, by the share of cells that are not red: all, from 75 %, from 50 %."""
    if not found:
        return 0.0
    share = sum(each is not Colour.RED for each in found) / len(found)
    if share == 1.0:
        return total
    return total * (0.75 if share >= 0.75 else 0.5 if share >= 0.5 else 0.0)
