"""Confidence sequences hold a rate at all looks together."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtr, ndtri

from engine.search.probability.confidence_sequence import confidence_sequence, sequence_interval
from engine.search.probability.functions import evaluator, uniform_space
from engine.search.probability.monte_carlo import monte_carlo
from engine.search.statistics import clopper_pearson
from tests.laws import examples

LOOKS = np.arange(100, 5_001, 100)
CAMPAIGNS = 1_000


@pytest.mark.parametrize("rate", [0.0005, 0.01, 0.3, 0.97])
def test_no_more_than_alpha_of_all_campaigns_ever_miss_the_rate(rate: float) -> None:
    """A look after every 100 trials, and someone who stops at the first look that misses. With a rate of 5 % there
    are more than 73 misses in 1,000 in one of 1,000.
    """
    numbers = np.random.default_rng(5)
    counts = numbers.binomial(100, rate, (CAMPAIGNS, len(LOOKS))).cumsum(axis=1)
    low, high = confidence_sequence(counts, LOOKS)
    assert ((low > rate) | (high < rate)).any(axis=1).sum() <= 73
    if rate == 0.3:  # the same campaigns, with intervals for one look
        single = [[clopper_pearson(int(k), int(n)) for k, n in zip(row, LOOKS, strict=True)] for row in counts[:200]]
        ends = np.array(single)
        assert ((ends[..., 0] > rate) | (ends[..., 1] < rate)).any(axis=1).mean() > 0.1


@pytest.mark.parametrize("trials", [100, 1_000, 10_000, 100_000])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.5, 1.0])
def test_intervals_are_at_most_twice_as_wide_as_those_for_one_look(trials: int, share: float) -> None:
    for successes in {min(trials, round(share * trials) + more) for more in (0, 1, 2, 5)}:
        low, high = confidence_sequence(successes, trials)
        single = clopper_pearson(successes, trials)
        assert high - low <= 2.0 * (single.high - single.low)


@examples(60)
@given(st.integers(1, 3000), st.floats(0.0, 1.0), st.floats(0.001, 0.5), st.floats(0.5, 500.0))
def test_mirrored_monotone_and_around_the_share(n: int, share: float, alpha: float, strength: float) -> None:
    s = round(share * n)
    (low, more_low), (high, more_high) = confidence_sequence([s, min(n, s + 1)], n, alpha, strength)
    assert 0.0 <= low <= s / n <= high <= 1.0
    assert low <= more_low
    assert high <= more_high
    back_low, back_high = confidence_sequence(n - s, n, alpha, strength)
    assert (1.0 - back_high, 1.0 - back_low) == pytest.approx((low, high), abs=1e-12)


@examples(40)
@given(st.lists(st.booleans(), min_size=1, max_size=60), st.floats(0.02, 0.98))
def test_rates_outside_are_those_that_the_bettor_refutes(trials: list[bool], rate: float) -> None:
    """The capital, computed bet by bet from its definition."""
    capital, won = 1.0, 0
    for number, success in enumerate(trials):
        stake = (50.0 * rate + won) / (50.0 + number)
        capital *= stake / rate if success else (1.0 - stake) / (1.0 - rate)
        won += success
    low, high = confidence_sequence(won, len(trials))
    if abs(capital * 0.05 - 1.0) > 1e-9:
        assert (low <= rate <= high) == (capital * 0.05 < 1.0)


def test_looks_of_any_shape() -> None:
    low, high = confidence_sequence([[0, 0], [0, 7]], [0, 10])
    assert low.shape == high.shape == (2, 2)
    assert (low[1, 1], high[1, 1]) == confidence_sequence(7, 10)
    assert confidence_sequence(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize("bad", [(1, 0, 0.05, 50.0), (-1, 3, 0.05, 50.0), (1, 3, 0.0, 50.0), (1, 3, 0.05, 0.0)])
def test_bad_arguments_are_refused(bad: tuple[int, int, float, float]) -> None:
    with pytest.raises(ValueError, match=r"successes|alpha"):
        confidence_sequence(*bad)


@pytest.mark.parametrize("far", [0.5, 1.5])
def test_plain_draws_stop_at_a_width_and_hold_the_truth(far: float) -> None:
    """With the interval of the sequence; a run with more draws goes on from the same ones."""
    space, truth = uniform_space(1), float(ndtr(-far))
    evaluate = evaluator(lambda uniforms, _: far - ndtri(uniforms[:, 0]))
    held = 0
    for seed in range(20):
        found = monte_carlo(space, evaluate, 50_000, seed, until_width=0.05)
        assert found.interval == found.sequence
        assert found.interval.high - found.interval.low <= 0.05
        assert found.simulations < 50_000
        held += found.interval.low <= truth <= found.interval.high
    assert held >= 18
    least = monte_carlo(space, evaluate, 1_000, 1, until_width=1e-3)
    assert (least.simulations, least.interval) == (1_000, least.sequence)


def test_unknown_outcomes_widen_both_ends() -> None:
    low, high = sequence_interval(3, 100, 0.95, unknown=10)
    assert low == confidence_sequence(3, 110)[0]
    assert high == confidence_sequence(13, 110)[1]
    assert np.isnan(sequence_interval(0, 0)).all()
