"""Regions that a file makes, such as circles and polygons: how places in them are drawn, and what they contain."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace

from cortex_dsl.semantics.model.values import Value, Vector
from cortex_dsl.semantics.quantities.algebra import Term
from engine.frozen import frozen, frozen_identity

Draw = Callable[[], Term]
"""A fresh uniform number of the scene."""


@frozen
class Coordinates(Vector):
    """A point of which the function of a field takes x and y as plain numbers."""


@frozen
class Velocity:
    """How fast something moves, and where to [m/s]."""

    x: Term
    y: Term


@frozen
class DrawnPlace:
    """A place that was drawn."""

    point: Vector
    heading: Term | None = None
    kept: Term | None = None
    """Whether it counts; None: it always does. What does not is thrown away with the scene."""


@frozen_identity
class Area:
    """A region of the file's own."""

    name: str
    """What messages call it."""
    contains: Callable[[Vector], Term]
    """Whether a point lies in it."""
    holds: Callable[[Sequence[Vector]], Term] | None = None
    """Whether a whole outline does, given by its corners in order; None: that is not known."""
    draw: Callable[[Draw], DrawnPlace] | None = None
    """A place in it; None where no place can be drawn. Places that count have a density of 1 / `weight`."""
    weight: Term | None = None
    """[m^2], of lines [m]."""
    distance: Callable[[Vector], Term] | None = None
    """From a point, 0 inside [m]."""
    attributes: Mapping[str, Value] = field(default_factory=dict)
    parts: int = 1
    """How many regions it is made of, each as often as it stands there."""
    is_workspace: bool = False
    """Whether all objects must lie in it."""
    corners: Sequence[Vector] | None = None
    """Corners of an area that is an outline itself, in order."""


def convex(area: Area) -> Area:
    """An outline lies in what is convex where its corners do."""

    def holds(corners: Sequence[Vector]) -> Term:
        result = area.contains(corners[0])
        for corner in corners[1:]:
            result = result & area.contains(corner)
        return result

    return replace(area, holds=holds)


def all_or_nothing(name: str, truth: Term) -> Area:
    """`everywhere` or `nowhere`."""
    return Area(name, lambda _: truth, lambda _: truth)
