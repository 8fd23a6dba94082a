"""The storyboard of a plan: where all begin and which way they go, then for each actor its phases and reactions.

Events are `parallel`: a new action on an actor's speed ends the one before, and with it its event, which may start again
(OpenSCENARIO 1.3, 7.5.1). An event that is overridden would be over for good, however often it might run (8.4.2.2). Of
several that start at once the last one stays: so phases stand in the order of the way, and reactions, whose triggers
exclude each other and the phases, need no order.
"""

from collections.abc import Sequence

from engine.interchange.openscenario.document import teleport, time_trigger
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.conditions import START, STOP, Edged, Words, add_trigger, steady
from engine.interchange.openscenario.maneuvers.plan import (
    ActorPlan,
    Change,
    Condition,
    End,
    ManeuverPlan,
    Measure,
    Phase,
    Reaction,
    Trigger,
    all_of,
    any_of,
    none_of,
)
from engine.interchange.openscenario.storyboard import add_replay
from engine.interchange.openscenario.trajectory import stretches
from engine.interchange.recording import Recording
from engine.interchange.xml_text import Element, child
from engine.vocabulary import State

OFTEN = 1000
"""How often an event may happen that has no limit of its own."""
STANDING = formula.number(0.01)
"""Who is slower stands [m/s]."""


def add_storyboard(root: Element, recording: Recording, plan: ManeuverPlan, words: Words) -> Element:
    storyboard = child(root, "Storyboard")
    actions = child(child(storyboard, "Init"), "Actions")
    for index, actor in enumerate(plan.actors):
        if recording.states[0, index, State.PRESENT]:  # who is not named is not there yet
            _begin(child(actions, "Private", entityRef=actor.name), actor, words)
    act = child(child(storyboard, "Story", name="maneuver_story"), "Act", name="maneuver_act")
    for index, actor in enumerate(plan.actors):
        if actor.exact:
            add_replay(act, actor.name, stretches(recording, index), words.version)
        else:
            maneuver = child(_group(act, actor.name), "Maneuver", name=f"{actor.name}_maneuver")
            _events(maneuver, actor, words)
    if not len(act):
        _group(act, plan.actors[0].name)  # all stand still, and an act needs a group
    time_trigger(act, START, "maneuver_begins", 0.0, words.version)
    _ends(storyboard, plan.ends, words)
    return storyboard


def _begin(private: Element, actor: ActorPlan, words: Words) -> None:
    """Place, speed and route at the start."""
    if actor.start.lane is None:
        teleport(private, actor.start.pose)
    else:
        words.places.start(child(child(private, "PrivateAction"), "TeleportAction"), actor.name, words.text)
    step = {"dynamicsShape": "step", "value": "0", "dynamicsDimension": "time"}
    _speed_action(child(private, "PrivateAction"), step, words.text(actor.speed))
    if actor.route:
        routing = child(child(private, "PrivateAction"), "RoutingAction")
        route = child(child(routing, "AssignRouteAction"), "Route", name=f"{actor.name}_route", closed="false")
        words.places.way(route, actor, words.text)


def _speed_action(private_action: Element, dynamics: dict[str, str], speed: str) -> None:
    action = child(child(private_action, "LongitudinalAction"), "SpeedAction")
    child(action, "SpeedActionDynamics", **dynamics)
    child(child(action, "SpeedActionTarget"), "AbsoluteTargetSpeed", value=speed)


def _group(act: Element, name: str) -> Element:
    group = child(act, "ManeuverGroup", name=f"{name}_group", maximumExecutionCount=1)
    child(child(group, "Actors", selectTriggeringEntities="false"), "EntityRef", entityRef=name)
    return group


# -- events -----------------------------------------------------------------------------------------------------------


