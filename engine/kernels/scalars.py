"""Scalar instructions as plain functions: kernels compile them (`engine.kernels.evaluate`), the compiler calls them.

In a kernel nothing raises: division by zero gives an infinity or NaN, the root of a negative number NaN.
`engine.operators.Operator.value` gives Python the same results. A truth is 1.0, 0.0, or NaN where it depends on a NaN:
logic has three values (Kleene, "Introduction to Metamathematics", 1952, section 64). No import of numba.
"""

import math

import numpy as np

FULL_TURN = 2.0 * math.pi

# -- arithmetic --------------------------------------------------------------------------------------------------------


def move(x: float) -> float:
    return x


def add(x: float, y: float) -> float:
    return x + y


def subtract(x: float, y: float) -> float:
    return x - y


def multiply(x: float, y: float) -> float:
    return x * y


def divide(x: float, y: float) -> float:
    return x / y


def modulo(x: float, y: float) -> float:
    return x % y


def floor_divide(x: float, y: float) -> float:
    return x // y


def power(x: float, y: float) -> float:
    return x**y


def negate(x: float) -> float:
    return -x


def magnitude(x: float) -> float:
    return abs(x)


def minimum(x: float, y: float) -> float:
    return y if y < x else x


def maximum(x: float, y: float) -> float:
    return y if y > x else x


# -- functions ---------------------------------------------------------------------------------------------------------


def sqrt(x: float) -> float:
    return math.sqrt(x)


def sin(x: float) -> float:
    return math.sin(x)


def cos(x: float) -> float:
    return math.cos(x)


def tan(x: float) -> float:
    return math.tan(x)


def asin(x: float) -> float:
    return math.asin(x)


def acos(x: float) -> float:
    return math.acos(x)


def atan(x: float) -> float:
    return math.atan(x)


def atan2(x: float, y: float) -> float:
    return math.atan2(x, y)


def exp(x: float) -> float:
    return math.exp(x)


def log(x: float) -> float:
    """Return the natural logarithm; -inf at 0, where Python raises what it raises for a negative number."""
    return -math.inf if x == 0.0 else math.log(x)


# math's floor and ceil are integers, which overflow in kernels.


def floor(x: float) -> float:
    return float(np.floor(x))


def ceil(x: float) -> float:
    return float(np.ceil(x))


def rounded(x: float) -> float:
    """Return the nearest whole number, halves to even."""
    return float(np.rint(x))


def hypot(x: float, y: float) -> float:
    return math.hypot(x, y)


def wrap_angle(angle: float) -> float:
    """Return the angle [rad] brought into [-pi, pi); an angle in this range is returned bit for bit."""
    if -math.pi <= angle < math.pi:
        return angle
    turned = angle - FULL_TURN * float(np.floor((angle + math.pi) / FULL_TURN))
    return turned - FULL_TURN if turned >= math.pi else turned


def normal_cdf(x: float) -> float:
    """Return the probability that a standard normal variable is below x; erfc keeps the lower tail accurate."""
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def normal_quantile(p: float) -> float:
    """Return the x below which a standard normal variable lies with probability p; NaN outside [0, 1].

    For Python only; `engine.kernels.random_numbers` has that of kernels.
    """
    from statistics import NormalDist  # slow to import, and rarely needed

    if 0.0 < p < 1.0:
        return NormalDist().inv_cdf(p)
    return math.copysign(math.inf, p - 0.5) if p in (0.0, 1.0) else math.nan


# -- truths ------------------------------------------------------------------------------------------------------------


def less(x: float, y: float) -> float:
    return 1.0 if x < y else 0.0 if x >= y else math.nan


def at_most(x: float, y: float) -> float:
    return 1.0 if x <= y else 0.0 if x > y else math.nan


def equal(x: float, y: float) -> float:
    return 1.0 if x == y else 0.0 if abs(x) >= 0.0 and abs(y) >= 0.0 else math.nan


def unequal(x: float, y: float) -> float:
    return 0.0 if x == y else 1.0 if abs(x) >= 0.0 and abs(y) >= 0.0 else math.nan


def both(x: float, y: float) -> float:
    return 0.0 if x == 0.0 or y == 0.0 else 1.0 if abs(x) > 0.0 and abs(y) > 0.0 else math.nan


def either(x: float, y: float) -> float:
    return 1.0 if abs(x) > 0.0 or abs(y) > 0.0 else 0.0 if x == 0.0 and y == 0.0 else math.nan


def negation(x: float) -> float:
    return 1.0 if x == 0.0 else 0.0 if abs(x) > 0.0 else math.nan


def select(x: float, y: float, z: float) -> float:
    """Return y if x is true, z if x is false."""
    return y if abs(x) > 0.0 else z if x == 0.0 else math.nan
