"""Intervals, over many boxes at once: what a value may be in each.

NaN is kept beside the numbers: an interval holds all values that are numbers, `undefined` says whether there may be one
that is not. Truths are intervals within [0, 1]. (`cortex_dsl.semantics.quantities.bounds` has the plain ones of the
compiler, one expression at a time; a test holds the two together.)

Source of the method: Moore, Kearfott and Cloud (2009), "Introduction to Interval Analysis", chapters 2 to 5.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.tables import Floats

Bools = NDArray[np.bool_]
RELATIVE = 1e-13
"""Slack of functions that are not correctly rounded: hundreds of times their error."""


class Interval(NamedTuple):
    """What a value may be, box by box: arrays (n,)."""

    low: Floats
    high: Floats
    undefined: Bools
    """Where it may be NaN."""


Forward = Callable[..., Interval]


def made(low: Floats, high: Floats, undefined: Bools) -> Interval:
    """The interval, or everything where an end is NaN."""
    unknown = np.isnan(low) | np.isnan(high)
    if unknown.any():
        low, high = np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)
        undefined = undefined | unknown
    return Interval(low, high, undefined)


def point(value: float, count: int = 1) -> Interval:
    """A known number."""
    return made(np.full(count, value), np.full(count, value), np.zeros(count, dtype=bool))


def between(low: float, high: float, count: int) -> Interval:
    """A number that is surely defined and lies there."""
    return Interval(np.full(count, low), np.full(count, high), np.zeros(count, dtype=bool))


def everything(count: int) -> Interval:
    """Nothing is known."""
    return Interval(np.full(count, -np.inf), np.full(count, np.inf), np.ones(count, dtype=bool))


def slackened(low: Floats, high: Floats, undefined: Bools) -> Interval:
    """Both ends moved outward by more than a library function may err."""
    return made(low - RELATIVE * (1.0 + np.abs(low)), high + RELATIVE * (1.0 + np.abs(high)), undefined)


def either(*operands: Interval) -> Bools:
    """Where one of the operands may be NaN."""
    undefined = operands[0].undefined
    for operand in operands[1:]:
        undefined = undefined | operand.undefined
    return undefined


def infinite(a: Interval) -> Bools:
    """Where it may be infinite."""
    return np.isinf(a.low) | np.isinf(a.high)


def holds_zero(a: Interval) -> Bools:
    return (a.low <= 0.0) & (a.high >= 0.0)


def truth(sure: Bools, never: Bools) -> Interval:
    """1 where sure, 0 where never, both in between."""
    return Interval(sure.astype(np.float64), (~never).astype(np.float64), np.zeros(len(sure), dtype=bool))


def surely_true(a: Interval) -> Bools:
    """Not zero; NaN counts as true, as in the kernels."""
    return (a.low > 0.0) | (a.high < 0.0)


def surely_false(a: Interval) -> Bools:
    return (a.low == 0.0) & (a.high == 0.0) & ~a.undefined
