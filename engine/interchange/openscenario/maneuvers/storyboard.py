"""The storyboard of a plan: starts and routes of all actors, then the phases and reactions of each actor.

Events are `parallel`: a new action on an actor's speed ends the one before, and with it its event, which may start
again (OpenSCENARIO 1.3, 7.5.1). An overridden event would end for good, for any maximum number of executions (8.4.2.2).
Of several events that start at once the last one stays active: so phases are in the order of the way; reactions, with
triggers that exclude each other and the phases, need no order.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from engine.errors import InterchangeError
from engine.interchange.openscenario.document import (
    AT_ONCE,
    add_environment,
    literal,
    speed_action,
    teleport,
    time_trigger,
    world_position,
)
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.openscenario.maneuvers.maneuver_plan import (
    ActorPlan,
    Change,
    Condition,
    ManeuverPlan,
    Measure,
    Phase,
    Reaction,
    Trigger,
    all_of,
    any_of,
    none_of,
)
from engine.interchange.openscenario.maneuvers.positions import Places
from engine.interchange.openscenario.versions import Version
from engine.interchange.openscenario.write import add_group, add_replay, stretches
from engine.interchange.recording import Recording
from engine.interchange.xml_writing import Element, child, decimal

# -- triggers: groups of conditions, each with an edge -----------------------------------------------------------------

STOP = "StopTrigger"
START = "StartTrigger"


@dataclass(frozen=True)
class Notation:
    """Notation of numbers, places and rules in one file."""

    version: Version
    values: Mapping[str, float]
    """Values of the parameters in this case."""
    places: Places

    def text(self, formula: Formula) -> str:
        """Return a formula as an attribute; a number if the version has no expressions."""
        if self.version.has_expressions or not formula.operands:
            return formula.expression()
        return decimal(formula.value(self.values))

    def time(self, condition: Condition) -> str:
        """Return the limit of a condition on the time."""
        if condition.limit.plain and not condition.below:
            return decimal(self.version.time_value(condition.limit.number))
        return self.text(condition.limit)

    def rule(self, condition: Condition) -> str:
        return "lessThan" if condition.below else self.version.rule


@dataclass(frozen=True)
class Edged:
    """A condition; with `rises` it must have become true just now."""

    condition: Condition
    rises: bool = False


def steady(trigger: Trigger) -> tuple[tuple[Edged, ...], ...]:
    """Return a trigger that is set while it holds."""
    return tuple(tuple(Edged(each) for each in group) for group in trigger)


Groups = Sequence[Sequence[Edged]]


def add_trigger(parent: Element, tag: str, named: Iterable[tuple[str, Groups]], notation: Notation) -> Element:
    """Add a `StartTrigger` or `StopTrigger` as its parent's last child; each name is that of its groups' conditions.

    Raises:
        InterchangeError: OpenSCENARIO cannot express a condition.
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

# -- the storyboard ----------------------------------------------------------------------------------------------------

OFTEN = 1000
"""Maximum number of executions of an event without a limit of its own."""
STANDING = formula.number(0.01)
"""An actor that is slower counts as standing [m/s]."""


def add_storyboard(root: Element, recording: Recording, plan: ManeuverPlan, notation: Notation) -> Element:
    storyboard = child(root, "Storyboard")
    actions = child(child(storyboard, "Init"), "Actions")
    add_environment(actions, recording, notation.version)
    for index, actor in enumerate(plan.actors):
        if recording.there[0, index]:  # an entity without a <Private> is absent at the start
            _begin(child(actions, "Private", entityRef=actor.name), actor, notation)
    act = child(child(storyboard, "Story", name="maneuver_story"), "Act", name="maneuver_act")
    for index, actor in enumerate(plan.actors):
        if actor.exact:
            add_replay(act, actor.name, stretches(recording, index), notation.version)
        else:
            maneuver = child(add_group(act, actor.name), "Maneuver", name=f"{actor.name}_maneuver")
            _events(maneuver, actor, notation)
    if not len(act):
        add_group(act, plan.actors[0].name)  # no actor moves, but an act needs a group
    time_trigger(act, START, "maneuver_begins", 0.0, notation.version)
    # two ends may have equal names, which readers take for one condition
    ends = [(f"end {number}, {end.name}:", steady(end.when)) for number, end in enumerate(plan.ends, 1)]
    add_trigger(storyboard, STOP, ends, notation)
    return storyboard


