"""Differential evolution, DE/rand/1/bin: the difference of two members, added to a third, crossed with a fourth.

Storn and Price (1997), "Differential evolution: a simple and efficient heuristic for global optimization over
continuous spaces"; F = 0.5 and CR = 0.9 are their first suggestion.
"""

from collections.abc import Sequence

import numpy as np

from engine.search.methods.annealing import reflected
from engine.search.methods.cube import InCube
from engine.search.protocol import Birth, Box, Operator, Proposal, Result, StreamAt, check_answer
from engine.tables import Floats

WEIGHT = 0.5
CROSSOVER = 0.9


class DifferentialEvolution(InCube):
    """A trial replaces its target when it is valid and at least as risky; an invalid target yields to any trial."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._trials = np.empty((0, len(box)))
        self._members = np.empty((0, len(box)))
        self._births: list[Birth] = []
        self._value = np.full(population, -np.inf)

    def ask(self) -> list[Proposal]:
        self._generation += 1
        rows = [self._trial(slot) for slot in range(self._population)]
        self._trials = np.array([point for point, _ in rows]).reshape(self._population, self._cube.size)
        operator = Operator.CROSSOVER if self._generation else Operator.RANDOM
        self._asked = [
            Proposal(self._cube.genome(point), operator, Birth(self._generation, slot), parents)
            for slot, (point, parents) in enumerate(rows)
        ]
        return self._asked

    def _trial(self, slot: int) -> tuple[Floats, tuple[Birth, ...]]:
        stream = self._streams(self._generation, slot)
        if not len(self._members) or self._population < 4:
            return stream.random(self._cube.size), ()
        others = [member for member in range(self._population) if member != slot]
        base, plus, minus = (int(i) for i in stream.choice(others, size=3, replace=False))
        mutant = reflected(self._members[base] + WEIGHT * (self._members[plus] - self._members[minus]))
        crossed = stream.random(self._cube.size) < CROSSOVER
        if self._cube.size:
            crossed[int(stream.random() * self._cube.size)] = True
        return np.where(crossed, mutant, self._members[slot]), (self._births[slot], self._births[base])

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        if not len(self._members):
            self._members = self._trials.copy()
            self._births = [proposal.birth for proposal in self._asked]
        for slot, result in enumerate(results):
            value = result.continuous if result.selectable else -np.inf
            if value >= self._value[slot]:
                self._members[slot], self._value[slot] = self._trials[slot], value
                self._births[slot] = self._asked[slot].birth
