"""The worst cases of a search with their params in the file's own units, and the effect of each gene."""

import math
from collections.abc import Sequence
from shlex import quote

import numpy as np
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.table import Column
from rich.text import Text

from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.failures import finds_of
from cortex_dsl.report.findings.readable import ABSENT, column_decimals, fixed, format_gene, significant
from cortex_dsl.report.findings.run_report import PARTS
from cortex_dsl.report.findings.search_report import SearchReport
from cortex_dsl.report.terminal.theme import bar, columns, left, right, sparkline
from engine.outcomes import Assessment
from engine.program import ParamSpace, Program
from engine.search.campaign import Campaign
from engine.search.insight.gene_effects import GeneEffect
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.ranking import Case, order_of_risk
from engine.tables import Floats
from engine.vocabulary import Blame, GeneKind

LEAST_GENE_WIDTH = 7
"""Narrower than this, a table of many genes is split into several."""
ALIKE = 0.1
"""Share of a gene's range below which the spread of its values counts as equal."""


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
    """Return the genes of each table: as many as fit; the first table has other columns of width `room`."""
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


AVOIDABLE = {
    Blame.AVOIDABLE: ("yes", "bad"),
    Blame.UNAVOIDABLE: ("no", "warn"),
    Blame.STRUCK: ("struck", "quiet"),
    Blame.NONE: (ABSENT, "quiet"),
}
"""Answers of the reference driver in a column that leaves room for params, and their styles."""

Judged = list[tuple[list[str], list[Text]]]
"""Columns in front of the genes: the lines of their heads, and a cell for each case."""


def _judgement(program: Program, campaign: Campaign) -> Judged:
    """Return risk and its parts, and the ego's partner if there are several."""
    worst, runs = campaign.worst, campaign.evaluations.rollouts
    found: Judged = [
        (["risk"], [Text(ABSENT if case.lost else str(case.score)) for case in worst]),
        (["parts"], [_parts(runs.parts[case.row, case.rollout].tolist(), lost=case.lost) for case in worst]),
    ]
    if campaign.objective != DEFAULT_OBJECTIVES:
        found.insert(0, (["objec-", "tive"], [Text(significant(case.continuous)) for case in worst]))
    if any(case.collided for case in worst):
        found.append((["avoid-", "able"], [_blame(campaign, case) for case in worst]))
    if len(program.actors) > 2:
        found.append((["hit or", "near"], [_other(program, runs, case) for case in worst]))
    return found


def _blame(campaign: Campaign, case: Case) -> Text:
    """Return the word for whether the reference driver avoids a case."""
    return Text(*AVOIDABLE[Blame(int(campaign.blame[case.row, case.rollout]))])


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


def _parts(parts: Sequence[int], *, lost: bool) -> Text:
    """`10+4+3+4`, each part in its colour; their order is C, MD, D_MS, TTC_MS. Of a lost run there are none."""
    if lost:
        return Text("failed", "bad")
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
    """Return the params that lie within a tenth of their range in all cases; None without any."""
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
    """Return the places of the concrete scenarios of the worst cases; None without any."""
    if not report.worst_files:
        return None
    first, last = report.worst_files[0], report.worst_files[-1]
    text = quote(as_argument(first)) + ("" if first == last else f" .. {last.name}")
    drives = f" {report.driver}" if report.driver else ""
    return Text.assemble(("again: ", "quiet"), f"cortexc {text}{drives}")


# -- effect of each gene, and the bad cases in its range ---------------------------------------------------------------

BINS = 16
BAR = 6
ROOMY = 94
"""Columns from which the ends of each range are shown too."""
LEGEND = """\
effect: change of risk in points when this param moves half its range and what
the file chooses (lanes, routes) stays; in: so many cases could be compared
trend: rank correlation with {goal}, -1 to +1
bad cases: where in the range they lie; worst tenth: where 90 % of it lies"""
"""Meanings of the columns; fits 80 columns."""
FEW = 10
"""Number of collisions below which the riskiest tenth replaces them."""


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
    rows = [_gene_row(space, index, gene, genomes[:, index], most) for index, gene in enumerate(campaign.genes)]
    table = columns(*(head[i] for i in kept), rows=[[row[i] for i in kept] for row in rows], header=True)
    dead = [gene.name for gene in campaign.genes if gene.dead]
    legend = LEGEND.format(goal=finds_of(campaign.objective).goal)
    return Group(table, *([_dead_line(dead)] if dead else []), Text(), Text(legend, "quiet"))


def effect_note(campaign: Campaign) -> str:
    """Return the definition of the bad cases, for the heading."""
    found = int(np.count_nonzero(campaign.evaluations.simulated & campaign.evaluations.found))
    bad = f"{found:,} {finds_of(campaign.objective).many}" if found >= FEW else "the worst tenth"
    return f"bad cases: {bad}"


def bad_cases(campaign: Campaign) -> NDArray[np.intp]:
    """Return the rows of all simulated collisions, or of finds of another objective; if few, of the worst tenth."""
    evaluations = campaign.evaluations
    found = np.flatnonzero(evaluations.simulated & evaluations.found)
    if len(found) >= FEW:
        return found
    order = order_of_risk(evaluations)
    return np.asarray(order[: max(1, len(order) // 10)], dtype=np.intp)


def _gene_row(space: ParamSpace, gene: int, effect: GeneEffect, bad: Floats, most: float) -> tuple[Text, ...]:
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
    """Return the range that holds nine tenths of the worst tenth, or the most frequent option."""
    if space.kinds[gene] == GeneKind.INDEX:
        often = int(np.bincount(bad.astype(int)).argmax()) if len(bad) else 0
        return Text(f"mostly {format_gene(space, gene, often)}")
    decimals = max(0, column_decimals(float(space.low[gene]), float(space.high[gene])) - 1)
    unit = f" {space.units[gene]}" if space.units[gene] else ""
    return Text.assemble(f"{fixed(effect.worst.low, decimals)} .. {fixed(effect.worst.high, decimals)}", (unit, "unit"))


def _dead_line(names: list[str]) -> Text:
    changes = "changes" if len(names) == 1 else "change"
    return Text.assemble((", ".join(names), "warn"), f" {changes} nothing: a search could do without")
