"""The scenario: head, road, actors, and the ego's planning problem."""

import re
from collections.abc import Iterator

import numpy as np

from engine.interchange.commonroad.remarks import remarks
from engine.interchange.commonroad.road import Ids, add_road
from engine.interchange.commonroad.solution import solution
from engine.interchange.commonroad.texts import add_exact, add_interval, add_point, add_rectangle, add_text
from engine.interchange.commonroad.timeline import Course, Timeline, timeline
from engine.interchange.errors import InterchangeError
from engine.interchange.export import Export
from engine.interchange.kinds import KINDS
from engine.interchange.recording import Recording
from engine.interchange.xml_text import Element, child, decimal, xml_text
from engine.road import Network, build_network
from engine.vocabulary import ActorKind

UNKNOWN_PLACE = {"geoNameId": "-999", "gpsLatitude": "999", "gpsLongitude": "999"}
"""What commonroad-io writes where nothing is known of a place."""
TURN = np.radians(45.0)
"""More than this is a turn, for the scenario's tags [rad]."""


def write_commonroad(recording: Recording, stem: str) -> Export:
    """`<stem>.cr.xml` and `<stem>.solution.xml`: everyone at whole steps, the ego as problem and solution.

    Raises:
        InterchangeError: the road is none of ours, steps are missing, or the ego is hardly there.
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
    """CommonRoad's name of a scenario: country (Zamunda, for roads that are nowhere), map, number, kind of prediction.

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
    for track in sorted(line.others, key=_is_dynamic):  # static ones first, as the schema has them
        _add_actor(root, ids.actor(track.index), track)
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
    """In the order of the schema's list."""
    turned = float(line.ego.heading[-1] - line.ego.heading[0])
    yield "urban"
    if line.recording.contact is not None:
        yield "critical"
    yield "intersection"
    yield "single_lane" if network.spec.lanes == 1 else "multi_lane"
    yield "simulated"
    # Contact may spin a vehicle, which is no turn.
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
    """Where an actor is and how it moves at one step; what is asked of a beginning is given of all."""
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


# -- the ego


def _add_problem(root: Element, id: int, ego: Course) -> None:  # noqa: A002 -- the attribute's name
    """To be where the ego ended, then: an area of its own size around its last place."""
    problem = child(root, "planningProblem", id=id)
    _add_state(problem, "initialState", ego, 0)
    goal = child(problem, "goalState")
    last = len(ego) - 1
    add_interval(goal, "time", last, last)
    area = add_rectangle(child(goal, "position"), ego.actor.length, ego.actor.width)
    add_text(area, "orientation", decimal(ego.heading[-1]))
    center = child(area, "center")
    add_text(center, "x", decimal(ego.x[-1]))
    add_text(center, "y", decimal(ego.y[-1]))
