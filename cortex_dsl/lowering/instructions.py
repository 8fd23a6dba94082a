"""Symbolic code: rows with registers that have no numbers yet, and expressions as such rows.

Scene code and step code are written in the same way. Shared sub-expressions are computed once.
"""

from collections import ChainMap
from collections.abc import Callable, Container, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.bounds import changes, operands
from engine.frozen import frozen
from engine.opcodes import INSTRUCTIONS, Op
from engine.tables import SHADE

# -- operands and rows: code before registers have numbers -------------------------------------------------------------
#
# Variants of one scenario usually run the same code on other constants (another lane, another path). So code is first
# written with symbolic operands in which every constant has a running number instead of a value; variants whose rows
# are then equal share one *template*, and only their constants are kept apart.


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
    """One instruction: op, destination, up to four operands. A plain int is a literal operand."""

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
            Row(row.op, row.destination, tuple(Jump(o.row) if isinstance(o, Target) else o for o in row.operands))
            if Target in map(type, row.operands)
            else row
            for row in self.rows
        )


FEW = 6
"""Rows that are cheaper to execute than to skip."""
READINGS = frozenset({Op.STATE, Op.TIME, Op.ACTION, Op.IS_RUNNING, Op.TABLE})
"""Instructions that cost no more than a scalar one."""
SEARCH = 20
"""Cost of any other instruction that is not scalar, in rows."""

# -- Expressions -------------------------------------------------------------------------------------------------------


@dataclass
class Dynamics:
    """Distinguishes expressions that change during a run from those that are settled with the scene."""

    known: dict[int, bool] = field(default_factory=dict)

    def is_dynamic(self, expression: ir.Expr) -> bool:
        key = id(expression)
        if key not in self.known:
            self.known[key] = self._decide(expression)
        return self.known[key]

    def _decide(self, expression: ir.Expr) -> bool:
        return changes(expression) or any(map(self.is_dynamic, operands(expression)))


@dataclass
class Skipping:
    """Decides whether code jumps over an operand that does not matter."""

    is_settled: Callable[[ir.Expr], bool]
    """Function that tells whether code reads an expression without computing it."""
    draws: dict[int, bool] = field(default_factory=dict)
    """Whether an expression draws a random number, by identity."""

    def is_worthwhile(self, expression: ir.Expr, known: Container[int]) -> bool:
        """Return True if an expression takes `FEW` rows or more that are not known yet, and draws no random number."""
        cost, waiting, seen = 0, [expression], set[int]()
        while waiting and cost < FEW:
            part = waiting.pop()
            if isinstance(part, ir.Literal) or id(part) in seen or id(part) in known or self.is_settled(part):
                continue
            seen.add(id(part))
            if isinstance(part, ir.Apply):
                cost += 1 if part.op in READINGS or part.op not in INSTRUCTIONS else SEARCH
            waiting += operands(part)
        return cost >= FEW and not self._draws(expression)

    def _draws(self, expression: ir.Expr) -> bool:
        key = id(expression)
        if key not in self.draws:
            is_draw = isinstance(expression, ir.Apply) and expression.op == Op.RANDOM
            self.draws[key] = is_draw or any(map(self._draws, operands(expression)))
        return self.draws[key]


