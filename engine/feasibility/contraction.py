"""Forward evaluation and backward contraction of a tape over many boxes at once.

A *box* is an interval for each variable of one variant. A box dies when a requirement surely fails in it; `killer` says
which one. A slot is *demanded* in a box where every attempt that may still pass has a number in its interval there:
only such a slot may tell its operands something, and only such a one, found empty, kills.
"""

from collections.abc import Sequence

import numpy as np

from engine.feasibility.arithmetic import Bools, Interval, surely_false
from engine.feasibility.bounds import GEOMETRY
from engine.feasibility.forward import FORWARD, TRUTHS, table
from engine.feasibility.inverses import Ends, narrowed
from engine.feasibility.tape import Instruction, Tape
from engine.frozen import frozen
from engine.program import Program
from engine.tables import Floats, Ints
from engine.vocabulary import Op

ALIVE = -1


@frozen
class Boxes:
    """What is known of every slot in n boxes; the arrays are worked on in place."""

    program: Program
    tape: Tape
    low: Floats
    """(slots, n)"""
    high: Floats
    undefined: Bools
    demanded: Bools
    killer: Ints
    """(n,): the requirement that surely fails, `ALIVE` where none is known to."""

    @property
    def alive(self) -> Bools:
        return self.killer == ALIVE

    def __getitem__(self, slot: int) -> Interval:
        return Interval(self.low[slot], self.high[slot], self.undefined[slot])

    def forward(self, instructions: Sequence[Instruction], requirement: int) -> None:
        """Evaluate; what was known before is kept. A contradiction is put down to the requirement."""
        for instruction in instructions:
            operands = [self[slot] for slot in instruction.operands]
            for n, result in enumerate(self._results(instruction, operands)):
                slot = instruction.first + n
                self.undefined[slot] = result.undefined
                self._intersect(slot, (result.low, result.high), np.ones_like(self.demanded[slot]), requirement)

    def _results(self, instruction: Instruction, operands: Sequence[Interval]) -> Sequence[Interval]:
        if instruction.op in GEOMETRY:
            return GEOMETRY[instruction.op](self.program.road, operands)
        if instruction.op == Op.TABLE:
            return [table(self.program.code.pool, instruction.number, operands[0])]
        return [FORWARD[instruction.op](*operands)]

    def demand(self, requirement: int) -> None:
        """The requirement holds: its result is neither zero nor NaN."""
        root = self.tape.roots[requirement]
        maker = self.tape.maker.get(root)
        if maker is not None and maker.op in TRUTHS:
            self.demanded[root] = True
            one = np.ones(len(self.killer))
            self._intersect(root, (one, one), self.demanded[root], requirement)
        else:
            self.kill(surely_false(self[root]), requirement)

    def backward(self, instructions: Sequence[Instruction], requirement: int) -> None:
        """Narrow what the demanded slots were made of."""
        for instruction in reversed(instructions):
            demanded = self.demanded[instruction.first]
            if instruction.results > 1 or instruction.op in GEOMETRY or not demanded.any():
                continue
            operands = [self[slot] for slot in instruction.operands]
            makers = [maker.op if (maker := self.tape.maker.get(slot)) else None for slot in instruction.operands]
            answers = narrowed(instruction.op, self[instruction.first], operands, makers)
            for slot, ends in zip(instruction.operands, answers, strict=True):
                if ends is not None and slot != self.tape.unknown:
                    told = demanded & (np.isfinite(ends[0]) | np.isfinite(ends[1]))
                    self.demanded[slot] |= told
                    self._intersect(slot, ends, told, requirement)

    def _intersect(self, slot: int, ends: Ends, where: Bools, requirement: int) -> None:
        """Narrow a slot in some boxes; where it is demanded, nothing left is the end of the box."""
        low, high = np.maximum(self.low[slot], ends[0]), np.minimum(self.high[slot], ends[1])
        empty = low > high
        self.kill(empty & where & self.demanded[slot], requirement)
        taken = where & ~empty
        np.copyto(self.low[slot], low, where=taken)
        np.copyto(self.high[slot], high, where=taken)

    def kill(self, where: Bools, requirement: int) -> None:
        self.killer[where & self.alive] = requirement


def empty_boxes(program: Program, tape: Tape, count: int) -> Boxes:
    """Boxes of which nothing is known."""
    shape = tape.slots, count
    return Boxes(
        program,
        tape,
        np.full(shape, -np.inf),
        np.full(shape, np.inf),
        np.ones(shape, dtype=bool),
        np.zeros(shape, dtype=bool),
        np.full(count, ALIVE, dtype=np.int32),
    )
