"""Statistics against known values, against scipy, and their laws."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from engine.search.statistics import (
    a12,
    a12_bounds,
    a12_interval,
    clopper_pearson,
    fisher,
    holm,
    mann_whitney,
    mcnemar,
    midranks,
    newcombe_interval,
    residual_bound,
    spearman,
    tango_interval,
)

samples = st.lists(st.integers(-8, 8).map(float), min_size=1, max_size=12)


def pairs_won(first: list[float], second: list[float]) -> float:
    """A12 by its definition."""
    wins = sum((x > y) + 0.5 * (x == y) for x in first for y in second)
    return wins / (len(first) * len(second))


@given(samples, samples)
def test_a12_is_its_definition(first: list[float], second: list[float]) -> None:
    """The rank form counts pairs."""
    assert a12(first, second) == pytest.approx(pairs_won(first, second), abs=1e-12)


@given(samples, samples)
def test_a12_is_antisymmetric(first: list[float], second: list[float]) -> None:
    """Exchanging the samples mirrors A12 at 1/2."""
    assert a12(first, second) + a12(second, first) == pytest.approx(1.0)


@given(samples, samples)
def test_a12_sees_order_only(first: list[float], second: list[float]) -> None:
    """A monotone change of scale changes nothing."""
    assert a12(np.exp(first), np.exp(second)) == pytest.approx(a12(first, second))


def test_a12_known_values() -> None:
    """All above is 1, all equal 1/2; an empty sample has none."""
    assert a12([4, 5, 6], [1, 2, 3]) == 1.0
    assert a12([1, 1], [1, 1, 1]) == 0.5
    assert a12([1, 2, 3], [2, 3, 4]) == pytest.approx(2 / 9)
    assert math.isnan(a12([], [1.0]))


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=15))
def test_midranks_are_those_of_scipy(values: list[int]) -> None:
    """Ties share the mean of their ranks."""
    assert np.array_equal(midranks(values), stats.rankdata(values))


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=3, max_size=20))
def test_spearman_is_that_of_scipy(points: list[tuple[int, int]]) -> None:
    """Rank correlation with ties; NaN where one side never changes."""
    first, second = zip(*points, strict=True)
    found = spearman(first, second)
    if len(set(first)) == 1 or len(set(second)) == 1:
        assert math.isnan(found)
    else:
        assert found == pytest.approx(stats.spearmanr(first, second).statistic, abs=1e-9)


def test_holm_known_values() -> None:
    """Smallest p times 4, next times 3, never falling, never above 1, in the order given."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([0.9, 0.8]) == pytest.approx((1.0, 1.0))
    assert holm([]) == ()


def test_holm_leaves_missing_tests_out() -> None:
    """A test that could not be made does not count in its family."""
    adjusted = holm([0.02, float("nan"), 0.01])
    assert adjusted[0] == pytest.approx(0.02)
    assert math.isnan(adjusted[1])
    assert adjusted[2] == pytest.approx(0.02)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=10))
def test_holm_laws(p_values: list[float]) -> None:
    """Adjusted values are between p and min(1, n p), and keep the order of p."""
    adjusted = holm(p_values)
    for p, q in zip(p_values, adjusted, strict=True):
        assert p <= q <= 1.0
    order = np.argsort(p_values, kind="stable")
    assert list(np.array(adjusted)[order]) == sorted(adjusted)


def test_mann_whitney_known_values() -> None:
    """Clearly apart is significant, equal is not, and ties alone say nothing."""
    assert mann_whitney(range(30), range(40, 70)) < 1e-9
    assert mann_whitney([1, 2, 3], [1, 2, 3]) == pytest.approx(1.0)
    assert mann_whitney([2, 2], [2, 2]) == 1.0
    assert math.isnan(mann_whitney([], [1]))


def test_mann_whitney_is_exact_where_that_is_easy() -> None:
    """Five against five, all apart: 2 of the 252 orders are as extreme. Ties and larger samples are approximated."""
    assert mann_whitney(range(5), range(10, 15)) == pytest.approx(2 / 252)
    tied = mann_whitney([1, 2, 3, 4, 4], [5, 6, 7, 8, 9])
    assert tied == pytest.approx(stats.mannwhitneyu([1, 2, 3, 4, 4], [5, 6, 7, 8, 9], method="asymptotic").pvalue)


