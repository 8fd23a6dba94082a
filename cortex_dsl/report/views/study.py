"""The views of `study` and `paper-check`: the verdict, tables by scenario and by outcome, and the paper's numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from cortex_dsl.report.blocks import Block, Caution, Column, Facts, Note, Table, Title, Value, Words
from cortex_dsl.report.findings.readable import counted, duration, fixed, percent, ratio
from cortex_dsl.report.findings.search_report import method_name, method_style
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
from engine.paper import Claim, by_assumption, said
from engine.paper import Study as StudyRow
from engine.search.statistics import Interval
from engine.study.comparisons import NAMED_FIRST, Comparison, Spread
from engine.study.database import Study
from engine.study.plan import Plan
from engine.study.verdict import FAMILIES, RULE, Beside, Findings, RandomRates

SHOWN = (*(measure.name for measure in NAMED_FIRST), "RL", "NC", "MDG", "MDEC", "NIS", "NIS, last 10")
"""Measures of the tables by scenario; the others stand in tests.csv."""
STACKED = 3
"""Maximum number of methods with a spread."""
MATRIX_NAME, MATRIX_CELL = 36, 8
"""Characters of the name of a method and of each number in a table of many methods."""
FILES = (
    ("tests.csv", "every measure, spread, p and A12, whole run and last ten generations"),
    ("runs.csv", "every figure of every run"),
    ("generations.csv", "the figures of every generation of every run"),
    ("summary.json", "the figures of this page, for programs"),
    ("study.sqlite", "everything, with every evaluation"),
)


def number(head: str, style: str = "", *, least: int = 0) -> Column:
    """Return a column of numbers."""
    return Column(head, numbers=True, style=style, least=least)


def study_view(study: Study, findings: Findings) -> Title:
    """Return the view of `cortexc study`."""
    plan, search = study.plan, study.plan.subjects[0].config.search
    methods = ", ".join(f"{method} {plan.preset(method)}".strip() for method in plan.methods)
    sizes = f"{len(plan.subjects)} x {len(plan.methods)} x {plan.runs} runs"
    note = f"{sizes} of {search.generations} x {search.population}; {methods}; {_seeds(plan)}, profile {plan.profile}"
    blocks = list(_head(study, findings))
    if study.records:
        blocks += [_scenario(study, findings, subject.name) for subject in plan.subjects]
        blocks += [view for view in (paper_view(findings), rates_view(findings), studies_view(findings)) if view]
        files = [(name, Value(text, "quiet")) for name, text in FILES]
        blocks.append(Title("Files", [Facts(files)], f"in {study.folder}/"))
    blocks.append(Title("How this is decided", [Note(RULE, "quiet"), Note(FAMILIES, "quiet")]))
    return Title("Study", blocks, note)


def _head(study: Study, findings: Findings) -> Iterator[Block]:
    plan, records = study.plan, study.records
    seconds = sum(record.seconds for record in records)
    yield Note(f"{counted(distinct_simulations(study), 'simulation')}, {duration(seconds)} of work", "quiet")
    if not study.complete:
        total = plan.runs * len(plan.subjects) * len(plan.methods)
        yield Caution(f"not finished: {len(records):,} of {total:,} runs")
    if failed := sum(record.figures.simulations.error_runs for record in records):
        yield Note(f"{counted(failed, 'simulation')} failed and are not counted", "bad")
    yield from (Note(line, "quiet") for line in yields_text(plan, records))
    yield Note(verdict_line(plan, findings.comparisons), "title", apart=True)
    yield from map(Note, findings.verdict)


def _seeds(plan: Plan) -> str:
    """Return `seeds 0 to 5`: each scenario has its own."""
    first, last = plan.seeds[0], plan.seeds[-1]
    return f"seed {first}" if first == last else f"seeds {first} to {last}"


# -- a table for each scenario -----------------------------------------------------------------------------------------


def _scenario(study: Study, findings: Findings, name: str) -> Block:
    """Return the comparison of the methods in one scenario; tests.csv has all of it."""
    plan, rows = study.plan, [row for row in findings.comparisons if row.scenario == name]
    if not rows:
        return Note(f"  {name}: only {plan.methods[0]}, see runs.csv", "quiet")
    if len(plan.methods) > STACKED:
        return Title(name, [_matrix(plan, rows)], "medians; p, A12 and quartiles are in tests.csv")
    stack = _stack(plan, rows)
    table = replace(_pair(plan, rows), narrow=stack) if len(plan.methods) == 2 else stack
    return Title(name, [table, *(Note(line, "quiet") for line in missing_lines(rows))])


TESTED = number("p, Holm"), Column(), number("A12")


def _pair(plan: Plan, rows: Sequence[Comparison]) -> Table:
    """Return a line for each measure with the spreads of two methods side by side."""
    head = [Column()]
    for method in (plan.baseline, *plan.contenders):
        head += [number(method, method_style(method)), Column("[IQR]", style="quiet")]
    body = [
        (_name(row), *_spread(row.baseline_spread, row), *_spread(row.spread, row), *_test(row))
        for name in SHOWN
        for row in _of(rows, name)
    ]
    return Table((*head, *TESTED, Column("95 %", style="quiet")), body)


def _stack(plan: Plan, rows: Sequence[Comparison]) -> Table:
    """Return a line for each method under each measure, the baseline first."""
    head = (Column(), Column(), number("median"), Column("[IQR]", style="quiet", least=76))
    body: list[Sequence[Words]] = []
    for name in SHOWN:
        of = _of(rows, name)
        body.append((_name(of[0]), _method(plan.baseline), *_spread(of[0].baseline_spread, of[0]), *[""] * 4))
        body += [("", _method(row.method), *_spread(row.spread, row), *_test(row)) for row in of]
    return Table((*head, *TESTED, Column("95 %", style="quiet", least=90)), body)


def _matrix(plan: Plan, rows: Sequence[Comparison]) -> Table:
    """Return a line for each method with the medians of all measures, coloured by the comparison with the baseline."""
    heads = [_of(rows, name)[0] for name in SHOWN]
    columns = [
        number(
            row.title.replace("distinct ", "d. ").replace("last 10", "end"),
            least=MATRIX_NAME + MATRIX_CELL * (place + 1) - 2 if place else 0,
        )
        for place, row in enumerate(heads)
    ]
    body: list[Sequence[Words]] = [
        (_method(plan.baseline), *(value_text(row.baseline_spread.median, row) for row in heads))
    ]
    for method in plan.contenders:
        mine = [next(row for row in _of(rows, name) if row.method == method) for name in SHOWN]
        body.append((_method(method), *(Value(value_text(row.spread.median, row), _style(row)) for row in mine)))
    return Table((Column(), *columns), body)


def _of(rows: Sequence[Comparison], name: str) -> list[Comparison]:
    return [row for row in rows if row.measure.name == name]


def _method(name: str) -> Value:
    return Value(name, method_style(name))


def _name(row: Comparison) -> Words:
    return row.title, _unit(row.measure.unit)


def _unit(unit: str) -> Value:
    return Value(f" [{unit}]" if unit else "", "unit")


def _spread(spread: Spread, row: Comparison) -> tuple[Words, Words]:
    low, high = quartiles(spread, row)
    return value_text(spread.median, row), f"[{low}, {high}]"


def _style(row: Comparison) -> str:
    return "good" if row.beats else "bad" if row.loses else ""


def _test(row: Comparison) -> tuple[Words, ...]:
    style = _style(row)
    interval = f"[{fixed(row.interval.low, 2)}, {fixed(row.interval.high, 2)}]"
    return p_text(row.p_holm), Value(row.marks, style), Value(fixed(row.a12, 2), style), interval


# -- tables of the page: the outcomes that were named first, and every test --------------------------------------------

FIRST_NOTE = (
    "Four outcomes named before the study was run, one family of tests: avoidable collisions, which count against "
    "the ego, and their kinds; then the yield, genomes that may differ in a single bit, and its variety."
)
TESTS_NOTE = (
    "Two-sided Mann-Whitney tests, Holm's correction in each family; ▲ and A12 above 0.5: the method is better. "
    "Exploratory tests suggest, and show nothing by themselves: picking one of their families afterwards is not "
    "corrected for."
)


def primary_view(study: Study, found: Findings) -> Title | None:
    """Return a table for each outcome that was named before the study; None without comparisons."""
    if not found.comparisons:
        return None
    spread = number("median"), number("middle half"), number(study.plan.baseline), number("middle half")
    columns = Column("scenario"), Column("method"), *spread, number("p, Holm"), number("A12"), number("95 %"), Column()
    blocks: list[Block] = []
    for measure in NAMED_FIRST:
        rows = [
            (
                Value(row.scenario, "title"),
                method_name(row.method),
                _median(row),
                _middle(row.spread, row),
                value_text(row.baseline_spread.median, row),
                _middle(row.baseline_spread, row),
                *_judged(row),
                row.words,
            )
            for row in found.comparisons
            if row.measure is measure
        ]
        name = Value(f"{measure.name[0].upper()}{measure.name[1:]}", "title")
        blocks += [Note((name, f": {measure.meaning}.")), Table(columns, rows, name="tests")]
    blocks += [Note(f"{text}.") for text in yields_text(study.plan, study.records)]
    return Title("Which method finds more", blocks, FIRST_NOTE, name="primary")


def tests_view(found: Findings) -> Title | None:
    """Return every other test, folded; None without comparisons."""
    if not found.comparisons:
        return None
    rows = [
        (
            row.scenario,
            (row.title, Value(f" {row.measure.unit}", "unit")),
            Value("exploratory" if row.measure.exploratory else row.measure.family, "quiet"),
            row.method,
            _median(row),
            value_text(row.baseline_spread.median, row),
            Value(p_text(row.p), "quiet"),
            *_judged(row),
            (row.words, Value(f" {row.missing}" if row.missing else "", "quiet")),
        )
        for row in found.comparisons
        if row.measure not in NAMED_FIRST
    ]
    texts = (Column(head) for head in ("scenario", "measure", "role", "method"))
    numbers = map(number, ("median", found.comparisons[0].baseline, "p", "p, Holm", "A12", "95 %"))
    table = Table((*texts, *numbers, Column()), rows, name="tests")
    return Title("Every test", [Title(counted(len(rows), "test"), [table], folded=True)], TESTS_NOTE, name="tests")


def _median(row: Comparison) -> Value:
    name = f"{row.scenario}.{row.method}.{row.measure.name}.median"
    return Value(value_text(row.spread.median, row), "", row.spread.median, name)


def _middle(spread: Spread, row: Comparison) -> Value:
    return Value(" to ".join(quartiles(spread, row)), "quiet")


def _judged(row: Comparison) -> tuple[Words, Words, Words]:
    """Return p, A12 and its interval."""
    interval = f"{fixed(row.interval.low, 2)} to {fixed(row.interval.high, 2)}"
    return (p_text(row.p_holm), " ", Value(row.marks, "title")), fixed(row.a12, 2), Value(interval, "quiet")


# -- comparison with the paper: its six scenarios, the rate of random draws, and the table of studies ------------------


def paper_view(findings: Findings) -> Title | None:
    """Return our numbers beside the paper's; None for other scenarios."""
    if not findings.beside:
        return None
    first, *others = differences(findings.beside)
    lines = Note(first, apart=True), *(Note(line, "quiet") for line in others)
    note = "medians of our runs; the paper's one run"
    return Title("Compared with the paper", [_beside_table(findings.beside), *lines], note, name="paper")


