"""What each gene did in a search: what moving it changes, and where in its range the bad cases lie."""

import math

import numpy as np
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import ABSENT, column_decimals, fixed, format_gene, significant
from cortex_dsl.report.sparkline import bar, sparkline
from engine.program import ParamSpace
from engine.search.campaign import Campaign
from engine.search.genes import GeneEffect
from engine.search.ranking import order_of_risk
from engine.tables import Floats
from engine.vocabulary import GeneKind

BINS = 16
BAR = 6
ROOMY = 94
"""Columns from which the ends of each range are shown too."""
LEGEND = """\
effect: change of risk in points when this param moves half its range and what
the file chooses (lanes, routes) stays; in: so many cases could be compared
trend: rank correlation with risk, -1 to +1
bad cases: where in the range they lie; worst tenth: where 90 % of it lies"""
"""What the columns mean; fits 80 columns."""
FEW = 10
"""With fewer collisions than this, the riskiest tenth stands for them."""


def genes_view(space: ParamSpace, campaign: Campaign, width: int) -> RenderableType:
    """One row a gene: its effect, its trend, a histogram of the bad cases over its range, and where the worst lie."""
    bad = bad_cases(campaign)
    most = max((gene.effect for gene in campaign.genes if math.isfinite(gene.effect)), default=0.0)
    head = (
        left("gene"),
        right("effect"),
        left(),
        right("in"),
        right("trend"),
        right(),
        left("bad cases"),
        left(),
        left("worst tenth", wrap=True),
    )
    kept = range(len(head)) if width >= ROOMY else (0, 1, 2, 3, 4, 6, 8)
    genomes = campaign.evaluations.genomes[bad]
    rows = [_row(space, index, gene, genomes[:, index], most) for index, gene in enumerate(campaign.genes)]
    table = columns(*(head[i] for i in kept), rows=[[row[i] for i in kept] for row in rows], header=True)
    dead = [gene.name for gene in campaign.genes if gene.dead]
    return Group(table, *([_dead_line(dead)] if dead else []), Text(), Text(LEGEND, "quiet"))


def effect_note(campaign: Campaign) -> str:
    """Which cases are the bad ones, for the heading."""
    collisions = int(np.count_nonzero(campaign.evaluations.simulated & campaign.evaluations.collided))
    bad = f"{collisions:,} collisions" if collisions >= FEW else "the riskiest tenth"
    return f"bad cases: {bad}"


def bad_cases(campaign: Campaign) -> NDArray[np.intp]:
    """Rows of all simulated collisions, or of the riskiest tenth where there are few."""
    evaluations = campaign.evaluations
    collisions = np.flatnonzero(evaluations.simulated & evaluations.collided)
    if len(collisions) >= FEW:
        return collisions
    order = order_of_risk(evaluations)
    return np.asarray(order[: max(1, len(order) // 10)], dtype=np.intp)


def _row(space: ParamSpace, gene: int, effect: GeneEffect, bad: Floats, most: float) -> tuple[Text, ...]:
    is_index = space.kinds[gene] == GeneKind.INDEX
    low, high = ("", "") if is_index else (significant(float(bounds[gene])) for bounds in (space.low, space.high))
    return (
        Text(effect.name),
        Text("none", "warn") if effect.dead else Text(fixed(effect.effect, 1)),
        Text(bar(effect.effect, most, BAR), "bar"),
        Text(str(effect.compared) if effect.probes else ABSENT, "quiet"),
        Text(_trend(effect.correlation)),
        Text(low, "quiet"),
        Text(_histogram(space, gene, bad), "part.C"),
        Text(high, "quiet"),
        _worst(space, gene, effect, bad),
    )


def _trend(correlation: float) -> str:
    """Spearman's rho with its sign; a trend that rounds to nothing has none."""
    return f"{correlation:+.2f}" if math.isfinite(correlation) else ABSENT


def _histogram(space: ParamSpace, gene: int, values: Floats) -> str:
    if space.kinds[gene] == GeneKind.INDEX:
        counts = np.bincount(values.astype(int), minlength=len(space.options[gene]))
    else:
        counts, _ = np.histogram(values, bins=BINS, range=(float(space.low[gene]), float(space.high[gene])))
    return sparkline([count or math.nan for count in counts.tolist()], BINS, low=0.0)


def _worst(space: ParamSpace, gene: int, effect: GeneEffect, bad: Floats) -> Text:
    """Where nine tenths of the worst tenth lie, or the most frequent option."""
    if space.kinds[gene] == GeneKind.INDEX:
        often = int(np.bincount(bad.astype(int)).argmax()) if len(bad) else 0
        return Text(f"mostly {format_gene(space, gene, often)}")
    decimals = max(0, column_decimals(float(space.low[gene]), float(space.high[gene])) - 1)
    unit = f" {space.units[gene]}" if space.units[gene] else ""
    return Text.assemble(f"{fixed(effect.worst.low, decimals)} .. {fixed(effect.worst.high, decimals)}", (unit, "unit"))


def _dead_line(names: list[str]) -> Text:
    changes = "changes" if len(names) == 1 else "change"
    return Text.assemble((", ".join(names), "warn"), f" {changes} nothing: a search could do without")
