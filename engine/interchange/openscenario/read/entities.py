"""Entities: `ScenarioObject` elements as actors, with the additional properties of files of cortexc.

Lengths in metres. The reference point is the middle of the rear axle on the ground, and `BoundingBox/Center` is the
position of the outline's centre relative to it (ASAM OpenSCENARIO XML 1.2, classes BoundingBox and Axles).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from engine.errors import InterchangeError, name_cure
from engine.interchange import own_metadata
from engine.interchange.openscenario.read.parameters import Catalogs
from engine.interchange.recording import MOST_ACTORS, RecordedActor
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind
from engine.xml import Node

EGO_NAMES = ("ego", "hero", "ego_vehicle", "egovehicle")
"""Names of the ego in esmini, in CARLA and in other tools; small letters."""
CATEGORIES: Mapping[str, ActorKind] = MappingProxyType(
    {
        "car": ActorKind.CAR,
        "van": ActorKind.CAR,
        "truck": ActorKind.TRUCK,
        "semitrailer": ActorKind.TRUCK,
        "trailer": ActorKind.TRUCK,
        "bus": ActorKind.BUS,
        "tram": ActorKind.BUS,
        "train": ActorKind.BUS,
        "motorbike": ActorKind.MOTORCYCLE,
        "bicycle": ActorKind.BICYCLE,
    }
)
EGO = "ego_vehicle"
"""Value of the ego's property `type`, by which CARLA's ScenarioRunner finds it."""
LONGEST = 1000.0
"""Maximum length of an outline [m]; a wall may be long."""


@dataclass(frozen=True)
class Entity:
    """An actor, the position of its outline relative to its reference point, and its `cortexc.…` properties."""

    actor: RecordedActor
    forward: float
    left: float
    properties: Mapping[str, str]
    node: Node
    is_ego: bool
    """True if its property `type` marks it as the ego."""


def read_entities(scenario: Node, catalogs: Catalogs, ego: str | None) -> list[Entity]:
    """Return all entities, the ego first.

    Raises:
        InterchangeError: there are none, too many, two of one name, or one without an outline.
    """
    objects = scenario.need("Entities").every("ScenarioObject")
    if not objects:
        raise scenario.need("Entities").error("no actor takes part", "write <ScenarioObject> elements")
    if len(objects) > MOST_ACTORS:
        raise objects[-1].error(f"{len(objects):,} take part", f"leave at most {MOST_ACTORS:,}")
    by_name: dict[str, Entity] = {}
    for node in objects:
        name = node.text("name")
        if name in by_name:
            raise node.error(f"two take part as `{name}`", f"rename one; see {by_name[name].node.place}")
        by_name[name] = _entity(node, name, catalogs)
    entities = _renamed(list(by_name.values()))
    first = _ego(entities, ego, scenario)
    return [first, *(each for each in entities if each is not first)]


def _renamed(entities: list[Entity]) -> list[Entity]:
    """Return the entities under the original names in files of cortexc, as some readers accept few letters only."""
    names = [own_metadata.name_in(entity.properties, entity.actor.name) for entity in entities]
    if len(set(names)) < len(names):
        return entities
    return [replace(e, actor=replace(e.actor, name=name)) for e, name in zip(entities, names, strict=True)]


def _ego(entities: list[Entity], ego: str | None, scenario: Node) -> Entity:
    """Return the entity of that name, as displayed or else as written in the file; without a name see `_usual_ego`."""
    shown, written = ([name(each) for each in entities] for name in (_shown_name, _written_name))
    if ego is None:
        return _usual_ego(entities)
    for names in (shown, written):
        if ego in names:
            return entities[names.index(ego)]
    raise InterchangeError(f"no actor is called `{ego}`", name_cure(ego, [*shown, *written]), scenario.file)


def _usual_ego(entities: list[Entity]) -> Entity:
    """Return the entity that a property marks as ego, as for ScenarioRunner; in files of cortexc the first; else the
    entity with a usual name, or the first.
    """
    if (said := next((each for each in entities if each.is_ego), None)) is not None:
        return said
    if any(own_metadata.NAME in each.properties for each in entities):
        return entities[0]
    return next((each for each in entities if _written_name(each).casefold() in EGO_NAMES), entities[0])


def _shown_name(entity: Entity) -> str:
    return entity.actor.name


def _written_name(entity: Entity) -> str:
    return entity.node.text("name")


def _entity(node: Node, name: str, catalogs: Catalogs) -> Entity:
    body = next((child for child in node.children if child.tag in ("CatalogReference", *BODIES)), None)
    if body is None:
        found = f"<{node.children[0].tag}>" if node.children else "nothing"
        raise node.error(f"`{name}` is {found}, which is not read here", f"write one of {', '.join(BODIES)}")
    if body.tag == "CatalogReference":
        body = catalogs.entry(body)
    if body.tag not in BODIES:
        raise body.error(f"`{name}` is a <{body.tag}>, which takes no part", f"name one of {', '.join(BODIES)}")
    said = _properties(body)
    kind = _kind(body, said)
    box = body.need("BoundingBox", "Center")
    forward = box.number("x", low=-LONGEST, high=LONGEST)
    actor = replace(_actor(name, kind, body, forward), **own_metadata.fields_in(said))
    is_ego = any(row.text("name") == "type" and row.text("value") == EGO for row in _rows(body))
    return Entity(actor, forward, box.number("y", low=-LONGEST, high=LONGEST), said, node, is_ego)


def _properties(body: Node) -> dict[str, str]:
    rows = _rows(body)
    return {row.text("name"): row.text("value") for row in rows if row.text("name").startswith(own_metadata.PREFIX)}


def _rows(body: Node) -> list[Node]:
    return (body.find("Properties") or body).every("Property")


def _kind(body: Node, said: own_metadata.Properties) -> ActorKind:
    """Return the kind of an element; files of cortexc name their kinds."""
    if (kind := own_metadata.kind_in(said)) is not None:
        return kind
    if body.tag != "Vehicle":
        return BODIES[body.tag]
    category = body.text("vehicleCategory")
    if category not in CATEGORIES:
        raise body.error(f"there is no vehicle category `{category[:40]}`", name_cure(category, CATEGORIES))
    return CATEGORIES[category]


def _actor(name: str, kind: ActorKind, body: Node, forward: float) -> RecordedActor:
    size, model = body.need("BoundingBox", "Dimensions"), MODELS[kind]
    performance = body.find("Performance") or Node("Performance", {}, body.file, body.line)
    return RecordedActor(
        name=name,
        kind=kind,
        length=size.number("length", low=SMALLEST, high=LONGEST),
        width=size.number("width", low=SMALLEST, high=LONGEST),
        rear_to_center=forward,
        wheelbase=_wheelbase(body, model.wheelbase),
        mass=body.number("mass", model.mass, low=0.0) or model.mass,
        max_acceleration=performance.number("maxAcceleration", model.max_acceleration, low=0.0, high=math.inf),
        max_braking=performance.number("maxDeceleration", model.max_braking, low=0.0, high=math.inf),
        max_steer=_max_steer(body, model.max_steer),
        max_speed=performance.number("maxSpeed", model.top_speed, low=0.0, high=math.inf),
    )


def _wheelbase(body: Node, default: float) -> float:
    front, rear = body.find("Axles", "FrontAxle"), body.find("Axles", "RearAxle")
    if front is None or rear is None:
        return default
    between = front.number("positionX") - rear.number("positionX")
    return between if SMALLEST <= between <= LONGEST else default


def _max_steer(body: Node, default: float) -> float:
    """Return the limit of the front axle [rad]; above a right angle it is in another unit, or the steering wheel's."""
    front = body.find("Axles", "FrontAxle")
    steer = front.number("maxSteering", default, low=0.0) if front else default
    return steer if steer <= math.pi / 2 else default


SMALLEST = 1e-6
"""Minimum length of an outline, or distance between two axles [m]."""
BODIES: Mapping[str, ActorKind] = MappingProxyType(
    {"Vehicle": ActorKind.CAR, "Pedestrian": ActorKind.PEDESTRIAN, "MiscObject": ActorKind.OBSTACLE}
)
