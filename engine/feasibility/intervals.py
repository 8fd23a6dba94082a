"""Interval versions of the scalar instructions, over many boxes at once.

Each function of `FORWARD` takes intervals and gives one that holds every value the instruction can have on operands in
them. Correctly rounded operations need no slack: rounding never changes an order, so what a kernel computes lies
between what it computes at the ends. The others get a slack far above their error. NaN is kept beside the numbers: an
interval holds all values that are numbers, `undefined` says whether there may be one that is not.

Source of the method: Moore, Kearfott and Cloud (2009), "Introduction to Interval Analysis", chapters 2 to 5.
"""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.tables import Floats
from engine.vocabulary import Op

Bools = NDArray[np.bool_]
RELATIVE = 1e-13
"""Slack of functions that are not correctly rounded: hundreds of times their error."""
NEAR_POLE = 1e-9
"""How far from a jump or pole of a periodic function a branch is still taken for sure [rad]."""
FULL_TURN = 2.0 * math.pi


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


def _either(*operands: Interval) -> Bools:
    undefined = operands[0].undefined
    for operand in operands[1:]:
        undefined = undefined | operand.undefined
    return undefined


def _infinite(a: Interval) -> Bools:
    return np.isinf(a.low) | np.isinf(a.high)


def _holds_zero(a: Interval) -> Bools:
    return (a.low <= 0.0) & (a.high >= 0.0)


# -- arithmetic -------------------------------------------------------------------------------------------------------


def _add(a: Interval, b: Interval) -> Interval:
    opposite = ((a.high == np.inf) & (b.low == -np.inf)) | ((a.low == -np.inf) & (b.high == np.inf))
    return made(a.low + b.low, a.high + b.high, _either(a, b) | opposite)


def _neg(a: Interval) -> Interval:
    return Interval(-a.high, -a.low, a.undefined)


def _sub(a: Interval, b: Interval) -> Interval:
    return _add(a, _neg(b))


def _mul(a: Interval, b: Interval) -> Interval:
    products = np.stack([a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high])
    # An end of infinity times a zero: products of numbers below it are zero.
    products = np.where(np.isnan(products), 0.0, products)
    undefined = (_holds_zero(a) & _infinite(b)) | (_holds_zero(b) & _infinite(a))
    return made(products.min(axis=0), products.max(axis=0), _either(a, b) | undefined)


def _div(a: Interval, b: Interval) -> Interval:
    quotients = np.stack([a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high])
    through_zero = _holds_zero(b)
    low = np.where(through_zero, -np.inf, quotients.min(axis=0))
    high = np.where(through_zero, np.inf, quotients.max(axis=0))
    return made(low, high, _either(a, b) | (through_zero & _holds_zero(a)) | (_infinite(a) & _infinite(b)))


def _mod(a: Interval, b: Interval) -> Interval:
    """With the divisor's sign, as Python has it; rounding may reach the divisor itself."""
    low, high = np.where(b.low > 0.0, 0.0, b.low), np.where(b.high < 0.0, 0.0, b.high)
    whole = (a.low >= 0.0) & (a.high < b.low)
    undefined = _either(a, b) | _holds_zero(b) | _infinite(a) | _infinite(b)
    low, high = np.where(whole, a.low, low), np.where(whole, a.high, high)
    return made(np.where(undefined, -np.inf, low), np.where(undefined, np.inf, high), undefined)


def _floordiv(a: Interval, b: Interval) -> Interval:
    quotient = _div(a, b)
    return made(np.floor(quotient.low) - 1.0, np.floor(quotient.high) + 1.0, quotient.undefined)


