"""Interval arithmetic holds what the kernels compute."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from engine.feasibility.arithmetic import Interval, everything, surely_false, surely_true
from engine.feasibility.contraction import narrowed
from engine.feasibility.distances import by_id
from engine.feasibility.forward import FORWARD
from engine.feasibility.tape import THREE, TWO
from engine.kernels import evaluate
from engine.kernels.random_numbers import normal_cdf, normal_quantile
from engine.opcodes import Op

SPECIAL = (-math.inf, -3.0, -1.0, -1e-300, 0.0, 0.5, 1.0, 2.0, 7.0, 1e8, math.inf)
BOXES = 400


def plain(function: Callable[..., Any]) -> Callable[..., Any]:
    return getattr(function, "py_func", function)


def computed(op: Op, values: list[float]) -> float:
    """What a kernel gives; Python's exceptions stand for its NaN and infinities."""
    x, y, z = (np.float64(v) for v in (*values, 0.0, 0.0)[:3])
    try:
        if op in (Op.NORMAL_QUANTILE, Op.NORMAL_CDF):
            return float((normal_quantile if op == Op.NORMAL_QUANTILE else normal_cdf)(float(x)))
        if op < Op.SQRT:
            return float(plain(evaluate.arithmetic)(op, x, y))
        if op < Op.LT:
            return float(_function(op, float(x), float(y)))
        return float(plain(evaluate.comparison)(op, x, y, z))
    except OverflowError:
        return math.inf
    except ValueError:
        return -math.inf if op == Op.LOG and x == 0.0 else math.nan


def _function(op: Op, x: float, y: float) -> float:
    if op == Op.WRAP:
        inside = -math.pi <= x < math.pi
        turned = x - math.tau * np.floor((x + math.pi) / math.tau)
        return x if inside else turned - math.tau if turned >= math.pi else turned
    return plain(evaluate.function)(op, np.float64(x), np.float64(y))


def random_intervals(rng: np.random.Generator, count: int) -> Interval:
    ends = rng.normal(0.0, 1.0, (2, count)) * 10.0 ** rng.integers(-2, 3, (2, count))
    picked = rng.random((2, count)) < 0.2
    ends[picked] = rng.choice([v for v in SPECIAL if math.isfinite(v)], picked.sum())
    ends.sort(axis=0)
    same = rng.random(count) < 0.2
    ends[1, same] = ends[0, same]
    return Interval(ends[0], ends[1], rng.random(count) < 0.2)


def inside(rng: np.random.Generator, interval: Interval) -> np.ndarray:
    """A value of each box; NaN in some of those where it may be."""
    share = rng.choice([0.0, 1.0, 0.5, rng.random()], len(interval.low))
    values = np.clip(interval.low + share * (interval.high - interval.low), interval.low, interval.high)
    return np.where(interval.undefined & (rng.random(len(values)) < 0.5), math.nan, values)


@pytest.mark.parametrize("op", [op for op in FORWARD], ids=lambda op: op.name)  # noqa: C416
def test_forward_holds_every_value(op: Op) -> None:
    """Whatever lies in the operands, the result lies in the interval, and NaN only where one may be."""
    rng = np.random.default_rng(int(op))
    arity = 3 if op in THREE else 2 if op in TWO else 1
    operands = [random_intervals(rng, BOXES) for _ in range(arity)]
    if op in (Op.NORMAL_QUANTILE,):
        low, high, undefined = operands[0]
        operands = [Interval(np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0), undefined)]
    with np.errstate(all="ignore"):
        result = FORWARD[op](*operands)
        for _ in range(8):
            points = [inside(rng, operand) for operand in operands]
            for box in range(BOXES):
                value = computed(op, [p[box] for p in points])
                if math.isnan(value):
                    assert result.undefined[box], (op, [p[box] for p in points])
                else:
                    assert result.low[box] <= value <= result.high[box], (op, [p[box] for p in points], value)


@pytest.mark.parametrize("op", [op for op in FORWARD], ids=lambda op: op.name)  # noqa: C416
def test_backward_cuts_nothing_that_gives_the_result(op: Op) -> None:
    """Operands whose result lies in a narrower interval stay inside what is left of theirs."""
    rng = np.random.default_rng(1000 + int(op))
    arity = 3 if op in THREE else 2 if op in TWO else 1
    operands = [random_intervals(rng, BOXES) for _ in range(arity)]
    points = [inside(rng, operand) for operand in operands]
    with np.errstate(all="ignore"):
        values = np.array([computed(op, [p[box] for p in points]) for box in range(BOXES)])
        defined = ~np.isnan(values)
        margin = rng.choice([0.0, 0.0, 0.5], BOXES)
        result = Interval(values - margin, values + margin, np.zeros(BOXES, dtype=bool))
        for operand, ends in zip(points, narrowed(op, result, operands, [None] * arity), strict=True):
            if ends is not None:
                known = defined & ~np.isnan(operand)
                assert (ends[0] <= operand)[known].all()
                assert (operand <= ends[1])[known].all()


def test_truth_of_what_may_be_nan() -> None:
    """A comparison with NaN is NaN, which is neither true nor false, so nothing is sure of it."""
    unknown = everything(1)
    assert not surely_false(unknown)[0]
    assert not surely_true(unknown)[0]
    less = FORWARD[Op.LT](
        Interval(np.zeros(1), np.ones(1), np.ones(1, dtype=bool)),
        Interval(np.full(1, 9.0), np.full(1, 9.0), np.zeros(1, dtype=bool)),
    )
    assert less.undefined[0]
    assert not surely_true(less)[0]
    assert not surely_true(FORWARD[Op.NOT](less))[0]
    assert not surely_false(FORWARD[Op.NOT](less))[0]


def test_a_table_at_the_end_of_a_share_names_no_id() -> None:
    """Of two ids, 0 and 1, neither 2, nor a part of one, nor a negative one is known; nor is an interval of both."""
    low, high = np.array([1.0, 2.0, 0.5, -1.0, 0.0]), np.array([1.0, 2.0, 0.5, -1.0, 1.0])
    ids = Interval(low, high, np.zeros(5, dtype=bool))
    assert [(number, rows.tolist()) for number, rows in by_id(ids, ~ids.undefined, np.array([0, 3, 5]))] == [(1, [0])]
