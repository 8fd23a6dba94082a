"""How fast everybody moves, also after contact, where bodies slide sideways and spin."""

import numpy as np

from engine.metrics import time_step
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State


def speeds(trajectory: Trajectory) -> Floats:
    """(samples, actors) [m/s]. Up to contact as the actor drives, backwards negative; from then on of its centre,
    whatever way it heads: over the step that follows a sample, so that none mixes what was before the blow with what
    came after it; the last sample goes on with the braking before it. NaN where an actor is not in the scene.
    """
    found = np.where(trajectory.states[..., State.PRESENT] > 0.5, trajectory.states[..., State.SPEED], np.nan)
    first = trajectory.contact_sample + 1
    if 0 < first < len(found) - 1:
        x, y = trajectory.states[first:, :, State.X], trajectory.states[first:, :, State.Y]
        moved = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0)) / time_step(trajectory)
        last = np.maximum(0.0, 2.0 * moved[-1:] - moved[-2:-1] if len(moved) > 1 else moved)
        moved = np.concatenate([moved, last])
        found[first:] = np.where(np.isnan(found[first:]), np.nan, moved)
    return found
