"""Importance sampling, for what is rare: draw where failures are, and weigh each run by how likely the file draws it.

Genes are standard normal numbers through their quantile functions, so that the file's own density f is the standard
normal one. First one climb of `levels.py`, and chains inside the failures that it reaches, show where these are. A
mixture of normal densities is fitted to them by expectation and maximisation, which minimises the cross-entropy from f
given a failure: Rubinstein and Kroese (2004), "The cross-entropy method"; with mixtures, for several modes, Kurtz and
Song (2013), "Cross-entropy-based adaptive importance sampling using Gaussian mixture".

The estimate takes new runs alone, drawn from a density q that holds f itself with a share of a tenth, so that no weight
w = f / q is above ten: Hesterberg (1995), "Weighted average importance sampling and defensive mixture distributions".
It is the mean of w times failure over these n runs, divided by the share of draws that give a valid run; its error is
that of a mean of independent numbers (Owen 2013, "Monte Carlo theory, methods and examples", chapter 9), and the
interval that of its logarithm, by the delta method. The effective sample size (sum w)^2 / sum w^2 of the failures (Kong
1992, "A note on importance sampling using standardized weights") says whether that may be trusted. Where it is small,
or the estimate is far from the climb's, a reason takes the interval's place.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.program import ParamSpace
from engine.search.assessment import Evaluate
from engine.search.probability.estimates import (
    MOST_DRIVEN,
    NOT_KNOWN,
    Judge,
    Probability,
    Withheld,
    around,
    checked_samples,
)
from engine.search.probability.levels import Chains, Level, climb, joined, next_level
from engine.search.probability.mixtures import Mixture, fitted, nominal, together, widened
from engine.search.probability.scores import DISTANCE, Score
from engine.search.statistics import Interval
from engine.tables import Bools, Floats

LEAST = 1000
"""Simulations."""
LEVELS = 10
"""Levels of which the size is such that as many would take all simulations."""
LEAST_EFFECTIVE = 100.0
"""Effective sample size of the failures below which no interval is given."""
FARTHEST = 5.0
"""Between the estimate and that of the climb, as a factor either way."""
DEFENCE = 0.1
"""Share of the file's own distribution in what is drawn."""
SPREAD = ((0.7, 0.2), (0.2, 1.0))
"""Shares of the fitted mixture in what is drawn, and of a unit covariance in it. Beyond a border failures fall off like
an exponential function, slower than a normal density that is as narrow as they are: without the second, what lies far
beyond is seldom drawn and weighs much.
"""
LAST_SHARE = 4
"""At least one of so many simulations is left for the estimate."""
BLOCK = 4096
"""Draws that are simulated together."""
RUN = 100
"""Of the streams: no repetition of subset simulation has it."""


class _Runs(NamedTuple):
    """Independent runs, rows aligned, and how much each weighs."""

    weights: Floats
    failed: Bools
    scenes: Level


def importance_sampling(
    space: ParamSpace,
    evaluate: Evaluate,
    samples: int,
    seed: int = 0,
    level: float = 0.95,
    judge: Judge | None = None,
    score: Score = DISTANCE,
) -> Probability:
    """Importance sampling with about `samples` simulations in all.

    Raises:
        ValueError: fewer than 1,000.
    """
    checked_samples("importance sampling", samples, LEAST)
    chains = Chains(space, evaluate, score, seed, RUN, judge)
    size = samples // LEVELS
    found = climb(chains, size)
    runs = _drawn(chains, _density(chains, found.last, size), samples) if found.last and not found.withheld else None
    weights = np.zeros(0) if runs is None else runs.weights * runs.failed
    value, interval = _estimate(weights, chains, level)
    withheld = found.withheld if runs is None else _withheld(weights, value, found.value)
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
        levels=found.thresholds,
        avoidable=avoidable,
        avoidable_interval=avoidable_interval,
        driven=chains.driven,
        score=score.name,
        withheld=withheld,
        tied=found.tied,
        effective=effective_size(weights),
    )


def effective_size(weights: Floats) -> float:
    """Kong's: as many runs of equal weight have an error as large."""
    squares = float((weights * weights).sum())
    return float(weights.sum()) ** 2 / squares if squares > 0.0 else 0.0


def _density(chains: Chains, failures: Level, size: int) -> Mixture:
    """What is drawn from: f, and where failures are."""
    inside = next_level(chains, failures.rows(failures.failed), math.inf, size)
    fit = fitted(inside.points, chains.numbers())
    parts = [(share, widened(fit, wider)) for share, wider in SPREAD]
    return together((DEFENCE, nominal(inside.points.shape[1])), *parts)


def _drawn(chains: Chains, density: Mixture, samples: int) -> _Runs:
    """The runs of the estimate: what simulations are left, and no fewer than a quarter of all."""
    points = density.draw(chains.numbers(), max(samples - chains.count.simulations, samples // LAST_SHARE))
    parts: list[_Runs] = []
    for start in range(0, len(points), BLOCK):
        block = points[start : start + BLOCK]
        scenes, valid = chains.simulate(block, chains.keys(len(block), start))
        parts.append(_Runs(1.0 / density.ratios(block), valid & scenes.failed, scenes))
    weights, failed, scenes = zip(*parts, strict=True)
    return _Runs(np.concatenate(weights), np.concatenate(failed), joined(list(scenes)))


def _withheld(weights: Floats, value: float, rough: float) -> Withheld:
    """Why the estimate is not to be trusted, if so."""
    if effective_size(weights) < LEAST_EFFECTIVE:
        return Withheld.FEW
    return Withheld.NOTHING if rough / FARTHEST <= value <= rough * FARTHEST else Withheld.APART


def _estimate(weights: Floats, chains: Chains, level: float) -> tuple[float, Interval]:
    """Mean weight of failures, given a valid run, and its interval."""
    from scipy.special import ndtri

    mean = float(weights.mean()) if len(weights) else 0.0
    if not mean > 0.0:
        return 0.0, NOT_KNOWN
    share = chains.filled / chains.drawn
    relative = float(weights.var(ddof=1)) / (len(weights) * mean * mean) + (1.0 - share) / chains.filled
    value = min(1.0, mean / share)  # weights are random: their mean may lie above
    return value, around(value, float(ndtri((1.0 + level) / 2.0)) * math.sqrt(relative))


def _avoidable(runs: _Runs, chains: Chains, level: float) -> tuple[float, Interval]:
    """The same of failures that can be avoided: of the first runs, whose failures are driven again."""
    if chains.judge is None:
        return math.nan, NOT_KNOWN
    rows = np.flatnonzero(runs.failed)
    count = int(rows[MOST_DRIVEN]) if len(rows) > MOST_DRIVEN else len(runs.weights)
    rows = rows[rows < count]
    weights = np.zeros(count)
    weights[rows] = runs.weights[rows] * chains.avoided(runs.scenes.rows(rows))
    value, interval = _estimate(weights, chains, level)
    return value, interval if effective_size(weights) >= LEAST_EFFECTIVE else NOT_KNOWN
