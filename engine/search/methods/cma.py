"""CMA-ES, by Hansen's own package `cma` (an extra): a normal distribution that learns the shape of the risk.

Hansen (2016), "The CMA evolution strategy: a tutorial", arXiv:1604.00772.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.search.methods.cube import InCube
from engine.search.methods.extras import needed
from engine.search.protocol import Box, Operator, Proposal, Result, StreamAt, check_answer

STEP = 0.3
"""First standard deviation, of the unit interval."""


class CovarianceAdaptation(InCube):
    """An invalid or failed individual counts as worse than every valid one. A strategy that has converged starts anew
    from a random place.
    """

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        self._cma = needed("cma", "cmaes")
        super().__init__(box, population, streams)
        self._points: list[np.ndarray] = []
        self._strategy: Any = None

    def ask(self) -> list[Proposal]:
        self._generation += 1
        fresh = self._strategy is None
        if fresh:
            self._strategy = self._start()
        self._points = self._strategy.ask()
        operator = Operator.RANDOM if self._generation == 0 else Operator.SAMPLED
        return self._propose([point[: self._cube.size] for point in self._points], operator)

    def _start(self) -> Any:
        stream = self._streams(self._generation, 0)
        size = max(2, self._cube.size)  # the package knows no one-dimensional case
        options = {
            "popsize": self._population,
            "bounds": [[0.0] * size, [1.0] * size],
            "randn": lambda *shape: stream.standard_normal(shape),
            "seed": np.nan,
            "verbose": -9,
        }
        return self._cma.CMAEvolutionStrategy(stream.random(size), STEP, options)

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
        losses = [-result.continuous if result.selectable else np.inf for result in results]
        worst = max((loss for loss in losses if np.isfinite(loss)), default=0.0)
        self._strategy.tell(self._points, [loss if np.isfinite(loss) else worst + 1.0 for loss in losses])
        if self._strategy.stop():
            self._strategy = None
