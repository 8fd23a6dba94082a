"""The view of `compare`: what differs between A and B, on each file."""

from collections.abc import Iterator, Sequence

from cortex_dsl.report.blocks import (
    Block,
    Caution,
    Code,
    Column,
    Facts,
    Note,
    Panel,
    Picture,
    Table,
    Title,
    Value,
    Words,
)
from cortex_dsl.report.findings.comparison_report import (
    Change,
    ComparisonReport,
    Condition,
    FileComparison,
    FoundChange,
    Searched,
)
from cortex_dsl.report.findings.readable import ABSENT, counted, significant
from engine.gates.decision import Answer

STYLES = {Change.NEW: "bad", Change.CURED: "good", Change.MOVED: "warn", Change.KEPT: "quiet"}
TITLES = {
    Change.NEW: "New failures",
    Change.CURED: "Cured failures",
    Change.MOVED: "Moved failures",
    Change.KEPT: "Kept failures",
}
NOTES = {
    Change.NEW: "A keeps a condition that B breaks",
    Change.CURED: "A breaks a condition, B none",
    Change.MOVED: "both fail, B in nothing that A keeps, in failures of different kinds",
    Change.KEPT: "both fail, in failures of the same kind",
}
ANSWERS = {
    Answer.BROKEN: ("above the limit", "bad"),
    Answer.KEPT: ("at or below the limit", "good"),
    Answer.OPEN: ("undecided", "warn"),
}
SHOWN = 3
"""Kinds of each change in the terminal."""
SMALLEST = 1e-4


def comparison_view(report: ComparisonReport, shown: int = SHOWN, *, whole: bool = False) -> Title:
    """Return the view; `shown` kinds of each change, and with `whole` drawings and kept failures."""
    blocks: list[Block] = [Caution(f"{text}; there is no paired test") for text in report.not_deterministic]
    blocks.append(Facts([("A", Value(report.a, "title")), ("B", Value(report.b, "title"))]))
    blocks += [file_view(file, shown, whole=whole) for file in report.files]
    if report.timed:
        blocks.append(Note(f"the number of pairs depends on the machine: --budget {report.budget}", "quiet"))
    blocks.append(Note(Value(report.headline, "good" if report.passed else "bad"), apart=True))
    return Title("A against B", blocks)


def file_view(file: FileComparison, shown: int, *, whole: bool) -> Title:
    """Return the section of a file."""
    blocks: list[Block] = [Note(f"note: {text}", "quiet") for text in file.remarks]
    if file.trouble:
        blocks.append(Note(file.trouble, "bad"))
    if file.conditions:
        blocks += [_conditions(file), *_below(file)]
    for change in Change:
        found = [each for each in file.changes if each.change is change]
        if found and (whole or change is not Change.KEPT):
            count = f"{counted(file.count(change), 'pair')} of {counted(len(found), 'kind')}: {NOTES[change]}"
            blocks.append(Title(TITLES[change], list(_changes(found, shown, whole=whole)), count))
    if file.searched is not None:
        blocks.append(_searched(file.searched, shown, whole=whole))
    if file.not_run:
        columns = (
            Column("side"),
            Column("reason", wrap=True),
            Column("scenes", numbers=True),
            Column("first", numbers=True),
        )
        rows = [(each.side, each.reason, f"{each.count:,}", f"{each.number:,}") for each in file.not_run]
        blocks.append(Title("Not run", [Table(columns, rows)], "scenes without a pair of runs"))
    note = "" if file.trouble and not file.pairs else f"{counted(file.pairs, 'pair')}, {file.valid:,} of which count"
    return Title(file.path, blocks, note)


# -- conditions --------------------------------------------------------------------------------------------------------


def _conditions(file: FileComparison) -> Table:
    """Return the table of outcomes and tests; where it is too wide, each test is below its condition."""
    heads = "both\nkeep", "only B\nbreaks", "only A\nbreaks", "both\nbreak"
    counts = tuple(Column(head, numbers=True) for head in heads)
    rows = [(each.name, *_counts(each)) for each in file.conditions]
    if file.untested:
        return Table((Column("condition", wrap=True), *counts), rows, name="conditions")
    tests = [_test(each) for each in file.conditions]
    columns = Column("B less A", numbers=True), Column("95 %", numbers=True), Column("p", numbers=True), Column()
    below = [
        ((name, "\n", difference, f" ({interval}), p ", p, " ", verdict), *cells)
        for (name, *cells), (difference, interval, p, verdict) in zip(rows, tests, strict=True)
    ]
    narrow = Table((Column("condition\nB less A (95 %)", wrap=True), *counts), below)
    wide = [(*row, *test) for row, test in zip(rows, tests, strict=True)]
    return Table((Column("condition"), *counts, *columns), wide, name="conditions", narrow=narrow)


def _counts(condition: Condition) -> Sequence[Value]:
    return [Value(f"{count:,}", "" if count else "quiet", count) for count in condition.table.counts]


