"""Subset simulation, for what is rare: a small probability as a product of larger ones.

Au and Beck (2001), "Estimation of small failure probabilities in high dimensions by subset simulation". The levels are
least distances (MD): of each level's runs the nearest tenth are the seeds of chains in which no run is farther than
they are. The chains' proposals are those of Papaioannou, Betz, Zwirglmaier and Straub (2015), "MCMC algorithms for
subset simulation", sections 4.4: every gene, as a standard normal number, is drawn a step towards its prior; and in
every other step the scene's own random numbers are drawn again.

Within a chain runs are dependent. The variance is therefore taken from outside: the whole estimate is made ten times,
independently; the mean is the estimate, and its interval is Student's with nine degrees of freedom.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from engine.errors import ArgumentError
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.search.assessment import Evaluate, concatenate, take
from engine.search.probability.estimates import MOST_DRIVEN, NOT_KNOWN, Count, Judge, Probability
from engine.search.statistics import Interval
from engine.streams import key_rows, operator_generator
from engine.tables import Floats, Ints
from engine.vocabulary import Method, Verdict

REPETITIONS = 10
"""Independent estimates of subset simulation."""
SHARE = 0.1
"""Of a level's runs that are the seeds of the next."""
STEP = 0.6
"""Of a chain, in standard deviations: sqrt(1 - rho^2) with rho = 0.8."""
MOST_LEVELS = 12
TRIES = 50
"""Blocks without enough valid runs after which a level cannot be filled."""

Genomes = Callable[[Floats], Floats]
"""Uniform numbers (n, d) to genomes (n, d) under the file's distributions."""


@dataclass(frozen=True)
class _Level:
    """Valid runs, rows aligned: where their genes lie in standard normal space, their keys, and what came of them."""

    points: Floats
    keys: Ints
    runs: Assessment

    def rows(self, chosen: Ints) -> "_Level":
        return _Level(self.points[chosen], self.keys[chosen], take(self.runs, chosen))

    @property
    def distance(self) -> Floats:
        """(n,) MD, 0 for a collision [m]."""
        return np.where(self.runs.collided, 0.0, np.maximum(self.runs.min_distance, np.finfo(float).tiny))


