"""`read_openscenario`: reader of scenarios with timed polylines as recordings, with their roads, from any tool.
Versions 1.0 to 1.3.

file -> xml -> parameters and catalogs put in -> entities, road -> actions in the order of time -> tracks (motion) ->
one grid of samples, with a check of their speeds. Every defect of a file is an `InterchangeError`.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from engine.errors import InterchangeError, name_cure, quoted
from engine.interchange.after_contact import FACT, up_to_contact
from engine.interchange.openscenario.read.actions import (
    ACTED_ON,
    TimedAction,
    condition_name,
    is_steered,
    read_path,
    stop_time,
    timed_actions,
)
from engine.interchange.openscenario.read.entities import BODIES, Entity, read_entities
from engine.interchange.openscenario.read.motion import KINDS, Coast, Placed, Polyline, Surroundings, Track, place
from engine.interchange.openscenario.read.parameters import Catalogs, substituted
from engine.interchange.openscenario.read.samples import Grid, Part, grid, part_of, presence, states
from engine.interchange.openscenario.read.speeds import judged
from engine.interchange.own_metadata import FILE_PREFIX, TIME
from engine.interchange.recording import Provenance, Recording
from engine.interchange.road_levels import level_notes
from engine.opendrive.read import read_opendrive
from engine.opendrive.roads import OdrNetwork
from engine.unread import unread_elements
from engine.vocabulary import LEVEL, State
from engine.xml import LIMITS, NUMBER, Limits, Node, read_xml

# -- elements that are read --------------------------------------------------------------------------------------------

READ: Mapping[str, Collection[str] | None] = dict.fromkeys(
    (
        *("OpenSCENARIO", "FileHeader", "ParameterDeclarations", "CatalogLocations", "RoadNetwork", "LogicFile"),
        *("Entities", "ScenarioObject", "CatalogReference", "Properties", "Property", *BODIES, "BoundingBox", "Center"),
        *("Dimensions", "Performance", "Axles", "FrontAxle", "RearAxle", "Storyboard", "Init", "Actions", "Private"),
        *("PrivateAction", "GlobalAction", "EntityAction", *ACTED_ON, "Position", *KINDS, "Orientation"),
        *("LongitudinalAction", "LateralAction", "RoutingAction", "SpeedActionDynamics", "SpeedActionTarget"),
        *("AbsoluteTargetSpeed", "Trajectory", "TrajectoryRef", "Shape", "Polyline", "Vertex", "TimeReference"),
        *("Timing", "TrajectoryFollowingMode", "Story", "Act", "ManeuverGroup", "Actors", "EntityRef", "Maneuver"),
        *("Event", "Action", "StartTrigger", "StopTrigger", "ConditionGroup", "Condition", "ByValueCondition"),
        *(
            "ParameterDeclaration",
            "ParameterAssignment",
            "SimulationTimeCondition",
            "EnvironmentAction",
            "Environment",
            "Weather",
            "ParameterAssignments",
        ),
    )
) | {
    "WorldPosition": ("x", "y", "z", "h"),
    "RelativeWorldPosition": ("entityRef", "dx", "dy"),
    "RelativeObjectPosition": ("entityRef", "dx", "dy"),
    "Orientation": ("type", "h"),
    "Trajectory": ("name",),
    "SpeedActionDynamics": ("dynamicsShape", "dynamicsDimension"),
}
"""Elements of a scenario that are read, or contain elements that are read, and the attributes that are read of elements
whose other attributes change a run.
"""
REMARKED = ("TrafficSignals", "ByEntityCondition")
"""Elements with remarks of their own, in addition to actions that are not replayed."""


# -- actions in order of time: a track for each entity, and remarks on omissions of a replay ---------------------------


@dataclass
class _Stage:
    """Tracks of all entities, extended action after action."""

    road: OdrNetwork | None
    catalogs: Catalogs
    tracks: dict[str, Track]
    speeds: dict[str, float] = field(default_factory=dict)
    """Initial speeds of entities."""

    def around(self, time: float) -> Surroundings:
        def other(name: str, node: Node) -> Placed:
            track = self.track(name, node)
            if (placed := track.placed_at(time)) is None:
                raise node.error(f"where `{name[:40]}` is at {time:g} s is not known here", "place it before")
            return placed

        return Surroundings(self.road, other)

    def track(self, name: str, node: Node) -> Track:
        if name not in self.tracks:
            raise node.error(f"no actor is called `{name[:40]}`", name_cure(name, self.tracks))
        return self.tracks[name]

    def does(self, timed: TimedAction) -> None:
        track = self.track(timed.entity, timed.action)
        self.tracks[timed.entity] = self._after(track, timed)

    def _after(self, track: Track, timed: TimedAction) -> Track:
        time, action = timed.time, timed.action
        match action.tag:
            case "FollowTrajectoryAction":
                path = read_path(action, time, self._speed(timed.entity), self.around(time), self.catalogs)
                return _moved_under(track, action, time).with_leg(path)
            case "TeleportAction":
                return _moved_under(track, action, time).with_leg(self._placed(action, timed))
            case "AddEntityAction":
                return track.enters(time).with_leg(self._placed(action, timed))
            case "DeleteEntityAction":
                return track.leaves(time)
            case _:
                return self._at_speed(track, timed)

    def _speed(self, entity: str) -> float:
        """Return the speed at which it begins its next leg."""
        last = self.tracks[entity].legs[-1:]
        return last[0].end_speed if last and isinstance(last[0], Polyline) else self.speeds.get(entity, 0.0)

    def _placed(self, action: Node, timed: TimedAction) -> Coast:
        placed = place(action.need("Position"), self.around(timed.time))
        return Coast(timed.time, placed, self.speeds.get(timed.entity, 0.0) if timed.time == 0.0 else 0.0, self.road)

    def _at_speed(self, track: Track, timed: TimedAction) -> Track:
        target = timed.action.need("SpeedActionTarget")
        absolute = target.find("AbsoluteTargetSpeed")
        if absolute is None:
            raise target.error("only an absolute speed is read here", "write <AbsoluteTargetSpeed value=…/>")
        speed = absolute.number("value", low=-1000.0, high=1000.0)
        self.speeds[timed.entity] = speed
        legs = tuple(
            Coast(leg.begin, leg.placed, speed, leg.road) if isinstance(leg, Coast) else leg for leg in track.legs
        )
        return Track(legs, track.absent)


ABSENT_DEPTH = 40.0
"""Depth under the road [m] from which on an entity is absent: some players place absent entities there."""


def _moved_under(track: Track, action: Node, time: float) -> Track:
    """Return the track of an entity that is put under the road, or comes up from there."""
    position = next((node for node in action.walk() if node.tag == "WorldPosition"), None)
    if position is None:
        return track
    away = bool(track.absent) and track.absent[-1][1] == math.inf
    if position.number("z", 0.0) < -ABSENT_DEPTH:
        return track if away else track.leaves(time)
    return track.enters(time) if away else track


def read_tracks(
    entities: Sequence[Entity], actions: Sequence[TimedAction], road: OdrNetwork | None, catalogs: Catalogs
) -> tuple[list[Track], list[str]]:
    """Return one track per entity, in their order, and remarks.

    Raises:
        InterchangeError: an entity is moved without a trajectory, or has no place.
    """
    stage = _Stage(road, catalogs, {entity.node.text("name"): Track() for entity in entities})
    for timed in actions:
        if timed.is_read:
            stage.does(timed)
        else:
            stage.track(timed.entity, timed.action)
    remarks = _of_others(stage, [timed for timed in actions if not timed.is_read])
    steered = dict.fromkeys(timed.entity for timed in actions if is_steered(timed.action))
    remarks += [f"{name} may steer along its trajectory (mode `follow`); here it is on it exactly" for name in steered]
    for entity in entities:
        remarks += _of_track(entity, stage.tracks[entity.node.text("name")])
    return list(stage.tracks.values()), remarks


def _of_others(stage: _Stage, actions: Sequence[TimedAction]) -> list[str]:
    """Return remarks on actions that require a simulator, of entities that also have a trajectory."""
    for timed in actions:
        if not stage.tracks[timed.entity].follows:
            raise timed.action.error(
                f"`{timed.entity}` is moved by <{timed.action.tag}>, which only a simulator can work out",
                "record the run in a simulator, and import the recording",
            )
    pairs = dict.fromkeys((timed.entity, timed.action.tag) for timed in actions)
    return [f"<{tag}> of {name} is not replayed: it follows its trajectory alone" for name, tag in pairs]


def _of_track(entity: Entity, track: Track) -> list[str]:
    """Return remarks on assumptions of a replay."""
    name = entity.node.text("name")
    if not track.legs:
        raise entity.node.error(f"nothing says where `{name}` is", "place it by a TeleportAction in <Init>")
    said = [f"{name} jumps {distance:.1f} m at {time:g} s" for time, distance in track.jumps()]
    first = track.legs[0]
    instant = len(entity.properties.get(TIME, "").split()) == 1  # present for one instant, in a recording of cortexc
    if isinstance(first, Coast) and first.speed and not track.follows and not instant:
        said.append(f"{name} follows no trajectory: it goes on at {first.speed:g} m/s, along its lane where known")
    elif isinstance(first, Polyline) and first.begin > 0.0 and not track.absent:
        said.append(f"nothing says where {name} is before {first.begin:g} s: it waits where its trajectory begins")
    return said


# -- the recording -----------------------------------------------------------------------------------------------------

SHORTEST_STEP = 1e-4
"""[s]"""


@dataclass(frozen=True)
class Imported:
    """Content of a file, and remarks on facts that could not be imported."""

    recording: Recording
    """Recording without contact, which `measure` finds."""
    road: OdrNetwork | None
    remarks: tuple[str, ...]


def read_openscenario(
    path: str | Path, *, ego: str | None = None, step: float | None = None, limits: Limits = LIMITS
) -> Imported:
    """Read a scenario in which every entity that moves follows a timed polyline.

    Actor 0 is the entity `ego`, or the entity named ego or hero, or the first. Without `step` [s] samples are at the
    times of vertices, and every 0.05 s where these are further than 0.2 s apart.

    Raises:
        InterchangeError: the file, its road or a catalog cannot be read, or it needs a simulator to be played.
    """
    path = Path(path)
    _check_step(step)
    raw = _of_kind(read_xml(path, "OpenSCENARIO", limits))
    scenario = substituted(raw)
    road, remarks = _read_road(scenario, path.parent, limits)
    catalogs = Catalogs(scenario, path.parent, limits)
    entities = read_entities(scenario, catalogs, ego)
    storyboard = scenario.need("Storyboard")
    actions = timed_actions(storyboard)
    tracks, said = read_tracks(entities, actions, road, catalogs)
    end, on_end = _read_end(storyboard)
    parts = [part_of(entity, track) for entity, track in zip(entities, tracks, strict=True)]
    times = grid(parts, end, step, path.name)
    parts = judged(parts, times.given)
    recording = replace(_recording(path, parts, times), provenance=_provenance(raw, path))
    if road is not None:
        recording = replace(recording, buildings=road.buildings)
    jumps = (presence(part, times.times)[1] for part in parts)
    on_motion = [*(remark for part in parts for remark in part.remarks), *filter(None, jumps)]
    recording, on_contact = _motion_alone(recording)
    unread = unread_elements(scenario, READ, (*REMARKED, *(timed.action.tag for timed in actions if not timed.is_read)))
    flat = () if road is None else level_notes(road)
    on_heights = (*flat, *_on_heights(scenario))
    return Imported(
        recording, road, (*remarks, *said, *on_heights, *on_motion, *times.remarks, *on_end, *on_contact, *unread)
    )


def _on_heights(scenario: Node) -> Iterator[str]:
    """Yield the remark on world positions of different heights, but for those of actors that are not there."""
    every = (node for node in scenario.walk() if node.tag == "WorldPosition" and node.has("z"))
    heights = [z for node in every if (z := node.number("z")) >= -ABSENT_DEPTH]
    if heights and max(heights) - min(heights) >= LEVEL:
        yield f"positions have heights from {min(heights):g} to {max(heights):g} m: all are judged in one plane"


GOING = {"through": "go on through each other", "stop": "stand"}
"""Motion after contact in files of cortexc that is not motion of the run."""


def _motion_alone(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """Return the recording without such motion after contact, and a remark on it."""
    facts = recording.provenance.facts
    after, time = facts.get(FACT), facts.get("contact_time", "")
    if after not in GOING or not NUMBER.fullmatch(time):
        return recording, ()
    said = f"what follows contact at {float(time):.3f} s is passed over: all {GOING[after]}, for players to see it"
    return up_to_contact(recording, float(time)), (said,)


def _check_step(step: float | None) -> None:
    if step is not None and not SHORTEST_STEP <= step < math.inf:
        raise InterchangeError(f"a step of {step:g} s", f"take one of at least {SHORTEST_STEP:g} s")


def _read_end(storyboard: Node) -> tuple[float, list[str]]:
    """Return the latest end [s], and remarks on ends that require a simulator."""
    end, passed_over = stop_time(storyboard)
    names = dict.fromkeys(map(condition_name, passed_over))
    return end, [f"the end by <{name}> is not taken over: it ends with the last vertex" for name in names]


def _of_kind(root: Node) -> Node:
    """Return the root of a scenario of a supported version, or raise InterchangeError."""
    header = root.need("FileHeader")
    major, minor = header.text("revMajor"), header.text("revMinor", "0")
    if major != "1":
        raise header.error(
            f"this is OpenSCENARIO {quoted(major)[1:-1]}.{quoted(minor)[1:-1]}", "1.0 to 1.3 are read: convert it"
        )
    for tag, kind in (("Catalog", "a catalog"), ("ParameterValueDistribution", "a distribution of parameters")):
        if (node := root.find(tag)) is not None:
            raise node.error(f"this is {kind}, not a scenario", "name the .xosc that uses it")
    return root


def _read_road(scenario: Node, folder: Path, limits: Limits) -> tuple[OdrNetwork | None, list[str]]:
    """Return the road that the scenario names, searched for next to the scenario, and remarks."""
    network = scenario.find("RoadNetwork")
    lights = network.find("TrafficSignals") if network else None
    remarks = ["its traffic lights are not taken over"] if lights and lights.children else []
    node = network.find("LogicFile") if network else None
    name = node.text("filepath").replace("\\", "/") if node else ""
    if node is None or not name:
        return None, remarks
    if "://" in name:
        raise node.error(f"the road {quoted(name)} lies elsewhere, and nothing is fetched", "put the .xodr beside it")
    if not Path(name).suffix:
        return None, [*remarks, f"the road {quoted(name)} is the name of a map, not a file: it is not read"]
    road = read_opendrive(_beside(node, folder, name), limits)
    return road, [*remarks, *road.notes, "whether an actor leaves the road is not judged: that needs a road of ours"]


def _beside(node: Node, folder: Path, name: str) -> Path:
    """Return the path of the road file: that in the scenario, else in the scenario's own folder."""
    for candidate in (folder / name, folder / Path(name).name):
        try:
            if candidate.exists():
                return candidate
        except (OSError, ValueError):
            continue
    try:
        others = [path.name for path in folder.glob("*.xodr")]
    except OSError:
        others = []
    near = name_cure(Path(name).name, others)
    cure = near or "put it beside the scenario, or take <LogicFile> out if all positions are world positions"
    raise node.error(f"the road file {quoted(name)} is not there", cure)


