"""Results of the analysis of a search, in words: kinds of failures, heat maps, and responsible actors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from cortex_dsl.report.findings.judgement import judged_content
from cortex_dsl.report.findings.readable import (
    ABSENT,
    column_decimals,
    counted,
    fixed,
    format_gene,
    percent,
    ratio,
)
from engine.avoidability import Avoidability, Avoidance
from engine.portable import log
from engine.program import ParamSpace
from engine.references import OUT_OF_RANGE, REFERENCES
from engine.scenes import Bools
from engine.search.evaluations import Evaluations
from engine.search.insight.analysis import Analysis, Avoided
from engine.search.insight.clusters import Cluster, Condition
from engine.search.insight.diversity import Grid
from engine.search.insight.sensitivity import Indices, Sensitivity
from engine.search.manifest import Parameter
from engine.tables import Floats, Ints
from engine.vocabulary import Answer, GeneKind

# -- kinds of failures, grids, and which params matter -----------------------------------------------------------------


JUDGED = (
    "failure rate: that of new runs that meet the condition, drawn from the distributions of the file, with the "
    "95 % interval of Clopper and Pearson; lift: this rate divided by that of all new runs"
)


def grouped_text(analysis: Analysis) -> str:
    """Return how many failures were grouped, if not all were; else ""."""
    if analysis.grouped in (0, analysis.failures):
        return ""
    return f"{analysis.grouped:,} of {analysis.failures:,} failures, spread evenly, were grouped"


def fresh_text(cluster: Cluster) -> str:
    """`71 % (66 .. 76)`: how often fresh draws under the condition fail."""
    if not cluster.conditions:
        return ABSENT
    low, high = (fixed(100.0 * end, 0) for end in cluster.fresh.interval)
    return f"{percent(cluster.fresh.share, 0)} ({low} .. {high})"


def lift_text(cluster: Cluster) -> str:
    """`5.1 times`"""
    if not cluster.conditions:
        return ABSENT
    return f"{fixed(cluster.lift, 1)} times" if math.isfinite(cluster.lift) else "all others: none"


def condition_text(space: ParamSpace, cluster: Cluster) -> str:
    """`ADV_SPEED > 41.0 km/h and EGO_BRAKE < 0.300`."""
    return " and ".join(_condition(space, each) for each in cluster.conditions) or "no range within which more fail"


def _condition(space: ParamSpace, condition: Condition) -> str:
    gene = condition.gene
    name, unit = space.names[gene], f" {space.units[gene]}" if space.units[gene] else ""
    if space.kinds[gene] == GeneKind.INDEX:
        return f"{name} is {format_gene(space, gene, condition.low)}"
    low = format_gene(space, gene, _outward(space, gene, condition.low, -1.0)) if math.isfinite(condition.low) else ""
    high = format_gene(space, gene, _outward(space, gene, condition.high, 1.0)) if math.isfinite(condition.high) else ""
    if low and high:
        return f"{name} {low} .. {high}{unit}"
    return f"{name} ≥ {low}{unit}" if low else f"{name} ≤ {high}{unit}"


def _outward(space: ParamSpace, gene: int, value: float, sign: float) -> float:
    """The next value that is printed as it is: a bound as printed leaves out nothing that the bound lets in."""
    if space.kinds[gene] == GeneKind.INTEGER:
        return value
    scale = 10.0 ** column_decimals(float(space.low[gene]), float(space.high[gene]))
    return sign * math.ceil(sign * value * scale - 1e-6) / scale


def grid_text(grid: Grid) -> str:
    """Return the number of failing cells among the reached cells; many of the rest are unreachable."""
    return f"collisions in {grid.failing} of the {counted(grid.covered, 'cell')} reached"


def varying(found: Sensitivity) -> list[tuple[str, Indices]]:
    """Return title and indices of each output that varies."""
    outputs = (("a valid run", found.validity), ("risk", found.risk), ("collision", found.collision))
    return [(title, indices) for title, indices in outputs if math.isfinite(indices.chance.value)]


# -- would a competent driver have avoided it? -------------------------------------------------------------------------

AVOIDANCES = {
    Avoidance.AVOIDABLE: ("avoidable", "good", "the careful driver would have stopped or passed in time"),
    Avoidance.UNAVOIDABLE: ("unavoidable", "bad", "the careful driver would have braked too late"),
    Avoidance.BRAKED_AS_HARD: ("braked as hard", "warn", "too late, but the ego itself braked as hard"),
    Avoidance.UNSEEN: ("unseen", "warn", "no conflict within the next 4 s was visible for long enough"),
    Avoidance.LOST: ("lost from the start", "warn", "the scene begins so late that even the hardest braking fails"),
    Avoidance.NO_BRAKING_HELPS: ("no braking helps", "warn", "another actor hits the ego however early it brakes"),
    Avoidance.STRUCK_FROM_BEHIND: ("struck from behind", "quiet", "not the ego's failure: another hit its rear"),
    Avoidance.STRUCK_STANDING: ("struck while standing", "quiet", "not the ego's failure: it stood where it may stand"),
}
"""Name, style and meaning."""

DRIVER = (
    "UN R157: the careful driver needs 0.4 s to perceive and 0.75 s to react, and reaches 0.774 g of braking 0.6 s "
    "later, or less if brakes or road allow less; it sees what bodies and weather do not hide, brakes along the ego's "
    "path, at least as hard as the ego had begun to, and never steers. The regulation covers cut-ins on motorways; "
    "that the driver reacts to a conflict up to 4 s ahead is cortexc's choice"
)


def driver_rows(avoided: Avoided) -> list[tuple[str, str, int, int, str]]:
    """Return a row for each reference driver: name, meaning, collisions that it avoids, that it covers, and why others
    are out of its range.
    """
    sentences = {each.name: each.sentence for each in REFERENCES}
    rows = []
    for name, counts in avoided.by_driver.items():
        avoids, collides = counts.get(Answer.AVOIDS, 0), counts.get(Answer.COLLIDES, 0)
        out = ", ".join(f"{counts[answer]:,} {reason}" for answer, reason in OUT_OF_RANGE.items() if counts.get(answer))
        rows.append((name, sentences[name], avoids, avoids + collides, out))
    return rows


def lost_text(avoided: Avoided) -> str:
    """`3 of them are lost from the start …`; empty where there are none."""
    if not avoided.lost:
        return ""
    return f"{avoided.lost:,} of them are lost from the start: this is a property of the scene, not of the driving"


def struck_text(avoided: Avoided) -> str:
    """`2 of them are not the ego's failure …`; empty where there are none."""
    if not avoided.struck:
        return ""
    return f"{avoided.struck:,} of them are not the ego's failure: it was struck from behind, or while it stood"


def system_lines(avoided: Avoided) -> list[str]:
    """Return how avoidable failures depend on params of the system that the search chose; empty without any."""
    if not (avoided.by_system and sum(avoided.by_system[0].thirds)):
        return []
    parts = [f"{share.name} {', '.join(f'{n:,}' for n in share.thirds)}" for share in avoided.by_system]
    avoidable = f"number of the {sum(avoided.by_system[0].thirds):,} avoidable ones"
    where = f"{avoidable} in the lower, middle and upper third of the range"
    return [
        f"the search also chose params of the system under test; {where}: {'; '.join(parts)}",
        "an avoidable collision counts against the ego with these settings only; --freeze fixes them",
    ]


def closing_text(speed: float) -> str:
    """`45 km/h`"""
    return f"{fixed(3.6 * speed, 0)} km/h" if math.isfinite(speed) else ABSENT


def fastest_text(analysis: Analysis) -> str:
    """Return the fastest contact, which an order by risk may hide; empty without a contact."""
    if not math.isfinite(analysis.fastest):
        return ""
    fastest = closing_text(analysis.fastest)
    return f"the risk is bounded and hides the most severe contacts; the fastest one closed at {fastest}"


def margin_text(answer: Avoidability) -> str:
    """Return the margin by which braking was early enough, or too late."""
    if math.isnan(answer.margin):
        return ""
    if math.isinf(answer.margin):
        return "braking never helps"
    if answer.avoidable:
        return f"{fixed(answer.margin, 2)} s to spare"
    if answer.margin > 0.0:
        return f"{fixed(answer.margin, 2)} s too early: a driver who brakes later passes first"
    return f"{fixed(-answer.margin, 2)} s too late"


# -- where in the space of params a search failed: pairs of genes, the most informative first --------------------------

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
    """Labels of an index gene's cells; () for other genes."""

    @property
    def cells(self) -> int:
        return len(self.edges) - 1

    def place(self, values: Floats) -> Ints:
        """The cell of each value."""
        return np.clip(np.searchsorted(self.edges, values, side="right") - 1, 0, self.cells - 1)


