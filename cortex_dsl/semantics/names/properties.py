"""Properties of objects, one row each: the classes of `new`, the numbers and truths that `with` sets, and the arguments
of `environment`, with column, dimension and legal range.
"""

import math
from collections.abc import Mapping

from cortex_dsl import ir
from cortex_dsl.semantics.names.builtins import TOP_SPEED
from cortex_dsl.semantics.quantities.units import ACCELERATION, ANGLE, ANGULAR_SPEED, LENGTH, MASS, PURE, SPEED, TIME
from engine.frozen import frozen
from engine.vocabulary import ActorKind, Column

# -- classes of `new` --------------------------------------------------------------------------------------------------


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


@frozen
class Domain:
    """A number that has a name, its dimension and its legal range."""

    name: str
    dimension: ir.Dimension
    low: float = 0.0
    high: float = math.inf
    above: bool = False
    """Whether the lower end itself is illegal."""
    doc: str = ""


MEASURED: Mapping[str, Domain] = {
    "age": Domain("`age`", PURE, 3.0, 110.0),
    "doorLength": Domain("`doorLength`", LENGTH, 0.3, 3.0),
}
"""Numbers that no column of a scene has: the age of a person on foot in years, and the length of a vehicle's doors."""

ENVIRONMENT: Mapping[str, Domain] = {
    d.name: d
    for d in (
        Domain("friction", PURE, 0.0, 2.0, above=True, doc="Factor on everybody's grip: wet 0.6, snow 0.2, ice 0.1."),
        Domain("sight", LENGTH, 0.0, above=True, doc="Nobody sees further, as in fog."),
        Domain("light", PURE, 0.0, 1.0, above=True, doc="Factor on everybody's `visibleDistance`, 1 by day."),
    )
}
"""Arguments of `environment`."""


@frozen
class Property(Domain):
    """A number or a truth that `with` sets, and its column in a scene."""

    column: Column = Column.X
    truth: bool = False
    """Whether it is True or False, stored as 1.0 or 0.0."""


def _truth(name: str, column: Column, doc: str) -> Property:
    return Property(name, PURE, 0.0, 1.0, doc=doc, column=column, truth=True)


PROPERTIES: Mapping[str, Property] = {
    p.name: p
    for p in (
        Property("speed", SPEED, 0.0, TOP_SPEED, doc="Speed at the start.", column=Column.SPEED),
        Property("length", LENGTH, 0.0, 100.0, above=True, doc="Length of the outline.", column=Column.LENGTH),
        Property("width", LENGTH, 0.0, 20.0, above=True, doc="Width of the outline.", column=Column.WIDTH),
        Property("wheelbase", LENGTH, 0.0, 100.0, above=True, doc="Front axle to rear axle.", column=Column.WHEELBASE),
        Property(
            "rearToCenter", LENGTH, 0.0, 50.0, doc="Rear axle to the outline's centre.", column=Column.REAR_TO_CENTER
        ),
        Property("mass", MASS, 0.0, 1e6, above=True, doc="Mass.", column=Column.MASS),
        Property("maxSteer", ANGLE, 0.0, math.pi, doc="Largest steering angle either way.", column=Column.MAX_STEER),
        Property("maxAcceleration", ACCELERATION, 0.0, 100.0, doc="At full throttle.", column=Column.MAX_ACCELERATION),
        Property("maxBraking", ACCELERATION, 0.0, 100.0, doc="Deceleration at full pedal.", column=Column.MAX_BRAKING),
        Property("friction", PURE, 0.0, 10.0, above=True, doc="Between tyre and road.", column=Column.FRICTION),
        Property(
            "viewAngle", ANGLE, 0.0, math.tau, above=True, doc="Opening angle of its view.", column=Column.VIEW_ANGLE
        ),
        Property("visibleDistance", LENGTH, doc="How far it sees.", column=Column.VIEW_DISTANCE),
        _truth("occluding", Column.OCCLUDING, "Whether others are hidden behind it."),
        _truth("fixed", Column.FIXED, "Whether no impact moves it."),
        Property("topSpeed", SPEED, 0.0, TOP_SPEED, doc="No throttle takes it beyond.", column=Column.TOP_SPEED),
        Property("steerRate", ANGULAR_SPEED, 0.0, 100.0, doc="How fast its wheels turn.", column=Column.STEER_RATE),
        Property("pedalTime", TIME, 0.0, 10.0, doc="From no pedal to a full one.", column=Column.PEDAL_TIME),
        Property(
            "drag", ACCELERATION, 0.0, 100.0, doc="Deceleration while it rolls without pedals.", column=Column.DRAG
        ),
    )
}

MODEL_FIELDS: Mapping[str, str] = {name: p.column.name.lower() for name, p in PROPERTIES.items() if name != "speed"}
"""Field of `engine.vehicles.ActorModel` that holds each default."""

FLAGS: Mapping[str, str] = {
    "behavior": "What it does during the run.",
    "name": "What reports call it.",
    "allowCollisions": "Whether it may overlap others at the start.",
    "regionContainedIn": "`None`: it may start off the road.",
    "requireVisible": "Whether the ego must see it at the start.",
    "doorLength": "Length of the doors that it opens, 1 m without it.",
    "age": "Years of a person on foot, by which behaviors draw the walking speed.",
    "level": "The road on whose level it begins, where roads pass over one another.",
}
"""Properties that are not numbers."""

IGNORED: Mapping[str, str] = {
    "blueprint": "the looks of a vehicle do not matter here",
    "color": "the looks of a vehicle do not matter here",
    "rolename": "objects have the name of their variable",
    "physics": "every object takes part",
    "height": "the world is flat",
    "render": "no picture is made of a scene",
    **dict.fromkeys(("viewRayDensity", "viewRayCount", "viewRayDistanceScaling"), "sight is computed without rays"),
}
"""Properties of Scenic's scripts that are accepted and do nothing."""

_FACING, _FLAT, _NOISE = "`facing` turns it", "the world is flat", "`mutate` has its own noise: `mutate NAME by 2`"
_SPEED, _PLACE = "write `with speed V`; it goes the way it heads", "say where it is by a specifier, as `on road`"
SCENIC_ONLY: Mapping[str, str] = {
    **dict.fromkeys(("yaw", "orientation", "parentOrientation"), _FACING),
    **dict.fromkeys(("pitch", "roll", "baseOffset", "elevation", "onSurface", "cameraOffset"), _FLAT),
    **dict.fromkeys(("mutator", "mutationEnabled", "mutationScale"), _NOISE),
    **dict.fromkeys(("positionStdDev", "headingStdDev", "orientationStdDev"), _NOISE),
    **dict.fromkeys(("velocity", "angularVelocity", "angularSpeed"), _SPEED),
    **dict.fromkeys(("onDirection", "contactTolerance", "sideComponentThresholds"), _PLACE),
    "viewAngles": "write `with viewAngle 90 deg`",
    "shape": "every outline is a rectangle: `with length L, with width W`",
    "density": "write `with mass M`",
}
"""Properties by which Scenic moves, turns or measures an object, and their replacements.

A file cannot define them as its own, since they would be ignored.
"""


def all_properties() -> tuple[str, ...]:
    return (*PROPERTIES, *FLAGS, *IGNORED)
