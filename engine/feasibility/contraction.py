"""Forward evaluation and backward contraction of a tape over many boxes at once.

A *box* is an interval for each variable of one variant. A box dies when a requirement surely fails in it; `killer` is
that requirement. A slot is *demanded* in a box if every attempt that may still pass has a number in the slot's
interval: only a demanded slot may narrow its operands, and only an empty demanded slot kills the box.

The results that are demanded are numbers in every attempt that may still pass: the demands start at comparisons that
hold, and no comparison with NaN does.
"""

from collections.abc import Sequence

import numpy as np

from engine.feasibility.bounds import GEOMETRY
from engine.feasibility.tape import Instruction, Tape
from engine.frozen import frozen
from engine.opcodes import Op
from engine.operators import OPERATORS
from engine.operators.intervals import Bools, Interval, made, surely_false
from engine.operators.narrowing import Ends
from engine.program import Program
from engine.tables import Floats, Ints

TRUTHS = frozenset(
    {op for op, row in OPERATORS.items() if row.is_truth} | {Op.REGION_CONTAINS, Op.REGION_CONTAINS_BOX, Op.CAN_SEE}
)
"""Instructions with the result 1, 0 or NaN."""

# -- boxes -------------------------------------------------------------------------------------------------------------

ALIVE = -1


@frozen
class Boxes:
    """Known bounds of every slot in n boxes; the arrays are modified in place."""

    program: Program
    tape: Tape
    low: Floats
    """(slots, n)"""
    high: Floats
    undefined: Bools
    demanded: Bools
    killer: Ints
    """(n,) Requirement that surely fails; `ALIVE` if none is known."""

    @property
    def alive(self) -> Bools:
        return self.killer == ALIVE

    def __getitem__(self, slot: int) -> Interval:
        return Interval(self.low[slot], self.high[slot], self.undefined[slot])

    def forward(self, instructions: Sequence[Instruction], requirement: int) -> None:
        """Evaluate the instructions within known bounds; a contradiction is attributed to the requirement."""
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
            return [_table(self.program.code.pool, instruction.number, operands[0])]
        return [OPERATORS[instruction.op].forward(*operands)]

    def demand(self, requirement: int) -> None:
        """Demand that the requirement holds: its result is not zero.

        Nothing follows where it may be NaN, which ends an attempt as an error that must not be skipped.
        """
        root = self.tape.roots[requirement]
        if self._is_truth(root):
            self.demanded[root] = ~self.undefined[root]
            one = np.ones(len(self.killer))
            self._intersect(root, (one, one), self.demanded[root], requirement)
        else:
            self.kill(surely_false(self[root]), requirement)

    def backward(self, instructions: Sequence[Instruction], requirement: int) -> None:
        """Narrow the operands of the demanded slots."""
        for instruction in reversed(instructions):
            demanded = self.demanded[instruction.first]
            if instruction.op not in OPERATORS or not demanded.any():
                continue
            operands = [self[slot] for slot in instruction.operands]
            truths = [self._is_truth(slot) for slot in instruction.operands]
            answers = OPERATORS[instruction.op].narrowed(self[instruction.first], operands, truths)
            for slot, ends in zip(instruction.operands, answers, strict=True):
                if ends is not None and slot != self.tape.unknown:
                    bounded = demanded & (np.isfinite(ends[0]) | np.isfinite(ends[1]))
                    self.demanded[slot] |= bounded
                    self._intersect(slot, ends, bounded, requirement)

    def _is_truth(self, slot: int) -> bool:
        maker = self.tape.maker.get(slot)
        return maker is not None and maker.op in TRUTHS

    def _intersect(self, slot: int, ends: Ends, where: Bools, requirement: int) -> None:
        """Narrow a slot in some boxes; a box in which a demanded slot becomes empty dies."""
        low, high = np.maximum(self.low[slot], ends[0]), np.minimum(self.high[slot], ends[1])
        empty = low > high
        self.kill(empty & where & self.demanded[slot], requirement)
        taken = where & ~empty
        np.copyto(self.low[slot], low, where=taken)
        np.copyto(self.high[slot], high, where=taken)

    def kill(self, where: Bools, requirement: int) -> None:
        self.killer[where & self.alive] = requirement


def empty_boxes(program: Program, tape: Tape, count: int) -> Boxes:
    """Return boxes without any known bound."""
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


def _table(pool: Floats, first: int, index: Interval) -> Interval:
    """Return the least and greatest of the options that the index of `Op.TABLE` may name, clipped to the pool."""
    last = len(pool) - 1
    start = np.clip(np.nan_to_num(first + np.floor(index.low)), 0, last).astype(np.int64)
    end = np.clip(np.nan_to_num(first + np.floor(index.high)), 0, last).astype(np.int64)
    low, high = np.full(len(start), np.inf), np.full(len(start), -np.inf)
    for option in range(int(start.min(initial=last)), int(end.max(initial=0)) + 1):
        may = (start <= option) & (option <= end)
        low, high = (
            np.where(may, np.minimum(low, pool[option]), low),
            np.where(may, np.maximum(high, pool[option]), high),
        )
    low, high = np.where(index.undefined, pool.min(), low), np.where(index.undefined, pool.max(), high)
    return made(low, high, np.zeros(len(start), dtype=bool))
