"""Places in the box of a search: genomes sampled in it, the box as a unit cube for methods with distances and
directions, and the base class of these methods.

Four methods fill the box without learning from results. The random baseline draws independently and uniformly, as many
individuals as the search that it is compared with. Sobol, Halton and Latin hypercubes cover the box more evenly than
chance: Owen (1998), "Scrambling Sobol' and Niederreiter-Xing points"; Owen (2017), "A randomized Halton algorithm in
R"; McKay, Beckman and Conover (1979), "A comparison of three methods for selecting values of input variables".
"""

import warnings
from collections.abc import Sequence
from math import floor
from typing import Any

import numpy as np
from numpy.random import Generator, default_rng

from engine.search.protocol import Birth, Box, GenerationSearcher, Genome, Operator, Proposal, StreamAt
from engine.tables import Floats
from engine.vocabulary import GeneKind


class Cube:
    """Map between points of [0, 1]^d and genomes of a box. A discrete gene has an equal slice of its axis per value."""

    def __init__(self, box: Box) -> None:
        self.size = len(box)
        self._low, high = np.array(box.low), np.array(box.high)
        self._discrete = np.array([kind is not GeneKind.CONTINUOUS for kind in box.kinds], dtype=bool)
        self._span = high - self._low
        self._values = np.where(self._discrete, self._span + 1.0, 1.0)

    @property
    def discrete(self) -> np.ndarray:
        """Return (d,) True for genes with whole numbers only."""
        return self._discrete

    def values(self, gene: int) -> int:
        """Return the number of values of a discrete gene."""
        return int(self._values[gene])

    def genomes(self, points: Floats) -> list[Genome]:
        """Return one genome for each row of points (n, d); points outside count as the nearest inside."""
        inside = np.clip(points, 0.0, 1.0)
        slices = np.minimum(np.floor(inside * self._values), self._values - 1.0)
        steps = np.where(self._discrete, slices, inside * self._span)
        return list(map(tuple, np.minimum(self._low + steps, self._low + self._span).tolist()))

    def point(self, genome: Sequence[float]) -> Floats:
        """Return (d,) the point of a genome; a discrete value is the middle of its slice, a one-value range 0.5."""
        offset = np.asarray(genome) - self._low
        width = np.where(self._span > 0.0, self._span, 1.0)
        continuous = np.where(self._span > 0.0, offset / width, 0.5)
        return np.where(self._discrete, (offset + 0.5) / self._values, continuous)


class InCube(GenerationSearcher):
    """A searcher in the cube."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(population, streams)
        self._cube = Cube(box)

    def _at(self, points: Floats, operator: Operator) -> list[Proposal]:
        """Return one individual per point (d,), all born now of the same operator and without parents."""
        return [
            Proposal(genome, operator, Birth(self._generation, slot))
            for slot, genome in enumerate(self._cube.genomes(points))
        ]


def pick(stream: Generator, count: int) -> int:
    """Return a whole number, uniform in 0 .. count - 1."""
    return int(stream.random() * count)


def draw_gene(stream: Generator, box: Box, gene: int) -> float:
    """Return a value of one gene, uniform in its range; a discrete gene is uniform over its whole numbers."""
    low, high = box.low[gene], box.high[gene]
    if box.kinds[gene] is GeneKind.CONTINUOUS:
        return min(low + stream.random() * (high - low), high)
    return low + floor(stream.random() * (high - low + 1.0))


def draw_genome(stream: Generator, box: Box) -> Genome:
    """Return a genome, uniform over the box."""
    return tuple(draw_gene(stream, box, gene) for gene in range(len(box)))


def reflected(point: np.ndarray) -> np.ndarray:
    """Return a point reflected into the unit cube at its faces."""
    folded = np.mod(point, 2.0)
    return np.where(folded > 1.0, 2.0 - folded, folded)


# -- methods that fill the box without learning ------------------------------------------------------------------------


class RandomSearch(GenerationSearcher):
    """Learns nothing from results, be they valid, invalid or failed."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(population, streams)
        self._box = box

    def _proposals(self) -> list[Proposal]:
        births = [Birth(self._generation, slot) for slot in range(self._population)]
        return [Proposal(draw_genome(self._streams(*birth), self._box), Operator.RANDOM, birth) for birth in births]


SEQUENCES = {"sobol": "Sobol", "halton": "Halton", "lhs": "LatinHypercube"}
"""Method and its class in `scipy.stats.qmc`."""


class QuasiRandom(InCube):
    """Quasi-random points; results, be they valid, invalid or failed, have no influence.

    Sobol and Halton continue from generation to generation; each generation of `lhs` is a new Latin hypercube.
    """

    def __init__(self, box: Box, population: int, streams: StreamAt, sequence: str) -> None:
        from scipy.stats import qmc

        super().__init__(box, population, streams)
        # scipy spawns generators from this one, which requires a seeded generator.
        seeded = default_rng(streams(0, 0).integers(1 << 63))
        self._points: Any = getattr(qmc, SEQUENCES[sequence])(d=max(1, len(box)), rng=seeded)

    def _proposals(self) -> list[Proposal]:
        with warnings.catch_warnings():
            # Sobol points are balanced for powers of two only; a different population is still spread evenly.
            warnings.simplefilter("ignore", UserWarning)
            points = self._points.random(self._population)[:, : self._cube.size]
        return self._at(points, Operator.RANDOM)
