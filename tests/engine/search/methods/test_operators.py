"""Laws of the genetic operators."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Generator, Philox

from engine.search.methods.cube import draw_gene, draw_genome, pick
from engine.search.methods.ga import crossover, mutate, next_elite, tournament
from engine.search.protocol import Box, Genome
from engine.vocabulary import GeneKind
from tests.laws import examples


def stream(seed: int) -> Generator:
    return Generator(Philox(seed))


@st.composite
def boxes(draw: st.DrawFn) -> Box:
    """Boxes of all gene kinds, some ranges a single point."""
    count = draw(st.integers(1, 8))
    kinds = draw(st.lists(st.sampled_from(GeneKind), min_size=count, max_size=count))
    low, high = [], []
    for kind in kinds:
        if kind is GeneKind.CONTINUOUS:
            a, b = sorted(draw(st.tuples(*[st.floats(-1e6, 1e6)] * 2)))
        else:
            a, b = sorted(draw(st.tuples(*[st.integers(-50, 50).map(float)] * 2)))
        low.append(a)
        high.append(b)
    return Box(tuple(f"g{i}" for i in range(count)), tuple(low), tuple(high), tuple(kinds))


seeds = st.integers(0, 2**63 - 1)


@given(boxes(), seeds)
def test_drawn_genomes_lie_in_the_box(box: Box, seed: int) -> None:
    """Uniform genomes respect every range and are whole where they must be."""
    assert box.holds(draw_genome(stream(seed), box))


@given(boxes(), seeds)
def test_children_lie_in_the_box(box: Box, seed: int) -> None:
    """Neither crossover nor mutation leaves the box that the parents lie in."""
    numbers = stream(seed)
    first, second = draw_genome(numbers, box), draw_genome(numbers, box)
    assert all(box.holds(child) for child in crossover(numbers, first, second))
    assert box.holds(mutate(numbers, first, box))


@given(st.integers(2, 9), seeds)
def test_crossover_has_one_cut(count: int, seed: int) -> None:
    """Children are complementary: a head of one parent and the tail of the other, neither of them empty."""
    zeros, ones = (0.0,) * count, (1.0,) * count
    first, second = crossover(stream(seed), zeros, ones)
    cut = first.index(1.0)
    assert 1 <= cut <= count - 1
    assert first == zeros[:cut] + ones[cut:]
    assert second == ones[:cut] + zeros[cut:]


def test_crossover_cuts_uniformly() -> None:
    """Each of the n - 1 cuts is taken equally often."""
    numbers = stream(1)
    cuts = [crossover(numbers, (0.0,) * 5, (1.0,) * 5)[0].index(1.0) for _ in range(8000)]
    counts = np.bincount(cuts, minlength=5)[1:]
    assert counts.sum() == 8000
    assert np.all(np.abs(counts - 2000) < 4 * np.sqrt(8000 * 0.25 * 0.75))


def test_crossover_of_one_gene_copies() -> None:
    """There is no place to cut a genome of one gene."""
    assert crossover(stream(1), (1.0,), (2.0,)) == ((1.0,), (2.0,))


@given(boxes(), seeds)
def test_mutation_changes_at_most_one_gene(box: Box, seed: int) -> None:
    """Exactly one gene is drawn anew; where a range is a point, nothing can change."""
    numbers = stream(seed)
    parent = draw_genome(numbers, box)
    child = mutate(numbers, parent, box)
    changed = [gene for gene in range(len(box)) if child[gene] != parent[gene]]
    assert len(changed) <= 1
    assert all(box.low[gene] < box.high[gene] for gene in changed)


def test_mutation_reaches_every_gene_and_value() -> None:
    """All movable genes are chosen equally often, and a discrete one takes each of its values."""
    kinds = (GeneKind.CONTINUOUS, GeneKind.INDEX, GeneKind.CONTINUOUS)
    box = Box(("a", "b", "fixed"), (0.0, 0.0, 3.0), (1.0, 3.0, 3.0), kinds)
    numbers = stream(2)
    children = [mutate(numbers, (2.0, 9.0, 3.0), box) for _ in range(4000)]
    options = [child[1] for child in children if child[1] != 9.0]
    assert abs(len(options) - 2000) < 4 * np.sqrt(1000)
    assert set(options) == {0.0, 1.0, 2.0, 3.0}
    assert {child[2] for child in children} == {3.0}


@given(seeds, st.integers(1, 12))
def test_pick_stays_in_range(seed: int, count: int) -> None:
    """A pick is an index."""
    assert 0 <= pick(stream(seed), count) < count


def test_binary_tournament_prefers_the_fitter() -> None:
    """With replacement among n, the best wins with probability 1 - (1 - 1/n)^2; uniformly with 1/n."""
    numbers = stream(3)
    fitness = [0.0, 1.0, 2.0, 3.0]
    for size, expected in ((2, 1 - 0.75**2), (1, 0.25)):
        wins = sum(tournament(numbers, range(4), fitness, size) == 3 for _ in range(8000))
        assert abs(wins / 8000 - expected) < 4 * np.sqrt(0.25 / 8000)


def test_tournament_ties_favour_nobody() -> None:
    """Among equals the choice stays uniform."""
    numbers = stream(4)
    counts = np.bincount([tournament(numbers, range(4), [1.0] * 4, 2) for _ in range(8000)])
    assert np.all(np.abs(counts - 2000) < 4 * np.sqrt(1500))


def test_next_elite_skips_equal_genomes() -> None:
    """A genome that was taken is taken wherever it stands."""
    genomes: list[Genome] = [(1.0,), (1.0,), (2.0,)]
    assert next_elite(range(3), genomes, set()) == 0
    assert next_elite(range(3), genomes, {(1.0,)}) == 2
    assert next_elite(range(3), genomes, {(1.0,), (2.0,)}) is None


@examples(20)
@given(seeds)
def test_gene_range_is_closed(seed: int) -> None:
    """Rounding never carries a value past the upper end of its range."""
    box = Box(("a",), (0.1,), (0.1 + 2**-50,), (GeneKind.CONTINUOUS,))
    values = {draw_gene(stream(seed + i), box, 0) for i in range(20)}
    assert all(box.low[0] <= value <= box.high[0] for value in values)
