"""Levels of runs that approach a failure: they locate failures and estimate their probability, if the score leads
there.

Au and Beck (2001), "Estimation of small failure probabilities in high dimensions by subset simulation": the nearest
tenth of each level's runs are the seeds of chains, in which no run is farther from a failure than they are. Proposals
of the chains are those of Papaioannou, Betz, Zwirglmaier and Straub (2015), "MCMC algorithms for subset simulation",
section 4.4: every gene, as a standard normal number, is drawn a step towards its prior; and in every other step the
scene's own random numbers are drawn again.

A climb under the file's own distribution follows the slope that is steep where most draws are, and may never see a
failure on another side, however probable. A *wide* climb therefore begins with normal numbers of a larger standard
deviation, which see the far sides of the space too. Its failures are then narrowed down to the file's distribution step
by step: they are drawn again by their likelihood under a smaller deviation, and moved by chains inside the failures.
This is annealed importance sampling: Neal (2001), "Annealed importance sampling"; Del Moral, Doucet and Jasra (2006),
"Sequential Monte Carlo samplers"; for rare events, Papaioannou, Papadimitriou and Straub (2016), "Sequential importance
sampling for structural reliability analysis".

A score gives no direction on a plateau, where many different runs are exactly at the threshold: a level cannot take
their nearest tenth, and chains among them move at random.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from engine.assessment import Evaluate
from engine.outcomes import Assessment
from engine.portable import exp
from engine.program import ParamSpace
from engine.search.probability.estimates import Count, Judge, Withheld
from engine.streams import key_rows, operator_generator
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Method, Verdict

# -- scores ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Score:
    """One score. Both functions take runs and return (n,) values, which are meaningless for invalid runs."""

    name: str
    sentence: str
    unit: str
    nearness: Callable[[Assessment], Floats]
    """Minus the distance to a failure, so larger values are nearer; not read for a failure."""
    failed: Callable[[Assessment], Bools]


DISTANCE = Score(
    "distance",
    "the least distance between the ego and another (MD); a failure is a collision",
    "m",
    lambda runs: -runs.min_distance,
    lambda runs: runs.collided,
)
SCORES = {score.name: score for score in (DISTANCE,)}


def nearness(score: Score, runs: Assessment) -> Floats:
    """Return (n,) nearness by the score; infinite for a failure, minus infinite if unknown."""
    near = np.where(score.failed(runs), np.inf, np.minimum(score.nearness(runs), 0.0))
    return np.where(np.isnan(near), -np.inf, near)


SHARE = 0.1
"""Share of a level's runs that are the seeds of the next level."""
TIED = SHARE / 2.0
"""Largest share of a level's runs that are different and exactly at its threshold; above it the level is a plateau."""
STEP = 0.6
"""Step of a chain, in standard deviations: sqrt(1 - rho^2) with rho = 0.8."""
MOST_LEVELS = 12
WIDTH = 1.5
"""A wide climb begins with a standard deviation of 1 + WIDTH / sqrt(d): about WIDTH farther out in any number d of
dimensions.
"""
LEAST_SHARE = 0.5
"""Effective share of failures whose likelihoods may differ, in one step of narrowing down."""
MOVES = 3
"""Moves of each chain after such a step."""
MOST_STEPS = 30
TRIES = 50
"""Blocks without enough valid runs after which a level cannot be filled."""


@dataclass(frozen=True)
class Level:
    """Valid runs, rows aligned: genes as points of standard normal space, keys, and nearness to a failure."""

    points: Floats
    keys: Ints
    near: Floats
    """(n,) infinite for a failure."""

    def rows(self, chosen: Ints | Bools) -> "Level":
        return Level(self.points[chosen], self.keys[chosen], self.near[chosen])

    @property
    def failed(self) -> Bools:
        return np.isposinf(self.near)


