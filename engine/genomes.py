"""Genomes from stream keys: from the genes' own distributions (plain runs), or uniform over the search's box."""

import numpy as np

from engine.kernels.gene import truncated_normals
from engine.kernels.philox import GENE_CHANNEL, fill_uniform
from engine.program import ParamSpace
from engine.streams import check_keys
from engine.tables import Floats, Ints
from engine.vocabulary import Distribution, GeneKind, Purpose


def draw_genomes(space: ParamSpace, keys: Ints) -> Floats:
    """(n, d) gene values in file units, each from its own distribution; row i depends on key i alone."""
    return from_uniforms(space, _uniforms(space, keys))


def from_uniforms(space: ParamSpace, uniforms: Floats) -> Floats:
    """(n, d) gene values in file units: each gene's quantile, under its own distribution, at a number of [0, 1)."""
    genomes = np.empty_like(uniforms)
    for gene in range(len(space)):
        genomes[:, gene] = _from_distribution(space, gene, uniforms[:, gene])
    return genomes


def uniform_genomes(space: ParamSpace, keys: Ints) -> Floats:
    """(n, d) gene values in file units, uniform over the box of the search; row i depends on key i alone."""
    genomes = _uniforms(space, keys)
    for gene in range(len(space)):
        genomes[:, gene] = _from_box(space, gene, genomes[:, gene])
    return genomes


def _uniforms(space: ParamSpace, keys: Ints) -> Floats:
    check_keys(keys)
    uniforms = np.empty((len(keys), len(space)))
    fill_uniform(keys, int(Purpose.SCENE), GENE_CHANNEL, uniforms)
    return uniforms


def _from_distribution(space: ParamSpace, gene: int, uniforms: Floats) -> Floats:
    match Distribution(space.distribution[gene]):
        case Distribution.UNIFORM:
            return _from_box(space, gene, uniforms)
        case Distribution.NORMAL | Distribution.TRUNCATED_NORMAL:
            values = np.empty(len(uniforms))
            mean, deviation = space.shape[gene]
            truncated_normals(
                np.ascontiguousarray(uniforms), space.low[gene], space.high[gene], mean, deviation, values
            )
            return values
        case Distribution.DISCRETE:
            return space.low[gene] + _pick(space.weights[gene], uniforms)


def _from_box(space: ParamSpace, gene: int, uniforms: Floats) -> Floats:
    low, high = space.low[gene], space.high[gene]
    if space.kinds[gene] == GeneKind.CONTINUOUS:
        return np.minimum(low + uniforms * (high - low), high)
    return low + np.floor(uniforms * (high - low + 1.0))


def _pick(weights: tuple[float, ...], uniforms: Floats) -> Floats:
    """Index of the weight whose share of [0, 1) holds each uniform number; weightless options are never picked."""
    cumulative = np.cumsum(weights) / np.sum(weights)
    last = np.flatnonzero(weights)[-1]
    return np.minimum(np.searchsorted(cumulative, uniforms, side="right"), last).astype(np.float64)