@dataclass
class _Chain:
    """One repetition of subset simulation: where its random numbers come from, and what it has spent.

    Of the `drawn` draws of its first level `filled` were valid.
    """

    evaluate: Evaluate
    genomes: Genomes
    genes: int
    seed: int
    run: int
    judge: Judge | None = None
    count: Count = field(default_factory=Count)
    drawn: int = 0
    filled: int = 0
    driven: int = 0
    step: int = 0

    def numbers(self) -> Generator:
        """A new stream for the next block."""
        self.step += 1
        return operator_generator(self.seed, int(Method.SAMPLE), self.run, self.step)

    def keys(self, count: int) -> Ints:
        """New stream keys for scenes, of this block."""
        return key_rows(self.seed, int(Method.SAMPLE), self.run, self.step, range(count))

    def simulate(self, points: Floats, keys: Ints) -> Assessment:
        runs = self.evaluate(self.genomes(_uniforms(points)), keys)
        self.count = self.count.more(runs)
        return runs

    def avoidable(self, level: "_Level") -> float:
        """Share of a level's collisions that can be avoided, by driving some of them again; NaN without a judge."""
        rows = np.flatnonzero(level.runs.collided)
        if self.judge is None or not len(rows):
            return math.nan
        most = min(len(rows), MOST_DRIVEN // REPETITIONS)
        chosen = level.rows(rows[np.linspace(0, len(rows) - 1, most).astype(np.int64)])
        self.driven += most
        return float(self.judge(self.genomes(_uniforms(chosen.points)), chosen.keys).mean())


def _uniforms(points: Floats) -> Floats:
    """Of standard normal numbers."""
    from scipy.special import ndtr

    return np.clip(ndtr(points), 0.0, np.nextafter(1.0, 0.0))


def subset_simulation(
    space: ParamSpace,
    evaluate: Evaluate,
    samples: int,
    seed: int = 0,
    level: float = 0.95,
    judge: Judge | None = None,
) -> Probability:
    """Subset simulation with `samples` runs a level, shared by ten independent repetitions.

    Raises:
        ValueError: fewer than 100 runs a repetition.
    """
    from engine.sampling import from_uniforms

    size = samples // REPETITIONS
    if size < 100:
        raise ArgumentError(
            f"samples is {samples}; subset simulation needs at least {100 * REPETITIONS} a level", "take more"
        )
    chains = [
        _Chain(evaluate, lambda uniforms: from_uniforms(space, uniforms), len(space), seed, repetition + 1, judge)
        for repetition in range(REPETITIONS)
    ]
    estimates = [_estimate(chain, size) for chain in chains]
    value, interval = _student([each.value for each in estimates], level)
    avoidable, avoidable_interval = _student([each.avoidable for each in estimates], level)
    return Probability(
        method="subset",
        value=value,
        interval=interval,
        level=level,
        simulations=sum(chain.count.simulations for chain in chains),
        valid=sum(chain.count.valid for chain in chains),
        collisions=sum(chain.count.collisions for chain in chains),
        valid_share=sum(chain.filled for chain in chains) / sum(chain.drawn for chain in chains),
        aborted=sum(chain.count.aborted for chain in chains),
        levels=estimates[0].levels,
        avoidable=avoidable,
        avoidable_interval=avoidable_interval,
        driven=sum(chain.driven for chain in chains),
    )


def _student(estimates: list[float], level: float) -> tuple[float, Interval]:
    """Mean of independent estimates and Student's interval; none where every estimate is 0."""
    from scipy.special import stdtrit

    values = np.array(estimates)
    mean = float(values.mean())
    if not mean > 0.0:
        return 0.0 if mean == 0.0 else math.nan, NOT_KNOWN
    half = float(stdtrit(len(values) - 1, (1.0 + level) / 2.0)) * float(values.std(ddof=1)) / math.sqrt(len(values))
    return mean, Interval(max(0.0, mean - half), min(1.0, mean + half))


class _Estimate(NamedTuple):
    """Of one repetition; NaN where valid runs are too rare to begin with."""

    value: float
    levels: tuple[float, ...]
    avoidable: float


def _estimate(chain: _Chain, size: int) -> _Estimate:
    current = _first_level(chain, size)
    if current is None:
        return _Estimate(math.nan, (), math.nan)
    value = 1.0
    levels: list[float] = []

    def ended(last: _Level, *more: float) -> _Estimate:
        found = value * float((last.distance == 0.0).mean())
        avoidable = found * chain.avoidable(last) if found > 0.0 and chain.judge else 0.0 if chain.judge else math.nan
        return _Estimate(found, (*levels, *more), avoidable)

    for _ in range(MOST_LEVELS):
        distance = current.distance
        touching = float((distance == 0.0).mean())
        threshold = float(np.quantile(distance, SHARE, method="lower"))
        if touching >= SHARE or threshold == 0.0:
            return ended(current, 0.0)
        inside = distance <= threshold
        if not math.isfinite(threshold) or (levels and threshold >= levels[-1]):
            return ended(current)
        value *= float(inside.mean())
        levels.append(threshold)
        current = _next_level(chain, current.rows(np.flatnonzero(inside)), threshold, size)
    return ended(current)


def _first_level(chain: _Chain, size: int) -> _Level | None:
    """`size` valid runs under the file's distributions."""
    parts: list[_Level] = []
    found = 0
    for _ in range(TRIES):
        numbers, count = chain.numbers(), max(size, 64)
        points, keys = numbers.standard_normal((count, chain.genes)), chain.keys(count)
        runs = chain.simulate(points, keys)
        rows = np.flatnonzero(runs.verdict == Verdict.VALID)[: size - found]
        found += len(rows)
        chain.filled += len(rows)
        chain.drawn += int(rows[-1]) + 1 if found == size and len(rows) else count
        parts.append(_Level(points, keys, runs).rows(rows))
        if found == size:
            return _joined(parts)
    return None


def _next_level(chain: _Chain, seeds: _Level, threshold: float, size: int) -> _Level:
    """Runs no farther than the threshold: chains from the seeds, all of them a step at a time."""
    length = max(1, round(1.0 / SHARE))
    count = max(1, size // length)
    numbers = chain.numbers()
    state = seeds.rows(np.sort(numbers.choice(len(seeds.keys), count, replace=len(seeds.keys) < count)))
    parts = [state]
    for step in range(1, length):
        numbers = chain.numbers()
        noise = numbers.standard_normal(state.points.shape)
        points = math.sqrt(1.0 - STEP * STEP) * state.points + STEP * noise
        keys = chain.keys(count) if step % 2 else state.keys
        proposed = _Level(points, keys, chain.simulate(points, keys))
        accepted = (proposed.runs.verdict == Verdict.VALID) & (proposed.distance <= threshold)
        state = _chosen(accepted, proposed, state)
        parts.append(state)
    return _joined(parts)


def _chosen(accepted: np.ndarray, proposed: _Level, state: _Level) -> _Level:
    """The proposal where it was accepted, else the state again."""
    both = _joined([state, proposed])
    rows = np.arange(len(accepted))
    return both.rows(np.where(accepted, rows + len(rows), rows))


def _joined(parts: list[_Level]) -> _Level:
    return _Level(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.keys for part in parts]),
        concatenate([part.runs for part in parts]),
    )