@dataclass
class ExpressionWriter:
    """Writes expressions into a buffer. `known` maps the identity of an expression to its (first) register."""

    buffer: CodeBuffer
    constants: Constants
    hoist: Callable[[ir.Expr], Register | None] = lambda _: None
    """Function that returns the register of an expression computed before this code runs (a scene value), or None."""
    known: MutableMapping[int, Register] = field(default_factory=dict)
    monitor_blocks: Sequence[int] = ()
    """Block of each monitor."""
    shades: tuple[ir.Expr, ...] = ()
    """Outlines that hide at the start, as `Op.CAN_SEE` reads them."""
    skipping: "Skipping | None" = None
    """Rule for operands that code may jump over; None for segments, which are evaluated as a whole."""
    before: Mapping[int, int] = field(default_factory=dict)
    """How many of the first actors alone hide, by the identity of a look on which the next actor depends."""

    def branch(self) -> "ExpressionWriter":
        """Return a writer into the same buffer; the original neither uses its results nor writes meanwhile."""
        return replace(self, known=ChainMap({}, self.known))

    def register(self, expression: ir.Expr) -> Register:
        """The register that holds the expression, after writing whatever computes it."""
        if isinstance(expression, ir.Literal):
            return self.constants.add(expression.value)
        key = id(expression)
        if key not in self.known:
            hoisted = self.hoist(expression)
            self.known[key] = self._write(expression) if hoisted is None else hoisted
        return self.known[key]

    def into(self, destination: Register, expression: ir.Expr) -> None:
        """Write code that leaves the expression in `destination`."""
        self.buffer.emit(Op.MOVE, destination, self.register(expression))

    def _write(self, expression: ir.Expr) -> Register:
        match expression:
            case ir.Gene(index=index):
                return GeneRegister(index)
            case ir.Draw(index=index):
                return DrawRegister(index)
            case ir.Local(index=index):
                return LocalRegister(index)
            case ir.Running(monitor=monitor):
                return self._running(monitor)
            case ir.Item(bundle=bundle, index=index):
                return self._item(bundle, index)
            case ir.Pack(items=items):
                return self._pack(items)
            case ir.Apply():
                return self._apply(expression)
        raise AssertionError(f"no code for {type(expression).__name__}")

    def _running(self, monitor: int) -> Register:
        destination = self.buffer.temporary()
        self.buffer.emit(Op.IS_RUNNING, destination, self.monitor_blocks[monitor])
        return destination

    def _item(self, bundle: ir.Expr, index: int) -> Register:
        if isinstance(bundle, ir.Pack):
            return self.register(bundle.items[index])
        first = self.register(bundle)
        assert isinstance(first, Temporary), "wide results live in temporaries"
        return Temporary(first.index + index)

    def _pack(self, items: tuple[ir.Expr, ...]) -> Register:
        return self._side_by_side([self.register(item) for item in items])

    def _side_by_side(self, sources: Sequence[Register]) -> Register:
        first = self.buffer.temporary(len(sources))
        for position, source in enumerate(sources):
            self.buffer.emit(Op.MOVE, Temporary(first.index + position), source)
        return first

    def _shades(self, look: ir.Expr) -> Register:
        """Return the number of hiding outlines and the outlines, written once for all looks that share them."""
        number = self.before.get(id(look), len(self.shades) // SHADE)
        if (key := -1 - number) not in self.known:  # no identity is below 0
            sources = [self.constants.add(float(number)), *map(self.register, self.shades[: number * SHADE])]
            self.known[key] = self._side_by_side(sources)
        return self.known[key]

    def _apply(self, expression: ir.Apply) -> Register:
        if self.skipping is not None and (chosen := self._skip(expression, self.skipping)) is not None:
            return chosen
        registers, immediates = [self.register(argument) for argument in expression.arguments], expression.immediates
        if expression.op == Op.CAN_SEE:
            registers, immediates = [*registers, self._shades(expression)], ()
        destination = self.buffer.temporary(expression.width)
        self.buffer.emit(expression.op, destination, *immediates, *registers)
        return destination

    def _skip(self, expression: ir.Apply, skipping: "Skipping") -> Register | None:
        """Write an `and` or a choice whose second operand is costly: it is skipped if the first is false.

        The result is that of the operation on all operands, as a skipped operand has no effect of its own. Returns None
        for other expressions. Registers that are written in the skipped code are not known after it.
        """
        match expression:
            case ir.Apply(op=Op.AND, arguments=(condition, costly)):
                otherwise = condition
            case ir.Apply(op=Op.SELECT, arguments=(condition, costly, otherwise)):
                pass
            case _:
                return None
        if not skipping.is_worthwhile(costly, self.known):
            return None
        test, result, end = self.register(condition), self.register(otherwise), Target()
        destination = self.buffer.temporary()
        self.buffer.emit(Op.MOVE, destination, result)
        self.buffer.emit(Op.JUMP_IF_FALSE, None, test, end)
        within = self.branch()
        self.buffer.emit(expression.op, destination, *map(within.register, expression.arguments))
        self.buffer.place(end)
        return destination
