"""Best-first search with counts: step from the best runs, less often the more was tried near them and of their kind.

    archive = everything that was run, with the step by which it was made
    for each generation
        a part of it at random
        for each other place
            the run of largest
                log(1 / share of runs that are better) - log(1 + tries near it) - log(1 + tries of its kind)
            a child of it: some genes moved by a step, which the child draws near its parent's and keeps

A rare failure is the maximum of a slope that contains few runs, and most slopes end at a near miss. So the search
follows many slopes, each while it rises: a better child is rarer and is stepped from next; without improvement tries
add up, until a run ten times as common but tried a tenth as often precedes it. No regions are opened or closed. Runs
are of one kind if the other actor came from the same side, at similar speeds of both, so a kind at which many slopes
end soon has enough tries. A child inherits its step, so successful steps persist, from a third of the box down to the
size of a small set of failures. Failures are equally good if the objective does not separate them, so their order
depends on their tries: once there are many failures, the search spreads over them.

Sources of the parts: counts of visits against the value, Auer, Cesa-Bianchi and Fischer (2002), "Finite-time analysis
of the multiarmed bandit problem"; steps that evolve with their results, Schwefel (1981), "Numerical optimization of
computer models" (self-adaptation of evolution strategies).
"""

from collections.abc import Sequence
from functools import cache
from math import floor, isnan, pi

import numpy as np
from numpy.random import Generator

from engine.portable import exp, log, log1p
from engine.search.methods.cube import InCube, reflected
from engine.search.protocol import Birth, Box, Genome, Operator, Proposal, Result, StreamAt, measure
from engine.tables import Bools, Floats, Ints

EXPLORING = 0.4
"""Share of a generation that is run at random."""
WIDEST, NARROWEST = 0.3, 1e-4
"""Standard deviations of steps, as shares of the unit interval; random individuals have the widest."""
VARIED = 0.8
"""Standard deviation of the logarithm of a step against its parent's."""
MOVED = 4
"""Genes that a step moves, about."""
NEAR = 0.1
"""Runs that differ by less in each gene are near."""
SECTORS = 8
"""Number of sectors of the direction from which the other actor comes."""
LIKE = 2.0
"""Speeds [m/s] that a kind spans."""
NONE = -1
"""Row number of a missing second parent."""

Kind = tuple[int, int, int]


