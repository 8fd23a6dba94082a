"""Details of a search: the metrics of the paper, params of the worst cases, effects of genes, and the ends of runs."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from shlex import quote

import numpy as np

from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.blocks import Bar, Bars, Block, Column, Facts, Gauge, Note, Spark, Table, Title, Value, Words
from cortex_dsl.report.findings.driven_runs import DRIVEN
from cortex_dsl.report.findings.failures import finds_of
from cortex_dsl.report.findings.paper_metrics import METRICS, PaperMetric, brief_of
from cortex_dsl.report.findings.readable import (
    ABSENT,
    column_decimals,
    counted,
    fixed,
    format_gene,
    significant,
    whole,
)
from cortex_dsl.report.findings.run_report import PARTS
from cortex_dsl.report.findings.search_report import End, SearchReport, ends_of, method_name, method_style
from engine.outcomes import Assessment
from engine.program import ParamSpace, Program
from engine.search.campaign import Campaign
from engine.search.evaluations import Figures
from engine.search.insight.gene_effects import GeneEffect
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.ranking import Case, order_of_risk
from engine.tables import Floats, Ints
from engine.vocabulary import Blame, EndReason, GeneKind, Verdict

NUMBER = Column(numbers=True)


def search_details(program: Program, report: SearchReport) -> list[Title]:
    """Return the details of a search for `--metrics`: params of the worst cases, effects, ends, files."""
    campaign, space = report.campaign, program.space
    views: list[Title] = []
    if campaign.worst:
        below = [*_common_line(space, campaign), *_again(report)]
        blocks = [worst_table(program, campaign), *([Note(""), *below] if below else [])]
        views.append(Title("Params of the worst cases", blocks, "parts of the risk: C + MD + D_MS + TTC_MS"))
    if campaign.worst and len(space):
        views.append(Title("What each gene did", genes_blocks(space, campaign), _bad_note(campaign)))
    if np.isin(campaign.evaluations.rollouts.verdict, DRIVEN).any():
        ran = [end for end in ends_of(program, campaign.evaluations) if end.verdict in DRIVEN]
        views.append(Title("How runs ended", [Bars([_end(end) for end in ran], sum(end.count for end in ran))]))
    if report.folder is not None:
        views.append(Title("Results", [results(report.folder)], f"in {report.folder}/"))
    return views


END_STYLES = {EndReason.COLLISION: "bad", EndReason.BUILDING: "bad", EndReason.ABORTED: "warn"}


def _end(end: End) -> Bar:
    crashed = "" if end.reason is None else END_STYLES.get(end.reason, "")
    return Bar(end.count, end.text, ("bad" if end.verdict == Verdict.CONTROLLER else crashed) if end.count else "")


RESULTS: Sequence[tuple[str, str]] = (
    ("README.md", "every file and every column explained"),
    ("worst/", "the worst cases, each a scenario of its own"),
    ("failures/", "scenes over which the driver failed, to be driven again"),
    ("controller.log", "where the driver failed, one line for each scene"),
    ("summary.json", "the figures of this page, for programs"),
    ("evaluations.csv", "every simulation: params, verdict, metrics (SI), risk"),
    ("evaluations.jsonl", "the same as JSON, with the counts of each requirement"),
    ("critical.csv", "the same, but only risks of 14 and more"),
    ("generations.csv", "RL, NC, MDG, MDEC and NIS of every generation"),
    ("journal.sqlite", "everything, and all that is needed to repeat it"),
)
"""Files of a run directory."""


def results(folder: Path) -> Facts:
    """Return the existing files of a run directory, and the use of each."""
    return Facts([(name, Value(meaning, "quiet")) for name, meaning in RESULTS if (folder / name).exists()])


# -- the figures of the paper ------------------------------------------------------------------------------------------


def paper_details(reports: Sequence[SearchReport], settings: str) -> Title:
    """Return the figures of the paper for `--paper`: its five metrics, and its count of collisions."""
    lines = [Note(line, "quiet") for report in reports for line in paper_lines(report)]
    if len(reports) > 2:
        return Title("Side by side", [_methods_table(reports), *lines], settings)
    if len(reports) == 2:
        return Title("Side by side", [_comparison_table(reports), *lines], settings)
    return Title("Generations", [_generations(reports[0]), *lines], settings)


def paper_lines(report: SearchReport) -> Iterator[str]:
    """Yield the counts of the paper, in which a repeated elite counts again."""
    campaign = report.campaign
    everyone, name = campaign.by_individual, method_name(report.method)
    how = "as the paper counts, with repeated elites" if campaign.evaluations.reused.any() else "by individual"
    collisions, individuals = counted(everyone.nc, "collision"), counted(everyone.individuals, "individual")
    yield f"{name}, {how}: {collisions} among {individuals}; {campaign.distinct_collisions:,} colliding sets of params"


def _generations(report: SearchReport) -> Block:
    """Return each metric in the first and last generation and the whole run, with its course."""
    campaign = report.campaign
    if not campaign.generations:
        return Note("no generation was finished", "warn")
    figures = (*(campaign.generations[i].by_individual for i in (0, -1)), campaign.by_individual)
    rows = [
        (*_metric(metric, campaign), *(_value(each, metric) for each in figures), _course(report, metric, 30))
        for metric in METRICS
    ]
    numbers = (Column(head, numbers=True) for head in ("first", "last", "whole run"))
    return Table((Column(), Column(wrap=True), *numbers, Column("course")), rows, name="generations")


def _comparison_table(reports: Sequence[SearchReport]) -> Table:
    """Return each metric over the whole run, a column for each method; the courses of a row have one scale."""
    rows: list[Sequence[Words]] = []
    for metric in METRICS:
        every = [_every(report, metric) for report in reports]
        high = max((value for values in every for value in values if math.isfinite(value)), default=0.0)
        pairs = ((_value(r.campaign.by_individual, metric), _course(r, metric, 16, high)) for r in reports)
        rows.append((*_metric(metric, reports[0].campaign), *(cell for pair in pairs for cell in pair)))
    individuals = [report.campaign.by_individual.individuals for report in reports]
    runs = [report.campaign.by_simulation.runs for report in reports]
    for meaning, counts in (("individuals", individuals), ("distinct simulations", runs)):
        cells = [cell for count in counts for cell in (Value(whole(count), "quiet", count), "")]
        rows.append(("", Value(meaning, "quiet"), *cells))
    heads = [(Column(r.method, numbers=True, style=method_style(r.method)), Column()) for r in reports]
    return Table((Column(), Column(wrap=True), *(head for pair in heads for head in pair)), rows, name="generations")


def _methods_table(reports: Sequence[SearchReport]) -> Table:
    """Return a row for each method, for more methods than stand side by side."""
    rows = [
        (
            Value(method_name(report.method), method_style(report.method)),
            *(_value(report.campaign.by_individual, metric) for metric in METRICS),
            whole(report.campaign.distinct_collisions),
            Value(whole(report.campaign.by_simulation.runs), "quiet"),
        )
        for report in reports
    ]
    heads = (*(f"{metric.name} {metric.unit}".strip() for metric in METRICS), "distinct", "simulated")
    return Table((Column("method"), *(Column(head, numbers=True) for head in heads)), rows, name="generations")


def _metric(metric: PaperMetric, campaign: Campaign) -> tuple[Words, Words]:
    unit = Value(f" [{metric.unit}]" if metric.unit else "", "unit")
    return Value(metric.name, "title"), (brief_of(metric, campaign.objective), unit)


def _value(figures: Figures, metric: PaperMetric) -> Value:
    number = float(getattr(figures, metric.field))
    return Value(fixed(number, metric.decimals), "", number)


def _every(report: SearchReport, metric: PaperMetric) -> list[float]:
    return [float(getattr(f.by_individual, metric.field)) for f in report.campaign.generations]


def _course(report: SearchReport, metric: PaperMetric, length: int, high: float | None = None) -> Spark:
    """Return a metric by generation, from zero up, so that noise looks as small as it is."""
    return Spark(style=method_style(report.method), values=_every(report, metric), length=length, low=0.0, high=high)


# -- the worst cases with their params ---------------------------------------------------------------------------------

HEAD = 5
"""Characters to which words of the name of a param are joined."""
ALIKE = 0.1
"""Share of a param's range below which the spread of its values counts as equal."""
AVOIDABLE = {
    Blame.AVOIDABLE: ("yes", "bad"),
    Blame.DISPUTED: ("disputed", "bad"),
    Blame.UNAVOIDABLE: ("no", "warn"),
    Blame.NO_MODEL: ("no model", "quiet"),
    Blame.STRUCK: ("struck", "quiet"),
    Blame.NONE: (ABSENT, "quiet"),
}
"""Answers of the reference driver in a column that leaves room for params, and their styles."""


