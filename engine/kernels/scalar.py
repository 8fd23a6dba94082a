"""The scalar instructions, one function a family: numbers in, number out, Python's meaning.

Nothing raises: dividing by zero gives an infinity or NaN, the root of a negative number NaN. Truth is 1.0 / 0.0.
Each chain of comparisons with constants becomes one jump table in machine code.
"""

import math

import numpy as np

from engine.kernels.inline import inlined
from engine.kernels.normal import normal_cdf, normal_quantile
from engine.vocabulary import Op

FULL_TURN = 2.0 * math.pi


@inlined
def wrap_angle(angle: float) -> float:
    """The angle brought into [-pi, pi) [rad]; one that lies there already is returned bit for bit."""
    if -math.pi <= angle < math.pi:
        return angle
    turned = angle - FULL_TURN * np.floor((angle + math.pi) / FULL_TURN)
    return turned - FULL_TURN if turned >= math.pi else turned


@inlined
def arithmetic(op: int, x: float, y: float) -> float:
    """`Op.MOVE` to `Op.MAX`."""
    if op == Op.MOVE:
        return x
    if op == Op.ADD:
        return x + y
    if op == Op.SUB:
        return x - y
    if op == Op.MUL:
        return x * y
    if op == Op.DIV:
        return x / y
    if op == Op.MOD:
        return x % y
    if op == Op.FLOORDIV:
        return x // y
    if op == Op.POW:
        return x**y
    if op == Op.NEG:
        return -x
    if op == Op.ABS:
        return abs(x)
    if op == Op.MIN:
        return y if y < x else x
    return y if y > x else x


@inlined
def function(op: int, x: float, y: float) -> float:
    """`Op.SQRT` to `Op.WRAP`."""
    if op == Op.SQRT:
        return math.sqrt(x)
    if op == Op.SIN:
        return math.sin(x)
    if op == Op.COS:
        return math.cos(x)
    if op == Op.TAN:
        return math.tan(x)
    if op == Op.ASIN:
        return math.asin(x)
    if op == Op.ACOS:
        return math.acos(x)
    if op == Op.ATAN:
        return math.atan(x)
    if op == Op.ATAN2:
        return math.atan2(x, y)
    if op == Op.EXP:
        return math.exp(x)
    if op == Op.LOG:
        return math.log(x)
    # numpy's floor and ceil stay floats; math's overflow as integers.
    if op == Op.FLOOR:
        return np.floor(x)
    if op == Op.CEIL:
        return np.ceil(x)
    if op == Op.ROUND:
        return np.rint(x)
    if op == Op.HYPOT:
        return math.hypot(x, y)
    return wrap_angle(x)


@inlined
def comparison(op: int, x: float, y: float, z: float) -> float:
    """`Op.LT` to `Op.SELECT`."""
    if op == Op.LT:
        return 1.0 if x < y else 0.0
    if op == Op.LE:
        return 1.0 if x <= y else 0.0
    if op == Op.EQ:
        return 1.0 if x == y else 0.0
    if op == Op.NE:
        return 1.0 if x != y else 0.0
    if op == Op.AND:
        return 1.0 if x != 0.0 and y != 0.0 else 0.0
    if op == Op.OR:
        return 1.0 if x != 0.0 or y != 0.0 else 0.0
    if op == Op.NOT:
        return 1.0 if x == 0.0 else 0.0
    return y if x != 0.0 else z


@inlined
def distribution(op: int, x: float) -> float:
    """`Op.NORMAL_QUANTILE` and `Op.NORMAL_CDF`."""
    if op == Op.NORMAL_QUANTILE:
        return normal_quantile(x)
    return normal_cdf(x)
