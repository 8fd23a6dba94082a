"""Clusters of failures in the gene space, each with a readable condition such as `ADV_SPEED > 41 km/h`.

Failures are grouped by their genes, each as a share of its range: agglomeration by Ward (1963), "Hierarchical grouping
to optimize an objective function", cut where the mean silhouette of Rousseeuw (1987), "Silhouettes: a graphical aid",
is largest; if even the largest silhouette is weak, all failures are one group.

The condition of a group is grown gene by gene, each time by the bound that separates its failures best from runs
without failure that are sampled from the file's distributions: weighted relative accuracy of Lavrac, Flach and Zupan
(1999), "Rule evaluation measures: a unifying view", coverage times (precision - share of all).

The simulations of a search are not a random sample, as a search prefers regions with failures. A condition is therefore
tested on fresh draws from the file's own distributions. One half of the draws that meet it decides whether it is
significant: its runs fail more often than all runs, and the 95 % intervals do not overlap; otherwise there is no
condition. The second half gives the reported interval, which no selection has influenced. All results follow from the
seed.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engine.assessment import Evaluate
from engine.outcomes import Assessment
from engine.portable import product
from engine.program import ParamSpace
from engine.sampling import draw_genomes
from engine.search.evaluations import Evaluations
from engine.search.protocol import Box
from engine.search.statistics import Interval, clopper_pearson, spread_evenly
from engine.streams import StreamKey, key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import GeneKind, Method, Verdict

MOST_CLUSTERS = 6
LEAST_FAILURES = 8
"""Fewer failures than this are not grouped."""
WEAK = 0.3
"""A mean silhouette below this is no structure to speak of (0.25 to 0.5: weak, Kaufman and Rousseeuw, 1990)."""
MOST_GROUPED = 20_000
"""Maximum number of failures in all groups, spread evenly over all."""
MOST_ROWS = 800
"""Maximum number of failures that make the groups, spread evenly; each of the others joins the group of its nearest."""
NEAREST_AT_ONCE = 2_000
"""Failures whose distances are in memory at once."""
MOST_CONDITIONS = 3
CUTS = 24
"""Bounds tried for each gene."""
MIN_GAIN = 0.04
"""Share by which a further condition must improve the rule."""
BACKGROUND = 2000
"""Draws that conditions are grown against."""
JUDGES = 2000
"""Draws under a condition: one half decides whether it is accepted, the second half gives its failure rate."""
LOOKED_AT = 1 << 18
"""Maximum number of genomes that are drawn in search of those draws."""
AT_ONCE = 1 << 14
"""Number of genomes that are drawn before the draws under a condition are counted again."""
LEAST_JUDGES = 100
"""Minimum number of draws under a condition; a condition with fewer is rejected."""
FRESH_RUN = 0xFFFE
"""Number of the run in the stream keys of these draws: no search, estimate or design has it."""


@dataclass(frozen=True)
class Condition:
    """low <= gene <= high; one end may be infinite. For options, both ends are the number of the option."""

    gene: int
    low: float
    high: float

    def holds(self, genomes: Floats) -> Bools:
        """Return (n,) True for genomes (n, d) within the bounds."""
        return (genomes[:, self.gene] >= self.low) & (genomes[:, self.gene] <= self.high)


@dataclass(frozen=True)
class Rate:
    """Failure rate of runs that are sampled from the file's distributions."""

    valid: int
    """Valid runs."""
    failed: int
    """Valid runs in which the ego collides."""

    @property
    def share(self) -> float:
        return self.failed / self.valid if self.valid else math.nan

    @cached_property
    def interval(self) -> Interval:
        """Return the 95 % interval of Clopper and Pearson."""
        return clopper_pearson(self.failed, self.valid)


NOTHING = Rate(0, 0)


@dataclass(frozen=True)
class Cluster:
    """Group of failures that are close to each other."""

    rows: tuple[int, ...]
    """Rows of its failures in the evaluations."""
    example: int
    """The row nearest to the middle of all."""
    conditions: tuple[Condition, ...]
    """Conditions that all hold; () if no bounds were found under which runs fail more often than all runs."""
    coverage: float
    """Share of these failures that meets the conditions."""
    fresh: Rate
    """Failure rate of fresh draws that meet the conditions."""
    base: Rate
    """Failure rate of all fresh draws."""

    @property
    def lift(self) -> float:
        """Return the failure rate under the conditions divided by that of all draws; infinite if no draw failed."""
        return self.fresh.share / self.base.share if self.base.failed else math.inf


def clusters(evaluations: Evaluations, space: ParamSpace, evaluate: Evaluate, seed: int = 0) -> tuple[Cluster, ...]:
    """Return the clusters of a search's failures, or of `MOST_GROUPED` of them, the largest first; () without a failure
    or without a gene.
    """
    failures = np.flatnonzero(evaluations.simulated & evaluations.valid & evaluations.collided)
    failures = failures[spread_evenly(len(failures), MOST_GROUPED)]
    if not len(failures) or not len(space):
        return ()
    box = Box.of(space)
    units = _units(evaluations.genomes, box)
    labels = _grouped(units[failures])
    fresh = FreshDraws(space, evaluate, seed)
    return tuple(
        _cluster(evaluations, box, units, failures[labels == label], fresh)
        for label in np.argsort(-np.bincount(labels), kind="stable").tolist()
    )


def _units(genomes: Floats, box: Box) -> Floats:
    low, high = np.array(box.low), np.array(box.high)
    return (genomes - low) / np.where(high > low, high - low, 1.0)


# -- groups -----------------------------------------------------------------------------------------------------------