def _test(condition: Condition) -> tuple[Value, str, Value, Value]:
    """Return the difference, its interval, the p value and the verdict."""
    difference, (low, high) = condition.table.difference, condition.table.interval
    style, p = {"worse": "bad", "better": "good", "": ""}[condition.verdict], condition.p_holm
    shown = Value(f"{_points(difference)} %", style, difference)
    return shown, f"{_points(low)} to {_points(high)}", Value(_p_text(p), style, p), Value(condition.verdict, style)


def _points(share: float) -> str:
    """Return a difference in percent, with its sign."""
    text = significant(100.0 * share, 3)
    return f"+{text}" if share > 0.0 else text


def _p_text(p: float) -> str:
    return ABSENT if p != p else f"< {SMALLEST:g}" if p < SMALLEST else significant(p, 2)


def _below(file: FileComparison) -> Iterator[Block]:
    """Yield the notes below the table: why there is no test, the decision, and the bound."""
    if file.untested:
        yield Note(f"no paired test: {file.untested}", "warn" if not file.deterministic else "quiet")
    else:
        yield Note(
            "p: exact McNemar test, by Holm over all conditions of its family; 95 %: Tango's score interval", "quiet"
        )
    if file.decision is not None and file.limit is not None:
        word, style = ANSWERS[file.decision.answer]
        ends = " to ".join(f"{significant(100.0 * end, 3)} %" for end in (file.decision.low, file.decision.high))
        limit = f"limit {significant(100.0 * file.limit, 3)} %"
        yield Note(("probability of a new failure: ", Value(word, style), f", {ends}, {limit}"))
    if file.residual is not None:
        bound = f"{significant(100.0 * file.residual, 3)} %"
        yield Note(f"no new failure in {counted(file.valid, 'pair')}: its probability is at most {bound} (95 %)")
    if file.lost_by_b:
        yield Note(f"the driver of B failed in {counted(file.lost_by_b, 'scene')} that A drove", "bad")


# -- failures ----------------------------------------------------------------------------------------------------------


def _changes(found: Sequence[FoundChange], shown: int, *, whole: bool) -> Iterator[Block]:
    """Yield the first kinds; a page folds those without drawings."""
    is_folded = [whole and not each.drawings for each in found[:shown]]
    for each in found[: is_folded.index(True) if True in is_folded else shown]:
        yield from _change(each, whole=whole)
    if any(is_folded):
        folded = found[is_folded.index(True) : shown]
        blocks = [block for each in folded for block in _change(each, whole=whole)]
        yield Title(counted(len(folded), "further kind"), blocks, folded=True)
    if rest := found[shown:]:
        yield Note(
            f"and {counted(len(rest), 'kind')} more, {counted(sum(each.count for each in rest), 'pair')}", "quiet"
        )


def _change(found: FoundChange, *, whole: bool) -> Iterator[Block]:
    """Yield the kind, both runs side by side, and the commands that repeat them."""
    yield Note((Value(found.kind, "title"), Value(f": {counted(found.count, 'pair')}", "quiet")), apart=True)
    example = found.example
    seed = "" if example.seed is None else f", seed {example.seed}"
    rows: list[Sequence[Words]] = [
        (Value(f"pair {example.number:,}{seed}", "quiet"), Value("A", "title"), Value("B", "title")),
        ("end", example.a.event, example.b.event),
    ]
    numbers = {each.name: (each.text.removeprefix(each.name).strip(), "") for each in example.a.numbers}
    for each in example.b.numbers:
        numbers[each.name] = (numbers.get(each.name, ("", ""))[0], each.text.removeprefix(each.name).strip())
    rows += [(name, a or ABSENT, b or ABSENT) for name, (a, b) in numbers.items()]
    yield Table((Column(wrap=True),) * 3, rows, header=False, name="sides")
    if whole and found.drawings:
        yield Picture([Panel(drawing, (side,)) for side, drawing in zip("AB", found.drawings, strict=True)], rows=12)
    replays = dict.fromkeys(run.replay for run in (example.a, example.b) if run.replay)
    yield from map(Code, replays)
    if found.cases:
        yield Note(f"kept as {', '.join(found.cases)}", "quiet")


def _searched(searched: Searched, shown: int, *, whole: bool) -> Title:
    """Return the section of the search for differences."""
    note = f"{counted(searched.scenes, 'scene')} by {searched.method}: no sample, and no part of any number above"
    blocks: list[Block] = []
    for change in (Change.NEW, Change.CURED, Change.MOVED):
        found = [each for each in searched.changes if each.change is change]
        if found:
            words = f"{TITLES[change]}: {counted(searched.count(change), 'scene')} of {counted(len(found), 'kind')}"
            blocks.append(Note(Value(words, STYLES[change]), apart=True))
            blocks += _changes(found, shown, whole=whole)
    if searched.changes and not any(each.cases or each.example.a.replay for each in searched.changes):
        blocks.append(Note("--out DIR keeps these scenes as files, which `cortexc compare A B FILE` repeats", "quiet"))
    return Title("Found by the search", blocks or [Note("no scene in which both differ")], note)
