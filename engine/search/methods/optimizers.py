"""Textbook optimizers: the cross-entropy method and differential evolution.

Cross-entropy: a distribution over the box that moves towards the riskiest tenth of its draws. Rubinstein and Kroese
(2004), "The Cross-Entropy Method". Continuous genes are normal on the unit interval, cut off at its ends; discrete
genes have a probability for each value. New estimates are mixed with the old ones (smoothing), and neither a deviation
nor a probability falls below a floor, so that the distribution never becomes a point.

Differential evolution, DE/rand/1/bin: the difference of two members, added to a third, crossed with a fourth. Storn and
Price (1997), "Differential evolution: a simple and efficient heuristic for global optimization over continuous spaces";
F = 0.5 and CR = 0.9 are their first suggestion.
"""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from engine.search.methods.cube import InCube, reflected
from engine.search.protocol import Birth, Box, Operator, Proposal, Result, StreamAt
from engine.tables import Floats

ELITE_SHARE = 0.1
SMOOTHING = 0.7
"""Weight of the new estimate."""
DEVIATION_FLOOR = 0.03
"""Minimum standard deviation, of the unit interval."""
PROBABILITY_FLOOR = 0.02


class CrossEntropy(InCube):
    """The elite contains valid results only; a generation with fewer than two of them changes nothing."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._points = np.empty((0, len(box)))
        self._mean = np.full(len(box), 0.5)
        self._deviation = np.full(len(box), 0.5)
        self._weights = {
            int(gene): np.full(self._cube.values(int(gene)), 1.0 / self._cube.values(int(gene)))
            for gene in np.flatnonzero(self._cube.discrete)
        }

    def _proposals(self) -> list[Proposal]:
        stream = self._streams(self._generation, 0)
        self._points = self._draw(stream) if self._generation else stream.random((self._population, self._cube.size))
        return self._at(self._points, Operator.SAMPLED if self._generation else Operator.RANDOM)

    def _learn(self, results: Sequence[Result]) -> None:
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
        """Return (population, d) points of the distribution."""
        points = truncated_normal(stream, self._mean, self._deviation, self._population)
        for gene, weights in self._weights.items():
            values = stream.choice(len(weights), size=self._population, p=weights)
            points[:, gene] = (values + 0.5) / len(weights)
        return points


def _mixed(new: Floats, old: Floats) -> Floats:
    return SMOOTHING * new + (1.0 - SMOOTHING) * old


def truncated_normal(stream: Generator, mean: Floats, deviation: Floats, rows: int) -> Floats:
    """Return (rows, d) normal numbers confined to [0, 1], by inversion of one uniform number each."""
    from scipy.special import ndtr, ndtri

    low, high = ndtr((0.0 - mean) / deviation), ndtr((1.0 - mean) / deviation)
    uniform = low + stream.random((rows, len(mean))) * (high - low)
    return np.clip(mean + deviation * ndtri(uniform), 0.0, 1.0)


# -- differential evolution --------------------------------------------------------------------------------------------

WEIGHT = 0.5
CROSSOVER = 0.9


class DifferentialEvolution(InCube):
    """A trial replaces its target when it is valid and at least as risky; an invalid target yields to any trial."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._trials = np.empty((0, len(box)))
        self._members = np.empty((0, len(box)))
        self._births: list[Birth] = []
        self._value = np.full(population, -np.inf)

    def _proposals(self) -> list[Proposal]:
        rows = [self._trial(slot) for slot in range(self._population)]
        self._trials = np.array([point for point, _ in rows]).reshape(self._population, self._cube.size)
        operator = Operator.CROSSOVER if self._generation else Operator.RANDOM
        return [
            Proposal(genome, operator, Birth(self._generation, slot), parents)
            for slot, (genome, (_, parents)) in enumerate(zip(self._cube.genomes(self._trials), rows, strict=True))
        ]

    def _trial(self, slot: int) -> tuple[Floats, tuple[Birth, ...]]:
        stream = self._streams(self._generation, slot)
        if not len(self._members) or self._population < 4:
            return stream.random(self._cube.size), ()
        others = [member for member in range(self._population) if member != slot]
        base, plus, minus = (int(i) for i in stream.choice(others, size=3, replace=False))
        mutant = reflected(self._members[base] + WEIGHT * (self._members[plus] - self._members[minus]))
        crossed = stream.random(self._cube.size) < CROSSOVER
        if self._cube.size:
            crossed[int(stream.random() * self._cube.size)] = True
        return np.where(crossed, mutant, self._members[slot]), (self._births[slot], self._births[base])

    def _learn(self, results: Sequence[Result]) -> None:
        if not len(self._members):
            self._members = self._trials.copy()
            self._births = [proposal.birth for proposal in self._proposed]
        for slot, result in enumerate(results):
            value = result.continuous if result.selectable else -np.inf
            if value >= self._value[slot]:
                self._members[slot], self._value[slot] = self._trials[slot], value
                self._births[slot] = self._proposed[slot].birth
