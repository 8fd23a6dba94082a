"""The storyboard of a replay: where all begin, and for each actor when it comes, how it moves and when it goes."""

from collections.abc import Sequence

from engine.interchange.openscenario.document import start_speed, stop_trigger, teleport, time_trigger, world_position
from engine.interchange.openscenario.trajectory import Stretch, follow_trajectory, stretches
from engine.interchange.openscenario.versions import Version
from engine.interchange.recording import Recording
from engine.interchange.xml_text import Element, child
from engine.vocabulary import State


def add_storyboard(root: Element, recording: Recording, names: Sequence[str], version: Version) -> Element:
    """The replay of a whole recording under the names of `names.entity_names`."""
    storyboard = child(root, "Storyboard")
    add_init(storyboard, recording, names, version)
    act = child(child(storyboard, "Story", name="replay_story"), "Act", name="replay_act")
    for actor, name in enumerate(names):
        add_replay(act, name, stretches(recording, actor), version)
    if not len(act):
        add_group(act, names[0])  # all stand still, and an act needs a group
    time_trigger(act, "StartTrigger", "replay_begins", 0.0, version)
    stop_trigger(storyboard, float(recording.time[-1]), version)
    return storyboard


def add_init(storyboard: Element, recording: Recording, names: Sequence[str], version: Version) -> Element:
    """Place and speed of all who are there at the beginning; who is not named here is not there yet."""
    actions = child(child(storyboard, "Init"), "Actions")
    for actor, name in enumerate(names):
        if recording.there[0, actor]:
            private = child(actions, "Private", entityRef=name)
            teleport(private, recording.rear_axle(actor)[0])
            start_speed(private, float(recording.states[0, actor, State.SPEED]), version)
    return actions


def add_replay(act: Element, name: str, parts: Sequence[Stretch], version: Version) -> None:
    """The maneuver group of one actor; none if it is there from beginning to end and never moves."""
    if not any(part.moves or part.starts_late or part.gone is not None for part in parts):
        return
    maneuver = child(add_group(act, name), "Maneuver", name=f"{name}_maneuver")
    for number, part in enumerate(parts, start=1):
        if part.moves or part.starts_late:
            _begin(maneuver, name, number, part, version)
        if part.gone is not None:
            _leave(maneuver, name, number, part.gone, version)


def add_group(act: Element, name: str) -> Element:
    """An empty maneuver group of one actor."""
    group = child(act, "ManeuverGroup", name=f"{name}_group", maximumExecutionCount=1)
    child(child(group, "Actors", selectTriggeringEntities="false"), "EntityRef", entityRef=name)
    return group


def _begin(maneuver: Element, name: str, number: int, part: Stretch, version: Version) -> None:
    event = child(maneuver, "Event", name=f"{name}_event_{number}", priority=version.priority)
    if part.starts_late:
        world_position(child(_entity_action(event, name, f"{name}_enters_{number}"), "AddEntityAction"), part.poses[0])
    if part.moves:
        action = child(event, "Action", name=f"{name}_moves_{number}")
        follow_trajectory(action, part, f"{name}_trajectory_{number}", version)
    time_trigger(event, "StartTrigger", f"{name}_begins_{number}", float(part.time[0]), version)


def _leave(maneuver: Element, name: str, number: int, gone: float, version: Version) -> None:
    event = child(maneuver, "Event", name=f"{name}_exit_{number}", priority=version.priority)
    child(_entity_action(event, name, f"{name}_leaves_{number}"), "DeleteEntityAction")
    time_trigger(event, "StartTrigger", f"{name}_ends_{number}", gone, version)


def _entity_action(event: Element, name: str, action: str) -> Element:
    return child(child(child(event, "Action", name=action), "GlobalAction"), "EntityAction", entityRef=name)
