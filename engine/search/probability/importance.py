"""Importance sampling for rare events: sample near failures, and weight each run by its likelihood under the file.

Genes are standard normal numbers through their quantile functions, so that the file's own density f is the standard
normal one. First, several independent climbs of `levels.py` locate the failures: some under f, more of them wide, and
one for each partner and side on which it is met, led by the distance to that partner. One mixture of normal densities
is fitted to the failures of all climbs by expectation and maximisation, which minimises the cross-entropy from f given
a failure: Rubinstein and Kroese (2004), "The cross-entropy method"; with mixtures, for several modes, Kurtz and Song
(2013), "Cross-entropy-based adaptive importance sampling using Gaussian mixture".

The estimate uses new runs only, drawn from a density q that contains f itself with a share of a tenth, so that no
weight w = f / q is above ten: Hesterberg (1995), "Weighted average importance sampling and defensive mixture
distributions". It is the mean of w times failure over these n runs, divided by the share of draws that give a valid
run; its error is that of a mean of independent numbers (Owen 2013, "Monte Carlo theory, methods and examples", chapter
9), and the interval that of its logarithm, by the delta method.

No variance shows a mode of failures that no climb came to. Two numbers show whether the interval can be trusted. The
effective sample size (sum w)^2 / sum w^2 of the failures is to be large (Kong 1992, "A note on importance sampling
using standardized weights"). And each component of the mixture belongs to climbs in proportion to their failures in it:
without the draws and the share of any one climb, the estimate is to stay the same within a factor of 1.5. A mode that
only one climb came to is a sign of others that none came to. Otherwise, or if the estimate is far from that of the
wide climbs, a reason replaces the interval.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from engine.assessment import Evaluate
from engine.outcomes import Assessment
from engine.portable import cholesky, exp, log, product, solved
from engine.program import ParamSpace
from engine.search.probability.estimates import (
    MOST_DRIVEN,
    NOT_KNOWN,
    Judge,
    Probability,
    Withheld,
    around,
    checked_samples,
    disagree,
)
from engine.search.probability.levels import (
    DISTANCE,
    Ascent,
    Chains,
    Level,
    Score,
    ascend,
    joined,
    nearness,
    width_of,
)
from engine.search.statistics import Interval
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

LEAST = 1000
"""Minimum number of simulations."""
CLIMBS = (False, False, True, True, True, True)
"""Climbs of an estimate: True for a wide one."""
LEAST_CLIMBS = 4
"""Number of these that come to failures, below which no interval is given."""
LEVELS = 50
"""Number of levels that would use all simulations; it determines the size of a level."""
SMALLEST = 50
"""Minimum size of a level."""
LEAST_EFFECTIVE, LEAST_PER_DIMENSION = 100.0, 4.0
"""Effective sample size of the failures below which no interval is given: in all, and per dimension. In many dimensions
few weights are large, so that the size is estimated too large and the error too small.
"""
FARTHEST = 5.0
"""Largest factor, either way, between the estimate and that of the wide climbs."""
DEFENCE = 0.1
"""Share of the file's own distribution in the sampling density."""
SPREAD = ((0.7, 0.2), (0.2, 1.0))
"""Shares of the fitted mixture in the sampling density, and of a unit covariance in it. Beyond a border failures
decrease exponentially, slower than a normal density as narrow as the failures: without the second part, failures far
beyond the border would rarely be drawn and would have large weights.
"""
LAST_SHARE = 2
"""Reciprocal of the minimum share of simulations that is left for the estimate."""
BLOCK = 4096
"""Draws that are simulated together."""
RUN = 100
"""Number of the first run in the stream keys: no repetition of subset simulation has it."""
VISIBLE = 0.1
"""Least share of wide draws in which a partner is met on a side that gets a climb of its own."""
MOST_COMPONENTS = 8
"""Maximum number of components of a fitted mixture."""
TINY = 1e-300
ROUNDS = 12
"""Rounds of expectation and maximisation."""
CANDIDATES = 8
"""Candidates for each initial centre of a fit."""
FAITH = 5.0
"""Weight of a unit covariance in each component's, in points per dimension; it regularizes fits to few points."""

