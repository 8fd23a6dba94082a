"""Aggregates, verdicts of several rollouts, the five figures, the ranking, what genes did, and whom the ego met."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.assessment import Evaluate, map_arrays, take
from engine.config import Config, SearchConfig
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.search.campaign import Campaign
from engine.search.evaluations import (
    NOBODY,
    Evaluations,
    Partners,
    aggregate,
    distinct_collisions,
    figures,
    partner_of,
    partners,
    quantile_level,
)
from engine.search.probability.estimates import Count
from engine.search.protocol import Box
from engine.search.ranking import order_of_risk, worst_cases
from engine.search.run import Task, run_campaign
from engine.search.searchers import build_searcher
from engine.tables import Floats, Ints
from engine.vocabulary import Blame, GeneKind, Verdict
from tests.engine.search.conftest import evaluated

Rows = Callable[[Ints, Floats], Assessment]
VALID, EXHAUSTED, ABORTED, ERROR = (
    int(verdict) for verdict in (Verdict.VALID, Verdict.EXHAUSTED, Verdict.ABORTED, Verdict.ERROR)
)


@pytest.fixture
def table(rows: Rows) -> Callable[[list[list[int]], list[list[float]]], Evaluations]:
    """Individuals from the verdicts and distances of their rollouts; genome i is (i,)."""

    def make(verdicts: list[list[int]], distances: list[list[float]]) -> Evaluations:
        shape = np.shape(verdicts)
        flat = rows(np.array(verdicts, dtype=np.int32).ravel(), np.array(distances, dtype=float).ravel())
        rollouts = map_arrays(flat, lambda array: array.reshape(*shape, *array.shape[1:]))
        return evaluated(np.arange(float(shape[0]))[:, np.newaxis], rollouts)

    return make


def run(space: ParamSpace, evaluate: Evaluate, config: SearchConfig) -> Campaign:
    searcher = build_searcher("random", Box.of(space), Config(search=config))
    return run_campaign(Task(space, evaluate, config, "random"), searcher)


@given(
    st.lists(st.lists(st.floats(-1, 22), min_size=4, max_size=4), min_size=1, max_size=6),
    st.sampled_from(["mean", "max", "q0", "q50", "q90", "q100"]),
    st.integers(0, 2**24 - 1),
)
def test_aggregate_reads_valid_rollouts_only(values: list[list[float]], how: str, bits: int) -> None:
    """Each row's aggregate lies between the least and largest of its valid values, and is that of numpy."""
    array = np.array(values)
    valid = (bits >> np.arange(array.size) & 1).astype(bool).reshape(array.shape)
    found = aggregate(np.where(valid, array, 99.0), valid, how)
    for row, chosen, result in zip(array, valid, found, strict=True):
        if not chosen.any():
            assert np.isnan(result)
            continue
        level = quantile_level(how)
        expected = np.mean(row[chosen]) if how == "mean" else np.quantile(row[chosen], 1.0 if level is None else level)
        assert result == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("how", ["q", "q101", "median", "q-5", ""])
def test_unknown_aggregates(how: str) -> None:
    """The message lists what there is."""
    with pytest.raises(ValueError, match="mean, max or a quantile"):
        quantile_level(how)


def test_verdict_of_several_rollouts(table: Callable[..., Evaluations]) -> None:
    """One valid rollout makes the genome valid; without one, an error outweighs an invalid one."""
    found = table(
        [[VALID, EXHAUSTED], [ABORTED, EXHAUSTED], [ERROR, VALID], [EXHAUSTED, ERROR]], [[0.5, 0.0]] * 2 + [[2, 2]] * 2
    )
    assert found.verdict.tolist() == [VALID, ABORTED, VALID, ERROR]
    assert found.fitness[0] == found.rollouts.score[0, 0]
    assert np.isnan(found.fitness[[1, 3]]).all()


