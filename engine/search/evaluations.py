"""The individuals of a campaign or of one generation, with all their simulations, and the numbers that follow from
them:
the aggregate of k rollouts, the paper's metrics (RL, NC, MDG, MDEC and NIS) over a set of individuals, and the actors
with which the ego collided.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engine.assessment import map_arrays
from engine.errors import ArgumentError
from engine.outcomes import Assessment
from engine.search.protocol import MEASURES, Birth, Proposal, Result, Status
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

# -- one number for k rollouts -----------------------------------------------------------------------------------------


def aggregate(values: Floats, valid: Bools, how: str) -> Floats:
    """Return (n,) from (n, k) the `mean`, `max` or `qNN` over the valid rollouts; NaN without a valid rollout.

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
    """Return 0.9 for `q90` and None for `mean` and `max`; raise ArgumentError for any other text."""
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
    """Individuals, one per row, by generation and by place within it. An elite's row repeats the keys and simulations
    of its birth, with `reused` True; all other rows are the distinct simulations of the campaign.
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
    """(n,) VALID if any rollout is valid, else the verdict of the first rollout."""
    fitness: Floats
    """(n,) Integer risk, or first objective, aggregated over the valid rollouts; NaN without a valid rollout."""
    keys: Ints
    """(n, k, 6) stream keys."""
    rollouts: Assessment
    """Arrays (n, k, …)."""

    def __len__(self) -> int:
        return len(self.verdict)

    @cached_property
    def valid(self) -> Bools:
        """Return (n,) True for individuals with a valid verdict."""
        return np.equal(self.verdict, Verdict.VALID)

    @cached_property
    def scored(self) -> Bools:
        """Return (n,) True for individuals with a fitness: valid ones, and failed controllers with an objective."""
        return self.valid | (np.equal(self.verdict, Verdict.CONTROLLER) & np.isfinite(self.fitness))

    @cached_property
    def failed(self) -> Bools:
        """Return (n,) True if the engine failed: neither valid nor invalid, never scored."""
        return np.equal(self.verdict, Verdict.ERROR)

    @cached_property
    def collided(self) -> Bools:
        """Return (n,) True where at least one rollout collided."""
        return np.asarray(self.rollouts.collided.any(axis=1))

    @cached_property
    def found(self) -> Bools:
        """Return (n,) True where at least one rollout is a find; a collision if the objective is the risk."""
        return np.asarray(self.rollouts.found.any(axis=1))

    @cached_property
    def worst_rollout(self) -> Ints:
        """Return (n,) the rollout of largest score, then continuous score, then lowest number; else of the first
        objective.
        """
        if is_aimed(self.rollouts):
            return np.argmax(np.nan_to_num(goal_of(self.rollouts), nan=-np.inf), axis=1)
        score = self.rollouts.score.astype(np.float64)
        top = score == score.max(axis=1, keepdims=True)
        return np.argmax(np.where(top, np.nan_to_num(self.rollouts.continuous, nan=-1.0), -np.inf), axis=1)

    @cached_property
    def continuous(self) -> Floats:
        """Return (n,) the continuous risk, or the first objective, of the worst rollout."""
        values = goal_of(self.rollouts) if is_aimed(self.rollouts) else self.rollouts.continuous
        return values[np.arange(len(self)), self.worst_rollout]

    @cached_property
    def score(self) -> Ints:
        """Return (n,) the integer risk of the worst rollout; -1 if invalid."""
        return self.rollouts.score[np.arange(len(self)), self.worst_rollout]

    @cached_property
    def min_distance(self) -> Floats:
        """Return (n,) the least MD over the rollouts [m]; NaN if none is valid."""
        distances = np.where(self.rollouts.verdict == Verdict.VALID, self.rollouts.min_distance, np.inf).min(axis=1)
        return np.where(np.isinf(distances), np.nan, distances)

    @cached_property
    def first_alike(self) -> Ints:
        """Return (n,) the first row with the same genome as each row."""
        return first_alike(self.genomes)

    @property
    def simulated(self) -> Bools:
        """Return (n,) True for rows that have simulations of their own."""
        return ~self.reused


def judge(rollouts: Assessment, how: str) -> tuple[Ints, Floats]:
    """Return verdict and fitness (n,) of individuals from their rollouts (n, k).

    An individual is invalid if all k are; an error among rollouts without a valid one makes the individual an error.
    """
    valid = counted(rollouts)
    failed = (rollouts.verdict == Verdict.ERROR).any(axis=1)
    verdict = np.where(failed, int(Verdict.ERROR), rollouts.verdict[:, 0])
    verdict = np.where((rollouts.verdict == Verdict.VALID).any(axis=1), int(Verdict.VALID), verdict).astype(np.int32)
    return verdict, aggregate(goal_of(rollouts), valid, how)


def counted(rollouts: Assessment) -> Bools:
    """Return (n, k) True for simulations in the fitness: valid ones, and failures of a controller with a value."""
    failures = (rollouts.verdict == Verdict.CONTROLLER) & is_aimed(rollouts) & np.isfinite(goal_of(rollouts))
    return (rollouts.verdict == Verdict.VALID) | failures


def is_aimed(rollouts: Assessment) -> bool:
    """Return True if the search has objectives other than the risk alone."""
    return rollouts.sought.shape[-1] > 0


def goal_of(rollouts: Assessment) -> Floats:
    """Return (n, k) the first objective; the integer risk if there is none."""
    return rollouts.sought[..., 0] if is_aimed(rollouts) else rollouts.score.astype(np.float64)


def results(evaluations: Evaluations) -> list[Result]:
    """Return the results that a searcher's `tell` expects, one per row."""
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
    """Return one list of `MEASURES` per individual, of its worst rollout."""
    place = np.arange(len(evaluations)), evaluations.worst_rollout
    return np.stack([getattr(evaluations.rollouts, name)[place] for name in MEASURES], axis=1).tolist()


