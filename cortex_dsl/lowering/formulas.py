"""Temporal requirements to the rows that `engine.kernels.temporal` reads."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from cortex_dsl import ir

FormulaRow = tuple[int, int, int]


@dataclass
class FormulaWriter:
    """Writes formulas, operands above their operators; equal ones share a row."""

    rows: list[FormulaRow] = field(default_factory=list)
    numbers: dict[FormulaRow, int] = field(default_factory=dict)

    def row(self, formula: ir.Formula) -> int:
        """Number of the row that holds a formula."""
        operands = [self.row(operand) for operand in formula.operands] or [formula.watch]
        first, second = (*operands, -1)[:2]
        row = (int(formula.op), first, second)
        if row not in self.numbers:
            self.numbers[row] = len(self.rows)
            self.rows.append(row)
        return self.numbers[row]


def formula_rows(temporals: Sequence[ir.Temporal]) -> tuple[list[FormulaRow], list[int]]:
    """All rows, and the root of each temporal requirement."""
    writer = FormulaWriter()
    roots = [writer.row(temporal.formula) for temporal in temporals]
    return writer.rows, roots
