"""Mixtures of normal densities in the space in which a file's own distribution is the standard normal one."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from engine.tables import Floats, Ints

MOST = 4
"""Components that a fit may have."""
ROUNDS = 12
"""Of expectation and maximisation."""
CANDIDATES = 8
"""For each centre from which a fit starts."""
FAITH = 5.0
"""What a unit covariance weighs in each component's, in points a dimension: few points say little of many numbers."""


@dataclass(frozen=True)
class Mixture:
    """`k` components in `d` dimensions."""

    shares: Floats
    """(k,)"""
    means: Floats
    """(k, d)"""
    factors: Floats
    """(k, d, d): lower triangular, covariances are their squares."""

    def draw(self, numbers: Generator, count: int) -> Floats:
        """(count, d) points, as many of each component as its share says, in random order."""
        ends: Ints = np.rint(np.cumsum(self.shares) / self.shares.sum() * count).astype(np.int64)
        which = np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))[numbers.permutation(count)]
        noise = numbers.standard_normal((count, self.means.shape[1]))
        return self.means[which] + np.einsum("nij,nj->ni", self.factors[which], noise)

    def logarithms(self, points: Floats) -> Floats:
        """(k, n) of share times density, over the standard normal density."""
        own = 0.5 * np.einsum("ni,ni->n", points, points)
        rows = np.empty((len(self.shares), len(points)))
        for row, share in enumerate(self.shares.tolist()):
            inverse: Floats = np.linalg.inv(np.asarray(self.factors[row], dtype=np.float64)).astype(np.float64)
            scaled: Floats = (points - self.means[row]) @ inverse.T
            scale = math.log(share) + float(np.log(np.diagonal(inverse)).sum())
            rows[row] = own - 0.5 * np.einsum("ni,ni->n", scaled, scaled) + scale
        return rows

    def ratios(self, points: Floats) -> Floats:
        """(n,) density over the standard normal density."""
        return np.exp(np.logaddexp.reduce(self.logarithms(points), axis=0))


def nominal(dimensions: int, share: float = 1.0) -> Mixture:
    """The standard normal density."""
    return Mixture(np.array([share]), np.zeros((1, dimensions)), np.eye(dimensions)[np.newaxis])


def together(*parts: tuple[float, Mixture]) -> Mixture:
    """A mixture of mixtures by their shares."""
    return Mixture(
        np.concatenate([share * part.shares for share, part in parts]),
        np.concatenate([part.means for _, part in parts]),
        np.concatenate([part.factors for _, part in parts]),
    )


def fitted(points: Floats, numbers: Generator) -> Mixture:
    """The mixture of few components under which (n, d) points are likely, by Schwarz's criterion.

    Dempster, Laird and Rubin (1977), "Maximum likelihood from incomplete data via the EM algorithm"; Schwarz (1978),
    "Estimating the dimension of a model", with the numbers of means and shares: covariances are held by `FAITH`.
    """
    distinct = np.unique(points, axis=0)
    fits = [_fitted(points, count, numbers) for count in range(1, min(MOST, len(distinct)) + 1)]
    penalty = 0.5 * (points.shape[1] + 1) * math.log(max(2, len(distinct)))
    repeats = len(distinct) / len(points)
    scores = [repeats * float(np.log(fit.ratios(points)).sum()) - penalty * len(fit.shares) for fit in fits]
    return fits[int(np.argmax(scores))]


def widened(fit: Mixture, share: float) -> Mixture:
    """With this share of a unit covariance in each component's."""
    unit = np.eye(fit.means.shape[1])
    covariances = fit.factors @ fit.factors.transpose(0, 2, 1)
    factors: Floats = np.linalg.cholesky((1.0 - share) * covariances + share * unit).astype(np.float64)
    return Mixture(fit.shares, fit.means, factors)


def _fitted(points: Floats, count: int, numbers: Generator) -> Mixture:
    owners = np.argmin(_squares(points, _centres(points, count, numbers)), axis=0)
    parts = (owners == np.arange(count)[:, np.newaxis]).astype(np.float64)
    mixture = _maximised(points, parts)
    for _ in range(ROUNDS if count > 1 else 0):
        logarithms = mixture.logarithms(points)
        mixture = _maximised(points, np.exp(logarithms - np.logaddexp.reduce(logarithms, axis=0)))
    return mixture


def _maximised(points: Floats, parts: Floats) -> Mixture:
    """Of (k, n) parts that components have in points; a component without any is left out."""
    sizes = parts.sum(axis=1)
    parts, sizes = parts[sizes > 1.0], sizes[sizes > 1.0]
    means = parts @ points / sizes[:, np.newaxis]
    dimensions = points.shape[1]
    faith = FAITH * dimensions
    factors = np.empty((len(sizes), dimensions, dimensions))
    for row, (part, size, mean) in enumerate(zip(parts, sizes, means, strict=True)):
        away = points - mean
        scatter = (part[:, np.newaxis] * away).T @ away + faith * np.eye(dimensions)
        factors[row] = np.linalg.cholesky(scatter / (size + faith))
    return Mixture(sizes / sizes.sum(), means, factors)


def _centres(points: Floats, count: int, numbers: Generator) -> Floats:
    """Points far apart: each next one is the best of some that are drawn by their squared distance from those before.

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
    """(k, n) squared distances."""
    return np.stack([((points - centre) ** 2).sum(axis=1) for centre in centres])
