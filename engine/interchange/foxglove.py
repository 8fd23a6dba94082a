"""A recording as Foxglove's `SceneUpdate` messages: boxes for those who take part, lines for the road, in one frame.

Field names and numbers of kinds are those of Foxglove's published message schemas, in JSON.
"""

import math
from collections.abc import Mapping
from typing import Any

from engine.interchange.kinds import KINDS
from engine.interchange.recording import RecordedActor, Recording
from engine.program import RoadSpec
from engine.road import build_network, outline
from engine.tables import Floats
from engine.vocabulary import ActorKind, State

FRAME = "map"
EGO, OTHERS, THINGS = (0.95, 0.45, 0.1), (0.25, 0.45, 0.75), (0.5, 0.5, 0.5)
"""Colours, as red, green, blue."""
KERB, MARKING, STOP = (0.55, 0.55, 0.55), (0.85, 0.85, 0.85), (1.0, 1.0, 1.0)
LINE_STRIP = 0
"""Foxglove's number of lines from point to point."""
DELETE_ID = 0
"""Foxglove's number for the end of one entity."""
Message = dict[str, Any]


def _scene(entities: list[Message], deletions: list[Message] | None = None) -> Message:
    return {"deletions": deletions or [], "entities": entities}


def actors_scene(recording: Recording, sample: int, instant: int) -> Message:
    """All who are there, and the end of those who were there one sample before."""
    there = recording.there
    gone = there[max(sample - 1, 0)] & ~there[sample]
    entities = [
        _entity(actor.name, instant, cubes=[_cube(actor, recording.states[sample, i], i == 0)])
        for i, actor in enumerate(recording.actors)
        if there[sample, i]
    ]
    stamp = _stamp(instant)
    names = [actor.name for actor, left in zip(recording.actors, gone, strict=True) if left]
    return _scene(entities, [{"timestamp": stamp, "type": DELETE_ID, "id": name} for name in names])


def _cube(actor: RecordedActor, state: Floats, is_ego: bool) -> Message:
    height, heading = KINDS[actor.kind].height, float(state[State.HEADING])
    colour = EGO if is_ego else THINGS if actor.kind is ActorKind.OBSTACLE else OTHERS
    return {
        "pose": {
            "position": {"x": float(state[State.X]), "y": float(state[State.Y]), "z": 0.5 * height},
            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * heading), "w": math.cos(0.5 * heading)},
        },
        "size": {"x": actor.length, "y": actor.width, "z": height},
        "color": _colour(colour),
    }


def road_scene(spec: RoadSpec) -> Message:
    """All lines of a road, to stay."""
    drawn = outline(build_network(spec))
    lines = [
        *(_line(line, KERB, 0.15) for line in drawn.kerbs),
        *(_line(line, MARKING, 0.12) for line in (*drawn.middle_lines, *drawn.lane_lines)),
        *(_line(line, STOP, 0.3) for line in drawn.stop_lines),
    ]
    return _scene([_entity("road", 0, lines=lines)])


def _line(points: Floats, colour: tuple[float, float, float], thickness: float) -> Message:
    identity = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {
        "type": LINE_STRIP,
        "pose": identity,
        "thickness": thickness,
        "scale_invariant": False,
        "points": [{"x": x, "y": y, "z": 0.0} for x, y in points.tolist()],
        "color": _colour(colour),
        "colors": [],
        "indices": [],
    }


def _entity(
    name: str, instant: int, *, cubes: list[Message] | None = None, lines: list[Message] | None = None
) -> Message:
    """Something to be seen until it is replaced or deleted."""
    shapes = {"arrows": [], "cubes": cubes or [], "spheres": [], "cylinders": [], "lines": lines or []}
    return {
        "timestamp": _stamp(instant),
        "frame_id": FRAME,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        "metadata": [],
        **shapes,
        "triangles": [],
        "texts": [],
        "models": [],
    }


def _stamp(instant: int) -> dict[str, int]:
    seconds, nanoseconds = divmod(instant, 10**9)
    return {"sec": seconds, "nsec": nanoseconds}


def _colour(rgb: tuple[float, float, float]) -> dict[str, float]:
    return {**dict(zip("rgb", rgb, strict=True)), "a": 1.0}


# -- what the messages hold, as JSON Schema; only fields that ever hold anything


def _object(**properties: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list(items: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_NUMBER, _WHOLE, _TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
_VECTOR = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_POSE = _object(position=_VECTOR, orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER))
_TIME = _object(sec=_WHOLE, nsec=_WHOLE)
_COLOUR = _object(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_CUBE = _object(pose=_POSE, size=_VECTOR, color=_COLOUR)
_LINE = _object(
    type=_WHOLE,
    pose=_POSE,
    thickness=_NUMBER,
    scale_invariant={"type": "boolean"},
    points=_list(_VECTOR),
    color=_COLOUR,
)
_ENTITY = _object(
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_TIME,
    frame_locked={"type": "boolean"},
    cubes=_list(_CUBE),
    lines=_list(_LINE),
)
SCENE_UPDATE = _object(
    deletions=_list(_object(timestamp=_TIME, type=_WHOLE, id=_TEXT)), entities=_list(_ENTITY)
)  # fmt: skip
