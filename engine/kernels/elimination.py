"""Gaussian elimination of symmetric matrices, in an order of additions that does not depend on the processor."""

import math

from engine.kernels.jit import kernel
from engine.tables import Floats


@kernel
def eliminate(rows: Floats) -> None:
    """Factor the symmetric matrix A in the first columns of (n, n + m) `rows`, in place: its upper triangle becomes U
    with U^T U = A, and the other columns B become X with U^T X = B.

    Unlike LAPACK, whose order of additions depends on the processor, each number is the result of one sequence of
    roundings; only adjacent numbers of a row are computed at the same time. The lower triangle is not changed. A matrix
    that is not positive definite gives NaN.
    """
    size, width = rows.shape
    for row in range(size):
        # Four rows at once, in the same order: half the time, because the row is written a quarter as often.
        for k in range(0, row - 3, 4):
            one, two, three, four = rows[k, row], rows[k + 1, row], rows[k + 2, row], rows[k + 3, row]
            for j in range(row, width):
                rest = (rows[row, j] - one * rows[k, j]) - two * rows[k + 1, j]
                rows[row, j] = (rest - three * rows[k + 2, j]) - four * rows[k + 3, j]
        for k in range(row // 4 * 4, row):
            factor = rows[k, row]
            for j in range(row, width):
                rows[row, j] -= factor * rows[k, j]
        root = math.sqrt(rows[row, row])
        for j in range(row, width):
            rows[row, j] /= root