# -- mixtures of normal densities in the space in which a file's own distribution is the standard normal one -----------


@dataclass(frozen=True)
class Mixture:
    """Mixture of `k` normal densities in `d` dimensions."""

    shares: Floats
    """(k,)"""
    means: Floats
    """(k, d)"""
    factors: Floats
    """(k, d, d): lower triangular, covariances are their squares."""

    def draw(self, numbers: Generator, count: int) -> Floats:
        """Return (count, d) points in random order, with the numbers per component proportional to the shares."""
        return self.at(numbers, apportioned(numbers, self.shares, count))

    def at(self, numbers: Generator, which: Ints) -> Floats:
        """Return (n, d) points, each drawn from the component with this number."""
        noise = numbers.standard_normal((len(which), self.means.shape[1]))
        return self.means[which] + np.einsum("nij,nj->ni", self.factors[which], noise)

    def logarithms(self, points: Floats) -> Floats:
        """Return (k, n) logarithms of share times density, over the standard normal density."""
        own = 0.5 * np.einsum("ni,ni->n", points, points)
        rows = np.empty((len(self.shares), len(points)))
        for row, share in enumerate(self.shares.tolist()):
            inverse = solved(self.factors[row], np.eye(points.shape[1]))
            scaled = product(points - self.means[row], inverse.T)
            scale = math.log(share) + float(log(np.diagonal(inverse)).sum())
            rows[row] = own - 0.5 * np.einsum("ni,ni->n", scaled, scaled) + scale
        return rows

    def ratios(self, points: Floats) -> Floats:
        """Return (n,) the density over the standard normal density."""
        return exp(np.logaddexp.reduce(self.logarithms(points), axis=0))


def apportioned(numbers: Generator, shares: Floats, count: int) -> Ints:
    """Return (count,) numbers of parts in random order, each as often as its share says."""
    ends: Ints = np.rint(np.cumsum(shares) / shares.sum() * count).astype(np.int64)
    return np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))[numbers.permutation(count)]


def nominal(dimensions: int, share: float = 1.0) -> Mixture:
    """Return the standard normal density."""
    return Mixture(np.array([share]), np.zeros((1, dimensions)), np.eye(dimensions)[np.newaxis])


def together(*parts: tuple[float, Mixture]) -> Mixture:
    """Return a mixture of mixtures by their shares."""
    return Mixture(
        np.concatenate([share * part.shares for share, part in parts]),
        np.concatenate([part.means for _, part in parts]),
        np.concatenate([part.factors for _, part in parts]),
    )


def fitted(points: Floats, numbers: Generator) -> Mixture:
    """Return the mixture with few components that fits (n, d) points best, by Schwarz's criterion.

    Dempster, Laird and Rubin (1977), "Maximum likelihood from incomplete data via the EM algorithm"; Schwarz (1978),
    "Estimating the dimension of a model", which here counts means and shares as parameters: `FAITH` regularizes the
    covariances.
    """
    distinct = np.unique(points, axis=0)
    fits = [_fitted(points, count, numbers) for count in range(1, min(MOST_COMPONENTS, len(distinct)) + 1)]
    penalty = 0.5 * (points.shape[1] + 1) * math.log(max(2, len(distinct)))
    repeats = len(distinct) / len(points)
    scores = [repeats * float(log(fit.ratios(points)).sum()) - penalty * len(fit.shares) for fit in fits]
    return fits[int(np.argmax(scores))]


def widened(fit: Mixture, share: float) -> Mixture:
    """Return the mixture with this share of a unit covariance in each component's covariance."""
    unit = np.eye(fit.means.shape[1])
    covariances = product(fit.factors, fit.factors.transpose(0, 2, 1))
    return Mixture(fit.shares, fit.means, cholesky((1.0 - share) * covariances + share * unit))


def _fitted(points: Floats, count: int, numbers: Generator) -> Mixture:
    owners = np.argmin(_squares(points, _centres(points, count, numbers)), axis=0)
    parts = (owners == np.arange(count)[:, np.newaxis]).astype(np.float64)
    mixture = _maximised(points, parts)
    for _ in range(ROUNDS if count > 1 else 0):
        logarithms = mixture.logarithms(points)
        mixture = _maximised(points, exp(logarithms - np.logaddexp.reduce(logarithms, axis=0)))
    return mixture


