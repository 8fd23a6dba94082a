"""Covering arrays: every allowed combination is in a row, no forbidden one is, and arrays are as small as others'."""

from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.gates.covering import ANY, Combination, covering_array
from tests.laws import examples

SIZES = st.lists(st.integers(1, 5), min_size=1, max_size=6)


@st.composite
def spaces(draw: st.DrawFn) -> tuple[list[int], int, list[Combination]]:
    """Sizes, ways, and forbidden combinations of up to so many domains."""
    sizes = draw(SIZES)
    ways = draw(st.integers(1, min(3, len(sizes))))
    forbidden: list[Combination] = []
    for _ in range(draw(st.integers(0, 8))):
        count = draw(st.integers(1, ways))
        domains = tuple(sorted(draw(st.permutations(range(len(sizes))))[:count]))
        forbidden.append((domains, tuple(draw(st.integers(0, sizes[domain] - 1)) for domain in domains)))
    return sizes, ways, forbidden


@examples(50)
@given(spaces(), st.integers(0, 3))
def test_each_allowed_combination_is_in_a_row(space: tuple[list[int], int, list[Combination]], seed: int) -> None:
    """And no row has a forbidden one; an equal call gives equal rows."""
    sizes, ways, forbidden = space
    rows = covering_array(sizes, ways, forbidden, seed)
    assert np.array_equal(rows, covering_array(sizes, ways, forbidden, seed))
    held = {
        (domains, tuple(row[list(domains)].tolist()))
        for row in rows
        for domains in combinations(range(len(sizes)), ways)
    }
    wanted = {
        (domains, cells)
        for domains in combinations(range(len(sizes)), ways)
        for cells in product(*(range(sizes[domain]) for domain in domains))
        if not any(_holds(dict(zip(domains, cells, strict=True)), never) for never in forbidden)
    }
    assert wanted == {(domains, cells) for domains, cells in held if ANY not in cells}
    for row in rows.tolist():
        assert not any(_holds(dict(enumerate(row)), never) for never in forbidden)


def _holds(row: dict[int, int], combination: Combination) -> bool:
    return all(row.get(domain) == cell for domain, cell in zip(*combination, strict=True))


def expanded(*groups: tuple[int, int]) -> list[int]:
    """Return the sizes of (size, number) groups."""
    return [size for size, number in groups for _ in range(number)]


PAIRS = [
    (expanded((3, 4)), 9),
    (expanded((3, 13)), 17),
    (expanded((2, 10)), 8),
    (expanded((4, 5)), 22),
    (expanded((5, 3), (4, 2), (2, 4)), 30),
    (expanded((6, 4)), 43),
    (expanded((12, 2), (3, 4)), 144),
    (expanded((10, 20)), 219),
]
"""Rows of allpairspy 2.5.1 (`len(list(AllPairs(...)))`)."""
TRIPLES = [
    (expanded((3, 4)), 32),
    (expanded((2, 10)), 21),
    (expanded((4, 5)), 64),
    (expanded((3, 6)), 48),
    (expanded((4, 6)), 64),
    (expanded((5, 6)), 208),
    (expanded((5, 2), (4, 2), (3, 2)), 106),
    (expanded((10, 1), (6, 2), (4, 3), (3, 1)), 375),
]
"""Rows of IPOG, the algorithm of ACTS, in testflows.combinatorics 1.1 (`len(list(Covering(..., strength=3)))`)."""
TCAS = (expanded((2, 7), (3, 2), (4, 1), (10, 2)), 400)
"""Rows of ACTS for the module TCAS: Lei, Kacker, Kuhn, Okun and Lawrence (2007), "IPOG: a general strategy for t-way
software testing", ECBS.
"""


@pytest.mark.parametrize(
    ("sizes", "reference", "ways"),
    [*((*each, 2) for each in PAIRS), *((*each, 3) for each in TRIPLES), (*TCAS, 3)],
)
def test_arrays_have_at_most_a_fifth_more_rows_than_those_of_others(
    sizes: list[int], reference: int, ways: int
) -> None:
    assert len(covering_array(sizes, ways)) <= 1.2 * reference
