"""`Position` of OpenSCENARIO as a pose of the reference point.

Source: ASAM OpenSCENARIO XML 1.2, classes WorldPosition, LanePosition, RoadPosition and their relatives.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from engine.interchange.reading.node import Node
from engine.interchange.reading.opendrive import OdrNetwork
from engine.interchange.reading.planview import Pose


class RoadPlace(NamedTuple):
    """Where on a road: on a lane and so far left of its middle, or without a lane left of the reference line."""

    road: str
    lane: int | None
    s: float
    offset: float


@dataclass(frozen=True)
class Placed:
    """A pose, and what is known besides."""

    pose: Pose
    """Its heading is the one given, or else the one that follows from the place."""
    given: bool
    """Whether the file says a heading."""
    on_road: RoadPlace | None = None


@dataclass(frozen=True)
class Surroundings:
    """What positions may refer to."""

    road: OdrNetwork | None
    others: Callable[[str, Node], Placed]
    """Where an entity is at that time; the node is who asks."""


def place(position: Node, around: Surroundings) -> Placed:
    """Where a `Position` lies.

    Raises:
        InterchangeError: of a kind that is not read here, off the network, or relative to what is not known.
    """
    node = position.only()
    if node.tag not in KINDS:
        raise node.error(f"<{node.tag}> is not read here", f"write one of {', '.join(KINDS)}")
    return KINDS[node.tag](node, around)


def _world(node: Node, _: Surroundings) -> Placed:
    given = "h" in node.attributes
    return Placed(Pose(node.number("x"), node.number("y"), node.number("h", 0.0, *ANGLES)), given)


def _lane(node: Node, around: Surroundings) -> Placed:
    lane = RoadPlace(node.text("roadId"), node.integer("laneId"), node.number("s"), _offset(node, "offset", 0.0))
    return _on_road(lane, node, around)


def _road(node: Node, around: Surroundings) -> Placed:
    return _on_road(RoadPlace(node.text("roadId"), None, node.number("s"), _offset(node, "t")), node, around)


def _on_road(where: RoadPlace, node: Node, around: Surroundings) -> Placed:
    if around.road is None:
        raise node.error(
            f"<{node.tag}> needs the road, and the file names none that could be read",
            "name the .xodr in <RoadNetwork><LogicFile filepath=…/>",
        )
    return _oriented(around.road.pose(*where, place=node.place), node, where)


def _relative_object(node: Node, around: Surroundings) -> Placed:
    other = around.others(node.text("entityRef"), node).pose
    return _oriented(other.moved(_offset(node, "dx"), _offset(node, "dy")), node)


def _relative_world(node: Node, around: Surroundings) -> Placed:
    other = around.others(node.text("entityRef"), node).pose
    return _oriented(Pose(other.x + _offset(node, "dx"), other.y + _offset(node, "dy"), other.heading), node)


def _relative_lane(node: Node, around: Surroundings) -> Placed:
    where, lane = _other_on_road(node, around), node.integer("dLane")
    if where.lane is None:
        raise node.error("the other's lane is not known", "write a LanePosition")
    ds = _offset(node, "ds" if "ds" in node.attributes else "dsLane")
    moved = RoadPlace(where.road, _counted(where.lane, lane), where.s + ds, _offset(node, "offset", 0.0))
    return _on_road(moved, node, around)


def _relative_road(node: Node, around: Surroundings) -> Placed:
    where = _other_on_road(node, around)
    if where.lane is not None:
        row = around.road.road(where.road, node.place) if around.road else None
        where = where._replace(lane=None, offset=where.offset + (row.center(where.lane, where.s) if row else 0.0))
    moved = where._replace(s=where.s + _offset(node, "ds"), offset=where.offset + _offset(node, "dt"))
    return _on_road(moved, node, around)


def _other_on_road(node: Node, around: Surroundings) -> RoadPlace:
    name = node.text("entityRef")
    where = around.others(name, node).on_road
    if where is None:
        raise node.error(
            f"where on the road `{name[:40]}` is then is not known here",
            "write a LanePosition or a WorldPosition; relative ones are read where the other stands where it was put",
        )
    return where


def _counted(lane: int, change: int) -> int:
    """A lane so many to the left of another; there is no lane 0 to drive on."""
    target = lane + change
    return target if (target > 0) == (lane > 0) and target else target + (1 if change > 0 else -1)


def _oriented(pose: Pose, node: Node, where: RoadPlace | None = None) -> Placed:
    """The pose with the element's `Orientation`: relative to the place's own heading, or absolute."""
    orientation = node.find("Orientation")
    if orientation is None or "h" not in orientation.attributes:
        return Placed(pose, False, where)
    heading = orientation.number("h", None, *ANGLES)
    if orientation.text("type", "absolute") == "relative":
        heading += pose.heading
    return Placed(pose._replace(heading=heading), True, where)


def _offset(node: Node, name: str, default: float | None = None) -> float:
    return node.number(name, default, -FARTHEST, FARTHEST)


ANGLES = (-1e4, 1e4)
FARTHEST = 1e5
"""From a road or from somebody [m]: further away is another place."""
KINDS: Mapping[str, Callable[[Node, Surroundings], Placed]] = MappingProxyType(
    {
        "WorldPosition": _world,
        "LanePosition": _lane,
        "RoadPosition": _road,
        "RelativeObjectPosition": _relative_object,
        "RelativeWorldPosition": _relative_world,
        "RelativeLanePosition": _relative_lane,
        "RelativeRoadPosition": _relative_road,
    }
)
