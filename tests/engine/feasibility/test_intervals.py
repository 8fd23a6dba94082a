"""Interval arithmetic holds what the kernels compute."""

import math

import numpy as np
import pytest

from engine.feasibility.distances import by_id
from engine.opcodes import Op
from engine.operators import OPERATORS
from engine.operators.intervals import Interval, everything, surely_false, surely_true

SPECIAL = (-math.inf, -3.0, -1.0, -1e-300, 0.0, 0.5, 1.0, 2.0, 7.0, 1e8, math.inf)
BOXES = 400


def random_intervals(rng: np.random.Generator, count: int) -> Interval:
    ends = rng.normal(0.0, 1.0, (2, count)) * 10.0 ** rng.integers(-2, 3, (2, count))
    picked = rng.random((2, count)) < 0.2
    ends[picked] = rng.choice([v for v in SPECIAL if math.isfinite(v)], picked.sum())
    ends.sort(axis=0)
    same = rng.random(count) < 0.2
    ends[1, same] = ends[0, same]
    return Interval(ends[0], ends[1], rng.random(count) < 0.2)


def random_truths(rng: np.random.Generator, count: int) -> Interval:
    """Intervals of truths whose values are 0 or 1: known ones."""
    values = rng.integers(0, 2, count).astype(float)
    return Interval(values, values.copy(), np.zeros(count, dtype=bool))


def inside(rng: np.random.Generator, interval: Interval) -> np.ndarray:
    """A value of each box; NaN in some of those where it may be."""
    share = rng.choice([0.0, 1.0, 0.5, rng.random()], len(interval.low))
    values = np.clip(interval.low + share * (interval.high - interval.low), interval.low, interval.high)
    return np.where(interval.undefined & (rng.random(len(values)) < 0.5), math.nan, values)


@pytest.mark.parametrize("op", OPERATORS, ids=lambda op: op.name)
def test_forward_holds_every_value(op: Op) -> None:
    """Whatever lies in the operands, the result lies in the interval, and NaN only where one may be."""
    rng = np.random.default_rng(int(op))
    operands = [random_intervals(rng, BOXES) for _ in range(OPERATORS[op].arity)]
    if op in (Op.NORMAL_QUANTILE,):
        low, high, undefined = operands[0]
        operands = [Interval(np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0), undefined)]
    with np.errstate(all="ignore"):
        result = OPERATORS[op].forward(*operands)
        for _ in range(8):
            points = [inside(rng, operand) for operand in operands]
            for box in range(BOXES):
                value = OPERATORS[op].value(*[p[box] for p in points])
                if math.isnan(value):
                    assert result.undefined[box], (op, [p[box] for p in points])
                else:
                    assert result.low[box] <= value <= result.high[box], (op, [p[box] for p in points], value)


@pytest.mark.parametrize("truths", [False, True], ids=["of numbers", "of truths"])
@pytest.mark.parametrize("op", OPERATORS, ids=lambda op: op.name)
def test_backward_cuts_nothing_that_gives_the_result(op: Op, truths: bool) -> None:
    """Operands whose result lies in a narrower interval stay inside what is left of theirs."""
    rng, row = np.random.default_rng(1000 + int(op)), OPERATORS[op]
    operands = [random_truths(rng, BOXES) if truths else random_intervals(rng, BOXES) for _ in range(row.arity)]
    points = [inside(rng, operand) for operand in operands]
    with np.errstate(all="ignore"):
        values = np.array([row.value(*[p[box] for p in points]) for box in range(BOXES)])
        defined = ~np.isnan(values)
        margin = rng.choice([0.0, 0.0, 0.5], BOXES)
        result = Interval(values - margin, values + margin, np.zeros(BOXES, dtype=bool))
        for operand, ends in zip(
            points, OPERATORS[op].narrowed(result, operands, [False] * len(operands)), strict=True
        ):
            if ends is not None:
                known = defined & ~np.isnan(operand)
                assert (ends[0] <= operand)[known].all()
                assert (operand <= ends[1])[known].all()


def test_truth_of_what_may_be_nan() -> None:
    """A comparison with NaN is NaN, which is neither true nor false, so nothing is sure of it."""
    unknown = everything(1)
    assert not surely_false(unknown)[0]
    assert not surely_true(unknown)[0]
    less = OPERATORS[Op.LT].forward(
        Interval(np.zeros(1), np.ones(1), np.ones(1, dtype=bool)),
        Interval(np.full(1, 9.0), np.full(1, 9.0), np.zeros(1, dtype=bool)),
    )
    assert less.undefined[0]
    assert not surely_true(less)[0]
    assert not surely_true(OPERATORS[Op.NOT].forward(less))[0]
    assert not surely_false(OPERATORS[Op.NOT].forward(less))[0]


def test_a_table_at_the_end_of_a_share_names_no_id() -> None:
    """Of two ids, 0 and 1, neither 2, nor a part of one, nor a negative one is known; nor is an interval of both."""
    low, high = np.array([1.0, 2.0, 0.5, -1.0, 0.0]), np.array([1.0, 2.0, 0.5, -1.0, 1.0])
    ids = Interval(low, high, np.zeros(5, dtype=bool))
    assert [(number, rows.tolist()) for number, rows in by_id(ids, ~ids.undefined, np.array([0, 3, 5]))] == [(1, [0])]
