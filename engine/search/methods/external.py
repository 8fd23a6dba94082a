"""Methods of other packages (extras), in the unit cube: CMA-ES by `cma`, NSGA-II by `pymoo`, MAP-Elites and CMA-ME by
`ribs`.

CMA-ES, by Hansen's own package: a normal distribution that learns the shape of the risk. Hansen (2016), "The CMA
evolution strategy: a tutorial", arXiv:1604.00772.

NSGA-II: runs that are close *and* fast, without one number that weighs both. Deb, Pratap, Agarwal and Meyarivan (2002),
"A fast and elitist multiobjective genetic algorithm: NSGA-II".

MAP-Elites and CMA-ME: the riskiest run for every pair of speeds at closest approach. Mouret and Clune (2015),
"Illuminating search spaces by mapping elites", arXiv:1504.04909; Fontaine, Togelius, Nikolaidis and Hoover (2020),
"Covariance matrix adaptation for the rapid illumination of behavior space".
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.extras import needed
from engine.kernels.jit import KERNELS, cache_folder, is_known
from engine.search.methods.cube import InCube
from engine.search.protocol import Birth, Box, Operator, Proposal, Result, StreamAt, measure
from engine.tables import Floats

CMAES_STEP = 0.3
"""First standard deviation, of the unit interval."""


class CovarianceAdaptation(InCube):
    """An invalid or failed individual is worse than any valid one. A converged strategy restarts at a random place."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        self._cma = needed("cma", "`cmaes` needs", "search")
        super().__init__(box, population, streams)
        self._points: list[np.ndarray] = []
        self._strategy: Any = None

    def _proposals(self) -> list[Proposal]:
        fresh = self._strategy is None
        if fresh:
            self._strategy = self._start()
        self._points = self._strategy.ask()
        operator = Operator.RANDOM if self._generation == 0 else Operator.SAMPLED
        return self._at(np.array(self._points)[:, : self._cube.size], operator)

    def _start(self) -> Any:
        stream = self._streams(self._generation, 0)
        size = max(2, self._cube.size)  # the package requires two dimensions

        def normal(*shape: int) -> Floats:
            return stream.standard_normal(shape)

        options: dict[str, Any] = {
            "popsize": self._population,
            "bounds": [[0.0] * size, [1.0] * size],
            "randn": normal,
            "seed": np.nan,
            "verbose": -9,
        }
        return self._cma.CMAEvolutionStrategy(stream.random(size), CMAES_STEP, options)

    def _learn(self, results: Sequence[Result]) -> None:
        losses = [-result.continuous if result.selectable else np.inf for result in results]
        worst = max((loss for loss in losses if np.isfinite(loss)), default=0.0)
        self._strategy.tell(self._points, [loss if np.isfinite(loss) else worst + 1.0 for loss in losses])
        if self._strategy.stop():
            self._strategy = None


# -- NSGA-II -----------------------------------------------------------------------------------------------------------

OBJECTIVES = (("min_distance", 1.0), ("closing_speed", -1.0))
"""Measures and the signs with which they are minimized."""
WORST = 1e9
"""Value of an objective that does not exist; the constraint excludes it from every front."""


class NonDominatedSorting(InCube):
    """An invalid or failed individual violates a constraint, so every valid individual is preferred.

    If the package finds fewer new individuals than a generation holds, the rest is random and is not passed to it.
    """

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        super().__init__(box, population, streams)
        self._bred: Any = None
        self._aims = 0
        self._algorithm: Any = self._start() if len(box) else None

    def seek(self, aims: int) -> None:
        """Look for several objectives instead of those of its own."""
        if aims > 0 and self._algorithm is not None:
            self._aims = aims
            self._algorithm = self._start()

    def _start(self) -> Any:
        problem = needed("pymoo.core.problem", "`nsga2` needs", "search").Problem(
            n_var=self._cube.size, n_obj=self._aims or len(OBJECTIVES), n_ieq_constr=1, xl=0.0, xu=1.0
        )
        algorithm = needed("pymoo.algorithms.moo.nsga2", "`nsga2` needs", "search").NSGA2(pop_size=self._population)
        endless = needed("pymoo.core.termination", "`nsga2` needs", "search").NoTermination()
        seed = int(self._streams(0, 0).integers(1 << 63))
        return algorithm.setup(problem, termination=endless, seed=seed, verbose=False)

    def _proposals(self) -> list[Proposal]:
        self._bred = self._algorithm.ask() if self._algorithm is not None else None
        points = self._bred.get("X") if self._bred is not None else np.empty((0, self._cube.size))
        missing = self._population - len(points)
        drawn = self._streams(self._generation, 1).random((missing, self._cube.size))
        bred = Operator.CROSSOVER_MUTATION if self._generation else Operator.RANDOM
        operators = [bred] * len(points) + [Operator.RANDOM] * missing
        genomes = self._cube.genomes(np.concatenate([points, drawn]))
        return [
            Proposal(genome, operator, Birth(self._generation, slot))
            for slot, (genome, operator) in enumerate(zip(genomes, operators, strict=True))
        ]

    def _learn(self, results: Sequence[Result]) -> None:
        if self._bred is None or not len(self._bred):
            return
        own = results[: len(self._bred)]
        broken = np.array([[0.0 if result.selectable else 1.0] for result in own])
        static = needed("pymoo.problems.static", "`nsga2` needs", "search").StaticProblem
        problem = static(self._algorithm.problem, F=losses(own) if self._aims else objectives(own), G=broken)
        self._algorithm.evaluator.eval(problem, self._bred)
        self._algorithm.tell(infills=self._bred)


