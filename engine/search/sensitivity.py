"""Which genes matter: first-order and total Sobol' indices of risk and of collision, from a design of their own.

A search's evaluations are no sample: what it bred, it bred for its risk. These indices come from simulations of their
own, drawn from the file's distributions by a Sobol' sequence. With A and B two independent designs of n rows, and A_i
the design A with the column of gene i from B:

    first order   S_i  = mean(f(B) (f(A_i) - f(A))) / V       the share of the variance that gene i explains alone
    total         ST_i = mean((f(A) - f(A_i))^2) / (2 V)      the share that is lost when all but gene i are known

Saltelli, Annoni, Azzini, Campolongo, Ratto and Tarantola (2010), "Variance based sensitivity analysis of model output.
Design and estimator for the total sensitivity index", their table 2 (b) and (f), the latter Jansen's.

What a scene draws beside its genes (lanes, places) counts as one more input, `chance`. Where no valid scene exists, the
risk is the paper's -1, and there is no collision: a gene also matters by what it makes impossible. Intervals are
percentile bootstrap intervals over the n rows: Archer, Saltelli and Sobol' (1997), "Sensitivity measures, ANOVA-like
techniques and the use of bootstrap".
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator, Philox, default_rng

from engine.program import ParamSpace
from engine.search.assessment import Assessment, Evaluate
from engine.search.statistics import Interval
from engine.streams import key_rows
from engine.tables import Floats, Ints
from engine.vocabulary import Method, Verdict

CHANCE = "chance"
"""Name of what a scene draws beside its genes."""
INVALID_RISK = -1.0
RESAMPLES = 1000
"""Of the bootstrap; fewer for a large design, so that they fit into memory."""
MOST_NUMBERS = 8_000_000
BLOCK = 4096
SALTELLI_RUN = 0xFFFF
"""Number of the run in the stream keys of these simulations: no search and no estimate has it."""


@dataclass(frozen=True)
class GeneIndex:
    """One input's part in the variance of an output; NaN where that never varies."""

    name: str
    first: float
    first_interval: Interval
    total: float
    total_interval: Interval


@dataclass(frozen=True)
class Sensitivity:
    """Indices of every gene in the order of the file, and of `chance` at the end."""

    risk: tuple[GeneIndex, ...]
    """Of the continuous risk, -1 where invalid."""
    collision: tuple[GeneIndex, ...]
    """Of whether the ego collides."""
    rows: int
    """n of the design."""
    simulations: int
    """n (inputs + 2)."""
    valid_share: float
    """Of the simulations."""
    collision_share: float


def sensitivity(
    space: ParamSpace, evaluate: Evaluate, simulations: int = 20_000, seed: int = 0, level: float = 0.95
) -> Sensitivity:
    """Indices from at most so many simulations: the largest design whose rows are a power of two, at least 64."""
    inputs = len(space) + 1
    rows = max(64, 1 << int(math.log2(max(simulations / (inputs + 2), 1.0))))
    runs = _run(space, evaluate, *_designs(space, rows, seed))
    valid = runs.verdict == Verdict.VALID
    risk = np.where(valid, runs.continuous, INVALID_RISK).reshape(inputs + 2, rows)
    collided = (runs.collided & valid).astype(np.float64).reshape(inputs + 2, rows)
    names = (*space.names, CHANCE)
    return Sensitivity(
        risk=_indices(names, risk, level, seed),
        collision=_indices(names, collided, level, seed),
        rows=rows,
        simulations=len(runs),
        valid_share=float(valid.mean()),
        collision_share=float(collided.mean()),
    )


def _designs(space: ParamSpace, rows: int, seed: int) -> tuple[Floats, Ints]:
    """Uniform numbers (m, d) and stream keys (m, 6) of A, B, and A with each input in turn from B."""
    from scipy.stats.qmc import Sobol

    d = len(space)
    points = Sobol(2 * d, rng=default_rng(seed)).random(rows) if d else np.zeros((rows, 0))
    first, second = points[:, :d], points[:, d:]
    keys = [key_rows(seed, int(Method.SAMPLE), SALTELLI_RUN, half, range(rows)) for half in (0, 1)]
    uniforms, every_key = [first, second], list(keys)
    for gene in range(d):
        mixed = first.copy()
        mixed[:, gene] = second[:, gene]
        uniforms.append(mixed)
        every_key.append(keys[0])
    return np.concatenate([*uniforms, first]), np.concatenate([*every_key, keys[1]])


def _run(space: ParamSpace, evaluate: Evaluate, uniforms: Floats, keys: Ints) -> Assessment:
    from engine.genomes import from_uniforms
    from engine.search.assessment import concatenate

    genomes = from_uniforms(space, np.clip(uniforms, 0.0, np.nextafter(1.0, 0.0)))
    blocks = [slice(start, start + BLOCK) for start in range(0, len(keys), BLOCK)]
    return concatenate([evaluate(genomes[block], keys[block]) for block in blocks])


def _indices(names: tuple[str, ...], outputs: Floats, level: float, seed: int) -> tuple[GeneIndex, ...]:
    """From outputs (inputs + 2, n): of A, of B, and of A with each input in turn from B."""
    rows = outputs.shape[1]
    resamples = max(100, min(RESAMPLES, MOST_NUMBERS // rows))
    draws = Generator(Philox(seed)).integers(rows, size=(resamples, rows))
    # Both estimators take the output from its mean: the same in the limit, and less noise in the first-order ones.
    a, b = outputs[0] - outputs[:2].mean(), outputs[1] - outputs[:2].mean()
    variance, resampled = _variance(a, b), _variance(a[draws], b[draws])
    indices = []
    for name, mixed in zip(names, outputs[2:] - outputs[:2].mean(), strict=True):
        first, total = b * (mixed - a), (a - mixed) ** 2 / 2.0
        indices.append(
            GeneIndex(
                name,
                _share(first.mean(), variance),
                _interval(first[draws].mean(axis=1), resampled, level),
                _share(total.mean(), variance),
                _interval(total[draws].mean(axis=1), resampled, level),
            )
        )
    return tuple(indices)


def _variance(a: Floats, b: Floats) -> Floats:
    """Over both designs, along the last axis."""
    return np.concatenate([a, b], axis=-1).var(axis=-1)


def _share(part: float, variance: Floats) -> float:
    return float(part / variance) if variance > 0.0 else math.nan


def _interval(parts: Floats, variances: Floats, level: float) -> Interval:
    known = variances > 0.0
    if not known.any():
        return Interval(math.nan, math.nan)
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(parts[known] / variances[known], [tail, 1.0 - tail])
    return Interval(float(low), float(high))
