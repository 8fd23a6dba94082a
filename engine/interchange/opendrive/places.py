"""Which road and lane of OpenDRIVE each of our lanes is, and where along it.

A road outside the junctions has its two directions to either side of its reference line, which runs in the middle and
with the traffic of its first lane. A turn is a road of one lane with the reference line on the lane's own centre. In
both cases arc length along our lane is arc length along the reference line, or what is left of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from engine.program import RoadSpec
from engine.road import Lane, LaneRole, Maneuver, Network, build_network


class RoadPlace(NamedTuple):
    """A place as others say it: road, lane, arc length along the road's reference line [m]."""

    road: str
    lane: int
    s: float


@dataclass(frozen=True)
class LanePlace:
    """One of our lanes in OpenDRIVE's terms."""

    road: str
    lane: int
    """Positive to the left of the reference line, negative to its right, counted from the middle."""
    forward: bool
    """Whether traffic runs the way that s grows."""
    length: float
    """[m]"""

    def s(self, along: float) -> float:
        """Arc length on the road, of a point `along` the lane [m]."""
        return along if self.forward else self.length - along


@dataclass(frozen=True)
class Carriageway:
    """A road outside the junctions."""

    id: str
    name: str
    forward: tuple[Lane, ...]
    """Lanes that run the way that s grows, from the kerb to the middle."""
    backward: tuple[Lane, ...]

    @property
    def length(self) -> float:
        return self.forward[0].length

    @property
    def lanes(self) -> tuple[Lane, ...]:
        return (*self.forward, *self.backward)


@dataclass(frozen=True)
class RoadMap:
    """A network with the names that its parts have in OpenDRIVE: numbers from 1, none used twice in a document."""

    network: Network

    @cached_property
    def roads(self) -> tuple[Carriageway, ...]:
        """All roads outside the junctions, in the order of their lanes."""
        by_name: dict[str, list[Lane]] = {}
        for lane in self.network.lanes:
            if lane.role is not LaneRole.CONNECTING:
                by_name.setdefault(lane.road, []).append(lane)
        return tuple(_carriageway(str(i), name, lanes) for i, (name, lanes) in enumerate(by_name.items(), 1))

    def turn_id(self, maneuver: Maneuver) -> str:
        """The road that runs through the junction along a maneuver."""
        return str(len(self.roads) + 1 + maneuver.id)

    def junction_id(self, intersection: int) -> str:
        return str(len(self.roads) + len(self.network.maneuvers) + 1 + intersection)

    @cached_property
    def places(self) -> tuple[LanePlace, ...]:
        """By lane id."""
        places: dict[int, LanePlace] = {}
        for road in self.roads:
            for lane in road.lanes:
                places[lane.id] = self._place_beside(road, lane)
        for maneuver in self.network.maneuvers:
            lane = maneuver.connecting_lane
            places[lane.id] = LanePlace(self.turn_id(maneuver), self.side, True, lane.length)
        return tuple(places[lane.id] for lane in self.network.lanes)

    def place(self, lane: int, s: float) -> RoadPlace:
        """Where a point `s` along one of our lanes [m] lies; `lane` is its id."""
        there = self.places[lane]
        return RoadPlace(there.road, there.lane, there.s(s))

    @property
    def side(self) -> int:
        """Sign of the lanes that run the way that s grows."""
        return 1 if self.network.spec.left_hand else -1

    def _place_beside(self, road: Carriageway, lane: Lane) -> LanePlace:
        forward = lane in road.forward
        from_middle = self.network.spec.lanes + 1 - lane.number
        return LanePlace(road.id, (self.side if forward else -self.side) * from_middle, forward, lane.length)


def road_map(spec: RoadSpec) -> RoadMap:
    """The road of a specification with its names in OpenDRIVE.

    Raises:
        RoadError: no road fits the specification.
    """
    return RoadMap(build_network(spec))


def _carriageway(road_id: str, name: str, lanes: Sequence[Lane]) -> Carriageway:
    forward = tuple(lane for lane in lanes if _heading(lane) == _heading(lanes[0]))
    return Carriageway(road_id, name, forward, tuple(lane for lane in lanes if lane not in forward))


def _heading(lane: Lane) -> float:
    return lane.network.paths.pose(lane.path, 0.0).heading
