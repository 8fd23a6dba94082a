"""Recordings made by hand, and a player of what is written from them that knows no more than the standard says."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias
from xml.etree import ElementTree

import numpy as np
from hypothesis import strategies as st

from engine.interchange.contract import OSC_VERSIONS, ExportOptions
from engine.interchange.openscenario import write_trajectories
from engine.interchange.openscenario.versions import BEFORE
from engine.interchange.recording import Contact, Provenance, RecordedActor, Recording, SignalTimes
from engine.maps import RoadSpec
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.commonroad.recordings import actor

STEP = 0.05
ROAD = "crossing.xodr"
Xml: TypeAlias = Any
"""An element of ElementTree. What a test asks for and is not there is None, and fails the test by itself."""


def recording(actors: Sequence[RecordedActor], time: Sequence[float], ways: Sequence[Sequence[Any]]) -> Recording:
    """`ways`: for each actor a pose (x, y, heading) at each sample, or None where it is not there."""
    states = np.zeros((len(time), len(actors), len(State)))
    for index, way in enumerate(ways):
        for sample, pose in enumerate(way):
            if pose is not None:
                states[sample, index, : State.SPEED] = pose
                states[sample, index, State.PRESENT] = 1.0
    return Recording("crossing", tuple(actors), np.array(time, dtype=float), states, STEP)


def small() -> Recording:
    """A car that turns into a standing bus, a walker that comes, goes and comes back, and a box in the way."""
    time = [0.0, 0.05, 0.1, 0.12, 0.15]
    box = (20.0, 5.0, 0.5)
    ways = [
        [(0, 0, 0), (0.5, 0, 0), (1, 0.1, 0.2), (1.25, 0.15, 0.25), (1.25, 0.15, 0.25)],
        [(9, 0, 3), (9, 0, 3), (9, 0, 3), (9, 0, 3), (9.1, 0, 3.1)],
        [None, (3, 4, -1.5), (3, 3.9, -1.5), None, (3, 3.5, -1.5)],
        [box, box, box, box, box],
    ]
    actors = [
        actor("ego"),
        actor("bus 12", ActorKind.BUS),
        actor("walker", ActorKind.PEDESTRIAN),
        actor("box", ActorKind.OBSTACLE),
    ]
    made = recording(actors, time, ways)
    made.states[:, 0, State.SPEED] = [10.0, 10.0, 10.5, 10.5, 3.0]
    made.states[:, 0, State.STEER] = [0.0, 0.1, 0.2, 0.2, 0.2]
    provenance = Provenance(
        title="The ego turns into a bus",
        facts={"seed": "7", "risk": "22 of 22", "digest": "abc123", "command": "cortexc replay runs/one --case 1"},
        genome={"EGO_SPEED": "36 km/h", "EGO_BRAKE": "0.5"},
    )
    return replace(made, contact=Contact(0.12, (0, 1)), road=RoadSpec(), provenance=provenance)


def with_lights(offset: float = 0.0, all_red: float = 1.0) -> Recording:
    return replace(small(), signals=SignalTimes(10.0, 3.0, all_red, offset))


def scenario(of: Recording, version: str = "1.2", road_file: str | None = ROAD) -> Xml:
    (text,) = write_trajectories(of, "case", ExportOptions(osc=version), road_file).files.values()
    return ElementTree.fromstring(text)


@dataclass(frozen=True)
class Polyline:
    times: list[float]
    poses: np.ndarray

    def pose(self, time: float) -> np.ndarray:
        """Linear between vertices, as both the standard and our own contact search have it."""
        return np.array([np.interp(time, self.times, self.poses[:, column]) for column in range(3)])


def polyline(element: Xml) -> Polyline:
    vertices = list(element.iter("Vertex"))
    return Polyline([float(v.get("time")) for v in vertices], np.array([pose_of(v) for v in vertices]))


def pose_of(element: Xml) -> np.ndarray:
    position = element.find(".//WorldPosition")
    return np.array([float(position.get(name)) for name in "xyh"])


def starts(element: Xml) -> float:
    """When a trigger of an event holds for the first time [s]."""
    condition = element.find("StartTrigger/ConditionGroup/Condition/ByValueCondition/SimulationTimeCondition")
    value = float(condition.get("value"))
    return value if condition.get("rule") == "greaterOrEqual" else value + BEFORE


def played(root: Xml, name: str, time: float) -> np.ndarray | None:
    """Where the reference point of an entity is at a time; None while it is not there."""
    began = root.find(f".//Private[@entityRef='{name}']")
    events = list(root.findall(f".//Maneuver[@name='{name}_maneuver']/Event"))
    last = bisect_right([starts(event) for event in events], time + 1e-9) - 1
    where = None if began is None else pose_of(began.find(".//TeleportAction"))
    for event in events[: last + 1]:
        if event.find(".//DeleteEntityAction") is not None:
            where = None
        else:
            added, way = event.find(".//AddEntityAction"), event.find(".//FollowTrajectoryAction")
            where = where if added is None else pose_of(added)
            where = where if way is None else polyline(way).pose(time)
    return where


poses = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-7, 7))


@st.composite
def ways(draw: st.DrawFn, samples: int) -> list[object]:
    """Few different poses, so that actors stand, and gaps."""
    pool = draw(st.lists(poses, min_size=1, max_size=3))
    return draw(st.lists(st.sampled_from([*pool, *pool, None]), min_size=samples, max_size=samples))


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    """Of which the ego takes part at some time; others may never."""
    kinds = draw(st.lists(st.sampled_from(ActorKind), min_size=1, max_size=3))
    samples = draw(st.integers(1, 8))
    time = [sample * STEP for sample in range(samples)]
    if draw(st.booleans()):
        time = sorted([*time, time[-1] + draw(st.floats(1e-6, STEP - 1e-6))])
    names = [draw(st.text(st.characters(exclude_categories=["Cc", "Cs", "Cn"]), max_size=4)) for _ in kinds]
    actors = [actor(name, kind) for name, kind in zip(names, kinds, strict=True)]
    ego = draw(ways(len(time)).filter(lambda way: any(pose is not None for pose in way)))
    return recording(actors, time, [ego, *(draw(ways(len(time))) for _ in actors[1:])])


versions = st.sampled_from(OSC_VERSIONS)
