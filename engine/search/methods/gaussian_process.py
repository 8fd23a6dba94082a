"""A Gaussian process on the runs of a search: mean and standard deviation of the value at a point.

Rasmussen and Williams (2006), "Gaussian Processes for Machine Learning": algorithm 2.1, equations 2.30 (likelihood) and
4.17 (Matern 5/2). Values have mean 0 and variance 1, of which the share `noise` does not depend on genes; `lengths`
(d,) are the correlation lengths along each gene.
"""

from math import sqrt
from typing import cast

import numpy as np

from engine.kernels.elimination import eliminate
from engine.portable import log, product
from engine.tables import Floats


def likelihood(points: Floats, values: Floats, lengths: Floats, noise: float) -> float:
    """Return the logarithm of the marginal likelihood, up to a constant."""
    upper, white = _factored(points, lengths, noise, values[:, np.newaxis])
    return float(-0.5 * (white**2).sum() - log(np.diag(upper)).sum())


def predicted(points: Floats, values: Floats, lengths: Floats, noise: float, queries: Floats) -> tuple[Floats, Floats]:
    """Return (m,) mean and standard deviation of the value at each query."""
    from scipy.spatial.distance import cdist

    columns = np.column_stack([values, _covariance(cdist(points / lengths, queries / lengths))])
    _, white = _factored(points, lengths, noise, columns)
    across = white[:, 1:]
    mean = product(white[:, :1].T, across)[0]
    return mean, np.sqrt(np.maximum(1.0 - (across**2).sum(axis=0), 1e-12))


def _factored(points: Floats, lengths: Floats, noise: float, columns: Floats) -> tuple[Floats, Floats]:
    """Return the upper Cholesky factor U (n, n) of the covariance of points, and X (n, m) with U^T X = columns."""
    from scipy.spatial.distance import pdist, squareform

    size = len(points)
    pairs = squareform(_covariance(pdist(points / lengths)))
    rows = np.column_stack([pairs + (1.0 + noise) * np.eye(size), columns])
    eliminate(rows)
    return rows[:, :size], rows[:, size:]


def _covariance(apart: Floats) -> Floats:
    """Return the Matern 5/2 covariance at distances of any shape."""
    from scipy.special import inv_boxcox  # inv_boxcox of 0 is the exponential, in a tenth of the time of `portable.exp`

    way = sqrt(5.0) * apart
    return (1.0 + way + way**2 / 3.0) * cast("Floats", inv_boxcox(-way, 0.0))
