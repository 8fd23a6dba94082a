"""A template's scene code as a tape: every value has its own slot, every instruction names all its operands.

Registers are overwritten; slots are not (static single assignment), so the bounds of a value stay valid. Slots 0 … are
the leaves in the order of the registers: literals, variant values, genes, draws. A register that is read before it is
written is slot `unknown`.
"""

from functools import cached_property

import numpy as np

from engine.feasibility.bounds import GEOMETRY
from engine.frozen import frozen
from engine.opcodes import Op
from engine.operators import OPERATORS, signature
from engine.program import Program
from engine.tables import CodeTables, Size
from engine.vocabulary import Column


@frozen
class Instruction:
    op: Op
    first: int
    """Slot of its first result; further results are in the next slots."""
    results: int
    operands: tuple[int, ...]
    number: int = 0
    """The integer operand of `Op.TABLE`."""


@frozen
class Leaves:
    """First slots of the groups of leaves, the same for all templates."""

    variant_values: int
    genes: int
    draws: int
    temporaries: int

    @property
    def variables(self) -> range:
        """Return the slots of the values that an attempt may vary: genes, then draws. Variable i is slot
        `variables[i]`.
        """
        return range(self.genes, self.temporaries)

    @property
    def gene_count(self) -> int:
        return self.draws - self.genes


@frozen
class Tape:
    """The scene code of one template."""

    leaves: Leaves
    slots: int
    unknown: int
    instructions: tuple[Instruction, ...]
    roots: tuple[int, ...]
    """Slot of each requirement of the file; -1 for a soft requirement."""
    values: tuple[int, ...]
    """Slots of the scene values."""

    @cached_property
    def maker(self) -> dict[int, Instruction]:
        """Return the instruction that made each slot that is not a leaf."""
        return {i.first + n: i for i in self.instructions for n in range(i.results)}

    @cached_property
    def depends(self) -> list[frozenset[int]]:
        """Return the variables that each slot depends on."""
        depends: list[frozenset[int]] = [frozenset()] * self.slots
        for variable, slot in enumerate(self.leaves.variables):
            depends[slot] = frozenset({variable})
        depends[self.unknown] = frozenset({-1})
        for instruction in self.instructions:
            union = frozenset[int]().union(*(depends[slot] for slot in instruction.operands))
            for n in range(instruction.results):
                depends[instruction.first + n] = union
        return depends

    @cached_property
    def tabulated(self) -> frozenset[int]:
        """Return the slots of constants, and of values that cannot be inverted and depend on draws alone or on one gene
        alone.
        """
        hard: set[int] = set()
        chosen: set[int] = set()
        for instruction in self.instructions:
            made = range(instruction.first, instruction.first + instruction.results)
            row = OPERATORS.get(instruction.op)
            if row is None or row.backward is None or row.is_tabulated or not hard.isdisjoint(instruction.operands):
                hard.update(made)
            depends = self.depends[instruction.first]
            genes = sum(variable < self.leaves.gene_count for variable in depends)
            if -1 not in depends and (not depends or (hard.issuperset(made) and (genes == 0 or len(depends) == 1))):
                chosen.update(made)
        return frozenset(chosen)

    @cached_property
    def frontier(self) -> tuple[int, ...]:
        """Return the tabulated slots that are operands of other slots, or requirements themselves."""
        used = {slot for i in self.instructions if i.first not in self.tabulated for slot in i.operands}
        return tuple(sorted(self.tabulated & (used | set(self.roots))))

    def cone(self, root: int, stop: frozenset[int] = frozenset()) -> tuple[Instruction, ...]:
        """Return the instructions that a slot needs, in their order, down to the leaves and to slots in `stop`."""
        needed = {root}
        chosen: list[Instruction] = []
        for instruction in reversed(self.instructions):
            made = range(instruction.first, instruction.first + instruction.results)
            if any(slot in needed and slot not in stop for slot in made):
                chosen.append(instruction)
                needed.update(instruction.operands)
        return tuple(reversed(chosen))

    def outline(self, actor: int) -> list[int]:
        """Return the slots of an actor's x, y, heading, length and width."""
        first = actor * len(Column)
        columns = (Column.X, Column.Y, Column.HEADING, Column.LENGTH, Column.WIDTH)
        return [self.values[first + column] for column in columns]


