"""Genomes drawn from a part of the space of the params, by the file's own distributions, and the probability of that
part.
"""

import numpy as np

from engine.program import ParamSpace
from engine.sampling import from_uniforms, uniforms_of
from engine.tables import Floats, Ints
from engine.vocabulary import Distribution, GeneKind

MARGIN = 1e-9
"""Width by which a part is enlarged in uniform numbers, so that rounding cuts nothing off."""


def quantiles_of(space: ParamSpace, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return (n, genes) ends of the uniform numbers that the genes of boxes (n, genes; file units) come from."""
    below, above = np.zeros(low.shape), np.ones(high.shape)
    for gene in range(len(space)):
        below[:, gene] = _share_below(space, gene, low[:, gene], inclusive=False)
        above[:, gene] = _share_below(space, gene, high[:, gene], inclusive=True)
    return np.clip(below - MARGIN, 0.0, 1.0), np.clip(above + MARGIN, 0.0, 1.0)


def _share_below(space: ParamSpace, gene: int, value: Floats, *, inclusive: bool) -> Floats:
    """Return the probability of a gene below each value, of a discrete one with the value itself if `inclusive`."""
    low, high = float(space.low[gene]), float(space.high[gene])
    match Distribution(space.distribution[gene]):
        case Distribution.DISCRETE:
            shares = np.concatenate([[0.0], np.cumsum(space.weights[gene]) / np.sum(space.weights[gene])])
            place = np.clip(value - low + inclusive, 0, len(shares) - 1).astype(np.int64)
            return shares[place]
        case Distribution.UNIFORM if space.kinds[gene] != GeneKind.CONTINUOUS:
            return (value - low + inclusive) / (high - low + 1.0)
        case Distribution.UNIFORM:
            return (value - low) / (high - low) if high > low else np.full(len(value), float(inclusive))
        case _:
            from scipy.special import ndtr

            mean, deviation = space.shape[gene]
            ends = np.asarray(ndtr((np.concatenate([[low, high], value]) - mean) / deviation), dtype=np.float64)
            first, last, here = ends[0], ends[1], ends[2:]
            return (here - first) / (last - first) if last > first else np.full(len(value), float(inclusive))


def genomes_between(space: ParamSpace, keys: Ints, below: Floats, above: Floats) -> Floats:
    """Return (n, genes) genomes, file units, between the ends (m, genes; uniform numbers), whose rows take turns."""
    turn = np.arange(len(keys)) % len(below)
    uniforms = below[turn] + uniforms_of(space, keys) * (above - below)[turn]
    return from_uniforms(space, np.minimum(uniforms, np.nextafter(1.0, 0.0)))
