"""The niching genetic algorithm of cortexc: of each brood of children it runs the child that promises a *new* failure.

    archive = everything that was run
    for each place of a generation
        a brood of children: bred from failures that lie apart from others, or drawn at random
        promise of a child  = share of failures among its nearest neighbours in the archive, nearer ones counting more
        novelty of a child  = distance to the nearest failure known
        run the most novel child among those that promise enough, else the most promising

The paper's algorithm breeds only from the last generation and picks parents by risk alone: it finds failures fast, and
then the same failures repeatedly. Here the archive stores all runs, parents are picked by their distance to other
failures, and children that are surely harmless or known are never run. Distances weight each gene by its separation of
failures from the rest, so that irrelevant genes do not affect them.

Sources of the parts: preselection by known runs, Rasheed and Hirsh (2000), "Informed operators: speeding up genetic
algorithm based design optimization using reduced models"; novelty, Lehman and Stanley (2011), "Abandoning objectives";
weights of genes, Kira and Rendell (1992), "A practical approach to feature selection" (Relief).
"""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from engine.search.methods.cube import InCube, reflected
from engine.search.protocol import Birth, Box, Genome, Operator, Proposal, Result, StreamAt
from engine.tables import Bools, Floats, Ints

BROOD = 10
"""Number of children per brood; one of them is run."""
NEIGHBOURS = 8
ENOUGH = 0.9
"""Promise from which on novelty decides."""
FRESH = 0.3
"""Share of children that are drawn at random over the box."""
EXPLORING = 0.05
"""Share of a generation that is run at random, without regard to its promise."""
RIVALS = 3
"""Failures that compete, by how alone they are, to be a parent."""
STEP = 0.15
"""Standard deviation of a mutation, of the unit interval."""
MUTATED = 0.4
"""Share of genes that a mutation moves."""
NEARNESS = 0.02
"""Distance below which neighbours have equal weight."""
FEW = 20
"""Fewer failures than this are joined by the riskiest individuals so far."""
LEAST_WEIGHT = 0.1
"""Weight of a gene that does not separate failures from the rest."""
SAMPLE = 600
"""Latest individuals that the weights are learnt from."""


