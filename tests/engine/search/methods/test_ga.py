"""Each decision about the genetic algorithm, one by one."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Generator, Philox

from engine.config import GAConfig
from engine.search.methods.cube import RandomSearch
from engine.search.methods.ga import PRESETS, GeneticAlgorithm, operator_thresholds, tournament_size
from engine.search.protocol import Birth, Box, Genome, Operator, Proposal, Result, Status
from engine.streams import operator_generator
from engine.vocabulary import GeneKind, Method, Verdict
from tests.laws import examples

streams = partial(operator_generator, 7, int(Method.GA), 0)
INVALID = Result(Status.INVALID, float("nan"), Verdict.EXHAUSTED)
ERROR = Result(Status.ERROR, float("nan"), Verdict.ERROR)


def valid(fitness: float) -> Result:
    return Result(Status.VALID, fitness, Verdict.VALID)


def tell(search: GeneticAlgorithm, proposals: Sequence[Proposal], judge: Callable[[Proposal], Result]) -> None:
    """Tell fresh proposals as judged, elites as reused."""
    results = [replace(p.reused, status=Status.REUSED) if p.reused else judge(p) for p in proposals]
    search.tell(results)


def by_sum(proposal: Proposal) -> Result:
    return valid(sum(proposal.genome))


def simple_box(genes: int = 4, high: float = 1.0, kind: GeneKind = GeneKind.CONTINUOUS) -> Box:
    return Box(tuple(f"g{i}" for i in range(genes)), (0.0,) * genes, (high,) * genes, (kind,) * genes)


def run(search: GeneticAlgorithm, generations: int, judge: Callable[[Proposal], Result]) -> list[list[Proposal]]:
    history = []
    for _ in range(generations):
        proposals = list(search.ask())
        tell(search, proposals, judge)
        history.append(proposals)
    return history


def test_first_generation_is_random(box: Box) -> None:
    """Nobody has parents at first."""
    first = GeneticAlgorithm(box, 50, streams).ask()
    assert {proposal.operator for proposal in first} == {Operator.RANDOM}
    assert [proposal.birth for proposal in first] == [Birth(0, place) for place in range(50)]


@examples(25)
@given(
    population=st.integers(1, 31),
    seed=st.integers(0, 10**9),
    share=st.floats(0.0, 1.0),
    preset=st.sampled_from(sorted(PRESETS)),
    per_individual=st.booleans(),
)
def test_laws_of_a_generation(population: int, seed: int, share: float, preset: str, per_individual: bool) -> None:
    """Full and never overfull, inside the box, births at their places, elites as they were, never a known child."""
    box = Box(("a", "b", "c"), (-1.0, 2.0, 0.0), (5.0, 2.5, 100.0), (GeneKind.CONTINUOUS,) * 3)
    stream = partial(operator_generator, seed, int(Method.GA), 0)
    search = GeneticAlgorithm(box, population, stream, replace(PRESETS[preset], per_individual=per_individual))
    chance = Generator(Philox(seed))
    known: dict[Birth, tuple[Genome, Result]] = {}
    for generation in range(5):
        proposals = list(search.ask())
        assert len(proposals) == population
        elites = []
        for place, proposal in enumerate(proposals):
            assert box.holds(proposal.genome)
            if proposal.reused is None:
                assert proposal.birth == Birth(generation, place)
                assert proposal.genome not in [genome for genome, _ in known.values()]
                fitness = valid(sum(proposal.genome))
                known[proposal.birth] = proposal.genome, fitness if chance.random() < share else INVALID
                assert all(known[parent][1].selectable for parent in proposal.parents)
            else:
                assert known[proposal.birth] == (proposal.genome, replace(proposal.reused, status=Status.VALID))
                elites.append(proposal.genome)
        assert len(set(elites)) == len(elites)
        tell(search, proposals, lambda proposal: known[proposal.birth][1])


def test_elites_come_best_first_and_the_elder_of_equals() -> None:
    """Selection alone walks down the ranking by fitness, then birth."""
    config = GAConfig(selection_rate=1.0, crossover_rate=0.0, mutation_rate=0.0)
    search = GeneticAlgorithm(simple_box(), 6, streams, config)
    first = search.ask()
    fitness = [1.0, 3.0, 2.0, 3.0, 1.0, 3.0]
    search.tell([valid(value) for value in fitness])
    second = search.ask()
    assert [p.birth.place for p in second] == [1, 3, 5, 2, 0, 4]
    assert all(p.operator is Operator.ELITE and p.genome == first[p.birth.place].genome for p in second)


def test_elite_keeps_its_birth_over_generations() -> None:
    """The stored result travels with the first birth, however often it is kept."""
    config = GAConfig(selection_rate=1.0, crossover_rate=0.0, mutation_rate=0.0)
    search = GeneticAlgorithm(simple_box(), 5, streams, config)
    history = run(search, 4, by_sum)
    assert {p.birth.generation for p in history[-1]} == {0}
    assert sorted(p.birth for p in history[-1]) == sorted(p.birth for p in history[0])


def test_nothing_left_to_take_becomes_a_mutation() -> None:
    """A pool smaller than the population cannot fill it with elites."""
    config = GAConfig(selection_rate=1.0, crossover_rate=0.0, mutation_rate=0.0)
    search = GeneticAlgorithm(simple_box(), 6, streams, config)
    search.ask()
    search.tell([valid(1.0), valid(2.0), *[INVALID] * 4])
    assert Counter(p.operator for p in search.ask()) == {Operator.ELITE: 2, Operator.MUTATION: 4}


def test_equal_genomes_count_as_taken() -> None:
    """Where the same genome stands twice in the pool, it is kept once."""
    config = GAConfig(selection_rate=1.0, crossover_rate=0.0, mutation_rate=0.0)
    search = GeneticAlgorithm(simple_box(1, 0.0), 3, streams, config)
    search.ask()
    search.tell([valid(1.0)] * 3)
    assert [p.operator for p in search.ask()].count(Operator.ELITE) == 1


def test_invalid_and_failed_never_breed() -> None:
    """Neither selection nor crossover nor mutation touches an individual without a fitness."""
    search = GeneticAlgorithm(simple_box(), 60, streams)
    run_first = search.ask()
    fates = [(valid(1.0), INVALID, ERROR)[place % 3] for place in range(60)]
    search.tell(fates)
    second = search.ask()
    used = {birth.place for p in second for birth in (p.parents or (p.birth,))}
    assert used
    assert all(place % 3 == 0 for place in used)
    assert len(run_first) == 60


def test_one_valid_parent_only_mutates() -> None:
    """With a pool of one there is nobody to cross with."""
    search = GeneticAlgorithm(simple_box(), 40, streams)
    search.ask()
    search.tell([valid(1.0), *[INVALID] * 39])
    operators = Counter(p.operator for p in search.ask())
    assert set(operators) == {Operator.ELITE, Operator.MUTATION}
    assert operators[Operator.ELITE] == 1


def test_no_valid_parent_starts_afresh() -> None:
    """A generation without survivors is followed by a random one, of genomes not tried before."""
    search = GeneticAlgorithm(simple_box(), 40, streams)
    first = list(search.ask())
    search.tell([INVALID] * 40)
    second = search.ask()
    assert {p.operator for p in second} == {Operator.RANDOM}
    assert {p.birth.generation for p in second} == {1}
    assert not {p.genome for p in first} & {p.genome for p in second}


def test_two_parents_differ() -> None:
    """Parents are drawn without replacement: with two in the pool, both take part in every crossing."""
    config = GAConfig(selection_rate=0.0, crossover_rate=1.0, mutation_rate=0.0)
    search = GeneticAlgorithm(simple_box(8), 10, streams, config)
    search.ask()
    search.tell([valid(5.0), valid(1.0), *[INVALID] * 8])
    crossed = [p for p in search.ask() if p.operator in (Operator.CROSSOVER, Operator.CROSSOVER_MUTATION)]
    assert crossed
    assert all({parent.place for parent in p.parents} == {0, 1} for p in crossed)


def test_both_children_enter() -> None:
    """A crossing fills two places with complementary children of the same parents."""
    config = GAConfig(selection_rate=0.0, crossover_rate=1.0, mutation_rate=0.0)
    search = GeneticAlgorithm(simple_box(), 20, streams, config)
    first = list(search.ask())
    search.tell([valid(1.0)] * 20)
    second = search.ask()
    for a, b in zip(second[::2], second[1::2], strict=True):
        assert a.parents == b.parents[::-1]
        mother, father = (first[parent.place].genome for parent in a.parents)
        assert sorted(a.genome + b.genome) == sorted(mother + father)


def test_last_place_takes_either_child() -> None:
    """An odd population is never exceeded, and both children have their chance at the last place."""
    config = GAConfig(selection_rate=0.0, crossover_rate=1.0, mutation_rate=0.0)
    heads = []
    for seed in range(60):
        search = GeneticAlgorithm(simple_box(), 3, partial(operator_generator, seed, 3, 0), config)
        first = list(search.ask())
        search.tell([valid(1.0)] * 3)
        second = search.ask()
        assert len(second) == 3
        # The first parent is recorded first: its gene leads the child, in either order of the two children.
        last = second[2]
        assert last.genome[0] == first[last.parents[0].place].genome[0]
        stream = operator_generator(seed, 3, 0, 1, 2)
        stream.random()
        drawn = int(stream.random() * 3)
        stream.random()
        heads.append(last.parents[0].place == drawn)
    assert 5 < sum(heads) < 55


def test_rates_are_shares_of_draws() -> None:
    """As written, crossings fill two places: shares of individuals are 5.6, 88.9 and 5.6 %."""
    counts = Counter(p.operator for p in _second_generation(GAConfig()))
    total = sum(counts.values())
    crossed = counts[Operator.CROSSOVER] + counts[Operator.CROSSOVER_MUTATION]
    assert crossed / total == pytest.approx(1.6 / 1.8, abs=0.02)
    assert counts[Operator.ELITE] / total == pytest.approx(0.1 / 1.8, abs=0.012)


def test_rates_as_shares_of_individuals() -> None:
    """The other reading: 10, 80 and 10 % of the individuals."""
    counts = Counter(p.operator for p in _second_generation(GAConfig(per_individual=True)))
    total = sum(counts.values())
    assert counts[Operator.CROSSOVER] / total == pytest.approx(0.8, abs=0.025)
    assert counts[Operator.ELITE] / total == pytest.approx(0.1, abs=0.015)


def _second_generation(config: GAConfig) -> list[Proposal]:
    search = GeneticAlgorithm(simple_box(7), 3000, streams, config)
    tell(search, search.ask(), by_sum)
    return search.ask()


def test_thresholds() -> None:
    """Rates must be shares of a whole."""
    assert operator_thresholds(GAConfig()) == pytest.approx((0.1, 0.9))
    assert operator_thresholds(GAConfig(per_individual=True)) == pytest.approx((1 / 6, 5 / 6))
    for rates in ((0.5, 0.5, 0.5), (-0.1, 1.0, 0.1), (float("nan"), 0.5, 0.5)):
        with pytest.raises(ValueError, match="add up to 1"):
            operator_thresholds(GAConfig("cortex", *rates))


def test_presets_differ_in_how_parents_are_chosen() -> None:
    """The tournament breeds from fitter parents than the uniform choice does."""
    means = {}
    for preset, config in PRESETS.items():
        search = GeneticAlgorithm(simple_box(), 400, streams, config)
        first = list(search.ask())
        tell(search, first, by_sum)
        parents = [parent.place for p in search.ask() for parent in p.parents]
        means[preset] = np.mean([sum(first[place].genome) for place in parents]) - np.mean(
            [sum(p.genome) for p in first]
        )
    assert means["cortex"] > 0.2
    assert abs(means["cortex-literal"]) < 0.08


def test_preset_decides_the_tournament() -> None:
    """`cortex-literal` is uniform whatever size is set; an unknown preset is an error that names the known ones."""
    assert tournament_size(GAConfig()) == 2
    assert tournament_size(GAConfig(preset="cortex-literal")) == 1
    with pytest.raises(ValueError, match="cortex-literal"):
        tournament_size(GAConfig(preset="cortx"))
    with pytest.raises(ValueError, match="tournament"):
        tournament_size(GAConfig(tournament=0))


def test_known_children_are_bred_again() -> None:
    """In a small discrete box children avoid every genome ever proposed, as long as any is left."""
    box = simple_box(3, 5.0, GeneKind.INTEGER)
    search = GeneticAlgorithm(box, 20, streams)
    history = run(search, 4, by_sum)
    fresh = [p.genome for generation in history for p in generation if p.reused is None]
    assert len(set(fresh)) >= len(fresh) - 1


def test_child_known_whatever_the_parents_is_mutated() -> None:
    """After its redraws a child gets one gene anew, under an operator of its own name."""
    config = GAConfig(selection_rate=0.0, crossover_rate=1.0, mutation_rate=0.0, max_redraws=3)
    search = GeneticAlgorithm(simple_box(2), 4, streams, config)
    first = list(search.ask())
    search.tell([valid(1.0), valid(1.0), INVALID, INVALID])
    second = search.ask()
    parents = [p.genome for p in first[:2]]
    crosses = {(parents[0][0], parents[1][1]), (parents[1][0], parents[0][1])}
    assert {p.genome for p in second[:2]} == crosses
    for p in second[2:]:
        assert p.operator is Operator.CROSSOVER_MUTATION
        assert p.genome not in crosses
        assert any(sum(a != b for a, b in zip(p.genome, cross, strict=True)) == 1 for cross in crosses)


def test_redraws_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hopeless child is bred 1 + max_redraws times, not more and not fewer."""
    calls = []
    monkeypatch.setattr(
        "engine.search.methods.ga.draw_genome", lambda stream, box: calls.append(1) or (0.5,) * len(box)
    )
    search = GeneticAlgorithm(simple_box(), 2, streams)
    first, second = search.ask()
    assert len(calls) == 1 + 11
    assert first.genome == (0.5,) * 4
    assert sum(gene != 0.5 for gene in second.genome) == 1