def _events(maneuver: Element, actor: ActorPlan, words: Words) -> None:
    busy = any_of(reaction.when for reaction in actor.reactions)
    for number, phase in enumerate(actor.phases):
        if number or phase.change.speed != actor.speed:  # else it has that speed already
            _phase(maneuver, actor, phase, none_of(busy), words)
        if busy and phase.faster_than is None:
            _resumed(maneuver, actor, phase, none_of(busy), words)
    for reaction in actor.reactions:
        _reaction(maneuver, actor, reaction, words)
    if actor.leaves is not None:
        _leave(maneuver, actor, _after(actor, actor.leaves), words)
    if not len(maneuver):
        _phase(maneuver, actor, actor.phases[0], none_of(busy), words)


def _phase(maneuver: Element, actor: ActorPlan, phase: Phase, calm: Trigger, words: Words) -> None:
    """Once, where the phase begins, or as soon after that as nothing else is on."""
    when = all_of([calm, _after(actor, phase.begins)])
    if phase.faster_than is not None:
        fast = Condition(Measure.SPEED, phase.faster_than, below=False, actor=actor.name)
        when = all_of([when, ((fast,),)])
    _change(_event(maneuver, f"{actor.name}_{phase.name}", 1), phase.change, words)
    add_trigger(maneuver[-1], START, f"{actor.name}_{phase.name}", steady(when), words)


def _resumed(maneuver: Element, actor: ActorPlan, phase: Phase, calm: Trigger, words: Words) -> None:
    """Each time that a reaction is over. All phases that have begun are resumed, of which the last one stays."""
    name = f"{actor.name}_{phase.name}_again"
    begun = _after(actor, phase.begins)[0]
    groups = [
        [*(Edged(each, rises=each is last) for each in group), *map(Edged, begun)] for group in calm for last in group
    ]
    _change(_event(maneuver, name, OFTEN), phase.change, words)
    add_trigger(maneuver[-1], START, name, groups, words)


def _reaction(maneuver: Element, actor: ActorPlan, reaction: Reaction, words: Words) -> None:
    """For as long as its trigger holds and the actor moves."""
    name = f"{actor.name}_{reaction.name}"
    moves = Condition(Measure.SPEED, STANDING, below=False, actor=actor.name)
    _change(_event(maneuver, name, OFTEN), reaction.change, words)
    add_trigger(maneuver[-1], START, name, steady(all_of([reaction.when, ((moves,),)])), words)


def _leave(maneuver: Element, actor: ActorPlan, when: Trigger, words: Words) -> None:
    event = _event(maneuver, f"{actor.name}_leaves", 1)
    action = child(child(event, "Action", name=f"{actor.name}_leaves_action"), "GlobalAction")
    child(child(action, "EntityAction", entityRef=actor.name), "DeleteEntityAction")
    add_trigger(event, START, f"{actor.name}_leaves", steady(when), words)


def _after(actor: ActorPlan, way: formula.Formula) -> Trigger:
    if way == formula.ZERO:
        return ((Condition(Measure.TIME, formula.ZERO, below=False),),)
    return ((Condition(Measure.TRAVELLED, way, below=False, actor=actor.name),),)


def _event(maneuver: Element, name: str, times: int) -> Element:
    return child(maneuver, "Event", name=name, priority="parallel", maximumExecutionCount=times)


def _change(event: Element, change: Change, words: Words) -> None:
    name = f"{event.get('name')}_action"
    rate = {"dynamicsShape": "linear", "value": words.text(change.rate), "dynamicsDimension": "rate"}
    _speed_action(child(child(event, "Action", name=name), "PrivateAction"), rate, words.text(change.speed))


def _ends(storyboard: Element, ends: Sequence[End], words: Words) -> None:
    trigger = child(storyboard, STOP)
    for number, end in enumerate(ends, 1):  # two ends may have one name, which readers take for one condition
        part = add_trigger(storyboard, STOP, f"end {number}, {end.name}:", steady(end.when), words)
        trigger.extend(part)
        storyboard.remove(part)
