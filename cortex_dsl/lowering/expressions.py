"""Expressions to rows, for scene code and step code alike. Shared sub-expressions are computed once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.lowering.operands import (
    CodeBuffer,
    Constants,
    DrawRegister,
    GeneRegister,
    LocalRegister,
    Register,
    Temporary,
)
from cortex_dsl.semantics.quantities.algebra import changes, operands
from engine.vocabulary import Op


@dataclass
class Dynamics:
    """Tells expressions that change during a run from those that are settled with the scene."""

    known: dict[int, bool] = field(default_factory=dict)

    def is_dynamic(self, expression: ir.Expr) -> bool:
        key = id(expression)
        if key not in self.known:
            self.known[key] = self._decide(expression)
        return self.known[key]

    def _decide(self, expression: ir.Expr) -> bool:
        return changes(expression) or any(map(self.is_dynamic, operands(expression)))


@dataclass
class ExpressionWriter:
    """Writes expressions into a buffer. `known` maps the identity of an expression to its (first) register."""

    buffer: CodeBuffer
    constants: Constants
    hoist: Callable[[ir.Expr], Register | None] = lambda _: None
    """Where an expression already lies before this code runs (a scene value), or None."""
    known: dict[int, Register] = field(default_factory=dict)
    monitor_blocks: Sequence[int] = ()
    """Block of each monitor."""

    def branch(self) -> "ExpressionWriter":
        """A writer into the same buffer whose results the original will not rely on."""
        return replace(self, known=dict(self.known))

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
        sources = [self.register(item) for item in items]
        first = self.buffer.temporary(len(items))
        for position, source in enumerate(sources):
            self.buffer.emit(Op.MOVE, Temporary(first.index + position), source)
        return first

    def _apply(self, expression: ir.Apply) -> Register:
        registers = [self.register(argument) for argument in expression.arguments]
        destination = self.buffer.temporary(expression.width)
        self.buffer.emit(expression.op, destination, *expression.immediates, *registers)
        return destination
