"""Trajectory mode: a case as an `.xosc` that replays it exactly.

Each stretch of an actor's motion is a timed polyline; the storyboard contains all starts, and for each actor its
appearance, motion and departure.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from engine.interchange.contract import Export, ExportOptions
from engine.interchange.opendrive import SignalGroup, signal_groups
from engine.interchange.openscenario.document import (
    add_entities,
    add_environment,
    entity_names,
    new_document,
    remarks_on_environment,
    start_speed,
    stop_trigger,
    teleport,
    time_trigger,
    world_position,
)
from engine.interchange.openscenario.versions import Version, version_of
from engine.interchange.own_metadata import of_samples
from engine.interchange.recording import MOST_ACTORS, RecordedActor, Recording, SignalTimes
from engine.interchange.xml_writing import Element, child, xml_text
from engine.tables import Bools, Floats
from engine.vocabulary import State
from engine.xml import LIMITS, MEGABYTE

# -- one stretch of motion as a timed polyline -------------------------------------------------------------------------


@dataclass(frozen=True)
class Stretch:
    """A time span in which an actor is present without a break."""

    time: Floats
    """(samples,) [s]."""
    poses: Floats
    """(samples, 3): x, y, heading of the reference point."""
    starts_late: bool
    """True if the actor is absent at the beginning."""
    gone: float | None
    """The first sample without it [s]; None if it stays to the end."""
    below: float = 0.0
    """Depth under the road [m], where a player places absent actors."""
    heights: Floats | None = None
    """(samples,) Heights of the road [m]; None on a road without bridges."""

    @property
    def moves(self) -> bool:
        """Return True if the pose changes; a stretch at one pose needs no trajectory."""
        return bool((self.poses != self.poses[0]).any())

    def vertices(self) -> tuple[Floats, Floats]:
        """Return times and poses without those inside a standstill, which carry no motion and make readers spin."""
        moving = ~self._inside_standstills()
        return self.time[moving], self.poses[moving]

    def depths(self) -> Floats:
        """Return the depth of each vertex under height 0 [m]."""
        heights = np.zeros(len(self.time)) if self.heights is None else self.heights
        return self.below - heights[~self._inside_standstills()]

    def _inside_standstills(self) -> Bools:
        same = (self.poses[1:] == self.poses[:-1]).all(axis=1)
        return np.concatenate([[False], same]) & np.concatenate([same, [False]])

    def shortest_way(self) -> float:
        """Return the least distance between consecutive vertices [m]; infinite for a single one."""
        _, poses = self.vertices()
        return float(np.hypot(*np.diff(poses[:, :2], axis=0).T).min(initial=np.inf))


def stretches(recording: Recording, actor: int) -> list[Stretch]:
    """Return all stretches of an actor, in order."""
    poses, last, heights = recording.rear_axle(actor), len(recording) - 1, recording.heights
    return [
        Stretch(
            time=recording.time[start : end + 1],
            poses=poses[start : end + 1],
            starts_late=start > 0,
            gone=None if end == last else float(recording.time[end + 1]),
            heights=None if heights is None else heights[start : end + 1, actor],
        )
        for start, end in recording.stretches(actor)
    ]


def follow_trajectory(action: Element, stretch: Stretch, name: str, version: Version) -> None:
    """Add the private action that replays a stretch: absolute times and mode `position`, so that nothing steers."""
    routing = child(child(action, "PrivateAction"), "RoutingAction")
    follow = child(routing, "FollowTrajectoryAction")
    holder = child(follow, "TrajectoryRef") if version.trajectory_in_reference else follow
    trajectory = child(holder, "Trajectory", name=name, closed="false")
    polyline = child(child(trajectory, "Shape"), "Polyline")
    for time, pose, depth in zip(*stretch.vertices(), stretch.depths().tolist(), strict=True):
        world_position(child(polyline, "Vertex", time=float(time)), pose, depth)
    child(child(follow, "TimeReference"), "Timing", domainAbsoluteRelative="absolute", scale=1, offset=0)
    child(follow, "TrajectoryFollowingMode", followingMode="position")


# -- the storyboard ----------------------------------------------------------------------------------------------------


def add_storyboard(root: Element, recording: Recording, names: Sequence[str], version: Version) -> Element:
    """Add the replay of a whole recording under the names of `entity_names`."""
    storyboard = child(root, "Storyboard")
    add_init(storyboard, recording, names, version)
    act = child(child(storyboard, "Story", name="replay_story"), "Act", name="replay_act")
    for actor, name in enumerate(names):
        add_replay(act, name, stretches(recording, actor), version)
    if not len(act):
        add_group(act, names[0])  # no actor moves, but an act needs a group
    time_trigger(act, "StartTrigger", "replay_begins", 0.0, version)
    stop_trigger(storyboard, float(recording.time[-1]), version)
    return storyboard


def add_init(storyboard: Element, recording: Recording, names: Sequence[str], version: Version) -> Element:
    """Place and speed of all that are there at the beginning; an entity that is not named here is absent."""
    actions = child(child(storyboard, "Init"), "Actions")
    add_environment(actions, recording, version)
    for actor, name in enumerate(names):
        if recording.there[0, actor]:
            private = child(actions, "Private", entityRef=name)
            depth = 0.0 if recording.heights is None else -float(recording.heights[0, actor])
            teleport(private, recording.rear_axle(actor)[0], depth)
            start_speed(private, float(recording.states[0, actor, State.SPEED]), version)
    return actions


def add_replay(act: Element, name: str, parts: Sequence[Stretch], version: Version) -> None:
    """Add the maneuver group of one actor; none if it is present from beginning to end and never moves."""
    if not any(part.moves or part.starts_late or part.gone is not None for part in parts):
        return
    maneuver = child(add_group(act, name), "Maneuver", name=f"{name}_maneuver")
    for number, part in enumerate(parts, start=1):
        if part.moves or part.starts_late:
            _begin(maneuver, name, number, part, version)
        if part.gone is not None:
            _leave(maneuver, name, number, part.gone, version)


def add_group(act: Element, name: str) -> Element:
    """Add an empty maneuver group of one actor."""
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


# -- traffic lights: a fixed-time plan as phases of the road's signal controllers --------------------------------------

RED, YELLOW, GREEN = "on;off;off", "off;on;off", "off;off;on"
"""Lamps from top to bottom, the spelling that esmini and ScenarioRunner read."""


@dataclass(frozen=True)
class SignalPhase:
    """State of a group's lights for a duration [s]."""

    name: str
    duration: float
    state: str


