"""Backward narrowing of operands by the result of an operator, over many boxes at once.

Each function takes the interval that a result must lie in and the operands' intervals, and gives narrower ends for each
operand. It is only asked about results that are numbers in every attempt that may still pass.
Source: Benhamou, Goualard, Granvilliers and Puget (1999), "Revising hull and box consistency", ICLP'99 (HC4).
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from engine import portable
from engine.operators.intervals import RELATIVE, Bools, Interval, surely_false, surely_true
from engine.tables import Floats

# -- bounds of operands from a result ----------------------------------------------------------------------------------

TINY, HUGE = 1e-300, 1e300
"""Range of magnitudes with full precision."""
Ends = tuple[Floats, Floats]
"""Least and greatest value, to be intersected with the known interval; arrays (n,)."""
Backward = Callable[..., Sequence[Ends | None]]
"""Backward function; its result is None for an operand without a bound."""


def _outward(low: Floats, high: Floats, *scale: Interval) -> Ends:
    """Return the ends moved outward by more than the rounding errors of the instruction and of this code."""
    size = sum((_size(interval) for interval in scale), start=np.zeros(len(low)))
    low, high = low - RELATIVE * size, high + RELATIVE * size
    return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)


def _size(a: Interval) -> Floats:
    size = np.maximum(np.abs(a.low), np.abs(a.high))
    return np.where(np.isfinite(size), size, 0.0)


def _only(condition: np.ndarray, ends: Ends) -> Ends:
    return np.where(condition, ends[0], -np.inf), np.where(condition, ends[1], np.inf)


def add(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return (
        _outward(z.low - b.high, z.high - b.low, z, b),
        _outward(z.low - a.high, z.high - a.low, z, a),
    )


def subtract(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return (
        _outward(z.low + b.low, z.high + b.high, z, b),
        _outward(a.low - z.high, a.high - z.low, z, a),
    )


def _factor(z: Interval, b: Interval) -> Ends:
    """Return bounds of the factor a of a * b = z."""
    quotients = np.stack([z.low / b.low, z.low / b.high, z.high / b.low, z.high / b.high])
    low, high = quotients.min(axis=0), quotients.max(axis=0)
    known = ((b.low > 0.0) | (b.high < 0.0)) & np.isfinite(low) & np.isfinite(high)
    margin = RELATIVE * np.maximum(np.abs(low), np.abs(high)) + 1e-300
    # A product may round to zero or below the smallest number, so such a small factor cannot be distinguished from
    # zero.
    tiny = np.maximum(np.abs(z.low), np.abs(z.high)) < 1e-200
    return _only(known & ~tiny, (low - margin, high + margin))


def multiply(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return _factor(z, b), _factor(z, a)


def divide(z: Interval, _a: Interval, b: Interval) -> Sequence[Ends | None]:
    products = np.stack([z.low * b.low, z.low * b.high, z.high * b.low, z.high * b.high])
    low, high = products.min(axis=0), products.max(axis=0)
    known = np.isfinite(low) & np.isfinite(high) & (np.maximum(np.abs(z.low), np.abs(z.high)) > 1e-200)
    margin = RELATIVE * np.maximum(np.abs(low), np.abs(high)) + 1e-300
    return _only(known, (low - margin, high + margin)), None


def negate(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((-z.high, -z.low),)


def magnitude(z: Interval, a: Interval) -> Sequence[Ends]:
    low = np.where(a.low > -z.low, np.maximum(z.low, -z.high), -z.high)
    high = np.where(a.high < z.low, np.minimum(-z.low, z.high), z.high)
    return ((low, high),)


def minimum(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    """Return the bounds for `b if b < a else a`; none for a b that may be NaN."""
    unbounded = np.full(len(z.low), np.inf)
    defined = ~b.undefined
    a_high = np.where(b.low > z.high, z.high, unbounded)
    b_high = np.where((a.low > z.high) & defined, z.high, unbounded)
    return (z.low, a_high), (np.where(defined, z.low, -unbounded), b_high)


def maximum(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    unbounded = np.full(len(z.low), np.inf)
    defined = ~b.undefined
    a_low = np.where(b.high < z.low, z.low, -unbounded)
    b_low = np.where((a.high < z.low) & defined, z.low, -unbounded)
    return (a_low, z.high), (b_low, np.where(defined, z.high, unbounded))


def sqrt(z: Interval, _a: Interval) -> Sequence[Ends]:
    low, high = np.square(np.maximum(z.low, 0.0)), np.square(np.maximum(z.high, 0.0))
    return ((low * (1.0 - 4.0 * RELATIVE) - TINY, high * (1.0 + 4.0 * RELATIVE) + TINY),)


def hypot(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return _leg(z, b), _leg(z, a)


def _leg(z: Interval, other: Interval) -> Ends:
    least = np.where((other.low <= 0.0) & (other.high >= 0.0), 0.0, np.minimum(np.abs(other.low), np.abs(other.high)))
    left = np.square(z.high) - np.square(least)
    reach = np.sqrt(np.maximum(left + 8.0 * RELATIVE * np.square(z.high), 0.0)) * (1.0 + 8.0 * RELATIVE) + math.sqrt(
        TINY
    )
    reach = np.where(np.isnan(reach) | (z.high < 0.0), np.inf, reach)
    return -reach, reach


def exp(z: Interval, _a: Interval) -> Sequence[Ends]:
    """Return the bounds; beyond `TINY` and `HUGE` an exponential has lost its digits, or is not a number."""
    low, high = portable.log(np.clip(z.low, TINY, HUGE)), portable.log(np.clip(z.high, TINY, HUGE))
    low, high = low - RELATIVE * (1.0 + np.abs(low)), high + RELATIVE * (1.0 + np.abs(high))
    return ((np.where(z.low > TINY, low, -np.inf), np.where(z.high < HUGE, high, np.inf)),)


def log(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((portable.exp(z.low) * (1.0 - 1e-9) - TINY, portable.exp(z.high) * (1.0 + 1e-9) + TINY),)


def shifted(down: float, up: float) -> Backward:
    """Return the narrowing of an operator whose operand lies between its result - down and its result + up."""

    def narrowed(z: Interval, _a: Interval) -> Sequence[Ends]:
        return ((z.low - down, z.high + up),)

    return narrowed


# -- truth ------------------------------------------------------------------------------------------------------------


def order(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    """Return the bounds for less, or less or equal; reversed where it surely fails."""
    holds, fails = z.low > 0.0, z.high == 0.0
    low, high = np.full(len(z.low), -np.inf), np.full(len(z.low), np.inf)
    return (
        (np.where(fails, b.low, low), np.where(holds, b.high, high)),
        (np.where(holds, a.low, low), np.where(fails, a.high, high)),
    )


def equal(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    holds = z.low > 0.0
    return _only(holds, (b.low, b.high)), _only(holds, (a.low, a.high))


def unequal(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    fails = z.high == 0.0
    return _only(fails, (b.low, b.high)), _only(fails, (a.low, a.high))


def _one_of(true: Bools, false: Bools) -> Ends:
    """Return the ends of a condition: at least 1 where it is true, 0 where it is false.

    `Operator.narrowed` takes the 1 back from a condition that is a number: any but zero is true.
    """
    return np.where(false, 0.0, np.where(true, 1.0, -np.inf)), np.where(false, 0.0, np.inf)


def both(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    holds, fails = z.low > 0.0, z.high == 0.0
    return (
        _one_of(holds, fails & surely_true(b)),
        _one_of(holds, fails & surely_true(a)),
    )


def either(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    holds, fails = z.low > 0.0, z.high == 0.0
    return (
        _one_of(holds & surely_false(b), fails),
        _one_of(holds & surely_false(a), fails),
    )


def negation(z: Interval, _a: Interval) -> Sequence[Ends]:
    return (_one_of(z.high == 0.0, z.low > 0.0),)


def select(z: Interval, a: Interval, _b: Interval, _c: Interval) -> Sequence[Ends | None]:
    ends = z.low, z.high
    return None, _only(surely_true(a), ends), _only(surely_false(a), ends)
