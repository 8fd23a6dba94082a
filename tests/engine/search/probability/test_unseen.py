"""The probability of kinds that no draw has shown: Good's estimate, and a bound that holds for every distribution."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from engine.search.probability.unseen import NO_KIND, labels, unseen_kinds

KINDS = st.lists(st.integers(NO_KIND, 6), min_size=1, max_size=60).map(np.array)


@given(KINDS)
def test_the_estimate_is_the_share_of_kinds_seen_once(kinds: np.ndarray) -> None:
    shown = [kind for kind in kinds.tolist() if kind != NO_KIND]
    once = [kind for kind in shown if shown.count(kind) == 1]
    found = unseen_kinds(kinds)
    assert (found.kinds, found.once, found.estimate) == (len(set(shown)), len(once), len(once) / len(kinds))


@given(KINDS)
def test_the_bound_is_that_of_new_kinds_in_the_second_half(kinds: np.ndarray) -> None:
    half = len(kinds) // 2
    first, second = kinds[:half].tolist(), kinds[half:].tolist()
    new = sum(kind != NO_KIND and kind not in first for kind in second)
    exact = stats.binomtest(new, len(second)).proportion_ci(confidence_level=0.9, method="exact").high
    assert unseen_kinds(kinds).bound == pytest.approx(exact)


@given(KINDS, st.integers(1, 5))
def test_draws_of_unknown_outcome_only_raise_the_bound(kinds: np.ndarray, lost: int) -> None:
    assert unseen_kinds(kinds, lost=lost).bound >= unseen_kinds(kinds).bound


@given(KINDS)
def test_names_of_kinds_do_not_matter(kinds: np.ndarray) -> None:
    codes = np.stack([kinds, kinds, np.where(kinds == NO_KIND, NO_KIND, kinds % 2)], axis=1)
    assert unseen_kinds(labels(codes)) == unseen_kinds(kinds)


def test_no_draw_states_nothing() -> None:
    found = unseen_kinds(labels(np.zeros((0, 6), dtype=np.int16)))
    assert found.kinds == 0
    assert math.isnan(found.estimate)
    assert math.isnan(found.bound)


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0, 4.0])
def test_the_bound_holds_in_95_of_100_campaigns(power: float) -> None:
    """For rates of kinds that fall slowly or fast: in 1,000 campaigns no more misses than chance explains."""
    generator = np.random.default_rng(5)
    rates = np.arange(1.0, 201.0) ** -power
    rates *= 0.3 / rates.sum()  # three runs of ten fail
    misses = 0
    for _ in range(1000):
        kinds = generator.choice(201, size=400, p=[*rates, 0.7])
        kinds = np.where(kinds == 200, NO_KIND, kinds)
        missing = rates[~np.isin(np.arange(200), kinds)].sum()
        misses += missing > unseen_kinds(kinds).bound
    assert misses <= stats.binom.ppf(0.999, 1000, 0.05)
