"""Details of a search: the metrics of the paper, params and genes, the ends of its runs, and rejected scenes."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.driven_runs import DRIVEN
from cortex_dsl.report.findings.paper_metrics import METRICS, PaperMetric, brief_of
from cortex_dsl.report.findings.readable import counted, fixed, percent, ratio, whole
from cortex_dsl.report.findings.search_report import (
    End,
    SearchReport,
    ends_of,
    method_name,
    method_style,
)
from cortex_dsl.report.findings.story import end_text
from cortex_dsl.report.findings.tally import Tally, blame_note
from cortex_dsl.report.terminal.requirements_view import blame_view, requirements_view
from cortex_dsl.report.terminal.theme import bar, columns, indented, left, right, section, sparkline
from cortex_dsl.report.terminal.worst_view import common_line, effect_note, genes_view, worst_files, worst_table
from engine.program import Program
from engine.search.evaluations import Figures
from engine.vocabulary import EndReason, Verdict

CURVE = 30
"""Widest course of a metric over the generations."""
BESIDE_CURVE = 60
"""Columns that the rest of its line takes."""
BESIDE_TWO_CURVES = 52
"""The same where two methods stand side by side."""
BAR = 16


def search_details(program: Program, report: SearchReport, width: int) -> RenderableType:
    """Return the details of a search for `--metrics`: params of the worst cases, effects, ends, files."""
    parts: list[RenderableType] = []
    campaign = report.campaign
    if campaign.worst:
        below = [line for line in (common_line(program.space, campaign), worst_files(report)) if line is not None]
        body = Group(worst_table(program, campaign, width - 2), *([Text(), *below] if below else []))
        parts.append(section("Params of the worst cases", body, "parts of the risk: C + MD + D_MS + TTC_MS"))
    if campaign.worst and len(program.space):
        parts.append(
            section("What each gene did", genes_view(program.space, campaign, width - 2), effect_note(campaign))
        )
    if np.isin(campaign.evaluations.rollouts.verdict, DRIVEN).any():
        parts.append(section("How runs ended", ends_table(program, report)))
    if report.folder is not None:
        parts.append(section("Results", results_view(report.folder), f"in {report.folder}/"))
    return Group(*parts)


def paper_details(reports: Sequence[SearchReport], settings: str, width: int) -> RenderableType:
    """Return the figures of the paper for `--paper`: its five metrics, and its count of collisions."""
    if len(reports) > 1:
        table = section("Side by side", comparison_table(reports, width), settings)
    else:
        table = section("Generations", generations_table(reports[0], width), settings)
    return Group(table, *(indented(Text(line, "quiet")) for report in reports for line in paper_lines(report)))


def paper_lines(report: SearchReport) -> Iterator[str]:
    """Yield the counts of the paper, in which a repeated elite counts again."""
    campaign = report.campaign
    everyone, name = campaign.by_individual, method_name(report.method)
    how = "as the paper counts, with repeated elites" if campaign.evaluations.reused.any() else "by individual"
    collisions, individuals = counted(everyone.nc, "collision"), counted(everyone.individuals, "individual")
    yield f"{name}, {how}: {collisions} among {individuals}; {campaign.distinct_collisions:,} colliding sets of params"


def rejections(program: Program, report: SearchReport) -> RenderableType | None:
    """Return why no scene of a search was valid; None if one was driven."""
    evaluations = report.campaign.evaluations
    tally = Tally.of_search(evaluations)
    if np.isin(evaluations.rollouts.verdict, DRIVEN).any() or not tally.attempts:
        return None
    note = "no scene was valid; tested only if the earlier ones held"
    parts = [section("Requirements", requirements_view(program, tally), note)]
    if report.blame is not None:
        parts.append(section("Which requirement is to blame", blame_view(report.blame), blame_note(report.blame)))
    return Group(*parts)


def generations_table(report: SearchReport, width: int) -> RenderableType:
    """Each metric: first and last generation, the whole run, and its course."""
    if not report.campaign.generations:
        return Text("no generation was finished", "warn")
    curve = max(8, min(CURVE, width - BESIDE_CURVE))
    first, last = (report.campaign.generations[i].by_individual for i in (0, -1))
    rows = [
        (
            Text(metric.name, "title"),
            _meaning(brief_of(metric, report.campaign.objective), metric.unit),
            *(_value(f, metric) for f in (first, last, report.campaign.by_individual)),
            Text(_course(report, metric.field, curve), method_style(report.method)),
        )
        for metric in METRICS
    ]
    head = (left(), left(wrap=True), right("first"), right("last"), right("whole run"), left("course"))
    return columns(*head, rows=rows, header=True)


def comparison_table(reports: Sequence[SearchReport], width: int) -> RenderableType:
    """Each metric over the whole run, one column a method, with its course; the courses of a row share one scale."""
    if len(reports) > 2:
        return methods_table(reports)
    rows = []
    curve = max(6, min(16, (width - BESIDE_TWO_CURVES) // 2))
    for metric in METRICS:
        cells: list[Text] = [
            Text(metric.name, "title"),
            _meaning(brief_of(metric, reports[0].campaign.objective), metric.unit),
        ]
        highest = max((value for report in reports for value in _values(report, metric.field)), default=0.0)
        for report in reports:
            cells += [
                _value(report.campaign.by_individual, metric),
                Text(_course(report, metric.field, curve, highest), method_style(report.method)),
            ]
        rows.append(tuple(cells))
    for title, meaning, value in (
        ("", "individuals", lambda r: r.campaign.by_individual.individuals),
        ("", "distinct simulations", lambda r: r.campaign.by_simulation.runs),
    ):
        cells = [Text(title), Text(meaning, "quiet")]
        for report in reports:
            cells += [Text(whole(value(report)), "quiet"), Text()]
        rows.append(tuple(cells))
    head = [left(), left(wrap=True)]
    for report in reports:
        head += [right(report.method, method_style(report.method)), left()]
    return columns(*head, rows=rows, header=True)


def methods_table(reports: Sequence[SearchReport]) -> RenderableType:
    """One row a method, for more of them than stand side by side."""
    rows = []
    for report in reports:
        campaign = report.campaign
        numbers = [_value(campaign.by_individual, metric) for metric in METRICS]
        distinct = [Text(whole(campaign.distinct_collisions)), Text(whole(campaign.by_simulation.runs), "quiet")]
        rows.append((Text(method_name(report.method), method_style(report.method)), *numbers, *distinct))
    head = [right(f"{metric.name} {metric.unit}".strip()) for metric in METRICS]
    return columns(left("method"), *head, right("distinct"), right("simulated"), rows=rows, header=True)


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


def results_view(folder: Path) -> RenderableType:
    """Return the existing files of a run directory, and the use of each."""
    rows = [(Text(name), Text(meaning, "quiet")) for name, meaning in RESULTS if (folder / name).exists()]
    return columns(left(), left(wrap=True), rows=rows)


END_STYLES = {EndReason.COLLISION: "bad", EndReason.BUILDING: "bad", EndReason.ABORTED: "warn"}


def ends_table(program: Program, report: SearchReport) -> RenderableType:
    """Return the endings of runs, and the share that each rule ended or invalidated; a repeated elite counts once."""
    ends = ends_of(program, report.campaign.evaluations)
    ran = [end for end in ends if end.verdict in DRIVEN]
    total = sum(end.count for end in ran)
    rows = [_end_row(end, ratio(end.count, total)) for end in ran]
    return columns(right(), right(), left(), left(wrap=True), rows=rows)


def _end_row(end: End, share: float) -> tuple[Text, Text, Text, Text]:
    crashed = "" if end.reason is None else END_STYLES.get(end.reason, "")
    style = ("bad" if end.verdict == Verdict.CONTROLLER else crashed) if end.count else ""
    return (
        Text(whole(end.count)),
        Text(percent(share) if share >= 0.0005 or not end.count else "< 0.1 %"),
        Text(bar(share, 1.0, BAR), style or "bar"),
        Text(end.text, style),
    )


def _meaning(meaning: str, unit: str) -> Text:
    return Text.assemble(meaning, (f" [{unit}]" if unit else "", "unit"))


def _value(figures: Figures, metric: PaperMetric) -> Text:
    return Text(fixed(float(getattr(figures, metric.field)), metric.decimals))


def _course(report: SearchReport, field: str, width: int, highest: float | None = None) -> str:
    """Generation by generation from zero up, so that noise looks as small as it is."""
    every = [float(getattr(f.by_individual, field)) for f in report.campaign.generations]
    return sparkline(every, width, low=0.0, high=highest)


def _values(report: SearchReport, field: str) -> list[float]:
    """A metric in every generation that has it."""
    values = (float(getattr(f.by_individual, field)) for f in report.campaign.generations)
    return [value for value in values if math.isfinite(value)]


def failures_line(program: Program, report: SearchReport) -> Text | None:
    """Return a line on runs that the engine could not finish; None without any."""
    campaign = report.campaign
    runs = campaign.evaluations.rollouts
    failed = (runs.verdict == Verdict.ERROR) & (runs.end_reason != EndReason.STUCK)
    if not failed.any():
        return None
    reasons = Counter(zip(runs.end_reason[failed].tolist(), runs.end_rule[failed].tolist(), strict=True))
    (reason, rule), _ = reasons.most_common(1)[0]
    what = end_text(program, EndReason(reason), rule) if reason >= 0 else "a scene could not be drawn"
    return Text.assemble(
        (f"{counted(int(failed.sum()), 'run')} failed and are not counted", "bad"), f": {what}; please report it"
    )
