"""The paper's five evaluation metrics over a set of individuals: RL, NC, MDG, MDEC and NIS."""

from dataclasses import dataclass

import numpy as np

from engine.scenes import Bools
from engine.search.evaluations import Evaluations
from engine.vocabulary import Verdict


@dataclass(frozen=True)
class Figures:
    """Means are NaN where there is nothing to take the mean of. Runs are rollouts, of which a genome has k."""

    individuals: int
    valid: int
    rl: float
    """Mean fitness of valid individuals."""
    rl_all: float
    """The same with invalid individuals as -1."""
    nc: int
    """Individuals with at least one collision."""
    mdg: float
    """Mean MD of valid runs [m]."""
    mdec: float
    """Mean MD of valid runs without collision [m]."""
    nis: int
    """Invalid individuals: all their runs are."""
    errors: int
    """Individuals on which the engine failed; in no other figure."""
    runs: int
    valid_runs: int
    colliding_runs: int
    invalid_runs: int
    error_runs: int

    @property
    def collision_rate(self) -> float:
        """Collisions of valid runs; NaN without any."""
        return self.colliding_runs / self.valid_runs if self.valid_runs else float("nan")


def figures(evaluations: Evaluations, chosen: Bools) -> Figures:
    """The figures of the chosen rows (n,)."""
    verdict = evaluations.rollouts.verdict[chosen]
    valid_runs = verdict == Verdict.VALID
    collided = evaluations.rollouts.collided[chosen]
    distance = evaluations.rollouts.min_distance[chosen]
    fitness = evaluations.fitness[chosen]
    valid, errors = evaluations.valid[chosen], evaluations.failed[chosen]
    individuals, counted = len(valid), int((~errors).sum())
    nis = counted - int(valid.sum())
    total = float(fitness[valid].sum())
    return Figures(
        individuals=individuals,
        valid=counted - nis,
        rl=_ratio(total, counted - nis),
        rl_all=_ratio(total - nis, counted),
        nc=int(collided.any(axis=1).sum()),
        mdg=_mean(distance, valid_runs),
        mdec=_mean(distance, valid_runs & ~collided),
        nis=nis,
        errors=int(errors.sum()),
        runs=verdict.size,
        valid_runs=int(valid_runs.sum()),
        colliding_runs=int(collided.sum()),
        invalid_runs=int((~valid_runs & (verdict != Verdict.ERROR)).sum()),
        error_runs=int((verdict == Verdict.ERROR).sum()),
    )


def _mean(values: np.ndarray, chosen: Bools) -> float:
    return _ratio(float(values[chosen].sum()), int(chosen.sum()))


def _ratio(total: float, count: int) -> float:
    return total / count if count else float("nan")


@dataclass(frozen=True)
class GenerationFigures:
    """One generation: by individual, elites counted as the paper does; and by simulation, elites left out."""

    generation: int
    by_individual: Figures
    by_simulation: Figures


def generation_figures(evaluations: Evaluations, generation: int) -> GenerationFigures:
    """Figures of a table that holds one generation."""
    everyone = np.ones(len(evaluations), dtype=bool)
    return GenerationFigures(generation, figures(evaluations, everyone), figures(evaluations, evaluations.simulated))


def distinct_collisions(evaluations: Evaluations) -> int:
    """Different genomes that collided at least once: the primary outcome of a study."""
    rows = evaluations.simulated & evaluations.collided
    return len({genome.tobytes() for genome in evaluations.genomes[rows]})
