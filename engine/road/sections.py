"""Lanes side by side: which lane lies to the left and right of another, and the roads and groups that they make up.

A lane of the grid keeps its shape from end to end, so it is a single section; sections are there because Scenic asks
them for their neighbours. Left and right are seen by the driver; a neighbour may run the other way. In right-hand
traffic lanes are numbered from right to left, in left-hand traffic from left to right.
"""

import math
from dataclasses import field

from engine.frozen import frozen
from engine.road.network import Lane, LaneRole, Maneuver, Network


@frozen
class LaneSection:
    """The whole of a lane, as Scenic's `LaneSection`."""

    lane: Lane

    @property
    def name(self) -> str:
        return self.lane.name

    @property
    def source(self) -> str:
        """Text that names this section in the language."""
        return f"{self.lane.source}.sections[0]"


@frozen
class LaneGroup:
    """The lanes of one road that run the same way."""

    network: Network = field(repr=False)
    road: str
    forward: bool
    lanes: tuple[Lane, ...]
    """From the kerb to the middle."""

    @property
    def name(self) -> str:
        return f"{self.road} {'forward' if self.forward else 'backward'}"


@frozen
class Road:
    """An arm, or what joins two intersections, both directions together."""

    network: Network = field(repr=False)
    name: str
    forward: LaneGroup
    """Of an arm at the border, the lanes that lead into the intersection."""
    backward: LaneGroup

    @property
    def source(self) -> str:
        """Text that names this road in the language."""
        names = list(dict.fromkeys(lane.road for lane in self.network.lanes if _is_ordinary(lane)))
        return f"network.roads[{names.index(self.name)}]"

    @property
    def lanes(self) -> tuple[Lane, ...]:
        return (*self.forward.lanes, *self.backward.lanes)


def _is_ordinary(lane: Lane) -> bool:
    return lane.role is not LaneRole.CONNECTING


def roads(network: Network) -> tuple[Road, ...]:
    """All roads outside intersections, in the order of their lanes."""
    names = dict.fromkeys(lane.road for lane in network.lanes if _is_ordinary(lane))
    return tuple(_road(network, name) for name in names)


def road_of(lane: Lane) -> Road | None:
    """The road that a lane is part of; None for a connecting lane."""
    return _road(lane.network, lane.road) if _is_ordinary(lane) else None


def _road(network: Network, name: str) -> Road:
    lanes = [lane for lane in network.lanes if lane.road == name and _is_ordinary(lane)]
    forward = tuple(lane for lane in lanes if _heading(lane) == _heading(lanes[0]))
    backward = tuple(lane for lane in lanes if lane not in forward)
    return Road(network, name, LaneGroup(network, name, True, forward), LaneGroup(network, name, False, backward))


def _heading(lane: Lane) -> int:
    """Quarter turns from the east at which a lane begins."""
    return round(lane.network.paths.pose(lane.path, 0.0).heading / (math.pi / 2)) % 4


def is_forward(lane: Lane) -> bool:
    """Whether a lane runs as its road does; connecting lanes do."""
    road = road_of(lane)
    return road is None or lane in road.forward.lanes


def group_of(lane: Lane) -> LaneGroup:
    """The lanes beside this one that run the same way; of a connecting lane, those of the same turn."""
    road = road_of(lane)
    if road is not None:
        return road.forward if lane in road.forward.lanes else road.backward
    turn = maneuver_of(lane)
    beside = [m for m in turn.intersection.maneuvers if _ends(m) == _ends(turn)]
    lanes = sorted((m.connecting_lane for m in beside), key=lambda each: each.number)
    return LaneGroup(lane.network, turn.name.split(" ")[0], True, tuple(lanes))


def maneuver_of(connecting: Lane) -> Maneuver:
    """The maneuver that runs through a connecting lane."""
    return next(m for m in connecting.network.maneuvers if m.connecting == connecting.id)


def _ends(maneuver: Maneuver) -> tuple[str, str]:
    return maneuver.start_lane.road, maneuver.end_lane.road


def opposite_group(lane: Lane) -> LaneGroup | None:
    """The lanes of the same road that run the other way."""
    road = road_of(lane)
    if road is None:
        return None
    return road.backward if lane in road.forward.lanes else road.forward


def faster(lane: Lane) -> Lane | None:
    """The neighbour of the same direction nearer to the middle of the road."""
    return _numbered(lane, lane.number + 1)


def slower(lane: Lane) -> Lane | None:
    """The neighbour of the same direction nearer to the kerb."""
    return _numbered(lane, lane.number - 1)


def _numbered(lane: Lane, number: int) -> Lane | None:
    return next((each for each in group_of(lane).lanes if each.number == number), None)


def _inwards(lane: Lane) -> Lane | None:
    """The neighbour towards the middle of the road, and across it the first of the other direction."""
    opposite = opposite_group(lane)
    across = opposite.lanes[-1] if opposite is not None and opposite.lanes else None
    return faster(lane) or across


def to_left(lane: Lane) -> Lane | None:
    return slower(lane) if lane.network.spec.left_hand else _inwards(lane)


def to_right(lane: Lane) -> Lane | None:
    return _inwards(lane) if lane.network.spec.left_hand else slower(lane)
