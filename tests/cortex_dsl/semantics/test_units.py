"""Units and dimensions: laws that hold for every number, and the tables of their words and sizes."""

import re
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import ir
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.evaluation.arguments import usage
from cortex_dsl.semantics.names.builtins import BUILTINS, Parameter
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import (
    PURE,
    UNITS,
    dimension_name,
    power,
    product,
    quotient,
    root,
    si_formula,
)
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.literals import SPOKEN_UNITS, UNIT_WORDS
from engine.vocabulary import Column
from tests.laws import examples

exponents = st.integers(-6, 6)
dimensions = st.builds(ir.Dimension, exponents, exponents, exponents, exponents)


def length_of_car(text: str) -> float:
    """The SI length that a car gets from an expression."""
    source = Source("test.scn", f"map intersection()\nego = new Car at (0, 0), with length {text}\n")
    scenario, _ = elaborate(parse(source), source)
    column = scenario.variants[0].actors[0].columns[Column.LENGTH]
    value = closed_value(column)
    assert value is not None
    return value


def test_every_unit_word_of_the_grammar_has_a_size() -> None:
    """The parser and the semantics know the same units."""
    assert set(UNITS) == set(UNIT_WORDS)


@given(dimensions, dimensions)
def test_product_and_quotient_undo_each_other(a: ir.Dimension, b: ir.Dimension) -> None:
    """(a b) / b is a."""
    assert quotient(product(a, b), b) == a


@given(dimensions)
def test_root_of_square(a: ir.Dimension) -> None:
    """The root of a square is what was squared."""
    assert root(power(a, 2)) == a


@given(dimensions)
def test_every_dimension_has_a_name(a: ir.Dimension) -> None:
    """Messages always find words."""
    assert dimension_name(a)
    assert si_formula(a)


@examples(15)
@given(st.floats(0.001, 90.0))
def test_conversion_is_one_multiplication(value: float) -> None:
    """SI = written value * factor, bit for bit, however the digits are written."""
    assert length_of_car(f"{value!r} ft") == value * UNITS["ft"].factor
    assert length_of_car(f"{value!r} m") == value


@pytest.mark.parametrize(
    ("text", "si"),
    [
        ("3 m + 50 cm", 3.5),
        ("1 + 2 m", 3.0),
        ("2 * 3", 6.0),
        ("10 m / 2", 5.0),
        ("(6 m / 2 m) * 1 m", 3.0),
        ("sqrt(4 m * 4 m)", 4.0),
        ("36 km/h * 0.5 s", 5.0),
        ("min(3 m, 400 cm)", 3.0),
        ("abs(-3 m)", 3.0),
        ("3 m if 1 < 2 else 4 m", 3.0),
    ],
)
def test_dimensions_go_through_every_operator(text: str, si: float) -> None:
    """Each of these is a length."""
    assert length_of_car(text) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["3 s", "3 m * 2 m", "3 m / 1 m", "2 m + 1 s", "max(1 m, 2 s)", "36 km/h", "90 deg", "hypot(3 s, 4 s)"]
)
def test_other_dimensions_are_refused(text: str, said: Callable[..., list[str]]) -> None:
    """None of these is a length."""
    codes = said(f"other = new Car at (0, 0), with length {text}\n")
    assert set(codes) & {"SCN301", "SCN302"}


def test_bare_numbers_adopt_what_is_around_them(said: Callable[..., list[str]]) -> None:
    """A number without unit takes the dimension of the other side, of its place, or is pure in a product."""
    text = "x = 3 m + 2\nrequire (distance from ego to intersection) - x < 7\n"
    assert said(text + "other = new Car at (1, 2), with speed 2 * 4, facing 0.5\n") == []


def test_what_people_write_leads_to_a_unit() -> None:
    """Every spoken form stands for a unit that exists, and is none itself."""
    assert set(SPOKEN_UNITS.values()) <= set(UNIT_WORDS)
    assert not set(SPOKEN_UNITS) & set(UNIT_WORDS)


@pytest.mark.parametrize(
    "parameter",
    sorted({p for row in BUILTINS.values() for p in row.parameters if p.dimension is not None}, key=str),
    ids=lambda parameter: parameter.name,
)
def test_cure_of_an_argument_is_a_legal_one(parameter: Parameter) -> None:
    """What the cure of a wrong dimension proposes has the dimension and lies in the legal range of the parameter."""
    assert parameter.dimension is not None
    number, unit = re.findall(rf"`{parameter.name}=([0-9.]+) ?([^`]*)`", usage(parameter))[0]
    factor = UNITS[unit].factor if unit else 1.0
    assert (UNITS[unit].dimension if unit else PURE) == parameter.dimension
    assert parameter.low <= float(number) * factor <= parameter.high
