"""Cells of domains: each value lies in one cell at most, and counts are those of a plain loop."""

import math
from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from engine.gates.coverage import MISSING, OUTSIDE, Counted, count_cells, counted, places_of, products

ENDS = st.lists(st.integers(-20, 20), min_size=2, max_size=8, unique=True).map(sorted)
VALUES = st.lists(st.integers(-25, 25) | st.floats(-25, 25) | st.sampled_from([math.nan, math.inf, -math.inf]))


@given(ENDS, st.data(), VALUES)
def test_a_value_lies_in_the_cell_that_a_loop_finds(ends: list[int], data: st.DataObject, values: list[float]) -> None:
    """Cells with gaps, in any order: the place of a value is that of a comparison with each cell."""
    kept = data.draw(st.lists(st.booleans(), min_size=len(ends) - 1, max_size=len(ends) - 1).filter(any))
    cells = [pair for pair, keep in zip(pairwise(ends), kept, strict=True) if keep]
    cells = data.draw(st.permutations(cells))
    begins = {low for low, _ in cells}
    closed = [high not in begins for _, high in cells]
    found = places_of(
        np.array(values, dtype=np.float64),
        np.array([low for low, _ in cells], dtype=np.float64),
        np.array([high for _, high in cells], dtype=np.float64),
        np.array(closed),
    )
    for value, place in zip(values, found.tolist(), strict=True):
        if not math.isfinite(value):
            assert place == MISSING
            continue
        within = [
            i
            for i, ((low, high), end) in enumerate(zip(cells, closed, strict=True))
            if low <= value < high or (end and value == high)
        ]
        assert len(within) <= 1
        assert place == (within[0] if within else OUTSIDE)


@given(st.lists(st.tuples(st.integers(-2, 2), st.integers(-2, 2), st.booleans(), st.integers(0, 5))))
def test_counts_are_those_of_a_loop(rows: list[tuple[int, int, bool, int]]) -> None:
    """Runs, failures and the worst run of each cell."""
    expected: dict[tuple[int, ...], Counted] = {}
    for number, (one, other, failed, severity) in enumerate(rows):
        if min(one, other) < 0:
            continue
        known = expected.get((one, other))
        worse = known is None or severity > rows[known.worst][3]
        runs, failures = (0, 0) if known is None else (known.runs, known.failures)
        worst = number if known is None or worse else known.worst
        expected[one, other] = Counted(runs + 1, failures + failed, worst)
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    places = table[:, :2].astype(np.int64)
    assert counted(places, table[:, 2] == 1.0, table[:, 3]) == expected


@given(st.lists(st.integers(1, 9), min_size=1, max_size=5), st.integers(1, 3))
def test_the_number_of_cells_is_that_of_all_products(sizes: list[int], ways: int) -> None:
    total = sum(math.prod(sizes[i] for i in each) for each in products(sizes, ways))
    assert count_cells(sizes, ways) == total
