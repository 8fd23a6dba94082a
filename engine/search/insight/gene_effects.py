"""Effect of each gene: its association with risk among the simulations, and its effect if it alone is changed.

A genetic algorithm does not sample its box evenly, so a correlation among its individuals also shows its selection. The
effects come from *probes*: simulated cases, spread evenly over the campaign, are simulated again under the same stream
key with one gene moved by half its range, wrapping around. A gene that changes nothing in any probe is dead. Probes do
not count towards the budget or any figure.

A change of a gene may also change the attempt at a scene that the requirements accept, and with it lanes and all other
random values. Such a probe does not show the effect of the gene. An effect is therefore taken among those probes in
which the scene has the same finite choices (`variant`) as the case; if the case's own stream gives different choices,
some further streams are tried. A discrete gene may itself be such a choice, so its probes are all compared.
"""

from dataclasses import dataclass, fields

import numpy as np

from engine.assessment import Evaluate, concatenate, take
from engine.outcomes import Assessment
from engine.search.evaluations import Evaluations
from engine.search.protocol import Box
from engine.search.ranking import order_of_risk
from engine.search.statistics import Interval, correlation, midranks, spread_evenly
from engine.streams import StreamKey
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import GeneKind, Verdict

FURTHER = 8
"""Streams that are tried for a scene with the choices of its case."""
FURTHER_ROLLOUT = 1 << 15
"""Number of the first of them in the stream keys: no rollout of a search has it."""
NOT_OUTCOMES = ("attempts", "tested", "failed", "sought", "found")
"""Fields that describe how a scene was accepted, or objectives, which follow from the run; probes of a run that is read
back have no objectives.
"""


@dataclass(frozen=True)
class GeneEffect:
    """Effect of one gene in a campaign."""

    name: str
    correlation: float
    """Spearman's rho between gene and fitness over the valid distinct simulations; NaN for an index gene."""
    worst: Interval
    """5 % and 95 % quantile of the gene among the worst tenth of the simulations, file units."""
    concentration: float
    """1 - (width of `worst`) / (90 % of the box's width): near 1 where high risk pins the gene down, 0 where not;
    NaN for an index gene."""
    effect: float
    """Mean absolute change of the continuous risk over the probes that can be compared: mu* of Campolongo, Cariboni and
    Saltelli (2007), after Morris (1991), "Factorial sampling plans for preliminary computational experiments"."""
    compared: int | None
    """Probes that stay valid with the finite choices of their case; None if the gene was not probed."""
    changed: int | None
    """Probes in which anything changed; None if the gene was not probed."""
    probes: int
    """Number of probes."""

    @property
    def dead(self) -> bool | None:
        """Return True if the gene was probed and changed nothing; None if it was not probed."""
        return None if self.changed is None else self.changed == 0


@dataclass(frozen=True)
class Probes:
    """Results of moving each gene in turn: arrays (genes,)."""

    effect: Floats
    compared: Ints
    changed: Ints
    count: int


def gene_effects(box: Box, evaluations: Evaluations, probes: Probes | None = None) -> tuple[GeneEffect, ...]:
    """Return one effect per gene, in the order of the file."""
    rows = order_of_risk(evaluations)
    genomes, ranks = evaluations.genomes[rows], midranks(evaluations.fitness[rows])
    return tuple(_gene_effect(box, gene, genomes[:, gene], ranks, probes) for gene in range(len(box)))


