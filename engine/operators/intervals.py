"""Intervals over many boxes at once: the values that each operator can have on operands in given intervals.

NaN is separate from the numbers: an interval contains all values that are numbers, and `undefined` is True if the value
may be NaN. Truths are intervals within [0, 1], NaN where a kernel's truth is NaN. `engine.operators.bounds` has the
intervals of the compiler.

Correctly rounded operations need no slack: rounding never changes an order, so a kernel's result is between its results
at the ends. Functions without correct rounding have a slack far above their error.

Source of the method: Moore, Kearfott and Cloud (2009), "Introduction to Interval Analysis", chapters 2 to 5.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine import portable
from engine.kernels import scalars
from engine.tables import Floats

Bools = NDArray[np.bool_]
RELATIVE = 1e-13
"""Slack of functions that are not correctly rounded: hundreds of times their error."""
NEAR_POLE = 1e-9
"""Distance from a jump or pole of a periodic function within which its branch is unknown [rad]."""


class Interval(NamedTuple):
    """Possible values of a quantity, per box: arrays (n,)."""

    low: Floats
    high: Floats
    undefined: Bools
    """True where the value may be NaN."""


Forward = Callable[..., Interval]


def made(low: Floats, high: Floats, undefined: Bools) -> Interval:
    """Return the interval; all values where an end is NaN."""
    unknown = np.isnan(low) | np.isnan(high)
    if unknown.any():
        low, high = np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)
        undefined = undefined | unknown
    return Interval(low, high, undefined)


def point(value: float, count: int = 1) -> Interval:
    """Return the interval of a known number."""
    return made(np.full(count, value), np.full(count, value), np.zeros(count, dtype=bool))


def between(low: float, high: float, count: int) -> Interval:
    """Return the interval of a number that is defined and between `low` and `high`."""
    return Interval(np.full(count, low), np.full(count, high), np.zeros(count, dtype=bool))


def everything(count: int) -> Interval:
    """Return the interval of all values, NaN included."""
    return Interval(np.full(count, -np.inf), np.full(count, np.inf), np.ones(count, dtype=bool))


def slackened(low: Floats, high: Floats, undefined: Bools) -> Interval:
    """Return the interval with both ends moved outward by more than the error of a library function."""
    return made(low - RELATIVE * (1.0 + np.abs(low)), high + RELATIVE * (1.0 + np.abs(high)), undefined)


def either(*operands: Interval) -> Bools:
    """Return (n,) True where one of the operands may be NaN."""
    undefined = operands[0].undefined
    for operand in operands[1:]:
        undefined = undefined | operand.undefined
    return undefined


def infinite(a: Interval) -> Bools:
    """Return (n,) True where the value may be infinite."""
    return np.isinf(a.low) | np.isinf(a.high)


def holds_zero(a: Interval) -> Bools:
    return (a.low <= 0.0) & (a.high >= 0.0)


def truth(sure: Bools, never: Bools, undefined: Bools | None = None) -> Interval:
    """Return 1 where `sure`, 0 where `never`, [0, 1] elsewhere; `undefined` where it may be NaN instead."""
    undefined = np.zeros(len(sure), dtype=bool) if undefined is None else undefined
    return Interval(sure.astype(np.float64), (~never).astype(np.float64), undefined)


def never_zero(a: Interval) -> Bools:
    """Return (n,) True where no number of the interval is zero; NaN is ignored."""
    return (a.low > 0.0) | (a.high < 0.0)


def always_zero(a: Interval) -> Bools:
    """Return (n,) True where zero is the only number of the interval; NaN is ignored."""
    return (a.low == 0.0) & (a.high == 0.0)


def surely_true(a: Interval) -> Bools:
    """Return (n,) True where the value is neither zero nor NaN."""
    return never_zero(a) & ~a.undefined


def surely_false(a: Interval) -> Bools:
    return always_zero(a) & ~a.undefined


# -- arithmetic, comparisons and logic ---------------------------------------------------------------------------------


def add(a: Interval, b: Interval) -> Interval:
    opposite = ((a.high == np.inf) & (b.low == -np.inf)) | ((a.low == -np.inf) & (b.high == np.inf))
    return made(a.low + b.low, a.high + b.high, either(a, b) | opposite)


def unchanged(a: Interval) -> Interval:
    return a


def neg(a: Interval) -> Interval:
    return Interval(-a.high, -a.low, a.undefined)


def sub(a: Interval, b: Interval) -> Interval:
    return add(a, neg(b))


def mul(a: Interval, b: Interval) -> Interval:
    products = np.stack([a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high])
    # An end of infinity times a zero: products of numbers below it are zero.
    products = np.where(np.isnan(products), 0.0, products)
    undefined = (holds_zero(a) & infinite(b)) | (holds_zero(b) & infinite(a))
    return made(products.min(axis=0), products.max(axis=0), either(a, b) | undefined)


def div(a: Interval, b: Interval) -> Interval:
    quotients = np.stack([a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high])
    through_zero = holds_zero(b)
    low = np.where(through_zero, -np.inf, quotients.min(axis=0))
    high = np.where(through_zero, np.inf, quotients.max(axis=0))
    return made(low, high, either(a, b) | (through_zero & holds_zero(a)) | (infinite(a) & infinite(b)))


def mod(a: Interval, b: Interval) -> Interval:
    """Return the remainder with the divisor's sign, as in Python; rounding may reach the divisor itself."""
    low, high = np.where(b.low > 0.0, 0.0, b.low), np.where(b.high < 0.0, 0.0, b.high)
    whole = (a.low >= 0.0) & (a.high < b.low)
    undefined = either(a, b) | holds_zero(b) | infinite(a) | infinite(b)
    low, high = np.where(whole, a.low, low), np.where(whole, a.high, high)
    return made(np.where(undefined, -np.inf, low), np.where(undefined, np.inf, high), undefined)


