"""Forward evaluation and backward contraction of a tape over many boxes at once.

A *box* is an interval for each variable of one variant. A box dies when a requirement surely fails in it; `killer` is
that requirement. A slot is *demanded* in a box if every attempt that may still pass has a number in the slot's
interval: only a demanded slot may narrow its operands, and only an empty demanded slot kills the box.

Each function of `BACKWARD` takes the interval of a result and those of its operands, and returns narrower ends for each
operand. It is called only for results that are numbers in every attempt that may still pass: demands start at
comparisons that hold, and no comparison with NaN holds. Source: Benhamou, Goualard, Granvilliers and Puget (1999),
"Revising hull and box consistency", ICLP'99 (HC4).
"""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from engine.feasibility.arithmetic import RELATIVE, Bools, Interval, surely_false, surely_true
from engine.feasibility.bounds import GEOMETRY
from engine.feasibility.forward import FORWARD, TRUTHS, table
from engine.feasibility.tape import Instruction, Tape
from engine.frozen import frozen
from engine.opcodes import Op
from engine.portable import exp, log
from engine.program import Program
from engine.tables import Floats, Ints

# -- bounds of operands from a result ----------------------------------------------------------------------------------

TINY, HUGE = 1e-300, 1e300
"""Range of magnitudes with full precision."""
Ends = tuple[Floats, Floats]
"""Least and greatest value, to be intersected with the known interval; arrays (n,)."""
Backward = Callable[..., Sequence[Ends | None]]
"""Backward function; its result is None for an operand without a bound."""


def _outward(low: Floats, high: Floats, *scale: Interval) -> Ends:
    """Return the ends moved outward by more than the rounding errors of the instruction and of this code."""
    size = sum((_size(interval) for interval in scale), start=np.zeros(len(low)))
    low, high = low - RELATIVE * size, high + RELATIVE * size
    return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)


def _size(a: Interval) -> Floats:
    size = np.maximum(np.abs(a.low), np.abs(a.high))
    return np.where(np.isfinite(size), size, 0.0)


def _only(condition: np.ndarray, ends: Ends) -> Ends:
    return np.where(condition, ends[0], -np.inf), np.where(condition, ends[1], np.inf)


