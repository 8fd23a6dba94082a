"""Slices of every variable's range, computed once per program, and the narrowing of given boxes by them.

Each variable's range is cut into slices, all other variables keeping their whole ranges. A slice in which a requirement
surely fails is dead (shaving). For values that cannot be inverted, such as the distance to an intersection from a point
on a curved lane, a table stores their interval on every slice; a reverse look-up in it is their inverse.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from engine.feasibility.bounds import GEOMETRY
from engine.feasibility.contraction import ALIVE, Boxes, empty_boxes
from engine.feasibility.tape import Instruction, Tape, record, variant_leaves
from engine.frozen import frozen
from engine.opcodes import Op
from engine.operators.intervals import Bools
from engine.program import Program
from engine.tables import ROAD_REGION, Floats, Ints, Size
from engine.vocabulary import GeneKind

EVERY = -1
"""All requirements."""
MOST = 62
"""Requirement number from which on all share one bit."""
REFINED = 16
"""Parts into which a slice at the border of the dead slices is cut to move the border."""


@frozen
class Table:
    """Interval of a value on each slice of a variable: arrays (variants, slices)."""

    low: Floats
    high: Floats


@frozen
class Sliced:
    """Sliced ranges of all variants of one template."""

    program: Program
    tape: Tape
    variants: Ints
    """(m,) Numbers of the variants."""
    variables: tuple[int, ...]
    """Variables that a hard requirement or an outline depends on; the axis `variables` below."""
    low: Floats
    """(m, variables, slices) ends of the slices, in order."""
    high: Floats
    fatal: Ints
    """(m, variables, slices) Bits of the requirements that prove a slice dead; 0 if alive or empty."""
    dead: Bools
    """(m, variables, slices)"""
    tables: Mapping[tuple[int, int], Table]
    """Tables by slot of the frontier and position in `variables`."""
    undefined: Mapping[int, Bools]
    """(m,) True where a value of the frontier may be NaN."""
    whole: Mapping[int, tuple[Floats, Floats]]
    """(m,) least and greatest value of each slot of the frontier."""
    fate: Ints
    """(m,) Bits of the requirements that make a variant impossible by themselves; 0 if none does."""
    cones: Mapping[int, tuple[Instruction, ...]]
    """The instructions of each hard requirement down to the frontier."""

    def dead_under(self, allowed: int) -> Bools:
        """Return the slices that are proved dead by these requirements alone (bits; `EVERY`)."""
        return self.dead if allowed == EVERY else self.dead & ((self.fatal & ~allowed) == 0)


def bit(requirement: int) -> int:
    return 1 << min(requirement, MOST)


def bits(killer: Ints) -> Ints:
    """Return the bit of each killer, 0 for `ALIVE`."""
    return np.where(killer == ALIVE, 0, np.left_shift(np.int64(1), np.clip(killer, 0, MOST).astype(np.int64)))


@frozen
class Bench:
    """One template under analysis."""

    program: Program
    tape: Tape
    variants: Ints

    def ranges(self) -> tuple[Floats, Floats]:
        """Return (m, all variables) SI ranges; genes that select a variant are fixed at its option."""
        space, code = self.program.space, self.program.code
        ends = [np.minimum(space.low * space.scale, space.high * space.scale),
                np.maximum(space.low * space.scale, space.high * space.scale)]  # fmt: skip
        draws = int(code.sizes[Size.DRAWS])
        low, high = (np.tile(np.concatenate([end, np.full(draws, fill)]), (len(self.variants), 1))
                     for end, fill in zip(ends, (0.0, 1.0), strict=True))  # fmt: skip
        for position, variant in enumerate(self.variants):
            group = int(np.searchsorted(code.group_start, int(variant), side="right")) - 1
            for gene, size in zip(code.group_gene[::-1], code.group_size[::-1], strict=True):
                group, option = divmod(group, int(size))
                low[position, gene] = high[position, gene] = (space.low[gene] + option) * space.scale[gene]
        return low, high

    def open(self, rows: Ints, low: Floats, high: Floats) -> Boxes:
        """Return boxes over the variants `rows` with variables between low and high (n, all variables)."""
        boxes = empty_boxes(self.program, self.tape, len(rows))
        known = variant_leaves(self.program, self.variants[rows])
        boxes.low[: len(known)] = boxes.high[: len(known)] = known
        boxes.undefined[: len(known)] = np.isnan(known)
        variables = self.tape.leaves.variables
        boxes.low[variables.start : variables.stop] = low.T
        boxes.high[variables.start : variables.stop] = high.T
        boxes.undefined[variables.start : variables.stop] = False
        return boxes

    def evaluate(self, boxes: Boxes) -> None:
        boxes.forward(self.tape.instructions, 0)

    def judge(self, boxes: Boxes, cones: Mapping[int, tuple[Instruction, ...]]) -> None:
        """Kill boxes in which a requirement surely fails, each requirement alone."""
        for requirement in cones:
            boxes.demand(requirement)
        reasons = self.program.first_built_in
        for built_in, broken in enumerate((_off_road(boxes), _overlapping(boxes))):
            boxes.kill(broken, reasons + built_in)


def _defined(boxes: Boxes) -> Bools:
    """Return (n,) True where every scene value is a number; built-in requirements are tested only there."""
    known = np.ones(len(boxes.killer), dtype=bool)
    for slot in set(boxes.tape.values):
        known &= ~boxes.undefined[slot]
    return known


def _off_road(boxes: Boxes) -> Bools:
    broken = np.zeros(len(boxes.killer), dtype=bool)
    region = np.full(len(broken), float(ROAD_REGION))
    road = boxes[boxes.tape.unknown]._replace(low=region, high=region, undefined=np.zeros(len(broken), dtype=bool))
    for actor, checked in enumerate(boxes.program.code.road_check):
        if checked:
            outline = [boxes[slot] for slot in boxes.tape.outline(actor)]
            (inside,) = GEOMETRY[Op.REGION_CONTAINS_BOX](boxes.program.road, [road, *outline])
            broken |= inside.high == 0.0
    return broken & _defined(boxes)


def _overlapping(boxes: Boxes) -> Bools:
    broken = np.zeros(len(boxes.killer), dtype=bool)
    groups = boxes.program.code.overlap_check
    checked = np.flatnonzero(groups)
    if len(boxes.program.road.heights):
        return broken  # actors on different levels may overlap in the plane
    for position, one in enumerate(checked):
        for other in checked[:position]:
            if groups[one] != groups[other]:
                continue
            outlines = [boxes[slot] for actor in (one, other) for slot in boxes.tape.outline(int(actor))]
            (gap,) = GEOMETRY[Op.BOX_DISTANCE](boxes.program.road, outlines)
            broken |= ~gap.undefined & (gap.high == 0.0)
    return broken & _defined(boxes)


def slice_template(program: Program, template: int, count: int) -> Sliced:
    """Cut the variables of a template's variants into about `count` slices each."""
    tape = record(program, template)
    variants = np.flatnonzero(program.code.variant_template == template)
    bench = Bench(program, tape, variants)
    hard = [requirement for requirement, root in enumerate(tape.roots) if root >= 0]
    stop = frozenset(tape.frontier)
    cones = {requirement: tape.cone(tape.roots[requirement], stop) for requirement in hard}
    low, high = bench.ranges()
    full = bench.open(np.arange(len(variants)), low, high)
    bench.evaluate(full)
    whole = {slot: (full.low[slot].copy(), full.high[slot].copy()) for slot in tape.frontier}
    undefined = {slot: full.undefined[slot].copy() for slot in tape.frontier}
    bench.judge(full, cones)
    variables = _active(program, tape)
    cutter = _Cutter(bench, cones, variables, low, high)
    ends = cutter.edges(count)
    dead, fatal, tables = cutter.look(*ends)
    for _ in range(2):
        cutter.move_borders(*ends, dead, fatal)
    cutter.tabulate_borders(*ends, dead, tables)
    return Sliced(program, tape, variants, variables, *ends, fatal, dead, tables, undefined, whole,
                  bits(full.killer), cones)  # fmt: skip


