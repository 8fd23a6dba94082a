"""The interval version of every scalar instruction: one that holds every value it can have on operands in theirs."""

from collections.abc import Mapping

import numpy as np

from engine.feasibility import arithmetic, functions
from engine.feasibility.intervals import Forward, Interval, made
from engine.tables import Floats
from engine.vocabulary import Op

FORWARD: Mapping[Op, Forward] = {
    Op.MOVE: lambda a: a,
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
    Op.SQRT: functions.root,
    Op.SIN: functions.wave(np.sin),
    Op.COS: functions.wave(np.cos),
    Op.TAN: functions.tangent,
    Op.ASIN: functions.rising(np.arcsin, -1.0, 1.0),
    Op.ACOS: functions.arccosine,
    Op.ATAN: functions.rising(np.arctan),
    Op.ATAN2: functions.direction,
    Op.EXP: functions.rising(np.exp),
    Op.LOG: functions.rising(np.log, 0.0),
    Op.FLOOR: functions.exactly_rising(np.floor),
    Op.CEIL: functions.exactly_rising(np.ceil),
    Op.ROUND: functions.exactly_rising(np.rint),
    Op.HYPOT: functions.length,
    Op.WRAP: functions.wrapped,
    Op.LT: arithmetic.below,
    Op.LE: arithmetic.at_most,
    Op.EQ: arithmetic.equal,
    Op.NE: lambda a, b: arithmetic.negation(arithmetic.equal(a, b)),
    Op.AND: arithmetic.both,
    Op.OR: arithmetic.one_of,
    Op.NOT: arithmetic.negation,
    Op.SELECT: arithmetic.select,
    Op.NORMAL_QUANTILE: functions.normal_quantile,
    Op.NORMAL_CDF: functions.normal_cdf,
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