def test_only_the_order_counts_and_infinite_values_have_one() -> None:
    """Runs without a number rank last, all of them alike."""
    endless = [3.0, 4.0, math.inf, math.inf]
    assert mann_whitney(endless, [5.0, 6.0, 7.0]) == pytest.approx(mann_whitney([3, 4, 99, 99], [5, 6, 7]))
    assert a12(endless, [5.0, 6.0, 7.0]) == 0.5
    assert mann_whitney([math.inf] * 3, [math.inf] * 2) == 1.0


def test_bootstrap_interval_covers() -> None:
    """The interval holds the estimate, is repeatable, narrows with the sample, and ends at 1 when all is won."""
    rng = np.random.default_rng(3)
    first, second = rng.normal(0.5, 1, 30), rng.normal(0, 1, 30)
    interval = a12_interval(first, second)
    assert interval == a12_interval(first, second)
    assert interval.low < a12(first, second) < interval.high
    wide = a12_interval(first[:8], second[:8])
    assert wide.high - wide.low > interval.high - interval.low
    assert a12_interval([5, 6], [1, 2]) == (1.0, 1.0)
    assert math.isnan(a12_interval([], [1]).low)


def one_after_the_other(first: list[float], second: list[float], resamples: int, seed: int) -> tuple[float, float]:
    """The bootstrap interval, each resample by itself."""
    a, b = np.asarray(first), np.asarray(second)
    stream = np.random.Generator(np.random.Philox(seed))
    rows_a = stream.integers(len(a), size=(resamples, len(a)))
    rows_b = stream.integers(len(b), size=(resamples, len(b)))
    values = [a12(a[i], b[j]) for i, j in zip(rows_a, rows_b, strict=True)]
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)


@given(samples, samples)
def test_all_resamples_at_once_are_those_of_one_after_the_other(first: list[float], second: list[float]) -> None:
    """The bilinear form draws the same numbers and gives the same interval."""
    slow = one_after_the_other(first, second, resamples=50, seed=3)
    assert a12_interval(first, second, resamples=50, seed=3) == pytest.approx(slow)


@pytest.mark.parametrize(("successes", "trials"), [(0, 7), (7, 7), (3, 20), (361, 2157)])
def test_exact_intervals_are_scipys(successes: int, trials: int) -> None:
    """Clopper and Pearson's, from the quantiles of the beta distribution."""
    expected = stats.binomtest(successes, trials).proportion_ci(0.95, method="exact")
    assert clopper_pearson(successes, trials) == pytest.approx((expected.low, expected.high))


def test_an_exact_interval_of_the_literature() -> None:
    """0 of 10: the rule of three's exact form, 1 - 0.025 ** (1 / 10)."""
    assert clopper_pearson(0, 10) == pytest.approx((0.0, 1.0 - 0.025**0.1))


def test_odds_of_the_lady_tasting_tea() -> None:
    """Fisher's own example: 3 of 4 right, p = 0.4857 two-sided."""
    found = fisher((3, 1), (4, 4))
    assert found.ratio == 9.0
    assert found.p == pytest.approx(34 / 70)


def test_an_interval_that_never_collapses() -> None:
    """Complete separation says the more, the more runs there are: 1.00 of five runs is not 1.00 of a hundred."""
    lows = [a12_bounds(range(100, 100 + runs), range(runs)).low for runs in (2, 5, 30, 100)]
    assert lows == sorted(lows)
    assert 0.3 < lows[0] < 0.5
    assert 0.97 < lows[-1] < 0.99
    assert a12_bounds(range(5), range(100, 105)).high == pytest.approx(1.0 - lows[1])
    assert a12_bounds([1] * 5, [1] * 5).low < 0.25
    assert math.isnan(a12_bounds([], [1]).low)


def test_the_ends_of_newcombes_interval_solve_his_equation() -> None:
    """Each lies 1.96 of its own standard errors from the estimate (Hanley and McNeil's variance, equal halves)."""
    for value in (0.3, 0.9, 1.0):
        interval = newcombe_interval(value, 20, 30)
        for end, sign in zip(interval, (1.0, -1.0), strict=True):
            if end in (0.0, 1.0) or end > 1.0 - 1e-9:
                continue
            first, second = end / (2.0 - end), 2.0 * end * end / (1.0 + end)
            variance = end * (1 - end) + 24.0 * (first - end * end + second - end * end)
            assert end + sign * 1.959964 * math.sqrt(variance / 600.0) == pytest.approx(value, abs=1e-6)


