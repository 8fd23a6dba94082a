"""Simulated annealing: every place of a generation is a walker of its own, and all cool down together.

Kirkpatrick, Gelatt and Vecchi (1983), "Optimization by simulated annealing". A walker steps to a normal neighbour
whose width shrinks with the temperature; it stays where it is with probability 1 - exp(-loss / temperature).
"""

from collections.abc import Sequence
from math import exp

import numpy as np

from engine.search.methods.cube import InCube
from engine.search.protocol import Birth, Box, Genome, Operator, Proposal, Result, StreamAt, check_answer

HOT, COLD = 4.0, 0.1
"""First and last temperature, in points of risk."""
WIDE, NARROW = 0.3, 0.03
"""First and last width of a step, of the unit interval."""
CHANGED = 0.5
"""Share of the genes that a step changes, one at least."""


class Annealing(InCube):
    """An invalid or failed place is never stepped to; a walker that has found none yet starts anew at random."""

    def __init__(self, box: Box, population: int, generations: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._cooling = max(1, generations - 1)
        self._at: list[tuple[Genome, Birth, float] | None] = [None] * population

    def ask(self) -> list[Proposal]:
        self._generation += 1
        self._asked = [self._proposal(slot) for slot in range(self._population)]
        return self._asked

    def _proposal(self, slot: int) -> Proposal:
        stream = self._streams(self._generation, slot)
        birth = Birth(self._generation, slot)
        here = self._at[slot]
        if here is None:
            return Proposal(self._cube.genome(stream.random(self._cube.size)), Operator.RANDOM, birth)
        genome, parent, _ = here
        moved = stream.random(self._cube.size) < CHANGED
        if self._cube.size:
            moved[int(stream.random() * self._cube.size)] = True
        steps = stream.standard_normal(self._cube.size) * self._between(WIDE, NARROW) * moved
        return Proposal(
            self._cube.genome(reflected(self._cube.point(genome) + steps)), Operator.MUTATION, birth, (parent,)
        )

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        temperature = self._between(HOT, COLD)
        for slot, (proposal, result) in enumerate(zip(self._asked, results, strict=True)):
            here = self._at[slot]
            if not result.selectable:
                continue
            # A number of the walker's own stream, behind those that made the step.
            chance = self._streams(self._generation, self._population + slot).random()
            if here is None or chance < exp(min(0.0, (result.continuous - here[2]) / temperature)):
                self._at[slot] = (proposal.genome, proposal.birth, result.continuous)

    def _between(self, first: float, last: float) -> float:
        """The value of this generation on a geometric way from the first to the last."""
        return first * (last / first) ** min(1.0, self._generation / self._cooling)


def reflected(point: np.ndarray) -> np.ndarray:
    """A point brought back into the unit cube by mirrors at its faces."""
    folded = np.mod(point, 2.0)
    return np.where(folded > 1.0, 2.0 - folded, folded)