def _active(program: Program, tape: Tape) -> tuple[int, ...]:
    slots = {root for root in tape.roots if root >= 0}
    for actor in range(len(program.actors)):
        if program.code.road_check[actor] or program.code.overlap_check[actor]:
            slots.update(tape.outline(actor))
    found = frozenset[int]().union(*(tape.depends[slot] for slot in slots))
    return tuple(sorted(found - {-1}))


@frozen
class _Cutter:
    bench: Bench
    cones: Mapping[int, tuple[Instruction, ...]]
    variables: tuple[int, ...]
    low: Floats
    high: Floats

    def edges(self, count: int) -> tuple[Floats, Floats]:
        """Return even slices, between two of zero width that collect the dead parts at the ends."""
        space = self.bench.program.space
        steps = np.concatenate([[0.0], np.linspace(0.0, 1.0, count + 1), [1.0]])
        chosen = list(self.variables)
        low, high = self.low[:, chosen, np.newaxis], self.high[:, chosen, np.newaxis]
        edges = np.clip(low + steps * (high - low), low, high)
        starts, ends = edges[:, :, :-1].copy(), edges[:, :, 1:].copy()
        for position, variable in enumerate(chosen):
            if variable < len(space) and space.kinds[variable] != GeneKind.CONTINUOUS:
                self._whole_numbers(variable, starts[:, position], ends[:, position])
        return starts, ends

    def _whole_numbers(self, gene: int, starts: Floats, ends: Floats) -> None:
        """Set a discrete gene's slices to whole numbers; surplus slices repeat the last number."""
        space, count = self.bench.program.space, int(starts.shape[1]) - 2
        options = int(space.high[gene] - space.low[gene]) + 1
        if (starts[:, 0] == ends[:, -1]).any() or options > count:
            return
        values = (space.low[gene] + np.minimum(np.arange(count), options - 1)) * space.scale[gene]
        values = np.concatenate([values[:1], values, values[-1:]])
        starts[:], ends[:] = values, values

    def look(self, starts: Floats, ends: Floats) -> tuple[Bools, Ints, dict[tuple[int, int], Table]]:
        """Return the dead slices, the requirements that kill them, and the tables."""
        shape = starts.shape
        variants, positions, _ = np.unravel_index(np.arange(starts.size), shape)
        boxes = self._boxes(variants, positions, starts.ravel(), ends.ravel())
        tables: dict[tuple[int, int], Table] = {}
        for slot in self.bench.tape.frontier:
            for position, variable in enumerate(self.variables):
                if variable in self.bench.tape.depends[slot]:
                    low, high = boxes.low[slot].reshape(shape), boxes.high[slot].reshape(shape)
                    tables[slot, position] = Table(low[:, position].copy(), high[:, position].copy())
        self.bench.judge(boxes, self.cones)
        dead = (boxes.killer != ALIVE).reshape(shape)
        fatal = bits(boxes.killer).reshape(shape)
        dead[:, :, [0, -1]], fatal[:, :, [0, -1]] = True, 0
        return dead, fatal, tables

    def _boxes(self, variants: Ints, positions: Ints, starts: Floats, ends: Floats) -> Boxes:
        low, high = self.low[variants], self.high[variants]
        columns = np.array(self.variables, dtype=np.int64)[positions]
        rows = np.arange(len(variants))
        low[rows, columns], high[rows, columns] = starts, ends
        boxes = self.bench.open(variants, low, high)
        self.bench.evaluate(boxes)
        return boxes

    def move_borders(self, starts: Floats, ends: Floats, dead: Bools, fatal: Ints) -> None:
        """Move the borders between the dead slices at both ends and those alive: into the first that is alive."""
        variants, positions, place, backwards = _borders(dead)
        if not len(variants):
            return
        low, high = starts[variants, positions, place], ends[variants, positions, place]
        steps = np.linspace(0.0, 1.0, REFINED + 1)
        edges = low[:, np.newaxis] + steps * (high - low)[:, np.newaxis]
        edges[:, -1] = high
        parts = self._boxes(
            np.repeat(variants, REFINED), np.repeat(positions, REFINED), edges[:, :-1].ravel(), edges[:, 1:].ravel()
        )
        self.bench.judge(parts, self.cones)
        killers = parts.killer.reshape(-1, REFINED)
        killers[backwards] = killers[backwards, ::-1]
        lead = np.where((killers != ALIVE).all(axis=1), 0, np.argmin(killers != ALIVE, axis=1))
        reasons = np.bitwise_or.reduce(np.where(np.arange(REFINED) < lead[:, np.newaxis], bits(killers), 0), axis=1)
        neighbour = place + np.where(backwards, 1, -1)
        moved = (lead > 0) & (neighbour >= 0) & (neighbour < dead.shape[2])
        border = edges[np.arange(len(lead)), np.where(backwards, REFINED - lead, lead)]
        for side, near, far in ((moved & ~backwards, starts, ends), (moved & backwards, ends, starts)):
            here, beside = (variants[side], positions[side], place[side]), neighbour[side]
            near[here] = far[*here[:2], beside] = border[side]
            dead[*here[:2], beside] = True
            fatal[*here[:2], beside] |= reasons[side]

    def tabulate_borders(
        self, starts: Floats, ends: Floats, dead: Bools, tables: Mapping[tuple[int, int], Table]
    ) -> None:
        """Update the tables where a border has moved."""
        variants, positions, place, _ = _borders(dead)
        boxes = self._boxes(variants, positions, starts[variants, positions, place], ends[variants, positions, place])
        for (slot, position), table in tables.items():
            mine = positions == position
            table.low[variants[mine], place[mine]] = boxes.low[slot][mine]
            table.high[variants[mine], place[mine]] = boxes.high[slot][mine]


