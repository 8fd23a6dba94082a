"""CARLA's recorder as text: the result of `client.show_recorder_file_info(FILE, True)`, saved in a file.

Source: CARLA's documentation, "Recorder", and its plugin's `CarlaRecorderQuery.cpp`: locations and boxes are
centimetres of Unreal Engine, rotations are (roll, pitch, yaw) in degrees, y points right of x, velocities are m/s. Only
recordings with additional data have boxes and velocities.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from engine.errors import InterchangeError, reading
from engine.interchange.logs.rows import Row, tracks_of_rows
from engine.interchange.openscenario.carla import BLUEPRINTS
from engine.interchange.tables.layouts import Layout, Point
from engine.interchange.tables.track import Tracks
from engine.unread import Unread
from engine.vocabulary import ActorKind

MOST_BYTES = 1_000_000_000
CENTIMETRE = 0.01
VEHICLE, WALKER = "1", "2"
"""Types of actors in the recorder; all others are lights, signs and sensors."""
CARS = {car.name for car in BLUEPRINTS[ActorKind.CAR]}
BODIES = {
    kind: tuple(each.name.rpartition(".")[2] for each in BLUEPRINTS[kind] if each.name not in CARS)
    for kind in (ActorKind.BICYCLE, ActorKind.BUS, ActorKind.TRUCK)
}
"""Words in the names of blueprints other than cars."""
LAYOUT = Layout(
    name="CARLA's recorder",
    known_by=(),
    columns={"actor": "Id", "heading": "Rotation"},
    point=Point.CENTER,
    said="centimetres and degrees, y points right of x; positions are centres of boxes where boxes are recorded",
    y_down=True,
    kinds={kind.name.lower(): kind for kind in ActorKind},
)
_NUMBER = r"(-?[\d.]+(?:e[+-]?\d+)?)"
_VECTOR = rf"\({_NUMBER}, {_NUMBER}, {_NUMBER}\)"
FRAME = re.compile(rf"Frame \d+ at {_NUMBER} seconds")
CREATE = re.compile(r" Create (\d+): (\S+) \((\d+)\) at ")
ATTRIBUTE = re.compile(r"  (\w+) = (.*)")
POSE = re.compile(rf"  Id: (\d+) Location: {_VECTOR} Rotation: {_VECTOR}")
VELOCITY = re.compile(rf"  Id: (\d+) linear_velocity: {_VECTOR}")
BOX = re.compile(rf"  Id: (\d+) origin: {_VECTOR} extension: {_VECTOR}")
BOXES, POSITIONS, ACTORS = SECTIONS = " Actor bounding boxes:", " Positions:", " Dynamic actors:"
SECTION_END = re.compile(r" \d.*")
"""Line that ends a section."""


@dataclass
class _Actor:
    """Actor that was created."""

    blueprint: str
    is_walker: bool
    attributes: dict[str, str] = field(default_factory=dict[str, str])
    origin: tuple[float, float] = (0.0, 0.0)
    size: tuple[float, float] = (0.0, 0.0)
    """Size [m]; 0 without a recorded box."""

    @property
    def kind(self) -> ActorKind:
        if self.is_walker:
            return ActorKind.PEDESTRIAN
        if self._is(ActorKind.BICYCLE):
            return ActorKind.BICYCLE
        if self.attributes.get("number_of_wheels") == "2":
            return ActorKind.MOTORCYCLE
        return next((kind for kind in (ActorKind.BUS, ActorKind.TRUCK) if self._is(kind)), ActorKind.CAR)

    def _is(self, kind: ActorKind) -> bool:
        said = self.attributes.get("base_type", "").lower()
        return kind.name.lower() in said or any(word in self.blueprint for word in BODIES[kind])


@dataclass
class _Log:
    """Data read so far."""

    actors: dict[str, _Actor] = field(default_factory=dict[str, _Actor])
    poses: list[tuple[int, float, str, tuple[float, float, float, float]]] = field(default_factory=list)
    """Line, time, actor, (x, y, z, yaw)."""
    velocities: dict[tuple[float, str], tuple[float, float]] = field(default_factory=dict)
    unread: Unread = field(default_factory=Unread)


def read_recorder(path: Path) -> Tracks:
    """Return the tracks of a recorder's text.

    Raises:
        InterchangeError: unreadable, not such a text, or without positions.
    """
    log = _read(path)
    if not log.poses:
        cure = "ask for everything: client.show_recorder_file_info(FILE, True)"
        raise InterchangeError("it contains no positions of vehicles or walkers", cure, path.name)
    whole = all((time, actor) in log.velocities for _, time, actor, _ in log.poses)
    keys = ("time", "actor", "x", "y", "z", "heading", "length", "width", "type", "role")
    tracks = tracks_of_rows(path, LAYOUT, (*keys, "vel_x", "vel_y") if whole else keys, _rows(log))
    return replace(tracks, remarks=(*tracks.remarks, *log.unread.notes()))


def _read(path: Path) -> _Log:
    with reading(path):
        if path.stat().st_size > MOST_BYTES:
            raise InterchangeError("the file is larger than 1 GB", "record a part of it", path.name)
        with path.open(encoding="utf-8", errors="replace") as file:
            log = _Log()
            _gather(log, file, path.name)
            return log


def _gather(log: _Log, lines: Iterator[str], name: str) -> None:
    time, section, created = 0.0, "", None
    for number, line in enumerate(lines, 1):
        if found := FRAME.match(line):
            time, section, created = float(found.group(1)), "", None
        elif found := CREATE.match(line):
            actor, blueprint, kind = found.groups()
            created = _Actor(blueprint, kind == WALKER) if kind in (VEHICLE, WALKER) else None
            if created is not None:
                log.actors[actor] = created
        elif (found := ATTRIBUTE.match(line)) and created is not None:
            created.attributes[found.group(1)] = found.group(2).strip()
        elif line.startswith(" ") and not line.startswith("  "):
            section, created = line.partition(":")[0] + ":", None
            if section not in (*SECTIONS, " Create", " Destroy"):
                log.unread.add(SECTION_END.sub("", section).strip(" :"), f"{name}, line {number}")
        else:
            _add(log, section, line, number, time)


def _add(log: _Log, section: str, line: str, number: int, time: float) -> None:
    """Add the values of one line of a list."""
    pattern = {POSITIONS: POSE, ACTORS: VELOCITY, BOXES: BOX}.get(section)
    found = pattern.match(line) if pattern is not None else None
    if found is None or (actor := log.actors.get(found.group(1))) is None:
        return
    numbers = [float(text) for text in found.groups()[1:]]
    if section == POSITIONS:
        x, y, z = (number * CENTIMETRE for number in numbers[:3])
        pose = (x, y, z, math.radians(numbers[5]))
        log.poses.append((number, time, found.group(1), pose))
    elif section == ACTORS:
        log.velocities[time, found.group(1)] = (numbers[0], numbers[1])
    else:
        actor.origin = (numbers[0] * CENTIMETRE, numbers[1] * CENTIMETRE)
        actor.size = (2.0 * numbers[3] * CENTIMETRE, 2.0 * numbers[4] * CENTIMETRE)


def _rows(log: _Log) -> Iterator[Row]:
    for line, time, name, (x, y, z, yaw) in log.poses:
        actor = log.actors[name]
        cos, sin = math.cos(yaw), math.sin(yaw)
        vel_x, vel_y = log.velocities.get((time, name), (0.0, 0.0))
        yield (
            line,
            {
                "time": time,
                "actor": name,
                "x": x + actor.origin[0] * cos - actor.origin[1] * sin,
                "y": y + actor.origin[0] * sin + actor.origin[1] * cos,
                "z": z,
                "heading": yaw,
                "vel_x": vel_x,
                "vel_y": vel_y,
                "length": actor.size[0],
                "width": actor.size[1],
                "type": actor.kind.name.lower(),
                "role": actor.attributes.get("role_name", ""),
            },
        )
