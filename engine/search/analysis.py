"""What a search's failures are, taken together: how many different ones, where, of what kinds, and whose fault."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.avoidability import Avoidability, Avoidance, avoidability
from engine.config import Config
from engine.program import Program
from engine.risk import PROFILES
from engine.sampling import sample
from engine.search.clusters import Cluster, clusters
from engine.search.diversity import Grid, Spread, distinct_failures, grids, spread
from engine.search.evaluations import Evaluations
from engine.search.evaluator import make_evaluator
from engine.search.genes import GeneEffect, gene_effects, probe_genes
from engine.search.protocol import Box
from engine.search.ranking import Case, worst_cases
from engine.search.sensitivity import Sensitivity, sensitivity

MOST_REPLAYS = 500
"""Distinct failures that the reference driver drives again; of more, as many spread evenly."""
BUDGET = 20_000
"""Simulations of the sensitivity design."""


@dataclass(frozen=True)
class Avoided:
    """How many of a search's distinct failures the reference driver would have avoided."""

    driven: int
    """Failures that were driven again."""
    by: dict[Avoidance, int]
    """How many of them came out in each way."""
    lost: int = 0
    """How many of them not even full braking from the first moment on avoids."""

    @property
    def avoidable(self) -> int:
        return self.by.get(Avoidance.AVOIDABLE, 0)


@dataclass(frozen=True)
class Analysis:
    """One search, understood. Rows are those of its evaluations."""

    simulations: int
    valid: int
    failures: int
    """Simulated individuals that collided …"""
    distinct: tuple[int, ...]
    """… and those that count as different (`diversity`)."""
    spread: Spread
    grids: tuple[Grid, ...]
    clusters: tuple[Cluster, ...]
    genes: tuple[GeneEffect, ...]
    """What each gene did in the search, and what it does when it alone is changed."""
    sensitivity: Sensitivity | None
    """Of the scenario itself, by a design of its own; None where it was left out or there is no gene."""
    worst: tuple[Case, ...]
    avoidability: tuple[Avoidability | None, ...]
    """Of each of the worst; None for one without a collision."""
    avoided: Avoided
    system: tuple[str, ...]
    """Genes that the search chose and that belong to the system under test."""


def analyse(
    program: Program,
    evaluations: Evaluations,
    config: Config,
    profile: str = "paper",
    budget: int = BUDGET,
    count: int = 10,
) -> Analysis:
    """All of it; `budget` simulations for the sensitivity design (0: none), `count` worst cases."""
    box = Box.of(program.space)
    config = replace(config, search=replace(config.search, engine="batch"))
    evaluate = make_evaluator(program, config, PROFILES[profile])
    distinct = distinct_failures(evaluations, box)
    worst = worst_cases(evaluations, count, box)
    simulated = evaluations.simulated
    return Analysis(
        simulations=int(simulated.sum()) * evaluations.keys.shape[1],
        valid=int((simulated & evaluations.valid).sum()),
        failures=int((simulated & evaluations.collided).sum()),
        distinct=tuple(distinct),
        spread=spread(evaluations, box),
        grids=grids(evaluations, variant_labels(program)),
        clusters=clusters(evaluations, box),
        genes=gene_effects(box, evaluations, probe_genes(box, evaluations, evaluate, config.search.probes or 32)),
        sensitivity=sensitivity(program.space, evaluate, budget, config.search.seed) if budget and len(box) else None,
        worst=worst,
        avoidability=driven_again(program, evaluations, [case.row for case in worst], config),
        avoided=_avoided(driven_again(program, evaluations, _spread_evenly(distinct), config)),
        system=tuple(name for name in program.space.system if name in program.space.names),
    )


def driven_again(
    program: Program, evaluations: Evaluations, rows: Sequence[int], config: Config
) -> tuple[Avoidability | None, ...]:
    """What the reference driver makes of the worst rollout of each of the rows."""
    chosen = np.array(rows, dtype=np.int64)
    keys = evaluations.keys[chosen, evaluations.worst_rollout[chosen]]
    scenes = sample(program, evaluations.genomes[chosen], keys, config.simulation)
    return avoidability(program, scenes, config.simulation)


def _spread_evenly(rows: Sequence[int]) -> list[int]:
    if len(rows) <= MOST_REPLAYS:
        return list(rows)
    return [rows[i] for i in np.linspace(0, len(rows) - 1, MOST_REPLAYS).astype(int).tolist()]


def _avoided(answers: Sequence[Avoidability | None]) -> Avoided:
    known = [answer for answer in answers if answer is not None]
    by = Counter(answer.avoidance for answer in known)
    return Avoided(len(known), dict(sorted(by.items())), sum(answer.margin == -math.inf for answer in known))


def variant_labels(program: Program) -> list[str]:
    """A label for each way of making the file's finite choices."""
    return [", ".join(choice.option for choice in variant.choices) or "the only one" for variant in program.variants]
