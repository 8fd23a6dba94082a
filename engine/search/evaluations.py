"""Every individual of a campaign, or of one generation of it, with all its simulations, and what follows from them:
the one number of its k rollouts, the paper's five evaluation metrics (RL, NC, MDG, MDEC and NIS) over a set of
individuals, and with whom the ego collided.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engine.errors import ArgumentError
from engine.outcomes import Assessment
from engine.search.assessment import map_arrays
from engine.search.protocol import MEASURES, Birth, Proposal, Result, Status
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

# -- one number for k rollouts -----------------------------------------------------------------------------------------


def aggregate(values: Floats, valid: Bools, how: str) -> Floats:
    """(n,) from (n, k): `mean`, `max` or `qNN` over the valid rollouts, NaN where none is.

    A quantile interpolates linearly between order statistics (Hyndman and Fan 1996, type 7).
    """
    level = quantile_level(how)
    result = np.full(len(values), np.nan)
    rows = valid.any(axis=1)
    known = np.where(valid[rows], values[rows], np.nan)
    if values.shape[1] == 1:
        result[rows] = known[:, 0]
    elif how == "mean":
        result[rows] = np.nanmean(known, axis=1)
    elif rows.any():
        result[rows] = np.nanmax(known, axis=1) if level is None else np.nanquantile(known, level, axis=1)
    return result


def quantile_level(how: str) -> float | None:
    """0.9 for `q90`, None for `mean` and `max`; ValueError for anything else."""
    if how in ("mean", "max"):
        return None
    match = re.fullmatch(r"q(\d+(?:\.\d+)?)", how)
    if match is None or not 0.0 <= float(match[1]) <= 100.0:
        raise ArgumentError(
            f"aggregate: expected mean, max or a quantile such as q90, got `{how}`", "name one of these"
        )
    return float(match[1]) / 100.0


# -- individuals -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Evaluations:
    """Row i is individual i, in the order of generations and of places in them.

    An elite's row repeats the keys and simulations of its birth and is marked `reused`. Rows with `reused` False are
    the campaign's distinct simulations.
    """

    genomes: Floats
    """(n, d) file units."""
    places: Ints
    """(n, 2) generation, place in it."""
    births: Ints
    """(n, 2) where the genome was first simulated; equals `places` unless reused."""
    operator: Ints
    """(n,) `protocol.Operator`"""
    parents: Ints
    """(n, 2, 2) births of up to two parents, -1 where none."""
    reused: Bools
    """(n,)"""
    verdict: Ints
    """(n,) VALID when any rollout is, else what befell the first of them."""
    fitness: Floats
    """(n,) the integer risk, or what is sought, aggregated over the valid rollouts; NaN where none is."""
    keys: Ints
    """(n, k, 6) stream keys."""
    rollouts: Assessment
    """Arrays (n, k, …)."""

    def __len__(self) -> int:
        return len(self.verdict)

    @cached_property
    def valid(self) -> Bools:
        """(n,)"""
        return np.equal(self.verdict, Verdict.VALID)

    @cached_property
    def scored(self) -> Bools:
        """(n,) that have a fitness: valid ones, and where these are sought those over which a controller failed."""
        return self.valid | (np.equal(self.verdict, Verdict.CONTROLLER) & np.isfinite(self.fitness))

    @cached_property
    def failed(self) -> Bools:
        """(n,) the engine failed: neither valid nor invalid, never scored."""
        return np.equal(self.verdict, Verdict.ERROR)

    @cached_property
    def collided(self) -> Bools:
        """(n,) at least one rollout collided."""
        return np.asarray(self.rollouts.collided.any(axis=1))

    @cached_property
    def found(self) -> Bools:
        """(n,) at least one rollout is what the search is for: it collided, where the risk is sought."""
        return np.asarray(self.rollouts.found.any(axis=1))

    @cached_property
    def worst_rollout(self) -> Ints:
        """(n,) the rollout with the largest score, then continuous score, then lowest number; where something else is
        sought, the one with the most of it.
        """
        if is_aimed(self.rollouts):
            return np.argmax(np.nan_to_num(goal_of(self.rollouts), nan=-np.inf), axis=1)
        score = self.rollouts.score.astype(np.float64)
        top = score == score.max(axis=1, keepdims=True)
        return np.argmax(np.where(top, np.nan_to_num(self.rollouts.continuous, nan=-1.0), -np.inf), axis=1)

    @cached_property
    def continuous(self) -> Floats:
        """(n,) continuous risk of the worst rollout, or how much it has of what is sought."""
        values = goal_of(self.rollouts) if is_aimed(self.rollouts) else self.rollouts.continuous
        return values[np.arange(len(self)), self.worst_rollout]

    @cached_property
    def score(self) -> Ints:
        """(n,) integer risk of the worst rollout, -1 invalid."""
        return self.rollouts.score[np.arange(len(self)), self.worst_rollout]

    @cached_property
    def min_distance(self) -> Floats:
        """(n,) least MD over the rollouts [m]; NaN where none is valid."""
        distances = np.where(self.rollouts.verdict == Verdict.VALID, self.rollouts.min_distance, np.inf).min(axis=1)
        return np.where(np.isinf(distances), np.nan, distances)

    @property
    def simulated(self) -> Bools:
        """(n,) rows that stand for simulations of their own."""
        return ~self.reused


def judge(rollouts: Assessment, how: str) -> tuple[Ints, Floats]:
    """Verdict and fitness (n,) of individuals from their rollouts (n, k).

    Invalid only when all k are; an error among rollouts of which none is valid makes the individual an error.
    """
    valid = counted(rollouts)
    failed = (rollouts.verdict == Verdict.ERROR).any(axis=1)
    verdict = np.where(failed, int(Verdict.ERROR), rollouts.verdict[:, 0])
    verdict = np.where((rollouts.verdict == Verdict.VALID).any(axis=1), int(Verdict.VALID), verdict).astype(np.int32)
    return verdict, aggregate(goal_of(rollouts), valid, how)


def counted(rollouts: Assessment) -> Bools:
    """(n, k) simulations that fitness is made of: valid ones, and where such scenes are sought those over which a
    controller failed.
    """
    sought = (rollouts.verdict == Verdict.CONTROLLER) & is_aimed(rollouts) & np.isfinite(goal_of(rollouts))
    return (rollouts.verdict == Verdict.VALID) | sought


def is_aimed(rollouts: Assessment) -> bool:
    """Whether something else than the risk alone is sought."""
    return rollouts.sought.shape[-1] > 0


def goal_of(rollouts: Assessment) -> Floats:
    """(n, k) the first of what is sought: the integer risk where nothing else is."""
    return rollouts.sought[..., 0] if is_aimed(rollouts) else rollouts.score.astype(np.float64)


def results(evaluations: Evaluations) -> list[Result]:
    """Return what a searcher's `tell` gets, one result a row."""
    status = map(_status, evaluations.verdict.tolist(), evaluations.reused.tolist(), evaluations.fitness.tolist())
    columns = evaluations.fitness, evaluations.verdict, evaluations.continuous, evaluations.found
    each = np.arange(len(evaluations)), evaluations.worst_rollout
    sought = evaluations.rollouts.sought[each].tolist()
    rows = zip(status, *(column.tolist() for column in columns), _measures(evaluations), sought, strict=True)
    return [
        Result(state, fitness, Verdict(verdict), continuous, found, tuple(measures), tuple(values))
        for state, fitness, verdict, continuous, found, measures, values in rows
    ]


