"""Importance of genes: first-order and total Sobol' indices of the outcome of a genome, from a design of their own.

A search's evaluations are not a random sample, as the search selects for risk. These indices come from simulations of
their own, drawn from the file's distributions by a Sobol' sequence. There are three outputs: whether there is a valid
run and, given a valid run, its continuous risk and whether the ego collides.

A genome alone does not determine its run: lanes, places and all other random values of a scene are *chance*. Chance
cannot be fixed while a gene moves: the scene is the first attempt that the requirements accept, and a different genome
has different attempts accepted. So the indices are those of g(genes) = E[output | genes], the mean over chance, as
shares of the output's whole variance V; the remainder, E Var(output | genes) / V, is the share of chance. With A and B
two independent designs of n rows, A_i the design A with the column of gene i from B, and every design run twice, f and
f', under streams of its own each time:

    chance        mean((f(A) - f'(A))^2) / (2 V)
    first order   S_i  = cov(f(B), f(A_i)) / V                              what gene i explains alone
    total         ST_i = mean((f(A) - f(A_i)) (f'(A) - f'(A_i))) / (2 V)    what is left when all others are known

The first order is that of Sobol' (1993), "Sensitivity estimates for nonlinear mathematical models". The total is
Jansen's (1999), "Analysis of variance designs for model output", with a product of two differences that share no stream
in place of its square: the mean of the product is that of g, without the noise. Each mean is taken over all pairings of
the two runs.

Given validity, means are taken over the pairs of which every run is valid; genes are then no longer independent, and
indices need not add up. Intervals are percentile bootstrap intervals over the n rows: Archer, Saltelli and Sobol'
(1997), "Sensitivity measures, ANOVA-like techniques and the use of bootstrap".
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator, Philox, default_rng

from engine.assessment import Evaluate
from engine.outcomes import Assessment
from engine.portable import product
from engine.program import ParamSpace
from engine.search.statistics import Interval
from engine.streams import key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Method, Verdict

TWICE = 2
"""Runs of every design, each under streams of its own."""
RESAMPLES = 1000
"""Number of bootstrap resamples; a large design has fewer, so that they fit into memory."""
MOST_NUMBERS = 8_000_000
BLOCK = 4096
SALTELLI_RUN = 0xFFFF
"""Number of the run in the stream keys of these simulations: no search and no estimate has it."""


@dataclass(frozen=True)
class Share:
    """Share of the variance of an output; NaN if the output does not vary. An estimate may be negative."""

    value: float
    interval: Interval


@dataclass(frozen=True)
class GeneIndex:
    """Sensitivity indices of one gene for one output."""

    name: str
    first: Share
    total: Share


@dataclass(frozen=True)
class Indices:
    """Sensitivity indices of one output."""

    genes: tuple[GeneIndex, ...]
    """Indices of the genes, in the order of the file."""
    chance: Share
    """Share of the variance that the genes do not explain: lanes, places and all other random values of a scene."""


@dataclass(frozen=True)
class Sensitivity:
    """Indices of each output."""

    validity: Indices
    """Indices of the output: does a genome have a valid run?"""
    risk: Indices
    """Indices of the continuous risk, given a valid run."""
    collision: Indices
    """Indices of the output: does the ego collide, given a valid run?"""
    rows: int
    """n of the design."""
    simulations: int
    """2 n (genes + 2)."""
    valid_share: float
    """Share of the simulations that are valid."""
    collision_share: float
    """Share of the valid simulations in which the ego collides; NaN without a valid one."""


def sensitivity(
    space: ParamSpace, evaluate: Evaluate, simulations: int = 20_000, seed: int = 0, level: float = 0.95
) -> Sensitivity:
    """Return the indices from at most `simulations` runs; rows: the largest power of two, at least 32."""
    designs = len(space) + 2
    rows = max(32, 1 << int(math.log2(max(simulations / (TWICE * designs), 1.0))))
    runs = _run(space, evaluate, *_designs(space, rows, seed))
    shape = designs, TWICE, rows
    valid = (runs.verdict == Verdict.VALID).reshape(shape)
    allowed = valid | (runs.verdict == Verdict.CONTROLLER).reshape(shape)  # a failed driver means that a scene exists
    collided = runs.collided.reshape(shape) & valid
    weights = _resampled(rows, seed)

    def indices(output: Floats, known: Bools) -> Indices:
        return _indices(space.names, output, known, weights, level)

    return Sensitivity(
        validity=indices(allowed.astype(np.float64), np.ones(shape, dtype=bool)),
        risk=indices(runs.continuous.reshape(shape), valid),
        collision=indices(collided.astype(np.float64), valid),
        rows=rows,
        simulations=len(runs),
        valid_share=float(valid.mean()),
        collision_share=float(collided.sum() / valid.sum()) if valid.any() else math.nan,
    )


def _designs(space: ParamSpace, rows: int, seed: int) -> tuple[Floats, Ints]:
    """Return uniform numbers (m, d) and stream keys (m, 6) of A, B, and A with each gene in turn from B; each twice."""
    from scipy.stats.qmc import Sobol

    d = len(space)
    points = Sobol(2 * d, rng=default_rng(seed)).random(rows) if d else np.zeros((rows, 0))
    first, second = points[:, :d], points[:, d:]
    designs = [first, second]
    for gene in range(d):
        mixed = first.copy()
        mixed[:, gene] = second[:, gene]
        designs.append(mixed)
    keys = [
        key_rows(seed, int(Method.SAMPLE), SALTELLI_RUN, design, range(rows), rollout)
        for design in range(d + 2)
        for rollout in range(TWICE)
    ]
    return np.concatenate([design for design in designs for _ in range(TWICE)]), np.concatenate(keys)


def _run(space: ParamSpace, evaluate: Evaluate, uniforms: Floats, keys: Ints) -> Assessment:
    from engine.assessment import concatenate
    from engine.sampling import from_uniforms

    genomes = from_uniforms(space, np.clip(uniforms, 0.0, np.nextafter(1.0, 0.0)))
    blocks = [slice(start, start + BLOCK) for start in range(0, len(keys), BLOCK)]
    return concatenate([evaluate(genomes[block], keys[block]) for block in blocks])


def _resampled(rows: int, seed: int) -> Floats:
    """Return (resamples + 1, n) the weight of each row: 1 in the first resample, then its bootstrap count."""
    resamples = max(100, min(RESAMPLES, MOST_NUMBERS // rows))
    cells = Generator(Philox(seed)).integers(rows, size=(resamples, rows)) + rows * np.arange(resamples)[:, np.newaxis]
    drawn = np.bincount(cells.ravel(), minlength=resamples * rows).reshape(resamples, rows)
    return np.concatenate([np.ones((1, rows)), drawn.astype(np.float64)])


def _indices(names: tuple[str, ...], output: Floats, known: Bools, weights: Floats, level: float) -> Indices:
    """Return the indices of an output (designs, 2, n) for A, B and each A_i; `known` marks its valid values."""
    centre = output[:2][known[:2]].mean() if known[:2].any() else 0.0
    # Values are centred on their mean: the limit is the same, and the products have less noise.
    values, counts = np.where(known, output - centre, 0.0), known.astype(np.float64)
    means = [*_moments(values[:2], counts[:2]), _chance(values[:2], counts[:2])]
    for gene in range(2, len(values)):
        means += [*_products(values[[1, gene]], counts[[1, gene]]), _total(values[[0, gene]], counts[[0, gene]])]
    mean, square, chance, *rest = _weighted(means, weights)
    variance = square - mean**2
    genes: list[GeneIndex] = []
    for gene, name in enumerate(names):
        product, first, second, total = rest[4 * gene : 4 * gene + 4]
        alone = _share(product - first * second, variance, level)
        genes.append(GeneIndex(name, alone, _share(total, variance, level)))
    return Indices(tuple(genes), _share(chance, variance, level))


# Means over the rows, each as sums (n,) and counts (n,). They are computed from two designs: values (2, 2, n), 0 where
# unknown, and counts, 1 where known.

Mean = tuple[Floats, Floats]


def _moments(values: Floats, counts: Floats) -> tuple[Mean, Mean]:
    """Return the mean and the mean square of A and B together."""
    known = counts.sum(axis=(0, 1))
    return (values.sum(axis=(0, 1)), known), ((values**2).sum(axis=(0, 1)), known)


def _chance(values: Floats, counts: Floats) -> Mean:
    """Return E Var(output | genes): half the squared difference between two runs of one genome."""
    both = counts.prod(axis=1)
    return (both * (values[:, 0] - values[:, 1]) ** 2 / 2.0).sum(axis=0), both.sum(axis=0)


def _products(values: Floats, counts: Floats) -> tuple[Mean, Mean, Mean]:
    """Return the three means for the covariance of B and A_i, which share gene i alone, over four pairings of runs."""
    (b, mixed), (known_b, known_mixed) = values.sum(axis=1), counts.sum(axis=1)
    pairs = known_b * known_mixed
    return (b * mixed, pairs), (b * known_mixed, pairs), (known_b * mixed, pairs)


def _total(values: Floats, counts: Floats) -> Mean:
    """Return half the product of two differences between A and A_i, over both pairings with four known runs."""
    (a, again), (mixed, mixed_again) = values
    known = counts.prod(axis=(0, 1))
    products = a * again + mixed * mixed_again - (a + again) * (mixed + mixed_again) / 2.0
    return known * products / 2.0, known


def _weighted(means: list[Mean], weights: Floats) -> list[Floats]:
    """Return each mean (m,) under each of the weights (m, n); NaN where its count is 0."""
    sums = product(weights, np.stack([column for mean in means for column in mean], axis=1))
    parts, wholes = sums[:, ::2], sums[:, 1::2]
    return list(np.divide(parts, wholes, out=np.full(parts.shape, np.nan), where=wholes > 0.0).T)


def _share(parts: Floats, variances: Floats, level: float) -> Share:
    """Return the share of the original rows (the first), with the interval of the resampled rows (all others)."""
    varying = variances > 1e-12 * max(1.0, float(np.nanmax(variances, initial=0.0)))
    shares = np.divide(parts, variances, out=np.full(len(parts), np.nan), where=varying)
    drawn = shares[1:][np.isfinite(shares[1:])]
    if not (len(drawn) and np.isfinite(shares[0])):
        return Share(math.nan, Interval(math.nan, math.nan))
    tail = (1.0 - level) / 2.0
    low, high = np.quantile(drawn, [tail, 1.0 - tail])
    return Share(float(shares[0]), Interval(float(low), float(high)))
