"""The scenario (head, road, actors, the ego's planning problem), and the ego's motion as the solution of that problem.

The solution is a trajectory of the kinematic single-track model. Its states hold the vehicle's centre, but the speed of
its rear axle, as commonroad-io's vehicle dynamics take them.
"""

import math
import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from engine.errors import InterchangeError
from engine.interchange.commonroad.road import (
    Ids,
    add_exact,
    add_interval,
    add_point,
    add_rectangle,
    add_road,
    add_text,
    cycle,
)
from engine.interchange.commonroad.steps import Course, Timeline, timeline
from engine.interchange.contract import Export
from engine.interchange.kinds import KINDS
from engine.interchange.recording import PHASES, RecordedActor, Recording
from engine.interchange.xml_writing import Element, child, decimal, number, xml_text
from engine.kernels.geometry import Box
from engine.road import Network, build_network
from engine.vocabulary import ActorKind

# -- the solution ------------------------------------------------------------------------------------------------------

MODEL = "KS"
COST = "JB1"
"""Cost function that a solution must name; it has no influence on the motion."""
VEHICLES: Mapping[int, tuple[float, float]] = MappingProxyType(
    {1: (4.298, 1.674), 2: (4.508, 1.610), 3: (4.569, 1.844), 4: (5.1, 2.55)}
)
"""Length and width [m] of the vehicles of solutions: Ford Escort, BMW 320i, VW Vanagon, a tractor unit.

Source: CommonRoad vehicle models (Althoff, Würsching), parameters of vehicles 1 to 4.
"""


def nearest_vehicle(actor: RecordedActor) -> int:
    """Return the number of the vehicle with the outline nearest to an actor's."""
    return min(VEHICLES, key=lambda each: math.dist(VEHICLES[each], (actor.length, actor.width)))


def has_size_of(vehicle: int, actor: RecordedActor) -> bool:
    return VEHICLES[vehicle] == (actor.length, actor.width)


def solution(line: Timeline, problem: int, name: str) -> Element:
    """Return the solution document for a planning problem of a benchmark."""
    vehicle = nearest_vehicle(line.ego.actor)
    benchmark = f"{MODEL}{vehicle}:{COST}:{name}:2020a"
    root = Element("CommonRoadSolution", {"benchmark_id": benchmark, "date": line.recording.provenance.date[:19]})
    trajectory = child(root, "ksTrajectory", planningProblem=problem)
    for step in range(len(line.ego)):
        _add_vehicle_state(trajectory, line.ego, step)
    return root


def _add_vehicle_state(trajectory: Element, ego: Course, step: int) -> None:
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


# -- what CommonRoad cannot carry of a recording, or carries otherwise -------------------------------------------------


def remarks(line: Timeline) -> tuple[str, ...]:
    """Return one sentence for each property of a recording that CommonRoad cannot express, or expresses differently."""
    return (*_contact(line), *_times(line), *_signals(line), *_ego(line), *_buildings(line), *_always())


def _buildings(line: Timeline) -> Iterator[str]:
    if len(line.buildings):
        yield "buildings are obstacles of the environment, which CommonRoad's own collision checker passes over"


def _contact(line: Timeline) -> Iterator[str]:
    contact, step = line.recording.contact, line.contact_step
    if contact is None or step is None:
        return
    names = " and ".join(line.recording.actors[i].name for i in contact.actors)
    if abs(step - round(step)) > 1e-6:
        yield (
            f"first contact, of {names} at {contact.time:.4f} s, lies between steps {int(step)} and {int(step) + 1}; "
            "CommonRoad knows whole steps only"
        )
    after = int(step + 1e-6) + 1
    if len(contact.actors) < 2:
        yield f"at step {after} {names} stands as it would without contact, as far on as it reaches into the building"
    else:
        yield f"at step {after} the two stand as they would without contact, as far on as their outlines overlap"
    yield "what follows first contact is contact physics, which no vehicle model of CommonRoad drives"


