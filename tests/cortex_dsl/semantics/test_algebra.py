"""Terms: formulas written with operators are the operations that they stand for, each made once."""

import ast
from pathlib import Path

import pytest

import cortex_dsl
from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.quantities import algebra as terms
from cortex_dsl.semantics.quantities.algebra import DEPTH_LIMIT, Algebra, equal, maximum, minimum, where
from engine.opcodes import Op

ROOMS = sorted((Path(cortex_dsl.__file__).parent / "semantics").rglob("*.py"))


@pytest.mark.parametrize("path", [each for each in ROOMS if each.name != "algebra.py"], ids=lambda path: path.stem)
def test_formulas_are_written_with_operators(path: Path) -> None:
    """No `algebra.apply(Op.ADD, a, b)` outside of the algebra."""
    calls = [node.func.attr for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
             if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
             and ast.unparse(node.func.value).rpartition(".")[2] == "algebra"]  # fmt: skip
    assert not {"apply", "add", "sub", "mul"} & set(calls)


@pytest.mark.parametrize(
    ("formula", "op", "operands"),
    [
        (lambda a, b: a + b, Op.ADD, "ab"),
        (lambda a, b: a - b, Op.SUB, "ab"),
        (lambda a, b: a * b, Op.MUL, "ab"),
        (lambda a, b: a / b, Op.DIV, "ab"),
        (lambda a, b: a // b, Op.FLOORDIV, "ab"),
        (lambda a, b: a % b, Op.MOD, "ab"),
        (lambda a, b: a**b, Op.POW, "ab"),
        (lambda a, b: a < b, Op.LT, "ab"),
        (lambda a, b: a <= b, Op.LE, "ab"),
        (lambda a, b: a > b, Op.LT, "ba"),
        (lambda a, b: a >= b, Op.LE, "ba"),
        (lambda a, b: a & b, Op.AND, "ab"),
        (lambda a, b: a | b, Op.OR, "ab"),
        (equal, Op.EQ, "ab"),
        (minimum, Op.MIN, "ab"),
        (maximum, Op.MAX, "ab"),
        (lambda a, b: where(a, b, a), Op.SELECT, "aba"),
        (lambda a, _: -a, Op.NEG, "a"),
        (lambda a, _: ~a, Op.NOT, "a"),
        (lambda a, _: abs(a), Op.ABS, "a"),
    ],
)
def test_an_operator_makes_its_operation(formula, op: Op, operands: str) -> None:
    """The operation and its operands in their order, the same object each time."""
    algebra = Algebra()
    known = {"a": algebra.draw(0), "b": algebra.draw(1)}
    made = formula(known["a"], known["b"])
    assert isinstance(made, ir.Apply)
    assert (made.op, made.arguments) == (op, tuple(known[name] for name in operands))
    assert formula(known["a"], known["b"]) is made


@pytest.mark.parametrize(
    ("formula", "operands"),
    [
        (lambda a: 2.0 + a, (2.0, "a")),
        (lambda a: 2.0 - a, (2.0, "a")),
        (lambda a: 2.0 * a, (2.0, "a")),
        (lambda a: 2.0 < a, (2.0, "a")),  # noqa: SIM300 - the order is what is tested
        (lambda a: a * 2.0, ("a", 2.0)),
        (lambda a: maximum(2.0, a), (2.0, "a")),
    ],
)
def test_a_number_beside_a_term_is_a_literal(formula, operands: tuple[object, ...]) -> None:
    """On the side on which it is written: `2 - a` is not `a - 2`."""
    algebra = Algebra()
    a = algebra.draw(0)
    made = formula(a)
    assert isinstance(made, ir.Apply)
    assert made.arguments == tuple(a if each == "a" else algebra.literal(2.0) for each in operands)


def test_constants_fold_where_no_bit_changes() -> None:
    """Sums and comparisons do; a sine stays, since a copy of a case must compute what the original did."""
    algebra = Algebra()
    half = algebra.literal(0.5)
    assert half + half is algebra.literal(1.0)
    assert (half < 1.0) is algebra.truth(True)
    assert isinstance(terms.sin(half), ir.Apply)


def test_nobody_asks_a_term_whether_it_is_true() -> None:
    """`a and b` would silently be b."""
    with pytest.raises(TypeError, match="the run decides"):
        bool(Algebra().draw(0) < 0.5)


def test_chains_have_a_limit() -> None:
    """Later passes walk expressions recursively."""
    algebra = Algebra()
    term, one = algebra.draw(0), algebra.draw(1)
    for _ in range(DEPTH_LIMIT):
        term = term + one
    with pytest.raises(Mistake):
        _ = term + one
