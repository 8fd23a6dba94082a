"""Points that fill a range, and the largest range without a failing point. Plain numpy."""

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from engine.tables import Bools, Floats


def spread(count: int, dimensions: int) -> Floats:
    """Return (count, dimensions) points that fill [0, 1]: equally spaced with both ends in one dimension, else those of
    the lattice of Kronecker with the generalised golden ratio, and the corners.

    Source: Roberts (2018), "The unreasonable effectiveness of quasirandom sequences".
    """
    if dimensions == 1:
        return np.linspace(0.0, 1.0, max(2, count))[:, np.newaxis]
    ratio = 2.0
    for _ in range(64):
        ratio = (1.0 + ratio) ** (1.0 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1.0)
    inside = (0.5 + np.arange(1, count + 1)[:, np.newaxis] * steps) % 1.0
    return np.concatenate([np.array(list(product((0.0, 1.0), repeat=dimensions))), inside])


def largest_ranges(points: Floats, failed: Bools, ends: Floats) -> Iterator[tuple[float, float]]:
    """Yield for each param the range of the most points (n, d) that lie between failing ones; NaN if all fail.

    Its ends are points; without a failing one they are those of the range searched (d, 2).
    """
    if not failed.any():
        yield from map(tuple, ends.tolist())
        return
    for column in range(len(ends)):
        order = np.argsort(points[:, column], kind="stable")
        kept = np.split(points[order, column], np.flatnonzero(failed[order]))
        inside = [part[1:] if number else part for number, part in enumerate(kept)]
        most = max(inside, key=len)
        yield (float(most[0]), float(most[-1])) if len(most) else (math.nan, math.nan)
