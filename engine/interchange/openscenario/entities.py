"""Who takes part, written inline: no catalogs and no 3D models, which another machine may not have.

The reference point of a vehicle is the middle of its rear axle on the ground (ASAM OpenSCENARIO XML, User Guide, on
coordinate systems), so the centre of its bounding box lies ahead of it.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from engine.interchange.kinds import KINDS, Kind
from engine.interchange.openscenario.names import literal
from engine.interchange.openscenario.versions import Version
from engine.interchange.properties import FIELDS, of_actor
from engine.interchange.recording import RecordedActor, Recording
from engine.interchange.xml_text import Element, child
from engine.vocabulary import State

UNBOUNDED_SPEED = 100.0
"""`maxSpeed` of what no speed bounds [m/s]; a run that is faster has its own top speed instead."""
CATEGORY = {"Vehicle": "vehicleCategory", "Pedestrian": "pedestrianCategory", "MiscObject": "miscObjectCategory"}
WALKER = "walker.pedestrian.0001"
"""The model that 1.0 wants of every pedestrian: the name CARLA has for its first."""


def add_entities(
    root: Element,
    recording: Recording,
    names: Sequence[str],
    version: Version,
    properties: Sequence[Mapping[str, str]] = (),
) -> Element:
    """All actors under the names of `names.entity_names`, with more properties for each if wanted."""
    entities = child(root, "Entities")
    for index, actor in enumerate(recording.actors):
        scenario_object = child(entities, "ScenarioObject", name=names[index])
        top_speed = float(np.abs(recording.states[:, index, State.SPEED]).max(initial=0.0))
        element = _entity(scenario_object, actor, names[index], top_speed, version)
        own = _own_properties(actor, ego=index == 0, carried=_carried(actor, version))
        _properties(element, {**own, **(properties[index] if properties else {})})
    return entities


def _entity(parent: Element, actor: RecordedActor, name: str, top_speed: float, version: Version) -> Element:
    shape = KINDS[actor.kind]
    attributes: dict[str, str | float] = {"name": name, CATEGORY[shape.tag]: shape.category}
    if shape.tag != "Vehicle" or version.vehicle_mass:
        attributes["mass"] = actor.mass
    if shape.tag == "Pedestrian" and version.pedestrian_model:
        attributes["model"] = WALKER
    element = child(parent, shape.tag, **attributes)
    _bounding_box(element, actor, shape)
    if shape.tag == "Vehicle":
        _performance(element, actor, top_speed)
        _axles(element, actor, shape)
    return element


def _bounding_box(parent: Element, actor: RecordedActor, shape: Kind) -> None:
    box = child(parent, "BoundingBox")
    child(box, "Center", x=actor.rear_to_center, y=0, z=shape.height / 2)
    child(box, "Dimensions", width=actor.width, length=actor.length, height=shape.height)


def _performance(parent: Element, actor: RecordedActor, top_speed: float) -> None:
    speed = max(actor.max_speed if np.isfinite(actor.max_speed) else UNBOUNDED_SPEED, top_speed)
    acceleration, braking = actor.max_acceleration, actor.max_braking
    child(parent, "Performance", maxSpeed=speed, maxAcceleration=acceleration, maxDeceleration=braking)


def _axles(parent: Element, actor: RecordedActor, shape: Kind) -> None:
    axles = child(parent, "Axles")
    for tag, x, steering in (("FrontAxle", actor.wheelbase, actor.max_steer), ("RearAxle", 0.0, 0.0)):
        child(
            axles,
            tag,
            maxSteering=steering,
            wheelDiameter=shape.wheel,
            trackWidth=actor.width,
            positionX=x,
            positionZ=shape.wheel / 2,
        )


def _carried(actor: RecordedActor, version: Version) -> tuple[str, ...]:
    """Fields that the element of this kind has no place for."""
    if KINDS[actor.kind].tag != "Vehicle":
        return FIELDS[1:]
    mass = () if version.vehicle_mass else ("mass",)
    return mass if np.isfinite(actor.max_speed) else (*mass, "max_speed")


def _own_properties(actor: RecordedActor, *, ego: bool, carried: Sequence[str]) -> dict[str, str]:
    """`type` tells ScenarioRunner who the ego is, `plineInterpolation` esmini how headings run between vertices."""
    return {
        "type": "ego_vehicle" if ego else "simulation",
        "plineInterpolation": "segment",
        **of_actor(actor, carried),
    }


def _properties(parent: Element, properties: Mapping[str, str]) -> None:
    element = child(parent, "Properties")
    for name, value in properties.items():
        child(element, "Property", name=name, value=literal(value))