def _measures(evaluations: Evaluations) -> list[list[float]]:
    """One row of `MEASURES` an individual."""
    place = np.arange(len(evaluations)), evaluations.worst_rollout
    return np.stack([getattr(evaluations.rollouts, name)[place] for name in MEASURES], axis=1).tolist()


def _status(verdict: int, reused: bool, fitness: float) -> Status:
    if reused:
        return Status.REUSED
    if verdict == Verdict.ERROR:
        return Status.ERROR
    sought = verdict == Verdict.CONTROLLER and not math.isnan(fitness)
    return Status.VALID if verdict == Verdict.VALID or sought else Status.INVALID


def parent_rows(proposals: Sequence[Proposal]) -> Ints:
    """(n, 2, 2) births of the parents, -1 where there is none."""
    none = Birth(-1, -1)
    rows = [(*proposal.parents, none, none)[:2] for proposal in proposals]
    return np.array(rows, dtype=np.int32).reshape(len(rows), 2, 2)


def flat_rollouts(evaluations: Evaluations) -> Assessment:
    """All simulations under one another, arrays (n * k, …)."""
    size = evaluations.rollouts.verdict.size
    return map_arrays(evaluations.rollouts, lambda array: array.reshape(size, *array.shape[2:]))


# -- figures -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Figures:
    """Means are NaN where there is nothing to take the mean of. Runs are rollouts, of which a genome has k."""

    individuals: int
    valid: int
    rl: float
    """Mean fitness of individuals that have one: valid ones (see `Evaluations.scored`)."""
    rl_all: float
    """The same with all others as -1."""
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
    scored = evaluations.scored[chosen]
    total, scores = float(fitness[scored].sum()), int(scored.sum())
    individuals, counted = len(valid), int((~errors).sum())
    nis = counted - int(valid.sum())
    return Figures(
        individuals=individuals,
        valid=counted - nis,
        rl=_ratio(total, scores),
        rl_all=_ratio(total - (counted - scores), counted),
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
    """Different genomes that collided at least once: the yield of a search."""
    return _different_genomes(evaluations, evaluations.collided)


def distinct_finds(evaluations: Evaluations) -> int:
    """Different genomes that came at least once to what was sought."""
    return _different_genomes(evaluations, evaluations.found)


def _different_genomes(evaluations: Evaluations, chosen: Bools) -> int:
    return len({genome.tobytes() for genome in evaluations.genomes[evaluations.simulated & chosen]})


# -- partners in collisions --------------------------------------------------------------------------------------------

NOBODY = -1


@dataclass(frozen=True)
class Partners:
    """Collisions by who met. The pair that decides the risk is the one that touched: contact outweighs all else."""

    with_ego: tuple[int, ...]
    """Distinct simulations in which the ego touched actor 1, actor 2, …"""
    without_ego: int
    """Distinct simulations in which two others touched, before the ego touched anybody if it did."""


NO_PARTNERS = Partners((), 0)
"""Of an ego alone."""


def partners(evaluations: Evaluations, actors: int) -> Partners:
    """The collisions of a search among so many actors."""
    new = evaluations.simulated
    met = partner_of(evaluations)[new]
    others = np.isfinite(evaluations.rollouts.others_contact_time[new])
    return Partners(tuple(int((met == pair).sum()) for pair in range(actors - 1)), int(others.sum()))


def partner_of(evaluations: Evaluations) -> np.ndarray:
    """(n, k) the pair (ego, actor pair + 1) that touched, `NOBODY` where the ego did not."""
    return np.where(evaluations.rollouts.collided, evaluations.rollouts.pair, NOBODY)
