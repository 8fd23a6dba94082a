"""The IR in words: each expression and act as it stands in the listing of `--emit ir`."""

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.printing import Printer, expressions_of
from cortex_dsl.semantics.quantities.algebra import Algebra, minimum, table
from cortex_dsl.source import Span
from engine.vocabulary import Command, State

HERE = Span(0, 0)
ALGEBRA = Algebra()
A, B = ALGEBRA.draw(0), ALGEBRA.gene(1)
ONE = ALGEBRA.literal(1.0)
WAIT = (ir.Wait(HERE),)


def printed(*roots: ir.Expr) -> tuple[list[str], list[str]]:
    """The texts of expressions, and the names defined for what several of them use."""
    printer = Printer.of(roots)
    return [printer.text(root) for root in roots], [line.strip() for line in printer.definitions()]


@pytest.mark.parametrize(
    ("term", "text"),
    [
        (ONE, "1.0"),
        (A, "draw0"),
        (B, "gene1"),
        (ALGEBRA.local(3), "local3"),
        (ALGEBRA.running(2), "running(2)"),
        (A + B, "(draw0 + gene1)"),
        (A - B * ONE, "(draw0 - (gene1 * 1.0))"),
        (A**B, "(draw0 ** gene1)"),
        (A % B, "(draw0 % gene1)"),
        ((A < B) & (B <= A), "((draw0 < gene1) and (gene1 <= draw0))"),
        (~(A < B), "not((draw0 < gene1))"),
        (minimum(A, B), "min(draw0, gene1)"),
        (ALGEBRA.state(1, State.SPEED), "actor1.speed"),
        (table(A, 4), "table(4, draw0)"),
        (ALGEBRA.time_to_contact(0, 2), "ttc(0, 2)"),
        (ALGEBRA.pack(A, B), "(draw0, gene1)"),
        (ALGEBRA.items(ALGEBRA.pack(A, B), 2)[1], "(draw0, gene1).1"),
    ],
)
def test_an_expression_in_words(term: ir.Expr, text: str) -> None:
    """Operators between their operands, functions before them, numbers of the operation first."""
    assert printed(term) == ([text], [])


def test_what_is_used_twice_has_a_name() -> None:
    """Written once, before what uses it; a number or a gene is as short as a name and has none."""
    total = A + B
    texts, names = printed(total * A, total - A)
    assert texts == ["(e0 * draw0)", "(e0 - draw0)"]
    assert names == ["e0 = (draw0 + gene1)"]


@pytest.mark.parametrize(
    ("act", "lines"),
    [
        (ir.SetLocal(HERE, 2, A), ["local2 <- draw0"]),
        (ir.Take(HERE, ((Command.THROTTLE, A), (Command.BRAKE, ONE))), ["take throttle draw0, brake 1.0"]),
        (ir.Follow(HERE, ONE, A, B, 5), ["follow path 1.0 at draw0, lateral gene1, progress local5"]),
        (ir.HoldSpeed(HERE, A), ["hold speed draw0"]),
        (ir.Replay(HERE, 7, A, 3), ["replay track 7 at pace draw0, clock local3"]),
        (ir.Branch(HERE, A, WAIT, ()), ["if draw0", "  wait", "else", "  (nothing)"]),
        (ir.Loop(HERE, A, WAIT), ["while draw0", "  wait"]),
        (ir.Scope(HERE, "B", 4, WAIT, ((A, 7),)), ["scope 4 B", "  invariant draw0, else rule 7", "  wait"]),
        (ir.Demand(HERE, A, 3), ["demand draw0, else rule 3"]),
        (ir.Start(HERE, 1), ["start monitor 1"]),
        (ir.Advance(HERE, 1), ["advance monitor 1"]),
        (ir.Stop(HERE, (1, 2), (3,)), ["stop monitor 1, monitor 2, actor 3"]),
        (ir.Spawn(HERE, (1, 2)), ["spawn actor 1, actor 2"]),
        (ir.TryInterrupt(HERE, WAIT, ((A, WAIT),)), ["try", "  wait", "interrupt when draw0", "  wait"]),
        (ir.Leave(HERE, "break", 2), ["break (scope 2)"]),
        (ir.Terminate(HERE, 6), ["terminate by rule 6"]),
        (ir.Abort(HERE), ["abort"]),
        (
            ir.Pick(HERE, (ir.Option(ONE, A, WAIT),), False, 8),
            ["choose, else rule 8", "  option 1.0 if draw0", "    wait"],
        ),
        (ir.Pick(HERE, (), True, 8), ["shuffle, else rule 8"]),
    ],
)
def test_an_act_in_words(act: ir.Act, lines: list[str]) -> None:
    """One line, and those of the blocks inside indented below it."""
    assert list(Printer.of(expressions_of(act)).block((act,))) == lines


def test_every_expression_of_an_act_is_found() -> None:
    """Nested ones too, for what is used twice is counted over all."""
    act = ir.TryInterrupt(HERE, (ir.SetLocal(HERE, 0, A),), ((B, (ir.Demand(HERE, ONE, 0),)),))
    assert list(expressions_of(act)) == [A, B, ONE]