@pytest.mark.parametrize("genes", [0, 1])
def test_boxes_with_no_place_to_cut(genes: int) -> None:
    """One gene is mutated instead of crossed; without genes the same case is simulated again and again."""
    search = GeneticAlgorithm(simple_box(genes), 12, streams)
    history = run(search, 3, by_sum)
    operators = {p.operator for p in history[-1]}
    assert operators <= {Operator.ELITE, Operator.MUTATION}
    assert all(len(generation) == 12 for generation in history)


def test_answers_must_match() -> None:
    """One result for each proposal."""
    for search in (GeneticAlgorithm(simple_box(), 3, streams), RandomSearch(simple_box(), 3, streams)):
        search.ask()
        with pytest.raises(ValueError, match="3 proposals, got 2"):
            search.tell([valid(1.0)] * 2)


def test_same_streams_same_search() -> None:
    """Two searches that get the same results propose the same."""
    histories = [run(GeneticAlgorithm(simple_box(), 30, streams), 5, by_sum) for _ in range(2)]
    assert histories[0] == histories[1]


def test_slots_are_independent() -> None:
    """What a slot of the first generation holds does not depend on how large the generation is."""
    small, large = (GeneticAlgorithm(simple_box(), count, streams).ask() for count in (5, 50))
    assert small == large[:5]


def test_random_search_learns_nothing(box: Box) -> None:
    """Its proposals are uniform in the box and the same whatever results it got."""
    searches = [RandomSearch(box, 200, streams) for _ in range(2)]
    proposals = [search.ask() for search in searches]
    searches[0].tell([valid(22.0)] * 200)
    searches[1].tell([INVALID] * 200)
    assert searches[0].ask() == searches[1].ask()
    unit = np.array([(p.genome[1] - box.low[1]) / (box.high[1] - box.low[1]) for p in proposals[0]])
    assert abs(unit.mean() - 0.5) < 0.1
    assert {p.genome[6] for p in proposals[0]} == {0.0, 1.0, 2.0, 3.0}
