"""Traffic lights and signs that a file of roads has, and which arms of intersections have lights."""

from functools import lru_cache
from typing import TYPE_CHECKING

from engine.frozen import frozen

if TYPE_CHECKING:
    from engine.road.network import Lane, Network

TRAFFIC_LIGHT = "1000001"
"""OpenDRIVE's type of a traffic light of three colours, which alone is one to Scenic."""


@frozen
class RoadSign:
    """A traffic light or a sign, at one place at which it counts."""

    id: str
    """Of the file."""
    name: str
    country: str
    type: str
    subtype: str
    value: float | None
    road: str
    """The name of the road whose traffic it tells."""
    x: float
    y: float
    lanes: tuple[int, ...]
    """Ids of the lanes whose traffic it tells."""

    @property
    def is_traffic_light(self) -> bool:
        return self.type == TRAFFIC_LIGHT


@lru_cache(maxsize=4)
def lit_arms(network: "Network") -> frozenset[tuple[int, int]] | None:
    """Intersections and arms whose traffic has a light, by their indices; None where the file has no lights, or there
    is none: then the scenario says which there are, and every arm has one.
    """
    lights = [sign for sign in network.signs if sign.is_traffic_light]
    if not lights:
        return None
    lanes = {start for sign in lights for lane in sign.lanes for start in _waiting(network.lanes[lane])}
    return frozenset(
        (intersection.id, arm)
        for intersection in network.intersections
        for arm, leg in enumerate(intersection.legs)
        if not lanes.isdisjoint(lane.id for lane in leg.incoming_lanes)
    )


def _waiting(lane: "Lane") -> tuple[int, ...]:
    """Where traffic waits that a light over a lane tells: at its end, or before it where it runs through a junction."""
    return tuple(before.id for before in lane.predecessors) if not lane.maneuvers and lane.intersection else (lane.id,)


def signs_at(network: "Network", intersection: int) -> tuple[RoadSign, ...]:
    """Those over the lanes through an intersection, each once, as in Scenic."""
    through = {each.connecting_lane.road for each in network.intersections[intersection].maneuvers}
    return tuple({sign.id: sign for sign in reversed(network.signs) if sign.road in through}.values())[::-1]
