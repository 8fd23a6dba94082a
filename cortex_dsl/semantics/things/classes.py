"""The classes of `new`, and the properties that `with` sets."""

import math
from collections.abc import Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.builtins import TOP_SPEED
from cortex_dsl.semantics.quantities.units import ACCELERATION, ANGLE, LENGTH, MASS, PURE, SPEED
from engine.frozen import frozen
from engine.vocabulary import ActorKind, Column

PLACES = ("Point", "OrientedPoint")
PLACED = ("position", "heading")
"""What a class may say about the place of its objects, beside their properties."""

PROPS = (
    "Trash", "Cone", "Debris", "VendingMachine", "Chair", "BusStop", "Garbage", "Container", "Table", "Barrier",
    "PlantPot", "Mailbox", "Box", "Bench", "Barrel", "Kiosk", "IronPlate", "TrafficWarning",
)  # fmt: skip
"""Things of Scenic's CARLA model: obstacles here, all of one size."""

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


@frozen
class Property:
    """A number that `with` sets: its column in a scene, its dimension and its legal range."""

    name: str
    column: Column
    dimension: ir.Dimension
    low: float = 0.0
    high: float = math.inf
    above: bool = False
    """Whether the lower end itself is illegal."""
    doc: str = ""


PROPERTIES: Mapping[str, Property] = {
    p.name: p
    for p in (
        Property("speed", Column.SPEED, SPEED, 0.0, TOP_SPEED, doc="Speed at the start."),
        Property("length", Column.LENGTH, LENGTH, 0.0, 100.0, above=True, doc="Length of the outline."),
        Property("width", Column.WIDTH, LENGTH, 0.0, 20.0, above=True, doc="Width of the outline."),
        Property("wheelbase", Column.WHEELBASE, LENGTH, 0.0, 100.0, above=True, doc="Front axle to rear axle."),
        Property("rearToCenter", Column.REAR_TO_CENTER, LENGTH, 0.0, 50.0, doc="Rear axle to the outline's centre."),
        Property("mass", Column.MASS, MASS, 0.0, 1e6, above=True, doc="Mass."),
        Property("maxSteer", Column.MAX_STEER, ANGLE, 0.0, math.pi, doc="Largest steering angle either way."),
        Property("maxAcceleration", Column.MAX_ACCELERATION, ACCELERATION, 0.0, 100.0, doc="At full throttle."),
        Property("maxBraking", Column.MAX_BRAKING, ACCELERATION, 0.0, 100.0, doc="Deceleration at full pedal."),
        Property("friction", Column.FRICTION, PURE, 0.0, 10.0, above=True, doc="Between tyre and road."),
        Property("viewAngle", Column.VIEW_ANGLE, ANGLE, 0.0, math.tau, above=True, doc="Opening angle of its view."),
        Property("visibleDistance", Column.VIEW_DISTANCE, LENGTH, doc="How far it sees."),
    )
}

MODEL_FIELDS: Mapping[str, str] = {name: p.column.name.lower() for name, p in PROPERTIES.items() if name != "speed"}
"""Field of `engine.vehicles.ActorModel` that holds each default."""

FLAGS: Mapping[str, str] = {
    "behavior": "What it does during the run.",
    "name": "What reports call it.",
    "allowCollisions": "Whether it may overlap others at the start.",
    "regionContainedIn": "`None`: it may start off the road.",
}
"""Properties that are not numbers."""

IGNORED: Mapping[str, str] = {
    "blueprint": "the looks of a vehicle do not matter here",
    "color": "the looks of a vehicle do not matter here",
    "rolename": "objects have the name of their variable",
    "requireVisible": "nothing has to be visible from the ego",
    "physics": "every object takes part",
}
"""Properties of Scenic's scripts that are accepted and do nothing."""


def all_properties() -> tuple[str, ...]:
    return (*PROPERTIES, *FLAGS, *IGNORED)