def add_signals(network: Element, recording: Recording) -> Element | None:
    """Add the lights of all junctions, last in a `RoadNetwork`; None without lights, or without a road."""
    if recording.signals is None or recording.road is None:
        return None
    signals = child(network, "TrafficSignals")
    for group in signal_groups(recording.road):
        _add_controller(signals, group, recording.signals)
    return signals


def _add_controller(signals: Element, group: SignalGroup, times: SignalTimes) -> None:
    controller = child(signals, "TrafficSignalController", name=group.controller)
    for phase in phases(times, group.phase):
        element = child(controller, "Phase", name=phase.name, duration=phase.duration)
        for signal in group.signals:
            child(element, "TrafficSignalState", trafficSignalId=signal, state=phase.state)


def phases(times: SignalTimes, turn: int) -> tuple[SignalPhase, ...]:
    """Return the phases of a group from the beginning of the run on, with the first (0) or second (1) turn of the plan.

    A run that begins within a phase begins with its rest, and the part before comes last.
    """
    mine = (
        SignalPhase("green", times.green, GREEN),
        SignalPhase("yellow", times.yellow, YELLOW),
        SignalPhase("clear", times.all_red, RED),
    )
    others = SignalPhase("red", times.slot, RED)
    plan = (*mine, others) if turn == 0 else (others, *mine)
    return tuple(phase for phase in _begun(plan, times.offset % times.cycle) if phase.duration > 0.0)


def _begun(plan: tuple[SignalPhase, ...], offset: float) -> tuple[SignalPhase, ...]:
    for index, phase in enumerate(plan):
        if offset < phase.duration:
            rest = SignalPhase(phase.name, phase.duration - offset, phase.state)
            before = SignalPhase(f"{phase.name}_before", offset, phase.state)
            return (rest, *plan[index + 1 :], *plan[:index], before)
        offset -= phase.duration
    return plan


# -- the file ----------------------------------------------------------------------------------------------------------

SHOWN_AFTER = {
    "through": "no motion of the run: all go on as they went, through each other, so that outlines overlap",
    "stop": "no motion of the run: all stand where they touched",
    "physics": "contact physics, replayed as it was",
}
MERGED = 0.1
"""Distance below which esmini 3.6 merges vertices [m]: its default of `--traj_filter`."""


