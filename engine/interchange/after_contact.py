"""What a replay shows after the ego's first contact, where players disagree.

Contact physics keeps outlines apart, so that a player which looks for overlap sees no collision in what it plays. So a
replay may go `through`: all go on as they went just before; or `stop`: all stand where they touched, a moment
on. Either way outlines overlap. Neither is motion of the run, so that what measures such a file passes over it.
"""

from dataclasses import replace

import numpy as np

from engine.interchange.recording import Recording
from engine.tables import Floats
from engine.vocabulary import State

ONWARD = 1.0
"""How long all go on after contact [s]: any player sees it, and nobody takes it for what happened."""
BEFORE = 1e-3
"""The way at contact is taken over at least this time before it; who stops does so this time after it [s]."""
FACT = "after_contact"
"""The name of the choice where a file says of itself where it comes from."""
POSE = slice(State.X, State.HEADING + 1)


def shown_after_contact(recording: Recording, after: str) -> Recording:
    """The recording as it goes on after contact, one of `contract.AFTER_CONTACT`; as it is without contact."""
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
    """What is motion of the run: up to contact at a time [s], and one sample more, where a touch is an overlap."""
    end = int(np.searchsorted(recording.time, time, "right")) + 1
    return replace(recording, time=recording.time[:end], states=recording.states[:end])


def _whole_steps(recording: Recording, end: float) -> Floats:
    """The steps after the last scored sample up to an instant, one at least."""
    begin, step = float(recording.time[recording.scored_samples() - 1]), recording.step
    first = int(np.floor(begin / step + 1e-9)) + 1
    return np.arange(first, max(first, int(np.floor(end / step + 1e-9))) + 1, dtype=np.float64) * step


def _rates(recording: Recording, last: int) -> Floats:
    """(actors, 3): how fast x, y and heading change just before contact; of who just came in, by its speed."""
    time, states = recording.time, recording.states
    speed, heading = states[last, :, State.SPEED], states[last, :, State.HEADING]
    rates = np.column_stack([speed * np.cos(heading), speed * np.sin(heading), np.zeros(len(heading))])
    earlier = np.flatnonzero(time[: last + 1] <= time[last] - BEFORE)
    if len(earlier):
        both = states[[earlier[-1], last]]
        known = (both[:, :, State.PRESENT] != 0.0).all(axis=0)
        rates[known] = ((both[1] - both[0]) / (time[last] - time[earlier[-1]]))[known, POSE]
    return rates
