"""Methods that fill the box without learning from results.

The random baseline draws independently and uniformly, as many individuals as the search that it is compared with.
Sobol, Halton and Latin hypercubes cover the box more evenly than chance: Owen (1998), "Scrambling Sobol' and
Niederreiter-Xing points"; Owen (2017), "A randomized Halton algorithm in R"; McKay, Beckman and Conover (1979), "A
comparison of three methods for selecting values of input variables".
"""

import warnings
from typing import Any

from numpy.random import default_rng

from engine.search.methods.cube import InCube, draw_genome
from engine.search.protocol import Birth, Box, GenerationSearcher, Operator, Proposal, StreamAt


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
