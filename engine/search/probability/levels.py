"""Levels of runs that approach a failure: they locate failures and estimate their probability, if the score leads
there.

Au and Beck (2001), "Estimation of small failure probabilities in high dimensions by subset simulation": the nearest
tenth of each level's runs are the seeds of chains, in which no run is farther from a failure than they are. The chains'
proposals are those of Papaioannou, Betz, Zwirglmaier and Straub (2015), "MCMC algorithms for subset simulation",
section 4.4: every gene, as a standard normal number, is drawn a step towards its prior; and in every other step the
scene's own random numbers are drawn again.

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
        drawn, valid = chains.simulate(numbers.standard_normal((count, len(chains.space))), chains.keys(count))
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
    parts = [state]
    for step in range(1, length):
        numbers = chains.numbers()
        noise = numbers.standard_normal(state.points.shape)
        points = math.sqrt(1.0 - STEP * STEP) * state.points + STEP * noise
        proposed, valid = chains.simulate(points, chains.keys(count) if step % 2 else state.keys)
        state = _chosen(valid & (proposed.near >= threshold), proposed, state)
        parts.append(state)
    return joined(parts)


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
