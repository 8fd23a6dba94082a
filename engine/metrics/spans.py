"""Which part of a trajectory is measured: up to the end of the scored run, and while those measured are there."""

import numpy as np

from engine.scenes import Trajectory
from engine.vocabulary import State


def scored_samples(trajectory: Trajectory) -> int:
    """Samples up to the end of the scored run; what contact physics shows afterwards is left out."""
    return trajectory.contact_sample + 1 if trajectory.contact_sample >= 0 else len(trajectory.time)


def span_together(trajectory: Trajectory, other: int) -> tuple[int, int]:
    """The first scored sample at which the ego and another are both present, and at how many they are from then on."""
    present = trajectory.states[: scored_samples(trajectory), [0, other], State.PRESENT] != 0.0
    return _stretch(present.all(axis=1))


def span_of(trajectory: Trajectory, actor: int) -> tuple[int, int]:
    """The first scored sample at which an actor is present, and at how many it is from then on."""
    return _stretch(trajectory.states[: scored_samples(trajectory), actor, State.PRESENT] != 0.0)


def time_step(trajectory: Trajectory) -> float:
    """Time between two samples [s]; of a single sample, any."""
    return float(trajectory.time[1] - trajectory.time[0]) if len(trajectory.time) > 1 else 1.0


def _stretch(flags: np.ndarray) -> tuple[int, int]:
    """The first flag that holds, and how many do without a gap; 0, 0 where none does."""
    if not flags.any():
        return 0, 0
    first = int(np.argmax(flags))
    rest = flags[first:]
    return first, len(rest) if rest.all() else int(np.argmin(rest))
