"""A Gaussian process on what was run: what a point may come to, and how surely that is known.

Rasmussen and Williams (2006), "Gaussian Processes for Machine Learning": algorithm 2.1, equations 2.30 (likelihood) and
4.17 (Matern 5/2). Values have mean 0 and variance 1, `noise` of which no gene decides; `lengths` (d,) tell over how far
along each gene a model forgets.
"""

from typing import cast

import numpy as np

from engine.tables import Floats


def likelihood(points: Floats, values: Floats, lengths: Floats, noise: float) -> float:
    """The logarithm of the marginal one, but for a constant."""
    from scipy.linalg import solve_triangular

    factor = _factor(points, lengths, noise)
    white = solve_triangular(factor, values, lower=True)
    return float(-0.5 * white @ white - np.log(np.diag(factor)).sum())


def predicted(points: Floats, values: Floats, lengths: Floats, noise: float, queries: Floats) -> tuple[Floats, Floats]:
    """(m,) mean and standard deviation of the value at each query."""
    from scipy.linalg import solve_triangular

    factor = _factor(points, lengths, noise)
    across = solve_triangular(factor, _covariance(points, queries, lengths), lower=True)
    mean = across.T @ solve_triangular(factor, values, lower=True)
    return mean, np.sqrt(np.maximum(1.0 - (across**2).sum(axis=0), 1e-12))


def _factor(points: Floats, lengths: Floats, noise: float) -> Floats:
    return cast("Floats", np.linalg.cholesky(_covariance(points, points, lengths) + noise * np.eye(len(points))))


def _covariance(one: Floats, other: Floats, lengths: Floats) -> Floats:
    """(n, m) Matern 5/2."""
    from scipy.spatial.distance import cdist

    way = np.sqrt(5.0) * cdist(one / lengths, other / lengths)
    return (1.0 + way + way**2 / 3.0) * np.exp(-way)
