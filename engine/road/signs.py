"""Traffic lights and signs that a file of roads has."""

from engine.frozen import frozen

TRAFFIC_LIGHT = "1000001"
"""OpenDRIVE's type of a traffic light of three colours, the only type that Scenic counts as one."""


@frozen
class RoadSign:
    """A traffic light or a sign, at one place at which it applies."""

    id: str
    """Id in the file."""
    name: str
    country: str
    type: str
    subtype: str
    value: float | None
    road: str
    """Name of the road to which it applies."""
    x: float
    y: float
    lanes: tuple[int, ...]
    """Ids of the lanes to which it applies."""

    @property
    def is_traffic_light(self) -> bool:
        return self.type == TRAFFIC_LIGHT
