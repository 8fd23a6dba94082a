"""A study beside the paper: its six scenarios, what a random draw comes to, and the table of studies."""

from collections.abc import Iterator, Mapping, Sequence

from rich.console import Group, RenderableType
from rich.table import Column
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right, section
from cortex_dsl.report.numbers import fixed, percent, ratio
from cortex_dsl.report.theme import method_style
from engine.paper import Study as StudyRow
from engine.study.verdict import Beside, Findings, RandomRates


def paper_sections(findings: Findings, width: int) -> Iterator[RenderableType]:
    """Whatever there is to be said beside the paper."""
    if findings.beside:
        note = "medians of ours; the paper's one run"
        yield section(
            "Beside the paper", Group(_beside_table(findings.beside, width), Text(), *_lines(findings.beside)), note
        )
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
                Text("" if row.same_direction else "other way", style),
            )
        )
    return _fitted(head, body, width, {2: 84, 3: 84, 5: 84, 6: 84})


def _lines(rows: Sequence[Beside]) -> Iterator[Text]:
    for number, line in enumerate(differences(rows)):
        yield Text(line, "quiet" if number else "")


def differences(rows: Sequence[Beside]) -> list[str]:
    """Where ours differ from the paper's, in words; the first line is the sum of it."""
    against = [row for row in rows if not row.same_direction]
    windows = [row for row in rows if row.measure.name.startswith("NIS")]
    others = [row for row in rows if row not in windows]
    same = sum(row.same_direction for row in others)
    alike = sum(row.same_direction for row in windows)
    lines = [
        f"{same} of {len(others)} comparisons of risk, collisions and distances point the same way as in the paper",
        f"{alike} of {len(windows)} of NIS do, one observation told over again: all share the windows that decide it",
        *(f"the other way in {row.letter}: {row.measure.name}" for row in against),
    ]
    for name in dict.fromkeys(row.measure.name for row in rows):
        ours, paper = (_range([getattr(r, field) for r in rows if r.measure.name == name]) for field in _RATIOS)
        lines.append(f"{name}: ga / random is {ours} here, {paper} in the paper")
    return [*lines, "another simulator and one run each: sizes are not expected to agree"]


_RATIOS = ("ratio", "paper_ratio")


def _range(values: Sequence[float]) -> str:
    low, high = fixed(min(values), 2), fixed(max(values), 2)
    return low if low == high else f"{low} to {high}"


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
            Text("< 0.0001" if row.against_paper.p < 1e-4 else fixed(row.against_paper.p, 4)),
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
        left("s a simulation", wrap=True),
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
