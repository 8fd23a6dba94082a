"""The genetic algorithm of the CORTEX-AVD paper, with a decision for every gap of its description.

    pool = valid individuals of the last generation
    while the new generation is not full:
        u ~ U[0, 1)
        u < 0.1          the best of the pool not yet taken in this generation     (elitism)
        0.1 <= u < 0.9   two parents, one cut point, both children                 (single-point crossover)
        else             one parent, one gene drawn again in its range             (random mutation)

Gaps of the paper, and the decisions taken here:

| gap | decision |
|---|---|
| parents | preset `cortex`: binary tournament; `cortex-literal`: uniform over the pool |
| equal parents | the second parent has another genome; a pool of one genome only mutates |
| last slot | one of the two children, by the stream |
| rates | shares of draws; `per_individual` makes them shares of individuals |
| elites | fitness, then birth; equal genomes count as taken; with nothing left to take, a mutation |
| known children | bred again from new parents at most `max_redraws` times, then one gene is mutated |
| one gene | there is no place to cut: a mutation instead |
| no valid individual | a fresh random generation, inside the budget |

An invalid or failed individual is never selected, crossed or mutated; it stays known. An elite is proposed with its
stored result. The stream of an operator is that of the first slot it fills, so no result depends on any other slot.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from numpy.random import Generator

from engine.config import GAConfig
from engine.errors import ArgumentError
from engine.search.methods.cube import draw_gene, draw_genome, pick
from engine.search.protocol import Birth, Box, GenerationSearcher, Genome, Operator, Proposal, Result, StreamAt

# -- operators: pure functions of a stream of random numbers, the parents and the box ----------------------------------


def crossover(stream: Generator, first: Genome, second: Genome) -> tuple[Genome, Genome]:
    """Return both children of a single-point crossover with a uniform cut in 1 .. n - 1.

    With fewer than two genes there is no cut, and the children are copies.
    """
    if len(first) < 2:
        return first, second
    cut = 1 + pick(stream, len(first) - 1)
    return first[:cut] + second[cut:], second[:cut] + first[cut:]


def mutate(stream: Generator, parent: Genome, box: Box) -> Genome:
    """Return the parent with one gene drawn again in its range. A gene with a range of one point is never chosen."""
    genes = [gene for gene in range(len(box)) if box.low[gene] < box.high[gene]]
    if not genes:
        return parent
    gene = genes[pick(stream, len(genes))]
    return (*parent[:gene], draw_gene(stream, box, gene), *parent[gene + 1 :])


def tournament(stream: Generator, candidates: Sequence[int], fitness: Sequence[float], size: int) -> int:
    """Return the fittest of `size` candidates drawn with replacement; the first drawn wins a tie. Size 1 is uniform.

    Goldberg and Deb (1991), "A comparative analysis of selection schemes used in genetic algorithms".
    """
    winner = candidates[pick(stream, len(candidates))]
    for _ in range(size - 1):
        rival = candidates[pick(stream, len(candidates))]
        if fitness[rival] > fitness[winner]:
            winner = rival
    return winner


def next_elite(ranking: Iterable[int], genomes: Sequence[Genome], taken: set[Genome]) -> int | None:
    """Return the first member of a ranking (best first) with a genome that is not taken; None if all are taken."""
    return next((member for member in ranking if genomes[member] not in taken), None)


# -- the algorithm -----------------------------------------------------------------------------------------------------

PRESETS = {
    "cortex": GAConfig(),
    "cortex-literal": GAConfig(preset="cortex-literal", tournament=1),
}


@dataclass(frozen=True, slots=True)
class _Child:
    genome: Genome
    operator: Operator
    parents: tuple[Birth, ...] = ()


@dataclass(frozen=True)
class _Pool:
    """The valid individuals of a generation, best first (ties: elder first)."""

    genomes: tuple[Genome, ...] = ()
    fitness: tuple[float, ...] = ()
    births: tuple[Birth, ...] = ()
    results: tuple[Result, ...] = ()
    different: int = 0
    """Number of different genomes."""

    def __len__(self) -> int:
        return len(self.genomes)

    @cached_property
    def _before(self) -> dict[Genome, list[int]]:
        """Return the number of members with another genome before each member with a genome, in their order."""
        before: dict[Genome, list[int]] = {}
        for member, genome in enumerate(self.genomes):
            same = before.setdefault(genome, [])
            same.append(member - len(same))
        return before

    def others(self, member: int) -> Sequence[int]:
        """Return all members whose genome differs from that of `member`, without a list of them."""
        return _Others(len(self.genomes), self._before[self.genomes[member]])


@dataclass(frozen=True)
class _Others(Sequence[int]):
    """The first whole numbers from 0 on, without some."""

    numbers: int
    before: Sequence[int]
    """Number of numbers that stay, before each number that does not."""

    def __len__(self) -> int:
        return self.numbers - len(self.before)

    def __getitem__(self, place: Any) -> Any:
        if not 0 <= place < len(self):
            raise IndexError(place)
        return place + bisect_right(self.before, place)


Breed = Callable[[Generator, int], list[_Child]]
"""(stream, how many) -> that many children."""


class GeneticAlgorithm(GenerationSearcher):
    """Searcher that breeds one generation after another; see the table above."""

    def __init__(self, box: Box, population: int, streams: StreamAt, config: GAConfig = PRESETS["cortex"]) -> None:
        super().__init__(population, streams)
        self._box = box
        self._max_redraws = config.max_redraws
        self._tournament = tournament_size(config)
        self._elite_below, self._crossover_below = operator_thresholds(config)
        self._pool = _Pool()
        self._known: set[Genome] = set()

    def _proposals(self) -> list[Proposal]:
        proposals: list[Proposal] = []
        taken: set[Genome] = set()
        ranking = iter(range(len(self._pool)))
        while (slot := len(proposals)) < self._population:
            stream = self._streams(self._generation, slot)
            if not self._pool:
                proposals += self._born(slot, self._distinct(self._random, stream, 1))
            else:
                proposals += self._fill(stream, slot, ranking, taken)
        return proposals

    def _learn(self, results: Sequence[Result]) -> None:
        self._pool = _pool_of(self._proposed, results)

    def _fill(self, stream: Generator, slot: int, ranking: Iterator[int], taken: set[Genome]) -> list[Proposal]:
        """Return one or two proposals from the next slot on, by the operator that the stream chooses.

        `ranking` are the members that no slot has looked at as an elite; those before them are taken.
        """
        u = stream.random()
        elite = next_elite(ranking, self._pool.genomes, taken) if u < self._elite_below else None
        if elite is not None:
            taken.add(self._pool.genomes[elite])
            return [self._unchanged(elite)]
        crossing = self._elite_below <= u < self._crossover_below
        if crossing and len(self._box) > 1 and self._pool.different > 1:
            count = min(2, self._population - slot)
            return self._born(slot, self._distinct(self._cross, stream, count))
        return self._born(slot, self._distinct(self._mutate, stream, 1))

    def _unchanged(self, member: int) -> Proposal:
        pool = self._pool
        return Proposal(pool.genomes[member], Operator.ELITE, pool.births[member], reused=pool.results[member])

    def _born(self, slot: int, children: Sequence[_Child]) -> list[Proposal]:
        return [
            Proposal(child.genome, child.operator, Birth(self._generation, slot + place), child.parents)
            for place, child in enumerate(children)
        ]

    def _distinct(self, breed: Breed, stream: Generator, count: int) -> list[_Child]:
        """Return `count` children, new ones if redraws and one mutation suffice for that."""
        new_children: list[_Child] = []
        stale: list[_Child] = []
        for _ in range(1 + self._max_redraws):
            stale = []
            for child in breed(stream, count - len(new_children)):
                (new_children if self._claim(child.genome) else stale).append(child)
            if not stale:
                return new_children
        return new_children + [self._forced(stream, child) for child in stale]

    def _claim(self, genome: Genome) -> bool:
        """Store the genome; return True if it was new."""
        before = len(self._known)
        self._known.add(genome)
        return len(self._known) > before

    def _forced(self, stream: Generator, child: _Child) -> _Child:
        """Return the parent with one gene mutated. A small box may yield a known genome; it is simulated again."""
        genome = mutate(stream, child.genome, self._box)
        self._known.add(genome)
        crossed = child.operator is Operator.CROSSOVER
        return _Child(genome, Operator.CROSSOVER_MUTATION if crossed else child.operator, child.parents)

    def _random(self, stream: Generator, _count: int) -> list[_Child]:
        return [_Child(draw_genome(stream, self._box), Operator.RANDOM)]

    def _mutate(self, stream: Generator, _count: int) -> list[_Child]:
        pool = self._pool
        parent = tournament(stream, range(len(pool)), pool.fitness, self._tournament)
        genome = mutate(stream, pool.genomes[parent], self._box)
        return [_Child(genome, Operator.MUTATION, (pool.births[parent],))]

    def _cross(self, stream: Generator, count: int) -> list[_Child]:
        pool = self._pool
        first = tournament(stream, range(len(pool)), pool.fitness, self._tournament)
        second = tournament(stream, pool.others(first), pool.fitness, self._tournament)
        genomes = crossover(stream, pool.genomes[first], pool.genomes[second])
        births = pool.births[first], pool.births[second]
        orders = births, births[::-1]
        children = [_Child(*pair) for pair in zip(genomes, (Operator.CROSSOVER,) * 2, orders, strict=True)]
        return children if count == 2 else [children[pick(stream, 2)]]


def tournament_size(config: GAConfig) -> int:
    """Return the number of candidates that compete to be a parent.

    Raises:
        ArgumentError: unknown preset or empty tournament.
    """
    if config.preset not in PRESETS:
        raise ArgumentError(f"preset: `{config.preset}` is none of {', '.join(PRESETS)}", "name one of these")
    if config.tournament < 1:
        raise ArgumentError(
            f"tournament: expected at least 1 competitor, got {config.tournament}", "take 2, the default"
        )
    return 1 if config.preset == "cortex-literal" else config.tournament


def operator_thresholds(config: GAConfig) -> tuple[float, float]:
    """Return the ends of elitism and crossover in [0, 1). As share of individuals, a crossover counts for two."""
    rates = config.selection_rate, config.crossover_rate, config.mutation_rate
    if not (min(rates) >= 0.0 and abs(sum(rates) - 1.0) < 1e-9):
        raise ArgumentError(
            f"rates of selection, crossover and mutation: expected three that add up to 1, got {rates}",
            "take 0.1, 0.8, 0.1",
        )
    selection, crossing, mutation = rates
    if config.per_individual:
        crossing /= 2.0
    total = selection + crossing + mutation
    return selection / total, (selection + crossing) / total


def _pool_of(proposals: Sequence[Proposal], results: Sequence[Result]) -> _Pool:
    pairs = [pair for pair in zip(proposals, results, strict=True) if pair[1].selectable]
    pairs.sort(key=lambda pair: (-pair[1].fitness, pair[0].birth))
    return _Pool(
        genomes=tuple(proposal.genome for proposal, _ in pairs),
        fitness=tuple(result.fitness for _, result in pairs),
        births=tuple(proposal.birth for proposal, _ in pairs),
        results=tuple(result for _, result in pairs),
        different=len({proposal.genome for proposal, _ in pairs}),
    )
