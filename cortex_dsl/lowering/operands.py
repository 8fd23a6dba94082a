"""Symbolic operands and rows: code before registers have numbers.

Variants of one scenario usually run the same code on other constants (another lane, another path). So code is first
written with symbolic operands in which every constant has a running number instead of a value; variants whose rows
are then equal share one *template*, and only their constants are kept apart.
"""

from dataclasses import dataclass, field, replace

from engine.frozen import frozen
from engine.vocabulary import Op


@frozen
class Constant:
    """Occurrence number of a constant within one variant's code."""

    number: int


@frozen
class GeneRegister:
    index: int


@frozen
class DrawRegister:
    index: int


@frozen
class SceneValue:
    """A scene value, readable in step code."""

    index: int


@frozen
class LocalRegister:
    index: int


@frozen
class Temporary:
    index: int


Register = Constant | GeneRegister | DrawRegister | SceneValue | LocalRegister | Temporary


@dataclass
class Target:
    """A place in the code that jumps may name before it is known."""

    row: int = -1


@frozen
class Jump:
    """A row of the same variant's code."""

    row: int


Operand = Register | int | Target | Jump


@frozen
class Row:
    """One instruction: op, destination, up to four operands. A plain int stands for itself."""

    op: Op
    destination: Register | None
    operands: tuple[Operand, ...]


@dataclass
class Constants:
    """Values of all constant occurrences of one variant, in the order of the code."""

    values: list[float] = field(default_factory=list)

    def add(self, value: float) -> Constant:
        self.values.append(value)
        return Constant(len(self.values) - 1)


@dataclass
class CodeBuffer:
    """Rows under construction, with the source offset each one came from."""

    rows: list[Row] = field(default_factory=list)
    offsets: list[int] = field(default_factory=list)
    temporaries: int = 0
    offset: int = 0
    """Source offset given to the rows that follow."""

    def emit(self, op: Op, destination: Register | None = None, *operands: Operand) -> None:
        self.rows.append(Row(op, destination, operands))
        self.offsets.append(self.offset)

    def temporary(self, width: int = 1) -> Temporary:
        """The first of `width` fresh consecutive temporaries."""
        first = Temporary(self.temporaries)
        self.temporaries += width
        return first

    def place(self, target: Target) -> None:
        """Let jumps to `target` lead here."""
        target.row = len(self.rows)

    def resolved(self) -> tuple[Row, ...]:
        """All rows, with jump targets replaced by the rows they have got."""
        return tuple(
            replace(row, operands=tuple(Jump(o.row) if isinstance(o, Target) else o for o in row.operands))
            for row in self.rows
        )
