"""What the ego did, as the solution of its planning problem: a trajectory of the kinematic single-track model.

Its states hold the vehicle's centre, but the speed of its rear axle, as commonroad-io's vehicle dynamics take them.
"""

import math
from collections.abc import Mapping
from types import MappingProxyType

from engine.interchange.commonroad.texts import add_text
from engine.interchange.commonroad.timeline import Course, Timeline
from engine.interchange.recording import RecordedActor
from engine.interchange.xml_text import Element, child, number

MODEL = "KS"
COST = "JB1"
"""A solution must name a cost; it says nothing of how the ego drove."""
VEHICLES: Mapping[int, tuple[float, float]] = MappingProxyType(
    {1: (4.298, 1.674), 2: (4.508, 1.610), 3: (4.569, 1.844), 4: (5.1, 2.55)}
)
"""Length and width [m] of the vehicles that solutions know: Ford Escort, BMW 320i, VW Vanagon, a tractor unit.

Source: CommonRoad vehicle models (Althoff, Würsching), parameters of vehicles 1 to 4.
"""


def nearest_vehicle(actor: RecordedActor) -> int:
    """The vehicle whose outline is nearest to an actor's."""
    return min(VEHICLES, key=lambda each: math.dist(VEHICLES[each], (actor.length, actor.width)))


def has_size_of(vehicle: int, actor: RecordedActor) -> bool:
    return VEHICLES[vehicle] == (actor.length, actor.width)


def solution(line: Timeline, problem: int, name: str) -> Element:
    """The document for a planning problem of a benchmark."""
    vehicle = nearest_vehicle(line.ego.actor)
    benchmark = f"{MODEL}{vehicle}:{COST}:{name}:2020a"
    root = Element("CommonRoadSolution", {"benchmark_id": benchmark, "date": line.recording.provenance.date[:19]})
    trajectory = child(root, "ksTrajectory", planningProblem=problem)
    for step in range(len(line.ego)):
        _add_state(trajectory, line.ego, step)
    return root


def _add_state(trajectory: Element, ego: Course, step: int) -> None:
    state = child(trajectory, "ksState")
    values = {
        "x": ego.x[step],
        "y": ego.y[step],
        "orientation": ego.heading[step],
        "velocity": ego.speed[step],
        "steeringAngle": ego.steer[step],
    }
    for tag, value in values.items():
        add_text(state, tag, number(value))
    add_text(state, "time", str(step))
