"""Simulations of a search, run again: does each come to what its journal says, bit for bit?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.config import Config
from engine.program import Program
from engine.risk import PROFILES
from engine.search.assessment import take, to_arrays
from engine.search.chain import canonical
from engine.search.evaluations import Evaluations
from engine.search.evaluator import make_evaluator
from engine.search.objectives import known_objectives, objectives
from engine.search.protocol import SOUGHT
from engine.tables import Bools, Ints


@dataclass(frozen=True)
class Repeated:
    """Simulations that were run again."""

    rows: Ints
    """(n, 2) each by its individual and its rollout."""
    same: Bools
    """(n,) whether it came to the same."""
    sought: bool
    """Whether what was sought was asked again, too: a function of a Python program cannot be."""


def repeat(
    program: Program, config: Config, profile: str, objective: Sequence[str], evaluations: Evaluations, rows: Ints
) -> Repeated:
    """Run simulations again, named by rows (n, 2) of individual and rollout, and compare every number that a journal
    keeps of them.
    """
    known = tuple(objective) == SOUGHT or set(objective) <= set(known_objectives(program))
    aims = objectives(program, objective) if known else ()
    individual, rollout = rows.T
    before = take(evaluations.rollouts, (individual, rollout))
    if not len(rows):
        return Repeated(rows, np.ones(0, dtype=np.bool_), known)
    evaluate = make_evaluator(program, config, PROFILES[profile], aims)
    after = evaluate(evaluations.genomes[individual], evaluations.keys[individual, rollout])
    same = np.ones(len(rows), dtype=np.bool_)
    pairs = [*zip(to_arrays(before).values(), to_arrays(after).values(), strict=True)]
    names = ("tested", "failed", "broken", *(("sought", "found") if known else ()))
    pairs += [(getattr(before, name), getattr(after, name)) for name in names]
    for old, new in pairs:
        equal = canonical(old).view(np.int64) == canonical(new).view(np.int64)
        same &= equal.reshape(len(rows), -1).all(axis=1)
    return Repeated(rows, same, known)


def sampled(evaluations: Evaluations, count: int, among: Bools) -> Ints:
    """(n, 2) individual and rollout of at most so many distinct simulations, spread evenly over those `among`."""
    rows = np.argwhere(among & evaluations.simulated[:, np.newaxis])
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).round().astype(np.int64))
    return rows[chosen]
