"""Diversity of the runs of a search: cells of descriptor grids, QD score, and distances between its failures.

Descriptors are taken at the instant of closest approach, or of contact (see `engine.kernels.pair.Approach`). Edges of
grids are the same for every scenario and search, so that their cells can be compared.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.search.evaluations import Evaluations
from engine.search.protocol import Box
from engine.search.statistics import spread_evenly
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import GeneKind, Side

KMH = 1.0 / 3.6
MOST_NEAREST = 10_000
"""Maximum number of failures whose nearest other failure is looked for."""
SPEEDS = tuple(10.0 * step for step in range(1, 10))
"""Inner edges of speeds [km/h]; the last cell is open."""
CLOSING = tuple(20.0 * step for step in range(8))
"""Inner edges of closing speeds [km/h]; both outer cells are open."""
SECTORS = ("same way", "45° left", "90° left", "135° left", "head-on", "135° right", "90° right", "45° right")
"""Headings of the other actor relative to the ego, each the middle of a sector of 45 degrees."""


@dataclass(frozen=True)
class Grid:
    """The simulations of a search, counted in the cells of two descriptors; arrays (first, second)."""

    name: str
    first: tuple[str, ...]
    """Labels of the rows."""
    second: tuple[str, ...]
    """Labels of the columns."""
    runs: Ints
    """Valid simulations in each cell."""
    failures: Ints
    """Simulations in each cell that collided."""
    best: Floats
    """Largest continuous risk in each cell; NaN in an empty cell."""

    @property
    def cells(self) -> int:
        return self.runs.size

    @property
    def covered(self) -> int:
        """Return the number of cells with a valid simulation."""
        return int((self.runs > 0).sum())

    @property
    def failing(self) -> int:
        """Return the number of cells with a collision."""
        return int((self.failures > 0).sum())

    @property
    def qd_score(self) -> float:
        """Return the sum of the best quality, here the continuous risk, over all covered cells.

        Pugh, Soros and Stanley (2016), "Quality diversity: a new frontier for evolutionary computation".
        """
        return float(np.nansum(self.best))


@dataclass(frozen=True)
class Spread:
    """Mean distances between failures. A distance is the mean difference of genes, as shares of their ranges.

    NaN with fewer than two failures. The nearest distance falls with the number of failures, so compare it only between
    searches with the same `count`.
    """

    nearest: float
    """Mean distance to the nearest other failure: near 0 if the search found the same failure again and again. Of many
    failures, the mean over `MOST_NEAREST` that are spread evenly.
    """
    pairwise: float
    """Mean distance between any two failures; about 1/3 if they fill the box evenly."""
    count: int = 0
    """Failures of different genomes, all of them."""


def spread(evaluations: Evaluations, box: Box) -> Spread:
    """Return the mean distances between the different failures of a search."""
    rows = np.flatnonzero(evaluations.simulated & evaluations.collided)
    places = _different(_places(evaluations.genomes[rows], box))
    if len(places) < 2 or not len(box):
        return Spread(math.nan, math.nan, len(places))
    from scipy.spatial import KDTree

    apart, _ = KDTree(places).query(places[spread_evenly(len(places), MOST_NEAREST)], k=2, p=1)
    return Spread(float(np.asarray(apart)[:, 1].mean()) / len(box), _mean_difference(places) / len(box), len(places))


def _different(places: Floats) -> Floats:
    """Return the different points among (n, d), in their order: `np.unique` along an axis, in a tenth of the time."""
    if not places.size:
        return np.unique(places, axis=0)
    ordered = places[np.lexsort(places.T[::-1])]
    return ordered[np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])]


def _places(genomes: Floats, box: Box) -> Floats:
    """Return points (n, columns) with an L1 distance that sums the differences of genes as shares of their ranges.

    One column per gene; an option gene has one column per option, as two different options are a whole range apart.
    """
    units = _units(genomes, box)
    columns: list[Floats] = []
    for gene, kind in enumerate(box.kinds):
        if kind is GeneKind.INDEX:
            columns += [0.5 * (genomes[:, gene] == option) for option in np.unique(genomes[:, gene])]
        else:
            columns.append(units[:, gene])
    return np.array(columns, dtype=np.float64).reshape(len(columns), len(genomes)).T


def _mean_difference(places: Floats) -> float:
    """Return the mean L1 distance of all pairs: in each sorted column, the i-th of n has the weight 2 i - n + 1."""
    count = len(places)
    weights = 2.0 * np.arange(count) - count + 1.0
    return float((weights[:, np.newaxis] * np.sort(places, axis=0)).sum() * 2.0 / (count * (count - 1)))


def _units(genomes: Floats, box: Box) -> Floats:
    """Return genes as shares of their ranges; two different options are further apart than any share."""
    low, high = np.array(box.low), np.array(box.high)
    width = np.where(high > low, high - low, 1.0)
    options = np.array([kind is GeneKind.INDEX for kind in box.kinds], dtype=bool)
    return (genomes - low) / np.where(options, 0.5, width)


def grids(evaluations: Evaluations, variants: Sequence[str] = ()) -> tuple[Grid, ...]:
    """Return the descriptor grids of a search: speeds, angle and closing speed, side and variant."""
    runs, chosen = evaluations.rollouts, worst_valid(evaluations)
    if not len(variants):
        variants = [str(number) for number in range(int(runs.variant.max(initial=0)) + 1)]
    names = tuple(dict.fromkeys(variants))
    column = np.array([names.index(label) for label in variants])[np.maximum(runs.variant[chosen], 0)]
    ego, other = runs.ego_speed[chosen], runs.other_speed[chosen]
    closing, angle, side = runs.closing_speed[chosen], runs.approach_angle[chosen], runs.side[chosen]
    met = side >= 0
    speeds = _labels(SPEEDS, first="0")
    cells = (
        ("ego speed x other speed [km/h]", speeds, speeds, _bins(ego, SPEEDS), _bins(other, SPEEDS)),
        ("approach angle x closing speed [km/h]", SECTORS, _labels(CLOSING), sector(angle), _bins(closing, CLOSING)),
        ("side x variant", tuple(s.name.lower() for s in Side), names, side, column),
    )
    risk, failed = runs.continuous[chosen][met], runs.collided[chosen][met]
    return tuple(counted(name, a, b, i[met], j[met], risk, failed) for name, a, b, i, j in cells)


def worst_valid(evaluations: Evaluations) -> tuple[Ints, Ints]:
    """Return (row, rollout) of each valid simulated individual's worst rollout."""
    rows = np.flatnonzero(evaluations.simulated & evaluations.valid)
    return rows, evaluations.worst_rollout[rows]