def _status(verdict: int, reused: bool, fitness: float) -> Status:
    if reused:
        return Status.REUSED
    if verdict == Verdict.ERROR:
        return Status.ERROR
    is_failure = verdict == Verdict.CONTROLLER and not math.isnan(fitness)
    return Status.VALID if verdict == Verdict.VALID or is_failure else Status.INVALID


def parent_rows(proposals: Sequence[Proposal]) -> Ints:
    """Return (n, 2, 2) the births of the parents; -1 for a missing parent."""
    none = Birth(-1, -1)
    rows = [(*proposal.parents, none, none)[:2] for proposal in proposals]
    return np.array(rows, dtype=np.int32).reshape(len(rows), 2, 2)


def flat_rollouts(evaluations: Evaluations) -> Assessment:
    """Return all simulations as one table with arrays (n * k, …)."""
    size = evaluations.rollouts.verdict.size
    return map_arrays(evaluations.rollouts, lambda array: array.reshape(size, *array.shape[2:]))


# -- figures -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Figures:
    """Evaluation metrics of a set of individuals. A mean over nothing is NaN. A run is one of the k rollouts of a
    genome.
    """

    individuals: int
    valid: int
    rl: float
    """Mean fitness of the individuals that have a fitness: valid ones (see `Evaluations.scored`)."""
    rl_all: float
    """Mean fitness of all individuals, where those without a fitness count as -1."""
    nc: int
    """Individuals with at least one collision."""
    mdg: float
    """Mean MD of valid runs [m]."""
    mdec: float
    """Mean MD of valid runs without collision [m]."""
    nis: int
    """Invalid individuals: all their runs are."""
    errors: int
    """Individuals for which the engine failed; no other figure counts them."""
    runs: int
    valid_runs: int
    colliding_runs: int
    invalid_runs: int
    error_runs: int

    @property
    def collision_rate(self) -> float:
        """Return collisions / valid runs; NaN without valid runs."""
        return self.colliding_runs / self.valid_runs if self.valid_runs else float("nan")


def figures(evaluations: Evaluations, chosen: Bools) -> Figures:
    """Return the figures of the chosen rows (n,)."""
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
    """Figures of one generation: by individual, elites included as in the paper; and by simulation, without elites."""

    generation: int
    by_individual: Figures
    by_simulation: Figures


def generation_figures(evaluations: Evaluations, generation: int) -> GenerationFigures:
    """Return the figures of a table that holds one generation."""
    everyone = np.ones(len(evaluations), dtype=bool)
    return GenerationFigures(generation, figures(evaluations, everyone), figures(evaluations, evaluations.simulated))


def distinct_collisions(evaluations: Evaluations) -> int:
    """Return the number of different genomes that collided at least once: the yield of a search."""
    return _different_genomes(evaluations, evaluations.collided)


def distinct_finds(evaluations: Evaluations) -> int:
    """Return the number of different genomes with at least one find."""
    return _different_genomes(evaluations, evaluations.found)


def _different_genomes(evaluations: Evaluations, chosen: Bools) -> int:
    alike = evaluations.first_alike[evaluations.simulated & chosen]
    there = np.zeros(len(evaluations), dtype=bool)
    there[alike] = True
    return int(there.sum())


MIX = (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9)
"""Odd factors of SplitMix64 (Steele, Lea and Flood, 2014)."""


def first_alike(genomes: Floats) -> Ints:
    """Return (n,) the first row of (n, d) with the same bits as each row."""
    bits = np.ascontiguousarray(genomes).view(np.uint64)
    mixed = np.zeros(len(bits), dtype=np.uint64)
    for column in bits.T:
        mixed = (mixed ^ column) * np.uint64(MIX[0])
        mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(MIX[1])
    _, first, inverse = np.unique(mixed, return_index=True, return_inverse=True)
    if (bits[first[inverse]] != bits).any():  # two genomes with one number: one of some 10^19
        _, first, inverse = np.unique(bits, axis=0, return_index=True, return_inverse=True)
    return first[inverse.ravel()]


# -- partners in collisions --------------------------------------------------------------------------------------------

NOBODY = -1


@dataclass(frozen=True)
class Partners:
    """Collisions by partner. The deciding pair is the pair that touched, as contact outweighs the rest of the risk."""

    with_ego: tuple[int, ...]
    """Distinct simulations in which the ego touched actor 1, actor 2, …"""
    without_ego: int
    """Distinct simulations in which two other actors touched, before the ego touched an actor if it did."""


NO_PARTNERS = Partners((), 0)
"""Collisions in a scene with the ego alone."""


def partners(evaluations: Evaluations, actors: int) -> Partners:
    """Return the collisions of a search by partner; `actors` is the number of actors, ego included."""
    new = evaluations.simulated
    met = partner_of(evaluations)[new]
    others = np.isfinite(evaluations.rollouts.others_contact_time[new])
    return Partners(tuple(int((met == pair).sum()) for pair in range(actors - 1)), int(others.sum()))


def partner_of(evaluations: Evaluations) -> np.ndarray:
    """Return (n, k) the pair that touched (ego and actor pair + 1); `NOBODY` where the ego did not collide."""
    return np.where(evaluations.rollouts.collided, evaluations.rollouts.pair, NOBODY)