def test_figures_of_a_small_table(table: Callable[..., Evaluations]) -> None:
    """RL, NC, MDG, MDEC and NIS by hand: scores 22, 6 and 0, one invalid, one failed."""
    found = table([[VALID], [VALID], [VALID], [EXHAUSTED], [ERROR]], [[0.5], [2.0], [9.0], [1.0], [1.0]])
    total = figures(found, np.ones(5, dtype=bool))
    assert found.rollouts.score[:, 0].tolist() == [19, 6, 0, -1, -1]
    assert total.rl == pytest.approx(25 / 3)
    assert total.rl_all == pytest.approx(24 / 4)
    assert (total.nc, total.nis, total.errors, total.valid, total.individuals) == (1, 1, 1, 3, 5)
    assert total.mdg == pytest.approx(11 / 3)
    assert total.mdec == pytest.approx(5.5)
    assert total.collision_rate == pytest.approx(1 / 3)


def test_figures_count_genomes_and_rollouts(table: Callable[..., Evaluations]) -> None:
    """NC counts genomes with a collision, NIS genomes without a valid run; the runs stand beside them."""
    found = table(
        [[VALID, VALID, EXHAUSTED], [EXHAUSTED, EXHAUSTED, ABORTED], [VALID, ERROR, VALID]],
        [[0.1, 0.2, 0], [0, 0, 0], [3.0, 0, 5.0]],
    )
    total = figures(found, np.ones(3, dtype=bool))
    assert (total.nc, total.colliding_runs) == (1, 2)
    assert (total.nis, total.invalid_runs) == (1, 4)
    assert (total.errors, total.error_runs) == (0, 1)
    assert total.mdec == pytest.approx(4.0)


def test_no_rows_no_means(table: Callable[..., Evaluations]) -> None:
    """Figures of nothing are counts of zero and means that do not exist."""
    total = figures(table([[VALID]], [[1.0]]), np.zeros(1, dtype=bool))
    assert total.individuals == 0
    assert np.isnan([total.rl, total.rl_all, total.mdg, total.mdec, total.collision_rate]).all()


def test_worst_cases_are_ordered_and_distinct(table: Callable[..., Evaluations]) -> None:
    """By risk, then continuous risk, then age; a genome appears once, an elite's copy never."""
    found = table([[VALID]] * 6 + [[EXHAUSTED]], [[2.0], [0.5], [2.0], [0.25], [1.5], [0.5], [0.0]])
    found = replace(found, genomes=np.array([[0.0], [1], [2], [3], [4], [1], [6]]))
    cases = worst_cases(found)
    assert [case.row for case in cases] == [3, 1, 4, 0, 2]
    assert [case.rank for case in cases] == [1, 2, 3, 4, 5]
    reused = replace(found, reused=np.array([False, False, False, True, False, False, False]))
    assert [case.row for case in worst_cases(reused, 2)] == [1, 4]
    assert distinct_collisions(found) == 2


