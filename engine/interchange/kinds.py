"""What each standard calls the kinds of actors, and what a flat world does not know of them: one row for each."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from engine.interchange.osi import (
    BICYCLE,
    BUS,
    CIVIL,
    HEAVY_TRUCK,
    MEDIUM_CAR,
    MOTORBIKE,
    OTHER,
    PEDESTRIAN,
    PUBLIC_TRANSPORT,
    VEHICLE,
    Code,
)
from engine.vocabulary import ActorKind


@dataclass(frozen=True)
class Kind:
    """One row. Heights are *ours*: round figures within the range usual for the kind, a rider included."""

    tag: str
    """OpenSCENARIO's element, and `category` its category."""
    category: str
    commonroad: str
    """CommonRoad's type of an obstacle."""
    code: Code
    """Open Simulation Interface's numbers."""
    height: float
    """[m]"""
    wheel: float = 0.0
    """Diameter [m]; *ours*."""


KINDS: Mapping[ActorKind, Kind] = MappingProxyType(
    {
        ActorKind.CAR: Kind("Vehicle", "car", "car", Code(VEHICLE, CIVIL, MEDIUM_CAR), 1.5, 0.6),
        ActorKind.TRUCK: Kind("Vehicle", "truck", "truck", Code(VEHICLE, CIVIL, HEAVY_TRUCK), 3.5, 1.0),
        ActorKind.BUS: Kind("Vehicle", "bus", "bus", Code(VEHICLE, PUBLIC_TRANSPORT, BUS), 3.0, 1.0),
        ActorKind.MOTORCYCLE: Kind("Vehicle", "motorbike", "motorcycle", Code(VEHICLE, CIVIL, MOTORBIKE), 1.7, 0.6),
        ActorKind.BICYCLE: Kind("Vehicle", "bicycle", "bicycle", Code(VEHICLE, CIVIL, BICYCLE), 1.8, 0.7),
        ActorKind.PEDESTRIAN: Kind("Pedestrian", "pedestrian", "pedestrian", Code(PEDESTRIAN), 1.75),
        ActorKind.OBSTACLE: Kind("MiscObject", "obstacle", "unknown", Code(OTHER), 1.0),
    }
)
