"""Elements of a map by name, the value of `network.elements`, and the sections of its roads."""

from collections.abc import Mapping

from engine.frozen import frozen
from engine.road.network import Intersection, Lane, Network, Road

Element = Road | Lane | Intersection


@frozen
class Elements:
    """Elements of a network, accessible by name."""

    network: Network

    def by_name(self) -> Mapping[str, Element]:
        """Roads and lanes as reports call them; intersections of a file so, and as Scenic calls them."""
        network = self.network
        named = (*network.roads, *network.connecting_roads, *network.lanes, *network.intersections)
        by_name: dict[str, Element] = {each.name: each for each in named}
        for each in network.intersections:
            by_name.setdefault(each.name.replace("junction", "intersection"), each)
        return by_name


@frozen
class RoadSection:
    """All of a road: here it has one section, as its lanes have."""

    road: Road
