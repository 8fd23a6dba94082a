"""Confidence sequence of a rate: intervals that hold the rate at all looks together, whenever the trials stop.

An interval such as Clopper and Pearson's holds a rate at one number of trials that was chosen before. Someone who looks
again and again, and stops when the interval looks good, misses the rate more often than it says.

For a rate p, a bettor stakes on each next trial as if its rate were (c p + s) / (c + n), after s successes in n trials.
If p is the rate of every trial, given those before it, the bettor's capital

    M(p) = prod_{i < s} (c + i / p) * prod_{j < n - s} (c + j / (1 - p)) / prod_{k < n} (c + k)

is a non-negative martingale that begins at 1. It is also the mixture of the likelihood ratios against p by the beta
distribution with parameters c p and c (1 - p). By Ville's inequality it ever reaches 1 / alpha with a probability of at
most alpha, so that the rates with M(p) < 1 / alpha hold the true one at all looks. Each factor c + i / p is convex in
the logarithm over p, so these rates are an interval.

Ville (1939), "Étude critique de la notion de collectif"; Robbins (1970), "Statistical methods related to the law of the
iterated logarithm"; Waudby-Smith and Ramdas (2024), "Estimating means of bounded random variables by betting".
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from engine.errors import ArgumentError
from engine.search.statistics import Interval
from engine.tables import Bools, Floats

STRENGTH = 50.0
"""Default of c: the smaller, the narrower after few trials, the larger, the narrower after many. With 50 and alpha =
0.05, intervals after 100 to 100,000 trials are at most twice as wide as Clopper and Pearson's.
"""
HALVINGS = 1100
"""Limit of bisections: as many as halve 1 down to 0; they end as soon as no end moves."""


def confidence_sequence(
    successes: ArrayLike, trials: ArrayLike, alpha: float = 0.05, strength: float = STRENGTH
) -> tuple[Floats, Floats]:
    """Return (low, high) of the rate at each look; all looks hold it at once with a probability of at least 1 - alpha.

    successes, trials: counts so far, of any shape; both ends have that shape. Without trials: 0 and 1. `alpha` and
    `strength` are chosen before the first trial. Trials are independent, or have the same rate given those before.

    Raises:
        ArgumentError: alpha is not between 0 and 1, strength is not above 0, or successes are not between 0 and trials.
    """
    if not (0.0 < alpha < 1.0 and strength > 0.0):
        raise ArgumentError(f"alpha is {alpha}, strength is {strength}", "take 0 < alpha < 1 and strength > 0")
    s, n = np.broadcast_arrays(np.asarray(successes, dtype=np.float64), np.asarray(trials, dtype=np.float64))
    if not ((s >= 0.0) & (s <= n)).all():
        raise ArgumentError("there are fewer than 0 successes, or more than trials", "take 0 <= successes <= trials")
    limit = -math.log(alpha)
    share = s / np.maximum(n, 1.0)
    low = _end(np.zeros_like(share), share, s, n, strength, limit)
    high = _end(np.ones_like(share), share, s, n, strength, limit)
    return np.where(s > 0.0, low, 0.0), np.where(s < n, high, 1.0)


def _end(outside: Floats, inside: Floats, s: Floats, n: Floats, strength: float, limit: float) -> Floats:
    """Return the last rate from `inside` towards `outside` that the capital does not refute, by bisection."""
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        if ((middle == outside) | (middle == inside)).all():
            break
        refuted: Bools = _capital(middle, s, n, strength) >= limit
        outside, inside = np.where(refuted, middle, outside), np.where(refuted, inside, middle)
    return outside


def _capital(p: Floats, s: Floats, n: Floats, c: float) -> Floats:
    """Return log M(p) for 0 < p < 1."""
    from scipy.special import gammaln

    with np.errstate(divide="ignore", invalid="ignore"):
        won = np.where(s > 0.0, gammaln(c * p + s) - gammaln(c * p) - s * np.log(p), 0.0)
        lost = gammaln(c * (1.0 - p) + n - s) - gammaln(c * (1.0 - p)) - (n - s) * np.log1p(-p)
    return won + np.where(n > s, lost, 0.0) - gammaln(c + n) + gammaln(c)


def sequence_interval(successes: int, trials: int, level: float = 0.95, unknown: int = 0) -> Interval:
    """Return the confidence sequence at one look; NaN without trials. `unknown`: number of additional trials with
    unknown outcome; the lower end takes them for failures, the upper end for successes.
    """
    if not trials + unknown:
        return Interval(math.nan, math.nan)
    low, high = confidence_sequence([successes, successes + unknown], trials + unknown, 1.0 - level)
    return Interval(float(low[0]), float(high[1]))
