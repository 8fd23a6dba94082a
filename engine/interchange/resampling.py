"""A recording at other instants: motion between two samples is linear."""

import numpy as np

from engine.interchange.recording import SAME_INSTANT, Recording
from engine.tables import Floats
from engine.vocabulary import State

OF_STEPS = [State.ACCELERATION, State.THROTTLE, State.BRAKE]
"""What a sample tells of the step that ended there, so that it holds all through that step."""


def states_at(recording: Recording, instants: Floats) -> Floats:
    """(instants, actors, len(State)): everybody at instants within the recording [s].

    A sample no farther than `SAME_INSTANT` away is taken as it is. Between two samples only those are there who are at
    both.
    """
    time, states = recording.time, recording.states
    after = np.minimum(np.searchsorted(time, instants - SAME_INSTANT), len(time) - 1)
    sampled = (np.abs(time[after] - instants) <= SAME_INSTANT) | (after == 0)
    before = np.where(sampled, after, after - 1)
    way = np.where(sampled, 1.0, time[after] - time[before])
    part = np.where(sampled, 0.0, (instants - time[before]) / way)[:, np.newaxis, np.newaxis]
    found = states[before] + part * (states[after] - states[before])
    found[:, :, OF_STEPS] = states[after][:, :, OF_STEPS]
    found[:, :, State.PRESENT] = (states[before, :, State.PRESENT] != 0.0) & (states[after, :, State.PRESENT] != 0.0)
    return found
