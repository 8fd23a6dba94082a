"""Triggers as OpenSCENARIO has them: groups of conditions, each with an edge."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from engine.interchange.openscenario.document import world_position
from engine.interchange.openscenario.maneuvers.formula import Formula, decimal
from engine.interchange.openscenario.maneuvers.places import Places
from engine.interchange.openscenario.maneuvers.plan import Condition, Measure, Trigger
from engine.interchange.openscenario.names import literal
from engine.interchange.openscenario.versions import Version
from engine.interchange.xml_text import Element, child

STOP = "StopTrigger"
START = "StartTrigger"


@dataclass(frozen=True)
class Words:
    """How numbers, places and rules are written in one file."""

    version: Version
    values: Mapping[str, float]
    """Of the parameters, in this case."""
    places: Places

    @property
    def has_expressions(self) -> bool:
        """1.0 knows bare parameters only."""
        return self.version.minor > 0

    def text(self, formula: Formula) -> str:
        """A formula as an attribute; a number where the version cannot say more."""
        if self.has_expressions or not formula.operands:
            return formula.expression()
        return decimal(formula.value(self.values))

    def time(self, condition: Condition) -> str:
        """The limit of a condition on the time."""
        if condition.limit.plain and not condition.below:
            return decimal(self.version.time_value(condition.limit.number))
        return self.text(condition.limit)

    def rule(self, condition: Condition) -> str:
        if condition.below:
            return "lessThan"
        return "greaterOrEqual" if self.version.minor > 0 else "greaterThan"


@dataclass(frozen=True)
class Edged:
    """A condition, and whether it must have become true just now."""

    condition: Condition
    rises: bool = False


def steady(trigger: Trigger) -> tuple[tuple[Edged, ...], ...]:
    """A trigger that is set for as long as it holds."""
    return tuple(tuple(Edged(each) for each in group) for group in trigger)


def add_trigger(parent: Element, tag: str, name: str, groups: Iterable[Iterable[Edged]], words: Words) -> Element:
    """A `StartTrigger` or `StopTrigger`, as its parent's last child."""
    trigger = child(parent, tag)
    for number, group in enumerate(groups, 1):
        element = child(trigger, "ConditionGroup")
        for place, edged in enumerate(group, 1):
            _condition(element, literal(f"{name} {number}.{place}"), edged, words)
    return trigger


def _condition(group: Element, name: str, edged: Edged, words: Words) -> None:
    edge = "rising" if edged.rises else "none"
    element = child(group, "Condition", name=name, delay=0, conditionEdge=edge)
    condition = edged.condition
    if condition.measure is Measure.TIME:
        by_value = child(element, "ByValueCondition")
        child(by_value, "SimulationTimeCondition", value=words.time(condition), rule=words.rule(condition))
        return
    by_entity = child(element, "ByEntityCondition")
    entities = child(by_entity, "TriggeringEntities", triggeringEntitiesRule="any")
    child(entities, "EntityRef", entityRef=condition.actor)
    WRITERS[condition.measure](child(by_entity, "EntityCondition"), condition, words)


def _travelled(parent: Element, condition: Condition, words: Words) -> None:
    child(parent, "TraveledDistanceCondition", value=words.text(condition.limit))


def _speed(parent: Element, condition: Condition, words: Words) -> None:
    child(parent, "SpeedCondition", value=words.text(condition.limit), rule=words.rule(condition))


def _apart(parent: Element, condition: Condition, words: Words) -> None:
    old = words.version.minor == 0
    child(
        parent,
        "RelativeDistanceCondition",
        entityRef=condition.other,
        relativeDistanceType="cartesianDistance" if old else "euclidianDistance",
        value=words.text(condition.limit),
        freespace="false",
        rule=words.rule(condition),
    )


def _collision_time(parent: Element, condition: Condition, words: Words) -> None:
    old = {"alongRoute": "false"} if words.version.minor == 0 else {"relativeDistanceType": "euclidianDistance"}
    limit, rule = words.text(condition.limit), words.rule(condition)
    element = child(parent, "TimeToCollisionCondition", value=limit, freespace="true", rule=rule, **old)
    child(child(element, "TimeToCollisionConditionTarget"), "EntityRef", entityRef=condition.other)


def _distance(parent: Element, condition: Condition, words: Words) -> Element:
    old = {"alongRoute": "false"} if words.version.minor == 0 else {"relativeDistanceType": "euclidianDistance"}
    limit, rule = words.text(condition.limit), words.rule(condition)
    return child(parent, "DistanceCondition", value=limit, freespace="false", rule=rule, **old)


def _from_start(parent: Element, condition: Condition, words: Words) -> None:
    words.places.start(_distance(parent, condition, words), condition.actor, words.text)


def _from_point(parent: Element, condition: Condition, words: Words) -> None:
    world_position(_distance(parent, condition, words), (*condition.point, 0.0))


def _touch(parent: Element, condition: Condition, words: Words) -> None:
    del words
    child(child(parent, "CollisionCondition"), "EntityRef", entityRef=condition.other)


WRITERS: Mapping[Measure, Callable[[Element, Condition, Words], None]] = {
    Measure.TRAVELLED: _travelled,
    Measure.SPEED: _speed,
    Measure.APART: _apart,
    Measure.COLLISION_TIME: _collision_time,
    Measure.FROM_START: _from_start,
    Measure.FROM_POINT: _from_point,
    Measure.TOUCH: _touch,
}
