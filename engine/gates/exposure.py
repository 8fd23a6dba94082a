"""Failure rate under an exposure: the cells of a domain weighted by how often they occur.

Draws within a cell are independent. The rate under the exposure is the sum of weight times rate over the cells
(post-stratification: Cochran (1977), "Sampling techniques", 3rd edition, section 5A.9). The effective sample size is
that of Kish (1965), "Survey sampling": the square of the sum of the weights of all draws by the sum of their squares.
"""

import math
from collections.abc import Sequence

from engine.frozen import frozen
from engine.search.statistics import clopper_pearson

LEVEL = 0.95


@frozen
class CellCount:
    """Independent draws in one cell."""

    draws: int
    failures: int
    lost: int = 0
    """Further draws with unknown outcome that may lie in it: the bound takes them for failures."""


@frozen
class ExposedRate:
    """Rate under an exposure."""

    rate: float
    """NaN if cells with a weight have no draw."""
    high: float
    """Upper bound at `LEVEL`, one-sided; a cell with a weight and without a draw counts as failing always."""
    effective: float
    """Effective sample size; NaN as `rate`."""
    empty: float
    """Share of the weights that lies in cells without a draw."""


def upper_bound(failures: int, draws: int, level: float = LEVEL, unknown: int = 0) -> float:
    """Return the exact one-sided upper bound of a rate, of Clopper and Pearson; 1 without draws.

    `unknown`: number of further draws with unknown outcome, which count as failures.
    """
    return clopper_pearson(failures, draws, 2.0 * level - 1.0, unknown).high if draws + unknown else 1.0


def exposed_rate(cells: Sequence[CellCount], weights: Sequence[float]) -> ExposedRate:
    """Return the rate of cells under weights >= 0 of the same length, whose sum is above 0.

    The upper bounds of all m cells with a weight hold together, each at 1 - (1 - LEVEL) / m (Bonferroni), so that
    their weighted sum bounds the rate.
    """
    total = math.fsum(weights)
    used = [(cell, weight / total) for cell, weight in zip(cells, weights, strict=True) if weight > 0.0]
    level = 1.0 - (1.0 - LEVEL) / len(used)
    high = math.fsum(share * upper_bound(cell.failures, cell.draws, level, cell.lost) for cell, share in used)
    empty = math.fsum(share for cell, share in used if not cell.draws)
    if empty > 0.0:
        return ExposedRate(math.nan, min(1.0, high), math.nan, empty)
    rate = math.fsum(share * cell.failures / cell.draws for cell, share in used)
    effective = 1.0 / math.fsum(share * share / cell.draws for cell, share in used)
    return ExposedRate(rate, min(1.0, high), effective, 0.0)