@dataclass(frozen=True)
class HeatMap:
    """Distinct simulations that are counted (`Evaluations.scored`), by two genes."""

    across: Sides
    up: Sides
    tried: Ints
    """(cells across, cells up)"""
    failed: Ints
    information: float
    """Mutual information of the cell and of failure [bits]; see `information`."""


def sides(parameter: Parameter) -> Sides:
    """Return equal cells over the range; one cell per value if there are few values."""
    low, high = parameter.low, parameter.high
    if parameter.kind == GeneKind.CONTINUOUS or high - low + 1 > CELLS:
        edges = np.linspace(low, high if high > low else low + 1.0, CELLS + 1)
        return Sides(parameter.name, parameter.unit, edges, ())
    return Sides(parameter.name, parameter.unit, np.arange(low, high + 2) - 0.5, parameter.options)


def heat_maps(parameters: Sequence[Parameter], evaluations: Evaluations, count: int = 3) -> list[HeatMap]:
    """Return the `count` most informative pairs of genes, the best first."""
    rows = evaluations.scored & evaluations.simulated
    genomes, failed = evaluations.genomes[rows], evaluations.found[rows]
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
    """Return the mutual information of cell and failure [bits], less its value by chance alone; never below 0.

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
    """Return the entropy with the correction for its bias [bits]."""
    there = counts[counts > 0].astype(np.float64)
    share = there / there.sum()
    return float(-(share * log(share)).sum() + (len(there) - 1) / (2.0 * there.sum())) / math.log(2.0)


def heat_map_content(found: HeatMap) -> dict[str, Any]:
    """A pair of params with its counts, for a document."""
    return {
        "params": [found.across.name, found.up.name],
        "information": found.information,
        "tried": found.tried,
        "failed": found.failed,
    }


def analysis_content(space: ParamSpace, analysis: Analysis) -> dict[str, Any]:
    """Return all results of an analysis as a document."""
    conditions = [
        {
            "condition": condition_text(space, each),
            "fresh": {"valid": each.fresh.valid, "failed": each.fresh.failed, "interval": each.fresh.interval},
            "base": {"valid": each.base.valid, "failed": each.base.failed, "interval": each.base.interval},
            "lift": each.lift,
        }
        for each in analysis.clusters
    ]
    cells = [
        {"name": grid.name, "failing": grid.failing, "covered": grid.covered, "qd_score": grid.qd_score}
        for grid in analysis.grids
    ]
    found = analysis.avoided
    by_driver = {
        name: {answer.name.lower(): count for answer, count in counts.items()}
        for name, counts in found.by_driver.items()
    }
    more: dict[str, Any] = {
        "cells": cells,
        "avoided": {**vars(found), "by_driver": by_driver, "lost": found.lost, "struck": found.struck},
        "avoided_shares": {kind.name.lower(): ratio(count, found.driven) for kind, count in found.by.items()},
    }
    judged = [each and judged_content(each) for each in analysis.judged]
    return {"params": space.names, "conditions": conditions, **vars(analysis), "judged": judged, **more}
