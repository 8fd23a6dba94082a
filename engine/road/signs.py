"""Traffic lights and signs that a file of roads has."""

from engine.frozen import frozen

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
