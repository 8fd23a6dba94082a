"""Enumeration of finite choices."""

from collections.abc import Callable
from math import prod

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import ir
from cortex_dsl.semantics.model.choices import VARIANT_LIMIT, Oracle, TooManyVariants, enumerate_variants
from cortex_dsl.source import Span
from engine.opcodes import Op
from engine.vocabulary import GeneKind

HERE = Span(0, 1)
Compiled = Callable[..., ir.Scenario]


@given(st.lists(st.integers(1, 4), max_size=5))
def test_all_ways_are_enumerated_once(sizes: list[int]) -> None:
    """Independent choices give their product, each way once, with probabilities that add up to one."""

    def run(oracle: Oracle) -> tuple[int, ...]:
        return tuple(oracle.choose("x", HERE, (1.0 / size,) * size) for size in sizes)

    results = list(enumerate_variants(run))
    ways = [way for _, way in results]
    assert len(set(ways)) == len(ways) == prod(sizes)
    assert ways == sorted(ways)
    assert sum(oracle.probability for oracle, _ in results) == pytest.approx(1.0)


def test_later_choices_may_depend_on_earlier_ones() -> None:
    """A branch without a second choice is one way."""

    def run(oracle: Oracle) -> tuple[int, ...]:
        first = oracle.choose("x", HERE, (0.5, 0.5))
        return (first,) if first == 0 else (first, oracle.choose("y", HERE, (0.25, 0.75)))

    results = [(way, oracle.probability) for oracle, way in enumerate_variants(run)]
    assert results == [((0,), 0.5), ((1, 0), 0.125), ((1, 1), 0.375)]


def test_too_many_ways_are_noticed_at_once() -> None:
    """The first way already shows that there are too many."""
    runs = 0

    def run(oracle: Oracle) -> None:
        nonlocal runs
        runs += 1
        for _ in range(20):
            oracle.choose("x", HERE, (0.5, 0.5))

    with pytest.raises(TooManyVariants):
        list(enumerate_variants(run))
    assert runs == 1
    assert VARIANT_LIMIT == 4096


def test_objects_are_chosen_by_variants(compiled: Compiled) -> None:
    """A choice of a lane is a variant each, and names itself for a concrete copy."""
    scenario = compiled("chosen = Uniform(*intersection.incomingLanes)\nother = new Car in chosen.centerline\n")
    assert [v.probability for v in scenario.variants] == [0.25] * 4
    assert [v.choices[0].option_source for v in scenario.variants] == [f"network.lanes[{i}]" for i in (0, 2, 4, 6)]
    assert {v.choices[0].name for v in scenario.variants} == {"chosen"}


def test_numbers_stay_symbolic(compiled: Compiled) -> None:
    """Numeric choices that nobody needs to know make no variants."""
    scenario = compiled("x = Uniform(1, 2, 4) m\ny = DiscreteRange(1, 6)\nrequire x * y < 3\n")
    assert len(scenario.variants) == 1
    assert scenario.variants[0].draw_count == 3
    assert scenario.pool == (1.0, 2.0, 4.0)
    assert [site.kind for site in scenario.variants[0].draw_sites] == ["pose", "number", "number"]
    assert [site.unit for site in scenario.variants[0].draw_sites] == ["", "m", ""]


def test_numbers_are_expanded_where_they_must_be_known(compiled: Compiled) -> None:
    """An index makes the numeric choice behind it a choice of variants; others stay as they were."""
    scenario = compiled("i = DiscreteRange(0, 2)\nx = Uniform(1, 2)\nl = network.lanes[i]\nrequire x < 5\n")
    assert len(scenario.variants) == 3
    assert [v.choices[0].option for v in scenario.variants] == ["0", "1", "2"]
    assert scenario.variants[0].draw_count == 2


def test_weights_are_probabilities(compiled: Compiled) -> None:
    """`Discrete` over objects; options of weight 0 are left out."""
    scenario = compiled("x = Discrete({'a': 1, 'b': 3, 'c': 0})\n")
    assert [v.probability for v in scenario.variants] == [0.25, 0.75]


def test_discrete_gene_picks_the_variant(compiled: Compiled) -> None:
    """A searched choice is made by the gene: no probability, and the option in the variant."""
    scenario = compiled("param WHO = Uniform('a', 'b', 'c')\nx = 1 if WHO == 'a' else 2\n")
    assert scenario.genes[0].kind == GeneKind.INDEX
    assert scenario.genes[0].options == ('"a"', '"b"', '"c"')
    assert [v.gene_options for v in scenario.variants] == [((0, 0),), ((0, 1),), ((0, 2),)]
    assert [v.probability for v in scenario.variants] == [1.0] * 3


def test_integer_gene_is_expanded_by_use(compiled: Compiled) -> None:
    """A whole-number gene stays one number until it is an index."""
    quiet = compiled("param N = DiscreteRange(1, 3)\nrequire N < 3\n")
    assert len(quiet.variants) == 1
    used = compiled("param N = DiscreteRange(1, 3)\nl = network.lanes[N]\n")
    assert [v.gene_options for v in used.variants] == [((0, 0),), ((0, 1),), ((0, 2),)]


def test_empty_choice_rejects_its_variant(compiled: Compiled) -> None:
    """With its reason and line; the others go on."""
    scenario = compiled("which = Uniform('a', 'b')\nx = Uniform(*[i for i in [1, 2] if which == 'a'])\n")
    rejected = [v.rejection is not None for v in scenario.variants]
    assert rejected == [False, True]
    assert scenario.variants[1].rejection_line == 5
    assert "nothing to choose from" in (scenario.variants[1].rejection or "")


def test_fixed_gives_its_values_in_turn(compiled: Compiled) -> None:
    """Successive evaluations of one `Fixed` give successive values, in every variant anew."""
    scenario = compiled("l = Uniform('a', 'b')\nxs = [Fixed(1, 2, 3) m for i in range(3)]\nrequire xs[2] == 3 m\n")
    assert all(isinstance(v.requirements[0].condition, ir.Literal) for v in scenario.variants)


def test_repeated_site_is_recorded_each_time(compiled: Compiled) -> None:
    """Every evaluation of a place is noted, in order."""
    scenario = compiled("xs = [Range(0, 1) m for i in range(3)]\nrequire sum(xs) < 5\n")
    numbers = [site for site in scenario.variants[0].draw_sites if site.kind == "number"]
    assert len(numbers) == 3
    assert len({site.span for site in numbers}) == 1


def test_table_reads_the_pool(compiled: Compiled) -> None:
    """A numeric gene over options reads its value from the pool by its index."""
    scenario = compiled("param GAP = Discrete({5 m: 1, 10 m: 3})\nrequire GAP < 20\n")
    gene = scenario.genes[0]
    assert (gene.kind, gene.weights, gene.options) == (GeneKind.INDEX, (0.25, 0.75), ("5 m", "10 m"))
    condition = scenario.variants[0].requirements[0].condition
    assert isinstance(condition, ir.Apply)
    table = condition.arguments[0]
    assert isinstance(table, ir.Apply)
    assert (table.op, table.immediates) == (Op.TABLE, (0,))
