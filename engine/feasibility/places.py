"""Boxes of places: what the bounds of paths, regions and outlines share."""

from collections.abc import Iterator

import numpy as np

from engine.feasibility.intervals import Bools, Interval
from engine.tables import Floats

SLACK = 1e-7
"""Far above the rounding of any of these in a road of kilometres [m]."""


def numbers(*intervals: Interval) -> Bools:
    """Boxes in which all of these are finite."""
    known = np.ones(len(intervals[0].low), dtype=bool)
    for interval in intervals:
        known &= np.isfinite(interval.low) & np.isfinite(interval.high) & ~interval.undefined
    return known


def by_id(ids: Interval, known: Bools) -> Iterator[tuple[int, np.ndarray]]:
    """Each known id, and the boxes that have it."""
    settled = known & (ids.low == ids.high)
    for value in sorted(set(ids.low[settled].tolist())):
        yield int(value), np.flatnonzero(settled & (ids.low == value))


def unknown(*operands: Interval) -> Interval:
    """Any number; NaN only from a NaN."""
    count = len(operands[0].low)
    undefined = ~numbers(*operands)
    return Interval(np.full(count, -np.inf), np.full(count, np.inf), undefined)


def put(target: Interval, rows: np.ndarray, low: Floats, high: Floats) -> None:
    """Say in some boxes what is now known; the arrays of `target` are written to."""
    target.low[rows], target.high[rows], target.undefined[rows] = low, high, False


def at_least_zero(interval: Interval) -> Interval:
    return interval._replace(low=np.maximum(interval.low, 0.0))


def centre(x: Interval, y: Interval, rows: np.ndarray) -> tuple[tuple[Floats, Floats], Floats]:
    """Middles of boxes of points, and how far their corners are from them."""
    half_x, half_y = 0.5 * (x.high[rows] - x.low[rows]), 0.5 * (y.high[rows] - y.low[rows])
    return (x.low[rows] + half_x, y.low[rows] + half_y), np.hypot(half_x, half_y) + SLACK