def _pow(a: Interval, b: Interval) -> Interval:
    """Where the base is positive, or the exponent a known whole number that is not negative."""
    positive = a.low > 0.0
    corners = np.stack([np.power(np.where(positive, x, 1.0), y) for x in (a.low, a.high) for y in (b.low, b.high)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    whole = (b.low == b.high) & (b.low >= 0.0) & (np.floor(b.low) == b.low) & ~positive
    if whole.any():
        exponent = np.where(whole, b.low, 1.0)
        ends = np.power(a.low, exponent), np.power(a.high, exponent)
        even = np.mod(exponent, 2.0) == 0.0
        least = np.where(_holds_zero(a) & even & (exponent > 0.0), 0.0, np.minimum(*ends))
        low, high = np.where(whole, least, low), np.where(whole, np.maximum(*ends), high)
    known = positive | whole
    low, high = np.where(known, low, -np.inf), np.where(known, high, np.inf)
    return slackened(low, high, _either(a, b) | ~known | _infinite(a) | _infinite(b))


def _abs(a: Interval) -> Interval:
    low, high = np.abs(a.low), np.abs(a.high)
    return Interval(np.where(_holds_zero(a), 0.0, np.minimum(low, high)), np.maximum(low, high), a.undefined)


def _min(a: Interval, b: Interval) -> Interval:
    """`b if b < a else a`: a NaN in b leaves a."""
    high = np.where(b.undefined, a.high, np.minimum(a.high, b.high))
    return Interval(np.minimum(a.low, b.low), high, a.undefined)


def _max(a: Interval, b: Interval) -> Interval:
    low = np.where(b.undefined, a.low, np.maximum(a.low, b.low))
    return Interval(low, np.maximum(a.high, b.high), a.undefined)


# -- functions --------------------------------------------------------------------------------------------------------


def _sqrt(a: Interval) -> Interval:
    low, high = np.sqrt(np.maximum(a.low, 0.0)), np.sqrt(np.maximum(a.high, 0.0))
    return Interval(low, high, a.undefined | (a.low < 0.0))


def _wave(function: Callable[[Floats], Floats]) -> Forward:
    """Sine and cosine never rise faster than their argument, and never leave [-1, 1]."""

    def forward(a: Interval) -> Interval:
        known = ~_infinite(a)
        low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
        middle = function(0.5 * (low + high))
        reach = np.where(known, 0.5 * (high - low) + RELATIVE * (1.0 + np.abs(low) + np.abs(high)), 2.0)
        return Interval(np.maximum(middle - reach, -1.0), np.minimum(middle + reach, 1.0), a.undefined | ~known)

    return forward


def _tan(a: Interval) -> Interval:
    known = ~_infinite(a)
    low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
    branch = np.floor((low - NEAR_POLE) / math.pi + 0.5) == np.floor((high + NEAR_POLE) / math.pi + 0.5)
    branch &= known & (np.abs(low) + np.abs(high) < 1e6)
    ends = np.where(branch, np.tan(low), -np.inf), np.where(branch, np.tan(high), np.inf)
    margin = 1e-9 * (1.0 + np.square(ends[0]) + np.square(ends[1]))
    return made(ends[0] - margin, ends[1] + margin, a.undefined | ~known)


def _rising(function: Callable[[Floats], Floats], least: float = -np.inf, greatest: float = np.inf) -> Forward:
    """A function that never falls, defined on [least, greatest]."""

    def forward(a: Interval) -> Interval:
        low, high = function(np.clip(a.low, least, greatest)), function(np.clip(a.high, least, greatest))
        return slackened(low, high, a.undefined | (a.low < least) | (a.high > greatest))

    return forward


def _acos(a: Interval) -> Interval:
    turned = _rising(np.arcsin, -1.0, 1.0)(a)
    return slackened(0.5 * math.pi - turned.high, 0.5 * math.pi - turned.low, turned.undefined)


def _atan2(a: Interval, b: Interval) -> Interval:
    corners = np.stack([np.arctan2(y, x) for y in (a.low, a.high) for x in (b.low, b.high)])
    ahead = b.low > 0.0
    low, high = np.where(ahead, corners.min(axis=0), -math.pi), np.where(ahead, corners.max(axis=0), math.pi)
    return slackened(low, high, _either(a, b))


def _exactly_rising(function: Callable[[Floats], Floats]) -> Forward:
    return lambda a: Interval(function(a.low), function(a.high), a.undefined)


def _hypot(a: Interval, b: Interval) -> Interval:
    x, y = _abs(a), _abs(b)
    low, high = np.hypot(x.low, y.low), np.hypot(x.high, y.high)
    return made(np.maximum(low * (1.0 - RELATIVE), 0.0), high * (1.0 + RELATIVE), _either(a, b))


def _wrap(a: Interval) -> Interval:
    """One turn: where both ends lie on the same one, they are moved back by it."""
    known = ~_infinite(a) & (np.abs(a.low) < 1e6) & (np.abs(a.high) < 1e6)
    low, high = np.where(known, a.low, 0.0), np.where(known, a.high, 0.0)
    inside = known & (low >= -math.pi) & (high < math.pi)
    turn = np.floor((low - NEAR_POLE + math.pi) / FULL_TURN)
    same = known & (turn == np.floor((high + NEAR_POLE + math.pi) / FULL_TURN)) & ~inside
    moved = low - FULL_TURN * turn - NEAR_POLE, high - FULL_TURN * turn + NEAR_POLE
    return Interval(
        np.where(inside, low, np.where(same, moved[0], -math.pi)),
        np.where(inside, high, np.where(same, moved[1], math.pi)),
        a.undefined | _infinite(a),
    )


def _normal_quantile(a: Interval) -> Interval:
    inside = _rising(lambda p: np.array([_quantile(float(x)) for x in p]), 0.0, 1.0)(a)
    return slackened(inside.low - 1e-9, inside.high + 1e-9, inside.undefined)


def _quantile(p: float) -> float:
    if not 0.0 < p < 1.0:
        return -math.inf if p <= 0.0 else math.inf
    from statistics import NormalDist  # slow to import, and rarely asked

    return NormalDist().inv_cdf(p)


def _normal_cdf(a: Interval) -> Interval:
    values = [np.array([0.5 * math.erfc(-x / math.sqrt(2.0)) for x in end.tolist()]) for end in (a.low, a.high)]
    return slackened(values[0], values[1], a.undefined)


# -- truth ------------------------------------------------------------------------------------------------------------


def truth(sure: Bools, never: Bools) -> Interval:
    """1 where sure, 0 where never, both in between."""
    return Interval(sure.astype(np.float64), (~never).astype(np.float64), np.zeros(len(sure), dtype=bool))


def surely_true(a: Interval) -> Bools:
    """Not zero; NaN counts as true, as in the kernels."""
    return (a.low > 0.0) | (a.high < 0.0)


def surely_false(a: Interval) -> Bools:
    return (a.low == 0.0) & (a.high == 0.0) & ~a.undefined


def _lt(a: Interval, b: Interval) -> Interval:
    return truth((a.high < b.low) & ~_either(a, b), a.low >= b.high)


def _le(a: Interval, b: Interval) -> Interval:
    return truth((a.high <= b.low) & ~_either(a, b), a.low > b.high)


def _eq(a: Interval, b: Interval) -> Interval:
    same = (a.low == a.high) & (b.low == b.high) & (a.low == b.low) & ~_either(a, b)
    return truth(same, (a.high < b.low) | (a.low > b.high))


def _not(a: Interval) -> Interval:
    return truth(surely_false(a), surely_true(a))


def _and(a: Interval, b: Interval) -> Interval:
    return truth(surely_true(a) & surely_true(b), surely_false(a) | surely_false(b))


def _or(a: Interval, b: Interval) -> Interval:
    return truth(surely_true(a) | surely_true(b), surely_false(a) & surely_false(b))


def _select(a: Interval, b: Interval, c: Interval) -> Interval:
    then, otherwise = surely_true(a), surely_false(a)
    low = np.where(then, b.low, np.where(otherwise, c.low, np.minimum(b.low, c.low)))
    high = np.where(then, b.high, np.where(otherwise, c.high, np.maximum(b.high, c.high)))
    return Interval(low, high, np.where(then, b.undefined, np.where(otherwise, c.undefined, _either(b, c))))


FORWARD: Mapping[Op, Forward] = {
    Op.MOVE: lambda a: a,
    Op.ADD: _add,
    Op.SUB: _sub,
    Op.MUL: _mul,
    Op.DIV: _div,
    Op.MOD: _mod,
    Op.FLOORDIV: _floordiv,
    Op.POW: _pow,
    Op.NEG: _neg,
    Op.ABS: _abs,
    Op.MIN: _min,
    Op.MAX: _max,
    Op.SQRT: _sqrt,
    Op.SIN: _wave(np.sin),
    Op.COS: _wave(np.cos),
    Op.TAN: _tan,
    Op.ASIN: _rising(np.arcsin, -1.0, 1.0),
    Op.ACOS: _acos,
    Op.ATAN: _rising(np.arctan),
    Op.ATAN2: _atan2,
    Op.EXP: _rising(np.exp),
    Op.LOG: _rising(np.log, 0.0),
    Op.FLOOR: _exactly_rising(np.floor),
    Op.CEIL: _exactly_rising(np.ceil),
    Op.ROUND: _exactly_rising(np.rint),
    Op.HYPOT: _hypot,
    Op.WRAP: _wrap,
    Op.LT: _lt,
    Op.LE: _le,
    Op.EQ: _eq,
    Op.NE: lambda a, b: _not(_eq(a, b)),
    Op.AND: _and,
    Op.OR: _or,
    Op.NOT: _not,
    Op.SELECT: _select,
    Op.NORMAL_QUANTILE: _normal_quantile,
    Op.NORMAL_CDF: _normal_cdf,
}
"""Every scalar instruction but `Op.TABLE`, which needs the program's pool."""

TRUTHS = frozenset({Op.LT, Op.LE, Op.EQ, Op.NE, Op.AND, Op.OR, Op.NOT, Op.REGION_CONTAINS, Op.REGION_CONTAINS_BOX,
                    Op.CAN_SEE})  # fmt: skip
"""Instructions that give 1 or 0 and nothing else."""


def table(pool: Floats, first: int, index: Interval) -> Interval:
    """`Op.TABLE`: the least and greatest of the options that the index may name; held inside the pool."""
    last = len(pool) - 1
    start = np.clip(np.nan_to_num(first + np.floor(index.low)), 0, last).astype(np.int64)
    end = np.clip(np.nan_to_num(first + np.floor(index.high)), 0, last).astype(np.int64)
    low, high = np.full(len(start), np.inf), np.full(len(start), -np.inf)
    for option in range(int(start.min(initial=last)), int(end.max(initial=0)) + 1):
        may = (start <= option) & (option <= end)
        low, high = (
            np.where(may, np.minimum(low, pool[option]), low),
            np.where(may, np.maximum(high, pool[option]), high),
        )
    low, high = np.where(index.undefined, pool.min(), low), np.where(index.undefined, pool.max(), high)
    return made(low, high, np.zeros(len(start), dtype=bool))
