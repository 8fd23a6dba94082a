"""Kinds of failures, each with a readable condition such as `ADV_SPEED > 41 km/h and EGO_BRAKE < 0.3`.

Failures are grouped by their genes, each as a share of its range: agglomeration by Ward (1963), "Hierarchical grouping
to optimize an objective function", cut where the mean silhouette of Rousseeuw (1987), "Silhouettes: a graphical aid",
is largest; where even that is weak, all failures are of one kind.

The condition of a kind is grown gene by gene, each time by the bound that separates its failures best from all else
that was simulated: weighted relative accuracy of Lavrac, Flach and Zupan (1999), "Rule evaluation measures: a unifying
view", coverage times (precision - share of all). Everything is deterministic.

A condition is fitted to the runs that it describes, and describes them better than others. How much better shows
`held_out`: the rule is grown again from every other run and judged on those between, both ways round. Runs of a search
are relatives of one another, so that even this flatters it a little.
"""

import math
from dataclasses import dataclass

import numpy as np

from engine.search.evaluations import Evaluations
from engine.search.protocol import Box
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import GeneKind

MOST_CLUSTERS = 6
LEAST_FAILURES = 8
"""Fewer failures than this are not grouped."""
WEAK = 0.3
"""A mean silhouette below this is no structure to speak of (0.25 to 0.5: weak, Kaufman and Rousseeuw, 1990)."""
MOST_ROWS = 800
"""Failures that are grouped; of more, as many spread evenly, and each other one joins its nearest."""
MOST_CONDITIONS = 3
CUTS = 24
"""Bounds tried for each gene."""
WORTH = 0.04
"""Share by which a further condition must improve the rule."""


@dataclass(frozen=True)
class Condition:
    """low <= gene <= high; one end may be infinite. Of options: the one whose number both ends are."""

    gene: int
    low: float
    high: float

    def holds(self, genomes: Floats) -> Bools:
        """(n,) for genomes (n, d)."""
        return (genomes[:, self.gene] >= self.low) & (genomes[:, self.gene] <= self.high)


@dataclass(frozen=True)
class Cluster:
    """One kind of failure."""

    rows: tuple[int, ...]
    """Of the evaluations: its failures."""
    example: int
    """The row nearest to the middle of all."""
    conditions: tuple[Condition, ...]
    """All hold; () where no bound separates these failures from the rest."""
    precision: float
    """Failures of any kind among all valid simulations that meet the conditions: of what the search simulated, which
    is no probability."""
    coverage: float
    """Share of the cluster that meets the conditions."""
    met: int
    """Valid simulations that meet them."""
    held_out: "HeldOut"
    """The same of runs that the rule was not grown from."""


@dataclass(frozen=True)
class HeldOut:
    """How a rule does on runs that it has not seen; NaN where these were too few."""

    precision: float
    coverage: float


def clusters(evaluations: Evaluations, box: Box) -> tuple[Cluster, ...]:
    """The kinds of failures of a search, the largest first; () without a failure or without a gene."""
    valid = np.flatnonzero(evaluations.simulated & evaluations.valid)
    failed = evaluations.collided[valid]
    if not failed.any() or not len(box):
        return ()
    failures = valid[failed]
    units = _units(evaluations.genomes, box)
    labels = _grouped(units[failures])
    sizes = np.bincount(labels)
    return tuple(
        _cluster(evaluations, box, units, valid, failures[labels == label])
        for label in np.argsort(-sizes, kind="stable").tolist()
    )


def _units(genomes: Floats, box: Box) -> Floats:
    low, high = np.array(box.low), np.array(box.high)
    return (genomes - low) / np.where(high > low, high - low, 1.0)


# -- groups -----------------------------------------------------------------------------------------------------------


def _grouped(units: Floats) -> Ints:
    """A label for each failure (n, d)."""
    if len(units) < LEAST_FAILURES:
        return np.zeros(len(units), dtype=np.int64)
    from scipy.cluster.hierarchy import fcluster, ward
    from scipy.spatial.distance import cdist, pdist, squareform

    part = units[np.unique(np.linspace(0, len(units) - 1, min(len(units), MOST_ROWS)).astype(np.int64))]
    apart = pdist(part)
    if not apart.any():
        return np.zeros(len(units), dtype=np.int64)
    tree, table = ward(apart), squareform(apart)
    best, labels = WEAK, np.zeros(len(part), dtype=np.int64)
    for count in range(2, MOST_CLUSTERS + 1):
        cut = fcluster(tree, count, "maxclust") - 1
        quality = _silhouette(table, cut)
        if quality > best:
            best, labels = quality, cut
    if len(part) == len(units):
        return labels
    return labels[np.argmin(cdist(units, part), axis=1)]


