"""Subset simulation for rare events: a small probability as a product of larger ones.

Au and Beck (2001), "Estimation of small failure probabilities in high dimensions by subset simulation"; its levels are
those of `levels.py`.

Runs of a chain are dependent. The variance is therefore estimated from ten independent repetitions of the whole
estimate. The mean is the estimate; its interval is Student's with nine degrees of freedom. Such estimates are products
and skewed to the right: if all ten are low, they also scatter little. The upper end is therefore that of the mean's
logarithm (by the delta method), which is higher, and its error probability is a fifth of that of the lower end, so that
a danger is seldom underestimated.

A reason replaces the interval if a repetition met a plateau or did not reach a failure, or if repetitions differ by
more than their mean: then ten repetitions do not show the error of the estimate. All ten may miss the same mode of
failures. So the mean of any nine is to be within a factor of 1.5 of the mean of any other nine, and of that of three
wide climbs, which estimate the same probability but begin farther out; they are not part of the estimate.
"""

import math
from collections.abc import Sequence
from functools import reduce

import numpy as np

from engine.assessment import Evaluate
from engine.program import ParamSpace
from engine.search.probability.estimates import (
    MOST_DRIVEN,
    NOT_KNOWN,
    REPETITIONS,
    Count,
    Judge,
    Probability,
    Withheld,
    around,
    checked_samples,
    disagree,
)
from engine.search.probability.levels import DISTANCE, Chains, Climb, Score, ascend, climb, width_of
from engine.search.statistics import Interval
from engine.tables import Floats

SCOUTS = 3
"""Wide climbs, as large as a repetition."""
SCOUT = 50
"""Number of the first one's run in the stream keys."""
LEAST = 100 * REPETITIONS
"""Runs a level, over all repetitions."""
LEFT_OUT_ABOVE = 0.1
"""Share of 1 - level by which the upper end may be too low; the lower end has half of 1 - level."""
MOST_SCATTER = 1.0
"""Largest ratio of the repetitions' standard deviation to their mean at which they count as a reliable sample."""


def subset_simulation(
    space: ParamSpace,
    evaluate: Evaluate,
    samples: int,
    seed: int = 0,
    level: float = 0.95,
    judge: Judge | None = None,
    score: Score = DISTANCE,
) -> Probability:
    """Estimate by subset simulation with `samples` runs per level, shared by ten independent repetitions.

    Raises:
        ValueError: fewer than 100 runs per repetition.
    """
    checked_samples("subset simulation", samples, LEAST)
    ways = [Chains(space, evaluate, score, seed, repetition + 1, judge) for repetition in range(REPETITIONS)]
    climbs = [climb(chains, samples // REPETITIONS) for chains in ways]
    values = np.array([each.value for each in climbs])
    withheld = _withheld(climbs)
    scouts: list[Chains] = []
    if not withheld:
        wide, share = width_of(len(space)), sum(chains.filled for chains in ways) / sum(chains.drawn for chains in ways)
        scouts = [Chains(space, evaluate, score, seed, SCOUT + scout, width=wide) for scout in range(SCOUTS)]
        seen = float(np.mean([ascend(chains, samples // REPETITIONS).joint for chains in scouts])) / share
        without = (values.sum() - values) / (len(values) - 1)
        withheld = Withheld.MODES if disagree(np.append(without, seen)) else withheld
    shares = np.array([_avoidable(chains, each) for chains, each in zip(ways, climbs, strict=True)])
    value, interval = _estimate(values, withheld, level)
    avoidable, avoidable_interval = _estimate(values * shares, withheld, level)
    total = reduce(Count.plus, (chains.count for chains in (*ways, *scouts)))
    return Probability(
        method="subset",
        value=value,
        interval=interval,
        level=level,
        simulations=total.simulations,
        valid=total.valid,
        collisions=total.collisions,
        valid_share=sum(chains.filled for chains in ways) / sum(chains.drawn for chains in ways),
        aborted=total.aborted,
        errors=total.errors,
        lost=total.lost,
        levels=climbs[0].thresholds,
        avoidable=avoidable,
        avoidable_interval=avoidable_interval,
        driven=sum(chains.driven for chains in ways),
        score=score.name,
        withheld=withheld,
        tied=max(each.tied for each in climbs),
        reached=sum(each.value > 0.0 and not each.withheld for each in climbs),
        repetitions=REPETITIONS,
    )


def _withheld(climbs: Sequence[Climb]) -> Withheld:
    """Return the most informative reason to give no interval, or `NOTHING`."""
    reasons = [each.withheld for each in climbs]
    for reason in (Withheld.INVALID, Withheld.PLATEAU):
        if reason in reasons:
            return reason
    if any(reasons):
        return Withheld.UNREACHED if all(reasons) else Withheld.PARTLY
    values = np.array([each.value for each in climbs])
    return Withheld.SCATTERED if values.std(ddof=1) > MOST_SCATTER * values.mean() else Withheld.NOTHING


def _estimate(values: Floats, withheld: Withheld, level: float) -> tuple[float, Interval]:
    """Return the mean of independent estimates and its interval; both NaN if withheld, or 0 and NaN if unreached."""
    from scipy.special import stdtrit

    if withheld or np.isnan(values).any():
        return 0.0 if withheld == Withheld.UNREACHED else math.nan, NOT_KNOWN
    mean = float(values.mean())
    if not mean > 0.0:
        return mean, NOT_KNOWN
    error, freedom = float(values.std(ddof=1)) / math.sqrt(len(values)), len(values) - 1
    below = error * float(stdtrit(freedom, (1.0 + level) / 2.0))
    above = error * float(stdtrit(freedom, 1.0 - LEFT_OUT_ABOVE * (1.0 - level)))
    return mean, Interval(max(0.0, mean - below), around(mean, above / mean).high)


def _avoidable(chains: Chains, found: Climb) -> float:
    """Return the share of the last level's failures that the reference driver avoids; NaN without a judge."""
    if chains.judge is None or found.last is None:
        return math.nan
    rows = np.flatnonzero(found.last.failed)
    if found.withheld or not len(rows):
        return 0.0
    chosen = rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST_DRIVEN // REPETITIONS)).astype(np.int64)]
    return float(chains.avoided(found.last.rows(chosen)).mean())