def _maximised(points: Floats, parts: Floats) -> Mixture:
    """Return the mixture for (k, n) responsibilities of components for points; a component without any is dropped."""
    sizes = parts.sum(axis=1)
    parts, sizes = parts[sizes > 1.0], sizes[sizes > 1.0]
    means = product(parts, points) / sizes[:, np.newaxis]
    dimensions = points.shape[1]
    faith = FAITH * dimensions
    factors = np.empty((len(sizes), dimensions, dimensions))
    for row, (part, size, mean) in enumerate(zip(parts, sizes, means, strict=True)):
        away = points - mean
        scatter = product((part[:, np.newaxis] * away).T, away) + faith * np.eye(dimensions)
        factors[row] = cholesky(scatter / (size + faith))
    return Mixture(sizes / sizes.sum(), means, factors)


def _centres(points: Floats, count: int, numbers: Generator) -> Floats:
    """Return points that are far apart: each is the best of some candidates, drawn by squared distance to the earlier
    ones.

    Arthur and Vassilvitskii (2007), "k-means++: the advantages of careful seeding", in its greedy form.
    """
    chosen = points[numbers.integers(len(points), size=1)]
    while len(chosen) < count:
        away = _squares(points, chosen).min(axis=0)
        total = float(away.sum())
        drawn = numbers.choice(len(points), CANDIDATES, p=away / total) if total > 0.0 else np.zeros(1, dtype=np.int64)
        left = np.minimum(_squares(points, points[drawn]), away).sum(axis=1)
        chosen = np.concatenate([chosen, points[drawn[[int(np.argmin(left))]]]])
    return chosen


def _squares(points: Floats, centres: Floats) -> Floats:
    """Return (k, n) squared distances."""
    return np.stack([((points - centre) ** 2).sum(axis=1) for centre in centres])


# -- where failures are ------------------------------------------------------------------------------------------------


class _Located(NamedTuple):
    """Failures of all climbs, and the density that draws near them."""

    density: Mixture
    """f itself first."""
    owners: Floats
    """(climbs, k) Share of each climb in each component of `density`; f belongs to none."""


def _located(ascents: Sequence[Ascent], numbers: Generator) -> _Located:
    """Return the sampling density, a mixture of f and the density fitted to the failures of all climbs."""
    populations = [each.failures.points for each in ascents if each.failures is not None]
    points = np.concatenate(populations)
    fit = fitted(points, numbers)
    parts = [(share, widened(fit, wider)) for share, wider in SPREAD]
    logarithms = fit.logarithms(points)
    owned = exp(logarithms - np.logaddexp.reduce(logarithms, axis=0))
    ends = np.cumsum([len(each) for each in populations])[:-1]
    sums = np.array([part.sum(axis=1) for part in np.split(owned, ends, axis=1)])
    shares = sums / np.maximum(sums.sum(axis=0), TINY)
    none = np.zeros((len(populations), 1))
    density = together((DEFENCE, nominal(points.shape[1])), *parts)
    return _Located(density, np.concatenate([none, *[shares] * len(SPREAD)], axis=1))


def _seen(survey: Assessment, score: Score, targets: Sequence[Score]) -> list[Score]:
    """Return the targets that a share of the surveyed runs sees, each of which orders these runs in another way."""
    rows = survey.verdict == Verdict.VALID
    orders = [nearness(score, survey)[rows]]
    chosen: list[Score] = []
    for target in targets:
        order = nearness(target, survey)[rows]
        is_new = not any(np.array_equal(order, other) for other in orders)
        if is_new and len(order) and np.isfinite(order).mean() >= VISIBLE:
            orders.append(order)
            chosen.append(target)
    return chosen


# -- the estimate ------------------------------------------------------------------------------------------------------