def _silhouette(table: Floats, labels: Ints) -> float:
    """Mean over all points of (b - a) / max(a, b): a, mean distance within; b, mean distance to the nearest others."""
    names = np.unique(labels)
    if len(names) < 2:
        return -1.0
    members = np.stack([labels == name for name in names])
    sums, sizes = table @ members.T, members.sum(axis=1)
    own = np.searchsorted(names, labels)
    rows = np.arange(len(labels))
    alone = sizes[own] == 1
    within = sums[rows, own] / np.maximum(sizes[own] - 1, 1)
    means = sums / sizes
    means[rows, own] = np.inf
    other = means.min(axis=1)
    largest = np.maximum(within, other)
    width = np.where(alone | (largest == 0.0), 0.0, (other - within) / np.where(largest > 0.0, largest, 1.0))
    return float(width.mean())


# -- conditions -------------------------------------------------------------------------------------------------------


def _cluster(evaluations: Evaluations, box: Box, units: Floats, valid: Ints, members: Ints) -> Cluster:
    genomes, wanted, failed = evaluations.genomes[valid], np.isin(valid, members), evaluations.collided[valid]
    conditions = _rule(genomes, wanted, box)
    met = _meet(genomes, conditions)
    middle = np.median(units[members], axis=0)
    return Cluster(
        rows=tuple(members.tolist()),
        example=int(members[np.argmin(np.abs(units[members] - middle).sum(axis=1))]),
        conditions=conditions,
        precision=_mean(failed[met]),
        coverage=_mean(met[wanted]),
        met=int(met.sum()),
        held_out=_held_out(genomes, wanted, failed, box),
    )


def _held_out(genomes: Floats, wanted: Bools, failed: Bools, box: Box) -> HeldOut:
    """Precision and coverage of rules grown from one half of the runs, on the other half."""
    met, other = np.zeros(len(genomes), dtype=bool), np.arange(len(genomes)) % 2 == 1
    for seen in (other, ~other):
        if not wanted[seen].any():
            return HeldOut(math.nan, math.nan)
        met[~seen] = _meet(genomes[~seen], _rule(genomes[seen], wanted[seen], box))
    return HeldOut(_mean(failed[met]), _mean(met[wanted]))


def _mean(values: Bools) -> float:
    return float(values.mean()) if len(values) else math.nan


def _rule(genomes: Floats, wanted: Bools, box: Box) -> tuple[Condition, ...]:
    """Bounds added while each makes the rule better."""
    rule: tuple[Condition, ...] = ()
    best = 0.0
    while len(rule) < MOST_CONDITIONS:
        options = [_with(rule, condition) for condition in _candidates(genomes[wanted], box)]
        scored = [(_accuracy(_meet(genomes, option), wanted), option) for option in options]
        quality, option = max(scored, key=lambda pair: pair[0], default=(0.0, rule))
        if quality <= best * (1.0 + WORTH) or len(option) > MOST_CONDITIONS:
            break
        best, rule = quality, option
    return tuple(sorted(rule, key=lambda condition: condition.gene))


def _candidates(genomes: Floats, box: Box) -> list[Condition]:
    """Bounds from below and from above at quantiles of the wanted, and single options."""
    candidates: list[Condition] = []
    for gene, kind in enumerate(box.kinds):
        values = genomes[:, gene]
        if kind is GeneKind.INDEX:
            candidates += [Condition(gene, option, option) for option in np.unique(values).tolist()]
            continue
        cuts = np.unique(np.quantile(values, np.linspace(0.0, 1.0, CUTS), method="nearest")).tolist()
        candidates += [Condition(gene, cut, math.inf) for cut in cuts]
        candidates += [Condition(gene, -math.inf, cut) for cut in cuts]
    return candidates


def _with(rule: tuple[Condition, ...], new: Condition) -> tuple[Condition, ...]:
    """The rule with one more bound; two bounds of one gene are one condition."""
    known = next((old for old in rule if old.gene == new.gene), None)
    if known is None:
        return (*rule, new)
    both = Condition(new.gene, max(known.low, new.low), min(known.high, new.high))
    return tuple(both if old is known else old for old in rule)


def _meet(genomes: Floats, rule: tuple[Condition, ...]) -> Bools:
    met = np.ones(len(genomes), dtype=bool)
    for condition in rule:
        met &= condition.holds(genomes)
    return met


def _accuracy(met: Bools, wanted: Bools) -> float:
    """Weighted relative accuracy."""
    covered = int(met.sum())
    if not covered:
        return 0.0
    return covered / len(met) * (float(wanted[met].mean()) - float(wanted.mean()))