def _grouped(units: Floats) -> Ints:
    """Return (n,) the group of each failure in `units` (n, d)."""
    if len(units) < LEAST_FAILURES:
        return np.zeros(len(units), dtype=np.int64)
    from scipy.cluster.hierarchy import fcluster, ward
    from scipy.spatial.distance import cdist, pdist, squareform

    part = units[spread_evenly(len(units), MOST_ROWS)]
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
    blocks = (units[first : first + NEAREST_AT_ONCE] for first in range(0, len(units), NEAREST_AT_ONCE))
    return labels[np.concatenate([np.argmin(cdist(block, part), axis=1) for block in blocks])]


def _silhouette(table: Floats, labels: Ints) -> float:
    """Return the mean over all points of (b - a) / max(a, b).

    a: mean distance within the group; b: mean distance to the nearest other group.
    """
    names = np.unique(labels)
    if len(names) < 2:
        return -1.0
    members = np.stack([labels == name for name in names])
    sums, sizes = product(table, members.T), members.sum(axis=1)
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


class FreshDraws:
    """Runs that are sampled from the file's distributions; equal arguments give equal runs."""

    def __init__(self, space: ParamSpace, evaluate: Evaluate, seed: int) -> None:
        self._space, self._evaluate, self._seed = space, evaluate, seed

    def draws(self, part: int, count: int, rule: tuple[Condition, ...] = ()) -> tuple[Floats, Assessment]:
        """Return the first `count` draws that meet a rule, among `LOOKED_AT` draws; each part has different draws."""
        looked_at, genomes, keys = 0, np.empty((0, len(self._space))), np.empty((0, len(StreamKey._fields)), np.int64)
        while len(genomes) < count and looked_at < LOOKED_AT:
            block = range(looked_at, looked_at + (AT_ONCE if rule else count))
            drawn_keys = key_rows(self._seed, int(Method.SAMPLE), FRESH_RUN, part, block)
            drawn = draw_genomes(self._space, drawn_keys)
            met = _satisfy(drawn, rule)
            genomes, keys = np.concatenate([genomes, drawn[met]]), np.concatenate([keys, drawn_keys[met]])
            looked_at = block.stop
        return genomes[:count], self._evaluate(genomes[:count], keys[:count])

    @cached_property
    def background(self) -> tuple[Floats, Assessment]:
        return self.draws(0, BACKGROUND)


def rate(runs: Assessment, part: slice = slice(None)) -> Rate:
    """Return the failure rate of these runs."""
    valid = runs.verdict[part] == Verdict.VALID
    return Rate(int(valid.sum()), int((runs.collided[part] & valid).sum()))


def _cluster(evaluations: Evaluations, box: Box, units: Floats, members: Ints, fresh: FreshDraws) -> Cluster:
    own = evaluations.genomes[members]
    drawn, runs = fresh.background
    sound = drawn[(runs.verdict == Verdict.VALID) & ~runs.collided]
    rule = _rule(np.concatenate([own, sound]), np.arange(len(own) + len(sound)) < len(own), box)
    base = rate(runs)
    rule, reported = _judged(rule, base, fresh)
    middle = np.median(units[members], axis=0)
    return Cluster(
        rows=tuple(members.tolist()),
        example=int(members[np.argmin(np.abs(units[members] - middle).sum(axis=1))]),
        conditions=rule,
        coverage=_mean(_satisfy(own, rule)),
        fresh=reported,
        base=base,
    )


def _judged(rule: tuple[Condition, ...], base: Rate, fresh: FreshDraws) -> tuple[tuple[Condition, ...], Rate]:
    """Return the rule and its failure rate, from draws that did not influence its acceptance; no rule without lift."""
    _, runs = fresh.draws(1, JUDGES, rule) if rule else ((), None)
    if runs is None or len(runs) < LEAST_JUDGES:
        return (), NOTHING
    decide, tell = rate(runs, slice(0, None, 2)), rate(runs, slice(1, None, 2))
    if not tell.valid or decide.interval.low <= base.interval.high:
        return (), NOTHING
    return rule, tell


def _mean(values: Bools) -> float:
    return float(values.mean()) if len(values) else math.nan


def _rule(genomes: Floats, wanted: Bools, box: Box) -> tuple[Condition, ...]:
    """Return a rule of bounds, added as long as each improves the rule."""
    rule: tuple[Condition, ...] = ()
    best = 0.0
    while len(rule) < MOST_CONDITIONS:
        options = [_with(rule, condition) for condition in _candidates(genomes[wanted], box)]
        scored = [(_accuracy(_satisfy(genomes, option), wanted), option) for option in options]
        quality, option = max(scored, key=lambda pair: pair[0], default=(0.0, rule))
        if quality <= best * (1.0 + MIN_GAIN) or len(option) > MOST_CONDITIONS:
            break
        best, rule = quality, option
    return tuple(sorted(rule, key=lambda condition: condition.gene))


def _candidates(genomes: Floats, box: Box) -> list[Condition]:
    """Return bounds from below and above at quantiles of the wanted genomes, and single options."""
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
    """Return the rule with one more bound; two bounds of one gene become one condition."""
    known = next((old for old in rule if old.gene == new.gene), None)
    if known is None:
        return (*rule, new)
    both = Condition(new.gene, max(known.low, new.low), min(known.high, new.high))
    return tuple(both if old is known else old for old in rule)


def _satisfy(genomes: Floats, rule: tuple[Condition, ...]) -> Bools:
    met = np.ones(len(genomes), dtype=bool)
    for condition in rule:
        met &= condition.holds(genomes)
    return met


def _accuracy(met: Bools, wanted: Bools) -> float:
    """Return the weighted relative accuracy."""
    covered = int(met.sum())
    if not covered:
        return 0.0
    return covered / len(met) * (float(wanted[met].mean()) - float(wanted.mean()))
