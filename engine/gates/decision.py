"""Decision whether the rate of a failure lies above a limit, taken while runs are drawn.

After each block of runs, the confidence sequence of the rate is compared with the limit. All of its intervals hold the
rate at once with a probability of at least 1 - alpha, so that each of the two wrong decisions has a probability of at
most alpha, however often the decision is looked at and whenever the runs stop.
"""

from enum import StrEnum

from engine.frozen import frozen
from engine.search.probability.confidence_sequence import confidence_sequence

ALPHA = 0.05
"""Probability that some interval of the sequence does not hold the rate."""


class Answer(StrEnum):
    """Answer to the question whether a limit is kept."""

    KEPT = "kept"
    BROKEN = "broken"
    OPEN = "open"
    """The runs do not decide it yet."""


@frozen
class RateDecision:
    """Decision on a rate after some runs."""

    answer: Answer
    low: float
    high: float
    """Interval of the rate at the look that decided, or at the last one."""
    failures: int
    trials: int


UNDECIDED = RateDecision(Answer.OPEN, 0.0, 1.0, 0, 0)
"""Decision before the first run."""


def decide_rate(failures: int, trials: int, limit: float, alpha: float = ALPHA) -> RateDecision:
    """Return the decision after `failures` in `trials`: broken if the interval lies above the limit, kept if it lies
    at or below it.
    """
    low, high = (float(end) for end in confidence_sequence(failures, trials, alpha))
    answer = Answer.BROKEN if low > limit else Answer.KEPT if high <= limit else Answer.OPEN
    return RateDecision(answer, low, high, failures, trials)
