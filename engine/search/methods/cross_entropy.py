"""The cross-entropy method: a distribution over the box that moves towards the riskiest tenth of what it drew.

Rubinstein and Kroese (2004), "The Cross-Entropy Method". Continuous genes are normal on the unit interval, cut off at
its ends; discrete genes have a probability for each value. New estimates are mixed with the old ones (smoothing), and
neither a deviation nor a probability falls below a floor, so that the distribution never becomes a point.
"""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from engine.search.methods.cube import InCube
from engine.search.protocol import Box, Operator, Proposal, Result, StreamAt, check_answer
from engine.tables import Floats

ELITE_SHARE = 0.1
SMOOTHING = 0.7
"""Weight of the new estimate."""
DEVIATION_FLOOR = 0.03
"""Of the unit interval."""
PROBABILITY_FLOOR = 0.02


class CrossEntropy(InCube):
    """Invalid and failed results are left out of the elite; a generation without two valid ones changes nothing."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._points = np.empty((0, len(box)))
        self._mean = np.full(len(box), 0.5)
        self._deviation = np.full(len(box), 0.5)
        self._weights = {
            int(gene): np.full(self._cube.values(int(gene)), 1.0 / self._cube.values(int(gene)))
            for gene in np.flatnonzero(self._cube.discrete)
        }

    def ask(self) -> list[Proposal]:
        self._generation += 1
        stream = self._streams(self._generation, 0)
        self._points = self._draw(stream) if self._generation else stream.random((self._population, self._cube.size))
        return self._propose(self._points, Operator.SAMPLED if self._generation else Operator.RANDOM)

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        ranked = sorted((i for i, r in enumerate(results) if r.selectable), key=lambda i: -results[i].continuous)
        if len(ranked) < 2:
            return
        elite = self._points[ranked[: max(2, round(ELITE_SHARE * self._population))]]
        self._mean = _mixed(elite.mean(axis=0), self._mean)
        self._deviation = np.maximum(_mixed(elite.std(axis=0), self._deviation), DEVIATION_FLOOR)
        for gene, weights in self._weights.items():
            values = np.minimum((elite[:, gene] * len(weights)).astype(int), len(weights) - 1)
            shares = np.bincount(values, minlength=len(weights)) / len(elite)
            floored = np.maximum(_mixed(shares, weights), PROBABILITY_FLOOR / len(weights))
            self._weights[gene] = floored / floored.sum()

    def _draw(self, stream: Generator) -> Floats:
        """(population, d) points of the distribution."""
        points = truncated_normal(stream, self._mean, self._deviation, self._population)
        for gene, weights in self._weights.items():
            values = stream.choice(len(weights), size=self._population, p=weights)
            points[:, gene] = (values + 0.5) / len(weights)
        return points


def _mixed(new: Floats, old: Floats) -> Floats:
    return SMOOTHING * new + (1.0 - SMOOTHING) * old


def truncated_normal(stream: Generator, mean: Floats, deviation: Floats, rows: int) -> Floats:
    """(rows, d) normal numbers confined to [0, 1], by inversion: one uniform number each."""
    from scipy.special import ndtr, ndtri

    low, high = ndtr((0.0 - mean) / deviation), ndtr((1.0 - mean) / deviation)
    uniform = low + stream.random((rows, len(mean))) * (high - low)
    return np.clip(mean + deviation * ndtri(uniform), 0.0, 1.0)
