"""The genetic operators: pure functions of a stream of random numbers, the parents and the box."""

from collections.abc import Iterable, Sequence
from math import floor

from numpy.random import Generator

from engine.search.protocol import Box, Genome
from engine.vocabulary import GeneKind


def pick(stream: Generator, count: int) -> int:
    """A whole number, uniform in 0 .. count - 1."""
    return int(stream.random() * count)


def draw_gene(stream: Generator, box: Box, gene: int) -> float:
    """A value of one gene, uniform in its range; discrete genes are uniform over their whole numbers."""
    low, high = box.low[gene], box.high[gene]
    if box.kinds[gene] is GeneKind.CONTINUOUS:
        return min(low + stream.random() * (high - low), high)
    return low + floor(stream.random() * (high - low + 1.0))


def draw_genome(stream: Generator, box: Box) -> Genome:
    """A genome, uniform over the box."""
    return tuple(draw_gene(stream, box, gene) for gene in range(len(box)))


def crossover(stream: Generator, first: Genome, second: Genome) -> tuple[Genome, Genome]:
    """Both children of a single-point crossover, the cut uniform in 1 .. n - 1.

    Fewer than two genes leave no place to cut: the children are copies.
    """
    if len(first) < 2:
        return first, second
    cut = 1 + pick(stream, len(first) - 1)
    return first[:cut] + second[cut:], second[:cut] + first[cut:]


def mutate(stream: Generator, parent: Genome, box: Box) -> Genome:
    """The parent with one gene drawn anew in its range. A gene whose range is a point is never chosen."""
    genes = [gene for gene in range(len(box)) if box.low[gene] < box.high[gene]]
    if not genes:
        return parent
    gene = genes[pick(stream, len(genes))]
    return (*parent[:gene], draw_gene(stream, box, gene), *parent[gene + 1 :])


def tournament(stream: Generator, candidates: Sequence[int], fitness: Sequence[float], size: int) -> int:
    """The fittest of `size` candidates drawn with replacement; the first drawn wins a tie. Size 1 is uniform.

    Goldberg and Deb (1991), "A comparative analysis of selection schemes used in genetic algorithms".
    """
    winner = candidates[pick(stream, len(candidates))]
    for _ in range(size - 1):
        rival = candidates[pick(stream, len(candidates))]
        if fitness[rival] > fitness[winner]:
            winner = rival
    return winner


def next_elite(ranking: Iterable[int], genomes: Sequence[Genome], taken: set[Genome]) -> int | None:
    """The first of a ranking (best first) whose genome is not taken, or None when all are."""
    return next((member for member in ranking if genomes[member] not in taken), None)