def _recording(path: Path, parts: Sequence[Part], times: Grid) -> Recording:
    return Recording(
        name=path.stem or "imported",
        actors=tuple(part.entity.actor for part in parts),
        time=times.times,
        states=np.stack([states(part, times.times) for part in parts], axis=1),
        step=times.step,
        commands=all(map(_carries_commands, parts)),
    )


def _carries_commands(part: Part) -> bool:
    return part.believed and part.carried is not None and State.STEER in part.carried.columns


def _title(description: str, facts: Mapping[str, str]) -> str:
    """Return the title of a description: those of cortexc continue with facts that are also parameters."""
    return description.split(f" - {next(iter(facts))}: ")[0] if facts else description


def _provenance(root: Node, path: Path) -> Provenance:
    """Return the provenance from the header, and from the parameters of files of cortexc."""
    header = root.need("FileHeader")
    declarations = root.find("ParameterDeclarations")
    declared = {
        row.text("name"): row.text("value", "")
        for row in (declarations.every("ParameterDeclaration") if declarations else [])
    }
    facts = {name.removeprefix(FILE_PREFIX): value for name, value in declared.items() if name.startswith(FILE_PREFIX)}
    genome = {name: value for name, value in declared.items() if not name.startswith(FILE_PREFIX)} if facts else {}
    version = f"OpenSCENARIO 1.{header.text('revMinor', '0')[:3]}"
    return Provenance(
        title=_title(header.text("description", ""), facts)[:500],
        author=header.text("author", "")[:100],
        date=header.text("date", "")[:40] or Provenance().date,
        facts={**facts, "read from": path.name, "format": version},
        genome=genome,
    )
