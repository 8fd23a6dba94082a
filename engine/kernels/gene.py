"""Gene values from uniform numbers."""

import math

from engine.kernels.jit import kernel
from engine.kernels.normal import normal_cdf, normal_quantile
from engine.tables import Floats


@kernel
def truncated_normal(u: float, low: float, high: float, mean: float, deviation: float) -> float:
    """The value below which a normal variable confined to [low, high] lies with probability u."""
    lower, upper = (low - mean) / deviation, (high - mean) / deviation
    # Work in the lower tail, where probabilities near 0 keep all their digits.
    if lower > 0.0:
        return _within(mean - deviation * _between(1.0 - u, -upper, -lower), low, high)
    return _within(mean + deviation * _between(u, lower, upper), low, high)


@kernel
def _between(u: float, lower: float, upper: float) -> float:
    start = normal_cdf(lower)
    return normal_quantile(start + u * (normal_cdf(upper) - start))


@kernel
def _within(value: float, low: float, high: float) -> float:
    return math.nan if math.isnan(value) else min(max(value, low), high)


@kernel
def truncated_normals(uniforms: Floats, low: float, high: float, mean: float, deviation: float, out: Floats) -> None:
    """`truncated_normal` for each of `uniforms` (n,)."""
    for row in range(len(uniforms)):
        out[row] = truncated_normal(uniforms[row], low, high, mean, deviation)