@given(
    st.lists(st.tuples(st.floats(0.0, 9.0), st.booleans()), min_size=1, max_size=9),
    st.sampled_from([None, Blame.AVOIDABLE, Blame.UNAVOIDABLE]),
    st.integers(1, 9),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_near_miss_is_above_a_collision_whatever_is_sought(
    table: Callable[..., Evaluations], runs: list[tuple[float, bool]], blamed: Blame | None, count: int
) -> None:
    """First avoidable collisions, then others, then near misses; among each by the objective."""
    distances = [[0.5 if collides else 9.0] for _, collides in runs]
    found = table([[VALID]] * len(runs), distances)
    collided = found.rollouts.collided[:, 0]
    aims = np.array([value for value, _ in runs])
    rollouts = replace(found.rollouts, sought=aims[:, None, None], continuous=aims[:, None])
    found = replace(found, rollouts=rollouts, fitness=aims)
    blame = np.full((len(runs), 1), int(Blame.NONE))
    if blamed is not None:
        blame[np.flatnonzero(collided)[::2], 0] = blamed
    groups = np.where(blame[:, 0] == Blame.AVOIDABLE, 0, np.where(collided, 1, 2))
    rows = order_of_risk(found, blame)
    keys = [(groups[row], -aims[row]) for row in rows]
    assert keys == sorted(keys)
    shown = [int(groups[case.row]) for case in worst_cases(found, count, blame)]
    assert shown == sorted(shown)
    assert min(shown[-1:], default=0) < 2 or sum(each < 2 for each in shown) == min(count, int(collided.sum()))


def test_worst_case_names_its_rollout(table: Callable[..., Evaluations]) -> None:
    """Of several rollouts the case is the riskiest, which a concrete copy can replay."""
    found = table([[VALID, VALID, EXHAUSTED, VALID]], [[5.0, 0.5, 0.0, 0.75]])
    (case,) = worst_cases(found)
    assert (case.rollout, case.score, case.collided) == (1, 19, True)


def test_dead_gene_is_found(spaces: Callable[..., ParamSpace], evaluators: Callable[..., Evaluate]) -> None:
    """A gene that changes nothing is called dead, the others are not; its effect is nil."""
    space = spaces([0, 5, 0], [1, 80, 3], [GeneKind.CONTINUOUS, GeneKind.CONTINUOUS, GeneKind.INDEX])
    for dead in (1, 2):
        genes = run(space, evaluators(space, dead=dead), SearchConfig(generations=3, population=40)).genes
        assert [gene.dead for gene in genes] == [number == dead for number in range(3)]
        assert genes[dead].effect == 0.0
        assert genes[0].effect > 0.1
        assert all(gene.probes == 32 for gene in genes)


def test_an_effect_is_compared_among_scenes_with_the_same_choices(
    spaces: Callable[..., ParamSpace], rows: Rows
) -> None:
    """One gene changes which of four lanes is drawn, and the lane decides the risk: by itself the gene does nothing.

    The other is worth two points in every lane. Where a case's own stream gives another lane, others are tried.
    """
    space = spaces([0, 0], [1, 1], names=["WINDOW", "SPEED"])

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        found = rows(np.zeros(len(keys), dtype=np.int32), np.full(len(keys), 5.0))
        lane = np.floor(np.mod(97.0 * genomes[:, 0] + 0.618 * (keys[:, 4] + 31 * keys[:, 5]), 1.0) * 4.0).astype(
            np.int32
        )
        return replace(found, variant=lane, continuous=3.0 * lane + 4.0 * np.abs(genomes[:, 1] - 0.5))

    window, speed = run(space, evaluate, SearchConfig(generations=4, population=40)).genes
    assert (window.changed, window.probes) == (32, 32)
    assert window.effect == pytest.approx(0.0, abs=1e-9)
    assert window.compared in range(20, 33)
    assert speed.compared == 32
    assert speed.effect > 0.5


def test_a_discrete_gene_may_be_the_choice_itself(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """What it does is then compared whatever was chosen; a continuous one without a comparison has no effect."""
    space = spaces([0, 0], [3, 1], [GeneKind.INDEX, GeneKind.CONTINUOUS])

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        found = rows(np.zeros(len(keys), dtype=np.int32), np.full(len(keys), 5.0))
        variant = (genomes[:, 0] + 10.0 * np.floor(1e6 * genomes[:, 1])).astype(np.int32)
        return replace(found, variant=variant, continuous=genomes[:, 0])

    option, place = run(space, evaluate, SearchConfig(generations=2, population=40)).genes
    assert (option.effect, option.compared) == (pytest.approx(2.0), 32)
    assert np.isnan(place.effect)
    assert place.compared == 0


def test_monotone_gene_correlates(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """Where risk rises with a gene alone, its rank correlation is near 1 and the worst cases crowd its upper end."""
    space = spaces([0, 0], [10, 1])

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        found = rows(np.zeros(len(keys), dtype=np.int32), 12.0 - genomes[:, 0])
        return replace(found, score=np.floor(2 * genomes[:, 0]).astype(np.int32))

    steep, idle = run(space, evaluate, SearchConfig(generations=5, population=60)).genes
    assert steep.correlation > 0.98
    assert abs(idle.correlation) < 0.2
    assert steep.worst.low > 8.5
    assert steep.concentration > 0.8 > idle.concentration
    assert idle.dead


def test_probes_are_beside_the_budget(space: ParamSpace, evaluators: Callable[..., Evaluate]) -> None:
    """With or without probes the evaluations and figures are the same, and probes reuse the cases' own keys."""
    evaluate = evaluators(space)
    keys_seen = []

    def watching(genomes: Floats, keys: Ints) -> Assessment:
        keys_seen.append(keys)
        return evaluate(genomes, keys)

    with_probes = run(space, watching, SearchConfig(generations=2, population=40, probes=5))
    without = run(space, evaluate, SearchConfig(generations=2, population=40, probes=0))
    assert with_probes.generations == without.generations
    assert len(keys_seen) == 3
    assert len(keys_seen[2]) == 5 * len(space)
    known = {tuple(key) for keys in keys_seen[:2] for key in keys}
    assert {tuple(key) for key in keys_seen[2]} <= known
    assert np.isnan(without.genes[0].effect)


def test_take_keeps_rows_together(table: Callable[..., Evaluations]) -> None:
    """Taking rows takes them from every array, nested ones too."""
    found = table([[VALID]] * 4, [[1.0], [2.0], [3.0], [4.0]])
    part = take(found, np.array([2, 0]))
    assert part.genomes[:, 0].tolist() == [2.0, 0.0]
    assert part.rollouts.min_distance[:, 0].tolist() == [3.0, 1.0]


# -- with whom the ego collided ----------------------------------------------------------------------------------------


class Rollouts:
    """Five individuals of one rollout among three actors: two hits of actor 2, in the first after one of others, one of
    others alone, two without contact.
    """

    collided = np.array([[True], [True], [False], [False], [False]])
    pair = np.array([[1], [1], [0], [1], [-1]])
    others_contact_time = np.array([[1.5], [np.nan], [2.5], [np.nan], [np.nan]])


class Table:
    rollouts = Rollouts
    simulated = np.array([True, False, True, True, True])


def test_each_partner_is_counted_once_a_simulation() -> None:
    """A repeated elite is left out; who was only near is no partner; actor 1 was missed."""
    assert partners(Table, 3) == Partners((0, 1), 2)  # type: ignore[arg-type]


def test_nobody_is_a_partner_without_contact() -> None:
    """Although a pair decides their risk, too."""
    assert partner_of(Table).ravel().tolist() == [1, 1, NOBODY, NOBODY, NOBODY]  # type: ignore[arg-type]


def test_an_ego_alone_meets_nobody() -> None:
    """There is no pair at all."""
    assert partners(Table, 1).with_ego == ()  # type: ignore[arg-type]


def test_an_estimate_counts_partners_block_by_block() -> None:
    """Blocks that met other partners add up, whoever was met first."""
    first, second = Runs([0, 0, 1], [True, True, False]), Runs([2, 0], [True, True])
    count = Count().more(first).more(second)  # type: ignore[arg-type]
    assert count.by_partner == (3, 0, 1)
    assert (count.collisions, count.without_ego) == (4, 1)


class Runs:
    """One block of runs: whom each was nearest to, and whether it touched; in the others two others crashed."""

    def __init__(self, pair: list[int], collided: list[bool]) -> None:
        self.pair, self.collided = np.array(pair), np.array(collided)
        self.verdict = np.zeros(len(pair), dtype=np.int64)
        self.others_contact_time = np.where(self.collided, np.nan, 1.0)

    def __len__(self) -> int:
        return len(self.pair)