def floordiv(a: Interval, b: Interval) -> Interval:
    quotient = div(a, b)
    return made(np.floor(quotient.low) - 1.0, np.floor(quotient.high) + 1.0, quotient.undefined)


def power(a: Interval, b: Interval) -> Interval:
    """Return the power; all values unless the base is positive or the exponent is a known whole number >= 0."""
    positive = a.low > 0.0
    corners = np.stack(
        [portable.power(np.where(positive, x, 1.0), y) for x in (a.low, a.high) for y in (b.low, b.high)]
    )
    low, high = corners.min(axis=0), corners.max(axis=0)
    whole = (b.low == b.high) & (b.low >= 0.0) & (np.floor(b.low) == b.low) & ~positive
    if whole.any():
        exponent = np.where(whole, b.low, 1.0)
        ends = portable.power(a.low, exponent), portable.power(a.high, exponent)
        even = np.mod(exponent, 2.0) == 0.0
        lowest = np.where(holds_zero(a) & even & (exponent > 0.0), 0.0, np.minimum(*ends))
        low, high = np.where(whole, lowest, low), np.where(whole, np.maximum(*ends), high)
    known = positive | whole
    low, high = np.where(known, low, -np.inf), np.where(known, high, np.inf)
    return slackened(low, high, either(a, b) | ~known | infinite(a) | infinite(b))


def magnitude(a: Interval) -> Interval:
    low, high = np.abs(a.low), np.abs(a.high)
    return Interval(np.where(holds_zero(a), 0.0, np.minimum(low, high)), np.maximum(low, high), a.undefined)


def least(a: Interval, b: Interval) -> Interval:
    """Return `b if b < a else a`; the result is a if b is NaN."""
    high = np.where(b.undefined, a.high, np.minimum(a.high, b.high))
    return Interval(np.minimum(a.low, b.low), high, a.undefined)


def greatest(a: Interval, b: Interval) -> Interval:
    low = np.where(b.undefined, a.low, np.maximum(a.low, b.low))
    return Interval(low, np.maximum(a.high, b.high), a.undefined)


# -- functions ---------------------------------------------------------------------------------------------------------


def root(a: Interval) -> Interval:
    low, high = np.sqrt(np.maximum(a.low, 0.0)), np.sqrt(np.maximum(a.high, 0.0))
    return Interval(low, high, a.undefined | (a.low < 0.0))


def wave(function: Callable[[Floats], Floats]) -> Forward:
    """Return the interval version of sine or cosine, which is 1-Lipschitz and within [-1, 1]."""

    def forward(a: Interval) -> Interval:
        known = ~infinite(a)
        low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
        middle = function(0.5 * low + 0.5 * high)
        reach = np.where(known, 0.5 * (high - low) + RELATIVE * (1.0 + np.abs(low) + np.abs(high)), 2.0)
        return Interval(np.maximum(middle - reach, -1.0), np.minimum(middle + reach, 1.0), a.undefined | ~known)

    return forward


def tangent(a: Interval) -> Interval:
    known = ~infinite(a)
    low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
    branch = np.floor((low - NEAR_POLE) / math.pi + 0.5) == np.floor((high + NEAR_POLE) / math.pi + 0.5)
    branch &= known & (np.abs(low) + np.abs(high) < 1e6)
    ends = np.where(branch, portable.tan(low), -np.inf), np.where(branch, portable.tan(high), np.inf)
    margin = 1e-9 * (1.0 + np.square(ends[0]) + np.square(ends[1]))
    return made(ends[0] - margin, ends[1] + margin, a.undefined | ~known)


