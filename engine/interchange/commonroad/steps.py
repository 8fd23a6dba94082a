"""A recording in CommonRoad's time: whole steps from 0, where each actor has a state at every step until it leaves."""

import math
from dataclasses import dataclass, replace

import numpy as np

from engine.errors import InterchangeError
from engine.interchange.recording import SAME_INSTANT, Contact, RecordedActor, Recording, SignalTimes
from engine.kernels.geometry import Box, box_distance
from engine.portable import arctan, tan
from engine.road import build_network
from engine.road.outline import outline
from engine.tables import Floats
from engine.vocabulary import State

CURE = "write csv or parquet, which carry any times"
SHORT = 1e-3
"""Part of a step."""
HALVINGS = 20
PLACE = [State.X, State.Y, State.HEADING]
ASIDE = 50.0
"""Distance west of the road at which absent actors wait, and distance between them [m]."""


@dataclass(frozen=True)
class Course:
    """States of one actor at each step from 0 to its last; all arrays (steps,). SI units, angles [rad]."""

    actor: RecordedActor
    index: int
    """Index of the actor in its recording."""
    x: Floats
    """Centre of the outline, as is `y`."""
    y: Floats
    heading: Floats
    """Heading within (-2 tau, 2 tau)."""
    speed: Floats
    """Longitudinal speed of the rear axle."""
    steer: Floats
    acceleration: Floats
    yaw_rate: Floats
    slip: Floats
    """Angle from the heading to the direction of motion of the centre."""
    waits: bool
    """True if the actor waits off the road at some steps, because it is absent."""

    def __len__(self) -> int:
        return len(self.x)

    @property
    def never_moves(self) -> bool:
        return not self.waits and all(bool(np.ptp(each) == 0.0) for each in (self.x, self.y, self.heading))


@dataclass(frozen=True)
class Timeline:
    """Recording in whole steps; step 0 is the first step with the ego."""

    recording: Recording
    start: float
    """Time of step 0 in the recording [s]."""
    steps: int
    ego: Course
    others: tuple[Course, ...]
    """All actors that are present at a step."""

    @property
    def buildings(self) -> Floats:
        """Return the buildings as `Recording.buildings`."""
        return _buildings(self.recording)

    @property
    def signals(self) -> SignalTimes | None:
        """Return the plan of the lights from step 0 on."""
        signals = self.recording.signals
        return None if signals is None else replace(signals, offset=signals.offset + self.start)

    @property
    def contact_step(self) -> float | None:
        """Return the time of first contact, in steps."""
        contact = self.recording.contact
        return None if contact is None else (contact.time - self.start) / self.recording.step


def timeline(recording: Recording) -> Timeline:
    """Return the whole steps of a recording.

    Raises:
        InterchangeError: steps are missing, a state is not a number, or the ego is present at fewer than two steps.
    """
    whole = _through_contact(recording)
    stretches = whole.stretches(0)
    if not stretches or stretches[0][0] == stretches[0][1]:
        raise InterchangeError("the ego is there at fewer than two whole steps, too few for CommonRoad", CURE)
    recording.refuse_broken()
    first, last = stretches[0]
    numbers = np.round(whole.time[first:] / recording.step)
    if np.any(np.diff(numbers) != 1.0):
        raise InterchangeError("the recording leaves out steps, and CommonRoad knows no gaps", CURE)
    states = whole.states[first:]
    there = whole.there[first:]
    ego = _track(recording, states[: last - first + 1], 0)
    others = tuple(_track(recording, states, i) for i in range(1, len(recording.actors)) if there[:, i].any())
    return Timeline(recording, float(whole.time[first]), len(states), ego, others)


