"""Results of a study: the verdict, a table per scenario, a comparison with the paper, and the paper's arithmetic."""

from collections.abc import Iterator, Mapping, Sequence

from rich.console import Group, RenderableType
from rich.table import Column
from rich.text import Text

from cortex_dsl.report.findings.readable import counted, duration, fixed, percent, ratio
from cortex_dsl.report.findings.search_report import method_style
from cortex_dsl.report.findings.study_report import (
    differences,
    distinct_simulations,
    missing_lines,
    p_text,
    quartiles,
    value_text,
    verdict_line,
    yields_text,
)
from cortex_dsl.report.terminal.theme import MARGIN, columns, heading, indented, left, right, section
from engine.paper import Claim, by_assumption, said
from engine.paper import Study as StudyRow
from engine.study.comparisons import NAMED_FIRST, Comparison, Spread
from engine.study.database import Study
from engine.study.plan import Plan
from engine.study.verdict import FAMILIES, RULE, Beside, Findings, RandomRates

# -- comparison with the paper: its six scenarios, the rate of random draws, and the table of studies ------------------


def paper_sections(findings: Findings, width: int) -> Iterator[RenderableType]:
    """Yield the sections that compare the study with the paper."""
    if findings.beside:
        note = "medians of our runs; the paper's one run"
        table = Group(_beside_table(findings.beside, width), Text(), *_lines(findings.beside))
        yield section("Compared with the paper", table, note)
    if findings.rates:
        note = "independent draws; Clopper-Pearson 95 %"
        yield section("Random sampling", _rates_table(findings.rates, width), note)
    if findings.beside:
        yield section("Among other studies", _studies_table(findings.studies), "the paper's table, and this study")


def _beside_table(rows: Sequence[Beside], width: int) -> RenderableType:
    head = (
        left(),
        left(),
        right("ga", method_style("ga")),
        right("random", method_style("random")),
        right("ga / random"),
        right("paper: ga"),
        right("random"),
        right("paper's"),
        left(),
    )
    body = []
    for previous, row in zip((None, *rows), rows, strict=False):
        first = previous is None or previous.letter != row.letter
        style = "" if row.same_direction else "warn"
        decimals = row.measure.decimals
        unit = f" [{row.measure.unit}]" if row.measure.unit else ""
        body.append(
            (
                Text(row.letter if first else "", "title"),
                Text.assemble(row.measure.name, (unit, "unit")),
                Text(fixed(row.ga, decimals)),
                Text(fixed(row.random, decimals)),
                Text(fixed(row.ratio, 2), style),
                Text(fixed(row.paper_ga, decimals)),
                Text(fixed(row.paper_random, decimals)),
                Text(fixed(row.paper_ratio, 2), style),
                Text("" if row.same_direction else "opposite", style),
            )
        )
    return _fitted(head, body, width, {2: 84, 3: 84, 5: 84, 6: 84})


def _lines(rows: Sequence[Beside]) -> Iterator[Text]:
    for number, line in enumerate(differences(rows)):
        yield Text(line, "quiet" if number else "")


def _rates_table(rows: Sequence[RandomRates], width: int) -> RenderableType:
    head = (
        left(),
        right("valid"),
        left("", "quiet"),
        right("collide"),
        left("of valid", "quiet"),
        right("odds / paper"),
        right("p, Fisher"),
    )
    body = [
        (
            Text(row.scenario),
            Text(percent(ratio(row.valid, row.individuals))),
            Text(_interval(row.valid_rate)),
            Text(percent(ratio(row.collisions, row.valid))),
            Text(_interval(row.collision_rate)),
            Text(fixed(row.against_paper.ratio, 2)),
            Text(p_text(row.against_paper.p)),
        )
        for row in rows
    ]
    return _fitted(head, body, width, {2: 80, 5: 100, 6: 100})


def _fitted(
    head: Sequence[Column], body: Sequence[Sequence[Text]], width: int, needed: Mapping[int, int]
) -> RenderableType:
    """The table without those columns that need a wider terminal."""
    shown = [at for at in range(len(head)) if width >= needed.get(at, 0)]
    return columns(*(head[at] for at in shown), rows=[[row[at] for at in shown] for row in body], header=True)


def _interval(bounds: tuple[float, float]) -> str:
    return f"[{fixed(100 * bounds[0], 1)}, {fixed(100 * bounds[1], 1)}]"


def _studies_table(rows: Sequence[StudyRow]) -> RenderableType:
    head = (
        left(wrap=True),
        left("test cases", wrap=True),
        left("s per simulation", wrap=True),
        left("collisions", wrap=True),
        left("valid", wrap=True),
    )
    body = [
        [
            Text(text, "title" if row is rows[-1] else "")
            for text in (row.name, row.cases, row.seconds, row.collisions, row.valid)
        ]
        for row in rows
    ]
    return columns(*head, rows=body, header=True)


# -- the study ---------------------------------------------------------------------------------------------------------

SHOWN = (
    *(measure.name for measure in NAMED_FIRST),
    "RL",
    "NC",
    "MDG",
    "MDEC",
    "NIS",
    "NIS, last 10",
)
"""Measures of the terminal's tables; the others stand in tests.csv."""
STACKED = 3
"""Maximum number of methods with a spread in the terminal."""
SIDE_BY_SIDE = 98
"""Columns that two methods side by side take."""
NEEDED = {3: 76, 7: 90}
"""Columns that must be there for the quartiles and the interval of a stacked table."""
MATRIX_NAME, MATRIX_CELL = 34, 8
FILES = (
    ("tests.csv", "every measure, spread, p and A12, whole run and last ten generations"),
    ("runs.csv", "every figure of every run"),
    ("generations.csv", "the figures of every generation of every run"),
    ("summary.json", "the figures of this page, for programs"),
    ("study.sqlite", "everything, with every evaluation"),
)


