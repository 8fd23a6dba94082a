"""What a study came to, in the terminal: the verdict, a table for each scenario, and the paper beside it."""

from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import MARGIN, columns, heading, indented, left, right, section
from cortex_dsl.report.numbers import counted, duration, fixed
from cortex_dsl.report.study_numbers import missing_lines, p_text, quartiles, told
from cortex_dsl.report.study_paper_view import paper_sections
from cortex_dsl.report.theme import method_style
from engine.study.comparisons import Comparison, Spread
from engine.study.database import Study
from engine.study.plan import Plan
from engine.study.verdict import FAMILIES, RULE, Findings

SHOWN = (
    "colliding genomes",
    "distinct failures",
    "RL",
    "NC",
    "MDG",
    "MDEC",
    "NIS",
    "NIS, last 10",
)
"""Measures of the terminal's tables; the others stand in tests.csv."""
STACKED = 3
"""Most methods whose spreads are told in the terminal."""
SIDE_BY_SIDE = 98
"""Columns that two methods side by side take."""
NEEDED = {3: 76, 7: 90}
"""Columns that must be there for the quartiles and the interval of a stacked table."""
MATRIX_NAME, MATRIX_CELL = 34, 8
FILES = (
    ("tests.csv", "every measure, spread, p and A12, whole run and last ten generations"),
    ("runs.csv", "every figure of every run"),
    ("generations.csv", "the figures of every generation of every run"),
    ("summary.json", "what this page says, for programs"),
    ("study.sqlite", "all of it, and every evaluation"),
)


def study_view(study: Study, findings: Findings, width: int) -> RenderableType:
    """The whole report."""
    if not study.records:
        return Group(*_head(study, findings))
    return Group(
        *_head(study, findings),
        *(_scenario(study, findings, subject.name, width) for subject in study.plan.subjects),
        *paper_sections(findings, width),
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
    yield heading("Study", f"{note}; {methods}; {_seeds(plan)}, profile {plan.profile}")
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
    yield Text(FAMILIES, "quiet")


def _seeds(plan: Plan) -> str:
    """`seeds 0 to 5`: each scenario has its own."""
    first, last = plan.seeds[0], plan.seeds[-1]
    return f"seed {first}" if first == last else f"seeds {first} to {last}"


def _scenario(study: Study, findings: Findings, name: str, width: int) -> RenderableType:
    """As much as there is room for; tests.csv has all of it."""
    plan, rows = study.plan, [row for row in findings.comparisons if row.scenario == name]
    room = width - MARGIN
    if not rows:
        return indented(Text(f"{name}: {plan.methods[0]} alone, see runs.csv", "quiet"))
    if len(plan.methods) > STACKED:
        return section(name, _matrix(plan, rows, room), "medians; p, A12 and quartiles stand in tests.csv")
    table = _pair(plan, rows) if len(plan.methods) == 2 and room >= SIDE_BY_SIDE else _stack(plan, rows, room)
    lines = [Text(line, "quiet") for line in missing_lines(rows)]
    return section(name, Group(table, *lines))


def _pair(plan: Plan, rows: Sequence[Comparison]) -> RenderableType:
    """Two methods: one line a measure, both spreads side by side."""
    (contender,) = plan.contenders
    head = [left()]
    for method in (plan.baseline, contender):
        head += [right(method, method_style(method)), left("[IQR]", "quiet")]
    head += [right("p, Holm"), left(), right("A12"), left("95 %", "quiet")]
    body = [
        (_name(row), *_spread(row.baseline_spread, row), *_spread(row.spread, row), *_test(row))
        for name in SHOWN
        for row in _of(rows, name)
    ]
    return columns(*head, rows=body, header=True)


def _stack(plan: Plan, rows: Sequence[Comparison], room: int) -> RenderableType:
    """Under each measure one line a method, the baseline first; intervals and quartiles where there is room."""
    head = [left(), left(), right("median"), left("[IQR]", "quiet")]
    head += [right("p, Holm"), left(), right("A12"), left("95 %", "quiet")]
    body: list[tuple[RenderableType, ...]] = []
    for name in SHOWN:
        of = _of(rows, name)
        body.append((_name(of[0]), _method(plan.baseline), *_spread(of[0].baseline_spread, of[0]), *[Text()] * 4))
        body += [(Text(), _method(row.method), *_spread(row.spread, row), *_test(row)) for row in of]
    shown = [at for at in range(len(head)) if room >= NEEDED.get(at, 0)]
    return columns(*(head[at] for at in shown), rows=[[row[at] for at in shown] for row in body], header=True)


def _matrix(plan: Plan, rows: Sequence[Comparison], room: int) -> RenderableType:
    """Many methods: one line each, one column a measure; green where one beats the baseline, red where it loses."""
    names = SHOWN[: max(1, (room - MATRIX_NAME) // MATRIX_CELL)]
    body = [
        [
            _method(plan.baseline),
            *(Text(told(of[0].baseline_spread.median, of[0])) for of in (_of(rows, n) for n in names)),
        ]
    ]
    for method in plan.contenders:
        mine = [next(row for row in _of(rows, name) if row.method == method) for name in names]
        body.append([_method(method), *(Text(told(row.spread.median, row), _style(row)) for row in mine)])
    heads = (_of(rows, name)[0].title.replace("distinct ", "d. ").replace("last 10", "end") for name in names)
    return columns(left(), *map(right, heads), rows=body, header=True)


def _of(rows: Sequence[Comparison], name: str) -> list[Comparison]:
    return [row for row in rows if row.measure.name == name]


def _method(name: str) -> Text:
    return Text(name, method_style(name))


def _name(row: Comparison) -> Text:
    unit = f" [{row.measure.unit}]" if row.measure.unit else ""
    return Text.assemble(row.title, (unit, "unit"))


def _spread(spread: Spread, row: Comparison) -> tuple[Text, Text]:
    low, high = quartiles(spread, row)
    return Text(told(spread.median, row)), Text(f"[{low}, {high}]")


def _style(row: Comparison) -> str:
    return "good" if row.beats else "bad" if row.loses else ""


def _test(row: Comparison) -> tuple[Text, Text, Text, Text]:
    style = _style(row)
    interval = f"[{fixed(row.interval.low, 2)}, {fixed(row.interval.high, 2)}]"
    return Text(p_text(row.p_holm)), Text(row.marks, style), Text(fixed(row.a12, 2), style), Text(interval)
