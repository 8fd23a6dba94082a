"""Dependence of the actors of a program on the ego, read off its instructions."""

from collections.abc import Iterable, Iterator

from engine.opcodes import MANY, NUMBER, Op
from engine.operators import OPERATORS, signature
from engine.program import Program
from engine.tables import Ints, Size

EGO = 0
READ_ACTOR = frozenset({Op.STATE, Op.VELOCITY})
"""Instructions that read the state of actor a alone."""
GEOMETRY = frozenset(op for op in Op if Op.PATH_POSE <= op < Op.STATE)
CONTROL = frozenset(op for op in Op if op >= Op.JUMP)
INDIFFERENT = frozenset({*OPERATORS, Op.TABLE, *GEOMETRY, Op.TIME, Op.ACTION, Op.IS_RUNNING, *CONTROL})
"""Instructions that read registers, the road, the time, blocks and external decisions, or that command their own actor.

All others look at every actor, since the ego may be one that is seen, or one that hides another; or they draw from the
stream of random numbers of all behaviors, which an absent ego does not advance.
"""
BLOCKS = frozenset({Op.IS_RUNNING, Op.JUMP_IF_RUNNING, Op.SET_RESUME, Op.RESUME, Op.YIELD})
"""Instructions that read or set the place at which block a continues."""


def ignores_ego(program: Program) -> bool:
    """Return True if it is certain that nothing that the other actors do depends on the ego.

    False where monitors run, since they may start, stop and place actors.
    """
    code = program.code
    if code.monitor_entry.size:
        return False
    rows = code.step_code
    others = rows[_reached(rows, code.behaviour_entry[:, 1:].ravel().tolist())].tolist()
    ego = rows[_reached(rows, code.behaviour_entry[:, :1].ravel().tolist())].tolist()
    if not all(op in INDIFFERENT or (op in READ_ACTOR and actor != EGO) for op, _, actor, *_ in others):
        return False
    ego_blocks, other_blocks = ({row[2] for row in part if row[0] in BLOCKS} for part in (ego, others))
    ego_blocks |= set(code.main_block[:, 0].tolist())
    other_blocks |= set(code.main_block[:, 1:].ravel().tolist())
    first = len(code.literals) + code.variant_values.shape[1] + code.output_register.shape[1]
    last = first + int(code.sizes[Size.LOCALS])
    ego_locals = {register for row in ego for register in _written(row) if first <= register < last}
    return not (ego_blocks & other_blocks or any(ego_locals.intersection(_read(row, last)) for row in others))


def _written(instruction: list[int]) -> range:
    """Return the registers that an instruction writes."""
    op, destination, *_ = instruction
    return range(destination, destination + signature(Op(op)).results)


def _read(instruction: list[int], last: int) -> Iterator[int]:
    """Yield the registers that an instruction reads, those before `last` where their number is not known."""
    op, _, *operands = instruction
    for operand, count in zip(operands, signature(Op(op)).operands, strict=False):
        if count != NUMBER:
            yield from range(operand, last if count == MANY else operand + count)


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
    """Return the rows at which execution may continue after an instruction, in this turn or later."""
    op, _, a, b, c, d = instruction
    match op:
        case Op.JUMP:
            return (a,)
        case Op.RESUME | Op.HALT | Op.END:
            return ()
        case Op.JUMP_UNLESS | Op.JUMP_IF_FALSE | Op.JUMP_IF_RUNNING | Op.SET_RESUME:
            return row + 1, b
        case Op.FOLLOW:
            return row + 1, d
        case Op.REPLAY:
            return row + 1, c
        case _:
            return (row + 1,)