def study_view(study: Study, findings: Findings, width: int) -> RenderableType:
    """The whole report."""
    if not study.records:
        return Group(*_head(study, findings), _rule())
    return Group(
        *_head(study, findings),
        *(_scenario(study, findings, subject.name, width) for subject in study.plan.subjects),
        *paper_sections(findings, width),
        section(
            "Files",
            columns(left(), left(wrap=True), rows=[(a, Text(b, "quiet")) for a, b in FILES]),
            f"in {study.folder}/",
        ),
        _rule(),
    )


def _rule() -> RenderableType:
    return section("How this is decided", Group(Text(RULE, "quiet"), Text(FAMILIES, "quiet")))


def _head(study: Study, findings: Findings) -> Iterator[RenderableType]:
    plan, records = study.plan, study.records
    search = plan.subjects[0].config.search
    seconds = sum(record.seconds for record in records)
    methods = ", ".join(f"{method} {plan.preset(method)}".strip() for method in plan.methods)
    note = (
        f"{len(plan.subjects)} x {len(plan.methods)} x {plan.runs} runs of {search.generations} x {search.population}"
    )
    yield heading("Study", f"{note}; {methods}; {_seeds(plan)}, profile {plan.profile}")
    yield Text(f"{counted(distinct_simulations(study), 'simulation')}, {duration(seconds)} of work", "quiet")
    if not study.complete:
        total = plan.runs * len(plan.subjects) * len(plan.methods)
        yield Text(f"not finished: {len(records):,} of {total:,} runs", "warn")
    if failed := sum(record.figures.simulations.error_runs for record in records):
        yield Text(f"{counted(failed, 'simulation')} failed and are not counted", "bad")
    for line in yields_text(plan, records):
        yield Text(line, "quiet")
    yield Text()
    yield Text(verdict_line(plan, findings.comparisons), "title")
    for sentence in findings.verdict:
        yield Text(sentence)


def _seeds(plan: Plan) -> str:
    """`seeds 0 to 5`: each scenario has its own."""
    first, last = plan.seeds[0], plan.seeds[-1]
    return f"seed {first}" if first == last else f"seeds {first} to {last}"


def _scenario(study: Study, findings: Findings, name: str, width: int) -> RenderableType:
    """As much as there is room for; tests.csv has all of it."""
    plan, rows = study.plan, [row for row in findings.comparisons if row.scenario == name]
    room = width - MARGIN
    if not rows:
        return indented(Text(f"{name}: only {plan.methods[0]}, see runs.csv", "quiet"))
    if len(plan.methods) > STACKED:
        return section(name, _matrix(plan, rows, room), "medians; p, A12 and quartiles are in tests.csv")
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
            *(Text(value_text(of[0].baseline_spread.median, of[0])) for of in (_of(rows, n) for n in names)),
        ]
    ]
    for method in plan.contenders:
        mine = [next(row for row in _of(rows, name) if row.method == method) for name in names]
        body.append([_method(method), *(Text(value_text(row.spread.median, row), _style(row)) for row in mine)])
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
    return Text(value_text(spread.median, row)), Text(f"[{low}, {high}]")


def _style(row: Comparison) -> str:
    return "good" if row.beats else "bad" if row.loses else ""


def _test(row: Comparison) -> tuple[Text, Text, Text, Text]:
    style = _style(row)
    interval = f"[{fixed(row.interval.low, 2)}, {fixed(row.interval.high, 2)}]"
    return Text(p_text(row.p_holm)), Text(row.marks, style), Text(fixed(row.a12, 2), style), Text(interval)


# -- results of the paper's arithmetic, repeated -----------------------------------------------------------------------


def paper_view(claims: Sequence[Claim], everything: bool) -> RenderableType:
    """Return the claims by topic; only those that do not hold, unless `everything` is set."""
    parts: list[RenderableType] = list(_summary(claims))
    for topic in dict.fromkeys(claim.topic for claim in claims):
        shown = [claim for claim in claims if claim.topic == topic and (everything or not claim.holds)]
        if shown:
            parts.append(section(topic, _table(shown)))
    if not everything:
        parts += [Text(), Text("--all also shows the statements that hold", "quiet")]
    return Group(*parts)


def _summary(claims: Sequence[Claim]) -> Iterator[Text]:
    """Yield the counts of contradictions: statements of the paper, then our inferences by assumption.

    A wrong assumption is one cause for all of its failures.
    """
    own = said(claims)
    wrong = sum(not claim.holds for claim in own)
    tail = " statements of the paper contradict its own numbers"
    yield Text.assemble((f"{wrong} of {len(own)}", "bad"), tail)
    yield Text("Further checks rest on an assumption; a wrong assumption explains all its failures:", "quiet")
    for assumption, rows in by_assumption(claims).items():
        failing = sum(not claim.holds for claim in rows)
        yield Text(f"  {assumption}: {counted(failing, 'failure')} in {counted(len(rows), 'check')}", "quiet")


def _table(claims: Sequence[Claim]) -> RenderableType:
    rows = [
        (
            Text("holds" if claim.holds else "fails", "good" if claim.holds else "bad"),
            Text.assemble(claim.says, (_remark(claim), "quiet")),
            Text(claim.printed),
            Text(claim.found, "" if claim.holds else "warn"),
        )
        for claim in claims
    ]
    return columns(
        left(), left("statement", wrap=True), left("printed"), left("computed", wrap=True), rows=rows, header=True
    )


def _remark(claim: Claim) -> str:
    remarks = [claim.remark, f"assumption: {claim.assumption}" if claim.inferred else ""]
    return "".join(f"; {text}" for text in remarks if text)