def _beside_table(rows: Sequence[Beside]) -> Table:
    ours = number("ga", method_style("ga"), least=82), number("random", method_style("random"), least=82)
    papers = number("paper: ga", least=82), number("random", least=82)
    head = Column(), Column(), *ours, number("ga / random"), *papers, number("paper's"), Column()
    body = []
    for previous, row in zip((None, *rows), rows, strict=False):
        first = previous is None or previous.letter != row.letter
        style, decimals = "" if row.same_direction else "warn", row.measure.decimals
        body.append(
            (
                Value(row.letter if first else "", "title"),
                (row.measure.name, _unit(row.measure.unit)),
                fixed(row.ga, decimals),
                fixed(row.random, decimals),
                Value(fixed(row.ratio, 2), style),
                fixed(row.paper_ga, decimals),
                fixed(row.paper_random, decimals),
                Value(fixed(row.paper_ratio, 2), style),
                Value("" if row.same_direction else "opposite", style),
            )
        )
    return Table(head, body, name="beside")


def rates_view(findings: Findings) -> Title | None:
    """Return the outcomes of random sampling; None without it."""
    if not findings.rates:
        return None
    head = (
        Column(),
        number("valid"),
        Column(style="quiet", least=78),
        number("collide"),
        Column("of valid", style="quiet"),
        number("odds / paper", least=98),
        number("p, Fisher", least=98),
    )
    table = Table(head, [_rates(row) for row in findings.rates], name="rates")
    return Title("Random sampling", [table], "independent draws; Clopper-Pearson 95 %", name="rates")


