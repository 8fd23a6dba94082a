"""Actions of a storyboard's entities in the order of time, and the timed polylines that they follow.

Only triggers on the simulation's time are known in advance; every other trigger depends on a simulation, which is not
run here. Polylines without times are rejected with that reason. Times in seconds of the simulation.

Source: ASAM OpenSCENARIO XML 1.2, classes FollowTrajectoryAction, Polyline, Vertex, Timing. In 1.0 the trajectory is in
the action itself, later in a `TrajectoryRef`.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, islice

import numpy as np

from engine.interchange.motion_headings import marks_of
from engine.interchange.openscenario.read.motion import (
    COARSE,
    SAME_PLACE,
    STANDING,
    Polyline,
    Surroundings,
    place,
)
from engine.interchange.openscenario.read.parameters import Catalogs
from engine.portable import arctan2
from engine.tables import Floats
from engine.xml import Node

ACTED_ON = ("TeleportAction", "SpeedAction", "FollowTrajectoryAction", "AddEntityAction", "DeleteEntityAction")
"""Actions that are replayed; a speed only at the start."""
WITHOUT_MOTION = (
    "AppearanceAction",
    "ControllerAction",
    "VisibilityAction",
    "EnvironmentAction",
    "InfrastructureAction",
    "ParameterAction",
    "VariableAction",
    "SetMonitorAction",
    "UserDefinedAction",
    "AssignRouteAction",
    "ActivateControllerAction",
)
"""Actions, or families of them, that change no place of an entity in a replay."""
AFTER = ("greaterOrEqual", "greaterThan", "equalTo")
AT_ONCE = ("lessThan", "lessOrEqual", "notEqualTo")


MOST_ACTIONS = 5000


@dataclass(frozen=True)
class TimedAction:
    """One action of one entity."""

    time: float
    entity: str
    action: Node
    """One of `ACTED_ON`, or an action whose motion requires a simulator."""
    is_read: bool
    """True if it is replayed; if not, its time is unknown, and 0."""


def timed_actions(storyboard: Node) -> list[TimedAction]:
    """Return all actions that concern motion, in the order of time, and of the file at equal times.

    Raises:
        InterchangeError: the time of one of `ACTED_ON` does not follow from the file alone.
    """
    acts = [act for story in storyboard.every("Story") for act in story.every("Act")]
    parts = [_initial(storyboard.need("Init", "Actions")), *map(_of_act, acts)]
    found = list(islice(chain.from_iterable(parts), MOST_ACTIONS + 1))
    if len(found) > MOST_ACTIONS:
        raise storyboard.error(f"it holds more than {MOST_ACTIONS} actions", "leave out actors or events")
    return sorted(found, key=lambda timed: timed.time)


def stop_time(storyboard: Node) -> tuple[float, list[Node]]:
    """Return the latest end [s], infinite if it depends on the motion, and conditions that are ignored."""
    passed_over: list[Node] = []
    trigger, earliest = storyboard.find("StopTrigger"), math.inf
    for group in trigger.every("ConditionGroup") if trigger else []:
        times = [_condition_time(condition) for condition in group.every("Condition")]
        if times and None not in times:
            earliest = min(earliest, max(time for time in times if time is not None))
        passed_over += [c for c, time in zip(group.every("Condition"), times, strict=True) if time is None]
    return earliest, passed_over


def condition_name(condition: Node) -> str:
    """Return the name of a condition: that of the deepest element whose tag ends in `Condition`."""
    names = [node.tag for node in condition.walk() if node.tag.endswith("Condition")]
    return names[-1]


def _initial(actions: Node) -> Iterator[TimedAction]:
    for node in actions.children:
        if node.tag == "Private":
            for action in node.every("PrivateAction"):
                yield from _timed(NOW, [node.text("entityRef")], action, True)
        elif node.tag == "GlobalAction":
            yield from _timed(NOW, [], node, True)


def _of_act(act: Node) -> Iterator[TimedAction]:
    begins = _Start(act.find("StartTrigger"))
    for group in act.every("ManeuverGroup"):
        actors = group.find("Actors") or group
        names = [actor.text("entityRef") for actor in actors.every("EntityRef")]
        for event in (event for maneuver in group.every("Maneuver") for event in maneuver.every("Event")):
            start = _Start(event.find("StartTrigger"), begins)
            for holder in event.every("Action"):
                for action in holder.every("PrivateAction", "GlobalAction"):
                    yield from _timed(start, names, action, False)


class _Start:
    """Start time of an element; the error is raised only if the time is needed."""

    def __init__(self, trigger: Node | None, after: "_Start | None" = None) -> None:
        self._trigger = trigger
        self._after = after

    @cached_property
    def time(self) -> float:
        """Return the time [s]."""
        earliest = self._after.time if self._after else 0.0
        groups = self._trigger.every("ConditionGroup") if self._trigger else []
        if not groups:
            return earliest
        return max(earliest, min(max(map(_known_time, group.every("Condition")), default=0.0) for group in groups))


NOW = _Start(None)


def _known_time(condition: Node) -> float:
    time = _condition_time(condition)
    if time is None:
        raise condition.error(
            f"a start trigger waits for <{condition_name(condition)}>, which depends on the simulation",
            "use a SimulationTimeCondition, or record the run in a simulator and import the recording",
        )
    return time


def _condition_time(condition: Node) -> float | None:
    """Return the time at which a condition first holds, or None if that depends on the run."""
    time = condition.find("ByValueCondition", "SimulationTimeCondition")
    if time is None:
        return None
    value, rule = time.number("value"), time.text("rule")
    delay = condition.number("delay", 0.0, low=0.0)
    if rule in AFTER:
        return max(value, 0.0) + delay
    return delay if rule in AT_ONCE else None


def _timed(start: _Start, names: list[str], action: Node, initial: bool) -> Iterator[TimedAction]:
    leaf, entity = _leaf(action)
    if leaf is None:
        return
    actors = [entity] if entity is not None else names
    if not actors and leaf.tag == "FollowTrajectoryAction":
        raise leaf.error("no actor is named to follow this trajectory", "name its actors by <EntityRef>")
    is_read = leaf.tag in ACTED_ON and (initial or leaf.tag != "SpeedAction")
    time = start.time if is_read else 0.0
    for name in actors:
        yield TimedAction(time, name, leaf, is_read)


def _leaf(action: Node) -> tuple[Node | None, str | None]:
    """Return the innermost action, None if it does not concern motion, and the entity that it names."""
    node, entity = action, None
    while (inner := next((child for child in node.children if child.tag.endswith("Action")), None)) is not None:
        node, entity = inner, inner.attributes.get("entityRef", entity)
        if node.tag in WITHOUT_MOTION:
            return None, None
        if node.tag in ACTED_ON:
            break
    return (node, entity) if node is not action else (None, None)


# -- `FollowTrajectoryAction` with a timed polyline --------------------------------------------------------------------

SHORTEST_WAY = 0.1
"""Length below which a slow trajectory (slower than a walk) has no direction [m]."""
TOO_NEAR = 1e-10
"""Time between vertices below which they mean a jump [s]."""
TIMED = 'only a timed polyline is replayed: <Polyline> with time="…" on each vertex'


def read_path(action: Node, start: float, speed: float, around: Surroundings, catalogs: Catalogs) -> Polyline:
    """Return the path of an action that starts at a time [s] and a speed [m/s].

    Raises:
        InterchangeError: not a polyline, no times, no vertex, or times that do not ascend.
    """
    trajectory = _trajectory(action, catalogs)
    shape = trajectory.need("Shape")
    polyline = shape.find("Polyline")
    if polyline is None:
        said = shape.children[0].tag if shape.children else "no shape"
        raise shape.error(f"the trajectory `{trajectory.text('name', '')}` is a <{said}>", TIMED)
    offset, scale, relative = _timing(action)
    if action.number("initialDistanceOffset", 0.0):
        raise action.error("initialDistanceOffset is not read here", "leave out the vertices before it")
    vertices = polyline.every("Vertex")
    if not vertices:
        raise polyline.error("the polyline has no vertex", "write <Vertex> elements into it")
    times = (start if relative else 0.0) + offset + scale * np.array([_time(vertex) for vertex in vertices])
    _check_order(times, vertices)
    path = _path(start, times, vertices, around)
    if not is_steered(action) or speed < 0.0 or len(times) < 2 or np.median(np.diff(times)) <= COARSE:
        return path
    paces = steady_paces(path.times, path.poses, speed)
    return replace(path, paces=paces, end_speed=float(paces[-1, 0]))


def is_steered(action: Node) -> bool:
    """Return True if an actor follows its trajectory as a vehicle, with steering."""
    mode = action.find("TrajectoryFollowingMode")
    return mode is not None and mode.text("followingMode") == "follow"


def _path(start: float, times: Floats, vertices: Sequence[Node], around: Surroundings) -> Polyline:
    placed = [place(vertex.need("Position"), around) for vertex in vertices]
    given = [each.given for each in placed]
    raw = np.array([each.pose for each in placed], dtype=np.float64)
    if len(vertices) == 1 and not given[0]:
        given = [True]  # one place: its heading is used
    poses = along_polyline(times, raw, given, vertices[0])
    return Polyline(start, times, poses, final_speed(times, poses))


def _trajectory(action: Node, catalogs: Catalogs) -> Node:
    holder = action.find("TrajectoryRef") or action
    if (trajectory := holder.find("Trajectory")) is not None:
        return trajectory
    reference = holder.find("CatalogReference")
    if reference is None:
        raise action.error("the action names no trajectory", "write a <Trajectory> into its <TrajectoryRef>")
    return catalogs.entry(reference)


def _timing(action: Node) -> tuple[float, float, bool]:
    """Return offset, scale, and True if times count from the start of the action."""
    timing = action.find("TimeReference", "Timing")
    if timing is None:
        raise action.error(
            "the trajectory has no times: its <TimeReference> is <None/> or missing, so how fast it is driven "
            "depends on a simulator",
            'write <Timing domainAbsoluteRelative="absolute" offset="0" scale="1"/> and a time on each vertex',
        )
    domain = timing.text("domainAbsoluteRelative")
    if domain not in ("absolute", "relative"):
        raise timing.error(f"there is no time domain `{domain[:40]}`", "write `absolute` or `relative`")
    scale = timing.number("scale", low=0.0)
    if scale == 0.0:
        raise timing.error("times scaled by 0 are all one", "write a positive scale")
    return timing.number("offset"), scale, domain == "relative"


def _time(vertex: Node) -> float:
    if "time" not in vertex.attributes:
        raise vertex.error("a vertex has no time", 'write time="…" [s] on each <Vertex>')
    return vertex.number("time")


def _check_order(times: Floats, vertices: Sequence[Node]) -> None:
    wrong = np.flatnonzero(np.diff(times) <= TOO_NEAR)
    if len(wrong):
        here = int(wrong[0])
        said = f"{times[here + 1]:g} s after {times[here]:g} s"
        raise vertices[here + 1].error(f"times must ascend, and this vertex comes at {said}", "sort the vertices")


# -- vertices as a way -------------------------------------------------------------------------------------------------


def along_polyline(times: Floats, poses: Floats, given: Sequence[bool], node: Node) -> Floats:
    """Return poses in which missing headings are those of the way to the next distant vertex, as in esmini.

    Distant means farther than the noise of the vertices (`marks_of`). Given headings are unwrapped.
    """
    marks = marks_of(times, poses[:, :2], SHORTEST_WAY)
    if len(marks) < 2 and not all(given):
        raise node.error("a trajectory at one place has no direction", "write a heading into each vertex")
    headings, missing = poses[:, 2].copy(), np.flatnonzero(~np.asarray(given, dtype=bool))
    if len(missing):
        ways = np.diff(poses[marks, :2], axis=0)
        way = ways[np.minimum(np.searchsorted(marks, missing, "right") - 1, len(ways) - 1)]
        headings[missing] = arctan2(way[:, 1], way[:, 0])
    return np.column_stack([poses[:, :2], np.unwrap(headings)])


def steady_paces(times: Floats, poses: Floats, speed: float) -> Floats:
    """Return (vertices, 2) the speed at each vertex and the acceleration to the next, from an initial speed.

    The acceleration is constant and reaches the next vertex in time; if that would require reversing, the actor stops
    there earlier. Source: esmini 3.6.0, `PolyLineShape::CalculatePolyLine`, following mode `follow`.
    """
    paces: list[tuple[float, float]] = []
    for way, span in zip(np.hypot(*np.diff(poses[:, :2], axis=0).T).tolist(), np.diff(times).tolist(), strict=True):
        acceleration, after = 0.0, 0.0
        if way > SAME_PLACE:
            acceleration = 2.0 * (way - speed * span) / (span * span)
            after = speed + acceleration * span
            if after < 0.0:
                acceleration, after = -speed * speed / (2.0 * way), 0.0
        paces.append((speed, acceleration))
        speed = after
    return np.array([*paces, (speed, 0.0)])


def final_speed(times: Floats, poses: Floats) -> float:
    """Return the signed speed over the last segment; 0 for a single vertex or at standstill."""
    if len(times) < 2:
        return 0.0
    way = poses[-1, :2] - poses[-2, :2]
    ahead = float(way[0]) * math.cos(poses[-1, 2]) + float(way[1]) * math.sin(poses[-1, 2])
    speed = ahead / float(times[-1] - times[-2])
    return speed if abs(speed) > STANDING else 0.0
