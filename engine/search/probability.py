"""How probable a collision is under the file's own distributions, given a valid scene.

Params are drawn as the file says, then a scene under its requirements. Draws that allow no valid scene, and runs that
a requirement on the run makes invalid, are conditioned out: every figure is a probability *given* a valid run.

Two estimators:

- `monte_carlo`: independent draws; the share of collisions with the exact interval of Clopper and Pearson (1934), "The
  use of confidence or fiducial limits illustrated in the case of the binomial".
- `subset_simulation`, for what is rare: a small probability as a product of larger ones. Au and Beck (2001),
  "Estimation of small failure probabilities in high dimensions by subset simulation". The levels are least distances
  (MD): of each level's runs the nearest tenth are the seeds of chains in which no run is farther than they are. The
  chains' proposals are those of Papaioannou, Betz, Zwirglmaier and Straub (2015), "MCMC algorithms for subset
  simulation", sections 4.4: every gene, as a standard normal number, is drawn a step towards its prior; and in every
  other step the scene's own random numbers are drawn anew.

Within a chain runs are dependent. The variance is therefore taken from outside: the whole estimate is made ten times,
independently; the mean is the estimate, and its interval is Student's with nine degrees of freedom.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from engine.config import Config
from engine.program import ParamSpace, Program
from engine.search.assessment import Assessment, Evaluate, concatenate, take
from engine.search.statistics import Interval, clopper_pearson
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
BLOCK = 4096
"""Draws that are simulated together."""
TRIES = 50
"""Blocks without enough valid runs after which a level cannot be filled."""

Genomes = Callable[[Floats], Floats]
"""Uniform numbers (n, d) to genomes (n, d) under the file's distributions."""


@dataclass(frozen=True)
class Probability:
    """An estimate of P(collision | valid run)."""

    method: str
    """`mc` or `subset`."""
    value: float
    interval: Interval
    """Confidence interval at `level`; NaN where none can be given."""
    level: float
    simulations: int
    """Runs that the estimate took, invalid ones included."""
    valid: int
    """Of them valid."""
    collisions: int
    """Of them with a collision; under `subset` these are not independent."""
    valid_share: float
    """Estimated probability that a draw gives a valid run."""
    aborted: int = 0
    """Of the simulations, those that a requirement on the run made invalid: they did run."""
    levels: tuple[float, ...] = ()
    """Of the first repetition: least distances at which it stopped over [m]; 0 stands for contact."""


def estimate(program: Program, config: Config, method: str, samples: int, seed: int = 0) -> Probability:
    """The probability for a program, by `mc` or `subset`, in the host that the config names."""
    from engine.risk import PAPER
    from engine.search.evaluator import make_evaluator

    evaluate = make_evaluator(program, config, PAPER)
    estimator = {"mc": monte_carlo, "subset": subset_simulation}[method]
    return estimator(program.space, evaluate, samples, seed)


def monte_carlo(space: ParamSpace, evaluate: Evaluate, samples: int, seed: int = 0, level: float = 0.95) -> Probability:
    """Plain Monte Carlo with `samples` draws."""
    from engine.genomes import draw_genomes

    valid = collisions = aborted = 0
    for start in range(0, samples, BLOCK):
        keys = key_rows(seed, int(Method.SAMPLE), 0, 0, range(start, min(samples, start + BLOCK)))
        runs = evaluate(draw_genomes(space, keys), keys)
        valid += int((runs.verdict == Verdict.VALID).sum())
        collisions += int(runs.collided.sum())
        aborted += int((runs.verdict == Verdict.ABORTED).sum())
    value = collisions / valid if valid else math.nan
    interval = clopper_pearson(collisions, valid, level)
    return Probability("mc", value, interval, level, samples, valid, collisions, valid / samples, aborted)


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
    simulations: int = 0
    valid: int = 0
    drawn: int = 0
    filled: int = 0
    collisions: int = 0
    aborted: int = 0
    step: int = 0

    def numbers(self) -> Generator:
        """A new stream for the next block."""
        self.step += 1
        return operator_generator(self.seed, int(Method.SAMPLE), self.run, self.step)

    def keys(self, count: int) -> Ints:
        """New stream keys for scenes, of this block."""
        return key_rows(self.seed, int(Method.SAMPLE), self.run, self.step, range(count))

    def simulate(self, points: Floats, keys: Ints) -> Assessment:
        from scipy.special import ndtr

        uniforms = np.clip(ndtr(points), 0.0, np.nextafter(1.0, 0.0))
        runs = self.evaluate(self.genomes(uniforms), keys)
        self.simulations += len(keys)
        self.valid += int((runs.verdict == Verdict.VALID).sum())
        self.collisions += int(runs.collided.sum())
        self.aborted += int((runs.verdict == Verdict.ABORTED).sum())
        return runs


def subset_simulation(
    space: ParamSpace, evaluate: Evaluate, samples: int, seed: int = 0, level: float = 0.95
) -> Probability:
    """Subset simulation with `samples` runs a level, shared by ten independent repetitions.

    Raises:
        ValueError: fewer than 100 runs a repetition.
    """
    from scipy.special import stdtrit

    from engine.genomes import from_uniforms

    size = samples // REPETITIONS
    if size < 100:
        raise ValueError(f"samples is {samples}; subset simulation needs at least {100 * REPETITIONS} a level")
    chains = [
        _Chain(evaluate, lambda uniforms: from_uniforms(space, uniforms), len(space), seed, repetition + 1)
        for repetition in range(REPETITIONS)
    ]
    estimates = [_estimate(chain, size) for chain in chains]
    values = np.array([value for value, _ in estimates])
    half = float(stdtrit(REPETITIONS - 1, (1.0 + level) / 2.0)) * float(values.std(ddof=1)) / math.sqrt(REPETITIONS)
    value = float(values.mean())
    known = bool(value > 0.0)
    drawn = sum(chain.drawn for chain in chains)
    return Probability(
        method="subset",
        value=value,
        interval=Interval(max(0.0, value - half), min(1.0, value + half)) if known else Interval(math.nan, math.nan),
        level=level,
        simulations=sum(chain.simulations for chain in chains),
        valid=sum(chain.valid for chain in chains),
        collisions=sum(chain.collisions for chain in chains),
        valid_share=sum(chain.filled for chain in chains) / drawn,
        aborted=sum(chain.aborted for chain in chains),
        levels=estimates[0][1],
    )


def _estimate(chain: _Chain, size: int) -> tuple[float, tuple[float, ...]]:
    """One estimate and its levels; NaN where valid runs are too rare to begin with."""
    current = _first_level(chain, size)
    if current is None:
        return math.nan, ()
    value, levels = 1.0, []
    for _ in range(MOST_LEVELS):
        distance = current.distance
        touching = float((distance == 0.0).mean())
        threshold = float(np.quantile(distance, SHARE, method="lower"))
        if touching >= SHARE or threshold == 0.0:
            return value * touching, (*levels, 0.0)
        inside = distance <= threshold
        if not math.isfinite(threshold) or (levels and threshold >= levels[-1]):
            return value * touching, tuple(levels)
        value *= float(inside.mean())
        levels.append(threshold)
        current = _next_level(chain, current.rows(np.flatnonzero(inside)), threshold, size)
    return value * float((current.distance == 0.0).mean()), tuple(levels)


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
