"""The interval version of every scalar instruction: it contains every value on operands in the given intervals.

Functions without correct rounding have a slack far above their error.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from engine import portable
from engine.feasibility import arithmetic
from engine.feasibility.arithmetic import RELATIVE, Forward, Interval, either, infinite, made, magnitude, slackened
from engine.opcodes import Op
from engine.tables import Floats

# -- functions ---------------------------------------------------------------------------------------------------------

NEAR_POLE = 1e-9
"""Distance from a jump or pole of a periodic function at which the branch is still certain [rad]."""
FULL_TURN = 2.0 * math.pi


def unchanged(a: Interval) -> Interval:
    return a


def unequal(a: Interval, b: Interval) -> Interval:
    return arithmetic.negation(arithmetic.equal(a, b))


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


def arccosine(a: Interval) -> Interval:
    turned = rising(portable.arcsin, -1.0, 1.0)(a)
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
    turn = np.floor((low - NEAR_POLE + math.pi) / FULL_TURN)
    same = known & (turn == np.floor((high + NEAR_POLE + math.pi) / FULL_TURN)) & ~inside
    moved = low - FULL_TURN * turn - NEAR_POLE, high - FULL_TURN * turn + NEAR_POLE
    return Interval(
        np.where(inside, low, np.where(same, moved[0], -math.pi)),
        np.where(inside, high, np.where(same, moved[1], math.pi)),
        a.undefined | infinite(a),
    )


def normal_quantile(a: Interval) -> Interval:
    inside = rising(lambda p: np.array([_quantile(float(x)) for x in p]), 0.0, 1.0)(a)
    return slackened(inside.low - 1e-9, inside.high + 1e-9, inside.undefined)


def _quantile(p: float) -> float:
    if not 0.0 < p < 1.0:
        return -math.inf if p <= 0.0 else math.inf
    from statistics import NormalDist  # slow to import, rarely used

    return NormalDist().inv_cdf(p)


def normal_cdf(a: Interval) -> Interval:
    values = [np.array([0.5 * math.erfc(-x / math.sqrt(2.0)) for x in end.tolist()]) for end in (a.low, a.high)]
    return slackened(values[0], values[1], a.undefined)


# -- every instruction -------------------------------------------------------------------------------------------------

FORWARD: Mapping[Op, Forward] = {
    Op.MOVE: unchanged,
    Op.ADD: arithmetic.add,
    Op.SUB: arithmetic.sub,
    Op.MUL: arithmetic.mul,
    Op.DIV: arithmetic.div,
    Op.MOD: arithmetic.mod,
    Op.FLOORDIV: arithmetic.floordiv,
    Op.POW: arithmetic.power,
    Op.NEG: arithmetic.neg,
    Op.ABS: arithmetic.magnitude,
    Op.MIN: arithmetic.least,
    Op.MAX: arithmetic.greatest,
    Op.SQRT: root,
    Op.SIN: wave(np.sin),
    Op.COS: wave(np.cos),
    Op.TAN: tangent,
    Op.ASIN: rising(portable.arcsin, -1.0, 1.0),
    Op.ACOS: arccosine,
    Op.ATAN: rising(portable.arctan),
    Op.ATAN2: direction,
    Op.EXP: rising(portable.exp),
    Op.LOG: rising(portable.log, 0.0),
    Op.FLOOR: exactly_rising(np.floor),
    Op.CEIL: exactly_rising(np.ceil),
    Op.ROUND: exactly_rising(np.rint),
    Op.HYPOT: length,
    Op.WRAP: wrapped,
    Op.LT: arithmetic.below,
    Op.LE: arithmetic.at_most,
    Op.EQ: arithmetic.equal,
    Op.NE: unequal,
    Op.AND: arithmetic.both,
    Op.OR: arithmetic.one_of,
    Op.NOT: arithmetic.negation,
    Op.SELECT: arithmetic.select,
    Op.NORMAL_QUANTILE: normal_quantile,
    Op.NORMAL_CDF: normal_cdf,
}
"""Every scalar instruction but `Op.TABLE`, which needs the program's pool."""

TRUTHS = frozenset({Op.LT, Op.LE, Op.EQ, Op.NE, Op.AND, Op.OR, Op.NOT, Op.REGION_CONTAINS, Op.REGION_CONTAINS_BOX,
                    Op.CAN_SEE})  # fmt: skip
"""Instructions with the results 1 and 0 only."""


def table(pool: Floats, first: int, index: Interval) -> Interval:
    """Return the least and greatest of the options that the index of `Op.TABLE` may name, clipped to the pool."""
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
