"""Names of the kinds of actors in each standard, and their properties that a flat world lacks: one row for each kind.

ASAM's Open Simulation Interface numbers the kinds of actors, and omega-prime's columns contain these numbers. Source:
Open Simulation Interface 3.7, `osi_object.proto`: MovingObject.Type, MovingObject.VehicleClassification.Type and .Role.
Actors other than vehicles have neither role nor subtype, -1 in omega-prime.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from engine.vocabulary import ActorKind

# -- numbers of the Open Simulation Interface --------------------------------------------------------------------------

UNSET = -1
OTHER, VEHICLE, PEDESTRIAN, ANIMAL = 1, 2, 3, 4
"""Types."""
CIVIL, PUBLIC_TRANSPORT = 2, 6
"""Roles."""
SMALL_CAR, LUXURY_CAR, DELIVERY_VAN, HEAVY_TRUCK, SEMITRAILER, TRAILER = 2, 5, 6, 7, 8, 9
MOTORBIKE, BICYCLE, BUS, TRAM, TRAIN, WHEELCHAIR, SEMITRACTOR, STANDUP_SCOOTER = 10, 11, 12, 13, 14, 15, 16, 17
"""Subtypes of vehicles; 2 to 5 are cars by size."""
MEDIUM_CAR = 4


class Code(NamedTuple):
    """Kind of one actor by its numbers."""

    type: int
    role: int = UNSET
    subtype: int = UNSET


BY_SUBTYPE: Mapping[int, ActorKind] = MappingProxyType(
    {
        **dict.fromkeys(range(SMALL_CAR, DELIVERY_VAN + 1), ActorKind.CAR),
        **dict.fromkeys((HEAVY_TRUCK, SEMITRAILER, TRAILER, SEMITRACTOR), ActorKind.TRUCK),
        **dict.fromkeys((BUS, TRAM, TRAIN), ActorKind.BUS),
        MOTORBIKE: ActorKind.MOTORCYCLE,
        **dict.fromkeys((BICYCLE, STANDUP_SCOOTER), ActorKind.BICYCLE),
        WHEELCHAIR: ActorKind.PEDESTRIAN,
    }
)


def kind_of(code: Code) -> ActorKind | None:
    """Return the kind nearest to a code; None for an unknown code."""
    if code.type == PEDESTRIAN:
        return ActorKind.PEDESTRIAN
    if code.type == OTHER:
        return ActorKind.OBSTACLE
    return BY_SUBTYPE.get(code.subtype) if code.type == VEHICLE else None


# -- the table ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Kind:
    """One row. Heights are a choice of cortexc: round figures within the usual range of the kind, a rider included."""

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
    """Diameter [m]; a choice of cortexc."""


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
