"""Optimisers of other packages, by the protocol of plug-ins (`engine.search.searchers`): `make(box, config, streams)`.

They get the box as a unit cube and make the loss small: minus the objective, and where nothing is known of a genome one
more than the greatest loss of its generation. Packages come with `pip install -e '.[bench]'`. CMA-ES of `cma`, NSGA-II
of `pymoo` and the searches of `ribs` are methods of cortexc (`cmaes`, `nsga2`, `map_elites`, `cma_me`). Those of
`scipy.optimize` are missing: `differential_evolution` and `dual_annealing` call the function themselves and cannot be
asked; differential evolution is a method of ours. `NGOpt` of nevergrad 1.0.12 fails in `ask` with numpy 2.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from engine.config import Config
from engine.extras import needed
from engine.search.methods.cube import InCube
from engine.search.protocol import Box, Operator, Proposal, Result, Searcher, StreamAt
from engine.tables import Floats

EXTRA = "bench"
TREES = 50
CANDIDATES = 5_000
"""Random places, of which those of the most expected improvement are simulated."""


class Outside(InCube):
    """A generation of points, and then their losses; each package has its own `_points` and `_told`."""

    def __init__(self, box: Box, config: Config, streams: StreamAt) -> None:
        super().__init__(box, config.search.population, streams)
        self._seed = int(streams(0, 0).integers(1 << 31))

    def _proposals(self) -> list[Proposal]:
        points = np.clip(np.asarray(self._points(), dtype=np.float64), 0.0, 1.0)
        return self._at(points, Operator.SAMPLED)

    def _learn(self, results: Sequence[Result]) -> None:
        losses = np.array([-each.continuous if each.selectable else math.nan for each in results])
        worst = np.nanmax(losses) if np.isfinite(losses).any() else 0.0
        self._told(np.where(np.isnan(losses), worst + 1.0, losses))

    def _points(self) -> Any:
        raise NotImplementedError

    def _told(self, losses: Floats) -> None:
        raise NotImplementedError


class Optuna(Outside):
    """The tree-structured Parzen estimator, which takes what it has asked for and not been told for bad."""

    def __init__(self, box: Box, config: Config, streams: StreamAt) -> None:
        optuna = needed("optuna", "`optuna_tpe` needs", EXTRA)
        super().__init__(box, config, streams)
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        sampler = optuna.samplers.TPESampler(
            seed=self._seed, multivariate=True, constant_liar=True, warn_independent_sampling=False
        )
        self._study = optuna.create_study(sampler=sampler)
        self._ranges = {name: optuna.distributions.FloatDistribution(0.0, 1.0) for name in box.names}
        self._trials: list[Any] = []

    def _points(self) -> Any:
        self._trials = [self._study.ask(self._ranges) for _ in range(self._population)]
        return [list(trial.params.values()) for trial in self._trials]

    def _told(self, losses: Floats) -> None:
        for trial, loss in zip(self._trials, losses.tolist(), strict=True):
            self._study.tell(trial, loss)


class Nevergrad(Outside):
    """Its differential evolution with two-points crossover."""

    def __init__(self, box: Box, config: Config, streams: StreamAt) -> None:
        nevergrad = needed("nevergrad", "`nevergrad_de` needs", EXTRA)
        super().__init__(box, config, streams)
        space = nevergrad.p.Array(shape=(len(box),), lower=0.0, upper=1.0)
        space.random_state = np.random.RandomState(self._seed)
        budget = config.search.population * config.search.generations
        make = nevergrad.optimizers.TwoPointsDE
        self._optimizer = make(parametrization=space, budget=budget, num_workers=self._population)
        self._candidates: list[Any] = []

    def _points(self) -> Any:
        self._candidates = [self._optimizer.ask() for _ in range(self._population)]
        return [candidate.value for candidate in self._candidates]

    def _told(self, losses: Floats) -> None:
        for candidate, loss in zip(self._candidates, losses.tolist(), strict=True):
            self._optimizer.tell(candidate, loss)


class Pymoo(Outside):
    """The genetic algorithm for one objective; what it finds too few of is drawn at random, and not told."""

    def __init__(self, box: Box, config: Config, streams: StreamAt) -> None:
        ga = needed("pymoo.algorithms.soo.nonconvex.ga", "`pymoo_ga` needs", "search", "pymoo")
        problem = needed("pymoo.core.problem", "`pymoo_ga` needs", "search", "pymoo")
        super().__init__(box, config, streams)
        self._algorithm = ga.GA(pop_size=self._population)
        cube = problem.Problem(n_var=len(box), n_obj=1, xl=0.0, xu=1.0)
        self._algorithm.setup(cube, termination=("n_gen", math.inf), seed=self._seed, verbose=False)
        self._bred: Any = None

    def _points(self) -> Any:
        self._bred = self._algorithm.ask()
        bred = self._bred.get("X")
        rest = self._streams(self._generation, 1).random((self._population - len(bred), self._cube.size))
        return np.vstack([bred, rest])

    def _told(self, losses: Floats) -> None:
        self._bred.set("F", losses[: len(self._bred), np.newaxis])
        self._algorithm.tell(infills=self._bred)


class Trees(Outside):
    """A surrogate: extremely randomised trees, whose spread stands for what is not known; the most expected improvement
    on the least loss among random places.
    """

    def __init__(self, box: Box, config: Config, streams: StreamAt) -> None:
        self._ensemble = needed("sklearn.ensemble", "`extra_trees` needs", EXTRA, "scikit-learn")
        super().__init__(box, config, streams)
        self._seen, self._losses = np.zeros((0, len(box))), np.zeros(0)
        self._now = self._seen

    def _points(self) -> Any:
        places = self._streams(self._generation, 1).random((CANDIDATES, self._cube.size))
        if not len(self._seen):
            self._now = places[: self._population]
            return self._now
        trees = self._ensemble.ExtraTreesRegressor(TREES, min_samples_leaf=2, random_state=self._seed)
        trees.fit(self._seen, self._losses)
        guesses = np.array([tree.predict(places) for tree in trees.estimators_])
        # Of as many guesses as there are trees, by how much each is below the least loss: no shape is assumed.
        gain = np.maximum(self._losses.min() - guesses, 0.0).mean(axis=0)
        order = np.lexsort((guesses.mean(axis=0), -gain))
        self._now = places[order[: self._population]]
        return self._now

    def _told(self, losses: Floats) -> None:
        self._seen = np.vstack([self._seen, self._now])
        self._losses = np.concatenate([self._losses, losses])


Make = Callable[[Box, Config, StreamAt], Searcher]


OUTSIDE: dict[str, Make] = {
    "optuna_tpe": Optuna,
    "nevergrad_de": Nevergrad,
    "pymoo_ga": Pymoo,
    "extra_trees": Trees,
}
"""By the name under which their runs are kept."""
