"""What a storyboard has its entities do, and when: actions in the order of time. Times in seconds of the simulation.

Only triggers on the simulation's time are known beforehand; every other one depends on a run that is not made here.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice

from engine.interchange.reading.node import Node

ACTED_ON = ("TeleportAction", "SpeedAction", "FollowTrajectoryAction", "AddEntityAction", "DeleteEntityAction")
"""What is replayed; a speed only where all begin."""
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
"""Actions, or families of them, that change nothing about where anybody is in a replay."""
AFTER = ("greaterOrEqual", "greaterThan", "equalTo")
AT_ONCE = ("lessThan", "lessOrEqual", "notEqualTo")


MOST_ACTIONS = 5000


@dataclass(frozen=True)
class TimedAction:
    """One action of one entity."""

    time: float
    entity: str
    action: Node
    """One of `ACTED_ON`, or one that moves the entity in a way that only a simulator can tell."""
    is_read: bool
    """Whether it is replayed; if not, its time is not known, and 0."""


def timed_actions(storyboard: Node) -> list[TimedAction]:
    """All actions that concern motion, in the order of time, and of the file at the same time.

    Raises:
        InterchangeError: one of `ACTED_ON` waits for what a file alone cannot tell.
    """
    acts = [act for story in storyboard.every("Story") for act in story.every("Act")]
    parts = [_initial(storyboard.need("Init", "Actions")), *map(_of_act, acts)]
    found = list(islice(chain.from_iterable(parts), MOST_ACTIONS + 1))
    if len(found) > MOST_ACTIONS:
        raise storyboard.error(f"it holds more than {MOST_ACTIONS} actions", "leave out actors or events")
    return sorted(found, key=lambda timed: timed.time)


def stop_time(storyboard: Node) -> tuple[float, list[Node]]:
    """When it ends at the latest [s], infinite where only the motion tells, and conditions that are passed over."""
    trigger, passed_over, earliest = storyboard.find("StopTrigger"), [], math.inf
    for group in trigger.every("ConditionGroup") if trigger else []:
        times = [_condition_time(condition) for condition in group.every("Condition")]
        if times and None not in times:
            earliest = min(earliest, max(time for time in times if time is not None))
        passed_over += [c for c, time in zip(group.every("Condition"), times, strict=True) if time is None]
    return earliest, passed_over


def condition_name(condition: Node) -> str:
    """What a condition waits for: the deepest element whose name says so."""
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
    """When something starts; an error only if somebody needs to know."""

    def __init__(self, trigger: Node | None, after: "_Start | None" = None) -> None:
        self._trigger = trigger
        self._after = after

    @cached_property
    def time(self) -> float:
        """In seconds.

        Raises:
            InterchangeError: a condition depends on the run.
        """
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
            f"a start trigger waits for <{condition_name(condition)}>, which only a simulation can tell",
            "use a SimulationTimeCondition, or record the run in a simulator and import the recording",
        )
    return time


def _condition_time(condition: Node) -> float | None:
    """When a condition first holds, or None if that depends on the run."""
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
        raise leaf.error("nobody is named to follow this trajectory", "name its actors by <EntityRef>")
    is_read = leaf.tag in ACTED_ON and (initial or leaf.tag != "SpeedAction")
    time = start.time if is_read else 0.0
    for name in actors:
        yield TimedAction(time, name, leaf, is_read)


def _leaf(action: Node) -> tuple[Node | None, str | None]:
    """The innermost action, None if it does not concern motion, and the entity that it names itself."""
    node, entity = action, None
    while (inner := next((child for child in node.children if child.tag.endswith("Action")), None)) is not None:
        node, entity = inner, inner.attributes.get("entityRef", entity)
        if node.tag in WITHOUT_MOTION:
            return None, None
        if node.tag in ACTED_ON:
            break
    return (node, entity) if node is not action else (None, None)
