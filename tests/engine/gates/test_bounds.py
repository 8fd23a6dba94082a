"""A bound judges the result that a run has, of every pair; no result, no breach."""

from pathlib import Path

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.api.limits import bound_of, budget_of, probability_of
from engine.errors import ArgumentError
from engine.gates.bounds import UNITS, Bound, bounded_values
from engine.vocabulary import Verdict

EXAMPLE = Path(__file__).parents[3] / "examples" / "left_turn.scn"


def test_computed_results_are_those_of_an_objective() -> None:
    """`delta_v` and the post-encroachment time are what `maximize` gives, `delta_v` only with a contact."""
    scenario = cx.load(EXAMPLE)
    text = EXAMPLE.read_text() + '\nmaximize delta_v as "dv"\nmaximize post_encroachment_time as "pet"\n'
    asking = cx.compile_text(text, folder=EXAMPLE.parent)
    scenes = scenario.sample(60, seed=3)
    outcomes, told = scenario.simulate(scenes), asking.simulate(asking.sample(60, seed=3))
    args = scenario.program, scenes, outcomes, scenario.config
    delta_v = np.where(outcomes.collided | ~scenes.valid, told.sought[:, 0], 0.0)
    assert outcomes.collided.any()
    assert np.array_equal(bounded_values(Bound("delta_v", "<=", 1.0, ""), *args), delta_v, equal_nan=True)
    pet = bounded_values(Bound("post_encroachment_time", ">=", 1.0, ""), *args)
    assert np.array_equal(pet, told.sought[:, 1], equal_nan=True)


def test_every_result_has_a_value_and_every_pair_counts() -> None:
    """Each name gives one number a run, NaN for an invalid run; of pairs, the worst one."""
    scenario = cx.load(EXAMPLE.parent / "roads" / "walkers.scn")
    scenes = scenario.sample(40, seed=1)
    outcomes = scenario.simulate(scenes)
    for name in UNITS:
        values = bounded_values(Bound(name, "<=", 1.0, ""), scenario.program, scenes, outcomes, scenario.config)
        assert values.shape == (40,)
        assert np.isnan(values[outcomes.verdict != Verdict.VALID]).all()
    least = bounded_values(Bound("min_distance", ">=", 1.0, ""), scenario.program, scenes, outcomes, scenario.config)
    valid = outcomes.verdict == Verdict.VALID
    assert np.array_equal(least[valid], outcomes.min_distance[valid].min(axis=1))
    assert scenario.program.actors[2:]


@pytest.mark.parametrize(
    ("text", "limit"),
    [("delta_v <= 36 km/h", 10.0), ("min_distance>=50 cm", 0.5), ("collided < 1", 1.0), ("end_time > 1.5e1 s", 15.0)],
)
def test_bounds_are_read_with_their_units(text: str, limit: float) -> None:
    assert bound_of(text).limit == pytest.approx(limit)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("min_distanc >= 1 m", "did you mean `min_distance`"),
        ("min_distance >= 1 s", "does not fit"),
        ("min_distance >= 1", "does not fit"),
        ("score <= 3 m", "pure number"),
        ("min_distance >= m", "no number"),
        ("min_distance = 1 m", "no bound"),
        ("", "no bound"),
    ],
)
def test_wrong_bounds_are_refused(text: str, told: str) -> None:
    with pytest.raises(ArgumentError, match=told) as caught:
        bound_of(text)
    assert caught.value.cure


@pytest.mark.parametrize("text", ["0", "-1", "x", "0s", "1.5", "inf", "", "3 weeks", "2000000000"])
def test_wrong_budgets_are_refused(text: str) -> None:
    with pytest.raises(ArgumentError, match="--budget"):
        budget_of(text)


@pytest.mark.parametrize("text", ["0", "1.01", "-1", "nan", "x", "101%", "1 m"])
def test_wrong_probabilities_are_refused(text: str) -> None:
    with pytest.raises(ArgumentError, match="--max-probability"):
        probability_of(text)


def test_budgets_and_probabilities_are_read() -> None:
    assert (budget_of("2000").runs, budget_of("90s").seconds, budget_of("5min").seconds) == (2000, 90.0, 300.0)
    assert probability_of("0.1%") == pytest.approx(1e-3)
    assert probability_of("1") == 1.0
