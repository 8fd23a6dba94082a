"""A replay for CARLA's ScenarioRunner, with a controller file that moves all actors exactly as recorded.

ScenarioRunner reads OpenSCENARIO 1.0, and takes the name of a vehicle for a blueprint of CARLA. Without this controller
it snaps trajectories to the middle of lanes. It spawns all actors at the start, and an actor that appears later as a
second one. So all actors are spawned at the start, and an absent actor is placed under the road.

Source: ScenarioRunner 0.9.16, `srunner/tools/openscenario_parser.py`, `srunner/scenariomanager/actorcontrols`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from engine.interchange.contract import Export, ExportOptions
from engine.interchange.openscenario.document import (
    add_environment,
    plain_name,
    start_speed,
    stop_trigger,
    teleport,
    time_trigger,
)
from engine.interchange.openscenario.versions import Version
from engine.interchange.openscenario.write import (
    Stretch,
    add_group,
    begin_replay,
    follow_trajectory,
    stretches,
)
from engine.interchange.recording import RecordedActor, Recording
from engine.interchange.xml_writing import Element, child, number, xml_text
from engine.vocabulary import ActorKind, State

# -- blueprints --------------------------------------------------------------------------------------------------------


class Blueprint(NamedTuple):
    """A vehicle or person of CARLA, by its bounding box [m]."""

    name: str
    length: float
    width: float


BLUEPRINTS: Mapping[ActorKind, tuple[Blueprint, ...]] = MappingProxyType(
    {
        ActorKind.CAR: (
            Blueprint("vehicle.audi.a2", 3.71, 1.79),
            Blueprint("vehicle.audi.etron", 4.86, 2.03),
            Blueprint("vehicle.audi.tt", 4.18, 1.99),
            Blueprint("vehicle.chevrolet.impala", 5.36, 2.03),
            Blueprint("vehicle.citroen.c3", 3.99, 1.85),
            Blueprint("vehicle.dodge.charger_2020", 5.01, 1.88),
            Blueprint("vehicle.ford.ambulance", 6.37, 2.35),
            Blueprint("vehicle.ford.crown", 5.37, 1.80),
            Blueprint("vehicle.ford.mustang", 4.72, 1.89),
            Blueprint("vehicle.lincoln.mkz_2020", 4.89, 1.84),
            Blueprint("vehicle.mercedes.coupe_2020", 4.67, 1.81),
            Blueprint("vehicle.mercedes.sprinter", 5.92, 1.99),
            Blueprint("vehicle.micro.microlino", 2.21, 1.48),
            Blueprint("vehicle.nissan.micra", 3.63, 1.85),
            Blueprint("vehicle.nissan.patrol", 4.60, 1.93),
            Blueprint("vehicle.seat.leon", 4.19, 1.82),
            Blueprint("vehicle.tesla.model3", 4.79, 2.16),
            Blueprint("vehicle.toyota.prius", 4.51, 2.01),
        ),
        ActorKind.TRUCK: (
            Blueprint("vehicle.carlamotors.carlacola", 5.20, 2.63),
            Blueprint("vehicle.carlamotors.european_hgv", 7.94, 2.89),
            Blueprint("vehicle.carlamotors.firetruck", 8.47, 2.89),
            Blueprint("vehicle.tesla.cybertruck", 6.27, 2.39),
        ),
        ActorKind.BUS: (
            Blueprint("vehicle.mitsubishi.fusorosa", 10.27, 3.94),
            Blueprint("vehicle.mercedes.sprinter", 5.92, 1.99),
        ),
        ActorKind.MOTORCYCLE: (
            Blueprint("vehicle.harley-davidson.low_rider", 2.35, 0.77),
            Blueprint("vehicle.kawasaki.ninja", 2.04, 0.80),
            Blueprint("vehicle.vespa.zx125", 1.82, 0.87),
            Blueprint("vehicle.yamaha.yzf", 2.19, 0.87),
        ),
        ActorKind.BICYCLE: (
            Blueprint("vehicle.bh.crossbike", 1.51, 0.87),
            Blueprint("vehicle.diamondback.century", 1.66, 0.58),
            Blueprint("vehicle.gazelle.omafiets", 1.84, 0.66),
        ),
        ActorKind.PEDESTRIAN: (
            Blueprint("walker.pedestrian.0001", 0.38, 0.38),
            Blueprint("walker.pedestrian.0009", 0.50, 0.50),
        ),
        ActorKind.OBSTACLE: (
            Blueprint("static.prop.box01", 0.65, 0.65),
            Blueprint("static.prop.busstop", 3.88, 1.89),
            Blueprint("static.prop.clothcontainer", 1.24, 1.89),
            Blueprint("static.prop.container", 1.93, 1.01),
            Blueprint("static.prop.glasscontainer", 1.95, 2.01),
            Blueprint("static.prop.streetbarrier", 1.21, 0.37),
            Blueprint("static.prop.trampoline", 4.13, 4.13),
            Blueprint("static.prop.trashcan01", 0.64, 0.57),
        ),
    }
)
"""Blueprints by kind. Sizes are those of CARLA 0.9.16, to a centimetre."""
FITS = 0.1
"""Difference of length or width [m] from which on a remark names the blueprint."""


def blueprint_of(actor: RecordedActor) -> Blueprint:
    """Return the blueprint of the actor's kind with the nearest outline; the first of two equally near ones."""
    return min(
        BLUEPRINTS[actor.kind], key=lambda each: float(np.hypot(each.length - actor.length, each.width - actor.width))
    )


# -- motion: everybody is there all the time, and under the road while it is not in the case ---------------------------