def _borders(dead: Bools) -> tuple[Ints, Ints, Ints, Bools]:
    """Return variant, variable and place of the first and the last slice that is alive, and True for the last."""
    variants, positions = np.nonzero(~dead.all(axis=2))
    first, last = np.argmin(dead, axis=2), dead.shape[2] - 1 - np.argmin(dead[:, :, ::-1], axis=2)
    place = np.concatenate([first[variants, positions], last[variants, positions]])
    backwards = np.repeat([False, True], len(variants))
    return np.tile(variants, 2), np.tile(positions, 2), place, backwards


# -- narrowing: contraction over the requirements, with tables for values that have no inverse

GRID = 2.0**30
"""Grid to which ends of draws are rounded outward, so that the last digit of a library function has no influence."""


@dataclass(frozen=True)
class Narrowed:
    """Boxes (n) of variants, narrowed."""

    low: Floats
    """(n, all variables) SI."""
    high: Floats
    killer: Ints
    """(n,) Requirement that surely fails; -1 if an attempt in the box may pass."""


def narrow(sliced: Sliced, rows: Ints, low: Floats, high: Floats, rounds: int = 1, allowed: int = EVERY) -> Narrowed:
    """Narrow boxes of the variants `rows` (positions in `sliced.variants`).

    Args:
        sliced: the template.
        rows: (n,)
        low: (n, all variables) SI, inside the ranges of the program.
        high: (n, all variables) SI, inside the ranges of the program.
        rounds: number of passes over all requirements.
        allowed: bits of the requirements that may be used.
    """
    if not len(rows):
        return Narrowed(low, high, np.zeros(0, dtype=np.int32))
    with np.errstate(all="ignore"):
        return _Work(sliced, rows, low, high, allowed).run(rounds)