def _times(line: Timeline) -> Iterator[str]:
    if line.start != 0.0:
        yield f"step 0 is {line.start:g} s into the run, where the ego comes in"
    if len(line.recording.on_steps().stretches(0)) > 1:
        yield "the ego leaves and comes back; problem and solution end when it leaves first"
    late = [track.actor.name for track in line.others if track.waits]
    if late:
        yield (
            f"{', '.join(late)} must stand somewhere while not there: CommonRoad's obstacles are there from step 0; "
            "they wait aside, west of the road"
        )
    met = {track.index for track in line.others} | {0}
    for index, actor in enumerate(line.recording.actors):
        if index not in met:
            yield f"{actor.name} is never there at a whole step and left out"


def _signals(line: Timeline) -> Iterator[str]:
    signals = line.signals
    if signals is None:
        return
    if signals.controlled:
        yield "behaviours or monitors may change the traffic lights, and the file has their fixed plan"
    if not all(cycle(signals, phase, line.recording.step).is_exact for phase in range(PHASES)):
        yield "traffic lights change at whole steps, as near to their plan as these allow"


def _ego(line: Timeline) -> Iterator[str]:
    actor, vehicle = line.ego.actor, nearest_vehicle(line.ego.actor)
    if not has_size_of(vehicle, actor):
        length, width = VEHICLES[vehicle]
        yield (
            f"the solution's ego is CommonRoad's vehicle {vehicle}, {length:g} m x {width:g} m, the nearest to "
            f"{actor.length:g} m x {actor.width:g} m"
        )


def _always() -> Iterator[str]:
    yield "CommonRoad has no names, masses, axles or pedals of obstacles, and steering of the ego alone"


# -- the scenario ------------------------------------------------------------------------------------------------------

UNKNOWN_PLACE = {"geoNameId": "-999", "gpsLatitude": "999", "gpsLongitude": "999"}
"""Values of commonroad-io for an unknown place."""
TURN = np.radians(45.0)
"""Least change of heading that counts as a turn in the scenario's tags [rad]."""


def write_commonroad(recording: Recording, stem: str) -> Export:
    """Write `<stem>.cr.xml` and `<stem>.solution.xml`: all actors at whole steps, the ego as problem and solution.

    Raises:
        InterchangeError: the road is unknown, steps are missing, or the ego is present at fewer than two steps.
    """
    if recording.road is None:
        raise InterchangeError(
            "CommonRoad asks for lanelets, and the recording has no road made by `map`",
            "write csv, parquet or mcap, which need no road",
        )
    line = timeline(recording)
    ids = Ids(build_network(recording.road))
    name = benchmark_id(recording.name, stem)
    files = {
        f"{stem}.cr.xml": xml_text(_scenario(line, ids, name)),
        f"{stem}.solution.xml": xml_text(solution(line, ids.actor(0), name)),
    }
    return Export(files, remarks(line))


def benchmark_id(name: str, stem: str) -> str:
    """Return CommonRoad's name of a scenario: country (Zamunda, for roads without a place), map, number, prediction.

    The map is the recording's name, its number the last one in the file's.
    """
    words = re.findall(r"[A-Za-z0-9]+", name)
    numbers = [int(text) for text in re.findall(r"[0-9]+", stem)]
    title = "".join(word[0].upper() + word[1:] for word in words) or "Case"
    return f"ZAM_{title}-1_{max(numbers[-1], 1) if numbers else 1}_T-1"


def _scenario(line: Timeline, ids: Ids, name: str) -> Element:
    recording = line.recording
    root = Element("commonRoad", _head(recording, name))
    location = child(root, "location")
    for tag, text in UNKNOWN_PLACE.items():
        add_text(location, tag, text)
    tags = child(root, "scenarioTags")
    for tag in _tags(line, ids.network):
        child(tags, tag)
    add_road(root, ids, line.signals, recording.step)
    for track in sorted(line.others, key=_is_dynamic):  # static obstacles first, as in the schema
        _add_actor(root, ids.actor(track.index), track)
    for index, row in enumerate(line.buildings.tolist(), len(recording.actors)):
        _add_building(root, ids.actor(index), Box(*row))
    _add_problem(root, ids.actor(0), line.ego)
    return root