def leaves_of(program: Program) -> Leaves:
    code = program.code
    variant_values = len(code.literals)
    genes = variant_values + code.variant_values.shape[1]
    draws = genes + len(program.space)
    return Leaves(variant_values, genes, draws, draws + int(code.sizes[Size.DRAWS]))


def record(program: Program, template: int) -> Tape:
    """Return the tape of one template: its hard requirements in order, then its scene values."""
    return _Recorder(program.code, leaves_of(program), template).tape()


class _Recorder:
    def __init__(self, code: CodeTables, leaves: Leaves, template: int) -> None:
        self.code, self.leaves, self.template = code, leaves, template
        self.unknown = leaves.temporaries
        self.slots = leaves.temporaries + 1
        self.slot_of: dict[int, int] = {register: register for register in range(leaves.temporaries)}
        self.instructions: list[Instruction] = []

    def tape(self) -> Tape:
        roots: list[int] = []
        for requirement, (start, end, result) in enumerate(self.code.requirement_segment[self.template].tolist()):
            if self.code.requirement_probability[requirement] < 1.0:
                # Its code may be skipped, and then later code reads the registers of an earlier attempt.
                self._forget(start, end)
                roots.append(-1)
                continue
            self._run(start, end)
            roots.append(self._read(result))
        self._run(*self.code.output_segment[self.template].tolist())
        values = tuple(self._read(register) for register in self.code.output_register[self.template].tolist())
        return Tape(self.leaves, self.slots, self.unknown, tuple(self.instructions), tuple(roots), values)

    def _read(self, register: int) -> int:
        return self.slot_of.get(register, self.unknown)

    def _forget(self, start: int, end: int) -> None:
        for row in self.code.scene_code[start:end].tolist():
            for n in range(signature(Op(row[0])).results):
                self.slot_of[row[1] + n] = self.unknown

    def _run(self, start: int, end: int) -> None:
        for op_number, destination, *numbers in self.code.scene_code[start:end].tolist():
            op = Op(op_number)
            if op == Op.END:
                return
            registers, number = _operands(op, numbers)
            results = signature(op).results
            known = op in OPERATORS or op in GEOMETRY or op == Op.TABLE
            if known:
                operands = tuple(self._read(register) for register in registers)
                self.instructions.append(Instruction(op, self.slots, results, operands, number))
            for n in range(results):
                self.slot_of[destination + n] = self.slots + n if known else self.unknown
            self.slots += results if known else 0


def _operands(op: Op, numbers: list[int]) -> tuple[list[int], int]:
    """Return the registers that an instruction reads, and its integer."""
    counts = signature(op).operands
    registers = [register + n for register, count in zip(numbers, counts, strict=False) for n in range(count)]
    return registers, numbers[0] if op == Op.TABLE else 0


def variant_leaves(program: Program, variants: np.ndarray) -> np.ndarray:
    """Return (slots of literals and variant values, n) the known leaves of some variants."""
    code = program.code
    literals = np.repeat(code.literals[:, np.newaxis], len(variants), axis=1)
    return np.vstack([literals, code.variant_values[variants].T])


def genes_read(program: Program, requirement: int) -> tuple[int, ...]:
    """Return the genes that a requirement of the file depends on in some variant; all genes if unknown."""
    found: set[int] = set()
    for template in range(len(program.code.output_segment)):
        tape = record(program, template)
        root = tape.roots[requirement] if requirement < len(tape.roots) else tape.unknown
        found |= tape.depends[root if root >= 0 else tape.unknown]
    genes = range(len(program.space))
    return tuple(genes) if -1 in found else tuple(sorted(found.intersection(genes)))