class _Work:
    """One call of `narrow`. Arrays (n, …) have one row instead of n if all boxes share their values."""

    def __init__(self, sliced: Sliced, rows: Ints, low: Floats, high: Floats, allowed: int) -> None:
        self.sliced, self.rows, self.allowed = sliced, rows, allowed
        self.slots = list(sliced.tape.leaves.variables)
        self.boxes = Bench(sliced.program, sliced.tape, sliced.variants).open(rows, low, high)
        self.variant = rows[:1] if (rows == rows[0]).all() else rows
        self.fatal = np.where(sliced.dead_under(allowed), sliced.fatal, 0)
        self.alive = [self._met(position, low, high) for position in range(len(sliced.variables))]
        fate = sliced.fate[rows] if allowed == EVERY else sliced.fate[rows] & allowed
        self.boxes.killer[:] = _lowest(fate)
        for position in range(len(sliced.variables)):
            self._settle(position, _lowest(np.bitwise_or.reduce(self.fatal[self.variant, position], axis=1)))
        self._read_tables(sliced.tape.frontier, first=True)

    def _met(self, position: int, low: Floats, high: Floats) -> Bools:
        """Return the slices that are alive and intersect the boxes."""
        sliced, variable = self.sliced, self.sliced.variables[position]
        least, greatest = low[:, [variable]], high[:, [variable]]
        if len(self.variant) == 1 and (least == least[0]).all() and (greatest == greatest[0]).all():
            least, greatest = least[:1], greatest[:1]
        dead = sliced.dead[self.variant, position]
        if self.allowed != EVERY:
            dead = dead & ((sliced.fatal[self.variant, position] & ~self.allowed) == 0)
        met = (sliced.low[self.variant, position] <= greatest) & (sliced.high[self.variant, position] >= least)
        return ~dead & met

    def _settle(self, position: int, requirement: Ints | int) -> None:
        """Set a variable's interval to the hull of its slices that are alive; without one the box is dead."""
        sliced, alive = self.sliced, self.alive[position]
        slot = self.slots[sliced.variables[position]]
        rows, places = self._rows_of(alive), np.arange(int(alive.shape[1]))
        low = sliced.low[rows, position, places[alive.argmax(axis=1)]]
        high = sliced.high[rows, position, places[::-1][alive[:, ::-1].argmax(axis=1)]]
        some = alive.any(axis=1)
        low, high = np.maximum(self.boxes.low[slot], low), np.minimum(self.boxes.high[slot], high)
        empty = (~some | (low > high)) & self.boxes.alive
        self.boxes.killer[empty] = np.broadcast_to(requirement, empty.shape)[empty]
        taken = some & (low <= high)
        np.copyto(self.boxes.low[slot], low, where=taken)
        np.copyto(self.boxes.high[slot], high, where=taken)

    def _rows_of(self, alive: Bools) -> Ints:
        return self.variant[:1] if len(alive) == 1 else np.broadcast_to(self.variant, len(alive))

    def _read_tables(self, slots: Sequence[int], *, first: bool = False) -> None:
        """Read values of the frontier from the slices that are alive."""
        for slot in slots:
            if first:
                self.boxes.low[slot], self.boxes.high[slot] = (end[self.variant] for end in self.sliced.whole[slot])
                self.boxes.undefined[slot] = self.sliced.undefined[slot][self.variant]
            for position in self._positions(slot):
                table, alive = self.sliced.tables[slot, position], self.alive[position]
                low = np.where(alive, table.low[self.variant], np.inf).min(axis=1)
                high = np.where(alive, table.high[self.variant], -np.inf).max(axis=1)
                taken = alive.any(axis=1)
                np.copyto(self.boxes.low[slot], np.maximum(self.boxes.low[slot], low), where=taken)
                np.copyto(self.boxes.high[slot], np.minimum(self.boxes.high[slot], high), where=taken)

    def _positions(self, slot: int) -> list[int]:
        return [position for position in range(len(self.sliced.variables)) if (slot, position) in self.sliced.tables]

    def run(self, rounds: int) -> Narrowed:
        for again in range(rounds):
            for requirement, cone in self.sliced.cones.items():
                if self.allowed != EVERY and not self.allowed >> min(requirement, MOST) & 1:
                    continue
                self.boxes.forward(cone, requirement)
                self.boxes.demand(requirement)
                self.boxes.backward(cone, requirement)
                self._look_up(requirement, again=again + 1 < rounds)
        variables = self.sliced.tape.leaves.variables
        low = self.boxes.low[variables.start : variables.stop].T.copy()
        high = self.boxes.high[variables.start : variables.stop].T.copy()
        draws = self.sliced.tape.leaves.gene_count
        low[:, draws:] = np.floor(low[:, draws:] * GRID) / GRID
        high[:, draws:] = np.ceil(high[:, draws:] * GRID) / GRID
        return Narrowed(low, high, self.boxes.killer)

    def _look_up(self, requirement: int, *, again: bool) -> None:
        """Keep only the slices that can have the demanded values of the frontier."""
        root = self.sliced.tape.roots[requirement]
        read = {slot for instruction in self.sliced.cones[requirement] for slot in instruction.operands} | {root}
        touched = [slot for slot in self.sliced.tape.frontier if slot in read and self.boxes.demanded[slot].any()]
        for slot in touched:
            demanded = self.boxes.demanded[slot][:, np.newaxis]
            low, high = self.boxes.low[slot][:, np.newaxis], self.boxes.high[slot][:, np.newaxis]
            for position in self._positions(slot):
                table = self.sliced.tables[slot, position]
                meets = (table.high[self.variant] >= low) & (table.low[self.variant] <= high)
                self.alive[position] = self.alive[position] & (meets | ~demanded)
                self._settle(position, requirement)
        if again:
            self._read_tables(touched)


def _lowest(fatal: Ints) -> Ints:
    """Return the first requirement of each set of bits; `ALIVE` for an empty set."""
    lowest = fatal & -fatal
    return np.where(fatal == 0, ALIVE, np.round(np.log2(np.maximum(lowest, 1).astype(np.float64)))).astype(np.int32)
