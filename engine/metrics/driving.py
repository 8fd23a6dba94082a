"""Metrics of one actor from its recorded states: use of wheel and pedals, and jerk."""

import math

import numpy as np

from engine.metrics.table import PAPER, Measure
from engine.tables import Floats
from engine.vocabulary import State

STEERING_DEAD_BAND = 0.01
"""Steering rate below which a change has no sign [rad/s]."""


def steering_oscillation(states: Floats, step: float) -> float:
    """Return sign changes of the steering rate per second; rates within the dead band are ignored. NaN without a step.

    `states` (samples, len(State)) of one actor. As a command metric: Table 1 of the CORTEX-AVD paper.
    """
    rate = np.diff(states[:, State.STEER]) / step
    return _changes_a_second(np.sign(rate[np.abs(rate) > STEERING_DEAD_BAND]), len(states) - 1, step)


def pedal_oscillation(states: Floats, step: float) -> float:
    """Return switches between throttle and brake per second; coasting in between is ignored, brake has priority."""
    pedal = np.where(states[1:, State.BRAKE] > 0.0, -1.0, np.sign(states[1:, State.THROTTLE]))
    return _changes_a_second(pedal[pedal != 0.0], len(states) - 1, step)


def _changes_a_second(signs: Floats, steps: int, step: float) -> float:
    return float(np.count_nonzero(np.diff(signs))) / (steps * step) if steps > 0 else math.nan


def hardest_braking(states: Floats, step: float) -> float:
    """Return the largest recorded deceleration along the heading [m/s^2]; 0 if the actor never slowed down.

    Backwards driving counts, too; a step with a change of direction is ignored, as it shows no braking.
    """
    speed = states[:, State.SPEED]
    slower = -np.diff(np.abs(speed))[speed[1:] * speed[:-1] >= 0.0] / step
    return float(np.max(slower, initial=0.0)) if len(states) > 1 else math.nan


def jerk(states: Floats, step: float) -> float:
    """Return the largest rate of the acceleration along the heading [m/s^3]; NaN with fewer than three samples.

    The acceleration is that of the recorded speeds, step by step, so an immediate change gives a jerk over one step.
    """
    return _largest_rate(np.diff(states[:, State.SPEED]) / step, step)


def lateral_jerk(states: Floats, step: float) -> float:
    """Return the largest rate of the acceleration across the heading: speed times yaw rate, at mid-step [m/s^3]."""
    turn = np.diff(np.unwrap(states[:, State.HEADING]))
    speed = 0.5 * (states[1:, State.SPEED] + states[:-1, State.SPEED])
    return _largest_rate(speed * turn / step, step)


def _largest_rate(values: Floats, step: float) -> float:
    return float(np.abs(np.diff(values)).max()) / step if len(values) > 1 else math.nan


OF_ACTORS: tuple[Measure[[Floats, float]], ...] = (
    Measure(
        "braking",
        "hardest braking",
        "m/s^2",
        "largest deceleration",
        "max of -d|v| / dt, step by step",
        "the motion itself",
        hardest_braking,
    ),
    Measure(
        "jerk",
        "jerk along the heading",
        "m/s^3",
        "largest change of acceleration a second",
        "max |d2v / dt2|, step by step",
        "the motion itself",
        jerk,
        "Pedals act at once here, so each change of a pedal is a jerk over one time step.",
    ),
    Measure(
        "lateral jerk",
        "jerk across the heading",
        "m/s^3",
        "largest change of lateral acceleration a second",
        "max |d(v yaw rate) / dt|, step by step",
        "the motion itself",
        lateral_jerk,
    ),
    Measure(
        "steering oscillation",
        "oscillation of steering",
        "1/s",
        "sign changes of the steering rate",
        "sign changes of the steering rate a second, without rates below 0.01 rad/s",
        PAPER,
        steering_oscillation,
        of_commands=True,
    ),
    Measure(
        "pedal oscillation",
        "oscillation of pedals",
        "1/s",
        "switches between throttle and brake",
        "switches between throttle and brake a second",
        PAPER,
        pedal_oscillation,
        of_commands=True,
    ),
)
"""Metrics in the order of reports; values are functions of an actor's states (samples, len(State)) and the time step.
"""