class _Runs(NamedTuple):
    """Independent runs, rows aligned, with their weights."""

    weights: Floats
    failed: Bools
    scenes: Level
    without: Floats
    """(climbs, n) Weights without one climb; 0 for a run that this climb led to."""
    left: Ints
    """(climbs,) Runs that this climb did not lead to."""


def importance_sampling(
    space: ParamSpace,
    evaluate: Evaluate,
    samples: int,
    seed: int = 0,
    level: float = 0.95,
    judge: Judge | None = None,
    score: Score = DISTANCE,
    targets: Sequence[Score] = (),
) -> Probability:
    """Return the estimate of importance sampling with about `samples` simulations in all, up to twice as many with many
    targets: scores each of which leads one more climb to a part of the failures.

    Raises:
        ValueError: fewer than 1,000 samples.
    """
    checked_samples("importance sampling", samples, LEAST)
    size, wide = max(samples // LEVELS, SMALLEST), width_of(len(space))
    climbers = [
        Chains(space, evaluate, score, seed, RUN + number, judge, wide if is_wide else 1.0)
        for number, is_wide in enumerate(CLIMBS)
    ]
    ascents = [ascend(chains, size) for chains in climbers]
    reason = _reason(ascents)
    if targets and not reason:
        surveyor = Chains(space, evaluate, score, seed, RUN + len(climbers), width=wide)
        parts = _seen(surveyor.survey(size), score, targets)
        smaller = max(SMALLEST, min(size, size * len(CLIMBS) // max(1, len(parts))))
        own = [
            Chains(space, evaluate, part, seed, RUN + len(climbers) + 1 + number, width=wide)
            for number, part in enumerate(parts)
        ]
        ascents += [ascend(chains, smaller) for chains in own]
        climbers += [surveyor, *own]
    chains = Chains(space, evaluate, score, seed, RUN + len(climbers), judge)
    for each in climbers:
        chains.used(each)
    runs = None if reason else _drawn(chains, _located(ascents, chains.numbers()), samples)
    weights = np.zeros(0) if runs is None else runs.weights * runs.failed
    value, interval = _estimate(weights, chains, level)
    rough = float(np.mean([each.joint for each, is_wide in zip(ascents, CLIMBS, strict=False) if is_wide]))
    rough *= chains.drawn / max(1, chains.filled)
    withheld = reason if runs is None else _withheld(runs, value, rough, space)
    if withheld:
        value, interval = 0.0 if withheld == Withheld.UNREACHED else math.nan, NOT_KNOWN
    avoidable, avoidable_interval = _avoidable(runs, chains, level) if runs and not withheld else (math.nan, NOT_KNOWN)
    return Probability(
        method="importance",
        value=value,
        interval=interval,
        level=level,
        simulations=chains.count.simulations,
        valid=chains.count.valid,
        collisions=chains.count.collisions,
        valid_share=chains.filled / chains.drawn,
        aborted=chains.count.aborted,
        errors=chains.count.errors,
        lost=chains.count.lost,
        levels=ascents[0].found.thresholds,
        avoidable=avoidable,
        avoidable_interval=avoidable_interval,
        driven=chains.driven,
        score=score.name,
        withheld=withheld,
        tied=max(each.found.tied for each in ascents[: len(CLIMBS)]),
        reached=_reached(ascents),
        repetitions=len(CLIMBS),
        effective=effective_size(weights),
    )


def effective_size(weights: Floats) -> float:
    """Return Kong's effective sample size: the number of runs of equal weight with the same error."""
    squares = float((weights * weights).sum())
    return float(weights.sum()) ** 2 / squares if squares > 0.0 else 0.0


def _reached(ascents: Sequence[Ascent]) -> int:
    """Return how many climbs to all failures came to one."""
    return sum(each.failures is not None for each in ascents[: len(CLIMBS)])


def _reason(ascents: Sequence[Ascent]) -> Withheld:
    """Return the reason why the climbs cannot be used, or `NOTHING`.

    Plateaus of wide climbs do not count: they may lie where hardly a run of the file is.
    """
    reasons = [each.found.withheld for each, is_wide in zip(ascents, CLIMBS, strict=True) if not is_wide]
    for reason in (Withheld.INVALID, Withheld.PLATEAU):
        if reason in reasons:
            return reason
    reached = _reached(ascents)
    return Withheld.NOTHING if reached >= LEAST_CLIMBS else Withheld.PARTLY if reached else Withheld.UNREACHED


def _drawn(chains: Chains, located: _Located, samples: int) -> _Runs:
    """Return the runs of the estimate: the simulations that are left, but at least half of all."""
    numbers, density, owners = chains.numbers(), located.density, located.owners
    which = apportioned(numbers, density.shares, max(samples - chains.count.simulations, samples // LAST_SHARE))
    points = density.at(numbers, which)
    climb_of = np.full(len(which), -1)
    for part in range(1, len(density.shares)):
        rows = np.flatnonzero(which == part)
        climb_of[rows] = apportioned(numbers, owners[:, part], len(rows))
    left = density.shares * (1.0 - owners)
    left /= left.sum(axis=1, keepdims=True)
    led = climb_of == np.arange(len(owners))[:, np.newaxis]
    parts: list[tuple[Floats, Bools, Level, Floats]] = []
    for start in range(0, len(points), BLOCK):
        block = points[start : start + BLOCK]
        scenes, valid = chains.simulate(block, chains.keys(len(block), start))
        logarithms = density.logarithms(block)
        largest = logarithms.max(axis=0)
        ratios, scale = exp(logarithms - largest), exp(-largest)
        without = scale / np.maximum(product(left / density.shares, ratios), TINY)
        parts.append((scale / ratios.sum(axis=0), valid & scenes.failed, scenes, without))
    weights, failed, scenes, without = zip(*parts, strict=True)
    return _Runs(
        np.concatenate(weights),
        np.concatenate(failed),
        joined(list(scenes)),
        np.where(led, 0.0, np.concatenate(without, axis=1)),
        (~led).sum(axis=1),
    )


def _are_few(weights: Floats, space: ParamSpace) -> bool:
    """Return True if the effective sample size of these weights is too small for an interval."""
    return effective_size(weights) < max(LEAST_EFFECTIVE, LEAST_PER_DIMENSION * len(space))


def _withheld(runs: _Runs, value: float, rough: float, space: ParamSpace) -> Withheld:
    """Return the reason not to trust the estimate, or `NOTHING`."""
    weights = runs.weights * runs.failed
    if _are_few(weights, space):
        return Withheld.FEW
    failed = runs.failed.astype(np.float64)[:, np.newaxis]
    without = product(runs.without, failed)[:, 0] / runs.left
    if disagree(np.append(without, weights.mean())):
        return Withheld.MODES
    return Withheld.NOTHING if rough / FARTHEST <= value <= rough * FARTHEST else Withheld.APART


def _estimate(weights: Floats, chains: Chains, level: float) -> tuple[float, Interval]:
    """Return the mean weight of failures, given a valid run, and its interval."""
    from scipy.special import ndtri

    mean = float(weights.mean()) if len(weights) else 0.0
    if not mean > 0.0:
        return 0.0, NOT_KNOWN
    share = chains.filled / chains.drawn
    relative = float(weights.var(ddof=1)) / (len(weights) * mean * mean) + (1.0 - share) / chains.filled
    value = min(1.0, mean / share)  # weights are random: their mean may exceed the share
    return value, around(value, float(ndtri((1.0 + level) / 2.0)) * math.sqrt(relative))


def _avoidable(runs: _Runs, chains: Chains, level: float) -> tuple[float, Interval]:
    """Return the estimate and interval of avoidable failures, from the first runs, up to `MOST_DRIVEN` failures."""
    if chains.judge is None:
        return math.nan, NOT_KNOWN
    rows = np.flatnonzero(runs.failed)
    count = int(rows[MOST_DRIVEN]) if len(rows) > MOST_DRIVEN else len(runs.weights)
    rows = rows[rows < count]
    weights = np.zeros(count)
    weights[rows] = runs.weights[rows] * chains.avoided(runs.scenes.rows(rows))
    value, interval = _estimate(weights, chains, level)
    return value, NOT_KNOWN if _are_few(weights, chains.space) else interval