DEEP = 50.0
"""Depth under the road of an absent actor [m]; each further actor is `ROOM` deeper."""
ROOM = 5.0


def present_stretches(recording: Recording, actor: int) -> list[Stretch]:
    """Return the stretches of an actor from the beginning to the end, including those under the road."""
    parts, deep, end = stretches(recording, actor), DEEP + ROOM * actor, float(recording.time[-1])
    pieces: list[Stretch] = []
    if parts[0].starts_late:
        pieces.append(_under_the_road(parts[0], 0, 0.0, float(parts[0].time[0]), deep))
    for part in parts:
        pieces.append(part)
        if part.gone is not None:
            pieces.append(_under_the_road(part, -1, part.gone, max(end, part.gone + recording.step), deep))
    return pieces


def _under_the_road(part: Stretch, sample: int, begin: float, end: float, deep: float) -> Stretch:
    """Return a stretch at rest below the pose of one sample."""
    poses = np.repeat(part.poses[[sample]], 2, axis=0)
    return replace(part, time=np.array([begin, end]), poses=poses, below=deep)


# -- the storyboard ----------------------------------------------------------------------------------------------------

MODULE = "cortexc_replay.py"
PEDALS = ("Throttle", "Brake", "Clutch", "ParkingBrake")


def add_storyboard(root: Element, recording: Recording, names: Sequence[str], version: Version) -> None:
    """Add the initial places, the motion and the controllers of all actors."""
    storyboard = child(root, "Storyboard")
    actions = child(child(storyboard, "Init"), "Actions")
    add_environment(actions, recording, version)
    act = child(child(storyboard, "Story", name="replay_story"), "Act", name="replay_act")
    for actor, name in enumerate(names):
        parts = present_stretches(recording, actor)
        private = child(actions, "Private", entityRef=name)
        teleport(private, parts[0].poses[0], parts[0].below)
        start_speed(private, float(recording.states[0, actor, State.SPEED]) * (not parts[0].below), version)
        _add_controller(private, recording.actors[actor], name)
        _add_parts(act, name, parts, version)
    time_trigger(act, "StartTrigger", "replay_begins", 0.0, version)
    stop_trigger(storyboard, float(recording.time[-1]), version)


def _add_parts(act: Element, name: str, parts: Sequence[Stretch], version: Version) -> None:
    maneuver = child(add_group(act, name), "Maneuver", name=f"{name}_maneuver")
    for count, part in enumerate(parts, start=1):
        event = child(maneuver, "Event", name=f"{name}_event_{count}", priority=version.priority)
        action = child(event, "Action", name=f"{name}_moves_{count}")
        follow_trajectory(action, _with_two_vertices(part), f"{name}_trajectory_{count}", version)
        time_trigger(event, "StartTrigger", f"{name}_begins_{count}", float(part.time[0]), version)


def _with_two_vertices(part: Stretch) -> Stretch:
    """Return the stretch with at least two vertices, as a polyline requires; a single sample lasts a moment."""
    if len(part.vertices()[0]) > 1:
        return part
    return replace(part, time=part.time[0] + np.array([0.0, 1e-3]), poses=np.repeat(part.poses[:1], 2, axis=0))


def _add_controller(private: Element, actor: RecordedActor, name: str) -> None:
    """Add the private action that assigns the controller module to an entity."""
    holder = child(child(private, "PrivateAction"), "ControllerAction")
    controller = child(child(holder, "AssignControllerAction"), "Controller", name=f"{name}_controller")
    properties = child(controller, "Properties")
    for key, value in (("module", MODULE), ("ahead", number(actor.rear_to_center)), ("physics", "off")):
        child(properties, "Property", name=key, value=value)
    override = child(holder, "OverrideControllerValueAction")
    for pedal in PEDALS:
        child(override, pedal, value=0, active="false")
    child(override, "SteeringWheel", value=0, active="false")
    child(override, "Gear", number=0, active="false")


# -- the file ----------------------------------------------------------------------------------------------------------


def write_for_carla(recording: Recording, stem: str, options: ExportOptions, road_file: str) -> Export:
    """Write `<stem>.xosc` and the controller that it names; see `write_trajectories`.

    Raises:
        InterchangeError: the recording is empty or broken, or the ego is never present.
    """
    begun = begin_replay(recording, options, road_file, plain_name(stem), lambda actor: blueprint_of(actor).name)
    add_storyboard(begun.root, begun.shown, begun.names, begun.version)
    remarks = (*begun.remarks, *_remarks(begun.shown))
    return Export({f"{stem}.xosc": xml_text(begun.root), MODULE: controller_text()}, remarks)


def controller_text() -> str:
    """Return the source text of the controller."""
    return (files("engine.interchange.openscenario") / MODULE).read_text(encoding="utf-8")


def _remarks(recording: Recording) -> Iterator[str]:
    for actor in recording.actors:
        near = blueprint_of(actor)
        if max(abs(near.length - actor.length), abs(near.width - actor.width)) > FITS:
            size = f"{near.length:g} m x {near.width:g} m in place of {actor.length:g} m x {actor.width:g} m"
            yield f"`{actor.name}` is {near.name} in CARLA, {size}: outlines touch earlier or later there"
    away = [actor.name for index, actor in enumerate(recording.actors) if not recording.there[:, index].all()]
    if away:
        yield f"not there all the time: {', '.join(away)}; kept {DEEP:g} m and more under the road while away"
    if recording.actors[0].kind == ActorKind.PEDESTRIAN:
        yield "ScenarioRunner knows no ego on foot: it is one of the others there"