def objectives(results: Sequence[Result]) -> Floats:
    """Return (n, 2) the minimized values: the least distance, and the negative closing speed."""
    rows = [[sign * measure(result, name) for name, sign in OBJECTIVES] for result in results]
    return np.nan_to_num(np.array(rows).reshape(len(rows), len(OBJECTIVES)), nan=WORST)


def losses(results: Sequence[Result]) -> Floats:
    """Return (n, objectives) the negative objectives, which the method minimizes."""
    return np.nan_to_num(-np.array([result.objective_values for result in results]), nan=WORST)


# -- MAP-Elites and CMA-ME ---------------------------------------------------------------------------------------------

DESCRIPTORS = ("ego_speed", "other_speed")
"""Axes of the archive, both at closest approach."""
FASTEST = 30.0
"""End of both axes [m/s]; faster runs count for the last cell."""
CELLS = 20
"""Along each axis: 1.5 m/s each."""
REJECTED = -1.0
"""Passed on for results without risk; every true risk is at least 0, and the archive takes nothing below."""
EMITTER_STEP = 0.15
"""Standard deviation of a mutation, of the unit interval."""
BATCH = 20
"""Individuals that one evolution strategy of CMA-ME proposes, or a few more."""


def store_compiled(owner: type) -> None:
    """Store machine code of the static methods of a class that numba compiles on their first call: 4 s for `ribs`."""
    import numba

    if not is_known(numba.__version__):
        return
    from engine.kernels.numba_internals import cache_by_content

    methods: list[Any] = [each.__func__ for each in vars(owner).values() if isinstance(each, staticmethod)]
    for method in methods:
        if hasattr(method, "py_func"):
            cache_by_content(method, method.py_func, cache_folder(), KERNELS)


class Illumination(InCube):
    """An invalid or failed individual is passed on with a risk that no cell accepts. Generations are random until one
    of them has filled a cell.
    """

    def __init__(self, box: Box, population: int, streams: StreamAt, method: str) -> None:
        who = f"`{method}` needs"
        self._ribs = needed("ribs.archives", who, "search"), needed("ribs.emitters", who, "search")
        if method == "cma_me":
            store_compiled(needed("ribs.emitters.opt", who, "search").CMAEvolutionStrategy)
        super().__init__(box, population, streams)
        self._method = method
        self._points = np.empty((0, len(box)))
        self._bred = False
        self._archive: Any = None
        self._emitters: list[Any] = []
        self._rejected = REJECTED
        if len(box):
            self._archive = self._grid()
            self._emitters = self._strategies() if method == "cma_me" and population > 1 else [self._mutation()]

    def seek(self, aims: int) -> None:
        """Fill cells by the first objective, which may be less than 0."""
        if aims > 0 and self._archive is not None:
            self._rejected = -WORST
            self._archive = self._grid(threshold=0.5 * self._rejected)
            ribs = self._method == "cma_me" and self._population > 1
            self._emitters = self._strategies() if ribs else [self._mutation()]

    def _seed(self, slot: int) -> int:
        return int(self._streams(0, self._population + slot).integers(1 << 63))

    def _grid(self, threshold: float = 0.0) -> Any:
        return self._ribs[0].GridArchive(
            solution_dim=self._cube.size,
            dims=[CELLS] * len(DESCRIPTORS),
            ranges=[(0.0, FASTEST)] * len(DESCRIPTORS),
            learning_rate=1.0,
            threshold_min=threshold,
            seed=self._seed(0),
        )

    def _mutation(self) -> Any:
        return self._ribs[1].GaussianEmitter(
            self._archive,
            sigma=EMITTER_STEP,
            x0=np.full(self._cube.size, 0.5),
            lower_bounds=np.zeros(self._cube.size),
            upper_bounds=np.ones(self._cube.size),
            batch_size=self._population,
            seed=self._seed(1),
        )

    def _strategies(self) -> list[Any]:
        """Return evolution strategies that rank by novelty to the archive; together they propose one generation."""
        shares = np.array_split(np.arange(self._population), max(1, self._population // BATCH))
        return [
            self._ribs[1].EvolutionStrategyEmitter(
                self._archive,
                x0=np.full(self._cube.size, 0.5),
                sigma0=EMITTER_STEP,
                ranker="2imp",
                batch_size=len(share),
                seed=self._seed(1 + number),
            )
            for number, share in enumerate(shares)
        ]

    def _proposals(self) -> list[Proposal]:
        self._bred = self._archive is not None and not self._archive.empty
        operator = Operator.RANDOM
        if self._bred:
            operator = Operator.SAMPLED if self._method == "cma_me" else Operator.MUTATION
            # A strategy keeps its own points; a point outside the box is run, and stored, at the border.
            self._points = np.clip(np.concatenate([emitter.ask() for emitter in self._emitters]), 0.0, 1.0)
        else:
            self._points = self._streams(self._generation, 0).random((self._population, self._cube.size))
        return self._at(self._points, operator)

    def _learn(self, results: Sequence[Result]) -> None:
        if self._archive is None:
            return
        objective = np.array([result.continuous if result.selectable else self._rejected for result in results])
        rows = [[measure(result, name) for name in DESCRIPTORS] for result in results]
        measures = np.nan_to_num(np.array(rows))
        added = self._archive.add(self._points, objective, measures)
        if self._bred:
            self._share_out(objective, measures, added)

    def _share_out(self, objective: np.ndarray, measures: np.ndarray, added: dict[str, Any]) -> None:
        """Pass to each emitter the results of its own proposals."""
        shares = np.array_split(np.arange(self._population), len(self._emitters))
        for emitter, share in zip(self._emitters, shares, strict=True):
            own = {key: np.asarray(value)[share] for key, value in added.items()}
            emitter.tell(self._points[share], objective[share], measures[share], own)
