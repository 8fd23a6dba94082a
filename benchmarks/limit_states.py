"""Do intervals of rare events hold the truth on limit states of the literature, with several modes and dimensions?

    python -m benchmarks.limit_states [--repetitions 20] [--samples 10000] [--only ROW] [--method NAME] [--jobs 1]
        [--json]

Each row is a function of standard normal numbers; a failure is 0 or less. Its probability is computed from a closed
form, or by an integral over one number after the others are integrated exactly. Asked for: at least 93.5 % of the
intervals given hold the truth, and at most 1 % lie apart from the interval of ten million plain draws.
"""

import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri
from scipy.stats import binom, chi2

from benchmarks.coverage import tabulated
from engine.search.probability.functions import probability
from engine.search.statistics import clopper_pearson
from engine.tables import Floats

LEAST_COVERAGE, MOST_APART = 0.935, 0.01
PLAIN = 10**7
"""Draws of plain Monte Carlo that an interval is compared with."""
ROOT2 = math.sqrt(2.0)


@dataclass(frozen=True)
class LimitState:
    """A limit state of known probability."""

    name: str
    dimensions: int
    truth: Callable[[], float]
    score: Callable[[Floats], Floats]


# -- limit states ------------------------------------------------------------------------------------------------------


def _linear(dimensions: int, chance: float) -> LimitState:
    far = -float(ndtri(chance))
    name = f"linear, d = {dimensions}, {chance:.0e}"
    return LimitState(name, dimensions, lambda: chance, lambda u: far - u.sum(axis=1) / math.sqrt(dimensions))


def _largest(dimensions: int, far: float) -> LimitState:
    """2 d modes."""
    truth = -math.expm1(dimensions * math.log1p(-2.0 * float(ndtr(-far))))
    return LimitState(f"{2 * dimensions} modes", dimensions, lambda: truth, lambda u: far - np.abs(u).max(axis=1))


def _sphere(dimensions: int, chance: float) -> LimitState:
    radius = math.sqrt(float(chi2.isf(chance, dimensions)))
    return LimitState(
        f"sphere, d = {dimensions}", dimensions, lambda: chance, lambda u: radius - np.sqrt((u * u).sum(axis=1))
    )


def _density(x: float) -> float:
    return math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)


def _four_branches(u: Floats) -> Floats:
    along, across = (u[:, 0] + u[:, 1]) / ROOT2, (u[:, 0] - u[:, 1]) / ROOT2
    return np.minimum(3.0 + 0.2 * across**2 - np.abs(along), 7.0 / ROOT2 - ROOT2 * np.abs(across))


def _four_branches_truth() -> float:
    """Across: beyond 3.5; else along: beyond the curve, on both sides."""
    curves = quad(lambda y: 2.0 * float(ndtr(-3.0 - 0.2 * y * y)) * _density(y), -3.5, 3.5, epsabs=1e-14)[0]
    return 2.0 * float(ndtr(-3.5)) + curves


def _union(*chances: float) -> float:
    """Of independent failures."""
    return -math.expm1(sum(math.log1p(-chance) for chance in chances))


def _breitung(u: Floats) -> Floats:
    """Breitung (2017), arXiv 1705.04453: both slopes point away from the failures that are most probable."""
    first = np.where(u[:, 0] > 3.5, 4.0 - u[:, 0], 0.85 - 0.1 * u[:, 0])
    return np.minimum(first, np.where(u[:, 1] > 2.0, 0.5 - 0.1 * u[:, 1], 2.3 - u[:, 1]))


def _metaball(u: Floats) -> Floats:
    first, second = u[:, 0], u[:, 1]
    near = (4.0 * (first + 2.0) ** 2 / 9.0 + second**2 / 25.0) ** 2
    far = ((first - 2.5) ** 2 / 4.0 + (second - 0.5) ** 2 / 25.0) ** 2
    return 30.0 / (near + 1.0) + 20.0 / (far + 1.0) - 5.0


def _metaball_truth() -> float:
    """For each first number the second fails beyond the roots."""
    grid = np.linspace(-12.0, 12.0, 1201)

    def given(first: float) -> float:
        values = _metaball(np.column_stack([np.full_like(grid, first), grid]))
        ends = np.flatnonzero(np.diff(np.signbit(values)))
        roots = [brentq(lambda y: float(_metaball(np.array([[first, y]]))[0]), grid[i], grid[i + 1]) for i in ends]
        borders = [-math.inf, *roots, math.inf]
        inside = [values[0] <= 0.0, *(values[i + 1] <= 0.0 for i in ends)]
        # probabilities of the far sides are differences of small numbers on their own side
        parts = [
            _between(low, high) for low, high, fails in zip(borders[:-1], borders[1:], inside, strict=True) if fails
        ]
        return math.fsum(parts) * _density(first)

    steps = np.linspace(-9.0, 9.0, 1801)
    return float(np.trapezoid([given(x) for x in steps.tolist()], steps))


def _between(low: float, high: float) -> float:
    return float(ndtr(-low) - ndtr(-high)) if low > 0.0 else float(ndtr(high) - ndtr(low))


def _parabola_truth() -> float:
    return quad(lambda x: float(ndtr(-8.0 + 0.5 * (x - 0.1) ** 2)) * _density(x), -9.0, 9.0, epsabs=1e-16, limit=400)[0]


DEVIATION = math.sqrt(math.log(1.04))
LIMIT = 10.0 + 3.0 * 0.2 * math.sqrt(10.0)


def _rackwitz(u: Floats) -> Floats:
    """Rackwitz (2001), "Reliability analysis: a review and some perspectives": a sum of lognormal numbers."""
    return LIMIT - np.exp(DEVIATION * u - 0.5 * DEVIATION**2).sum(axis=1)


