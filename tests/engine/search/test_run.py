"""The campaign loop over a toy world."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engine.assessment import Evaluate, concatenate, take
from engine.config import Config, GAConfig, SearchConfig
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.search.campaign import Campaign, Progress
from engine.search.methods.ga import PRESETS
from engine.search.protocol import Box, Operator
from engine.search.run import Task, run_campaign
from engine.search.searchers import SEARCHERS, build_searcher
from engine.tables import Floats, Ints
from engine.vocabulary import GeneKind, Method, Verdict
from tests.engine.search.conftest import assert_equal

SMALL = SearchConfig(generations=8, population=30, seed=5)
Evaluators = Callable[..., Evaluate]


def campaign(
    space: ParamSpace,
    evaluate: Evaluate,
    method: str = "ga",
    config: SearchConfig = SMALL,
    ga: GAConfig = PRESETS["cortex"],
    **options: Any,
) -> Campaign:
    """Run a campaign of a method over a toy."""
    searcher = build_searcher(method, Box.of(space), Config(search=config, ga=ga))
    return run_campaign(Task(space, evaluate, config, method), searcher, **options)


def in_chunks(evaluate: Evaluate, size: int) -> Evaluate:
    """The same evaluator working on a few rows at a time, last rows first, as threads might."""

    def chunked(genomes: Floats, keys: Ints) -> Assessment:
        parts = [
            evaluate(genomes[start : start + size], keys[start : start + size])
            for start in reversed(range(0, len(keys), size))
        ]
        return concatenate(parts[::-1])

    return chunked


@pytest.mark.parametrize("method", ["ga", "random"])
@pytest.mark.parametrize("rollouts", [1, 3])
def test_same_seed_same_campaign(space: ParamSpace, evaluators: Evaluators, method: str, rollouts: int) -> None:
    """However the work is cut up, the same seed finds the same."""
    config = replace(SMALL, rollouts=rollouts)
    evaluate = evaluators(space)
    whole = campaign(space, evaluate, method, config)
    cut = campaign(space, in_chunks(evaluate, 7), method, replace(config, jobs=4))
    assert_equal(whole.evaluations, cut.evaluations)
    assert whole.generations == cut.generations
    assert whole.worst == cut.worst
    assert repr(whole.genes) == repr(cut.genes)


@pytest.mark.parametrize("change", [{"seed": 6}, {"run": 1}])
def test_other_seed_or_run_other_campaign(space: ParamSpace, evaluators: Evaluators, change: dict[str, int]) -> None:
    """Seed and run both name streams of their own."""
    first = campaign(space, evaluators(space))
    second = campaign(space, evaluators(space), config=replace(SMALL, **change))
    assert not np.isin(first.evaluations.genomes[:, 0], second.evaluations.genomes[:, 0]).any()


def test_methods_share_no_stream(space: ParamSpace, evaluators: Evaluators) -> None:
    """The baseline's first generation is not that of the genetic algorithm."""
    ga, random = (campaign(space, evaluators(space), method) for method in ("ga", "random"))
    assert not np.isin(ga.evaluations.genomes[:, 0], random.evaluations.genomes[:, 0]).any()
    assert set(ga.evaluations.keys[..., 1].flat) == {Method.GA}
    assert set(random.evaluations.keys[..., 1].flat) == {Method.RANDOM}


def test_keys_are_births(space: ParamSpace, evaluators: Evaluators) -> None:
    """Seed, method, run, birth and rollout make the key of each simulation; no two simulations share one."""
    found = campaign(space, evaluators(space), config=replace(SMALL, rollouts=2, run=4)).evaluations
    assert np.array_equal(found.keys[:, :, 3:5], np.repeat(found.births[:, np.newaxis], 2, axis=1))
    assert np.array_equal(found.keys[:, :, 5], np.tile([0, 1], (len(found), 1)))
    assert set(map(tuple, found.keys[:, :, :3].reshape(-1, 3))) == {(5, Method.GA, 4)}
    new = found.keys[found.simulated].reshape(-1, 6)
    assert len(np.unique(new, axis=0)) == len(new)


def test_elites_are_not_simulated_again(space: ParamSpace, evaluators: Evaluators) -> None:
    """A reused row repeats its birth's genome and result, and costs no evaluation."""
    simulated = []
    evaluate = evaluators(space)

    def counting(genomes: Floats, keys: Ints) -> Assessment:
        simulated.append(len(keys))
        return evaluate(genomes, keys)

    found = campaign(space, counting, config=replace(SMALL, probes=0)).evaluations
    elites = np.flatnonzero(found.reused)
    assert len(elites) > 5
    assert np.array_equal(found.reused, found.operator == Operator.ELITE)
    assert sum(simulated) == len(found) - len(elites)
    origin = found.births[elites, 0] * SMALL.population + found.births[elites, 1]
    assert np.array_equal(found.genomes[elites], found.genomes[origin])
    assert_equal(take(found.rollouts, elites), take(found.rollouts, origin))
    assert not found.reused[origin].any()


def test_search_beats_chance(space: ParamSpace, evaluators: Evaluators) -> None:
    """On a smooth landscape the genetic algorithm finds more collisions and fewer invalid cases than chance."""
    config = replace(SMALL, generations=15, population=60, probes=0)
    ga, random = (campaign(space, evaluators(space), method, config) for method in ("ga", "random"))
    assert ga.by_individual.rl > random.by_individual.rl + 1
    assert ga.by_simulation.nc > random.by_simulation.nc
    assert ga.last(5).nis < random.last(5).nis / 2
    assert ga.by_simulation.individuals < ga.by_individual.individuals == random.by_simulation.individuals == 900