@dataclass
class Chains:
    """One climb through the levels, with the source of its random numbers and the simulations it has used.

    Of the `drawn` draws of its first level `filled` were valid.
    """

    space: ParamSpace
    evaluate: Evaluate
    score: Score
    seed: int
    run: int
    judge: Judge | None = None
    width: float = 1.0
    """Standard deviation of the normal numbers of its levels; 1 stands for the file's own distribution."""
    count: Count = field(default_factory=Count)
    drawn: int = 0
    filled: int = 0
    driven: int = 0
    step: int = 0

    def numbers(self) -> Generator:
        """Return a new stream for the next block."""
        self.step += 1
        return operator_generator(self.seed, int(Method.SAMPLE), self.run, self.step)

    def keys(self, count: int, first: int = 0) -> Ints:
        """Return new stream keys for the scenes of this block."""
        return key_rows(self.seed, int(Method.SAMPLE), self.run, self.step, range(first, first + count))

    def simulate(self, points: Floats, keys: Ints) -> tuple[Level, Bools]:
        """Return the runs of these scenes, and (n,) True for valid ones."""
        runs = self.evaluate(self.genomes(points), keys)
        self.count = self.count.more(runs)
        return Level(points, keys, nearness(self.score, runs)), runs.verdict == Verdict.VALID

    def used(self, other: "Chains") -> None:
        """Count the simulations of other chains as well; first levels only if both draw as the file does."""
        self.count = self.count.plus(other.count)
        self.driven += other.driven
        if other.width == self.width:
            self.drawn += other.drawn
            self.filled += other.filled

    def survey(self, count: int) -> Assessment:
        """Return some runs of the first level, valid or not."""
        points = self.width * self.numbers().standard_normal((count, len(self.space)))
        runs = self.evaluate(self.genomes(points), self.keys(count))
        self.count = self.count.more(runs)
        return runs

    def genomes(self, points: Floats) -> Floats:
        """Return the genomes of standard normal numbers, under the file's distributions."""
        from scipy.special import ndtr

        from engine.sampling import from_uniforms

        return from_uniforms(self.space, np.clip(ndtr(points), 0.0, np.nextafter(1.0, 0.0)))

    def avoided(self, level: Level) -> Bools:
        """Return (n,) True where the reference driver avoids the collision."""
        assert self.judge is not None
        self.driven += len(level.keys)
        return self.judge(self.genomes(level.points), level.keys)


class Climb(NamedTuple):
    """Result of one climb through the levels."""

    value: float
    """Estimated probability of a failure, given a valid run; NaN where valid runs are too rare to begin with."""
    thresholds: tuple[float, ...]
    """Distance of each level's threshold to a failure, in units of the score; 0 stands for a failure."""
    last: Level | None
    withheld: Withheld = Withheld.NOTHING
    tied: float = 0.0
    """Share of a level's runs that are on a plateau."""


def climb(chains: Chains, size: int) -> Climb:
    """Simulate levels of `size` runs, until a tenth of a level are failures."""
    level = _first_level(chains, size)
    if level is None:
        return Climb(math.nan, (), None, Withheld.INVALID)
    value = 1.0
    left: list[float] = []
    for _ in range(MOST_LEVELS):
        threshold = float(np.sort(level.near)[::-1][int((size_of(level) - 1) * SHARE)])
        if math.isinf(threshold) and threshold > 0.0:
            return Climb(value * float(level.failed.mean()), (*left, 0.0), level)
        tied = _tied(level, threshold)
        if tied > TIED:
            return Climb(math.nan, tuple(left), level, Withheld.PLATEAU, tied)
        if left and -threshold >= left[-1]:
            break
        inside = level.near >= threshold
        value *= float(inside.mean())
        left.append(-threshold)
        level = next_level(chains, level.rows(inside), threshold, size)
    return Climb(value * float(level.failed.mean()), tuple(left), level, Withheld.UNREACHED)


def size_of(level: Level) -> int:
    return len(level.near)


def _tied(level: Level, threshold: float) -> float:
    """Return the share of a level's runs that are different and at the threshold; a resting chain repeats one run."""
    rows = np.flatnonzero(level.near == threshold)
    if len(rows) <= TIED * size_of(level):
        return 0.0
    different = np.unique(np.column_stack([level.points[rows], level.keys[rows]]), axis=0)
    return len(different) / size_of(level)


def _first_level(chains: Chains, size: int) -> Level | None:
    """Return `size` valid runs under the file's distributions; None if valid runs are too rare."""
    parts: list[Level] = []
    found = 0
    for _ in range(TRIES):
        numbers, count = chains.numbers(), max(size, 64)
        points = chains.width * numbers.standard_normal((count, len(chains.space)))
        drawn, valid = chains.simulate(points, chains.keys(count))
        rows = np.flatnonzero(valid)[: size - found]
        found += len(rows)
        chains.filled += len(rows)
        chains.drawn += int(rows[-1]) + 1 if found == size and len(rows) else count
        parts.append(drawn.rows(rows))
        if found == size:
            return joined(parts)
    return None


