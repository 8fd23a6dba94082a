"""The parts of a scenario that do not depend on the form of its motion: head, parameters, road, times, places, and
entities, written inline, without catalogs and 3D models, which a different machine may not have.

The reference point of a vehicle is the middle of its rear axle on the ground (ASAM OpenSCENARIO XML, User Guide, on
coordinate systems), so the centre of its bounding box is ahead of it.

The weather of a recording is an `EnvironmentAction`: grip as a factor, sight as the range of fog. Version 1.0 requires
a whole environment: a time of day, a sun and precipitation. Without data it is a clear noon.
"""

import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import count

import numpy as np

from engine.interchange.kinds import KINDS, Kind
from engine.interchange.openscenario.versions import Version
from engine.interchange.own_metadata import FIELDS, FILE_PREFIX, of_actor
from engine.interchange.recording import Provenance, RecordedActor, Recording, Surroundings
from engine.interchange.xml_writing import Element, child, decimal, number
from engine.vocabulary import State

# -- names as every reader takes them: letters, digits and `_`, unique, and still to be recognised ---------------------


def plain_name(text: str) -> str:
    """Return a name without accents, spaces and signs; `$` and `::` have a meaning for readers."""
    letters = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9]+", "_", letters).strip("_") or "unnamed"
    return f"_{name}" if name[0].isdigit() else name


def unique_names(texts: Iterable[str]) -> tuple[str, ...]:
    """Return plain names in the same order; a repeated name gets the first free number from 2 on."""
    taken: dict[str, None] = {}
    for text in texts:
        name = plain_name(text)
        numbered = (f"{name}_{number}" for number in count(2))
        taken[name if name not in taken else next(free for free in numbered if free not in taken)] = None
    return tuple(taken)


def entity_names(recording: Recording) -> tuple[str, ...]:
    """Return the names of a recording's actors in its files."""
    return unique_names(actor.name for actor in recording.actors)


def literal(text: str) -> str:
    """Return the text with full-width `$`, as readers take a `$` anywhere for a reference to a parameter."""
    return text.replace("$", "\N{FULLWIDTH DOLLAR SIGN}")


# -- head, parameters, road, times, places -----------------------------------------------------------------------------

LONGEST_DESCRIPTION = 500
"""Maximum number of characters; a longer description is in the parameters only."""
AT_ONCE: Mapping[str, str] = {"dynamicsShape": "step", "value": "0", "dynamicsDimension": "time"}
"""Dynamics of an immediate change of speed."""


@dataclass(frozen=True)
class ParameterDeclaration:
    """A parameter of a file: its name is made plain and unique, values of type `double` are numbers."""

    name: str
    value: str
    kind: str = "string"
    low: float = float("-inf")
    """Lower bound for variation, if the version can express it; `high`: upper bound."""
    high: float = float("inf")


@dataclass(frozen=True)
class Document:
    """A scenario up to its `RoadNetwork`; further parts are added to the root."""

    root: Element
    network: Element


def new_document(
    recording: Recording,
    version: Version,
    road_file: str | None,
    parameters: Sequence[ParameterDeclaration] = (),
    *,
    title: str = "",
) -> Document:
    """Return a scenario with its head; `parameters` precede those of provenance, `title` replaces its description."""
    root = Element("OpenSCENARIO")
    header(root, recording.provenance, version, title)
    declarations = child(root, "ParameterDeclarations")
    declared = (*parameters, *provenance_parameters(recording))
    for name, parameter in zip(unique_names(each.name for each in declared), declared, strict=True):
        _declare(declarations, name, parameter, version)
    child(root, "CatalogLocations")
    network = child(root, "RoadNetwork")
    if road_file is not None:
        child(network, "LogicFile", filepath=road_file)
    return Document(root, network)


def _declare(declarations: Element, name: str, parameter: ParameterDeclaration, version: Version) -> None:
    value = literal(parameter.value)
    element = child(declarations, "ParameterDeclaration", name=name, parameterType=parameter.kind, value=value)
    limits = (("greaterOrEqual", parameter.low), ("lessOrEqual", parameter.high))
    finite = [(rule, limit) for rule, limit in limits if abs(limit) < float("inf")]
    if finite and version.has_constraints:
        group = child(element, "ConstraintGroup")
        for rule, limit in finite:
            child(group, "ValueConstraint", rule=rule, value=decimal(limit))


