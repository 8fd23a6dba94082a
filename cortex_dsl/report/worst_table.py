"""The worst cases of a search: their risk with its parts, and their params in the file's own units."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.table import Column
from rich.text import Text

from cortex_dsl.report.layout import columns, right
from cortex_dsl.report.numbers import ABSENT, format_gene
from cortex_dsl.report.run_document import PARTS
from cortex_dsl.report.search_report import SearchReport
from engine.program import ParamSpace, Program
from engine.search.assessment import Assessment
from engine.search.campaign import Campaign
from engine.search.ranking import Case

LEAST_GENE_WIDTH = 7
"""Narrower than this, a table of many genes is split into several."""
ALIKE = 0.1
"""Cases whose values of a gene span less of its range than this are called alike."""


def worst_table(program: Program, campaign: Campaign, width: int) -> RenderableType:
    """One row a case. A file with many params gets several tables, so that none is wider than the terminal."""
    judged = _judgement(program, campaign)
    room = 3 + sum(2 + max(*map(len, lines), *(cell.cell_len for cell in cells)) for lines, cells in judged)
    tables: list[RenderableType] = []
    for index, genes in enumerate(_blocks(program.space, width, room)):
        tables += [Text()] if index else []
        tables.append(_block(program.space, campaign, genes, [] if index else judged))
    return Group(*tables)


def _blocks(space: ParamSpace, width: int, room: int) -> list[list[int]]:
    """Genes of each table: as many as fit; the first one has other columns that take `room`."""
    blocks: list[list[int]] = [[]]
    used = room
    for gene in range(len(space)):
        needed = 2 + max(LEAST_GENE_WIDTH - 2, *(len(line) for line in gene_header(space, gene)))
        if used + needed > width and blocks[-1]:
            blocks.append([])
            used = 5
        blocks[-1].append(gene)
        used += needed
    return blocks


Judged = list[tuple[list[str], list[Text]]]
"""Columns in front of the genes: the lines of their heads, and a cell for each case."""


def _judgement(program: Program, campaign: Campaign) -> Judged:
    """Risk and its parts; and whom the ego hit or came near to, where there is more than one who may be meant."""
    worst, runs = campaign.worst, campaign.evaluations.rollouts
    found: Judged = [
        (["risk"], [Text(str(case.score)) for case in worst]),
        (["parts"], [_parts(runs.parts[case.row, case.rollout].tolist()) for case in worst]),
    ]
    if len(program.actors) > 2:
        found.append((["hit or", "near"], [_other(program, runs, case) for case in worst]))
    return found


def _other(program: Program, runs: Assessment, case: Case) -> Text:
    """The actor that decided the risk of a case."""
    pair = int(runs.pair[case.row, case.rollout])
    if pair < 0:
        return Text(ABSENT, "quiet")
    return Text(program.actors[pair + 1], "bad" if runs.collided[case.row, case.rollout] else "quiet")


def _block(space: ParamSpace, campaign: Campaign, genes: Sequence[int], judged: Judged) -> RenderableType:
    heads = [["#"], *(lines for lines, _ in judged), *(gene_header(space, gene) for gene in genes)]
    height = max(map(len, heads))
    styles = ["quiet", *("title" if lines == ["risk"] else "" for lines, _ in judged), *([""] * len(genes))]
    head: list[Column] = [
        right("\n".join([*[""] * (height - len(lines)), *lines]), style)
        for lines, style in zip(heads, styles, strict=True)
    ]
    rows = [
        [
            Text(str(case.rank)),
            *(cells[place] for _, cells in judged),
            *(Text(format_gene(space, gene, case.genome[gene])) for gene in genes),
        ]
        for place, case in enumerate(campaign.worst)
    ]
    return columns(*head, rows=rows, header=True)


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
