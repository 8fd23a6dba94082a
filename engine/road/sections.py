"""Adjacent lanes: left and right neighbours, and the roads and groups that lanes form.

A lane of the grid keeps its shape from end to end, so it is a single section; sections exist because Scenic queries
their neighbours. Left and right are those of the driver; a neighbour may run in the opposite direction. In right-hand
traffic lanes are numbered from right to left, in left-hand traffic from left to right.
"""

import numpy as np

from engine.frozen import frozen
from engine.road.network import Lane, LaneGroup, Maneuver, Network, Road, once_per_network
from engine.road.regions import shape_of_parts


@frozen
class LaneSection:
    """The whole of a lane, as Scenic's `LaneSection`."""

    lane: Lane

    @property
    def name(self) -> str:
        return self.lane.name

    @property
    def source(self) -> str:
        """Return the text that names this section in the language."""
        return f"{self.lane.source}.sections[0]"


def road_of(lane: Lane) -> Road | None:
    """Return the road of a lane; None for a connecting lane of a grid."""
    return lane.network.road_named.get(lane.road)


def group_of(lane: Lane) -> LaneGroup:
    """Return the lanes of the road in the same direction; for a connecting lane, those of the same turn."""
    road = road_of(lane)
    if road is not None:
        return road.forward if lane.forward else road.backward
    turn = maneuver_of(lane)
    beside = [m for m in turn.intersection.maneuvers if _ends(m) == _ends(turn)]
    lanes = sorted((m.connecting_lane for m in beside), key=lambda each: each.number)
    return LaneGroup(lane.network, turn.name.split(" ")[0], True, tuple(lanes))


def maneuver_of(connecting: Lane) -> Maneuver:
    """Return the maneuver that runs through a connecting lane."""
    return next(m for m in connecting.network.maneuvers if m.connecting == connecting.id)


def _ends(maneuver: Maneuver) -> tuple[str, str]:
    return maneuver.start_lane.road, maneuver.end_lane.road


def opposite_group(lane: Lane) -> LaneGroup | None:
    """Return the lanes of the same road in the opposite direction."""
    road = road_of(lane)
    if road is None:
        return None
    opposite = road.backward if lane.forward else road.forward
    return opposite if opposite.lanes else None


def faster(lane: Lane) -> Lane | None:
    """Return the neighbour of the same direction nearer to the middle of the road."""
    return _same_way(lane, _listed(lane, left=not lane.network.left_hand)) if _is_listed(lane) else _numbered(lane, 1)


def slower(lane: Lane) -> Lane | None:
    """Return the neighbour of the same direction nearer to the kerb."""
    return _same_way(lane, _listed(lane, left=lane.network.left_hand)) if _is_listed(lane) else _numbered(lane, -1)


def _numbered(lane: Lane, further: int) -> Lane | None:
    return next((each for each in group_of(lane).lanes if each.number == lane.number + further), None)


def _is_listed(lane: Lane) -> bool:
    return lane.network.links.beside is not None


def _listed(lane: Lane, *, left: bool) -> Lane | None:
    beside = (lane.network.links.beside or {}).get(lane.id, (None, None))[0 if left else 1]
    return None if beside is None else lane.network.lanes[beside]


def _same_way(lane: Lane, other: Lane | None) -> Lane | None:
    return other if other is not None and other.forward == lane.forward else None


def _inwards(lane: Lane) -> Lane | None:
    """Return the neighbour towards the middle of the road, and across it the first of the opposite direction."""
    opposite = opposite_group(lane)
    across = None if opposite is None else opposite.lanes[-1]
    return faster(lane) or across


def to_left(lane: Lane) -> Lane | None:
    if _is_listed(lane):
        return _listed(lane, left=True)
    return slower(lane) if lane.network.left_hand else _inwards(lane)


def to_right(lane: Lane) -> Lane | None:
    if _is_listed(lane):
        return _listed(lane, left=False)
    return _inwards(lane) if lane.network.left_hand else slower(lane)


@once_per_network
def all_intersections(network: Network) -> int:
    """Return the id of the region of all intersections, which is made on first use."""
    shapes = [network.regions.shape(each.region) for each in network.intersections]
    parts = (np.vstack([shape.edges for shape in shapes]), np.vstack([shape.triangles for shape in shapes]))
    return network.intersections[0].region if len(shapes) == 1 else network.regions.add(shape_of_parts(*parts))
