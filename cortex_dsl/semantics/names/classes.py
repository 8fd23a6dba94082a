"""Classes of `new`: places, and the kind of actor of each other class."""

from collections.abc import Mapping

from engine.vocabulary import ActorKind

PLACES: Mapping[str, tuple[str, ...]] = {
    "Point": ("visibleDistance",),
    "OrientedPoint": ("visibleDistance", "viewAngle"),
}
"""Properties of a place that `with` may set."""
PLACED = ("position", "heading")
"""Values of a class that place its objects, in addition to their properties."""

PROPS = (
    "Trash", "Cone", "Debris", "VendingMachine", "Chair", "BusStop", "Garbage", "Container", "Table", "Barrier",
    "PlantPot", "Mailbox", "Box", "Bench", "Barrel", "Kiosk", "IronPlate", "TrafficWarning",
)  # fmt: skip
"""Things of Scenic's CARLA model: obstacles here, all of one size."""

LOW = frozenset(PROPS) - {"VendingMachine", "BusStop", "Container", "Kiosk", "TrafficWarning"}
"""Props over which a driver sees: none is higher than a driver's eyes, 1.08 m above the road (AASHTO, "A Policy on
Geometric Design of Highways and Streets", 2011, section 3.2.6)."""

ACTOR_KINDS: Mapping[str, ActorKind] = {
    "Car": ActorKind.CAR,
    "Truck": ActorKind.TRUCK,
    "Bus": ActorKind.BUS,
    "Motorcycle": ActorKind.MOTORCYCLE,
    "Bicycle": ActorKind.BICYCLE,
    "Pedestrian": ActorKind.PEDESTRIAN,
    "Obstacle": ActorKind.OBSTACLE,
    **dict.fromkeys(PROPS, ActorKind.OBSTACLE),
    "Object": ActorKind.OBSTACLE,
}

CLASSES = (*PLACES, *ACTOR_KINDS)
OFF_ROAD = frozenset({ActorKind.PEDESTRIAN, ActorKind.OBSTACLE})
"""Kinds that need not start on the road."""
