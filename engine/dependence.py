"""Dependence of the actors of a program on the ego, read off its instructions."""

from collections.abc import Iterable, Iterator

import numpy as np

from engine.opcodes import Op
from engine.program import Program
from engine.tables import Ints, Size

EGO = 0
SURROUNDINGS = {Op.WITHIN, Op.LEAD, Op.TTC, Op.SEES, Op.NOTICES, Op.TOUCHES, Op.CROSSING}
"""Instructions that look at all actors: the ego may be one that is seen, or one that hides another."""
STATES = {Op.STATE, Op.VELOCITY}
"""Instructions that read the state of actor a."""
BLOCKS = {Op.IS_RUNNING, Op.JUMP_IF_RUNNING, Op.SET_RESUME, Op.RESUME, Op.YIELD}
"""Instructions that read or set the place at which block a continues."""


def ignores_ego(program: Program) -> bool:
    """Return True if it is certain that nothing that the other actors do depends on the ego, nor any entry.

    Random numbers of behaviours come from one stream, which an absent ego does not advance; monitors may start, stop
    and place actors. With either, the answer is False.
    """
    code = program.code
    if code.monitor_entry.size:
        return False
    rows = code.step_code
    others = rows[_reached(rows, code.behaviour_entry[:, 1:].ravel().tolist())]
    ego = rows[_reached(rows, code.behaviour_entry[:, :1].ravel().tolist())]
    ops = others[:, 0]
    if np.isin(ops, [*SURROUNDINGS, Op.RANDOM]).any() or (others[np.isin(ops, [*STATES]), 2] == EGO).any():
        return False
    if set(_blocks(others)) & {*_blocks(ego), *code.main_block[:, 0].tolist()}:
        return False
    first = len(code.literals) + code.variant_values.shape[1] + code.output_register.shape[1]
    held = {register for register in ego[:, 1].tolist() if first <= register < first + int(code.sizes[Size.LOCALS])}
    return not held & set(others[:, 1:].ravel().tolist())


def _blocks(rows: Ints) -> Iterator[int]:
    return (block for op, _, block, *_ in rows.tolist() if op in BLOCKS)


def _reached(rows: Ints, entries: Iterable[int]) -> list[int]:
    """Return the rows of code that may be executed from these entries; -1 is none."""
    reached: set[int] = set()
    waiting = [row for row in entries if row >= 0]
    while waiting:
        row = waiting.pop()
        if row < len(rows) and row not in reached:
            reached.add(row)
            waiting += [following for following in _following(row, rows[row].tolist()) if following >= 0]
    return sorted(reached)


def _following(row: int, instruction: list[int]) -> tuple[int, ...]:
    """Return the rows at which execution may go on after an instruction, in this turn or later."""
    op, _, a, b, c, d = instruction
    match op:
        case Op.JUMP:
            return (a,)
        case Op.RESUME | Op.HALT | Op.END:
            return ()
        case Op.JUMP_UNLESS | Op.JUMP_IF_RUNNING | Op.SET_RESUME:
            return row + 1, b
        case Op.FOLLOW:
            return row + 1, d
        case Op.REPLAY:
            return row + 1, c
        case _:
            return (row + 1,)