def test_presets_give_different_campaigns(space: ParamSpace, evaluators: Evaluators) -> None:
    """The tournament climbs faster than uniform parents."""
    config = replace(SMALL, generations=15, population=60, probes=0)
    cortex, literal = (campaign(space, evaluators(space), "ga", config, ga) for ga in PRESETS.values())
    np.testing.assert_array_equal(cortex.evaluations.genomes[:60], literal.evaluations.genomes[:60])
    assert cortex.by_individual.rl > literal.by_individual.rl


def test_errors_are_never_scored(space: ParamSpace, evaluators: Evaluators) -> None:
    """A failure of the engine is neither valid nor invalid, and never a parent or a worst case."""
    found = campaign(space, evaluators(space, error_above=0.8))
    failed = found.evaluations.failed
    assert 0.1 < failed.mean() < 0.3
    assert found.by_individual.errors == failed.sum()
    assert found.by_individual.valid + found.by_individual.nis + found.by_individual.errors == len(failed)
    assert np.isnan(found.evaluations.fitness[failed]).all()
    parents = found.evaluations.parents[found.evaluations.parents[:, :, 0] >= 0]
    assert not failed[parents[:, 0] * SMALL.population + parents[:, 1]].any()
    assert not any(failed[case.row] for case in found.worst)


def test_progress_is_reported_after_each_generation(space: ParamSpace, evaluators: Evaluators) -> None:
    """Figures, best case so far, pace and time left, in order."""
    heard: list[Progress] = []
    found = campaign(space, evaluators(space), on_generation=heard.append)
    assert [progress.generation for progress in heard] == list(range(8))
    assert [progress.figures for progress in heard] == list(found.generations)
    assert heard[-1].simulations == found.by_simulation.runs
    assert heard[-1].remaining == 0.0 < heard[0].remaining
    assert heard[0].simulations_per_second > 0
    best = [(progress.best.score, progress.best.continuous) for progress in heard if progress.best]
    assert best == sorted(best)
    assert heard[-1].best == found.worst[0]
    assert_equal(concatenate([progress.evaluations for progress in heard]), found.evaluations)


def test_interrupt_keeps_finished_generations(space: ParamSpace, evaluators: Evaluators) -> None:
    """Ctrl-C in the middle of a generation leaves those before it, exactly as an undisturbed run has them."""
    evaluate = evaluators(space)
    calls = []

    def interrupted(genomes: Floats, keys: Ints) -> Assessment:
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return evaluate(genomes, keys)

    whole, cut = campaign(space, evaluate), campaign(space, interrupted)
    assert cut.stopped
    assert not whole.stopped
    assert cut.generations == whole.generations[:3]
    assert_equal(cut.evaluations, take(whole.evaluations, slice(0, 90)))
    assert all(gene.probes == 0 for gene in cut.genes)


def test_interrupt_before_anything_is_passed_on(space: ParamSpace) -> None:
    """With no generation finished there is nothing to give back."""

    def interrupted(genomes: Floats, keys: Ints) -> Assessment:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        campaign(space, interrupted)


def test_nothing_valid_is_a_campaign_too(
    space: ParamSpace, rows: Callable[[Ints, Floats], Assessment], evaluators: Evaluators
) -> None:
    """If every case is invalid, the figures say so and nothing fails."""

    def hopeless(genomes: Floats, keys: Ints) -> Assessment:
        return rows(np.full(len(keys), int(Verdict.INFEASIBLE), dtype=np.int32), np.zeros(len(keys)))

    found = campaign(space, hopeless)
    assert found.by_individual.nis == 240
    assert np.isnan(found.by_individual.rl)
    assert found.by_individual.rl_all == -1.0
    assert found.worst == ()
    assert {gene.probes for gene in found.genes} == {0}
    assert set(found.evaluations.operator) == {Operator.RANDOM}


def test_scenario_without_genes(spaces: Callable[..., ParamSpace], evaluators: Evaluators) -> None:
    """Without genes a search draws scene after scene of the one case."""
    space = spaces([], [])
    for method in SEARCHERS:
        found = campaign(space, evaluators(space), method)
        assert found.evaluations.genomes.shape == (240, 0)
        assert found.genes == ()


def test_index_and_integer_genes_stay_whole(spaces: Callable[..., ParamSpace], evaluators: Evaluators) -> None:
    """Discrete genes hold options only, also in probes."""
    space = spaces([0, 0, 2], [1, 4, 3], [GeneKind.CONTINUOUS, GeneKind.INDEX, GeneKind.INTEGER])
    evaluate = evaluators(space)
    seen = []

    def watching(genomes: Floats, keys: Ints) -> Assessment:
        seen.append(genomes[:, 1:])
        return evaluate(genomes, keys)

    campaign(space, watching)
    genomes = np.concatenate(seen)
    assert np.array_equal(genomes, np.floor(genomes))
    assert set(genomes[:, 0]) == {0, 1, 2, 3, 4}
    assert set(genomes[:, 1]) == {2, 3}


def test_settings_out_of_range(space: ParamSpace, evaluators: Evaluators) -> None:
    """Nonsense is refused before the first simulation, with the reason."""
    for change, message in (
        ({"population": 0}, "at least 1"),
        ({"generations": 70_000}, "65536"),
        ({"aggregate": "median"}, "q90"),
    ):
        with pytest.raises(ValueError, match=message):
            campaign(space, evaluators(space), config=replace(SMALL, **change))
    with pytest.raises(ValueError, match="ga, random"):
        build_searcher("gaa", Box.of(space), Config())
