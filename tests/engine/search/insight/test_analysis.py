"""Sobol' indices against known ones, clusters with planted conditions, and the analysis of a real search."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import load
from engine.assessment import Evaluate, map_arrays
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.sampling import draw_genomes
from engine.search.evaluations import Evaluations
from engine.search.insight import clusters as fresh_draws
from engine.search.insight.analysis import analyse
from engine.search.insight.clusters import Condition, FreshDraws, clusters
from engine.search.insight.sensitivity import sensitivity
from engine.streams import key_rows
from engine.tables import Floats, Ints
from engine.vocabulary import GeneKind, Method, Verdict
from tests.engine.search.conftest import evaluated

Rows = Callable[[Ints, Floats], Assessment]
EXAMPLE = Path(__file__).parents[4] / "examples" / "left_turn.scn"


def valued(rows: Rows, function: Callable[[Floats, Ints], Floats]) -> Evaluate:
    """Valid runs whose continuous risk is a function of genome and key; above 1 is a collision."""

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        value = function(genomes, keys)
        runs = rows(np.zeros(len(keys), dtype=np.int32), np.ones(len(keys)))
        return replace(runs, continuous=value, collided=value > 1.0)

    return evaluate


def noise(keys: Ints) -> Floats:
    """(n,) uniform numbers in [0, 1) that depend on each key alone."""
    state = np.zeros(len(keys), dtype=np.uint64)
    for column in range(keys.shape[1]):
        state = (state ^ keys[:, column].astype(np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
        state ^= state >> np.uint64(29)
    state = (state ^ (state >> np.uint64(31))) * np.uint64(0xBF58476D1CE4E5B9)
    return ((state ^ (state >> np.uint64(32))) >> np.uint64(11)).astype(np.float64) * 2.0**-53


def test_indices_of_the_ishigami_function(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """Sin x + 7 sin^2 y + 0.1 z^4 sin x: its indices are known (Ishigami and Homma, 1990)."""
    space = spaces([-math.pi] * 3, [math.pi] * 3, names=["X", "Y", "Z"])
    found = sensitivity(space, valued(rows, ishigami), 40_960, seed=2)
    assert [index.name for index in found.risk.genes] == ["X", "Y", "Z"]
    for index, (first, total) in zip(found.risk.genes, ISHIGAMI, strict=True):
        assert index.first.value == pytest.approx(first, abs=0.03)
        assert index.total.value == pytest.approx(total, abs=0.03)
        assert index.total.interval.low <= index.total.value <= index.total.interval.high
    assert found.risk.chance.value == pytest.approx(0.0, abs=1e-12)
    assert found.simulations == found.rows * 10


ISHIGAMI = ((0.3139, 0.5576), (0.4424, 0.4424), (0.0, 0.2437))


def ishigami(x: Floats, keys: Ints) -> Floats:
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def test_intervals_cover_the_truth(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """Over forty designs, under noise as large as the function: intervals hold the truth nearly as often as said."""
    space = spaces([-math.pi] * 3, [math.pi] * 3)
    variance, repetitions = 13.8446, 40
    deviation = math.sqrt(12.0 * variance)

    def noisy(x: Floats, keys: Ints) -> Floats:
        return ishigami(x, keys) + deviation * noise(keys)

    hits = np.zeros((3, 2))
    chance = 0
    for seed in range(repetitions):
        found = sensitivity(space, valued(rows, noisy), 5_120, seed=seed).risk
        for gene, (index, truth) in enumerate(zip(found.genes, ISHIGAMI, strict=True)):
            for k, share in enumerate((index.first, index.total)):
                hits[gene, k] += share.interval.low <= truth[k] / 2.0 <= share.interval.high
        chance += found.chance.interval.low <= 0.5 <= found.chance.interval.high
    assert hits.min() >= 0.85 * repetitions
    assert chance >= 0.85 * repetitions


def test_chance_is_distinguished_from_genes(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """Half of the variance comes from the stream key: no gene may claim it."""
    found = sensitivity(spaces([0.0], [1.0]), valued(rows, lambda x, keys: x[:, 0] + noise(keys)), 8_192).risk
    assert found.genes[0].total.value == pytest.approx(0.5, abs=0.06)
    assert found.genes[0].first.value == pytest.approx(0.5, abs=0.06)
    assert found.chance.value == pytest.approx(0.5, abs=0.06)


def test_a_gene_that_only_changes_which_attempt_is_accepted_explains_nothing(
    spaces: Callable[..., ParamSpace], rows: Rows
) -> None:
    """A window decides which attempt at a scene passes; the lane that this one drew has nothing to do with it.

    Under one stream key, moving the window changes the lane nearly always, and the risk with it. Over chance it changes
    nothing: half of the variance is the speed's, half is the lane's, and the lane is chance.
    """
    space = spaces([0.0, 0.0], [1.0, 1.0], names=["WINDOW", "SPEED"])

    def accepted(x: Floats, keys: Ints) -> Floats:
        lane = np.full(len(keys), np.nan)
        for attempt in range(400):
            placed, drawn = (noise(keys + np.array([0, 0, 0, 1000 * attempt + k, 0, 0])) for k in (300, 600))
            passes = np.isnan(lane) & (np.mod(placed - x[:, 0], 1.0) < 0.1)
            lane[passes] = drawn[passes]
        return lane

    window, speed = sensitivity(space, valued(rows, lambda x, keys: accepted(x, keys) + x[:, 1]), 4_096).risk.genes
    assert window.total.value == pytest.approx(0.0, abs=0.1)
    assert speed.total.value == pytest.approx(0.5, abs=0.1)
    keys = key_rows(5, 0, 0, 0, range(500))
    here, there = (accepted(np.full((500, 2), place), keys) for place in (0.2, 0.6))
    assert (here != there).mean() > 0.8  # what a design under one key would have called the window's effect


def test_what_never_varies_has_no_index(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    found = sensitivity(spaces([0.0], [1.0]), valued(rows, lambda x, keys: np.ones(len(x))), 500)
    for indices in (found.validity, found.risk, found.collision):
        assert math.isnan(indices.genes[0].total.value)
        assert math.isnan(indices.chance.interval.low)


def test_what_makes_a_scene_possible_is_distinguished_from_what_makes_it_risky(
    spaces: Callable[..., ParamSpace], rows: Rows
) -> None:
    """One gene decides alone whether there is a run, another alone how risky it is: no part for the other."""

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        verdict = np.where(genomes[:, 0] < 0.5, int(Verdict.EXHAUSTED), 0).astype(np.int32)
        runs = rows(verdict, np.full(len(keys), 5.0))
        return replace(runs, continuous=np.where(verdict == 0, genomes[:, 1], np.nan))

    found = sensitivity(spaces([0.0, 0.0], [1.0, 1.0]), evaluate, 4_096)
    assert [gene.total.value for gene in found.validity.genes] == pytest.approx([1.0, 0.0], abs=0.02)
    assert [gene.total.value for gene in found.risk.genes] == pytest.approx([0.0, 1.0], abs=0.05)
    assert math.isnan(found.collision.genes[0].total.value)
    assert found.valid_share == pytest.approx(0.5, abs=0.01)


def test_nothing_valid_is_no_index(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    def never(genomes: Floats, keys: Ints) -> Assessment:
        return rows(np.full(len(keys), int(Verdict.EXHAUSTED), dtype=np.int32), np.ones(len(keys)))

    found = sensitivity(spaces([0.0], [1.0]), never, 500)
    assert math.isnan(found.risk.genes[0].total.value)
    assert math.isnan(found.collision_share)


# -- clusters ---------------------------------------------------------------------------------------------------------

Region = Callable[[Floats], np.ndarray]


@pytest.fixture
def three(spaces: Callable[..., ParamSpace]) -> ParamSpace:
    kinds = [GeneKind.CONTINUOUS, GeneKind.CONTINUOUS, GeneKind.INDEX]
    return spaces([0.0, 0.0, 0.0], [10.0, 1.0, 2.0], kinds, ["A", "B", "C"])


def drawn(seed: int, count: int) -> Floats:
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(0, 10, count), rng.uniform(0, 1, count), rng.integers(0, 3, count)]).astype(
        float
    )


def searched(rows: Rows, genomes: Floats, collided: np.ndarray) -> Evaluations:
    runs = rows(np.zeros(len(genomes), dtype=np.int32), np.where(collided, 0.5, 3.0))
    return evaluated(genomes, map_arrays(runs, lambda array: array[:, np.newaxis]))


def failing(rows: Rows, region: Region, inside: float = 1.0, outside: float = 0.0) -> Evaluate:
    """Runs that fail with these probabilities within and outside of a region."""

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        hit = noise(keys + 7) < np.where(region(genomes), inside, outside)
        return rows(np.zeros(len(genomes), dtype=np.int32), np.where(hit, 0.5, 3.0))

    return evaluate


def test_planted_groups_are_found_with_their_conditions(rows: Rows, three: ParamSpace) -> None:
    """A > 8 and B < 0.3, or A < 2 and B > 0.8: conditions under which fresh draws fail, the larger group first."""
    genomes = drawn(4, 3000)

    def region(x: Floats) -> np.ndarray:
        return ((x[:, 0] > 8) & (x[:, 1] < 0.3)) | ((x[:, 0] < 2) & (x[:, 1] > 0.8))

    found = clusters(searched(rows, genomes, region(genomes)), three, failing(rows, region))
    assert sum(len(cluster.rows) for cluster in found) == int(region(genomes).sum())
    sizes = [len(cluster.rows) for cluster in found]
    assert sizes == sorted(sizes, reverse=True)
    for cluster in found:
        assert cluster.coverage > 0.6
        assert cluster.fresh.share > 0.6
        assert cluster.base.share == pytest.approx(0.1, abs=0.03)
        assert cluster.lift > 6.0
        assert cluster.example in cluster.rows


@pytest.mark.parametrize("wanted", [1, 50, 300])
def test_draws_under_a_condition_are_the_first_whatever_is_drawn_at_once(
    rows: Rows, three: ParamSpace, monkeypatch: pytest.MonkeyPatch, wanted: int
) -> None:
    """A twentieth of 4,000 draws meets the condition: as many as are wanted, or all of them."""
    monkeypatch.setattr(fresh_draws, "LOOKED_AT", 4096)
    rule = (Condition(0, 9.5, math.inf),)
    found = []
    for at_once in (1, 64, 4096):
        monkeypatch.setattr(fresh_draws, "AT_ONCE", at_once)
        genomes, runs = FreshDraws(three, failing(rows, lambda x: x[:, 1] > 0.5), 3).draws(1, wanted, rule)
        assert len(genomes) == len(runs)
        found.append((genomes, runs.collided))
    for genomes, collided in found[1:]:
        np.testing.assert_array_equal(genomes, found[0][0])
        np.testing.assert_array_equal(collided, found[0][1])
    keys = key_rows(3, int(Method.SAMPLE), fresh_draws.FRESH_RUN, 1, range(4096))
    expected = draw_genomes(three, keys)
    np.testing.assert_array_equal(found[0][0], expected[expected[:, 0] >= 9.5][:wanted])


def test_without_lift_there_is_no_condition(rows: Rows, three: ParamSpace) -> None:
    """A search that looked in one corner alone finds its failures there, though all others fail as often."""
    genomes = drawn(4, 2000) * np.array([0.2, 0.2, 1.0])
    everywhere = failing(rows, lambda x: np.ones(len(x), dtype=bool), 0.2)
    runs = everywhere(genomes, key_rows(9, 0, 0, 0, range(len(genomes))))
    for cluster in clusters(searched(rows, genomes, runs.collided), three, everywhere):
        assert cluster.conditions == ()
        assert cluster.fresh.valid == 0


def test_the_interval_told_is_of_draws_that_decided_nothing(rows: Rows, three: ParamSpace) -> None:
    """Of forty seeds at least nine tenths hold the share that is known: a fifth within A > 5, a twentieth outside."""

    def region(x: Floats) -> np.ndarray:
        return x[:, 0] > 5.0

    evaluate, genomes = failing(rows, region, 0.2, 0.05), drawn(3, 1500)
    runs = evaluate(genomes, key_rows(5, 0, 0, 0, range(len(genomes))))
    table, holds = searched(rows, genomes, runs.collided), []
    for seed in range(20):
        for cluster in clusters(table, three, evaluate, seed):
            if cluster.conditions:
                low, high = next(((c.low, c.high) for c in cluster.conditions if c.gene == 0), (0.0, 10.0))
                low, high = max(low, 0.0), min(high, 10.0)
                inside = max(0.0, high - max(low, 5.0)) / (high - low)
                truth = 0.2 * inside + 0.05 * (1.0 - inside)
                holds.append(cluster.fresh.interval.low <= truth <= cluster.fresh.interval.high)
    assert len(holds) >= 10
    assert np.mean(holds) >= 0.9


def test_an_option_can_be_a_condition(rows: Rows, three: ParamSpace) -> None:
    """Whatever the numbers are: option 1 fails."""
    genomes = drawn(1, 600)

    def region(x: Floats) -> np.ndarray:
        return x[:, 2] == 1.0

    for cluster in clusters(searched(rows, genomes, region(genomes)), three, failing(rows, region)):
        (condition,) = [condition for condition in cluster.conditions if condition.gene == 2]
        assert (condition.low, condition.high) == (1.0, 1.0)
        assert cluster.fresh.share == 1.0


def test_groups_follow_from_the_seed_and_small_ones_are_one(rows: Rows, three: ParamSpace) -> None:
    """The same search, the same groups; few failures are not grouped, none give none."""
    genomes = drawn(2, 900)
    evaluate = failing(rows, lambda x: x[:, 0] > 7)
    table = searched(rows, genomes, genomes[:, 0] > 7)
    assert clusters(table, three, evaluate, 1) == clusters(table, three, evaluate, 1)
    assert len(clusters(searched(rows, genomes, np.arange(900) < 5), three, evaluate)) == 1
    assert clusters(searched(rows, genomes, np.zeros(900, dtype=bool)), three, evaluate) == ()


# -- a real search ----------------------------------------------------------------------------------------------------


def test_a_search_is_understood() -> None:
    """Everything fits together: counts, grids, kinds, avoidability of the worst."""
    scenario = load(EXAMPLE)
    campaign = scenario.search("random", generations=4, population=100, probes=0)
    found = analyse(scenario.program, campaign.evaluations, scenario.config, budget=640)
    assert found.failures == campaign.by_simulation.nc
    assert found.came == campaign.failures
    assert sum(kind.count for kind in found.kinds) == found.failures
    assert sum(len(cluster.rows) for cluster in found.clusters) == found.failures
    for grid in found.grids:
        assert int(grid.runs.sum()) == campaign.by_simulation.valid_runs
        assert int(grid.failures.sum()) == found.failures
        assert grid.qd_score > 0.0
    assert found.avoided.driven == found.failures
    assert found.avoided.avoidable == found.came.avoidable
    assert found.avoided.struck == found.came.struck
    assert sum(found.avoided.by.values()) == found.avoided.driven
    for case, answer in zip(found.worst, found.avoidability, strict=True):
        assert (answer is not None) == case.collided
    assert found.sensitivity is not None
    assert found.sensitivity.simulations <= 640
