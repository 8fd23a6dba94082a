"""Statistics of searches and studies. scipy is imported only inside the functions that need it."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator, Philox
from numpy.typing import ArrayLike

from engine.tables import Floats, Ints

SMALL = 20
"""Values of a sample up to which the rank-sum test is exact."""


class Interval(NamedTuple):
    low: float
    high: float


def spread_evenly(count: int, most: int) -> Ints:
    """Return at most `most` of the numbers below `count`, in their order and evenly spread; all if they are fewer."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.int64)) if count else np.zeros(0, np.int64)


def midranks(values: ArrayLike) -> Floats:
    """Return (n,) ranks from 1; ties share the mean of their ranks."""
    array = np.asarray(values, dtype=np.float64)
    _, inverse, counts = np.unique(array, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return (last - (counts - 1) / 2.0)[inverse.ravel()]


def spearman(first: ArrayLike, second: ArrayLike) -> float:
    """Return the rank correlation rho in [-1, 1]: Pearson's correlation of midranks; NaN if one side is constant.

    Spearman (1904), "The proof and measurement of association between two things".
    """
    return correlation(midranks(first), midranks(second))


def correlation(first: Floats, second: Floats) -> float:
    """Return Pearson's correlation in [-1, 1]; NaN if one side is constant."""
    if len(first) < 2:
        return float("nan")
    a, b = first - first.mean(), second - second.mean()
    scale = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float(np.clip((a * b).sum() / scale, -1.0, 1.0)) if scale > 0.0 else float("nan")


def a12(first: ArrayLike, second: ArrayLike) -> float:
    """Return P(X > Y) + P(X = Y) / 2 for X of the first and Y of the second sample; NaN if one sample is empty.

    Vargha and Delaney (2000), "A critique and improvement of the CL common language effect size statistics", their
    equation 14 in rank form. 0.56, 0.64 and 0.71 are their small, medium and large.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not (len(a) and len(b)):
        return float("nan")
    rank_sum = midranks(np.concatenate([a, b]))[: len(a)].sum()
    return float((rank_sum / len(a) - (len(a) + 1) / 2.0) / len(b))


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return the adjusted p values of one family, in the same order; they control the family-wise error rate. NaN stays
    NaN.

    Holm (1979), "A simple sequentially rejective multiple test procedure".
    """
    p = np.asarray(p_values, dtype=np.float64)
    adjusted = np.full(len(p), np.nan)
    order = np.argsort(p, kind="stable")[: int((~np.isnan(p)).sum())]
    steps = p[order] * np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return tuple(adjusted.tolist())


def mann_whitney(first: ArrayLike, second: ArrayLike) -> float:
    """Return the two-sided p of the rank-sum test; values may be infinite, as only their order counts.

    Mann and Whitney (1947), "On a test of whether one of two random variables is stochastically larger than the other".
    Exact if both samples are small and have no ties, else by the normal approximation with corrections for ties and
    continuity. NaN if a sample is empty; 1 if all values are equal.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not (len(a) and len(b)):
        return float("nan")
    ranks = midranks(np.concatenate([a, b]))
    if np.ptp(ranks) == 0.0:
        return 1.0
    from scipy.stats import mannwhitneyu

    exact = max(len(a), len(b)) <= SMALL and len(np.unique(ranks)) == len(ranks)
    method = "exact" if exact else "asymptotic"
    return float(mannwhitneyu(ranks[: len(a)], ranks[len(a) :], alternative="two-sided", method=method).pvalue)


def a12_interval(
    first: ArrayLike, second: ArrayLike, level: float = 0.95, resamples: int = 2000, seed: int = 0
) -> Interval:
    """Return the percentile bootstrap interval of A12 of two independent samples, each resampled separately.

    Efron (1979), "Bootstrap methods: another look at the jackknife". All resamples are computed at once: each is a
    bilinear form of its counts per value.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not (len(a) and len(b)):
        return Interval(float("nan"), float("nan"))
    wins = (a[:, np.newaxis] > b) + 0.5 * (a[:, np.newaxis] == b)
    stream = Generator(Philox(seed))
    taken_a, taken_b = (_taken(stream.integers(len(x), size=(resamples, len(x))), len(x)) for x in (a, b))
    values = ((taken_a @ wins) * taken_b).sum(axis=1) / (len(a) * len(b))
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(values, [tail, 1.0 - tail])
    return Interval(float(low), float(high))


def newcombe_interval(value: float, first: int, second: int, level: float = 0.95) -> Interval:
    """Return the interval of an A12 `value` for samples of these sizes; its width is positive, even for a value of 1.

    Method 5 of Newcombe (2006), "Confidence intervals for an effect size measure based on the Mann-Whitney statistic",
    parts 1 and 2, Statistics in Medicine 25: its ends are the values whose own standard error (Hanley and McNeil, with
    the mean sample size) puts them as far from the estimate as the level requires. NaN if a sample is empty.
    """
    if not (first and second):
        return Interval(float("nan"), float("nan"))
    from scipy.special import ndtri

    far, middle = float(ndtri((1.0 + level) / 2.0)), (first + second) / 2.0 - 1.0

    def deviation(x: float) -> float:
        share = 1.0 + middle * (1.0 - x) / (2.0 - x) + middle * x / (1.0 + x)
        return far * math.sqrt(x * (1.0 - x) * share / (first * second))

    low = _border(lambda x: x + deviation(x) < value, 0.0, value)
    return Interval(low, _border(lambda x: x - deviation(x) <= value, value, 1.0))


def _border(below: Callable[[float], bool], low: float, high: float) -> float:
    """Return by bisection the point at which a condition that holds at `low` ceases to hold."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if below(middle) else (low, middle)
    return 0.5 * (low + high)


def a12_bounds(first: ArrayLike, second: ArrayLike) -> Interval:
    """Return the 95 % interval of A12: the union of the bootstrap interval and Newcombe's.

    If every run of one sample beats every run of the second, or all are equal, all resamples are equal, and the
    bootstrap interval is a single point for any number of runs.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    drawn, own = a12_interval(a, b), newcombe_interval(a12(a, b), len(a), len(b))
    return Interval(min(drawn.low, own.low), max(drawn.high, own.high))


def _taken(rows: Ints, size: int) -> Floats:
    """Return (resamples, size) the count of each value per resample, from row numbers (resamples, n) of its values."""
    resamples = len(rows)
    cells = rows + size * np.arange(resamples)[:, np.newaxis]
    return np.bincount(cells.ravel(), minlength=resamples * size).reshape(resamples, size).astype(np.float64)


def clopper_pearson(successes: int, trials: int, level: float = 0.95, unknown: int = 0) -> Interval:
    """Return the exact interval of a rate from *independent* trials; NaN without trials. `unknown`: number of
    additional trials with unknown outcome; the lower end takes them for failures, the upper end for successes.

    Clopper and Pearson (1934), "The use of confidence or fiducial limits illustrated in the case of the binomial".
    """
    every, most = trials + unknown, successes + unknown
    if not every:
        return Interval(float("nan"), float("nan"))
    from scipy.stats import beta

    tail = (1.0 - level) / 2.0
    low = beta.ppf(tail, successes, every - successes + 1) if successes else 0.0
    high = beta.ppf(1.0 - tail, most + 1, every - most) if most < every else 1.0
    return Interval(float(low), float(high))


class OddsRatio(NamedTuple):
    ratio: float
    """Ratio of the first sample's odds to the second's; infinite or NaN if a count is 0."""
    p: float
    """Two-sided, Fisher's exact test."""


def fisher(successes: tuple[int, int], trials: tuple[int, int]) -> OddsRatio:
    """Compare the rates of two samples of *independent* trials.

    Fisher (1922), "On the interpretation of chi-squared from contingency tables, and the calculation of P".
    """
    from scipy.stats import fisher_exact

    table = [[hits, count - hits] for hits, count in zip(successes, trials, strict=True)]
    (a, b), (c, d) = table
    ratio = a * d / (b * c) if b * c else float("inf") if a * d else float("nan")
    return OddsRatio(ratio, float(fisher_exact(table).pvalue))  # type: ignore[union-attr]


# -- paired trials -----------------------------------------------------------------------------------------------------


def mcnemar(first_only: int, second_only: int) -> float:
    """Return the two-sided p of equal rates in paired trials, from the pairs in which only one of both succeeds.

    McNemar (1947), "Note on the sampling error of the difference between correlated proportions or percentages"; exact:
    twice the smaller binomial tail at 1/2, and at most 1. Without such pairs: 1.
    """
    if not first_only + second_only:
        return 1.0
    from scipy.stats import binom

    tail = binom.cdf(min(first_only, second_only), first_only + second_only, 0.5)
    return min(1.0, 2.0 * float(tail))


def tango_interval(first_only: int, second_only: int, pairs: int, level: float = 0.95) -> Interval:
    """Return the score interval of the difference of two rates (first less second) in `pairs` paired trials; NaN
    without pairs.

    Tango (1998), "Equivalence test and confidence interval for the difference in proportions for the paired-sample
    design", Statistics in Medicine 17: the differences whose score statistic is at most the quantile of the normal
    distribution.
    """
    if not pairs:
        return Interval(float("nan"), float("nan"))
    from scipy.special import ndtri

    far, estimate = float(ndtri((1.0 + level) / 2.0)), (first_only - second_only) / pairs

    def score(difference: float) -> float:
        return _tango_score(difference, first_only, second_only, pairs)

    low = _border(lambda x: score(x) > far, -1.0, estimate)
    return Interval(low, _border(lambda x: score(x) >= -far, estimate, 1.0))


def _tango_score(difference: float, b: int, c: int, n: int) -> float:
    """Return (b - c - n d) / sqrt(n (2 q + d (1 - d))) for a difference d, where the maximum likelihood estimate q of
    the probability of c under d is the larger root of 2 n q^2 + (2 n d - b (1 + d) - c (1 - d)) q - c d (1 - d) = 0.
    """
    half, last = 0.5 * (2.0 * n * difference - b * (1.0 + difference) - c * (1.0 - difference)), c * difference
    last *= 1.0 - difference
    root = math.sqrt(max(0.0, half * half + 2.0 * n * last))
    q = (root - half) / (2.0 * n) if half <= 0.0 else last / (root + half)
    variance = n * (2.0 * q + difference * (1.0 - difference))
    distance = b - c - n * difference
    return distance / math.sqrt(variance) if variance > 0.0 else math.copysign(math.inf, distance) if distance else 0.0


def residual_bound(trials: int, level: float = 0.95) -> float:
    """Return the upper bound of a rate of which no event was found in independent trials: 1 - (1 - level)^(1 / n).

    It is the upper end of the one-sided interval of Clopper and Pearson (1934). Without trials: 1.
    """
    return -math.expm1(math.log1p(-level) / trials) if trials else 1.0
