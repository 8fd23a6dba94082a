"""Interval versions of arithmetic, comparisons and logic.

Each function takes intervals and gives one that holds every value the instruction can have on operands in them.
Correctly rounded operations need no slack: rounding never changes an order, so what a kernel computes lies between what
it computes at the ends.
"""

import numpy as np

from engine.feasibility.intervals import (
    Interval,
    either,
    holds_zero,
    infinite,
    made,
    slackened,
    surely_false,
    surely_true,
    truth,
)


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
    corners = np.stack([np.power(np.where(positive, x, 1.0), y) for x in (a.low, a.high) for y in (b.low, b.high)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    whole = (b.low == b.high) & (b.low >= 0.0) & (np.floor(b.low) == b.low) & ~positive
    if whole.any():
        exponent = np.where(whole, b.low, 1.0)
        ends = np.power(a.low, exponent), np.power(a.high, exponent)
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
    return truth((a.high < b.low) & ~either(a, b), a.low >= b.high)


def at_most(a: Interval, b: Interval) -> Interval:
    return truth((a.high <= b.low) & ~either(a, b), a.low > b.high)


def equal(a: Interval, b: Interval) -> Interval:
    same = (a.low == a.high) & (b.low == b.high) & (a.low == b.low) & ~either(a, b)
    return truth(same, (a.high < b.low) | (a.low > b.high))


def negation(a: Interval) -> Interval:
    return truth(surely_false(a), surely_true(a))


def both(a: Interval, b: Interval) -> Interval:
    return truth(surely_true(a) & surely_true(b), surely_false(a) | surely_false(b))


def one_of(a: Interval, b: Interval) -> Interval:
    return truth(surely_true(a) | surely_true(b), surely_false(a) & surely_false(b))


def select(a: Interval, b: Interval, c: Interval) -> Interval:
    then, otherwise = surely_true(a), surely_false(a)
    low = np.where(then, b.low, np.where(otherwise, c.low, np.minimum(b.low, c.low)))
    high = np.where(then, b.high, np.where(otherwise, c.high, np.maximum(b.high, c.high)))
    return Interval(low, high, np.where(then, b.undefined, np.where(otherwise, c.undefined, either(b, c))))
