"""How far a condition of one moment holds or is broken, as one number: above 0 it holds, below 0 it is broken.

Margins (`bounds`) in units that make them comparable, and a number for what has none: a bare truth is worth 1 or -1,
what lies in a region how deep it does. Donze and Maler (2010), "Robust satisfaction of temporal logic over real-valued
signals", FORMATS 2010, section 2; the units are ours. Over the samples of a run, `engine.kernels.temporal` goes on.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.quantities.algebra import (
    Operation,
    Term,
    equal,
    maximum,
    minimum,
    region_box_depth,
    region_depth,
    where,
)
from cortex_dsl.semantics.quantities.bounds import Dimensions, margin_of, parts
from engine.opcodes import Op

ANGLE_UNIT = 0.1
"""What counts as much as 1 m, 1 m/s, 1 m/s^2, 1 s or a pure 1 [rad]."""

_DEPTHS = {Op.REGION_CONTAINS: region_depth, Op.REGION_CONTAINS_BOX: region_box_depth}
_COMPARISONS = (Op.LT, Op.LE, Op.EQ, Op.NE)
_ENDLESS = (Op.TTC, Op.LEAD, Op.CROSSING)
"""What is infinite where nothing lies ahead."""


def robustness_of(condition: Term, compared: Dimensions) -> Term:
    """The robustness of a condition whose comparisons have the dimensions `compared`."""
    try:
        return _robustness(condition, compared)
    except Mistake:  # a chain of operations as long as there may be: the condition fits, and is no more than true
        return _of_truth(condition)


def _robustness(condition: Term, compared: Dimensions) -> Term:
    match condition:
        case Operation(op=Op.AND, arguments=(one, other)):
            return minimum(_robustness(one, compared), _robustness(other, compared))
        case Operation(op=Op.OR, arguments=(one, other)):
            return maximum(_robustness(one, compared), _robustness(other, compared))
        case Operation(op=Op.NOT, arguments=(inner,)):
            return -_robustness(inner, compared)
        case Operation(op=op, arguments=arguments) if op in _DEPTHS:
            return _DEPTHS[op](*arguments)
        case Operation(op=op, arguments=(left, right)) if op in _COMPARISONS:
            return _of_comparison(condition, left, right, compared)
    return _of_truth(condition)


def _of_truth(condition: Term) -> Term:
    return where(condition, 1.0, -1.0)


def _of_comparison(condition: Term, left: Term, right: Term, compared: Dimensions) -> Term:
    margin, dimension = margin_of(condition, compared)
    if margin is None:
        return _of_truth(condition)
    if _may_be_infinite(left) and _may_be_infinite(right):
        margin = where(equal(left, right), 0.0, margin)  # the difference of two infinities is no number
    return margin / ANGLE_UNIT**dimension.angle if dimension.angle else margin


def _may_be_infinite(side: Term) -> bool:
    return any(isinstance(part, ir.Apply) and part.op in _ENDLESS for part in parts(side))
