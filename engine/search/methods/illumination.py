"""MAP-Elites and CMA-ME, by `ribs` (an extra): the riskiest run for every pair of speeds at closest approach.

Mouret and Clune (2015), "Illuminating search spaces by mapping elites", arXiv:1504.04909; Fontaine, Togelius,
Nikolaidis and Hoover (2020), "Covariance matrix adaptation for the rapid illumination of behavior space".
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.search.methods.cube import InCube
from engine.search.methods.extras import needed
from engine.search.protocol import Box, Operator, Proposal, Result, StreamAt, check_answer, measure

DESCRIPTORS = ("ego_speed", "other_speed")
"""Axes of the archive, both at closest approach."""
FASTEST = 30.0
"""End of both axes [m/s]; what is faster counts for the last cell."""
CELLS = 20
"""Along each axis: 1.5 m/s each."""
REJECTED = -1.0
"""Told for what has no risk; every true risk is at least 0, and the archive takes nothing below."""
STEP = 0.15
"""Standard deviation of a mutation, of the unit interval."""
BATCH = 20
"""Individuals that one evolution strategy of CMA-ME proposes, or a few more."""


class Illumination(InCube):
    """An invalid or failed individual is told with a risk that no cell takes. Generations are random until one has
    filled a cell.
    """

    def __init__(self, box: Box, population: int, streams: StreamAt, method: str) -> None:
        self._ribs = needed("ribs.archives", method), needed("ribs.emitters", method)
        super().__init__(box, population, streams)
        self._method = method
        self._points = np.empty((0, len(box)))
        self._bred = False
        self._archive: Any = None
        self._emitters: list[Any] = []
        if len(box):
            self._archive = self._grid()
            self._emitters = self._strategies() if method == "cma_me" and population > 1 else [self._mutation()]

    def _seed(self, slot: int) -> int:
        return int(self._streams(0, self._population + slot).integers(1 << 63))

    def _grid(self) -> Any:
        return self._ribs[0].GridArchive(
            solution_dim=self._cube.size,
            dims=[CELLS] * len(DESCRIPTORS),
            ranges=[(0.0, FASTEST)] * len(DESCRIPTORS),
            learning_rate=1.0,
            threshold_min=0.0,
            seed=self._seed(0),
        )

    def _mutation(self) -> Any:
        return self._ribs[1].GaussianEmitter(
            self._archive,
            sigma=STEP,
            x0=np.full(self._cube.size, 0.5),
            lower_bounds=np.zeros(self._cube.size),
            upper_bounds=np.ones(self._cube.size),
            batch_size=self._population,
            seed=self._seed(1),
        )

    def _strategies(self) -> list[Any]:
        """Evolution strategies that rank by what is new to the archive; together they propose one generation."""
        shares = np.array_split(np.arange(self._population), max(1, self._population // BATCH))
        return [
            self._ribs[1].EvolutionStrategyEmitter(
                self._archive,
                x0=np.full(self._cube.size, 0.5),
                sigma0=STEP,
                ranker="2imp",
                batch_size=len(share),
                seed=self._seed(1 + number),
            )
            for number, share in enumerate(shares)
        ]

    def ask(self) -> list[Proposal]:
        self._generation += 1
        self._bred = self._archive is not None and not self._archive.empty
        operator = Operator.RANDOM
        if self._bred:
            operator = Operator.SAMPLED if self._method == "cma_me" else Operator.MUTATION
            # A strategy keeps its own points; what lies outside the box is run, and stored, at the border.
            self._points = np.clip(np.concatenate([emitter.ask() for emitter in self._emitters]), 0.0, 1.0)
        else:
            self._points = self._streams(self._generation, 0).random((self._population, self._cube.size))
        return self._propose(self._points, operator)

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        if self._archive is None:
            return
        objective = np.array([result.continuous if result.selectable else REJECTED for result in results])
        rows = [[measure(result, name) for name in DESCRIPTORS] for result in results]
        measures = np.nan_to_num(np.array(rows))
        added = self._archive.add(self._points, objective, measures)
        if self._bred:
            self._tell_emitters(objective, measures, added)

    def _tell_emitters(self, objective: np.ndarray, measures: np.ndarray, added: dict[str, Any]) -> None:
        """Each hears of what it proposed."""
        shares = np.array_split(np.arange(self._population), len(self._emitters))
        for emitter, share in zip(self._emitters, shares, strict=True):
            told = {key: np.asarray(value)[share] for key, value in added.items()}
            emitter.tell(self._points[share], objective[share], measures[share], told)
