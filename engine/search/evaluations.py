"""Every individual of a campaign, or of one generation of it, with all its simulations."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engine.scenes import Bools
from engine.search.aggregate import aggregate
from engine.search.assessment import Assessment, map_arrays
from engine.search.protocol import MEASURES, Birth, Proposal, Result, Status
from engine.tables import Floats, Ints
from engine.vocabulary import Verdict


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
    """(n,) the integer risk, aggregated over the valid rollouts; NaN where none is."""
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
    def failed(self) -> Bools:
        """(n,) the engine failed: neither valid nor invalid, never scored."""
        return np.equal(self.verdict, Verdict.ERROR)

    @cached_property
    def collided(self) -> Bools:
        """(n,) at least one rollout collided."""
        return np.asarray(self.rollouts.collided.any(axis=1))

    @cached_property
    def worst_rollout(self) -> Ints:
        """(n,) the rollout with the largest score, then continuous score, then lowest number."""
        score = self.rollouts.score.astype(np.float64)
        top = score == score.max(axis=1, keepdims=True)
        return np.argmax(np.where(top, np.nan_to_num(self.rollouts.continuous, nan=-1.0), -np.inf), axis=1)

    @cached_property
    def continuous(self) -> Floats:
        """(n,) continuous risk of the worst rollout."""
        return self.rollouts.continuous[np.arange(len(self)), self.worst_rollout]

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
    valid = rollouts.verdict == Verdict.VALID
    failed = (rollouts.verdict == Verdict.ERROR).any(axis=1)
    verdict = np.where(failed, int(Verdict.ERROR), rollouts.verdict[:, 0])
    verdict = np.where(valid.any(axis=1), int(Verdict.VALID), verdict).astype(np.int32)
    return verdict, aggregate(rollouts.score.astype(np.float64), valid, how)


def results(evaluations: Evaluations) -> list[Result]:
    """What a searcher is told, one result a row."""
    columns = evaluations.verdict, evaluations.fitness, evaluations.reused, evaluations.continuous, evaluations.collided
    rows = zip(*(column.tolist() for column in columns), _measures(evaluations), strict=True)
    return [
        Result(_status(verdict, reused), fitness, Verdict(verdict), continuous, collided, tuple(measures))
        for verdict, fitness, reused, continuous, collided, measures in rows
    ]


def _measures(evaluations: Evaluations) -> list[list[float]]:
    """One row of `MEASURES` an individual."""
    place = np.arange(len(evaluations)), evaluations.worst_rollout
    return np.stack([getattr(evaluations.rollouts, name)[place] for name in MEASURES], axis=1).tolist()


def _status(verdict: int, reused: bool) -> Status:
    if reused:
        return Status.REUSED
    if verdict == Verdict.ERROR:
        return Status.ERROR
    return Status.VALID if verdict == Verdict.VALID else Status.INVALID


def parent_rows(proposals: Sequence[Proposal]) -> Ints:
    """(n, 2, 2) births of the parents, -1 where there is none."""
    none = Birth(-1, -1)
    rows = [(*proposal.parents, none, none)[:2] for proposal in proposals]
    return np.array(rows, dtype=np.int32).reshape(len(rows), 2, 2)


def flat_rollouts(evaluations: Evaluations) -> Assessment:
    """All simulations under one another, arrays (n * k, …)."""
    size = evaluations.rollouts.verdict.size
    return map_arrays(evaluations.rollouts, lambda array: array.reshape(size, *array.shape[2:]))
