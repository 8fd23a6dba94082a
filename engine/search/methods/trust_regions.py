"""Trust regions with a local model each, which restart where a different kind of run is promising.

    archive = everything that was run
    for each region, every generation
        a Gaussian process on what is known about its centre, the best run in it
        candidates in its box; each place of the generation draws a value for all of them, and runs the best
        the box doubles when a better run is found, else it halves
        too small a box, or failures enough: the region starts again, from a good run of a kind seldom started from

A rare failure requires several params to agree to within a few percent. Far away from it the objective shows by how
much a run missed; a model of a hundred runs nearby gains more from that than differences of two runs. One region finds
one failure; so there are several regions, and a new one starts at a run of a different kind: the direction from which
the other actor came, and which of both moved.

Sources of the parts: trust regions by Gaussian processes with Thompson sampling, Eriksson, Pearce, Gardner, Turner and
Poloczek (2019), "Scalable global optimization via local Bayesian optimization", NeurIPS (TuRBO), with the same lengths,
box shapes and few moved genes, and independent instead of joint samples of the candidates.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from numpy.random import Generator

from engine.portable import exp, log
from engine.search.methods.best_first import sector_of
from engine.search.methods.cube import InCube
from engine.search.methods.gaussian_process import likelihood, predicted
from engine.search.protocol import Birth, Box, Operator, Proposal, Result, StreamAt, measure
from engine.tables import Floats, Ints

REGIONS = 5
EXPLORING = 0.1
"""Share of a generation that is run at random, from which later regions start."""
WIDE, WIDEST, NARROW = 0.4, 0.8, 0.4 * 0.5**6
"""Sides of a box, of the unit cube: first, largest, and smallest before a region ends."""
ENOUGH = 20
"""Failures after which a region ends."""
KNOWN = 100
"""Runs nearest to the centre, of which a model is made."""
CANDIDATES = 400
MOVED = 20
"""Genes that a candidate moves, about."""
LENGTH, SHORTEST, LONGEST = 0.5, 0.05, 4.0
"""Correlation lengths of a model in each gene, of the unit cube: first, and limits."""
NOISE = 0.05
"""Share of the variance that no gene explains."""
TRIALS = 4
"""Changes of lengths that a model tries in a generation."""
SEEN = 0.15
"""Cost of a start for each earlier start of the same kind, in shares of all runs that are better."""
NEAR = 0.1
"""Nearer to an earlier centre than this, in every gene, no region starts."""
STANDING = 0.5
"""Speed below which an actor counts as standing [m/s]."""

Kind = tuple[int, bool, bool]


@dataclass
class Region:
    """One box around the best run in it."""

    centre: Floats
    best: float
    kind: Kind
    lengths: Floats
    side: float = WIDE
    failures: int = 0
    slots: list[int] = field(default_factory=list)
    """Its places in the last generation that was proposed."""

    @property
    def is_over(self) -> bool:
        return self.side < NARROW or self.failures >= ENOUGH


class TrustRegions(InCube):
    """Invalid and failed results improve no region and enter no model."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._points = np.empty((0, len(box)))
        self._archive = np.empty((0, len(box)))
        self._value = np.empty(0)
        self._kinds: list[Kind] = []
        self._regions: list[Region] = []
        self._started: list[Region] = []

    def _proposals(self) -> list[Proposal]:
        stream = self._streams(self._generation, 0)
        self._points = stream.random((self._population, self._cube.size))
        moved = np.zeros(self._population, dtype=bool)
        if len(self._value) and self._cube.size:
            self._start_regions(stream)
            places = np.array_split(np.arange(ceil(EXPLORING * self._population), self._population), REGIONS)
            for region, slots in zip(self._regions, places, strict=False):
                region.slots = slots.tolist()
                moved[slots] = True
                self._points[slots] = self._chosen(region, len(slots), stream)
        return [
            Proposal(genome, Operator.SAMPLED if learnt else Operator.RANDOM, Birth(self._generation, slot))
            for slot, (genome, learnt) in enumerate(zip(self._cube.genomes(self._points), moved.tolist(), strict=True))
        ]

    def _learn(self, results: Sequence[Result]) -> None:
        known = [slot for slot, result in enumerate(results) if result.selectable]
        self._archive = np.concatenate([self._archive, self._points[known]])
        self._value = np.append(self._value, [results[slot].continuous for slot in known])
        self._kinds += [kind_of(results[slot]) for slot in known]
        for region in self._regions:
            reported = [(results[slot].continuous, slot) for slot in region.slots if results[slot].selectable]
            region.failures += sum(results[slot].failure for slot in region.slots)
            best, slot = max(reported, default=(-np.inf, -1))
            if best > region.best:
                region.best, region.centre = best, self._points[slot]
                region.side = min(WIDEST, 2.0 * region.side)
            else:
                region.side *= 0.5
            region.slots = []

    # -- where to start

    def _start_regions(self, stream: Generator) -> None:
        self._regions = [region for region in self._regions if not region.is_over]
        while len(self._regions) < REGIONS:
            row = self._start(stream)
            lengths = np.full(self._cube.size, LENGTH)
            region = Region(self._archive[row], float(self._value[row]), self._kinds[row], lengths)
            self._regions.append(region)
            self._started.append(region)

    def _start(self, stream: Generator) -> int:
        """Return the row of the run to start from: good, of a kind with few starts, and not near an earlier start."""
        order = np.argsort(self._value + 0.0, kind="stable")
        promise = np.empty(len(order))
        promise[order] = np.arange(len(order)) / len(order)
        times = Counter(region.kind for region in self._started)
        promise -= SEEN * np.array([times[kind] for kind in self._kinds])
        for region in self._started:
            promise[np.abs(self._archive - region.centre).max(axis=1) < NEAR] -= len(self._started)
        return int(np.argmax(promise + 1e-6 * stream.random(len(promise))))

    # -- what to run

    def _chosen(self, region: Region, count: int, stream: Generator) -> Floats:
        """Return (count, d) candidates; each is the best under an independent sample of the model."""
        nearest = np.argsort(np.abs(self._archive - region.centre).max(axis=1), kind="stable")[:KNOWN]
        points, values = self._archive[nearest], normal_scores(self._value[nearest])
        region.lengths = fitted(points, values, region.lengths, stream)
        candidates = _candidates(region, stream)
        mean, deviation = predicted(points, values, region.lengths, NOISE, candidates)
        rows: list[int] = []
        for _ in range(count):
            sampled = mean + deviation * stream.standard_normal(len(mean))
            sampled[rows] = -np.inf
            rows.append(int(np.argmax(sampled)))
        return candidates[rows]