def _through_contact(recording: Recording) -> Recording:
    """Return the whole steps, at least one of them after contact, where the outlines of both partners overlap.

    At that step they continue as without contact; the partner may be a building. CommonRoad detects collisions at whole
    steps, and contact physics has most outlines apart again by then.
    """
    whole, contact = recording.on_steps(), recording.contact
    if contact is None:
        return whole
    after = int(np.searchsorted(whole.time, contact.time + SAME_INSTANT, "right"))
    if after == 0:
        return whole
    touching = recording.states[int(np.searchsorted(recording.time, contact.time - SAME_INSTANT))]
    if after == len(whole):
        time = np.append(whole.time, whole.time[-1] + recording.step)
        whole = replace(whole, time=time, states=np.append(whole.states, touching[None], axis=0))
    before, elapsed = whole.states[after - 1], contact.time - whole.time[after - 1]
    if elapsed < SHORT * recording.step:  # too short to show a direction
        before, elapsed = whole.states[max(after - 2, 0)], elapsed + recording.step
    ahead = (whole.time[after] - contact.time) / elapsed
    who, states = list(contact.actors), whole.states.copy()
    states[after, who] = _overlapping(recording, contact, touching[who], ahead * (touching - before)[who])
    return replace(whole, states=states)


def _overlapping(recording: Recording, contact: Contact, touching: Floats, way: Floats) -> Floats:
    """Return states of the two actors that touch, or of the ego at a building, moved along their ways until outlines
    overlap.

    The way is halved until they do, as two actors that graze have passed each other at its end.
    """
    walls = [Box(*row) for row in _buildings(recording).tolist()]
    for halvings in range(HALVINGS):
        states = touching.copy()
        states[:, PLACE] += 0.5**halvings * way[:, PLACE]
        ego, *other = (_box(recording.actors[i], state) for i, state in zip(contact.actors, states, strict=True))
        if any(box_distance(ego, each) == 0.0 for each in other or walls):
            return states
    return touching


def _buildings(recording: Recording) -> Floats:
    assert recording.road is not None
    return build_network(recording.road).buildings


def _box(actor: RecordedActor, state: Floats) -> Box:
    x, y, heading = state[PLACE].tolist()
    return Box(x, y, heading, actor.length, actor.width)


def _track(recording: Recording, states: Floats, index: int) -> Course:
    """Return an actor up to the last step at which it is present; while it is absent it waits off the road."""
    actor = recording.actors[index]
    there = states[:, index, State.PRESENT] != 0.0
    end = int(np.flatnonzero(there)[-1]) + 1
    there = there[:end]
    columns = np.where(there[:, None], states[:end, index], 0.0)
    x, y = (columns[:, column].copy() for column in (State.X, State.Y))
    if not there.all():
        x[~there], y[~there] = _aside(recording, index)
    return Course(
        actor=actor,
        index=index,
        x=x,
        y=y,
        heading=_near_zero(columns[:, State.HEADING]),
        speed=columns[:, State.SPEED],
        steer=columns[:, State.STEER],
        acceleration=columns[:, State.ACCELERATION],
        yaw_rate=_yaw_rate(columns[:, State.HEADING], there, recording.step),
        slip=arctan(tan(columns[:, State.STEER]) * actor.rear_to_center / actor.wheelbase),
        waits=not there.all(),
    )


def _aside(recording: Recording, index: int) -> tuple[float, float]:
    """Return a place west of the road, different for each actor."""
    assert recording.road is not None
    kerbs = np.vstack(outline(build_network(recording.road)).kerbs)
    west, south = kerbs.min(axis=0).tolist()
    return west - ASIDE, south - ASIDE * index


def _yaw_rate(heading: Floats, there: Floats, step: float) -> Floats:
    """Return the yaw rates of the steps that begin at each sample, the last two equal; 0 where an actor appears or is
    absent.
    """
    turns = np.where(np.logical_and(there[1:], there[:-1]), np.diff(heading), 0.0) / step
    return np.append(turns, turns[-1:] if len(turns) else [0.0])


def _near_zero(heading: Floats) -> Floats:
    """Return continuous headings shifted as near to zero as possible; wrapped where they leave two turns."""
    near: Floats = heading - math.tau * np.round(float(heading[0]) / math.tau)
    wrapped = np.remainder(near + math.pi, math.tau) - math.pi
    return np.where(np.abs(near) < math.tau, near, wrapped)
