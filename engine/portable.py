"""Functions of arrays whose results do not depend on the code that numpy and BLAS choose by processor.

numpy and BLAS choose code by processor. With AVX-512 or AVX2, numpy rounds exp, log, powers, tan and inverse
trigonometric functions differently; sin, cos, hypot, sqrt, squares, sums, means and `einsum` (without `optimize`) do
not depend on it. Products of matrices (`@`, `dot`) and `numpy.linalg` do, as each BLAS kernel has its own order of
additions. A value that decides a result uses the functions of this module instead. They call `math`: bits are equal on
machines whose libm rounds alike.
"""

import math
from collections.abc import Callable

import numpy as np

from engine.tables import Floats


def _elementwise(function: Callable[..., float], like: np.ufunc) -> Callable[..., Floats]:
    """Return a function of `math` for arrays, with infinities and NaN as `like` has them where `math` raises."""

    def at(*numbers: float) -> float:
        try:
            return function(*numbers)
        except ValueError:
            return float(like(*numbers))
        except OverflowError:
            return math.inf * float(like(*numbers))

    quick, careful = np.frompyfunc(function, like.nin, 1), np.frompyfunc(at, like.nin, 1)

    def of_arrays(*arrays: Floats | float) -> Floats:
        try:
            values = quick(*arrays)
        except (ValueError, OverflowError):
            values = careful(*arrays)
        return np.asarray(values, dtype=np.float64)

    return of_arrays


exp = _elementwise(math.exp, np.exp)
log = _elementwise(math.log, np.log)
log1p = _elementwise(math.log1p, np.log1p)
power = _elementwise(math.pow, np.power)
tan = _elementwise(math.tan, np.tan)
arcsin = _elementwise(math.asin, np.arcsin)
arctan = _elementwise(math.atan, np.arctan)
arctan2 = _elementwise(math.atan2, np.arctan2)


def product(first: Floats, second: Floats) -> Floats:
    """Return the matrix product of (..., n, k) and (..., k, m)."""
    return np.asarray(np.einsum("...ij,...jk->...ik", first, second), dtype=np.float64)


def cholesky(matrices: Floats) -> Floats:
    """Return the lower triangular factors of positive definite matrices (..., n, n)."""
    lower = np.zeros(matrices.shape)
    for column in range(matrices.shape[-1]):
        known = lower[..., column:, :column]
        rest = matrices[..., column:, column] - np.einsum("...ij,...j->...i", known, known[..., 0, :])
        lower[..., column:, column] = rest / np.sqrt(rest[..., :1])
    return lower


def solved(lower: Floats, right: Floats) -> Floats:
    """Return the (n, m) solution of a system with a lower triangular matrix (n, n)."""
    solution = np.zeros(right.shape)
    for row in range(len(lower)):
        rest = right[row] - np.einsum("i,ij->j", lower[row, :row], solution[:row])
        solution[row] = rest / lower[row, row]
    return solution
