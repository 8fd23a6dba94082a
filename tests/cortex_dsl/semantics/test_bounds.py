"""The compiler's intervals hold the values of each operator."""

import math
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.bounds import interval
from cortex_dsl.source import Span
from engine.opcodes import Op
from engine.operators import OPERATORS

PLACE = Span(0, 0)
ENDS = (-math.inf, -7.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.5, 1e8, math.inf)
numbers = st.floats(-1e6, 1e6) | st.sampled_from([end for end in ENDS if math.isfinite(end)])


@st.composite
def operands(draw: st.DrawFn) -> tuple[tuple[float, float], float]:
    """Ends between which an operand lies, finite or not, and a number there."""
    number = draw(numbers)
    low, high = draw(numbers | st.just(-math.inf)), draw(numbers | st.just(math.inf))
    return (min(low, number), max(high, number)), number


def held(op: Op, within: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """What the compiler knows of an operation on genes that lie there."""
    genes = tuple(ir.Gene(PLACE, i) for i in range(len(within)))
    return interval(ir.Apply(PLACE, op, genes), dict(enumerate(within)))


@pytest.mark.parametrize("op", OPERATORS, ids=lambda op: op.name)
@given(st.data())
def test_the_compiler_holds_what_the_engine_computes(op: Op, data: st.DataObject) -> None:
    """Of numbers between the ends, the result lies between the ends that the compiler gives."""
    within, values = zip(*(data.draw(operands()) for _ in range(OPERATORS[op].arity)), strict=True)
    low, high = held(op, within)
    value = OPERATORS[op].value(*values)
    assert math.isnan(value) or low <= value <= high, (values, within)


def test_a_length_is_at_least_that_of_its_least_sides_and_at_most_that_of_its_largest() -> None:
    """Sides of 3 to 5 and of -4 to 12; of any, 0 or more."""
    assert held(Op.HYPOT, [(3.0, 5.0), (4.0, 12.0)]) == pytest.approx((5.0, 13.0), rel=1e-9)
    assert held(Op.HYPOT, [(3.0, 5.0), (-4.0, 12.0)]) == pytest.approx((3.0, 13.0), rel=1e-9)
    assert held(Op.HYPOT, [(-math.inf, math.inf), (-1.0, 1.0)]) == (0.0, math.inf)


@pytest.mark.parametrize("ends", [(0.5, math.inf), (-math.inf, 0.5), (-0.5, 2.5)])
def test_the_floor_of_an_end_is_rounded_even_if_the_other_is_infinite(ends: tuple[float, float]) -> None:
    """Half a metre is zero whole metres, however long the rest may be."""
    assert held(Op.FLOOR, [ends]) == tuple(end if math.isinf(end) else math.floor(end) for end in ends)


@pytest.mark.parametrize(
    ("op", "within", "expected"),
    [
        (Op.SQRT, [(4.0, 9.0)], (2.0, 3.0)),
        (Op.SQRT, [(0.0, math.inf)], (0.0, math.inf)),
        (Op.SQRT, [(-1.0, 9.0)], (-math.inf, math.inf)),
        (Op.ADD, [(1.0, 2.0), (10.0, 20.0)], (11.0, 22.0)),
        (Op.SUB, [(1.0, 2.0), (10.0, 20.0)], (-19.0, -8.0)),
        (Op.MUL, [(-1.0, 2.0), (10.0, 20.0)], (-20.0, 40.0)),
        (Op.DIV, [(1.0, 2.0), (4.0, 8.0)], (0.125, 0.5)),
        (Op.ABS, [(-3.0, 2.0)], (0.0, 3.0)),
        (Op.MIN, [(1.0, 5.0), (2.0, 3.0)], (1.0, 3.0)),
        (Op.MAX, [(1.0, 5.0), (2.0, 3.0)], (2.0, 5.0)),
        (Op.CEIL, [(0.5, 2.5)], (1.0, 3.0)),
        (Op.ROUND, [(0.2, 2.8)], (0.0, 3.0)),
        (Op.NORMAL_QUANTILE, [(0.1, 0.9)], (-math.inf, math.inf)),
        (Op.LT, [(1.0, 2.0), (2.5, 3.0)], (1.0, 1.0)),
        (Op.LT, [(2.0, 3.0), (1.0, 2.0)], (0.0, 0.0)),
        (Op.LE, [(1.0, 2.0), (2.0, 3.0)], (1.0, 1.0)),
    ],
)
def test_intervals_are_tight(op: Op, within: Sequence[tuple[float, float]], expected: tuple[float, float]) -> None:
    """An interval that is too wide proves nothing: a `require` that always holds would go unnoticed."""
    assert held(op, within) == expected