def write_trajectories(recording: Recording, stem: str, options: ExportOptions, road_file: str | None) -> Export:
    """Write `<stem>.xosc`, in which every actor replays its motion; `road_file` is the name of the `.xodr` next to it.

    Raises:
        InterchangeError: the recording is empty or broken, or the ego is never present.
    """
    begun = begin_replay(recording, options, road_file)
    add_storyboard(begun.root, begun.shown, begun.names, begun.version)
    text = xml_text(begun.root)
    remarks = (
        *begun.remarks,
        *_remarks_on_players(begun.shown, begun.version),
        *_remarks_on_size(begun.shown, text),
    )
    return Export({f"{stem}.xosc": text}, remarks)


class Begun(NamedTuple):
    """A replay up to its storyboard."""

    root: Element
    shown: Recording
    """Recording of the actors that appear, from time 0."""
    names: tuple[str, ...]
    version: Version
    remarks: tuple[str, ...]


def begin_replay(
    recording: Recording,
    options: ExportOptions,
    road_file: str | None,
    title: str = "",
    model_of: Callable[[RecordedActor], str] | None = None,
) -> Begun:
    """Write head, road, lights and entities; `model_of`: name of the player's model for an actor.

    Raises:
        InterchangeError: the recording is empty or broken, or the ego is never present.
    """
    recording.refuse_broken()
    recording = recording.taking_part()
    version, shown = version_of(options), recording.from_zero()
    names = entity_names(shown)
    document = new_document(shown, version, road_file, title=title)
    if road_file is not None:
        add_signals(document.network, shown)
    carried = [of_samples(shown, actor) for actor in range(len(names))]
    models = () if model_of is None else [model_of(actor) for actor in shown.actors]
    add_entities(document.root, shown, names, version, carried, models)
    return Begun(document.root, shown, names, version, tuple(general_remarks(recording, names, road_file)))


def general_remarks(recording: Recording, names: tuple[str, ...], road_file: str | None) -> Iterator[str]:
    """Yield facts that OpenSCENARIO cannot express, or expresses differently."""
    what = "speeds, steering, accelerations and pedals" if recording.commands else "speeds and accelerations"
    yield (
        f"OpenSCENARIO has no place for {what} over time: "
        "they stand as properties `cortexc.*` of each actor, which other tools pass over"
    )
    for actor, name in zip(recording.actors, names, strict=True):
        if actor.name != name:
            yield f"`{actor.name}` is called `{name}`: readers take letters, digits and underscores only"
    yield from _remarks_on_times(recording)
    yield from _remarks_on_road(recording, road_file)
    yield from remarks_on_environment(recording)


def _remarks_on_size(recording: Recording, text: str) -> Iterator[str]:
    """Yield a remark on a file that is larger than `cortexc import` accepts."""
    actors, elements, megabytes = len(recording.actors), text.count("<") - text.count("</"), len(text) / MEGABYTE
    if actors > MOST_ACTORS or elements > LIMITS.elements or megabytes > LIMITS.megabytes:
        has = f"{actors:,} actors, {elements:,} elements, {megabytes:.0f} MB"
        most = f"{MOST_ACTORS:,}, {LIMITS.elements:,} and {LIMITS.megabytes:g} MB"
        yield f"`cortexc import` refuses a file of {has}: it reads at most {most}"


def _remarks_on_times(recording: Recording) -> Iterator[str]:
    if recording.time[0] != 0.0:
        yield f"times are {recording.time[0]:g} s less than in the recording, as a scenario begins at 0"
    contact = recording.contact
    if contact is not None and contact.time < recording.time[-1]:
        yield f"what follows first contact at {contact.time:.3f} s is {SHOWN_AFTER[contact.after]}"


def _remarks_on_players(recording: Recording, version: Version) -> Iterator[str]:
    actors = range(len(recording.actors))
    if any(part.moves and part.shortest_way() < MERGED for actor in actors for part in stretches(recording, actor)):
        yield f"esmini merges vertices nearer than {MERGED:g} m, unless it is run with `--traj_filter 0`"
    late = [recording.actors[actor].name for actor in actors if not recording.there[0, actor]]
    if late and not version.late_entities:
        yield f"not there from the beginning: {', '.join(late)}; ScenarioRunner first puts them at the origin"


def _remarks_on_road(recording: Recording, road_file: str | None) -> Iterator[str]:
    if road_file is None:
        yield "no road is named: the scenario plays on an empty plane"
    if recording.signals is None:
        return
    if road_file is None or recording.road is None:
        yield "the traffic lights are left out, as there is no road for them"
    elif recording.signals.controlled:
        yield "the scenario may change its traffic lights by itself; what is written is their fixed plan alone"