def _rates(row: RandomRates) -> Sequence[Words]:
    return (
        row.scenario,
        percent(ratio(row.valid, row.individuals)),
        _interval(row.valid_rate),
        percent(ratio(row.collisions, row.valid)),
        _interval(row.collision_rate),
        fixed(row.against_paper.ratio, 2),
        p_text(row.against_paper.p),
    )


def _interval(bounds: Interval) -> str:
    return f"[{fixed(100 * bounds[0], 1)}, {fixed(100 * bounds[1], 1)}]"


def studies_view(findings: Findings) -> Title | None:
    """Return the paper's table of studies with this one; None for other scenarios."""
    if not findings.beside:
        return None
    heads = ("", "test cases", "s per simulation", "collisions", "valid")
    columns = *(Column(head, wrap=True) for head in heads), Column("metrics", wrap=True, least=140)
    last = findings.studies[-1]
    rows = [[Value(text, "title" if row is last else "") for text in _cells(row)] for row in findings.studies]
    return Title("Among other studies", [Table(columns, rows, name="studies")], "the paper's table, and this study")


def _cells(row: StudyRow) -> Sequence[str]:
    return [str(value) for value in vars(row).values()]


# -- results of the paper's arithmetic, repeated -----------------------------------------------------------------------


def claims_view(claims: Sequence[Claim], everything: bool) -> list[Block]:
    """Return the claims by topic; only those that do not hold, unless `everything` is set."""
    blocks: list[Block] = list(_summary(claims))
    for topic in dict.fromkeys(claim.topic for claim in claims):
        shown = [claim for claim in claims if claim.topic == topic and (everything or not claim.holds)]
        blocks += [Title(topic, [_claims(shown)])] if shown else []
    return blocks if everything else [*blocks, Note("--all also shows the statements that hold", "quiet", apart=True)]


