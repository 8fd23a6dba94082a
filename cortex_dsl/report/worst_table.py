"""The worst cases of a search: their risk with its parts, and their params in the file's own units."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.table import Column
from rich.text import Text

from cortex_dsl.report.layout import columns, right
from cortex_dsl.report.params import format_gene
from cortex_dsl.report.risk_view import PARTS
from cortex_dsl.report.search_report import SearchReport
from engine.program import ParamSpace
from engine.search.campaign import Campaign

LEAST_GENE_WIDTH = 7
"""Narrower than this, a table of many genes is split into several."""
ALIKE = 0.1
"""Cases whose values of a gene span less of its range than this are called alike."""


def worst_table(space: ParamSpace, campaign: Campaign, width: int) -> RenderableType:
    """One row a case. A file with many params gets several tables, so that none is wider than the terminal."""
    blocks = _blocks(space, width)
    tables: list[RenderableType] = []
    for index, genes in enumerate(blocks):
        tables += [Text()] if index else []
        tables.append(_block(space, campaign, genes, with_risk=index == 0))
    return Group(*tables)


def _blocks(space: ParamSpace, width: int) -> list[list[int]]:
    """Genes of each table: as many as fit."""
    blocks: list[list[int]] = [[]]
    used = 23
    for gene in range(len(space)):
        needed = 2 + max(LEAST_GENE_WIDTH - 2, *(len(line) for line in gene_header(space, gene)))
        if used + needed > width and blocks[-1]:
            blocks.append([])
            used = 5
        blocks[-1].append(gene)
        used += needed
    return blocks


def _block(space: ParamSpace, campaign: Campaign, genes: Sequence[int], *, with_risk: bool) -> RenderableType:
    height = max((len(gene_header(space, gene)) for gene in genes), default=1)
    head: list[Column] = [right("\n" * (height - 1) + "#", "quiet")]
    if with_risk:
        head.append(right("\n" * (height - 1) + "risk", "title"))
        head.append(right("\n" * (height - 1) + "parts"))
    head += [right("\n".join(["", "", "", "", *gene_header(space, gene)][-height:])) for gene in genes]
    rows = [_row(space, campaign, genes, place, with_risk=with_risk) for place in range(len(campaign.worst))]
    return columns(*head, rows=rows, header=True)


def _row(space: ParamSpace, campaign: Campaign, genes: Sequence[int], place: int, *, with_risk: bool) -> list[Text]:
    case = campaign.worst[place]
    cells = [Text(str(case.rank))]
    if with_risk:
        parts = campaign.evaluations.rollouts.parts[case.row, case.rollout]
        cells += [Text(str(case.score)), _parts(parts.tolist())]
    return cells + [Text(format_gene(space, gene, case.genome[gene])) for gene in genes]


def _parts(parts: Sequence[int]) -> Text:
    """`10+4+3+4`, each part in its colour; their order is C, MD, D_MS, TTC_MS."""
    pieces: list[str | tuple[str, str]] = []
    for (name, _, _), points in zip(PARTS, parts, strict=True):
        pieces += [("+", "quiet")] if pieces else []
        pieces.append((str(points), f"part.{name}"))
    return Text.assemble(*pieces)


def gene_header(space: ParamSpace, gene: int) -> list[str]:
    """A gene's name in short lines, broken at its underscores, and its unit below."""
    lines: list[str] = []
    for word in space.names[gene].split("_"):
        if lines and len(lines[-1]) + 1 + len(word) <= LEAST_GENE_WIDTH - 2:
            lines[-1] += "_" + word
        else:
            lines.append(word)
    return [*lines[:4], space.units[gene]]


def common_line(space: ParamSpace, campaign: Campaign) -> RenderableType | None:
    """What the cases share: the params that lie within a tenth of their range in all of them. None: nothing."""
    shared = [text for gene in range(len(space)) if (text := _common(space, campaign, gene))]
    if not shared or len(campaign.worst) < 2:
        return None
    return Text.assemble(("alike: ", "quiet"), ", ".join(shared))


def _common(space: ParamSpace, campaign: Campaign, gene: int) -> str:
    values = [case.genome[gene] for case in campaign.worst]
    low, high = min(values), max(values)
    if high - low > ALIKE * float(space.high[gene] - space.low[gene]):
        return ""
    ends = list(dict.fromkeys(format_gene(space, gene, value) for value in (low, high)))
    return " ".join(filter(None, (space.names[gene], " .. ".join(ends), space.units[gene])))


def worst_files(report: SearchReport) -> RenderableType | None:
    """Where the concrete scenarios of the worst cases lie; None where there are none."""
    if not report.worst_files:
        return None
    first, last = report.worst_files[0], report.worst_files[-1]
    text = str(first) if first == last else f"{first} .. {last.name}"
    return Text.assemble(("again: ", "quiet"), f"cortexc {text}")
