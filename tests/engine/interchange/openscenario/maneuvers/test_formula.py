"""Formulas: what is written is worth what was meant."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula
from engine.interchange.xml_writing import decimal
from tests.engine.interchange.openscenario.maneuvers.conftest import (
    evaluated,
    formulas,
    numbers,
    parameters,
)

SPEED, DIST = formula.parameter("SPEED"), formula.parameter("DIST")


@given(formulas, parameters)
def test_text_is_worth_what_the_formula_is(made: Formula, values: dict[str, float]) -> None:
    """Read back by an evaluator that knows nothing of us."""
    worth = made.value(values)
    assert evaluated(made.expression(), values) == pytest.approx(worth, rel=1e-6, abs=1e-3 + 1e-7 * abs(worth))


@given(formulas, formulas, parameters)
def test_sums_and_extremes_are_what_they_say(one: Formula, other: Formula, values: dict[str, float]) -> None:
    """Brackets are left out and numbers gathered, which must not change anything."""
    a, b = one.value(values), other.value(values)
    slack = 1e-9 * (1.0 + abs(a) + abs(b))
    assert formula.add(one, other).value(values) == pytest.approx(a + b, abs=slack)
    assert formula.subtract(one, other).value(values) == pytest.approx(a - b, abs=slack)
    assert formula.least(one, other).value(values) == pytest.approx(min(a, b), abs=slack)
    assert formula.most(one, other).value(values) == pytest.approx(max(a, b), abs=slack)


@given(numbers, numbers)
def test_what_depends_on_nothing_is_a_number(a: float, b: float) -> None:
    made = formula.multiply(formula.number(a), formula.positive(formula.number(b)))
    assert made.plain
    assert made == formula.number(a * max(b, 0.0))


@pytest.mark.parametrize(
    ("made", "text"),
    [
        (formula.number(3.0), "3"),
        (formula.number(1e-7), "0.0000001"),
        (SPEED, "$SPEED"),
        (formula.scaled(SPEED, 1 / 3.6), "${$SPEED / 3.6}"),
        (formula.scaled(SPEED, 0.001), "${$SPEED * 0.001}"),
        (formula.scaled(SPEED, 1.0), "$SPEED"),
        (formula.subtract(formula.number(50.0), formula.subtract(formula.number(48.5), DIST)), "${1.5 + $DIST}"),
        (formula.subtract(SPEED, formula.number(-2.0)), "${$SPEED + 2}"),
        (formula.multiply(formula.add(SPEED, DIST), SPEED), "${($SPEED + $DIST) * $SPEED}"),
        (formula.divide(SPEED, formula.multiply(SPEED, DIST)), "${$SPEED / ($SPEED * $DIST)}"),
        (formula.multiply(SPEED, formula.number(-2.0)), "${$SPEED * (-2)}"),
        (formula.square(formula.add(SPEED, DIST)), "${($SPEED + $DIST) * ($SPEED + $DIST)}"),
        (formula.positive(SPEED), "${($SPEED + sqrt($SPEED * $SPEED)) / 2}"),
    ],
)
def test_text_is_as_a_person_would_write_it(made: Formula, text: str) -> None:
    assert made.expression() == text


def test_what_has_no_value_is_no_number() -> None:
    """A quotient by 0 or a root of less than 0 is NaN, no traceback."""
    assert math.isnan(formula.divide(SPEED, DIST).value({"SPEED": 1.0, "DIST": 0.0}))
    assert math.isnan(formula.applied("sqrt", SPEED).value({"SPEED": -1.0}))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_read_back_without_an_exponent(value: float) -> None:
    text = decimal(value)
    assert "e" not in text.lower()
    assert float(text) == value