def sector(angle: Floats) -> Ints:
    """Return the index in `SECTORS` of each angle [rad]; a head-on angle may have either sign."""
    turned = np.nan_to_num(angle) / (2.0 * math.pi / len(SECTORS)) + 0.5
    return np.floor(turned).astype(np.int64) % len(SECTORS)


def _bins(speed: Floats, edges: Sequence[float]) -> Ints:
    return np.searchsorted(np.array(edges) * KMH, np.nan_to_num(speed), side="right")


def _labels(edges: Sequence[float], first: str = "") -> tuple[str, ...]:
    """Return labels such as `0 .. 10`, one more than inner edges; without `first` the first label is `< edge`."""
    texts = [f"{edge:g}" for edge in edges]
    start = f"{first} .. {texts[0]}" if first else f"< {texts[0]}"
    return (start, *(f"{a} .. {b}" for a, b in pairwise(texts)), f"> {texts[-1]}")


def counted(
    name: str, first: tuple[str, ...], second: tuple[str, ...], i: Ints, j: Ints, risk: Floats, failed: Bools
) -> Grid:
    """Return the simulations counted by their cells `i` and `j`."""
    shape = len(first), len(second)
    runs, failures = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64)
    best = np.full(shape, -np.inf)
    np.add.at(runs, (i, j), 1)
    np.add.at(failures, (i, j), failed.astype(np.int64))
    np.maximum.at(best, (i, j), risk)
    return Grid(name, first, second, runs, failures, np.where(runs > 0, best, np.nan))
