"""Intervals of the compiler: pairs of floats between which an operator's result lies, and the domains of operators.

`engine.operators.intervals` has the same on arrays, with an account of NaN, for thousands of boxes at once. The
compiler evaluates an expression once or twice, where one such array would cost more than the whole result. Tests
compare each of them with the values of the operators.
"""

import math
from collections.abc import Callable

from engine.frozen import frozen

Interval = tuple[float, float]
Bounds = Callable[..., Interval]

# -- bounds ------------------------------------------------------------------------------------------------------------

EVERYTHING: Interval = (-math.inf, math.inf)
ROUNDED = 1e-12
"""Relative slack of a length: more than the difference between two ways to round a square root."""


def add(a: Interval, b: Interval) -> Interval:
    return (a[0] + b[0], a[1] + b[1])


def subtract(a: Interval, b: Interval) -> Interval:
    return (a[0] - b[1], a[1] - b[0])


def multiply(a: Interval, b: Interval) -> Interval:
    return _hull(*(x * y for x in a for y in b))


def divide(a: Interval, b: Interval) -> Interval:
    return _hull(*(x / y for x in a for y in b)) if never_zero(b) else EVERYTHING


def _hull(*values: float) -> Interval:
    return (min(values), max(values))


def negate(a: Interval) -> Interval:
    return (-a[1], -a[0])


def magnitude(a: Interval) -> Interval:
    return (0.0 if a[0] <= 0.0 <= a[1] else min(map(abs, a)), max(map(abs, a)))


def minimum(a: Interval, b: Interval) -> Interval:
    return (min(a[0], b[0]), min(a[1], b[1]))


def maximum(a: Interval, b: Interval) -> Interval:
    return (max(a[0], b[0]), max(a[1], b[1]))


def sqrt(a: Interval) -> Interval:
    return EVERYTHING if a[0] < 0.0 else (math.sqrt(a[0]), math.sqrt(a[1]))


def wave(_a: Interval) -> Interval:
    """Return the range of sine and cosine."""
    return (-1.0, 1.0)


def floor(a: Interval) -> Interval:
    low, high = (end if math.isinf(end) else float(math.floor(end)) for end in a)
    return (low, high)


def hypot(a: Interval, b: Interval) -> Interval:
    (low, high), (least, most) = magnitude(a), magnitude(b)
    return (math.hypot(low, least) * (1.0 - ROUNDED), math.hypot(high, most) * (1.0 + ROUNDED))


def less(a: Interval, b: Interval) -> Interval:
    return _truth(a[1] < b[0], a[0] >= b[1])


def at_most(a: Interval, b: Interval) -> Interval:
    return _truth(a[1] <= b[0], a[0] > b[1])


def equal(a: Interval, b: Interval) -> Interval:
    return _truth(a[0] == a[1] == b[0] == b[1], a[1] < b[0] or b[1] < a[0])


def unequal(a: Interval, b: Interval) -> Interval:
    return negation(equal(a, b))


def both(a: Interval, b: Interval) -> Interval:
    return _truth(never_zero(a) and never_zero(b), (0.0, 0.0) in (a, b))


def either(a: Interval, b: Interval) -> Interval:
    return _truth(never_zero(a) or never_zero(b), a == b == (0.0, 0.0))


def negation(a: Interval) -> Interval:
    return _truth(a == (0.0, 0.0), never_zero(a))


def select(_condition: Interval, then: Interval, otherwise: Interval) -> Interval:
    return _hull(*then, *otherwise)


def _truth(always: bool, never: bool) -> Interval:
    return (float(always), float(not never))


def never_zero(a: Interval) -> bool:
    return a[0] > 0.0 or a[1] < 0.0


# -- domains -----------------------------------------------------------------------------------------------------------


@frozen
class Domain:
    """Operands for which an operator has a value."""

    holds: Callable[..., bool]
    """Whether all operands in these intervals have a value."""
    misses: Callable[..., bool] = lambda *_: False
    """Whether no operand in these intervals has a value."""


def within(low: float, high: float) -> Domain:
    """Return the domain of an operator of one number between two ends."""

    def holds(a: Interval) -> bool:
        return low <= a[0] and a[1] <= high

    def misses(a: Interval) -> bool:
        return a[1] < low or a[0] > high

    return Domain(holds, misses)


def _divides(_dividend: Interval, divisor: Interval) -> bool:
    return never_zero(divisor)


def _is_power(base: Interval, exponent: Interval) -> bool:
    """Return True for a positive base, or a known whole exponent."""
    return base[0] > 0.0 or (exponent[0] == exponent[1] >= 0.0 and exponent[0] == exponent[0] // 1.0)


DIVISIONS, POWERS = Domain(_divides), Domain(_is_power)
