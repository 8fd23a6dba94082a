"""The two wrong decisions on a rate are rare, however often the runs are looked at."""

import numpy as np
import pytest

from engine.gates.decision import ALPHA, UNDECIDED, Answer, RateDecision, decide_rate

LIMIT, BLOCK, BUDGET, SEEDS = 0.2, 100, 3000, 400


def decided(rate: float, seed: int) -> RateDecision:
    """Return the first decision on a rate, by a look after each block of draws."""
    failures = np.cumsum(np.random.default_rng(seed).random(BUDGET) < rate)
    decision = UNDECIDED
    for trials in range(BLOCK, BUDGET + 1, BLOCK):
        decision = decide_rate(int(failures[trials - 1]), trials, LIMIT)
        if decision.answer is not Answer.OPEN:
            break
    return decision


@pytest.mark.parametrize(
    ("rate", "wrong", "right"), [(0.9, Answer.BROKEN, Answer.KEPT), (1.1, Answer.KEPT, Answer.BROKEN)]
)
def test_wrong_decisions_are_rare(rate: float, wrong: Answer, right: Answer) -> None:
    """At most 5 % of the campaigns end with the wrong answer, and some end with the right one."""
    answers = [decided(rate * LIMIT, seed).answer for seed in range(SEEDS)]
    assert answers.count(wrong) <= ALPHA * SEEDS
    assert answers.count(right) > 0


def test_an_interval_at_a_fixed_number_of_runs_would_not_do() -> None:
    """The test can fail: looks at intervals of Clopper and Pearson take wrong decisions in more than 5 %."""
    from engine.search.statistics import clopper_pearson

    wrong = 0
    for seed in range(SEEDS):
        failures = np.cumsum(np.random.default_rng(seed).random(BUDGET) < LIMIT)
        looks = range(10, BUDGET + 1, 10)
        wrong += any(clopper_pearson(int(failures[n - 1]), n, 0.95).low > LIMIT for n in looks)
    assert wrong > ALPHA * SEEDS


def test_a_decision_states_its_interval() -> None:
    """The interval lies above the limit, at or below it, or holds it."""
    for failures, trials in ((0, 0), (0, 400), (400, 400), (40, 200)):
        found = decide_rate(failures, trials, LIMIT)
        assert (found.answer is Answer.BROKEN) == (found.low > LIMIT)
        assert (found.answer is Answer.KEPT) == (found.high <= LIMIT)
        assert (found.failures, found.trials) == (failures, trials)
