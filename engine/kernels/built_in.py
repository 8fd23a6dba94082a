"""The built-in requirements of a scene: outlines inside the road, no overlap at the start."""

from engine.kernels.geometry import Box, box_distance
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.kernels.region import region_contains_box
from engine.tables import ROAD_REGION, Floats, Ints, RoadTables
from engine.vocabulary import Column

VALUES_PER_ACTOR = len(Column)


@inlined
def _outline(values: Floats, actor: int) -> Box:
    first = actor * VALUES_PER_ACTOR
    return Box(
        values[first + Column.X],
        values[first + Column.Y],
        values[first + Column.HEADING],
        values[first + Column.LENGTH],
        values[first + Column.WIDTH],
    )


@inlined
def inside_road(road: RoadTables, checked: Ints, values: Floats) -> bool:
    """Whether the outlines of all actors that must be on the road lie in it."""
    for actor in range(len(checked)):
        if checked[actor] != 0:
            box = _outline(values, actor)
            if not region_contains_box(road, ROAD_REGION, box.x, box.y, box.heading, box.length, box.width):
                return False
    return True


@kernel
def overlap(checked: Ints, values: Floats) -> bool:
    """Whether two actors touch that both must not overlap."""
    for one in range(len(checked)):
        for other in range(one):
            both = checked[one] != 0 and checked[other] != 0
            if both and box_distance(_outline(values, one), _outline(values, other)) == 0.0:
                return True
    return False
