"""Intervals, over many boxes at once: what a value may be in each, and arithmetic, comparisons and logic on them.

NaN is kept beside the numbers: an interval holds all values that are numbers, `undefined` says whether there may be one
that is not. Truths are intervals within [0, 1], NaN where a kernel's is. (`cortex_dsl.semantics.quantities.bounds` has
the plain ones of the compiler, one expression at a time; a test holds the two together.)

Each function takes intervals and gives one that holds every value the instruction can have on operands in them.
Correctly rounded operations need no slack: rounding never changes an order, so what a kernel computes lies between what
it computes at the ends.

Source of the method: Moore, Kearfott and Cloud (2009), "Introduction to Interval Analysis", chapters 2 to 5.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine import portable
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


def truth(sure: Bools, never: Bools, undefined: Bools | None = None) -> Interval:
    """1 where sure, 0 where never, both in between; `undefined` where it may be NaN instead."""
    undefined = np.zeros(len(sure), dtype=bool) if undefined is None else undefined
    return Interval(sure.astype(np.float64), (~never).astype(np.float64), undefined)


def never_zero(a: Interval) -> Bools:
    """Where all that it may be, but NaN, is not zero."""
    return (a.low > 0.0) | (a.high < 0.0)


def always_zero(a: Interval) -> Bools:
    """Where all that it may be, but NaN, is zero."""
    return (a.low == 0.0) & (a.high == 0.0)


def surely_true(a: Interval) -> Bools:
    """Neither zero nor NaN."""
    return never_zero(a) & ~a.undefined


def surely_false(a: Interval) -> Bools:
    return always_zero(a) & ~a.undefined


# -- arithmetic, comparisons and logic ---------------------------------------------------------------------------------


def add(a: Interval, b: Interval) -> Interval:
    opposite = ((a.high == np.inf) & (b.low == -np.inf)) | ((a.low == -np.inf) & (b.high == np.inf))
    return made(a.low + b.low, a.high + b.high, either(a, b) | opposite)


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
    """With the divisor's sign, as Python has it; rounding may reach the divisor itself."""
    low, high = np.where(b.low > 0.0, 0.0, b.low), np.where(b.high < 0.0, 0.0, b.high)
    whole = (a.low >= 0.0) & (a.high < b.low)
    undefined = either(a, b) | holds_zero(b) | infinite(a) | infinite(b)
    low, high = np.where(whole, a.low, low), np.where(whole, a.high, high)
    return made(np.where(undefined, -np.inf, low), np.where(undefined, np.inf, high), undefined)


def floordiv(a: Interval, b: Interval) -> Interval:
    quotient = div(a, b)
    return made(np.floor(quotient.low) - 1.0, np.floor(quotient.high) + 1.0, quotient.undefined)


def power(a: Interval, b: Interval) -> Interval:
    """Where the base is positive, or the exponent a known whole number that is not negative."""
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
    """`b if b < a else a`: a NaN in b leaves a."""
    high = np.where(b.undefined, a.high, np.minimum(a.high, b.high))
    return Interval(np.minimum(a.low, b.low), high, a.undefined)


def greatest(a: Interval, b: Interval) -> Interval:
    low = np.where(b.undefined, a.low, np.maximum(a.low, b.low))
    return Interval(low, np.maximum(a.high, b.high), a.undefined)


# -- truth ------------------------------------------------------------------------------------------------------------


def below(a: Interval, b: Interval) -> Interval:
    return truth(a.high < b.low, a.low >= b.high, either(a, b))


def at_most(a: Interval, b: Interval) -> Interval:
    return truth(a.high <= b.low, a.low > b.high, either(a, b))


def equal(a: Interval, b: Interval) -> Interval:
    same = (a.low == a.high) & (b.low == b.high) & (a.low == b.low)
    return truth(same, (a.high < b.low) | (a.low > b.high), either(a, b))


def negation(a: Interval) -> Interval:
    return truth(always_zero(a), never_zero(a), a.undefined)


def both(a: Interval, b: Interval) -> Interval:
    """NaN where one operand is, unless the other is zero."""
    undefined = (a.undefined & ~surely_false(b)) | (b.undefined & ~surely_false(a))
    return truth(never_zero(a) & never_zero(b), always_zero(a) | always_zero(b), undefined)


def one_of(a: Interval, b: Interval) -> Interval:
    """NaN where one operand is, unless the other is true."""
    undefined = (a.undefined & ~surely_true(b)) | (b.undefined & ~surely_true(a))
    return truth(never_zero(a) | never_zero(b), always_zero(a) & always_zero(b), undefined)


def select(a: Interval, b: Interval, c: Interval) -> Interval:
    then, otherwise = never_zero(a), always_zero(a)
    low = np.where(then, b.low, np.where(otherwise, c.low, np.minimum(b.low, c.low)))
    high = np.where(then, b.high, np.where(otherwise, c.high, np.maximum(b.high, c.high)))
    undefined = np.where(then, b.undefined, np.where(otherwise, c.undefined, either(b, c)))
    return Interval(low, high, a.undefined | undefined)
