"""Regions that a file makes, such as circles and polygons, and the elements of a map by name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace

from cortex_dsl.semantics.model.values import Value, Vector
from cortex_dsl.semantics.quantities.algebra import Term
from engine.frozen import frozen, frozen_identity
from engine.road.network import Intersection, Lane, Network, Road, Surface

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
    accepted: Term | None = None
    """Whether the place counts; None: always. A scene with a place that does not count is rejected."""


@frozen_identity
class Area:
    """A region of the file's own."""

    name: str
    """Name in messages."""
    contains: Callable[[Vector], Term]
    """Whether a point lies in it."""
    holds: Callable[[Sequence[Vector]], Term] | None = None
    """Whether a whole outline does, given by its corners in order; None: that is not known."""
    draw: Callable[[Draw], DrawnPlace] | None = None
    """A place in it; None where no place can be drawn. Places that count have a density of 1 / `weight`."""
    weight: Term | None = None
    """[m^2], of lines [m]."""
    distance: Callable[[Vector], Term] | None = None
    """Distance of a point from the area, 0 inside [m]."""
    attributes: Mapping[str, Value] = field(default_factory=dict)
    parts: int = 1
    """Number of regions that it is made of, with repetitions."""
    is_workspace: bool = False
    """Whether all objects must lie in it."""
    corners: Sequence[Vector] | None = None
    """Corners of an area that is an outline itself, in order."""
    outline: Term | None = None
    """Packed x, y, heading, length and width of a rectangle."""


def convex(area: Area) -> Area:
    """Return the area as a convex one: an outline lies in it if its corners do."""

    def holds(corners: Sequence[Vector]) -> Term:
        result = area.contains(corners[0])
        for corner in corners[1:]:
            result = result & area.contains(corner)
        return result

    return replace(area, holds=holds)


def all_or_nothing(name: str, truth: Term) -> Area:
    """`everywhere` or `nowhere`."""
    return Area(name, lambda _: truth, lambda _: truth)


# -- elements of a map -------------------------------------------------------------------------------------------------


Element = Road | Lane | Intersection | Surface


@frozen
class Elements:
    """Elements of a network, accessible by name."""

    network: Network

    def by_name(self) -> Mapping[str, Element]:
        """Roads and lanes as reports call them; intersections of a file so, and as Scenic calls them."""
        network = self.network
        named = (*network.roads, *network.connecting_roads, *network.lanes, *network.intersections)
        by_name: dict[str, Element] = {each.name: each for each in (*named, *network.surfaces)}
        for each in network.intersections:
            by_name.setdefault(each.name.replace("junction", "intersection"), each)
        return by_name


@frozen
class RoadSection:
    """All of a road: here it has one section, as its lanes have."""

    road: Road