def header(root: Element, provenance: Provenance, version: Version, title: str = "") -> Element:
    """Add the header: author, date and description."""
    return child(
        root,
        "FileHeader",
        revMajor=1,
        revMinor=version.minor,
        date=date_and_time(provenance.date),
        description=title or literal(description(provenance)),
        author=literal(provenance.author),
    )


def date_and_time(text: str) -> str:
    """Return a date in XML's format; an invalid date, as in a foreign file, becomes the default date."""
    try:
        return datetime.fromisoformat(text).isoformat()
    except ValueError:
        return Provenance().date


def description(provenance: Provenance) -> str:
    """Return title and facts in one line."""
    facts = "; ".join(f"{name}: {value}" for name, value in provenance.facts.items())
    text = " - ".join(part for part in (provenance.title, facts) if part) or "scenario"
    return text if len(text) <= LONGEST_DESCRIPTION else text[: LONGEST_DESCRIPTION - 3] + "..."


def provenance_parameters(recording: Recording) -> tuple[ParameterDeclaration, ...]:
    """Return the genome by the names of its params, and the facts and first contact as `cortexc_...`."""
    provenance = recording.provenance
    genome = (ParameterDeclaration(name, value, value_kind(value)) for name, value in provenance.genome.items())
    facts = (ParameterDeclaration(f"{FILE_PREFIX}{name}", value) for name, value in provenance.facts.items())
    return (*genome, *facts, *_contact_parameters(recording))


def _contact_parameters(recording: Recording) -> tuple[ParameterDeclaration, ...]:
    """Return time and partners of contact, in the order of the file."""
    if recording.contact is None:
        return ()
    return (
        ParameterDeclaration(f"{FILE_PREFIX}contact_time", number(recording.contact.time), "double"),
        ParameterDeclaration(f"{FILE_PREFIX}contact_actors", " ".join(map(str, recording.contact.actors))),
    )


def value_kind(text: str) -> str:
    """Return `double` for a finite number, else `string`: `41.5 km/h` keeps its unit."""
    try:
        return "double" if abs(float(text)) < float("inf") and text.strip("+-.eE0123456789") == "" else "string"
    except ValueError:
        return "string"


def time_trigger(parent: Element, tag: str, name: str, seconds: float, version: Version) -> Element:
    """Add a `StartTrigger` or `StopTrigger` that holds from an instant on [s]; the edge `none` misses no instant."""
    trigger = child(parent, tag)
    condition = child(child(trigger, "ConditionGroup"), "Condition", name=name, delay=0, conditionEdge="none")
    by_value = child(condition, "ByValueCondition")
    child(by_value, "SimulationTimeCondition", value=version.time_value(seconds), rule=version.rule)
    return trigger


def stop_trigger(storyboard: Element, seconds: float, version: Version) -> Element:
    """Add the end of the scenario, the last child of its `Storyboard`."""
    return time_trigger(storyboard, "StopTrigger", "end_of_recording", seconds, version)


def world_position(parent: Element, pose: Sequence[float], below: float = 0.0) -> Element:
    """Add a position; `pose` is x, y, heading of the reference point (`Recording.rear_axle`), `below` the road [m]."""
    x, y, heading = (float(value) for value in pose)
    z = {"z": -below} if below else {}
    return child(child(parent, "Position"), "WorldPosition", x=x, y=y, **z, h=heading)


def teleport(parent: Element, pose: Sequence[float], below: float = 0.0) -> Element:
    """Add a private action that puts an entity at a pose of its reference point."""
    return world_position(child(child(parent, "PrivateAction"), "TeleportAction"), pose, below)


def start_speed(parent: Element, speed: float, version: Version) -> Element:
    """Add a private action that gives an entity a speed [m/s] at once."""
    speed = speed if version.reverse_speed else max(speed, 0.0)
    return speed_action(child(parent, "PrivateAction"), AT_ONCE, number(speed))


