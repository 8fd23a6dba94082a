"""`do choose` and `do shuffle`: one draw of the behaviour stream decides among the permitted options.

The shares of the options are adjacent on a line: each has its weight as length, or 0 if it is not permitted. A uniform
number times the line's length falls on one of them. If the line has length 0, no option is left: the run aborts.
"""

from collections.abc import Callable, Sequence

from cortex_dsl import ir
from cortex_dsl.lowering.instructions import CodeBuffer, ExpressionWriter, LocalRegister, Register, Target
from engine.frozen import frozen
from engine.opcodes import Op


@frozen
class Picker:
    """Writes one `Pick`; `write` writes the body of an option."""

    buffer: CodeBuffer
    expressions: ExpressionWriter
    write: Callable[[ir.Block], None]

    def choose(self, act: ir.Pick) -> None:
        """One option."""
        end = Target()
        for option, start in zip(act.options, self._draw(act, ()), strict=True):
            self.buffer.place(start)
            self.write(option.body)
            self.buffer.emit(Op.JUMP, None, end)
        self.buffer.place(end)

    def shuffle(self, act: ir.Pick, left: Sequence[LocalRegister]) -> None:
        """Write all options, one after another. `left` stores, in a local each, which options remain."""
        top, end = Target(), Target()
        for flag in left:
            self.buffer.emit(Op.MOVE, flag, self.expressions.constants.add(1.0))
        self.buffer.place(top)
        self.buffer.emit(Op.JUMP_UNLESS, None, self._any(left), end)
        for option, flag, start in zip(act.options, left, self._draw(act, left), strict=True):
            self.buffer.place(start)
            self.buffer.emit(Op.MOVE, flag, self.expressions.constants.add(0.0))
            self.write(option.body)
            self.buffer.emit(Op.JUMP, None, top)
        self.buffer.place(end)

    def _draw(self, act: ir.Pick, left: Sequence[Register]) -> list[Target]:
        """Write code that continues at the target of one option; the caller places the targets."""
        ends = self._shares(act.options, left)
        nothing, starts = Target(), [Target() for _ in ends]
        zero, drawn = self.expressions.constants.add(0.0), self.buffer.temporary()
        self.buffer.emit(Op.JUMP_UNLESS, None, self._new(Op.LT, zero, ends[-1]), nothing)
        self.buffer.emit(Op.RANDOM, drawn)
        self.buffer.emit(Op.MUL, drawn, drawn, ends[-1])
        for end, start in zip(ends, starts, strict=True):
            following = Target()
            self.buffer.emit(Op.JUMP_UNLESS, None, self._new(Op.LT, drawn, end), following)
            self.buffer.emit(Op.JUMP, None, start)
            self.buffer.place(following)
        self.buffer.place(nothing)
        self.buffer.emit(Op.TERMINATE, None, act.rule)
        return starts

    def _shares(self, options: Sequence[ir.Option], left: Sequence[Register]) -> list[Register]:
        """Return the cumulative end of each option's share."""
        writer, ends = self.expressions.branch(), []
        zero = self.expressions.constants.add(0.0)
        end: Register = zero
        for number, option in enumerate(options):
            allowed, weight = writer.register(option.allowed), writer.register(option.weight)
            if left:
                allowed = self._new(Op.AND, allowed, left[number])
            end = self._new(Op.ADD, end, self._new(Op.SELECT, allowed, weight, zero))
            ends.append(end)
        return ends

    def _any(self, flags: Sequence[Register]) -> Register:
        result = flags[0]
        for flag in flags[1:]:
            result = self._new(Op.OR, result, flag)
        return result

    def _new(self, op: Op, *operands: Register) -> Register:
        destination = self.buffer.temporary()
        self.buffer.emit(op, destination, *operands)
        return destination
