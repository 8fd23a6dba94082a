"""Buildings near roads: walls of a recording. Source: ASAM OpenDRIVE 1.7.0, chapter 13 (objects)."""

from collections.abc import Callable, Iterator, Sequence

from engine.errors import cited, quoted
from engine.opendrive.curves import Pose
from engine.xml import Node

OVERHEAD = 4.0
"""Height from which on a building is overhead [m]: the greatest height of a truck (Directive 96/53/EC, annex I)."""
LARGEST_BUILDING = 10_000.0
"""Length or width [m]."""


def road_buildings(road: Node) -> list[Node]:
    """Return the objects of a road that are buildings; all other objects are marked as left out."""
    objects = road.find("objects")
    found = objects.every("object") if objects else []
    buildings = [each for each in found if each.text("type", "") == "building"]
    for each in found:
        if each not in buildings:
            each.leave_out()
    return buildings


def building_row(node: Node, reference: Callable[[float], Pose], longest: float) -> list[tuple[float, ...]]:
    """Return its row of `OdrNetwork.buildings`; [] if it is overhead.

    `reference`: the pose of the road's reference line at a place, which is at most `longest` [m].

    Raises:
        InterchangeError: it is not a rectangle, or has no place.
    """
    if node.number("zOffset", 0.0) >= OVERHEAD:
        return []
    if "radius" in node.attributes or node.every("outline", "outlines", "repeat"):
        raise node.error(
            "this building is not a rectangle", 'give it a length and a width, without "radius" or outlines'
        )
    s, t = node.number("s", low=0.0, high=longest), node.number("t")
    pose = reference(s).moved(0.0, t, node.number("hdg", 0.0))
    sizes = (node.number(name, low=0.01, high=LARGEST_BUILDING) for name in ("length", "width"))
    return [(*pose, *sizes)]


def on_buildings(unread: Sequence[str]) -> Iterator[str]:
    """Yield the sentence about those that are left out, which names the first."""
    if unread:
        first = f"{cited(unread[0])} and {len(unread) - 1} more" if unread[1:] else quoted(unread[0])
        yield f"buildings that are not rectangles, or have no place, are left out: {first}"