def worst_table(program: Program, campaign: Campaign) -> Table:
    """Return one row for each case: its risk with the parts, then its params."""
    space, worst = program.space, campaign.worst
    judged = list(_judgement(program, campaign))
    genes = range(len(space))
    heads = [["#"], *(head for head, _ in judged), *(gene_header(space, gene) for gene in genes)]
    height = max(map(len, heads))
    styles = {"#": "quiet", "risk": "title"}
    columns = [
        Column("\n".join([*[""] * (height - len(head)), *head]), numbers=True, style=styles.get("".join(head), ""))
        for head in heads
    ]
    rows = [
        (
            str(case.rank),
            *(cells[place] for _, cells in judged),
            *(Value(format_gene(space, gene, case.genome[gene]), "", case.genome[gene]) for gene in genes),
        )
        for place, case in enumerate(worst)
    ]
    return Table(columns, rows, name="worst", split=True)


def _judgement(program: Program, campaign: Campaign) -> Iterator[tuple[list[str], list[Words]]]:
    """Yield the columns before the params, as lines of their heads and a cell for each case: the objective, the risk
    and its parts, the answer of the reference driver, and the ego's partner if there are several.
    """
    worst, runs = campaign.worst, campaign.evaluations.rollouts
    if campaign.objective != DEFAULT_OBJECTIVES:
        yield ["objec-", "tive"], [significant(case.continuous) for case in worst]
    yield ["risk"], [ABSENT if case.lost else str(case.score) for case in worst]
    yield ["parts"], [_parts(runs.parts[case.row, case.rollout].tolist(), lost=case.lost) for case in worst]
    if any(case.collided for case in worst):
        blame = (Blame(int(campaign.blame[case.row, case.rollout])) for case in worst)
        yield ["avoid-", "able"], [Value(*AVOIDABLE[each]) for each in blame]
    if len(program.actors) > 2:
        yield ["hit or", "near"], [_other(program, runs, case) for case in worst]


