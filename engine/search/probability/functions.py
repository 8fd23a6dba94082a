"""Probability that a Python function of random numbers fails, by the estimators of a file's failures."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from engine.assessment import Evaluate
from engine.errors import ArgumentError
from engine.outcomes import RESULTS, Assessment
from engine.program import ParamSpace
from engine.search.probability.estimates import Probability
from engine.search.probability.monte_carlo import METHODS, RARE, monte_carlo
from engine.tables import Floats, Ints
from engine.vocabulary import Distribution, GeneKind

TINY = 1e-16
"""Distance that uniform numbers keep from 0 and 1."""
MOST_DIMENSIONS = 1000


class Marginal(Protocol):
    """A distribution of one number, such as a frozen one of `scipy.stats`."""

    def ppf(self, q: Any, /) -> Any:
        """Return the quantiles of probabilities (n,)."""
        ...


def probability(
    function: Callable[[Floats], ArrayLike],
    space: int | Sequence[Marginal],
    method: str = "importance",
    samples: int = 10_000,
    seed: int = 0,
    level: float = 0.95,
) -> Probability:
    """Return the probability that a function of independent random numbers is 0 or less.

    function: (n, d) points -> (n,) scores; 0 or less is a failure, and the smaller the nearer. space: the distribution
    of each number, such as `scipy.stats.norm(3, 0.5)`, or d standard normal numbers. method: `mc`, `subset` or
    `importance`, with as many samples as for `cortexc probability`.

    Raises:
        ArgumentError: an argument is wrong; or the function raises an exception, or returns NaN or another shape. The
            message has the first such point.
    """
    if method not in METHODS:
        raise ArgumentError(f"method is {method!r}", f"take one of {', '.join(METHODS)}")
    quantiles = _quantiles(space)
    evaluate = evaluator(lambda uniforms, _: scores(function, quantiles(uniforms)))
    estimator = monte_carlo if method == "mc" else RARE[method].function
    if samples < 1:
        raise ArgumentError(f"samples is {samples}", "take at least 1")
    return estimator(uniform_space(space if isinstance(space, int) else len(space)), evaluate, samples, seed, level)


def _quantiles(space: int | Sequence[Marginal]) -> Callable[[Floats], Floats]:
    """Return the function from uniform numbers (n, d) to points (n, d)."""
    from scipy.special import ndtri

    if isinstance(space, int):
        if not 1 <= space <= MOST_DIMENSIONS or isinstance(space, bool):
            raise ArgumentError(f"space is {space!r}", f"take 1 to {MOST_DIMENSIONS} standard normal numbers")
        return lambda uniforms: ndtri(_inside(uniforms))
    for number, marginal in enumerate(space):
        if not callable(getattr(marginal, "ppf", None)):
            raise ArgumentError(
                f"space[{number}] is {marginal!r}, which has no method `ppf`",
                "take frozen distributions, such as `scipy.stats.norm(3, 0.5)`",
            )
    if not 1 <= len(space) <= MOST_DIMENSIONS:
        raise ArgumentError(f"space has {len(space)} distributions", f"take 1 to {MOST_DIMENSIONS}")
    return lambda uniforms: np.column_stack(
        [
            np.asarray(each.ppf(column), dtype=np.float64)
            for each, column in zip(space, _inside(uniforms).T, strict=True)
        ]
    )


def _inside(uniforms: Floats) -> Floats:
    return np.clip(uniforms, TINY, 1.0 - TINY)


def scores(function: Callable[[Floats], ArrayLike], points: Floats) -> Floats:
    """Return (n,) scores of points (n, d), checked.

    Raises:
        ArgumentError: the function raises an exception, or returns NaN or another shape.
    """
    try:
        values = np.asarray(function(points.copy()), dtype=np.float64)
    except Exception as error:
        point = _first_raising(function, points)
        raise ArgumentError(
            f"the function raises {type(error).__name__} ({error}) at {_text(point)}",
            "it takes points (n, d) and returns scores (n,)",
        ) from error
    if values.shape != (len(points),):
        raise ArgumentError(
            f"the function returns shape {values.shape} for {len(points)} points, of which the first is "
            f"{_text(points[0])}",
            f"return one score for each point: shape ({len(points)},)",
        )
    if np.isnan(values).any():
        first = points[int(np.argmax(np.isnan(values)))]
        raise ArgumentError(f"the function returns NaN at {_text(first)}", "return a number; 0 or less is a failure")
    return values


def _first_raising(function: Callable[[Floats], ArrayLike], points: Floats) -> Floats:
    """Return the first point at which the function raises alone; the first of all if it only raises for all."""
    for row in range(len(points)):
        try:
            function(points[row : row + 1].copy())
        except Exception:
            return points[row]
    return points[0]


def _text(point: Floats) -> str:
    return f"({', '.join(f'{number:.6g}' for number in point.tolist())})"


# -- what estimators ask for -------------------------------------------------------------------------------------------


def uniform_space(count: int) -> ParamSpace:
    """Return the space of some genes that are uniform numbers from 0 to 1."""
    return ParamSpace(
        names=tuple(f"U{i}" for i in range(count)),
        units=("",) * count,
        kinds=np.full(count, int(GeneKind.CONTINUOUS), dtype=np.int32),
        low=np.zeros(count),
        high=np.ones(count),
        distribution=np.full(count, int(Distribution.UNIFORM), dtype=np.int32),
        shape=np.zeros((count, 2)),
        scale=np.ones(count),
        weights=((),) * count,
        options=((),) * count,
    )


def evaluator(score: Callable[[Floats, Ints], Floats]) -> Evaluate:
    """Return an evaluator that takes a score of (uniform numbers, stream keys) for the least distance of a valid run;
    0 or less is a collision.
    """

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        left = score(genomes, keys)
        count = len(keys)
        blank: dict[str, Any] = {
            row.name: np.full((count, *((1,) if row.parts else ())), row.fill, row.dtype) for row in RESULTS
        }
        known: dict[str, Any] = {
            "verdict": np.zeros(count, dtype=np.int32),
            "collided": left <= 0.0,
            "min_distance": np.maximum(left, 0.0),
            "pair": np.zeros(count, dtype=np.int32),
            "tested": np.zeros((count, 0), dtype=np.int64),
            "failed": np.zeros((count, 0), dtype=np.int64),
            "found": left <= 0.0,
            "sought": np.zeros((count, 0)),
            "broken": np.zeros((count, 0)),
        }
        return Assessment(**blank | known)

    return evaluate
