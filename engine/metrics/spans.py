"""Measured parts of a trajectory: up to the end of the scored run, while the measured actors are present."""

import numpy as np

from engine.scenes import Trajectory
from engine.vocabulary import State


def scored_samples(trajectory: Trajectory) -> int:
    """Return the number of samples up to the end of the scored run, without those of contact physics."""
    return trajectory.contact_sample + 1 if trajectory.contact_sample >= 0 else len(trajectory.time)


def span_together(trajectory: Trajectory, other: int) -> tuple[int, int]:
    """Return the first scored sample with the ego and another actor, and the number of samples with both."""
    present = trajectory.states[: scored_samples(trajectory), [0, other], State.PRESENT] != 0.0
    return _stretch(present.all(axis=1))


def span_of(trajectory: Trajectory, actor: int) -> tuple[int, int]:
    """Return the first scored sample with an actor, and the number of samples with it from then on."""
    return _stretch(trajectory.states[: scored_samples(trajectory), actor, State.PRESENT] != 0.0)


def time_step(trajectory: Trajectory) -> float:
    """Return the time between two samples [s]; 1 for a single sample."""
    return float(trajectory.time[1] - trajectory.time[0]) if len(trajectory.time) > 1 else 1.0


def _stretch(flags: np.ndarray) -> tuple[int, int]:
    """Return the first flag that is True, and the length of its run without a gap; 0, 0 if none is True."""
    if not flags.any():
        return 0, 0
    first = int(np.argmax(flags))
    rest = flags[first:]
    return first, len(rest) if rest.all() else int(np.argmin(rest))