def rising(function: Callable[[Floats], Floats], least: float = -np.inf, greatest: float = np.inf) -> Forward:
    """Return the interval version of a function that never falls, defined on [least, greatest]."""

    def forward(a: Interval) -> Interval:
        low, high = function(np.clip(a.low, least, greatest)), function(np.clip(a.high, least, greatest))
        return slackened(low, high, a.undefined | (a.low < least) | (a.high > greatest))

    return forward


arcsine, arctangent = rising(portable.arcsin, -1.0, 1.0), rising(portable.arctan)
exponential, logarithm = rising(portable.exp), rising(portable.log, 0.0)


def arccosine(a: Interval) -> Interval:
    turned = arcsine(a)
    return slackened(0.5 * math.pi - turned.high, 0.5 * math.pi - turned.low, turned.undefined)


def direction(a: Interval, b: Interval) -> Interval:
    corners = np.stack([portable.arctan2(y, x) for y in (a.low, a.high) for x in (b.low, b.high)])
    ahead = b.low > 0.0
    low, high = np.where(ahead, corners.min(axis=0), -math.pi), np.where(ahead, corners.max(axis=0), math.pi)
    return slackened(low, high, either(a, b))


def exactly_rising(function: Callable[[Floats], Floats]) -> Forward:
    def forward(a: Interval) -> Interval:
        return Interval(function(a.low), function(a.high), a.undefined)

    return forward


def length(a: Interval, b: Interval) -> Interval:
    x, y = magnitude(a), magnitude(b)
    low, high = np.hypot(x.low, y.low), np.hypot(x.high, y.high)
    return made(np.maximum(low * (1.0 - RELATIVE), 0.0), high * (1.0 + RELATIVE), either(a, b))


def wrapped(a: Interval) -> Interval:
    """Return the angle wrapped to one turn: if both ends are on the same turn, they are shifted by it."""
    known = ~infinite(a) & (np.abs(a.low) < 1e6) & (np.abs(a.high) < 1e6)
    low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
    inside = known & (low >= -math.pi) & (high < math.pi)
    turn = np.floor((low - NEAR_POLE + math.pi) / scalars.FULL_TURN)
    same = known & (turn == np.floor((high + NEAR_POLE + math.pi) / scalars.FULL_TURN)) & ~inside
    moved = low - scalars.FULL_TURN * turn - NEAR_POLE, high - scalars.FULL_TURN * turn + NEAR_POLE
    return Interval(
        np.where(inside, low, np.where(same, moved[0], -math.pi)),
        np.where(inside, high, np.where(same, moved[1], math.pi)),
        a.undefined | infinite(a),
    )


def normal_quantile(a: Interval) -> Interval:
    inside = rising(lambda p: np.array(list(map(scalars.normal_quantile, p.tolist()))), 0.0, 1.0)(a)
    return slackened(inside.low - 1e-9, inside.high + 1e-9, inside.undefined)


def normal_cdf(a: Interval) -> Interval:
    low, high = (np.array(list(map(scalars.normal_cdf, end.tolist()))) for end in (a.low, a.high))
    return slackened(low, high, a.undefined)


# -- truth ------------------------------------------------------------------------------------------------------------


def below(a: Interval, b: Interval) -> Interval:
    return truth(a.high < b.low, a.low >= b.high, either(a, b))


def at_most(a: Interval, b: Interval) -> Interval:
    return truth(a.high <= b.low, a.low > b.high, either(a, b))


def equal(a: Interval, b: Interval) -> Interval:
    same = (a.low == a.high) & (b.low == b.high) & (a.low == b.low)
    return truth(same, (a.high < b.low) | (a.low > b.high), either(a, b))


def unequal(a: Interval, b: Interval) -> Interval:
    return negation(equal(a, b))


def negation(a: Interval) -> Interval:
    return truth(always_zero(a), never_zero(a), a.undefined)


def both(a: Interval, b: Interval) -> Interval:
    """Return the bounds of `a and b`; undefined if an operand may be, unless the other is surely false."""
    undefined = (a.undefined & ~surely_false(b)) | (b.undefined & ~surely_false(a))
    return truth(never_zero(a) & never_zero(b), always_zero(a) | always_zero(b), undefined)


def one_of(a: Interval, b: Interval) -> Interval:
    """Return the bounds of `a or b`; undefined if an operand may be, unless the other is surely true."""
    undefined = (a.undefined & ~surely_true(b)) | (b.undefined & ~surely_true(a))
    return truth(never_zero(a) | never_zero(b), always_zero(a) & always_zero(b), undefined)


def select(a: Interval, b: Interval, c: Interval) -> Interval:
    then, otherwise = never_zero(a), always_zero(a)
    low = np.where(then, b.low, np.where(otherwise, c.low, np.minimum(b.low, c.low)))
    high = np.where(then, b.high, np.where(otherwise, c.high, np.maximum(b.high, c.high)))
    undefined = np.where(then, b.undefined, np.where(otherwise, c.undefined, either(b, c)))
    return Interval(low, high, a.undefined | undefined)
