"""What a study came to, in the terminal: the verdict, a table for each scenario, and the paper beside it."""

from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, heading, indented, left, right, section
from cortex_dsl.report.numbers import counted, duration, fixed
from cortex_dsl.report.study_paper_view import paper_sections
from engine.study.comparisons import Comparison, Spread
from engine.study.findings import RULE, Findings
from engine.study.plan import Plan
from engine.study.reading import Study

SHOWN = (
    "distinct collisions",
    "distinct failures",
    "RL",
    "NC",
    "MDG",
    "MDEC",
    "NIS",
    "NIS, last 10",
)
"""Measures of the terminal's tables; the others stand in tests.csv."""
FILES = (
    ("tests.csv", "every measure, spread, p and A12, whole run and last ten generations"),
    ("runs.csv", "every figure of every run"),
    ("generations.csv", "the figures of every generation of every run"),
    ("summary.json", "what this page says, for programs"),
    ("study.sqlite", "all of it, and every evaluation"),
)


def study_view(study: Study, findings: Findings) -> RenderableType:
    """The whole report."""
    return Group(
        *_head(study, findings),
        *(_scenario(study, findings, subject.name) for subject in study.plan.subjects),
        *paper_sections(findings),
        section(
            "Files",
            columns(left(), left(wrap=True), rows=[(a, Text(b, "quiet")) for a, b in FILES]),
            f"in {study.folder}/",
        ),
    )


def _head(study: Study, findings: Findings) -> Iterator[RenderableType]:
    plan, records = study.plan, study.records
    search = plan.subjects[0].config.search
    simulations = sum(record.figures.simulations.runs for record in records)
    seconds = sum(record.seconds for record in records)
    methods = ", ".join(f"{method} {plan.preset(method)}".strip() for method in plan.methods)
    note = (
        f"{len(plan.subjects)} x {len(plan.methods)} x {plan.runs} runs of {search.generations} x {search.population}"
    )
    yield heading("Study", f"{note}; {methods}; seed {search.seed}, profile {plan.profile}")
    yield Text(f"{counted(simulations, 'simulation')}, {duration(seconds)} of work", "quiet")
    if not study.complete:
        total = plan.runs * len(plan.subjects) * len(plan.methods)
        yield Text(f"not complete: {len(records):,} of {total:,} runs", "warn")
    if failed := sum(record.figures.simulations.error_runs for record in records):
        yield Text(f"{counted(failed, 'simulation')} failed and count nowhere", "bad")
    yield Text()
    for sentence in findings.verdict:
        yield Text(sentence, "title")
    yield Text(RULE, "quiet")


def _scenario(study: Study, findings: Findings, name: str) -> RenderableType:
    rows = [row for row in findings.comparisons if row.scenario == name]
    if not rows:
        return _alone(study.plan, name)
    table = _pair(study.plan, rows) if len(study.plan.methods) == 2 else _many(study.plan, rows)
    return section(name, table)


def _alone(plan: Plan, name: str) -> RenderableType:
    return indented(Text(f"{name}: {plan.methods[0]} alone, see runs.csv", "quiet"))


def _shown(rows: Sequence[Comparison]) -> Iterator[Comparison]:
    for name in SHOWN:
        yield from (row for row in rows if row.measure.name == name)


def _pair(plan: Plan, rows: Sequence[Comparison]) -> RenderableType:
    """Two methods: one line a measure, both spreads side by side."""
    (contender,) = plan.contenders
    head = [
        left(),
        right(plan.baseline, f"method.{plan.baseline}"),
        left("[IQR]", "quiet"),
        right(contender, f"method.{contender}"),
        left("[IQR]", "quiet"),
        right("p, Holm"),
        left(),
        right("A12"),
        left("95 %", "quiet"),
    ]
    body = [
        (_name(row), *_spread(row.baseline_spread, row), *_spread(row.spread, row), *_test(row)) for row in _shown(rows)
    ]
    return columns(*head, rows=body, header=True)


def _many(plan: Plan, rows: Sequence[Comparison]) -> RenderableType:
    """More methods: under each measure one line a method, the baseline first."""
    body: list[tuple[RenderableType, ...]] = []
    for name in SHOWN:
        of = [row for row in rows if row.measure.name == name]
        first = of[0]
        body.append((_name(first), _method(plan.baseline), *_spread(first.baseline_spread, first), *[Text()] * 4))
        body += [(Text(), _method(row.method), *_spread(row.spread, row), *_test(row)) for row in of]
    head = (
        left(),
        left(),
        right("median"),
        left("[IQR]", "quiet"),
        right("p, Holm"),
        left(),
        right("A12"),
        left("95 %", "quiet"),
    )
    return columns(*head, rows=body, header=True)


def _method(name: str) -> Text:
    return Text(name, f"method.{name}")


def _name(row: Comparison) -> Text:
    unit = f" [{row.measure.unit}]" if row.measure.unit else ""
    return Text.assemble(row.measure.name, (unit, "unit"))


def _spread(spread: Spread, row: Comparison) -> tuple[Text, Text]:
    low, high = (fixed(value, row.measure.decimals) for value in spread.quartiles)
    return Text(fixed(spread.median, row.measure.decimals)), Text(f"[{low}, {high}]")


def _test(row: Comparison) -> tuple[Text, Text, Text, Text]:
    style = "good" if row.beats else "bad" if row.loses else ""
    interval = f"[{fixed(row.interval.low, 2)}, {fixed(row.interval.high, 2)}]"
    return Text(p_text(row.p_holm)), Text(row.stars, style), Text(fixed(row.a12, 2), style), Text(interval)


def p_text(p: float) -> str:
    """Four decimals, and no pretence of more."""
    return "< 0.0001" if p < 1e-4 else fixed(p, 4)
