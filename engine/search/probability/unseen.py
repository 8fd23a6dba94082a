"""Probability of kinds of failures that no run has shown, from independent draws.

`estimate` is Good's: the share of the draws whose kind came up once. Good (1953), "The population frequencies of
species and the estimation of population parameters".

`bound` is exact for every distribution of kinds: given the first half of the draws, each draw of the second half shows
none of the kinds of the first half with one probability, independently of the others, so their number is binomial and
has the upper bound of Clopper and Pearson. The kinds that no draw at all showed are fewer, and no more probable.
"""

import math
from dataclasses import dataclass

import numpy as np

from engine.search.statistics import clopper_pearson
from engine.tables import Ints

NO_KIND = -1
"""Label of a draw that is no failure."""


@dataclass(frozen=True)
class Unseen:
    """Probability of the kinds that no draw has shown."""

    kinds: int = 0
    """Number of kinds that some draw showed."""
    once: int = 0
    """Number of kinds that exactly one draw showed."""
    estimate: float = math.nan
    """Estimated probability of all other kinds together; NaN without draws."""
    bound: float = math.nan
    """Upper confidence bound of it; NaN where the number of draws depended on their results."""


NOTHING_DRAWN = Unseen()


def labels(codes: Ints) -> Ints:
    """Return (n,) numbers, equal for equal rows of `codes` (n, k), and `NO_KIND` for rows that begin with it."""
    if not len(codes):
        return np.zeros(0, dtype=np.int64)
    numbers = np.unique(codes, axis=0, return_inverse=True)[1].reshape(-1)
    return np.where(codes[:, 0] == NO_KIND, NO_KIND, numbers)


def unseen_kinds(kinds: Ints, level: float = 0.95, lost: int = 0) -> Unseen:
    """Return the estimate and the one-sided bound at `level` from the kinds of independent draws, in their order.

    Args:
        kinds: (n,) labels, `NO_KIND` for a draw that is no failure.
        level: confidence level of the bound.
        lost: number of further draws with an unknown outcome; the bound counts each as one more new kind.
    """
    if not len(kinds):
        return NOTHING_DRAWN
    shown, counts = np.unique(kinds[kinds != NO_KIND], return_counts=True)
    once = int((counts == 1).sum())
    first, second = np.split(kinds, [len(kinds) // 2])
    new = int((~np.isin(second, first) & (second != NO_KIND)).sum())
    bound = clopper_pearson(new, len(second), 2.0 * level - 1.0, lost).high
    return Unseen(len(shown), once, once / len(kinds), bound)