def kind_of(result: Result) -> Kind:
    """Return the direction of the other actor at the closest approach, and for each of both whether it moved."""
    return sector_of(result), measure(result, "ego_speed") > STANDING, measure(result, "other_speed") > STANDING


def _candidates(region: Region, stream: Generator) -> Floats:
    """Return (CANDIDATES, d) points of a region's box, which is longer in genes with a longer correlation length."""
    size = len(region.centre)
    shape = region.lengths / exp(log(region.lengths).mean())
    step = region.side * shape * (stream.random((CANDIDATES, size)) - 0.5)
    moved = stream.random((CANDIDATES, size)) < min(1.0, MOVED / size)
    moved[np.arange(CANDIDATES), stream.integers(size, size=CANDIDATES)] = True
    return np.clip(region.centre + step * moved, 0.0, 1.0)


# -- the model ---------------------------------------------------------------------------------------------------------


def normal_scores(values: Floats) -> Floats:
    """Return (n,) normal scores by rank, so that outliers do not distort a model. Equal values have one score."""
    from scipy.special import ndtri

    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    middle = np.cumsum(counts) - 0.5 * counts
    return np.asarray(ndtri(middle[place] / len(values)))


def fitted(points: Floats, values: Floats, lengths: Floats, stream: Generator) -> Floats:
    """Return lengths that explain the values better than `lengths`, if one of a few changes does; else `lengths`."""
    best = likelihood(points, values, lengths, NOISE)
    for genes in _subsets(len(lengths), stream):
        for factor in (0.5, 2.0):
            tried = lengths.copy()
            tried[genes] = np.clip(tried[genes] * factor, SHORTEST, LONGEST)
            fit = likelihood(points, values, tried, NOISE)
            if fit > best:
                best, lengths = fit, tried
                break
    return lengths


def _subsets(size: int, stream: Generator) -> list[Ints]:
    """Return index arrays: all genes, then single ones."""
    return [np.arange(size), *(np.array([gene]) for gene in stream.integers(size, size=TRIALS).tolist())]
