"""The timeline of a run: who did what when, and why it was over."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from engine.outcomes import Outcomes
from engine.scenes import Trajectory
from engine.vocabulary import EndReason, State
from engine.world.impacts import Impact

PEDAL = 0.01
"""Brake pedal from which an actor is said to brake."""


class EventKind(StrEnum):
    """What happened. In brackets what `Event.value` holds."""

    BRAKE = "brake"
    """An actor touches its brake for the first time [its speed, m/s]."""
    CLOSEST = "closest"
    """The ego and another are nearest [MD, m]."""
    CONTACT = "contact"
    """First contact [0]."""
    IMPACT = "impact"
    """Two bodies met [the larger delta-V, m/s]."""
    REST = "rest"
    """A struck actor has come to rest [0]."""
    LEFT_ROAD = "left_road"
    """An actor's centre left the road [its speed, m/s]."""
    END = "end"
    """End of the scored run [`EndReason`]."""


@dataclass(frozen=True)
class Event:
    """One thing that happened."""

    time: float
    """[s]"""
    kind: EventKind
    actors: tuple[int, ...]
    value: float


def timeline(
    outcomes: Outcomes, trajectory: Trajectory, impacts: tuple[Impact, ...], rest: dict[int, float]
) -> tuple[Event, ...]:
    """All events of one run (row 0 of the outcomes), in the order of time."""
    end = float(outcomes.end_time[0])
    events = [
        *_brakes(trajectory, end),
        *_closest(outcomes),
        *_left_road(outcomes, trajectory),
        *(Event(i.time, EventKind.IMPACT, i.actors, max(i.delta_v)) for i in impacts),
        *(Event(time, EventKind.REST, (actor,), 0.0) for actor, time in rest.items()),
        _end(outcomes, end),
    ]
    return tuple(sorted(events, key=lambda event: event.time))


def _brakes(trajectory: Trajectory, end: float) -> list[Event]:
    """A pedal recorded at sample k was pressed over the step that ended there."""
    events = []
    for actor in range(trajectory.states.shape[1]):
        pressed = np.flatnonzero(trajectory.states[:, actor, State.BRAKE] > PEDAL)
        if len(pressed) and trajectory.time[first := max(0, int(pressed[0]) - 1)] <= end:
            speed = float(trajectory.states[first, actor, State.SPEED])
            events.append(Event(float(trajectory.time[first]), EventKind.BRAKE, (actor,), speed))
    return events


def _closest(outcomes: Outcomes) -> list[Event]:
    return [
        Event(float(time), EventKind.CLOSEST, (0, pair + 1), float(distance))
        for pair, (time, distance) in enumerate(
            zip(outcomes.min_distance_time[0], outcomes.min_distance[0], strict=True)
        )
        if distance > 0.0 and np.isfinite(time)
    ]


def _left_road(outcomes: Outcomes, trajectory: Trajectory) -> list[Event]:
    events = []
    for actor, time in enumerate(outcomes.left_road_time[0]):
        if np.isfinite(time):
            sample = min(int(np.searchsorted(trajectory.time, time - 1e-9)), len(trajectory.time) - 1)
            speed = float(trajectory.states[sample, actor, State.SPEED])
            events.append(Event(float(time), EventKind.LEFT_ROAD, (actor,), speed))
    return events


def _end(outcomes: Outcomes, end: float) -> Event:
    reason = EndReason(int(outcomes.end_reason[0]))
    if reason in (EndReason.COLLISION, EndReason.OTHER_COLLISION):
        one, other = (int(actor) for actor in outcomes.contact_actors[0])
        return Event(end, EventKind.CONTACT, (one, other), 0.0)
    return Event(end, EventKind.END, (), float(reason))
