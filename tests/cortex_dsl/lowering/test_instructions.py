"""Writers of expressions: what a branch writes is its own, and what was written before is shared, not copied."""

from cortex_dsl import ir
from cortex_dsl.lowering.instructions import CodeBuffer, Constants, ExpressionWriter
from cortex_dsl.source import Span
from engine.opcodes import Op

HERE = Span(0, 1)


def _negated(expression: ir.Expr) -> ir.Expr:
    return ir.Apply(HERE, Op.NEG, (expression,))


def test_a_branch_goes_on_from_what_was_written_and_keeps_its_own() -> None:
    """The same expression is written again by the original, and by a branch only where nobody before it did."""
    buffer = CodeBuffer()
    writer = ExpressionWriter(buffer, Constants())
    first = _negated(ir.Gene(HERE, 0))
    second = _negated(first)
    place = writer.register(first)
    branch = writer.branch()
    assert branch.register(first) == place
    own = branch.register(second)
    assert branch.branch().register(second) == own
    assert len(buffer.rows) == 2
    assert writer.register(second) != own
    assert len(buffer.rows) == 3


def test_a_branch_copies_nothing() -> None:
    """A file has as many branches as requirements: copies would make its time grow with their square."""
    writer = ExpressionWriter(CodeBuffer(), Constants())
    kept = [_negated(ir.Gene(HERE, number)) for number in range(100)]
    before = [writer.register(each) for each in kept]
    branch = writer.branch()
    late = _negated(ir.Gene(HERE, 0))
    there = writer.register(late)
    assert [branch.register(each) for each in (*kept, late)] == [*before, there]