def _gene_effect(box: Box, gene: int, values: Floats, ranks: Floats, probes: Probes | None) -> GeneEffect:
    """Return the effect of a gene; `values` (n,) are the worst first, with the ranks (n,) of their fitness."""
    ordered = box.kinds[gene] is not GeneKind.INDEX
    worst = _central_range(values[: -(-len(values) // 10)])
    return GeneEffect(
        name=box.names[gene],
        correlation=correlation(midranks(values), ranks) if ordered else float("nan"),
        worst=worst,
        concentration=_concentration(worst, box.high[gene] - box.low[gene]) if ordered else float("nan"),
        effect=float(probes.effect[gene]) if probes else float("nan"),
        compared=int(probes.compared[gene]) if probes else None,
        changed=int(probes.changed[gene]) if probes else None,
        probes=probes.count if probes else 0,
    )


def _concentration(worst: Interval, width: float) -> float:
    """Share of the box, less its outer tenth, that the worst cases leave empty."""
    return float(1.0 - min((worst.high - worst.low) / (0.9 * width), 1.0)) if width > 0.0 else float("nan")


def _central_range(values: Floats) -> Interval:
    if not len(values):
        return Interval(float("nan"), float("nan"))
    low, high = np.quantile(values, [0.05, 0.95])
    return Interval(float(low), float(high))


def probe_genes(box: Box, evaluations: Evaluations, evaluate: Evaluate, count: int) -> Probes | None:
    """Move each gene alone in up to `count` valid cases; None where there is no case or no gene."""
    rows = np.flatnonzero(evaluations.valid & evaluations.simulated)
    rows = rows[spread_evenly(len(rows), count)]
    if not (len(rows) and len(box)):
        return None
    chosen = take(evaluations, rows)
    cases = np.arange(len(rows))
    rollout = np.argmax(chosen.rollouts.verdict == Verdict.VALID, axis=1)
    before, keys = take(chosen.rollouts, (cases, rollout)), chosen.keys[cases, rollout]
    moved = np.concatenate([_moved(box, gene, chosen.genomes) for gene in range(len(box))])
    keys = np.tile(keys, (len(box), 1))
    after = evaluate(moved, keys)
    again = take(before, np.tile(cases, len(box)))
    changed = _differs(again, after)
    chosen_by_gene = np.repeat([kind is not GeneKind.CONTINUOUS for kind in box.kinds], len(rows))
    after, same = _same_choices(again, after, moved, keys, chosen_by_gene, evaluate)
    shape = len(box), len(rows)
    effect = _effect(again, after, same, shape)
    return Probes(effect, same.reshape(shape).sum(axis=1), changed.reshape(shape).sum(axis=1), len(rows))


def _same_choices(
    before: Assessment, after: Assessment, moved: Floats, keys: Ints, free: Bools, evaluate: Evaluate
) -> tuple[Assessment, Bools]:
    """Return the probes, some of them under a further stream, and (n,) True if valid with the choices of their case."""

    def same(found: Assessment, rows: Ints) -> Bools:
        return (found.verdict == Verdict.VALID) & ((found.variant == before.variant[rows]) | free[rows])

    unchanged = same(after, np.arange(len(after)))
    other = np.flatnonzero(~unchanged & (after.verdict == Verdict.VALID))
    if not len(other):
        return after, unchanged
    rows = np.repeat(other, FURTHER)
    further = keys[rows]
    further[:, StreamKey._fields.index("rollout")] = FURTHER_ROLLOUT + np.tile(np.arange(FURTHER), len(other))
    found = evaluate(moved[rows], further)
    hits = same(found, rows).reshape(len(other), FURTHER)
    source = np.arange(len(after))
    reached = hits.any(axis=1)
    source[other[reached]] = len(after) + np.flatnonzero(reached) * FURTHER + np.argmax(hits[reached], axis=1)
    unchanged[other[reached]] = True
    return take(concatenate([after, found]), source), unchanged


def _moved(box: Box, gene: int, genomes: Floats) -> Floats:
    """Return the genomes with one gene moved by half its range, wrapping around; discrete genes stay whole numbers."""
    moved = genomes.copy()
    low, high = box.low[gene], box.high[gene]
    if low < high:
        discrete = box.kinds[gene] is not GeneKind.CONTINUOUS
        width = high - low + (1.0 if discrete else 0.0)
        step = float(width // 2) if discrete else width / 2.0
        moved[:, gene] = np.clip(low + np.mod(genomes[:, gene] - low + step, width), low, high)
    return moved


def _effect(before: Assessment, after: Assessment, same: Bools, shape: tuple[int, int]) -> Floats:
    """Return (genes,) the mean absolute change of the continuous risk; NaN where no probe can be compared."""
    total = np.where(same, np.abs(after.continuous - before.continuous), 0.0).reshape(shape).sum(axis=1)
    compared = same.reshape(shape).sum(axis=1)
    return np.where(compared > 0, total / np.maximum(compared, 1), np.nan)


def _differs(before: Assessment, after: Assessment) -> Bools:
    """Return (n,) True if any outcome differs, bit for bit; NaN equals NaN."""
    differs = np.zeros(len(before), dtype=bool)
    for field in fields(Assessment):
        if field.name not in NOT_OUTCOMES:
            a, b = getattr(before, field.name), getattr(after, field.name)
            unequal = (a != b) & ~((a != a) & (b != b))
            differs |= unequal.reshape(len(differs), -1).any(axis=1)
    return differs