class BestFirst(InCube):
    """An invalid or failed result counts as a try and is never a parent."""

    exploring = EXPLORING

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._points, self._steps = np.empty((0, len(box))), np.empty(0)
        self._stepped_from = np.empty(0, dtype=np.int64)
        self._second = np.empty(0, dtype=np.int64)
        self._archive, self._archived_steps = np.empty((0, len(box))), np.empty(0)
        self._value, self._tries = np.empty(0), np.empty(0, dtype=np.int64)
        self._births: list[Birth] = []
        self._first = np.empty((0, len(box)))
        self._kinds: dict[Kind, int] = {}
        self._kind, self._tries_of_kind = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)

    def begin_with(self, genomes: Floats) -> None:
        """Take genomes (n, d) as individuals of the first generation, as many as it has."""
        points = [self._cube.point(genome) for genome in genomes[: self._population]]
        self._first = np.array(points).reshape(len(points), self._cube.size)

    def _proposals(self) -> list[Proposal]:
        stream = self._streams(self._generation, 0)
        self._points = stream.random((self._population, self._cube.size))
        if not self._generation:
            self._points[: len(self._first)] = self._first
        self._steps = np.full(self._population, WIDEST)
        self._stepped_from = np.empty(0, dtype=np.int64)
        if len(self._value) and self._cube.size:
            count = self._population - round(self.exploring * self._population)
            self._stepped_from = self._chosen(count)
            self._second = np.full(count, NONE)
            self._points[:count], self._steps[:count] = self._children(stream)
        return [self._proposal(slot, genome) for slot, genome in enumerate(self._cube.genomes(self._points))]

    def _proposal(self, slot: int, genome: Genome) -> Proposal:
        born = Birth(self._generation, slot)
        if slot >= len(self._stepped_from):
            return Proposal(genome, Operator.RANDOM, born)
        first, second = int(self._stepped_from[slot]), int(self._second[slot])
        if second == NONE:
            return Proposal(genome, Operator.MUTATION, born, (self._births[first],))
        return Proposal(genome, Operator.CROSSOVER, born, (self._births[first], self._births[second]))

    def _chosen(self, count: int) -> Ints:
        """Return (count,) rows of the archive to step from; each counts as a try before the next is chosen."""
        promise, rows = rarity(self._value), np.empty(count, dtype=np.int64)
        columns = np.ascontiguousarray(self._archive.T)
        for place in range(count):
            row = np.argmax(promise - log_tries(self._tries) - log_tries(self._tries_of_kind)[self._kind])
            self._tries += near(columns, self._archive[row])
            self._tries_of_kind[self._kind[row]] += 1
            rows[place] = row
        return rows

    def _children(self, stream: Generator) -> tuple[Floats, Floats]:
        """Return (n, d) a child of each row in `_stepped_from`, and (n,) its steps, from which its own children draw
        theirs.
        """
        rows, size = self._stepped_from, self._cube.size
        varied = self._archived_steps[rows] * exp(VARIED * stream.standard_normal(len(rows)))
        steps = np.clip(varied, NARROWEST, WIDEST)
        moved = stream.random((len(rows), size)) < MOVED / size
        moved[np.arange(len(rows)), stream.integers(size, size=len(rows))] = True
        way = steps[:, np.newaxis] * stream.standard_normal((len(rows), size)) * moved
        return reflected(self._archive[rows] + way), steps

    def _learn(self, results: Sequence[Result]) -> None:
        known = [slot for slot, result in enumerate(results) if result.selectable]
        parents = np.ascontiguousarray(self._archive[self._stepped_from].T)
        tries = np.array([near(parents, self._points[slot]).sum() for slot in known], dtype=np.int64)
        self._archive = np.concatenate([self._archive, self._points[known]])
        self._archived_steps = np.append(self._archived_steps, self._steps[known])
        self._value = np.append(self._value, [results[slot].continuous for slot in known])
        self._tries = np.append(self._tries, tries)
        kinds = [self._kinds.setdefault(kind_of(results[slot]), len(self._kinds)) for slot in known]
        self._kind = np.append(self._kind, np.array(kinds, dtype=np.int64))
        new = np.zeros(len(self._kinds) - len(self._tries_of_kind), dtype=np.int64)
        self._tries_of_kind = np.append(self._tries_of_kind, new)
        self._births += [Birth(self._generation, slot) for slot in known]


def rarity(values: Floats | Ints) -> Floats:
    """Return (n,) log(1 / share of better values); equal values count half."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    better = len(values) - np.cumsum(counts) + 0.5 * counts
    return -log(better / len(values))[place]


def log_tries(tries: Ints) -> Floats:
    """Return (n,) log(1 + tries)."""
    return _logarithms(int(tries.max(initial=0)).bit_length())[tries]


@cache
def _logarithms(bits: int) -> Floats:
    """Return (2 ** bits,) log(1 + number) of each number with this many bits."""
    return log1p(np.arange(2**bits))


def near(columns: Floats, point: Floats) -> Bools:
    """Return (n,) True for points that are near `point` (d,); `columns` (d, n) are their coordinates."""
    return np.asarray((np.abs(columns - point[:, np.newaxis]) < NEAR).all(axis=0))


def kind_of(result: Result) -> Kind:
    """Return the kind of a run: direction of the other actor at closest approach, and both speeds; -1 if unknown."""
    ego, other = (measure(result, name) for name in ("ego_speed", "other_speed"))
    return sector_of(result), _step_of(ego), _step_of(other)


def sector_of(result: Result) -> int:
    """Return the direction of the other actor, one of `SECTORS`; -1 if unknown."""
    angle = measure(result, "approach_angle")
    return -1 if isnan(angle) else round(angle / (2.0 * pi) * SECTORS) % SECTORS


def _step_of(speed: float) -> int:
    return -1 if isnan(speed) else floor(speed / LIKE)