def _head(recording: Recording, name: str) -> dict[str, str]:
    origin = recording.provenance
    facts = [*origin.facts.items(), *origin.genome.items()]
    source = "; ".join(filter(None, [origin.title, *(f"{key}: {value}" for key, value in facts)]))
    return {
        "commonRoadVersion": "2020a",
        "benchmarkID": name,
        "date": origin.date[:10],
        "author": origin.author,
        "affiliation": "cortexc",
        "source": source or "cortexc",
        "timeStepSize": decimal(recording.step),
    }


def _tags(line: Timeline, network: Network) -> Iterator[str]:
    """Yield the tags in the order of the schema's list."""
    turned = float(line.ego.heading[-1] - line.ego.heading[0])
    if network.intersections:
        yield "urban"
    if line.recording.contact is not None:
        yield "critical"
    if network.intersections:
        yield "intersection"
    yield (
        "single_lane" if all(len(group.lanes) == 1 for road in network.roads for group in road.groups) else "multi_lane"
    )
    yield "simulated"
    # A rotation by contact is not a turn.
    if line.recording.contact is None and abs(turned) > TURN:
        yield "turn_left" if turned > 0.0 else "turn_right"


# -- actors


def _is_dynamic(track: Course) -> bool:
    return not (track.actor.kind is ActorKind.OBSTACLE and track.never_moves)


def _add_actor(root: Element, id: int, track: Course) -> None:  # noqa: A002 -- the attribute's name
    is_dynamic = _is_dynamic(track)
    element = child(root, "dynamicObstacle" if is_dynamic else "staticObstacle", id=id)
    add_text(element, "type", KINDS[track.actor.kind].commonroad)
    add_rectangle(child(element, "shape"), track.actor.length, track.actor.width)
    _add_state(element, "initialState", track, 0)
    if is_dynamic:
        trajectory = child(element, "trajectory")
        for step in range(1, len(track)):
            _add_state(trajectory, "state", track, step)


def _add_state(parent: Element, tag: str, track: Course, step: int) -> None:
    """Add an actor's pose and motion at one step; every state has the elements required of the first."""
    state = child(parent, tag)
    add_point(child(state, "position"), float(track.x[step]), float(track.y[step]))
    add_exact(
        state,
        {
            "orientation": track.heading[step],
            "time": step,
            "velocity": track.speed[step],
            "acceleration": track.acceleration[step],
            "yawRate": track.yaw_rate[step],
            "slipAngle": track.slip[step],
        },
    )


# -- buildings


def _add_building(root: Element, id: int, block: Box) -> None:  # noqa: A002 -- the attribute's name
    """Add a building; the schema allows the type `building` for obstacles of the environment only."""
    element = child(root, "environmentObstacle", id=id)
    add_text(element, "type", "building")
    _add_box(child(element, "shape"), block)


def _add_box(parent: Element, box: Box) -> None:
    """Add a rectangle with its place."""
    rectangle = add_rectangle(parent, box.length, box.width)
    add_text(rectangle, "orientation", decimal(box.heading))
    center = child(rectangle, "center")
    add_text(center, "x", decimal(box.x))
    add_text(center, "y", decimal(box.y))


# -- the ego


def _add_problem(root: Element, id: int, ego: Course) -> None:  # noqa: A002 -- the attribute's name
    """Add the ego's problem: its last place at its last time, as an area of its own size."""
    problem = child(root, "planningProblem", id=id)
    _add_state(problem, "initialState", ego, 0)
    goal = child(problem, "goalState")
    last = len(ego) - 1
    add_interval(goal, "time", last, last)
    area = Box(float(ego.x[-1]), float(ego.y[-1]), float(ego.heading[-1]), ego.actor.length, ego.actor.width)
    _add_box(child(goal, "position"), area)