class NichingSearch(InCube):
    """Valid results without failure, and invalid ones, count as harmless; a failed one (an error) is ignored."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._points = np.empty((0, len(box)))
        self._archive = np.empty((0, len(box)))
        self._failed = np.empty(0, dtype=bool)
        self._targets = np.empty(0, dtype=bool)
        self._risk = np.empty(0)
        self._births: list[Birth] = []

    def _proposals(self) -> list[Proposal]:
        stream = self._streams(self._generation, 0)
        shape = self._population, self._cube.size
        parents = np.full((self._population, 2), -1)
        self._points = stream.random(shape)
        if self._targets.any() and self._cube.size:
            self._points, parents = self._bred(stream)
            exploring = round(EXPLORING * self._population)
            self._points[:exploring], parents[:exploring] = stream.random((exploring, self._cube.size)), -1
        genomes = self._cube.genomes(self._points)
        return [
            self._proposal(slot, genome, pair)
            for slot, (genome, pair) in enumerate(zip(genomes, parents.tolist(), strict=True))
        ]

    def _proposal(self, slot: int, genome: Genome, parents: Sequence[int]) -> Proposal:
        births = tuple(self._births[parent] for parent in parents if parent >= 0)
        operator = (Operator.RANDOM, Operator.MUTATION, Operator.CROSSOVER_MUTATION)[len(births)]
        return Proposal(genome, operator, Birth(self._generation, slot), births)

    def _learn(self, results: Sequence[Result]) -> None:
        known = [slot for slot, result in enumerate(results) if result.judged]
        self._archive = np.concatenate([self._archive, self._points[known]])
        self._failed = np.append(self._failed, [results[slot].failure for slot in known]).astype(bool)
        risk = [results[slot].continuous if results[slot].selectable else -np.inf for slot in known]
        self._risk = np.append(self._risk, risk)
        self._births += [self._proposed[slot].birth for slot in known]
        self._choose_parents()

    def _choose_parents(self) -> None:
        """Choose the parents: the failures, joined by the riskiest runs so far while there are few failures."""
        ranked = np.argsort(-self._risk, kind="stable")[:FEW]
        few = np.zeros(len(self._risk), dtype=bool)
        few[ranked[np.isfinite(self._risk[ranked])]] = True
        self._targets = self._failed if self._failed.sum() >= FEW else self._failed | few

    def _bred(self, stream: Generator) -> tuple[Floats, np.ndarray]:
        """Return the chosen child of every brood (population, d), and its parents (population, 2), -1 if missing."""
        failures = self._archive[self._targets]
        children, parents = self._brood(stream, failures)
        promise = self._promise(children)
        novelty = nearest(failures, children, 1)[0][:, 0]
        score = np.where(promise >= ENOUGH, 1.0 + novelty, promise).reshape(self._population, BROOD)
        chosen = np.arange(self._population) * BROOD + score.argmax(axis=1)
        rows = np.flatnonzero(self._targets)
        return children[chosen], np.where(parents[chosen] >= 0, rows[parents[chosen]], -1)

    def _brood(self, stream: Generator, failures: Floats) -> tuple[Floats, np.ndarray]:
        """Return all children: a lonely failure, half of them crossed with a second, then mutated; some are random."""
        count, size = self._population * BROOD, self._cube.size
        alone = nearest(failures, failures, 4)[0][:, -1]
        rivals = stream.integers(len(failures), size=(count, RIVALS))
        first = rivals[np.arange(count), alone[rivals].argmax(axis=1)]
        second = np.where(stream.random(count) < 0.5, stream.integers(len(failures), size=count), -1)
        from_second = (stream.random((count, size)) < 0.5) & (second >= 0)[:, np.newaxis]
        children = np.where(from_second, failures[second], failures[first])
        moved = stream.random((count, size)) < MUTATED
        moved[np.arange(count), stream.integers(size, size=count)] = True
        children = reflected(children + STEP * stream.standard_normal((count, size)) * moved)
        fresh = stream.random(count) < FRESH
        children[fresh] = stream.random((int(fresh.sum()), size))
        parents = np.stack([first, second], axis=1)
        parents[fresh] = -1
        return children, parents

    def _promise(self, children: Floats) -> Floats:
        """Return (n,) the share of failures among the nearest neighbours, each weighted by its nearness."""
        weights = gene_weights(self._archive, self._targets)
        distance, neighbour = nearest(self._archive * weights, children * weights, NEIGHBOURS)
        nearness = 1.0 / (distance + NEARNESS)
        return (nearness * self._targets[neighbour]).sum(axis=1) / nearness.sum(axis=1)


def gene_weights(points: Floats, failed: Bools) -> Floats:
    """Return (d,) the separation of failures from the rest by each gene, 1 for the best: Relief weights of the latest
    runs.

    A gene counts by the difference between its distances to the nearest runs of the other kind and of the own kind.
    """
    genes = int(points.shape[1])
    if min(failed.sum(), (~failed).sum()) < 10:
        return np.ones(genes)
    points_of = {kind: points[failed == kind] for kind in (True, False)}
    latest, kinds = points[-SAMPLE:], failed[-SAMPLE:]
    weights = np.zeros(genes)
    for kind in (True, False):
        own = latest[kinds == kind]
        if len(own):
            same = points_of[kind][nearest(points_of[kind], own, 6)[1][:, 1:]]  # the nearest is the point itself
            other = points_of[not kind][nearest(points_of[not kind], own, 5)[1]]
            weights += (np.abs(own[:, np.newaxis] - other) - np.abs(own[:, np.newaxis] - same)).mean(axis=(0, 1))
    best = weights.max()
    return np.maximum(weights / best, LEAST_WEIGHT) if best > 0.0 else np.ones(genes)


def nearest(points: Floats, queries: Floats, count: int) -> tuple[Floats, Ints]:
    """Return (n, k) distances and row numbers of the nearest points of each query; k = `count`, or the number of points
    if that is smaller.
    """
    from scipy.spatial import KDTree

    ranks = list(range(1, min(count, len(points)) + 1))
    distance, row = KDTree(points).query(queries, k=ranks)  # pyright: ignore[reportArgumentType]  # a list is documented
    return np.asarray(distance), np.asarray(row)