def _summary(claims: Sequence[Claim]) -> Iterator[Note]:
    """Yield the counts of contradictions: statements of the paper, then our inferences by assumption.

    A wrong assumption is one cause for all of its failures.
    """
    own = said(claims)
    wrong = sum(not claim.holds for claim in own)
    yield Note((Value(f"{wrong} of {len(own)}", "bad"), " statements of the paper contradict its own numbers"))
    yield Note("Further checks rest on an assumption; a wrong assumption explains all its failures:", "quiet")
    for assumption, rows in by_assumption(claims).items():
        failing = sum(not claim.holds for claim in rows)
        yield Note(f"  {assumption}: {counted(failing, 'failure')} in {counted(len(rows), 'check')}", "quiet")


def _claims(claims: Sequence[Claim]) -> Table:
    rows = [
        (
            Value("holds", "good") if claim.holds else Value("fails", "bad"),
            (claim.says, Value(_remark(claim), "quiet")),
            claim.printed,
            Value(claim.found, "" if claim.holds else "warn"),
        )
        for claim in claims
    ]
    heads = Column("statement", wrap=True), Column("printed"), Column("computed", wrap=True)
    return Table((Column(), *heads), rows)


def _remark(claim: Claim) -> str:
    remarks = [claim.remark, f"assumption: {claim.assumption}" if claim.inferred else ""]
    return "".join(f"; {text}" for text in remarks if text)
