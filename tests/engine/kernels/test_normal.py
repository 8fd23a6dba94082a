"""The normal quantile and cumulative functions, against scipy."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy import special

from engine.kernels.random_numbers import normal_cdf, normal_quantile


def test_quantile_has_full_accuracy_over_all_scales():
    """Within a few units in the last place of scipy's, from 1e-300 to 1 - 1e-16."""
    tails = 10.0 ** -np.linspace(0.31, 300.0, 3000)
    levels = np.concatenate([tails, 1.0 - tails, np.linspace(0.001, 0.999, 999)])
    levels = levels[(levels > 0.0) & (levels < 1.0)]
    expected = special.ndtri(levels)
    actual = np.array([normal_quantile(level) for level in levels])
    np.testing.assert_allclose(actual, expected, rtol=2e-15, atol=1e-15)


def test_quantile_at_and_beyond_the_ends():
    """Infinite at 0 and 1, zero in the middle, NaN for what is no probability."""
    assert normal_quantile(0.0) == -math.inf
    assert normal_quantile(1.0) == math.inf
    assert normal_quantile(0.5) == 0.0
    assert all(math.isnan(normal_quantile(level)) for level in (-0.1, 1.1, math.nan))


@given(st.floats(-37.0, 8.0))
def test_cdf_equals_scipy(x):
    """The cumulative function keeps its digits in the lower tail."""
    assert math.isclose(normal_cdf(x), special.ndtr(x), rel_tol=1e-12)


@given(st.floats(-37.0, 5.0))
def test_quantile_undoes_cdf(x):
    """The quantile of the probability below x is x."""
    assert math.isclose(normal_quantile(normal_cdf(x)), x, rel_tol=1e-9, abs_tol=1e-9)