def _add(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return (
        _outward(z.low - b.high, z.high - b.low, z, b),
        _outward(z.low - a.high, z.high - a.low, z, a),
    )


def _sub(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return (
        _outward(z.low + b.low, z.high + b.high, z, b),
        _outward(a.low - z.high, a.high - z.low, z, a),
    )


def _factor(z: Interval, b: Interval) -> Ends:
    """Return bounds of the factor a of a * b = z."""
    quotients = np.stack([z.low / b.low, z.low / b.high, z.high / b.low, z.high / b.high])
    low, high = quotients.min(axis=0), quotients.max(axis=0)
    known = ((b.low > 0.0) | (b.high < 0.0)) & np.isfinite(low) & np.isfinite(high)
    margin = RELATIVE * np.maximum(np.abs(low), np.abs(high)) + 1e-300
    # A product may round to zero or below the smallest number, so such a small factor cannot be distinguished from
    # zero.
    tiny = np.maximum(np.abs(z.low), np.abs(z.high)) < 1e-200
    return _only(known & ~tiny, (low - margin, high + margin))


def _mul(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return _factor(z, b), _factor(z, a)


def _div(z: Interval, _a: Interval, b: Interval) -> Sequence[Ends | None]:
    products = np.stack([z.low * b.low, z.low * b.high, z.high * b.low, z.high * b.high])
    low, high = products.min(axis=0), products.max(axis=0)
    known = np.isfinite(low) & np.isfinite(high) & (np.maximum(np.abs(z.low), np.abs(z.high)) > 1e-200)
    margin = RELATIVE * np.maximum(np.abs(low), np.abs(high)) + 1e-300
    return _only(known, (low - margin, high + margin)), None


def _neg(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((-z.high, -z.low),)


def _abs(z: Interval, a: Interval) -> Sequence[Ends]:
    low = np.where(a.low > -z.low, np.maximum(z.low, -z.high), -z.high)
    high = np.where(a.high < z.low, np.minimum(-z.low, z.high), z.high)
    return ((low, high),)


def _min(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    """Return the bounds for `b if b < a else a`; none for a b that may be NaN."""
    unbounded = np.full(len(z.low), np.inf)
    defined = ~b.undefined
    a_high = np.where(b.low > z.high, z.high, unbounded)
    b_high = np.where((a.low > z.high) & defined, z.high, unbounded)
    return (z.low, a_high), (np.where(defined, z.low, -unbounded), b_high)


def _max(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    unbounded = np.full(len(z.low), np.inf)
    defined = ~b.undefined
    a_low = np.where(b.high < z.low, z.low, -unbounded)
    b_low = np.where((a.high < z.low) & defined, z.low, -unbounded)
    return (a_low, z.high), (b_low, np.where(defined, z.high, unbounded))


def _sqrt(z: Interval, _a: Interval) -> Sequence[Ends]:
    low, high = np.square(np.maximum(z.low, 0.0)), np.square(np.maximum(z.high, 0.0))
    return ((low * (1.0 - 4.0 * RELATIVE) - TINY, high * (1.0 + 4.0 * RELATIVE) + TINY),)


def _hypot(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    return _leg(z, b), _leg(z, a)


def _leg(z: Interval, other: Interval) -> Ends:
    least = np.where((other.low <= 0.0) & (other.high >= 0.0), 0.0, np.minimum(np.abs(other.low), np.abs(other.high)))
    left = np.square(z.high) - np.square(least)
    reach = np.sqrt(np.maximum(left + 8.0 * RELATIVE * np.square(z.high), 0.0)) * (1.0 + 8.0 * RELATIVE) + math.sqrt(
        TINY
    )
    reach = np.where(np.isnan(reach) | (z.high < 0.0), np.inf, reach)
    return -reach, reach


def _exp(z: Interval, _a: Interval) -> Sequence[Ends]:
    """Return the bounds; beyond `TINY` and `HUGE` an exponential has lost its digits, or is not a number."""
    low, high = log(np.clip(z.low, TINY, HUGE)), log(np.clip(z.high, TINY, HUGE))
    low, high = low - RELATIVE * (1.0 + np.abs(low)), high + RELATIVE * (1.0 + np.abs(high))
    return ((np.where(z.low > TINY, low, -np.inf), np.where(z.high < HUGE, high, np.inf)),)


def _log(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((exp(z.low) * (1.0 - 1e-9) - TINY, exp(z.high) * (1.0 + 1e-9) + TINY),)


def _move(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((z.low, z.high),)


def _floor(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((z.low, z.high + 1.0),)


def _ceil(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((z.low - 1.0, z.high),)


def _round(z: Interval, _a: Interval) -> Sequence[Ends]:
    return ((z.low - 0.5, z.high + 0.5),)


# -- truth ------------------------------------------------------------------------------------------------------------


def _order(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    """Return the bounds for less, or less or equal; reversed where it surely fails and neither operand is NaN."""
    holds, fails = z.low > 0.0, (z.high == 0.0) & ~a.undefined & ~b.undefined
    low, high = np.full(len(z.low), -np.inf), np.full(len(z.low), np.inf)
    return (
        (np.where(fails, b.low, low), np.where(holds, b.high, high)),
        (np.where(holds, a.low, low), np.where(fails, a.high, high)),
    )


def _equal(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    holds = z.low > 0.0
    return _only(holds, (b.low, b.high)), _only(holds, (a.low, a.high))


def _unequal(z: Interval, a: Interval, b: Interval) -> Sequence[Ends]:
    fails = z.high == 0.0
    return _only(fails, (b.low, b.high)), _only(fails, (a.low, a.high))


def _one_of(true: np.ndarray, false: np.ndarray, boolean: bool) -> Ends:
    """Return the ends of a logical operand: 1 for a true truth value, any value for a true number, 0 for false."""
    low = np.where(false, 0.0, np.where(true & boolean, 1.0, -np.inf))
    return low, np.where(false, 0.0, np.inf)


def _and(z: Interval, a: Interval, b: Interval, *, boolean: tuple[bool, bool]) -> Sequence[Ends]:
    holds, fails = z.low > 0.0, z.high == 0.0
    return (
        _one_of(holds, fails & surely_true(b), boolean[0]),
        _one_of(holds, fails & surely_true(a), boolean[1]),
    )


def _or(z: Interval, a: Interval, b: Interval, *, boolean: tuple[bool, bool]) -> Sequence[Ends]:
    holds, fails = z.low > 0.0, z.high == 0.0
    return (
        _one_of(holds & surely_false(b), fails, boolean[0]),
        _one_of(holds & surely_false(a), fails, boolean[1]),
    )


def _not(z: Interval, _a: Interval, *, boolean: tuple[bool]) -> Sequence[Ends]:
    return (_one_of(z.high == 0.0, z.low > 0.0, boolean[0]),)


def _select(z: Interval, a: Interval, _b: Interval, _c: Interval) -> Sequence[Ends | None]:
    ends = z.low, z.high
    return None, _only(surely_true(a), ends), _only(surely_false(a), ends)


BACKWARD: Mapping[Op, Backward] = {
    Op.MOVE: _move,
    Op.ADD: _add,
    Op.SUB: _sub,
    Op.MUL: _mul,
    Op.DIV: _div,
    Op.NEG: _neg,
    Op.ABS: _abs,
    Op.MIN: _min,
    Op.MAX: _max,
    Op.SQRT: _sqrt,
    Op.HYPOT: _hypot,
    Op.EXP: _exp,
    Op.LOG: _log,
    Op.FLOOR: _floor,
    Op.CEIL: _ceil,
    Op.ROUND: _round,
    Op.LT: _order,
    Op.LE: _order,
    Op.EQ: _equal,
    Op.NE: _unequal,
    Op.SELECT: _select,
}
LOGIC: Mapping[Op, Backward] = {Op.AND: _and, Op.OR: _or, Op.NOT: _not}
"""These must know which operands are truths."""


def narrowed(
    op: Op, result: Interval, operands: Sequence[Interval], makers: Sequence[Op | None]
) -> Sequence[Ends | None]:
    """Return narrower ends for the operands; `makers` are the instructions that made them, or None."""
    if op in LOGIC:
        return LOGIC[op](result, *operands, boolean=tuple(maker in TRUTHS for maker in makers))
    return BACKWARD[op](result, *operands) if op in BACKWARD else [None] * len(operands)


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
            return [table(self.program.code.pool, instruction.number, operands[0])]
        return [FORWARD[instruction.op](*operands)]

    def demand(self, requirement: int) -> None:
        """Demand that the requirement holds: its result is not zero.

        Nothing follows where it may be NaN, which ends an attempt as an error that must not be skipped.
        """
        root = self.tape.roots[requirement]
        maker = self.tape.maker.get(root)
        if maker is not None and maker.op in TRUTHS:
            self.demanded[root] = ~self.undefined[root]
            one = np.ones(len(self.killer))
            self._intersect(root, (one, one), self.demanded[root], requirement)
        else:
            self.kill(surely_false(self[root]), requirement)

    def backward(self, instructions: Sequence[Instruction], requirement: int) -> None:
        """Narrow the operands of the demanded slots."""
        for instruction in reversed(instructions):
            demanded = self.demanded[instruction.first]
            if instruction.results > 1 or instruction.op in GEOMETRY or not demanded.any():
                continue
            operands = [self[slot] for slot in instruction.operands]
            makers = [maker.op if (maker := self.tape.maker.get(slot)) else None for slot in instruction.operands]
            answers = narrowed(instruction.op, self[instruction.first], operands, makers)
            for slot, ends in zip(instruction.operands, answers, strict=True):
                if ends is not None and slot != self.tape.unknown:
                    bounded = demanded & (np.isfinite(ends[0]) | np.isfinite(ends[1]))
                    self.demanded[slot] |= bounded
                    self._intersect(slot, ends, bounded, requirement)

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