def _begin(private: Element, actor: ActorPlan, notation: Notation) -> None:
    """Place, speed and route at the start."""
    if actor.start.lane is None:
        teleport(private, actor.start.pose)
    else:
        notation.places.start(child(child(private, "PrivateAction"), "TeleportAction"), actor.name, notation.text)
    speed_action(child(private, "PrivateAction"), AT_ONCE, notation.text(actor.speed))
    if actor.route:
        routing = child(child(private, "PrivateAction"), "RoutingAction")
        route = child(child(routing, "AssignRouteAction"), "Route", name=f"{actor.name}_route", closed="false")
        notation.places.way(route, actor, notation.text)


# -- events -----------------------------------------------------------------------------------------------------------


def _events(maneuver: Element, actor: ActorPlan, notation: Notation) -> None:
    busy = any_of(reaction.when for reaction in actor.reactions)
    for number, phase in enumerate(actor.phases):
        if number or phase.change.speed != actor.speed:  # otherwise it has that speed already
            _phase(maneuver, actor, phase, none_of(busy), notation)
        if busy and phase.faster_than is None:
            _resumed(maneuver, actor, phase, none_of(busy), notation)
    for reaction in actor.reactions:
        _reaction(maneuver, actor, reaction, notation)
    if actor.leaves is not None:
        _leave(maneuver, actor, _after(actor, actor.leaves), notation)
    if not len(maneuver):
        _phase(maneuver, actor, actor.phases[0], none_of(busy), notation)


def _phase(maneuver: Element, actor: ActorPlan, phase: Phase, calm: Trigger, notation: Notation) -> None:
    """Add an event that runs once, where the phase begins, or as soon after that as no reaction is active."""
    when = all_of([calm, _after(actor, phase.begins)])
    if phase.faster_than is not None:
        fast = Condition(Measure.SPEED, phase.faster_than, below=False, actor=actor.name)
        when = all_of([when, ((fast,),)])
    _changes(maneuver, f"{actor.name}_{phase.name}", 1, phase.change, steady(when), notation)


def _resumed(maneuver: Element, actor: ActorPlan, phase: Phase, calm: Trigger, notation: Notation) -> None:
    """Add an event for each end of a reaction. All phases that have begun are resumed; the last one stays active."""
    begun = _after(actor, phase.begins)[0]
    groups = [
        [*(Edged(each, rises=each is last) for each in group), *map(Edged, begun)] for group in calm for last in group
    ]
    _changes(maneuver, f"{actor.name}_{phase.name}_again", OFTEN, phase.change, groups, notation)


def _reaction(maneuver: Element, actor: ActorPlan, reaction: Reaction, notation: Notation) -> None:
    """Add an event that runs while its trigger holds and the actor moves."""
    moves = Condition(Measure.SPEED, STANDING, below=False, actor=actor.name)
    when = all_of([reaction.when, ((moves,),)])
    _changes(maneuver, f"{actor.name}_{reaction.name}", OFTEN, reaction.change, steady(when), notation)


def _leave(maneuver: Element, actor: ActorPlan, when: Trigger, notation: Notation) -> None:
    name = f"{actor.name}_leaves"
    event = _event(maneuver, name, 1)
    action = child(child(event, "Action", name=f"{name}_action"), "GlobalAction")
    child(child(action, "EntityAction", entityRef=actor.name), "DeleteEntityAction")
    add_trigger(event, START, [(name, steady(when))], notation)


def _after(actor: ActorPlan, way: formula.Formula) -> Trigger:
    if way == formula.ZERO:
        return ((Condition(Measure.TIME, formula.ZERO, below=False),),)
    return ((Condition(Measure.TRAVELLED, way, below=False, actor=actor.name),),)


def _event(maneuver: Element, name: str, times: int) -> Element:
    return child(maneuver, "Event", name=name, priority="parallel", maximumExecutionCount=times)


def _changes(maneuver: Element, name: str, times: int, change: Change, when: Groups, notation: Notation) -> None:
    """Add an event that changes the speed."""
    event = _event(maneuver, name, times)
    action = child(child(event, "Action", name=f"{name}_action"), "PrivateAction")
    rate = {"dynamicsShape": "linear", "value": notation.text(change.rate), "dynamicsDimension": "rate"}
    speed_action(action, rate, notation.text(change.speed))
    add_trigger(event, START, [(name, when)], notation)
