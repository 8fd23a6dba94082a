"""From sampled, simulated and judged rows to assessments; and a whole search of a real scenario."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import load
from engine.assessment import take
from engine.config import Config, SearchConfig
from engine.outcomes import Assessment, Outcomes, blank_outcomes
from engine.risk import Risk
from engine.scenes import Scenes
from engine.search.evaluator import assessment, make_host
from engine.search.insight.gene_effects import probe_genes
from engine.search.protocol import Box
from engine.search.run import search
from engine.tables import Floats

EXAMPLE = Path(__file__).parents[3] / "examples" / "left_turn.scn"


def rows_of(pairs: int) -> Assessment:
    """Three rows, the last one invalid, with `pairs` pairs; metric of pair j in row i is 10 i + j (MD descending)."""
    grid = 10.0 * np.arange(3)[:, np.newaxis] + np.arange(pairs)
    grid[2] = np.nan
    verdict = np.array([0, 0, 2], dtype=np.int32)
    ints, counts = np.zeros(3, dtype=np.int32), np.zeros((3, 4), dtype=np.int64)
    scenes = Scenes(
        genomes=np.zeros((3, 1)),
        keys=np.zeros((3, 6), dtype=np.int64),
        verdict=verdict,
        variant=ints,
        values=np.zeros((3, 1)),
        draws=np.zeros((3, 1)),
        attempts=ints,
        tested=counts,
        failed=counts,
    )
    outcomes = blank_outcomes(
        3,
        max(2, pairs + 1),
        verdict=verdict,
        collided=np.array([True, False, False]),
        end_reason=ints,
        end_rule=ints,
        end_time=np.array([1.0, 2.0, np.nan]),
        steps=ints,
        min_distance=-grid,
        min_distance_time=grid + 0.1,
        max_closing_speed=grid + 0.2,
        max_closing_time=grid + 0.3,
        distance_at_ms=grid + 0.4,
        ttc_at_ms=grid + 0.5,
        ego_speed=grid + 0.6,
        other_speed=grid + 0.7,
        approach_angle=grid + 0.8,
        closing_speed=grid + 0.9,
        side=np.zeros((3, pairs), dtype=np.int32),
        left_road_time=np.array([[np.nan, np.nan], [3.0, 2.0], [np.nan, np.nan]]),
        contact_actors=np.zeros((3, 2), dtype=np.int32),
    )
    risk = Risk(
        score=np.array([14, 3, -1]),
        continuous=np.array([14.5, 3.5, -1.0]),
        parts=np.zeros((3, 4), dtype=np.int64),
        pair=np.array([0, 1, -1]) if pairs else np.full(3, -1),
    )
    return assessment(scenes, outcomes, risk)


def test_distance_is_the_least_and_speed_the_deciding_pairs() -> None:
    """MD is the least over pairs with the time that goes with it; MS and its kin are those of the deciding pair."""
    found = rows_of(2)
    assert found.min_distance[:2].tolist() == [-1.0, -11.0]
    assert found.min_distance_time[:2].tolist() == [1.1, 11.1]
    assert found.max_closing_speed[:2].tolist() == [0.2, 11.2]
    assert found.ttc_at_ms[:2].tolist() == [0.5, 11.5]
    assert np.isnan(found.left_road_time[[0, 2]]).all()
    assert found.left_road_time[1] == 2.0
    assert np.isnan([found.min_distance[2], found.continuous[2], found.distance_at_ms[2]]).all()
    assert found.score[2] == found.pair[2] == -1


def test_an_ego_alone_has_no_distances() -> None:
    """With one actor there is no pair: distances do not exist."""
    found = rows_of(0)
    assert np.isnan(found.min_distance).all()
    assert np.isnan(found.max_closing_speed).all()


def test_unknown_engine_and_profile() -> None:
    """Both say what there is."""
    program = load(EXAMPLE).program
    with pytest.raises(ValueError, match="batch or world"):
        make_host(program, Config(search=SearchConfig(engine="carla")))
    with pytest.raises(ValueError, match="paper-mm"):
        search(program, profile="papr")


def test_search_of_a_real_scenario() -> None:
    """Same seed, same campaign, on one thread or two; worst cases come out again from genome and key."""
    scenario = load(EXAMPLE)
    one, two = (scenario.search("ga", generations=4, population=25, seed=3, jobs=jobs) for jobs in (1, 2))
    for field in fields(Assessment):
        a, b = (getattr(found.evaluations.rollouts, field.name) for found in (one, two))
        np.testing.assert_array_equal(a, b, err_msg=field.name)
    assert one.worst == two.worst
    assert repr(one.genes) == repr(two.genes)
    assert 0.0 < one.by_individual.nis < 60
    worst = one.worst[0]
    again = scenario.assess(scenario.simulate(scenario.scene(worst)))
    assert (again.score[0], again.continuous[0]) == (worst.score, worst.continuous)


def test_probes_of_a_real_scenario_repeat_its_cases() -> None:
    """Moving a gene by nothing changes nothing: a probe differs from its case by the gene alone."""
    scenario = load(EXAMPLE)
    found = scenario.search("random", generations=1, population=30, probes=0)
    box = Box.of(scenario.program.space)
    point = Box(box.names, box.low, box.low, box.kinds)
    from engine.risk import PROFILES
    from engine.search.evaluator import make_evaluator

    evaluate = make_evaluator(scenario.program, scenario.config, PROFILES["paper"])
    still = probe_genes(point, take(found.evaluations, slice(None)), evaluate, 5)
    assert still is not None
    assert still.changed.tolist() == [0] * len(box)


def test_probes_compute_no_objective() -> None:
    """The effect of a gene is that on the risk; the risks are those of a search without the objective."""
    scenario, calls = load(EXAMPLE), []

    def nearest(outcomes: Outcomes) -> Floats:
        calls.append(len(outcomes))
        return -outcomes.min_distance[:, 0]

    aimed = scenario.search("random", generations=1, population=30, probes=5, objective=nearest)
    plain = scenario.search("random", generations=1, population=30, probes=5)
    assert calls == [30]
    assert [gene.effect for gene in aimed.genes] == [gene.effect for gene in plain.genes]
