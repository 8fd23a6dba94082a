"""Cells of the product of several domains, counted over runs. Plain numpy.

A value lies in one cell of a domain at most; a cell of the product is one cell of each of its domains.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, product

import numpy as np

from engine.frozen import frozen
from engine.tables import Bools, Floats, Ints

OUTSIDE = -1
"""Place of a value that lies in no cell."""
MISSING = -2
"""Place of a run that ended before the instant of the domain, or whose value is no number."""
MOST_CELLS = 100_000
"""Maximum number of cells of all products."""
RULE_OF_THREE = 3.0
"""n draws without a success bound a probability by 3 / n at 95 %. Hanley and Lippman-Hand (1983), "If nothing goes
wrong, is everything all right?", JAMA 249.
"""


def places_of(values: Floats, low: Floats, high: Floats, closed: Bools) -> Ints:
    """Return (n,) the cell of each value, `OUTSIDE` or, for a value that is not finite, `MISSING`.

    Args:
        values: (n,)
        low: (cells,) lower ends, which belong to the cells. No two cells share one.
        high: (cells,) upper ends.
        closed: (cells,) True if the upper end belongs to the cell.
    """
    order = np.argsort(low, kind="stable")
    finite = np.isfinite(values)
    known = np.where(finite, values, low[order[0]])
    before = np.searchsorted(low[order], known, side="right") - 1
    cell = order[np.maximum(before, 0)]
    within = (before >= 0) & ((known < high[cell]) | (closed[cell] & (known == high[cell])))
    return np.where(finite, np.where(within, cell, OUTSIDE), MISSING)


def products(sizes: Sequence[int], ways: int) -> Iterator[tuple[int, ...]]:
    """Yield the numbers of `ways` domains, in order."""
    return combinations(range(len(sizes)), ways)


def cells_in(sizes: Sequence[int], domains: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield the cells of a product, in order."""
    return product(*(range(sizes[domain]) for domain in domains))


def count_cells(sizes: Sequence[int], ways: int) -> int:
    """Return the number of cells of all products of `ways` domains."""
    return sum(int(np.prod([sizes[domain] for domain in each], dtype=object)) for each in products(sizes, ways))


@frozen
class Counted:
    """Runs in one cell of a product."""

    runs: int
    failures: int
    worst: int
    """Row of the run with the largest severity, of equal ones the first."""


def counted(places: Ints, failed: Bools, severity: Floats) -> dict[tuple[int, ...], Counted]:
    """Return the cells of a product in which runs lie.

    Args:
        places: (n, domains) cells of each run.
        failed: (n,)
        severity: (n,) how bad a run is; NaN counts least.
    """
    rows = np.flatnonzero((places >= 0).all(axis=1))
    if not len(rows):
        return {}
    worse = np.where(np.isnan(severity), -np.inf, severity)[rows]
    cells, inverse, runs = np.unique(places[rows], axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)
    failures = np.bincount(inverse, weights=failed[rows], minlength=len(cells)).astype(int)
    worst = np.empty(len(cells), dtype=np.int64)
    order = np.lexsort((-rows, worse))
    worst[inverse[order]] = rows[order]
    return {
        tuple(cell): Counted(int(n), int(bad), int(row))
        for cell, n, bad, row in zip(cells.tolist(), runs, failures, worst, strict=True)
    }