def next_level(chains: Chains, seeds: Level, threshold: float, size: int) -> Level:
    """Return runs no farther than the threshold: chains from the seeds, advanced together step by step."""
    length = max(1, round(1.0 / SHARE))
    count = max(1, size // length)
    numbers = chains.numbers()
    state = seeds.rows(np.sort(numbers.choice(len(seeds.keys), count, replace=len(seeds.keys) < count)))
    return joined([state, *_moved(chains, state, threshold, chains.width, length - 1)])


def _moved(chains: Chains, state: Level, threshold: float, width: float, steps: int) -> list[Level]:
    """Return the states of chains after each of some steps, under normal numbers of this width."""
    parts: list[Level] = []
    for step in range(1, steps + 1):
        numbers = chains.numbers()
        noise = width * numbers.standard_normal(state.points.shape)
        points = math.sqrt(1.0 - STEP * STEP) * state.points + STEP * noise
        proposed, valid = chains.simulate(points, chains.keys(len(points)) if step % 2 else state.keys)
        state = _chosen(valid & (proposed.near >= threshold), proposed, state)
        parts.append(state)
    return parts


# -- wide climbs -------------------------------------------------------------------------------------------------------


def width_of(dimensions: int) -> float:
    """Return the standard deviation with which a wide climb begins."""
    return 1.0 + WIDTH / math.sqrt(max(1, dimensions))


class Ascent(NamedTuple):
    """One climb, and its failures as the file's own distribution has them."""

    found: Climb
    failures: Level | None
    """About as many runs as a level has; None if it did not come to failures."""
    joint: float
    """Estimated probability that a draw gives a valid run with a failure; 0 if it did not come to failures."""


def ascend(chains: Chains, size: int) -> Ascent:
    """Climb through levels of `size` runs, and gather failures under the file's own distribution."""
    found = climb(chains, size)
    if found.withheld or found.last is None:
        return Ascent(found, None, 0.0)
    inside, ratio = found.last.rows(found.last.failed), 1.0
    if chains.width > 1.0:
        failures, ratio = _narrowed(chains, inside, max(1, size // 2))
    else:
        failures = next_level(chains, inside, math.inf, size)
    return Ascent(found, failures, found.value * ratio * chains.filled / chains.drawn)


def _narrowed(chains: Chains, failures: Level, size: int) -> tuple[Level | None, float]:
    """Return failures under the file's distribution, from those of a wide climb, and by what factor the probability of
    a failure is smaller under it; None and 0 if that takes too many steps.
    """
    width, ratio, parts = chains.width, 1.0, [failures]
    for _ in range(MOST_STEPS):
        if width == 1.0:
            return joined(parts[-2:]), ratio
        squares = np.einsum("ni,ni->n", failures.points, failures.points)
        after = _next_width(squares, width, failures.points.shape[1])
        weights = _likelihoods(squares, width, after, failures.points.shape[1])
        ratio *= float(weights.mean())
        chosen = chains.numbers().choice(len(weights), size, p=weights / weights.sum())
        parts = _moved(chains, failures.rows(np.sort(chosen)), math.inf, after, MOVES)
        failures, width = parts[-1], after
    return None, 0.0


def _likelihoods(squares: Floats, width: float, after: float, dimensions: int) -> Floats:
    """Return normal densities of width `after` over those of `width`, for points at these squared distances from 0."""
    factor = 0.5 * (1.0 / after**2 - 1.0 / width**2)
    return exp(dimensions * math.log(width / after) - factor * squares)


def _next_width(squares: Floats, width: float, dimensions: int) -> float:
    """Return the least width from 1 on at which an effective share of `LEAST_SHARE` of the points is left."""

    def is_near(after: float) -> bool:
        weights = _likelihoods(squares - squares.min(), width, after, dimensions)
        return float(weights.sum()) ** 2 >= LEAST_SHARE * len(weights) * float((weights * weights).sum())

    low, high = 1.0, width
    if is_near(low):
        return low
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_near(middle) else (middle, high)
    return high


# -- steps of chains ---------------------------------------------------------------------------------------------------


def _chosen(accepted: Bools, proposed: Level, state: Level) -> Level:
    """Return the proposal where it was accepted, elsewhere the previous state."""
    column = accepted[:, np.newaxis]
    return Level(
        np.where(column, proposed.points, state.points),
        np.where(column, proposed.keys, state.keys),
        np.where(accepted, proposed.near, state.near),
    )


def joined(parts: list[Level]) -> Level:
    return Level(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.keys for part in parts]),
        np.concatenate([part.near for part in parts]),
    )