@given(samples, samples)
def test_bounds_hold_the_estimate_and_the_bootstrap(first: list[float], second: list[float]) -> None:
    bounds, drawn = a12_bounds(first, second), a12_interval(first, second)
    assert bounds.low - 1e-9 <= a12(first, second) <= bounds.high + 1e-9
    assert bounds.low <= drawn.low
    assert bounds.high >= drawn.high
    assert bounds.high > bounds.low


# -- paired trials -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "p", "interval"),
    [
        ((1, 1, 7, 12), 0.070313, (-0.5172, -0.0260)),
        ((59, 6, 16, 80), 0.052479, (-0.1240, -0.0054)),
    ],
)
def test_paired_examples_that_are_published(table: tuple[int, ...], p: float, interval: tuple[float, float]) -> None:
    """Two examples of Fagerland, Lydersen and Laake (2014), "Recommended tests and confidence intervals for paired
    binomial proportions": airway hyper-responsiveness, and response to a therapy.
    """
    _, first_only, second_only, _ = table
    assert mcnemar(first_only, second_only) == pytest.approx(p, abs=1e-6)
    assert tango_interval(first_only, second_only, sum(table)) == pytest.approx(interval, abs=1e-4)


pairs_of = st.integers(1, 400).flatmap(
    lambda n: st.tuples(st.just(n), st.integers(0, n)).flatmap(
        lambda nb: st.tuples(st.just(nb[0]), st.just(nb[1]), st.integers(0, nb[0] - nb[1]))
    )
)


@given(pairs_of, st.sampled_from((0.8, 0.95, 0.99)))
def test_the_interval_of_a_paired_difference(counts: tuple[int, int, int], level: float) -> None:
    """It holds the estimate, is mirrored if both sides change places, and its ends have the score of its level, where
    the constrained estimate is the best of a fine grid.
    """
    n, b, c = counts
    low, high = tango_interval(b, c, n, level)
    assert -1.0 <= low <= (b - c) / n <= high <= 1.0
    assert tango_interval(c, b, n, level) == pytest.approx((-high, -low), abs=1e-9)
    assert mcnemar(b, c) == mcnemar(c, b)
    assert mcnemar(b, c) == pytest.approx(stats.binomtest(b, b + c, 0.5).pvalue if b + c else 1.0)
    z = stats.norm.ppf((1.0 + level) / 2.0)
    for end in (low, high):
        if abs(end) > 0.999:
            continue
        best = max(0.0, -end)
        grid = np.linspace(best, (1.0 - end) / 2.0, 200_001)[1:-1]
        with np.errstate(divide="ignore"):
            likelihood = b * np.log(grid + end) + c * np.log(grid) + (n - b - c) * np.log(1.0 - 2.0 * grid - end)
        q = grid[np.argmax(likelihood)]
        variance = n * (2.0 * q + end * (1.0 - end))
        assert abs((b - c - n * end) ** 2 / variance / z**2 - 1.0) < 0.02


@pytest.mark.parametrize(
    ("rates", "n"), [((0.05, 0.1), 60), ((0.02, 0.02), 200), ((0.3, 0.1), 30), ((0.01, 0.08), 100)]
)
def test_the_interval_covers_the_difference(rates: tuple[float, float], n: int) -> None:
    """Its coverage, summed over every table, is that of its level."""
    p, q = rates
    covered = 0.0
    for b in range(n + 1):
        for c in range(n + 1 - b):
            weight = stats.multinomial.pmf([b, c, n - b - c], n, [p, q, 1.0 - p - q])
            if weight > 1e-9:
                low, high = tango_interval(b, c, n)
                covered += weight * (low <= p - q <= high)
    assert 0.935 < covered < 0.98


def test_the_bound_of_a_rate_without_an_event() -> None:
    """It is the one-sided bound of Clopper and Pearson, and 3 / n where n is large."""
    assert residual_bound(10_000) == pytest.approx(3.0e-4, rel=2e-3)
    for n in (1, 7, 300):
        assert residual_bound(n) == pytest.approx(stats.beta.ppf(0.95, 1, n))
    assert residual_bound(0) == 1.0
