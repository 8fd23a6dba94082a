"""What a page replays of one run: poses and speeds of everybody, and how the deciding pair came near, over time.

Numbers travel as whole numbers, each series as its first value and the differences: a hundred samples of one series
take some 300 bytes. Positions in centimetres, headings in milliradians, speeds in millimetres a second.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cortex_dsl.page.case import Approach, Shape
from engine.metrics import scored_samples, time_step
from engine.scenes import Trajectory
from engine.tables import Floats
from engine.vocabulary import State

PER_METRE = 100.0
PER_RADIAN = 1000.0
PER_SPEED = 1000.0


def replay_data(
    trajectory: Trajectory, drawn: Sequence[Shape], near: Approach, key_time: float, speeds: Floats
) -> dict[str, Any]:
    """The embedded form, which `replay.js` reads; `speeds` (samples, actors) [m/s], NaN for who is not there."""
    return {
        "step": time_step(trajectory),
        "samples": len(trajectory.time),
        "scored": scored_samples(trajectory),
        "contact": trajectory.contact_sample,
        "key": key_time,
        "actors": [
            _actor(trajectory.states[:, actor], speeds[:, actor], shape.name) for actor, shape in enumerate(drawn)
        ],
        "distance": packed(near.distance, PER_METRE),
        "closing": packed(near.closing_speed, PER_SPEED),
    }


def _actor(states: Floats, speeds: Floats, name: str) -> dict[str, Any]:
    there = states[:, State.PRESENT] > 0.5
    return {
        "name": name,
        "present": _spans(there),
        "x": packed(np.where(there, states[:, State.X], np.nan), PER_METRE),
        "y": packed(np.where(there, states[:, State.Y], np.nan), PER_METRE),
        "heading": packed(np.where(there, _unwound(states[:, State.HEADING]), np.nan), PER_RADIAN),
        "speed": packed(speeds, PER_SPEED),
    }


def _unwound(angles: Floats) -> Floats:
    """Without jumps of a whole turn, so that what lies between two samples is between their values."""
    return np.unwrap(np.where(np.isfinite(angles), angles, 0.0))


def _spans(flags: np.ndarray) -> list[list[int]]:
    """Half-open stretches of samples where a flag holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2).tolist()


def packed(values: Floats, scale: float) -> list[int | None]:
    """The first number, then differences; None where there is no number, which the next difference passes over."""
    result: list[int | None] = []
    before = 0
    for value in values.tolist():
        if math.isfinite(value):
            now = round(value * scale)
            result.append(now - before)
            before = now
        else:
            result.append(None)
    return result
