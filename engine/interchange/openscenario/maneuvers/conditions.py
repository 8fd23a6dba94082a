"""Triggers as OpenSCENARIO has them: groups of conditions, each with an edge."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from engine.interchange.errors import InterchangeError
from engine.interchange.openscenario.document import world_position
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.places import Places
from engine.interchange.openscenario.maneuvers.plan import Condition, Measure, Trigger
from engine.interchange.openscenario.names import literal
from engine.interchange.openscenario.versions import Version
from engine.interchange.xml_text import Element, child, decimal

STOP = "StopTrigger"
START = "StartTrigger"


@dataclass(frozen=True)
class Notation:
    """How numbers, places and rules are written in one file."""

    version: Version
    values: Mapping[str, float]
    """Of the parameters, in this case."""
    places: Places

    def text(self, formula: Formula) -> str:
        """A formula as an attribute; a number where the version cannot say more."""
        if self.version.has_expressions or not formula.operands:
            return formula.expression()
        return decimal(formula.value(self.values))

    def time(self, condition: Condition) -> str:
        """The limit of a condition on the time."""
        if condition.limit.plain and not condition.below:
            return decimal(self.version.time_value(condition.limit.number))
        return self.text(condition.limit)

    def rule(self, condition: Condition) -> str:
        return "lessThan" if condition.below else self.version.rule


@dataclass(frozen=True)
class Edged:
    """A condition, and whether it must have become true just now."""

    condition: Condition
    rises: bool = False


def steady(trigger: Trigger) -> tuple[tuple[Edged, ...], ...]:
    """A trigger that is set for as long as it holds."""
    return tuple(tuple(Edged(each) for each in group) for group in trigger)


Groups = Sequence[Sequence[Edged]]


def add_trigger(parent: Element, tag: str, named: Iterable[tuple[str, Groups]], notation: Notation) -> Element:
    """A `StartTrigger` or `StopTrigger`, as its parent's last child; each name is that of its groups' conditions.

    Raises:
        InterchangeError: OpenSCENARIO has no words for a condition.
    """
    trigger = child(parent, tag)
    for name, groups in named:
        for number, group in enumerate(groups, 1):
            element = child(trigger, "ConditionGroup")
            for place, edged in enumerate(group, 1):
                _condition(element, literal(f"{name} {number}.{place}"), edged, notation)
    return trigger


def _condition(group: Element, name: str, edged: Edged, notation: Notation) -> None:
    edge = "rising" if edged.rises else "none"
    element = child(group, "Condition", name=name, delay=0, conditionEdge=edge)
    condition = edged.condition
    if not condition.can_be_said:
        what = f"the opposite of `{condition.measure.value}` of `{condition.actor}`"
        raise InterchangeError(f"OpenSCENARIO has no condition for {what}", "export the case in trajectory mode")
    if condition.measure is Measure.TIME:
        by_value = child(element, "ByValueCondition")
        child(by_value, "SimulationTimeCondition", value=notation.time(condition), rule=notation.rule(condition))
        return
    by_entity = child(element, "ByEntityCondition")
    entities = child(by_entity, "TriggeringEntities", triggeringEntitiesRule="any")
    child(entities, "EntityRef", entityRef=condition.actor)
    WRITERS[condition.measure](child(by_entity, "EntityCondition"), condition, notation)


def _travelled(parent: Element, condition: Condition, notation: Notation) -> None:
    child(parent, "TraveledDistanceCondition", value=notation.text(condition.limit))


def _speed(parent: Element, condition: Condition, notation: Notation) -> None:
    child(parent, "SpeedCondition", value=notation.text(condition.limit), rule=notation.rule(condition))


def _relative_distance(parent: Element, condition: Condition, notation: Notation) -> None:
    child(
        parent,
        "RelativeDistanceCondition",
        entityRef=condition.other,
        relativeDistanceType=notation.version.straight_distance,
        value=notation.text(condition.limit),
        freespace="false",
        rule=notation.rule(condition),
    )


def _time_to_collision(parent: Element, condition: Condition, notation: Notation) -> None:
    limit, rule, how = notation.text(condition.limit), notation.rule(condition), notation.version.distance_attributes
    element = child(parent, "TimeToCollisionCondition", value=limit, freespace="true", rule=rule, **how)
    child(child(element, "TimeToCollisionConditionTarget"), "EntityRef", entityRef=condition.other)


def _distance(parent: Element, condition: Condition, notation: Notation) -> Element:
    limit, rule, how = notation.text(condition.limit), notation.rule(condition), notation.version.distance_attributes
    return child(parent, "DistanceCondition", value=limit, freespace="false", rule=rule, **how)


def _distance_to_start(parent: Element, condition: Condition, notation: Notation) -> None:
    notation.places.start(_distance(parent, condition, notation), condition.actor, notation.text)


def _distance_to_point(parent: Element, condition: Condition, notation: Notation) -> None:
    world_position(_distance(parent, condition, notation), (*condition.point, 0.0))


def _collision(parent: Element, condition: Condition, notation: Notation) -> None:
    del notation
    child(child(parent, "CollisionCondition"), "EntityRef", entityRef=condition.other)


WRITERS: Mapping[Measure, Callable[[Element, Condition, Notation], None]] = {
    Measure.TRAVELLED: _travelled,
    Measure.SPEED: _speed,
    Measure.RELATIVE_DISTANCE: _relative_distance,
    Measure.TIME_TO_COLLISION: _time_to_collision,
    Measure.DISTANCE_TO_START: _distance_to_start,
    Measure.DISTANCE_TO_POINT: _distance_to_point,
    Measure.COLLISION: _collision,
}
