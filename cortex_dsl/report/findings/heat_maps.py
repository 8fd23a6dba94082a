"""Where in the space of params a search failed: pairs of genes as heat maps, those first that tell the most."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from engine.scenes import Bools
from engine.search.evaluations import Evaluations
from engine.search.manifest import Parameter
from engine.tables import Floats, Ints
from engine.vocabulary import GeneKind

CELLS = 14
"""Along each side, for a gene that is not a choice of few."""


@dataclass(frozen=True)
class Sides:
    """How one gene is cut into cells."""

    name: str
    unit: str
    edges: Floats
    """(cells + 1,) file units."""
    labels: tuple[str, ...]
    """Of an index gene's cells; () otherwise."""

    @property
    def cells(self) -> int:
        return len(self.edges) - 1

    def place(self, values: Floats) -> Ints:
        """The cell of each value."""
        return np.clip(np.searchsorted(self.edges, values, side="right") - 1, 0, self.cells - 1)


@dataclass(frozen=True)
class HeatMap:
    """Valid distinct simulations counted by two genes."""

    across: Sides
    up: Sides
    tried: Ints
    """(cells across, cells up)"""
    failed: Ints
    information: float
    """What the cell tells of whether a simulation failed [bits]; see `information`."""


def sides(parameter: Parameter) -> Sides:
    """Even cells over the range; one for each value where there are few."""
    low, high = parameter.low, parameter.high
    if parameter.kind == GeneKind.CONTINUOUS or high - low + 1 > CELLS:
        edges = np.linspace(low, high if high > low else low + 1.0, CELLS + 1)
        return Sides(parameter.name, parameter.unit, edges, ())
    return Sides(parameter.name, parameter.unit, np.arange(low, high + 2) - 0.5, parameter.options)


def heat_maps(parameters: Sequence[Parameter], evaluations: Evaluations, count: int = 3) -> list[HeatMap]:
    """The pairs of genes that tell the most, best first; no gene twice in all of them if that can be had cheaply."""
    rows = evaluations.valid & evaluations.simulated
    genomes, failed = evaluations.genomes[rows], evaluations.collided[rows]
    cuts = [sides(parameter) for parameter in parameters]
    places = [cut.place(genomes[:, gene]) for gene, cut in enumerate(cuts)]
    maps = [
        _heat_map(cuts[a], cuts[b], places[a], places[b], failed)
        for a, b in combinations(range(len(cuts)), 2)
        if cuts[a].cells > 1 and cuts[b].cells > 1
    ]
    return sorted(maps, key=lambda found: -found.information)[:count]


def _heat_map(across: Sides, up: Sides, x: Ints, y: Ints, failed: Bools) -> HeatMap:
    shape = across.cells, up.cells
    cell = np.ravel_multi_index((x, y), shape)
    tried = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
    hit = np.bincount(cell[failed], minlength=shape[0] * shape[1]).reshape(shape)
    return HeatMap(across, up, tried, hit, information(tried, hit))


def information(tried: Ints, failed: Ints) -> float:
    """Mutual information of cell and failure [bits], less what chance alone would show; never below 0.

    Shannon (1948), "A mathematical theory of communication"; the correction for few samples in many cells is that of
    Miller (1955), "Note on the bias of information estimates".
    """
    table = np.stack([failed.ravel(), tried.ravel() - failed.ravel()])
    total = int(table.sum())
    if not total:
        return 0.0
    entropy = _entropy(table.sum(axis=0)) + _entropy(table.sum(axis=1)) - _entropy(table)
    return max(0.0, entropy)


def _entropy(counts: Ints) -> float:
    """With the correction for its bias [bits]."""
    there = counts[counts > 0].astype(np.float64)
    share = there / there.sum()
    return float(-(share * np.log2(share)).sum() + (len(there) - 1) / (2.0 * there.sum() * np.log(2.0)))
