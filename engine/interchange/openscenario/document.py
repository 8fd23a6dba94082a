"""The parts of a scenario that do not depend on how its motion is said: head, parameters, road, times, places."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from engine.interchange.openscenario.names import literal, unique_names
from engine.interchange.openscenario.versions import Version
from engine.interchange.properties import FILE_PREFIX
from engine.interchange.recording import Provenance, Recording
from engine.interchange.xml_text import Element, child, decimal, number

LONGEST_DESCRIPTION = 500
"""Characters; what is longer stands in the parameters alone."""
AT_ONCE: Mapping[str, str] = {"dynamicsShape": "step", "value": "0", "dynamicsDimension": "time"}
"""How a speed is taken on that is there without any time."""


@dataclass(frozen=True)
class ParameterDeclaration:
    """One that a file declares: its name is made plain and unique, values of type `double` are numbers."""

    name: str
    value: str
    kind: str = "string"
    low: float = float("-inf")
    """Bounds within which it may be varied, where the version can say them."""
    high: float = float("inf")


@dataclass(frozen=True)
class Document:
    """A scenario up to its `RoadNetwork`; what follows is added to the root."""

    root: Element
    network: Element


def new_document(
    recording: Recording, version: Version, road_file: str | None, parameters: Sequence[ParameterDeclaration] = ()
) -> Document:
    """A scenario with its head; `parameters` stand before those of provenance."""
    root = Element("OpenSCENARIO")
    header(root, recording.provenance, version)
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


def header(root: Element, provenance: Provenance, version: Version) -> Element:
    """Who wrote it, when, and what is to be seen."""
    return child(
        root,
        "FileHeader",
        revMajor=1,
        revMinor=version.minor,
        date=date_and_time(provenance.date),
        description=literal(description(provenance)),
        author=literal(provenance.author),
    )


def date_and_time(text: str) -> str:
    """As XML wants it; a date that is none, such as a foreign file may have had, becomes that of no date."""
    try:
        return datetime.fromisoformat(text).isoformat()
    except ValueError:
        return Provenance().date


def description(provenance: Provenance) -> str:
    """Title and facts in one line."""
    facts = "; ".join(f"{name}: {value}" for name, value in provenance.facts.items())
    text = " - ".join(part for part in (provenance.title, facts) if part) or "scenario"
    return text if len(text) <= LONGEST_DESCRIPTION else text[: LONGEST_DESCRIPTION - 3] + "..."


def provenance_parameters(recording: Recording) -> tuple[ParameterDeclaration, ...]:
    """The genome by the names of its params, the facts and what is known of first contact as `cortexc_...`."""
    provenance = recording.provenance
    genome = (ParameterDeclaration(name, value, value_kind(value)) for name, value in provenance.genome.items())
    facts = (ParameterDeclaration(f"{FILE_PREFIX}{name}", value) for name, value in provenance.facts.items())
    return (*genome, *facts, *_contact_parameters(recording))


def _contact_parameters(recording: Recording) -> tuple[ParameterDeclaration, ...]:
    """When, and between which two in the order of the file."""
    if recording.contact is None:
        return ()
    first, second = recording.contact.actors
    return (
        ParameterDeclaration(f"{FILE_PREFIX}contact_time", number(recording.contact.time), "double"),
        ParameterDeclaration(f"{FILE_PREFIX}contact_actors", f"{first} {second}"),
    )


def value_kind(text: str) -> str:
    """`double` for a finite number, else `string`: `41.5 km/h` keeps its unit."""
    try:
        return "double" if abs(float(text)) < float("inf") and text.strip("+-.eE0123456789") == "" else "string"
    except ValueError:
        return "string"


def time_trigger(parent: Element, tag: str, name: str, seconds: float, version: Version) -> Element:
    """A `StartTrigger` or `StopTrigger` that holds from an instant on [s]; the edge `none` misses no instant."""
    trigger = child(parent, tag)
    condition = child(child(trigger, "ConditionGroup"), "Condition", name=name, delay=0, conditionEdge="none")
    by_value = child(condition, "ByValueCondition")
    child(by_value, "SimulationTimeCondition", value=version.time_value(seconds), rule=version.rule)
    return trigger


def stop_trigger(storyboard: Element, seconds: float, version: Version) -> Element:
    """The end of the scenario, the last child of its `Storyboard`."""
    return time_trigger(storyboard, "StopTrigger", "end_of_recording", seconds, version)


def world_position(parent: Element, pose: Sequence[float]) -> Element:
    """`pose` is x, y, heading of the reference point, see `Recording.rear_axle`."""
    x, y, heading = (float(value) for value in pose)
    return child(child(parent, "Position"), "WorldPosition", x=x, y=y, h=heading)


def teleport(parent: Element, pose: Sequence[float]) -> Element:
    """A private action that puts an entity at a pose of its reference point."""
    return world_position(child(child(parent, "PrivateAction"), "TeleportAction"), pose)


def start_speed(parent: Element, speed: float, version: Version) -> Element:
    """A private action that gives an entity a speed [m/s] at once."""
    speed = speed if version.reverse_speed else max(speed, 0.0)
    return speed_action(child(parent, "PrivateAction"), AT_ONCE, number(speed))


def speed_action(private_action: Element, dynamics: Mapping[str, str], speed: str) -> Element:
    """Go to a speed [m/s], by those attributes of its dynamics."""
    action = child(child(private_action, "LongitudinalAction"), "SpeedAction")
    child(action, "SpeedActionDynamics", **dynamics)
    return child(child(action, "SpeedActionTarget"), "AbsoluteTargetSpeed", value=speed)