def _other(program: Program, runs: Assessment, case: Case) -> Words:
    """Return the actor that decided the risk of a case."""
    pair = int(runs.pair[case.row, case.rollout])
    collided = pair >= 0 and bool(runs.collided[case.row, case.rollout])
    return Value(program.actors[pair + 1] if pair >= 0 else ABSENT, "bad" if collided else "quiet")


def _parts(parts: Sequence[int], *, lost: bool) -> Words:
    """Return `10+4+3+4`, each part in its colour, in the order C, MD, D_MS, TTC_MS; a lost run has none."""
    if lost:
        return Value("failed", "bad")
    words = [(Value("+", "quiet"), Value(str(n), f"part.{part[0]}")) for part, n in zip(PARTS, parts, strict=True)]
    return [word for pair in words for word in pair][1:]


def gene_header(space: ParamSpace, gene: int) -> list[str]:
    """Return the name of a gene in short lines, broken at its underscores, with its unit below."""
    lines: list[str] = []
    for word in space.names[gene].split("_"):
        if lines and len(lines[-1]) + 1 + len(word) <= HEAD:
            lines[-1] += "_" + word
        else:
            lines.append(word)
    return [*lines[:4], space.units[gene]]


def _common_line(space: ParamSpace, campaign: Campaign) -> Iterator[Note]:
    """Yield the params that lie within a tenth of their range in all cases."""
    shared = [text for gene in range(len(space)) if (text := _common(space, campaign, gene))]
    if shared and len(campaign.worst) > 1:
        yield Note((Value("alike: ", "quiet"), ", ".join(shared)))


def _common(space: ParamSpace, campaign: Campaign, gene: int) -> str:
    values = [case.genome[gene] for case in campaign.worst]
    low, high = min(values), max(values)
    if high - low > ALIKE * float(space.high[gene] - space.low[gene]):
        return ""
    ends = list(dict.fromkeys(format_gene(space, gene, value) for value in (low, high)))
    return " ".join(filter(None, (space.names[gene], " .. ".join(ends), space.units[gene])))


def _again(report: SearchReport) -> Iterator[Note]:
    """Yield the places of the concrete scenarios of the worst cases."""
    if files := report.worst_files:
        text = quote(as_argument(files[0])) + ("" if len(files) == 1 else f" .. {files[-1].name}")
        drives = f" {report.driver}" if report.driver else ""
        yield Note((Value("again: ", "quiet"), f"cortexc {text}{drives}"))


# -- effect of each gene, and the bad cases in its range ---------------------------------------------------------------