def speed_action(private_action: Element, dynamics: Mapping[str, str], speed: str) -> Element:
    """Add a change to a speed [m/s], with these attributes of its dynamics."""
    action = child(child(private_action, "LongitudinalAction"), "SpeedAction")
    child(action, "SpeedActionDynamics", **dynamics)
    return child(child(action, "SpeedActionTarget"), "AbsoluteTargetSpeed", value=speed)


# -- participants ------------------------------------------------------------------------------------------------------

UNBOUNDED_SPEED = 100.0
"""`maxSpeed` of an actor without a speed limit [m/s]; a faster run has its own top speed instead."""
CATEGORY = {"Vehicle": "vehicleCategory", "Pedestrian": "pedestrianCategory", "MiscObject": "miscObjectCategory"}
WALKER = "walker.pedestrian.0001"
"""Model that 1.0 requires for every pedestrian: the name of CARLA's first."""


def add_entities(
    root: Element,
    recording: Recording,
    names: Sequence[str],
    version: Version,
    properties: Sequence[Mapping[str, str]] = (),
    models: Sequence[str] = (),
) -> Element:
    """Add all actors under the names of `entity_names`, with more properties and a player's `models` if given."""
    entities = child(root, "Entities")
    for index, actor in enumerate(recording.actors):
        scenario_object = child(entities, "ScenarioObject", name=names[index])
        top_speed = float(np.abs(recording.states[:, index, State.SPEED]).max(initial=0.0))
        model = models[index] if models else ""
        element = _entity(scenario_object, actor, model or names[index], top_speed, version)
        if model and "model" in element.attrib:
            element.set("model", model)
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
    """Return the fields for which the element of this kind has no place."""
    if KINDS[actor.kind].tag != "Vehicle":
        return FIELDS[1:]
    mass = () if version.vehicle_mass else ("mass",)
    return mass if np.isfinite(actor.max_speed) else (*mass, "max_speed")


def _own_properties(actor: RecordedActor, *, ego: bool, carried: Sequence[str]) -> dict[str, str]:
    """Return the properties; `type` marks the ego for ScenarioRunner, `plineInterpolation` is for esmini."""
    return {
        "type": "ego_vehicle" if ego else "simulation",
        "plineInterpolation": "segment",
        **of_actor(actor, carried),
    }


def _properties(parent: Element, properties: Mapping[str, str]) -> None:
    element = child(parent, "Properties")
    for name, value in properties.items():
        child(element, "Property", name=name, value=literal(value))


# -- weather -----------------------------------------------------------------------------------------------------------

CLEAR = 100_000.0
"""`visualRange` without fog [m], for versions that require it."""
NOON = "2020-06-21T12:00:00"


def add_environment(actions: Element, recording: Recording, version: Version) -> None:
    """Write the weather as the first of the actions of `Init`; nothing if the recording has none."""
    said = recording.surroundings
    if said is None or said.friction is said.sight is None:
        return
    holder = child(child(actions, "GlobalAction"), "EnvironmentAction")
    environment = child(holder, "Environment", name="environment")
    if version.whole_environment:
        child(environment, "TimeOfDay", animation="false", dateTime=NOON)
    _add_weather(environment, said, version)
    if said.friction is not None or version.whole_environment:
        factor = 1.0 if said.friction is None else said.friction
        child(environment, "RoadCondition", frictionScaleFactor=factor)


def _add_weather(environment: Element, said: Surroundings, version: Version) -> None:
    sight = CLEAR if said.sight is None else said.sight
    if version.whole_environment:
        weather = child(environment, "Weather", cloudState="free")
        child(weather, "Sun", intensity=1.0, azimuth=0.0, elevation=1.0)
        child(weather, "Fog", visualRange=sight)
        child(weather, "Precipitation", precipitationType="dry", intensity=0.0)
    elif said.sight is not None:
        child(child(environment, "Weather"), "Fog", visualRange=sight)


def remarks_on_environment(recording: Recording) -> Iterator[str]:
    """Yield a remark for each property of the weather that OpenSCENARIO cannot express."""
    said = recording.surroundings
    if said is not None and said.light is not None:
        yield f"OpenSCENARIO has no place for `light` of the environment, {said.light:g}: it is left out"
