"""Rare events: intervals that hold the truth, and a reason where there can be none. (The full measure, 2,000 estimates
of each kind, is `python -m benchmarks.coverage`.)
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtri

from benchmarks.coverage import CASES, PLATEAU, SMOOTH, coverage, estimated, evaluated, space_of
from engine.errors import ArgumentError
from engine.search.probability.estimates import NOT_KNOWN, Probability, Withheld, keep, read_estimates
from engine.search.probability.importance import (
    DEFENCE,
    Mixture,
    effective_size,
    fitted,
    importance_sampling,
    nominal,
    together,
    widened,
)
from engine.search.probability.levels import DISTANCE, Chains, Climb, Score, climb
from engine.search.probability.monte_carlo import METHODS, RARE
from engine.search.probability.subset_simulation import _withheld, subset_simulation
from tests.laws import examples

CORNER = next(case for case in CASES if case.name == "corner")
CLIFF = next(case for case in CASES if case.name == "cliff")


@pytest.mark.parametrize("method", RARE)
@pytest.mark.parametrize("case", [case for case in CASES if case.kind == SMOOTH], ids=lambda case: case.name)
def test_intervals_hold_the_truth(case, method: str) -> None:
    """Of 16 estimates with a quarter of the budget at most four miss it: with 93.5 % that happens in one of 300."""
    found = coverage(case.name, method, 16, 3_000)
    assert math.isnan(found.holds) or found.given * found.holds >= found.given - 4 / 16
    assert found.apart <= 2 / 16


@pytest.mark.parametrize("method", RARE)
@pytest.mark.parametrize("case", [case for case in CASES if case.kind == PLATEAU], ids=lambda case: case.name)
def test_a_plateau_gets_a_reason_and_no_interval(case, method: str) -> None:
    for seed in range(10):
        found = estimated(case, method, 2_000, seed)
        assert (found.withheld, found.interval) == (Withheld.PLATEAU, NOT_KNOWN)
        assert math.isnan(found.value)
        assert found.tied > 0.05


def test_a_score_that_misleads_is_seen_by_its_repetitions() -> None:
    """Chains wander off to where nothing fails: some repetitions reach a failure, others none, or all differ."""
    misleading = next(case for case in CASES if case.name == "near miss, sloping")
    reasons = {estimated(misleading, "subset", 2_000, seed).withheld for seed in range(6)}
    assert reasons <= {Withheld.PARTLY, Withheld.SCATTERED, Withheld.PLATEAU, Withheld.UNREACHED}


@pytest.mark.parametrize(("apart", "reason"), [(0.94, Withheld.NOTHING), (0.96, Withheld.SCATTERED)])
def test_repetitions_that_differ_by_more_than_their_mean_are_no_sample(apart: float, reason: Withheld) -> None:
    """The standard deviation is that of a sample: half of ten at 1 - d and half at 1 + d have d * sqrt(10 / 9)."""
    climbs = [Climb(0.01 * (1.0 + side * apart), (), None) for side in (-1.0, 1.0) for _ in range(5)]
    assert _withheld(climbs) == reason


def test_a_chain_that_stays_is_no_plateau() -> None:
    """It repeats one run; these ties are not different ones."""
    found = climb(Chains(space_of(CORNER), lambda x, k: evaluated(CORNER, x, k), DISTANCE, 3, 1), 100)
    assert found.withheld == Withheld.NOTHING
    assert found.last is not None
    assert len(np.unique(found.last.near[~found.last.failed])) < (~found.last.failed).sum()


def test_the_same_seed_gives_the_same_weights() -> None:
    first, again, other = (estimated(CORNER, "importance", 2_000, seed) for seed in (1, 1, 2))
    assert first == again
    assert first.value != other.value


def test_what_can_be_avoided_has_its_share() -> None:
    """A driver who avoids whatever lies on one side of the diagonal avoids half of it."""
    found = importance_sampling(
        space_of(CORNER),
        lambda x, k: evaluated(CORNER, x, k),
        10_000,
        seed=4,
        judge=lambda x, keys: x[:, 0] > x[:, 1],
    )
    assert found.avoidable_interval.low <= CORNER.truth / 2.0 <= found.avoidable_interval.high
    assert 0 < found.driven <= found.collisions


@pytest.mark.parametrize("method", [subset_simulation, importance_sampling])
def test_any_score_leads_there(method) -> None:
    """Larger is nearer, and what failed is told apart: here a braking that comes too late, in seconds."""
    score = Score("late", "seconds to spare", "s", lambda runs: -2.0 * runs.min_distance, lambda runs: runs.collided)
    space, evaluate = space_of(CORNER), lambda x, k: evaluated(CORNER, x, k)
    found, by_distance = method(space, evaluate, 6_000, 2, score=score), method(space, evaluate, 6_000, 2)
    assert found.score == "late"
    assert found.value == pytest.approx(by_distance.value)
    assert found.levels == pytest.approx([2.0 * level for level in by_distance.levels])


def test_without_genes_only_chance_decides() -> None:
    """There is nothing to draw elsewhere: an honest reason, no crash."""
    alone = replace(CORNER, genes=0, left=lambda x, noise: 3.0 - noise)
    found = estimated(alone, "importance", 2_000, 0)
    assert found.withheld in (Withheld.FEW, Withheld.PARTLY)
    assert found.interval == NOT_KNOWN
    assert estimated(alone, "subset", 2_000, 0).withheld in (Withheld.PARTLY, Withheld.SCATTERED, Withheld.NOTHING)


@pytest.mark.parametrize("method", RARE)
def test_too_few_samples_are_refused(method: str) -> None:
    with pytest.raises(ArgumentError, match="at least 1000"):
        estimated(CORNER, method, 999, 0)


def test_reasons_are_kept_beside_a_journal(tmp_path: Path) -> None:
    """And read back as they were; what an earlier version wrote has none."""
    found = estimated(CLIFF, "subset", 1_000, 0)
    keep(tmp_path, found, "digest", 0)
    (again,) = read_estimates(tmp_path, "digest")
    assert again.withheld is Withheld.PLATEAU
    assert (again.tied, again.score) == (found.tied, "distance")
    assert {"mc", *RARE} == {*METHODS}


def test_old_estimates_have_no_reason() -> None:
    assert Probability("mc", 0.0, NOT_KNOWN, 0.95, 1, 1, 0, 1.0).withheld is Withheld.NOTHING


# -- mixtures ----------------------------------------------------------------------------------------------------------


@examples(30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.floats(-6.0, 6.0))
def test_no_weight_is_above_ten(seed: int, dimensions: int, middle: float) -> None:
    """The file's own distribution has a tenth of what is drawn, wherever the failures were."""
    numbers = np.random.default_rng(seed)
    density = _defended(numbers.normal(middle, 0.3, (200, dimensions)), numbers)
    points = numbers.normal(0.0, 4.0, (500, dimensions))
    assert (density.ratios(points) >= DEFENCE * (1.0 - 1e-12)).all()


