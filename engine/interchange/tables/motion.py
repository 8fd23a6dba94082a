"""What positions at given times say of motion. Times need not be even; arrays are row-aligned with them."""

import numpy as np

from engine.tables import Floats

STANDING = 1e-6
"""Less way between two samples shows no direction [m]."""


def rates(time: Floats, values: Floats) -> Floats:
    """(samples, …) rate of change: central differences, one-sided at both ends; 0 of a single sample.

    Of headings that are not wrapped it is the yaw rate that `engine.kernels.pair.center_velocity` takes.
    """
    if len(time) < 2:
        return np.zeros_like(values)
    before = np.maximum(np.arange(len(time)) - 1, 0)
    after = np.minimum(np.arange(len(time)) + 1, len(time) - 1)
    span = (time[after] - time[before]).reshape(-1, *([1] * (values.ndim - 1)))
    return (values[after] - values[before]) / span


def along(heading: Floats) -> Floats:
    """(samples, 2) unit vectors ahead."""
    return np.column_stack([np.cos(heading), np.sin(heading)])


def across(heading: Floats) -> Floats:
    """(samples, 2) unit vectors to the left."""
    return np.column_stack([-np.sin(heading), np.cos(heading)])


def driven(time: Floats) -> int:
    """Samples up to and with the first that is on no step: in a table of ours, that of first contact."""
    steps = np.diff(time)
    if len(steps) == 0:
        return len(time)
    short = np.flatnonzero(steps < 0.999 * np.median(steps))
    return int(short[0]) + 2 if len(short) else len(time)


def headings_of(positions: Floats) -> Floats:
    """(samples,) directions of motion, not wrapped; at standstill the last one, or the first to come; 0 without any.

    `positions` (samples, 2). The direction at a sample is that from the sample before to the one after it.
    """
    count = len(positions)
    before, after = np.maximum(np.arange(count) - 1, 0), np.minimum(np.arange(count) + 1, count - 1)
    way = positions[after] - positions[before]
    moving = np.flatnonzero(np.hypot(way[:, 0], way[:, 1]) > STANDING)
    if len(moving) == 0:
        return np.zeros(count)
    last = moving[np.maximum(np.searchsorted(moving, np.arange(count), "right") - 1, 0)]
    return np.unwrap(np.arctan2(way[last, 1], way[last, 0]))