BINS = 16
EFFECT = 6
ROOMY = 94
"""Characters of a line from which the ends of each range are shown too."""
LEGEND = """\
effect: change of risk in points when this param moves half its range and what
the file chooses (lanes, routes) stays; in: so many cases could be compared
trend: rank correlation with {goal}, -1 to +1
bad cases: where in the range they lie; worst tenth: where 90 % of it lies"""
"""Meanings of the columns; fits 80 columns."""
FEW = 10
"""Number of collisions below which the riskiest tenth replaces them."""


def genes_blocks(space: ParamSpace, campaign: Campaign) -> list[Block]:
    """Return one row for each gene: its effect, its trend, the bad cases over its range, and where the worst lie."""
    most = max((gene.effect for gene in campaign.genes if math.isfinite(gene.effect)), default=0.0)
    genomes = campaign.evaluations.genomes[_bad_cases(campaign)]
    rows = [_gene_row(space, index, gene, genomes[:, index], most) for index, gene in enumerate(campaign.genes)]
    columns = (
        Column("gene"),
        Column("effect", numbers=True),
        Column(),
        Column("in", numbers=True),
        Column("trend", numbers=True),
        Column(numbers=True, least=ROOMY),
        Column("bad cases"),
        Column(least=ROOMY),
        Column("worst tenth", wrap=True),
    )
    blocks: list[Block] = [Table(columns, rows, name="genes")]
    if dead := [gene.name for gene in campaign.genes if gene.dead]:
        changes = "changes" if len(dead) == 1 else "change"
        blocks.append(Note((Value(", ".join(dead), "warn"), f" {changes} nothing: a search could do without")))
    return [*blocks, Note(LEGEND.format(goal=finds_of(campaign.objective).goal), "quiet", apart=True)]


def _bad_note(campaign: Campaign) -> str:
    """Return the definition of the bad cases."""
    found = int(np.count_nonzero(campaign.evaluations.simulated & campaign.evaluations.found))
    bad = f"{found:,} {finds_of(campaign.objective).many}" if found >= FEW else "the worst tenth"
    return f"bad cases: {bad}"


def _bad_cases(campaign: Campaign) -> Ints:
    """Return the rows of all simulated collisions, or of finds of another objective; if few, of the worst tenth."""
    evaluations = campaign.evaluations
    found = np.flatnonzero(evaluations.simulated & evaluations.found)
    order = order_of_risk(evaluations)
    return found if len(found) >= FEW else np.asarray(order[: max(1, len(order) // 10)], dtype=np.intp)


def _gene_row(space: ParamSpace, gene: int, effect: GeneEffect, bad: Floats, most: float) -> Sequence[Words]:
    is_index = space.kinds[gene] == GeneKind.INDEX
    low, high = ("", "") if is_index else (significant(float(bounds[gene])) for bounds in (space.low, space.high))
    known = most > 0.0 and math.isfinite(effect.effect)
    return (
        effect.name,
        Value("none", "warn") if effect.dead else Value(fixed(effect.effect, 1), "", effect.effect),
        Gauge(style="bar", share=effect.effect / most if known else 0.0, length=EFFECT),
        Value(str(effect.compared) if effect.probes else ABSENT, "quiet"),
        f"{effect.correlation:+.2f}" if math.isfinite(effect.correlation) else ABSENT,
        Value(low, "quiet"),
        Spark(style="part.C", values=_histogram(space, gene, bad), length=BINS, low=0.0),
        Value(high, "quiet"),
        _worst(space, gene, effect, bad),
    )


def _histogram(space: ParamSpace, gene: int, values: Floats) -> list[float]:
    """Return the counts of values over the range of a param, or of its options; NaN for none."""
    if space.kinds[gene] == GeneKind.INDEX:
        counts = np.bincount(values.astype(int), minlength=len(space.options[gene]))
    else:
        counts, _ = np.histogram(values, bins=BINS, range=(float(space.low[gene]), float(space.high[gene])))
    return [count or math.nan for count in counts.tolist()]


def _worst(space: ParamSpace, gene: int, effect: GeneEffect, bad: Floats) -> Words:
    """Return the range that holds nine tenths of the worst tenth, or the most frequent option."""
    if space.kinds[gene] == GeneKind.INDEX:
        often = int(np.bincount(bad.astype(int)).argmax()) if len(bad) else 0
        return f"mostly {format_gene(space, gene, often)}"
    decimals = max(0, column_decimals(float(space.low[gene]), float(space.high[gene])) - 1)
    unit = Value(f" {space.units[gene]}" if space.units[gene] else "", "unit")
    return f"{fixed(effect.worst.low, decimals)} .. {fixed(effect.worst.high, decimals)}", unit