@pytest.mark.parametrize("dimensions", [1, 2, 5])
def test_weights_of_a_density_have_a_mean_of_one(dimensions: int) -> None:
    numbers = np.random.default_rng(3)
    density = _defended(numbers.normal(1.0, 0.5, (500, dimensions)), numbers)
    weights = 1.0 / density.ratios(density.draw(numbers, 200_000))
    assert weights.mean() == pytest.approx(1.0, abs=5.0 * weights.std() / math.sqrt(len(weights)))


def test_islands_get_components_of_their_own() -> None:
    """None lies in between, however unequal they are."""
    for seed in range(20):
        numbers = np.random.default_rng(seed)
        places = np.where(numbers.uniform(size=600) < 0.2, -4.0, 4.0)
        fit = fitted(numbers.normal(0.0, 0.3, (600, 3)) + places[:, np.newaxis], numbers)
        assert (np.abs(np.abs(fit.means) - 4.0) < 0.5).all()
        assert fit.shares[fit.means[:, 0] < 0.0].sum() == pytest.approx(0.2, abs=0.06)


def test_effective_size_counts_equal_weights() -> None:
    assert effective_size(np.array([0.0, 2.0, 2.0, 2.0])) == pytest.approx(3.0)
    assert effective_size(np.array([1e6, 1.0, 1.0])) == pytest.approx(1.0, abs=1e-3)
    assert effective_size(np.zeros(3)) == effective_size(np.zeros(0)) == 0.0


def test_normal_numbers_are_the_quantiles() -> None:
    """A gene's uniform number and its standard normal one are the same place."""
    space = space_of(CORNER)
    points = np.random.default_rng(1).standard_normal((50, 2))
    chains = Chains(space, lambda x, k: evaluated(CORNER, x, k), DISTANCE, 0, 1)
    assert ndtri(chains.genomes(points)) == pytest.approx(points, abs=1e-9)


def _defended(points: np.ndarray, numbers: np.random.Generator) -> Mixture:
    fit = widened(fitted(points, numbers), 0.2)
    return together((DEFENCE, nominal(points.shape[1])), (1.0 - DEFENCE, fit))
