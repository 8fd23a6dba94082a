"""Levels of runs that come ever nearer to a failure: where failures are, and how rare, if the score leads there.

Au and Beck (2001), "Estimation of small failure probabilities in high dimensions by subset simulation": of each level's
runs the nearest tenth are the seeds of chains in which no run is farther than they are. The chains' proposals are
those of Papaioannou, Betz, Zwirglmaier and Straub (2015), "MCMC algorithms for subset simulation", section 4.4: every
gene, as a standard normal number, is drawn a step towards its prior; and in every other step the scene's own random
numbers are drawn again.

A score leads nowhere on a plateau, where many different runs are exactly as near as the threshold: of these a level
cannot take the nearest tenth, and within them chains wander without a direction.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from engine.program import ParamSpace
from engine.search.assessment import Evaluate
from engine.search.probability.estimates import Count, Judge, Withheld
from engine.search.probability.scores import Score, nearness
from engine.streams import key_rows, operator_generator
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Method, Verdict

SHARE = 0.1
"""Of a level's runs that are the seeds of the next."""
TIED = SHARE / 2.0
"""Of a level's runs that are different and exactly at its threshold: with more of them it is a plateau."""
STEP = 0.6
"""Of a chain, in standard deviations: sqrt(1 - rho^2) with rho = 0.8."""
MOST_LEVELS = 12
TRIES = 50
"""Blocks without enough valid runs after which a level cannot be filled."""


@dataclass(frozen=True)
class Level:
    """Valid runs, rows aligned: where their genes lie in standard normal space, their keys, how near they came."""

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
    """One way up the levels: where its random numbers come from, and what it has spent.

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
        """A new stream for the next block."""
        self.step += 1
        return operator_generator(self.seed, int(Method.SAMPLE), self.run, self.step)

    def keys(self, count: int, first: int = 0) -> Ints:
        """New stream keys for scenes, of this block."""
        return key_rows(self.seed, int(Method.SAMPLE), self.run, self.step, range(first, first + count))

    def simulate(self, points: Floats, keys: Ints) -> tuple[Level, Bools]:
        """What became of these scenes, and which of them are valid."""
        runs = self.evaluate(self.genomes(points), keys)
        self.count = self.count.more(runs)
        return Level(points, keys, nearness(self.score, runs)), runs.verdict == Verdict.VALID

    def genomes(self, points: Floats) -> Floats:
        """Of standard normal numbers, under the file's distributions."""
        from scipy.special import ndtr

        from engine.sampling import from_uniforms

        return from_uniforms(self.space, np.clip(ndtr(points), 0.0, np.nextafter(1.0, 0.0)))

    def avoided(self, level: Level) -> Bools:
        """(n,) whether the reference driver avoids what happened in each of these runs."""
        assert self.judge is not None
        self.driven += len(level.keys)
        return self.judge(self.genomes(level.points), level.keys)


class Climb(NamedTuple):
    """Of one way up."""

    value: float
    """Estimated probability of a failure, given a valid run; NaN where valid runs are too rare to begin with."""
    thresholds: tuple[float, ...]
    """What was left to a failure where each level stopped over; 0 stands for a failure."""
    last: Level | None
    withheld: Withheld = Withheld.NOTHING
    tied: float = 0.0
    """Share of a level's runs that lie on a plateau."""


def climb(chains: Chains, size: int) -> Climb:
    """Levels of `size` runs, up to one of which a tenth are failures."""
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
    """Share of a level's runs that are different ones and exactly at the threshold: a chain that stays repeats one."""
    rows = np.flatnonzero(level.near == threshold)
    if len(rows) <= TIED * size_of(level):
        return 0.0
    different = np.unique(np.column_stack([level.points[rows], level.keys[rows]]), axis=0)
    return len(different) / size_of(level)


def _first_level(chains: Chains, size: int) -> Level | None:
    """`size` valid runs under the file's distributions."""
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
    """Runs no farther than the threshold: chains from the seeds, all of them a step at a time."""
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
    """The proposal where it was accepted, else the state again."""
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
