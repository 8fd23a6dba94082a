"""The storyboard of a plan: where all begin and which way they go, then for each actor its phases and reactions.

Events are `parallel`: a new action on an actor's speed ends the one before, and with it its event, which may start
again (OpenSCENARIO 1.3, 7.5.1). An event that is overridden would be over for good, however often it might run
(8.4.2.2). Of several that start at once the last one stays: so phases stand in the order of the way, and reactions,
whose triggers exclude each other and the phases, need no order.
"""

from engine.interchange.openscenario.document import AT_ONCE, speed_action, teleport, time_trigger
from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.conditions import (
    START,
    STOP,
    Edged,
    Groups,
    Notation,
    add_trigger,
    steady,
)
from engine.interchange.openscenario.maneuvers.plan import (
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
from engine.interchange.openscenario.storyboard import add_group, add_replay
from engine.interchange.openscenario.trajectory import stretches
from engine.interchange.recording import Recording
from engine.interchange.xml_text import Element, child

OFTEN = 1000
"""How often an event may happen that has no limit of its own."""
STANDING = formula.number(0.01)
"""Who is slower stands [m/s]."""


def add_storyboard(root: Element, recording: Recording, plan: ManeuverPlan, notation: Notation) -> Element:
    storyboard = child(root, "Storyboard")
    actions = child(child(storyboard, "Init"), "Actions")
    for index, actor in enumerate(plan.actors):
        if recording.there[0, index]:  # who is not named is not there yet
            _begin(child(actions, "Private", entityRef=actor.name), actor, notation)
    act = child(child(storyboard, "Story", name="maneuver_story"), "Act", name="maneuver_act")
    for index, actor in enumerate(plan.actors):
        if actor.exact:
            add_replay(act, actor.name, stretches(recording, index), notation.version)
        else:
            maneuver = child(add_group(act, actor.name), "Maneuver", name=f"{actor.name}_maneuver")
            _events(maneuver, actor, notation)
    if not len(act):
        add_group(act, plan.actors[0].name)  # all stand still, and an act needs a group
    time_trigger(act, START, "maneuver_begins", 0.0, notation.version)
    # two ends may have one name, which readers take for one condition
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
        if number or phase.change.speed != actor.speed:  # else it has that speed already
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
    """Once, where the phase begins, or as soon after that as nothing else is on."""
    when = all_of([calm, _after(actor, phase.begins)])
    if phase.faster_than is not None:
        fast = Condition(Measure.SPEED, phase.faster_than, below=False, actor=actor.name)
        when = all_of([when, ((fast,),)])
    _changes(maneuver, f"{actor.name}_{phase.name}", 1, phase.change, steady(when), notation)


def _resumed(maneuver: Element, actor: ActorPlan, phase: Phase, calm: Trigger, notation: Notation) -> None:
    """Each time that a reaction is over. All phases that have begun are resumed, of which the last one stays."""
    begun = _after(actor, phase.begins)[0]
    groups = [
        [*(Edged(each, rises=each is last) for each in group), *map(Edged, begun)] for group in calm for last in group
    ]
    _changes(maneuver, f"{actor.name}_{phase.name}_again", OFTEN, phase.change, groups, notation)


def _reaction(maneuver: Element, actor: ActorPlan, reaction: Reaction, notation: Notation) -> None:
    """For as long as its trigger holds and the actor moves."""
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
    """An event that goes to another speed."""
    event = _event(maneuver, name, times)
    action = child(child(event, "Action", name=f"{name}_action"), "PrivateAction")
    rate = {"dynamicsShape": "linear", "value": notation.text(change.rate), "dynamicsDimension": "rate"}
    speed_action(action, rate, notation.text(change.speed))
    add_trigger(event, START, [(name, when)], notation)
