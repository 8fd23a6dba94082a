"""Motion of a replay after the ego's first contact, where players differ.

Contact physics keeps outlines apart, so a player that detects overlap finds no collision. A replay may therefore go
`through`: all actors continue at their velocities just before contact; or `stop`: all actors stand at their places a
moment after contact. In both cases outlines overlap. Neither is motion of the run, so measurements of such a file
ignore it.
"""

from dataclasses import replace

import numpy as np

from engine.interchange.recording import Recording
from engine.tables import Floats
from engine.vocabulary import State

ONWARD = 1.0
"""Duration of the motion after contact [s]: visible in any player, too short to be taken for a recorded motion."""
BEFORE = 1e-3
"""Least time before contact over which velocities are taken, and time after contact at which actors stop [s]."""
FACT = "after_contact"
"""Key of the choice in the provenance of a file."""
POSE = slice(State.X, State.HEADING + 1)


def shown_after_contact(recording: Recording, after: str) -> Recording:
    """Return the recording with its motion after contact, of `contract.AFTER_CONTACT`; unchanged without contact."""
    contact = recording.contact
    if contact is None or after == "physics":
        return recording
    last = recording.scored_samples() - 1
    time = _whole_steps(recording, contact.time + ONWARD if after == "through" else float(recording.time[-1]))
    states = np.repeat(recording.states[[last]], len(time), axis=0)
    passed = time - recording.time[last] if after == "through" else np.full(len(time), BEFORE)
    states[:, :, POSE] += passed[:, np.newaxis, np.newaxis] * _rates(recording, last)
    if after == "stop":
        states[:, :, State.SPEED : State.PRESENT] = 0.0
    return replace(
        recording,
        time=np.concatenate([recording.time[: last + 1], time]),
        states=np.concatenate([recording.states[: last + 1], states]),
        contact=replace(contact, after=after),
        provenance=replace(recording.provenance, facts={**recording.provenance.facts, FACT: after}),
    )


def up_to_contact(recording: Recording, time: float) -> Recording:
    """Return the recording up to contact at `time` [s], and one sample more, so that a touch is an overlap."""
    end = int(np.searchsorted(recording.time, time, "right")) + 1
    return replace(recording, time=recording.time[:end], states=recording.states[:end])


def _whole_steps(recording: Recording, end: float) -> Floats:
    """Return the times of the steps after the last scored sample up to an instant, at least one."""
    begin, step = float(recording.time[recording.scored_samples() - 1]), recording.step
    first = int(np.floor(begin / step + 1e-9)) + 1
    return np.arange(first, max(first, int(np.floor(end / step + 1e-9))) + 1, dtype=np.float64) * step


def _rates(recording: Recording, last: int) -> Floats:
    """Return (actors, 3) the rates of x, y and heading just before contact; by speed for an actor that has just
    appeared.
    """
    time, states = recording.time, recording.states
    speed, heading = states[last, :, State.SPEED], states[last, :, State.HEADING]
    rates = np.column_stack([speed * np.cos(heading), speed * np.sin(heading), np.zeros(len(heading))])
    earlier = np.flatnonzero(time[: last + 1] <= time[last] - BEFORE)
    if len(earlier):
        both = states[[earlier[-1], last]]
        known = (both[:, :, State.PRESENT] != 0.0).all(axis=0)
        rates[known] = ((both[1] - both[0]) / (time[last] - time[earlier[-1]]))[known, POSE]
    return rates
