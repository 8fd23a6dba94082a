"""Sobol' indices against known ones, clusters with planted conditions, and the analysis of a real search."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl.session import load
from engine.program import ParamSpace
from engine.search.analysis import analyse
from engine.search.assessment import Assessment, Evaluate, map_arrays
from engine.search.clusters import clusters
from engine.search.evaluations import Evaluations, judge
from engine.search.protocol import Box
from engine.search.sensitivity import CHANCE, INVALID_RISK, sensitivity
from engine.tables import Floats, Ints
from engine.vocabulary import GeneKind, Verdict

Rows = Callable[[Ints, Floats], Assessment]
EXAMPLE = Path(__file__).parents[3] / "examples" / "left_turn.scn"


def valued(rows: Rows, function: Callable[[Floats, Ints], Floats]) -> Evaluate:
    """Valid runs whose continuous risk is a function of genome and key; above 1 is a collision."""

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        value = function(genomes, keys)
        runs = rows(np.zeros(len(keys), dtype=np.int32), np.ones(len(keys)))
        return replace(runs, continuous=value, collided=value > 1.0)

    return evaluate


def test_indices_of_the_ishigami_function(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """Sin x + 7 sin^2 y + 0.1 z^4 sin x: its indices are known (Ishigami and Homma, 1990)."""
    space = spaces([-math.pi] * 3, [math.pi] * 3, names=["X", "Y", "Z"])

    def ishigami(x: Floats, keys: Ints) -> Floats:
        return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    found = sensitivity(space, valued(rows, ishigami), 24_576, seed=2)
    assert [index.name for index in found.risk] == ["X", "Y", "Z", CHANCE]
    expected = {"X": (0.3139, 0.5576), "Y": (0.4424, 0.4424), "Z": (0.0, 0.2437), CHANCE: (0.0, 0.0)}
    for index in found.risk:
        first, total = expected[index.name]
        assert index.first == pytest.approx(first, abs=0.03)
        assert index.total == pytest.approx(total, abs=0.03)
        assert index.total_interval.low <= index.total <= index.total_interval.high
    assert found.simulations == found.rows * 6


def test_chance_is_told_from_genes(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """Half of the variance comes from the stream key: no gene may claim it."""
    space = spaces([0.0], [1.0])

    def noisy(x: Floats, keys: Ints) -> Floats:
        bits = (
            keys[:, 4].astype(np.uint64) + np.uint64(1) + keys[:, 3].astype(np.uint64) * np.uint64(7919)
        ) * np.uint64(0x9E3779B97F4A7C15)
        return x[:, 0] + (bits >> np.uint64(11)).astype(np.float64) * 2.0**-53

    gene, chance = sensitivity(space, valued(rows, noisy), 8_192).risk
    assert gene.total == pytest.approx(0.5, abs=0.06)
    assert chance.total == pytest.approx(0.5, abs=0.06)


def test_what_never_varies_has_no_index(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    found = sensitivity(spaces([0.0], [1.0]), valued(rows, lambda x, keys: np.ones(len(x))), 500)
    assert math.isnan(found.risk[0].total)
    assert math.isnan(found.collision[0].total_interval.low)


def test_an_invalid_scene_has_the_papers_risk(spaces: Callable[..., ParamSpace], rows: Rows) -> None:
    """A gene that only decides what is possible matters, too."""

    def evaluate(genomes: Floats, keys: Ints) -> Assessment:
        verdict = np.where(genomes[:, 0] < 0.5, int(Verdict.EXHAUSTED), 0).astype(np.int32)
        return rows(verdict, np.full(len(keys), 5.0))

    found = sensitivity(spaces([0.0, 0.0], [1.0, 1.0]), evaluate, 4_000)
    assert INVALID_RISK == -1.0
    assert found.risk[0].total == pytest.approx(1.0, abs=0.02)
    assert found.risk[1].total == 0.0
    assert found.valid_share == pytest.approx(0.5, abs=0.01)


# -- clusters ---------------------------------------------------------------------------------------------------------


def searched(rows: Rows, genomes: Floats, collided: np.ndarray) -> Evaluations:
    count = len(genomes)
    runs = rows(np.zeros(count, dtype=np.int32), np.where(collided, 0.5, 3.0))
    rollouts = map_arrays(runs, lambda array: array[:, np.newaxis])
    verdict, fitness = judge(rollouts, "mean")
    places = np.stack([np.zeros(count), np.arange(count)], axis=1).astype(np.int32)
    return Evaluations(
        genomes=genomes,
        places=places,
        births=places,
        operator=np.zeros(count, dtype=np.int32),
        parents=np.full((count, 2, 2), -1, dtype=np.int32),
        reused=np.zeros(count, dtype=bool),
        verdict=verdict,
        fitness=fitness,
        keys=np.zeros((count, 1, 6), dtype=np.int64),
        rollouts=rollouts,
    )


BOX = Box(
    ("A", "B", "C"), (0.0, 0.0, 0.0), (10.0, 1.0, 2.0), (GeneKind.CONTINUOUS, GeneKind.CONTINUOUS, GeneKind.INDEX)
)


def test_planted_kinds_are_found_with_their_conditions(rows: Rows) -> None:
    """A > 8 and B < 0.2, or A < 2 and B > 0.8: two kinds, each with its own condition, the larger first."""
    rng = np.random.default_rng(4)
    genomes = np.column_stack([rng.uniform(0, 10, 3000), rng.uniform(0, 1, 3000), rng.integers(0, 3, 3000)])
    one = (genomes[:, 0] > 8) & (genomes[:, 1] < 0.3)
    two = (genomes[:, 0] < 2) & (genomes[:, 1] > 0.8)
    found = clusters(searched(rows, genomes, one | two), BOX)
    kinds = [{c.gene: (c.low, c.high) for c in cluster.conditions} for cluster in found]
    large = [kind for cluster, kind in zip(found, kinds, strict=True) if set(cluster.rows) <= set(np.flatnonzero(one))]
    assert large
    assert sum(len(cluster.rows) for cluster in found) == int((one | two).sum())
    sizes = [len(cluster.rows) for cluster in found]
    assert sizes == sorted(sizes, reverse=True)
    for cluster in found:
        assert cluster.coverage > 0.6
        assert cluster.precision > 0.6
        assert cluster.example in cluster.rows


def test_a_condition_is_judged_on_runs_that_it_was_not_grown_from(rows: Rows) -> None:
    """Failures that fill a corner are found again among others; failures by chance alone only seem to be somewhere."""
    rng = np.random.default_rng(4)
    genomes = np.column_stack([rng.uniform(0, 10, 2000), rng.uniform(0, 1, 2000), rng.integers(0, 3, 2000)])
    for real in clusters(searched(rows, genomes, genomes[:, 0] > 8), BOX):
        assert real.held_out.precision > 0.9
        assert real.held_out.coverage > 0.5
    for chance in clusters(searched(rows, genomes, rng.random(2000) < 0.05), BOX):
        assert chance.held_out.precision < chance.precision
    (alone,) = clusters(searched(rows, genomes, np.arange(2000) == 7), BOX)
    assert math.isnan(alone.held_out.precision)


def test_an_option_can_be_a_condition(rows: Rows) -> None:
    """Whatever the numbers are: option 1 fails."""
    rng = np.random.default_rng(1)
    genomes = np.column_stack([rng.uniform(0, 10, 600), rng.uniform(0, 1, 600), rng.integers(0, 3, 600)])
    for cluster in clusters(searched(rows, genomes, genomes[:, 2] == 1.0), BOX):
        (condition,) = [condition for condition in cluster.conditions if condition.gene == 2]
        assert (condition.low, condition.high) == (1.0, 1.0)
        assert cluster.precision == 1.0


def test_clusters_are_deterministic_and_small_ones_are_one(rows: Rows) -> None:
    """The same search, the same kinds; few failures are not grouped, none give none."""
    rng = np.random.default_rng(2)
    genomes = np.column_stack([rng.uniform(0, 10, 900), rng.uniform(0, 1, 900), rng.integers(0, 3, 900)])
    table = searched(rows, genomes, genomes[:, 0] > 7)
    assert clusters(table, BOX) == clusters(table, BOX)
    assert len(clusters(searched(rows, genomes, np.arange(900) < 5), BOX)) == 1
    assert clusters(searched(rows, genomes, np.zeros(900, dtype=bool)), BOX) == ()


# -- a real search ----------------------------------------------------------------------------------------------------


def test_a_search_is_understood() -> None:
    """Everything fits together: counts, grids, kinds, avoidability of the worst."""
    scenario = load(EXAMPLE)
    campaign = scenario.search("random", generations=4, population=100, probes=0)
    found = analyse(scenario.program, campaign.evaluations, scenario.config, budget=640)
    assert found.failures == campaign.by_simulation.nc
    assert 0 < len(found.distinct) <= found.failures
    assert sum(len(cluster.rows) for cluster in found.clusters) == found.failures
    for grid in found.grids:
        assert int(grid.runs.sum()) == campaign.by_simulation.valid_runs
        assert int(grid.failures.sum()) == found.failures
        assert grid.qd_score > 0.0
    assert found.avoided.driven == len(found.distinct)
    assert sum(found.avoided.by.values()) == found.avoided.driven
    for case, answer in zip(found.worst, found.avoidability, strict=True):
        assert (answer is not None) == case.collided
    assert found.sensitivity is not None
    assert found.sensitivity.simulations <= 640
