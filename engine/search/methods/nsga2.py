"""NSGA-II, by the package `pymoo` (an extra): runs that are close *and* fast, no one number to decide between the two.

Deb, Pratap, Agarwal and Meyarivan (2002), "A fast and elitist multiobjective genetic algorithm: NSGA-II".
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.search.methods.cube import InCube
from engine.search.methods.extras import needed
from engine.search.protocol import Birth, Box, Operator, Proposal, Result, StreamAt, check_answer, measure
from engine.tables import Floats

OBJECTIVES = (("min_distance", 1.0), ("closing_speed", -1.0))
"""Measures and their signs: what is made small."""
WORST = 1e9
"""Stands for an objective that does not exist; the constraint keeps it out of every front."""


class NonDominatedSorting(InCube):
    """An invalid or failed individual breaks a constraint, so that any valid one is preferred to it.

    Where the package finds fewer new individuals than a generation holds, the rest is drawn at random and not told.
    """

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._bred: Any = None
        self._algorithm: Any = self._start() if len(box) else None

    def _start(self) -> Any:
        problem = needed("pymoo.core.problem", "nsga2").Problem(
            n_var=self._cube.size, n_obj=len(OBJECTIVES), n_ieq_constr=1, xl=0.0, xu=1.0
        )
        algorithm = needed("pymoo.algorithms.moo.nsga2", "nsga2").NSGA2(pop_size=self._population)
        endless = needed("pymoo.core.termination", "nsga2").NoTermination()
        seed = int(self._streams(0, 0).integers(1 << 63))
        return algorithm.setup(problem, termination=endless, seed=seed, verbose=False)

    def ask(self) -> list[Proposal]:
        self._generation += 1
        self._bred = self._algorithm.ask() if self._algorithm is not None else None
        points = self._bred.get("X") if self._bred is not None else np.empty((0, self._cube.size))
        missing = self._population - len(points)
        drawn = self._streams(self._generation, 1).random((missing, self._cube.size))
        bred = Operator.CROSSOVER_MUTATION if self._generation else Operator.RANDOM
        operators = [bred] * len(points) + [Operator.RANDOM] * missing
        genomes = self._cube.genomes(np.concatenate([points, drawn]))
        self._asked = [
            Proposal(genome, operator, Birth(self._generation, slot))
            for slot, (genome, operator) in enumerate(zip(genomes, operators, strict=True))
        ]
        return self._asked

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        if self._bred is None or not len(self._bred):
            return
        told = results[: len(self._bred)]
        broken = np.array([[0.0 if result.selectable else 1.0] for result in told])
        static = needed("pymoo.problems.static", "nsga2").StaticProblem
        problem = static(self._algorithm.problem, F=objectives(told), G=broken)
        self._algorithm.evaluator.eval(problem, self._bred)
        self._algorithm.tell(infills=self._bred)


def objectives(results: Sequence[Result]) -> Floats:
    """(n, 2) what is made small: the least distance, and the closing speed with its sign turned."""
    rows = [[sign * measure(result, name) for name, sign in OBJECTIVES] for result in results]
    return np.nan_to_num(np.array(rows).reshape(len(rows), len(OBJECTIVES)), nan=WORST)
