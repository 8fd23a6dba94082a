"""The compiler's intervals hold the values of each operator."""

import math
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import compile_text, ir
from cortex_dsl.semantics.quantities import bounds
from cortex_dsl.semantics.quantities.bounds import folded, interval, operands, parts
from cortex_dsl.source import Span
from engine.opcodes import Op
from engine.operators import OPERATORS

PLACE = Span(0, 0)
ENDS = (-math.inf, -7.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.5, 1e8, math.inf)
numbers = st.floats(-1e6, 1e6) | st.sampled_from([end for end in ENDS if math.isfinite(end)])


@st.composite
def number_between(draw: st.DrawFn) -> tuple[tuple[float, float], float]:
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
    within, values = zip(*(data.draw(number_between()) for _ in range(OPERATORS[op].arity)), strict=True)
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


# -- how often a part is looked at -------------------------------------------------------------------------------------

CHAIN = """
map intersection()
behavior Drive():
    while {condition}:
        take SetBrakeAction(0.1)
ego = new Car on road, with behavior Drive()
"""
STEPS = {
    "greatest": "max(1 m/s, {})",
    "inverse": "(1 m/s) * (1 m/s) / ({})",
    "root": "sqrt(({}) * 2 m/s)",
    "comparison": "(2 m/s if ({}) < 3 else 1 m/s)",
}
"""Further operations on a number, each of which is bounded or tested when it is made."""


def visited(step: str, count: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """Return the number of parts at which the compiler looks for a condition of so many steps."""
    looked: list[ir.Expr] = []

    def counted(expression: ir.Expr) -> tuple[ir.Expr, ...]:
        looked.append(expression)
        return operands(expression)

    number = "self.speed"
    for _ in range(count):
        number = step.format(number)
    with monkeypatch.context() as patch:
        patch.setattr(bounds, "operands", counted)
        compile_text(CHAIN.format(condition=f"{number} < 9 m/s"))
    return len(looked)


@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_a_longer_number_takes_the_compiler_proportionally_more_looks(
    step: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each step adds as many as the step before it, though every step is made of all the steps before."""
    few, more, most = (visited(step, count, monkeypatch) for count in (5, 15, 25))
    assert most - more <= 1.2 * (more - few)


@given(st.data())
def test_what_was_folded_before_changes_no_result(data: st.DataObject) -> None:
    """The results of all parts, in any order of asking, are those of each part alone."""
    made: list[ir.Expr] = [ir.Gene(PLACE, 0), ir.Literal(PLACE, 2.0)]
    for op in data.draw(st.lists(st.sampled_from([Op.ADD, Op.MUL, Op.MAX, Op.SUB]), max_size=12)):
        made.append(ir.Apply(PLACE, op, (data.draw(st.sampled_from(made)), data.draw(st.sampled_from(made)))))

    def text(part: ir.Expr, inside: list[str]) -> str:
        return f"{made.index(part)}({','.join(inside)})"

    known: dict[ir.Expr, str] = {}
    for each in data.draw(st.permutations(made)):
        assert folded(each, text, known) == folded(each, text)
        assert parts(each, known) == []
