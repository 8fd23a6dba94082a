"""Plain Monte Carlo and subset simulation, each against the truth and against the other."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine.assessment import Evaluate
from engine.outcomes import Assessment
from engine.program import ParamSpace
from engine.search.probability.estimates import MOST_DRIVEN
from engine.search.probability.monte_carlo import CONDITIONS, estimate, monte_carlo, subset_simulation
from engine.tables import Floats, Ints
from engine.vocabulary import Verdict

Rows = Callable[[Ints, Floats], Assessment]


@pytest.fixture
def corner(rows: Rows) -> Callable[[float], Evaluate]:
    """A collision where both genes of the unit square lie above a bound; nearer runs lie nearer to that corner."""

    def make(bound: float) -> Evaluate:
        def evaluate(genomes: Floats, keys: Ints) -> Assessment:
            distance = np.maximum(bound - genomes.min(axis=1), 0.0)
            runs = rows(np.where(genomes[:, 0] < 0.2, int(Verdict.EXHAUSTED), 0).astype(np.int32), 1.0 + distance)
            valid = runs.verdict == Verdict.VALID
            collided = valid & (distance == 0.0)
            return replace(runs, collided=collided, min_distance=np.where(valid, distance, np.nan))

        return evaluate

    return make


@pytest.fixture
def square(spaces: Callable[..., ParamSpace]) -> ParamSpace:
    return spaces([0.0, 0.0], [1.0, 1.0])


def truth(bound: float) -> float:
    """Given that the first gene is at least 0.2."""
    return (1.0 - bound) ** 2 / 0.8


def test_monte_carlo_covers_the_truth(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    """Invalid draws are conditioned out, and the share of valid ones is returned."""
    found = monte_carlo(square, corner(0.7), 20_000, seed=3)
    assert found.interval.low <= truth(0.7) <= found.interval.high
    assert found.valid_share == pytest.approx(0.8, abs=0.01)
    assert found.value == found.collisions / found.valid


def test_subset_simulation_finds_what_is_rare(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    """One in eight million, with a few ten thousand runs; levels come ever nearer."""
    found = subset_simulation(square, corner(0.9997), 10_000, seed=1)
    assert found.interval.low <= truth(0.9997) <= found.interval.high
    assert found.value == pytest.approx(truth(0.9997), rel=0.4)
    assert found.simulations < 120_000
    assert list(found.levels) == sorted(found.levels, reverse=True)
    assert found.levels[-1] == 0.0
    assert found.valid_share == pytest.approx(0.8, abs=0.02)


def test_both_agree(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    """Where plain Monte Carlo still sees enough, the two intervals overlap."""
    plain = monte_carlo(square, corner(0.97), 60_000, seed=5)
    chains = subset_simulation(square, corner(0.97), 10_000, seed=5)
    assert plain.interval.low < chains.interval.high
    assert chains.interval.low < plain.interval.high
    assert chains.value == pytest.approx(plain.value, rel=0.35)


def test_the_same_seed_gives_the_same_estimate(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    first, again, other = (subset_simulation(square, corner(0.95), 2_000, seed) for seed in (7, 7, 8))
    assert first == again
    assert first.value != other.value


def test_what_never_happens_has_no_interval(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    """No chain reaches contact where there is none; Monte Carlo bounds it from above."""
    found = subset_simulation(square, corner(2.0), 2_000)
    assert found.value == 0.0
    assert math.isnan(found.interval.high)
    plain = monte_carlo(square, corner(2.0), 2_000)
    assert (plain.value, plain.interval.low) == (0.0, 0.0)
    assert 0.0 < plain.interval.high < 0.01


def test_no_valid_scene_no_estimate(square: ParamSpace, rows: Rows) -> None:
    """Nothing is known of what cannot be."""

    def never(genomes: Floats, keys: Ints) -> Assessment:
        return rows(np.full(len(keys), int(Verdict.EXHAUSTED), dtype=np.int32), np.ones(len(keys)))

    assert math.isnan(monte_carlo(square, never, 100).value)
    assert math.isnan(subset_simulation(square, never, 1_000).value)


def test_too_few_samples_are_refused(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    with pytest.raises(ValueError, match="at least 1000"):
        subset_simulation(square, corner(0.5), 500)


def test_too_few_valid_runs_are_no_estimate(square: ParamSpace, rows: Rows) -> None:
    """Where chains cannot begin, the share of valid runs is that of what was drawn."""

    def rarely(genomes: Floats, keys: Ints) -> Assessment:
        verdicts = np.where(genomes[:, 0] < 0.999, int(Verdict.EXHAUSTED), 0).astype(np.int32)
        return rows(verdicts, np.ones(len(keys)))

    found = subset_simulation(square, rarely, 1_000)
    assert math.isnan(found.value)
    assert found.valid_share == found.valid / found.simulations == pytest.approx(0.001, abs=0.0008)


def test_an_avoidable_collision_has_its_own_probability(
    square: ParamSpace, corner: Callable[[float], Evaluate]
) -> None:
    """A driver who avoids whatever has its second gene below a bound: both estimators cover that share of the truth."""

    def judge(genomes: Floats, keys: Ints) -> np.ndarray:
        return genomes[:, 1] < 0.8

    plain = monte_carlo(square, corner(0.7), 20_000, seed=3, judge=judge)
    assert plain.driven == plain.collisions
    assert plain.avoidable_interval.low <= truth(0.7) / 3.0 <= plain.avoidable_interval.high
    for rare, bound in ((0.97, 0.98), (0.9, 0.92)):
        share = (bound - rare) / (1.0 - rare)
        found = subset_simulation(square, corner(rare), 10_000, seed=5, judge=lambda x, keys, b=bound: x[:, 1] < b)
        assert found.avoidable_interval.low <= truth(rare) * share <= found.avoidable_interval.high
        assert 0 < found.driven <= MOST_DRIVEN
    assert math.isnan(monte_carlo(square, corner(0.7), 500).avoidable)


def test_not_all_collisions_are_driven_again(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    """Of many, those of the first draws; the share is of the valid runs among these."""

    def judge(genomes: Floats, keys: Ints) -> np.ndarray:
        return genomes[:, 1] < 0.6

    found = monte_carlo(square, corner(0.2), 20_000, seed=1, judge=judge)
    assert found.driven <= MOST_DRIVEN < found.collisions
    assert found.avoidable == pytest.approx(0.5 * truth(0.2), abs=0.03)
    assert found.avoidable_interval.low <= 0.4 <= found.avoidable_interval.high


def test_enough_valid_runs_end_it(square: ParamSpace, corner: Callable[[float], Evaluate]) -> None:
    """Exactly as many as asked for, and no draw after the last of them."""
    found = monte_carlo(square, corner(0.7), 100_000, seed=3, enough=6_000)
    assert found.valid == 6_000
    assert found.simulations == pytest.approx(6_000 / 0.8, rel=0.03)
    assert found.interval.low <= truth(0.7) <= found.interval.high
    assert monte_carlo(square, corner(0.7), 1_000, seed=3, enough=6_000).simulations == 1_000


def test_params_that_seldom_allow_a_scene_count_less_under_the_joint_condition() -> None:
    """A fast ego is allowed five times as often as a slow one, and only a fast one crashes: the conditions differ.

    V is 5 or 25 m/s, the luck that the requirement looks at passes in 4 % or 20 % of attempts.
    """
    scenario = compile_text(UNEVEN, "uneven.scn")
    once, joint = (estimate(scenario.program, scenario.config, "mc", 4_000, 2, condition) for condition in CONDITIONS)
    assert (once.condition, once.max_attempts) == ("params", 2_000)
    assert (joint.condition, joint.max_attempts, joint.valid) == ("joint", 1, 4_000)
    assert once.interval.low <= 0.5 <= once.interval.high
    assert joint.interval.low <= 5.0 / 6.0 <= joint.interval.high
    assert joint.valid_share == pytest.approx(0.12, abs=0.02)
    with pytest.raises(ValueError, match="mc"):
        estimate(scenario.program, scenario.config, "subset", 1_000, 0, "joint")


UNEVEN = """\
map intersection(ways=4, lanes=1, approach=50 m)
param FAST = DiscreteRange(0, 1)
luck = Range(0, 1)
ego = new Car at (1.75, -40), facing 90 deg, with speed (5 m/s + FAST * 20 m/s)
other = new Car at (1.75, -8), facing 90 deg, with speed 5 m/s
require luck <= 0.04 + 0.16 * FAST
terminate after 4 s
"""


def test_broken_runs_are_counted_apart(square: ParamSpace, rows: Rows) -> None:
    """What a requirement on the run made invalid did run, and is counted by itself."""

    def breaking(genomes: Floats, keys: Ints) -> Assessment:
        verdicts = np.where(genomes[:, 0] < 0.5, int(Verdict.ABORTED), 0).astype(np.int32)
        verdicts[genomes[:, 0] < 0.1] = int(Verdict.EXHAUSTED)
        return rows(verdicts, np.ones(len(keys)))

    found = monte_carlo(square, breaking, 2_000)
    assert found.aborted / found.simulations == pytest.approx(0.4, abs=0.05)
    assert found.valid / found.simulations == pytest.approx(0.5, abs=0.05)
    assert subset_simulation(square, breaking, 1_000).aborted > 0
