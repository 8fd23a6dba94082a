"""Numbers that an instruction gives: analyses of code read the same count as the expressions that it is made from."""

from pathlib import Path

import pytest

from cortex_dsl import ir, load
from cortex_dsl.lowering.instructions import ExpressionWriter, Register
from engine.opcodes import Op
from engine.operators import signature

FILES = sorted((Path(__file__).parents[2] / "agreement").glob("*.scn"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_expression_is_as_wide_as_the_results_of_its_instruction(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In every construct of the language, library drivers included."""
    found, write = set[tuple[Op, int]](), ExpressionWriter._apply

    def noted(self: ExpressionWriter, expression: ir.Apply) -> Register:
        found.add((expression.op, expression.width))
        return write(self, expression)

    monkeypatch.setattr(ExpressionWriter, "_apply", noted)
    load(file)
    assert found
    assert [(op.name, width, signature(op).results) for op, width in found if signature(op).results != width] == []