def _rackwitz_truth() -> float:
    """The density of the sum, as the tenth power of one number's characteristic function."""
    points, top = 2**17, 40.0
    step = top / points
    edges = np.arange(points + 1) * step
    with np.errstate(divide="ignore"):
        below = ndtr((np.log(edges) + 0.5 * DEVIATION**2) / DEVIATION)
    total = np.fft.irfft(np.fft.rfft(np.diff(below)) ** 10, points)
    middles = np.arange(points) * step + 5.0 * step  # ten numbers, each in the middle of its cell
    return float(total[middles >= LIMIT].sum())


def _steps(u: Floats) -> Floats:
    return np.ceil((-float(ndtri(1e-4)) - u.sum(axis=1) / math.sqrt(5.0)) / 0.25) * 0.25


def _jump(u: Floats) -> Floats:
    left = -float(ndtri(1e-4)) - u[:, 0]
    return np.where(left <= 0.0, 0.0, left + 2.0)


def _two_cars(u: Floats) -> Floats:
    """Clearances of a car between two parked ones, each with a slope that changes where few draws are."""
    left = np.minimum(0.9 - 0.1 * u[:, 0], 3.9 - u[:, 0])
    return np.minimum(left, np.maximum(2.6 - u[:, 1], 0.44 - 0.08 * u[:, 1]))


LIMIT_STATES = (
    _linear(2, 1e-2),
    _linear(10, 1e-5),
    _linear(50, 1e-4),
    _linear(50, 1e-7),
    LimitState("four branches", 2, _four_branches_truth, _four_branches),
    LimitState(
        "two modes", 2, lambda: _union(ndtr(-3.5), ndtr(-4.2)), lambda u: np.minimum(3.5 - u[:, 0], 4.2 + u[:, 1])
    ),
    LimitState("Breitung", 2, lambda: _union(ndtr(-4.0), ndtr(-5.0)), _breitung),
    LimitState("metaball", 2, _metaball_truth, _metaball),
    LimitState("parabola", 2, _parabola_truth, lambda u: 8.0 - u[:, 1] - 0.5 * (u[:, 0] - 0.1) ** 2),
    _largest(10, 4.4171734),
    _largest(50, 4.7532),
    _sphere(10, 1e-5),
    _sphere(50, 1e-6),
    LimitState("Rackwitz", 10, _rackwitz_truth, _rackwitz),
    LimitState("steps", 5, lambda: 1e-4, _steps),
    LimitState("jump", 2, lambda: 1e-4, _jump),
    LimitState("two parked cars", 2, lambda: _union(ndtr(-3.9), ndtr(-5.5)), _two_cars),
)


# -- estimates of each -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Held:
    """Intervals of one estimator on one limit state."""

    name: str
    dimensions: int
    truth: float
    method: str
    repetitions: int
    given: int
    holding: int
    """Intervals that hold the truth."""
    apart: int
    """Intervals that lie apart from that of `PLAIN` draws."""
    factor: float
    """Median quotient of both ends; NaN without an interval."""
    simulations: float
    """Median."""
    reasons: dict[str, int]

    @property
    def fine(self) -> bool:
        """True unless a bar is missed by more than chance: at the bar, that happens in less than 5 % of the time."""
        holds = float(binom.cdf(self.holding, self.given, LEAST_COVERAGE))
        return min(holds, float(binom.sf(self.apart - 1, self.given, MOST_APART))) >= 0.05


def held(name: str, method: str, repetitions: int, samples: int) -> Held:
    """Estimates from seeds 0, 1, …"""
    case = next(case for case in LIMIT_STATES if case.name == name)
    truth = float(case.truth())
    found = [probability(case.score, case.dimensions, method, samples, seed) for seed in range(repetitions)]
    ends = [each.interval for each in found if math.isfinite(each.interval.low)]
    plain = clopper_pearson(round(PLAIN * truth), PLAIN)
    return Held(
        case.name,
        case.dimensions,
        truth,
        method,
        repetitions,
        given=len(ends),
        holding=sum(low <= truth <= high for low, high in ends),
        apart=sum(low > plain.high or high < plain.low for low, high in ends),
        factor=float(np.median([high / max(low, 1e-300) for low, high in ends])) if ends else math.nan,
        simulations=float(np.median([each.simulations for each in found])),
        reasons=dict(Counter(str(each.withheld) for each in found if each.withheld)),
    )


HEAD = (
    "| limit state | d | p | estimator | given | hold p | apart | high / low | simulations | instead of an interval |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)


def row(found: Held) -> str:
    reasons = ", ".join(f"{name} {count:,}" for name, count in sorted(found.reasons.items()))
    factor = "" if math.isnan(found.factor) else f"{found.factor:.2f}"
    mark = "" if found.fine else " **missed**"
    return (
        f"| {found.name}{mark} | {found.dimensions} | {found.truth:.4e} | {found.method} | {found.given} of "
        f"{found.repetitions} | {found.holding} | {found.apart} | {factor} | {found.simulations:,.0f} | {reasons} |"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    found = tabulated(__doc__.splitlines()[0], [case.name for case in LIMIT_STATES], held, HEAD, row, 20, arguments)
    given, holding, apart = (sum(getattr(each, name) for each in found) for name in ("given", "holding", "apart"))
    print(f"\n{holding:,} of {given:,} intervals hold the truth, {apart:,} lie apart from it", file=sys.stderr)
    return 0 if all(each.fine for each in found) else 1


if __name__ == "__main__":
    raise SystemExit(main())
