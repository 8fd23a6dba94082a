"""Narrowing of given boxes: contraction over the requirements, with tables for values that have no inverse."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.feasibility.contraction import ALIVE
from engine.feasibility.slices import EVERY, MOST, Bench, Sliced
from engine.operators.intervals import Bools
from engine.tables import Floats, Ints

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
