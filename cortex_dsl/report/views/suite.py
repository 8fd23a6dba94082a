"""The view of `suite`: counts and points by group, then the cells that fail, that nearly do, and that are not run."""

from collections import Counter
from collections.abc import Iterator, Sequence

from cortex_dsl.report.blocks import Block, Caution, Code, Column, Facts, Note, Table, Title, Value, Words
from cortex_dsl.report.findings.readable import ABSENT, counted, significant
from cortex_dsl.report.findings.suite_report import CellResult, GroupResult, Outcome, SuiteReport
from engine.gates.ratings import EXTENDED, STANDARD, VERIFIED

STYLES = {Outcome.PASS: "good", Outcome.FAIL: "bad", Outcome.ERROR: "bad", Outcome.NOT_RUN: "quiet"}
COLOUR_STYLES = {"green": "good", "red": "bad"}
SHOWN = 12
"""Cells of each list in the terminal."""


def suite_view(report: SuiteReport, shown: int | None = SHOWN) -> Title:
    """Return the view; at most `shown` cells of each list, all of them with None."""
    blocks: list[Block] = [_groups(report)]
    lists = (
        ("Cells that fail", [cell for cell in report.cells if cell.outcome in (Outcome.FAIL, Outcome.ERROR)]),
        (
            "Cells that pass the nominal test and fail within the tolerances",
            [cell for cell in report.cells if _is_fragile(cell)],
        ),
    )
    for name, cells in lists:
        if cells:
            blocks.append(Title(name, list(_cells(cells, shown)), counted(len(cells), "cell")))
    if searched := [cell for cell in report.cells if cell.searched is not None]:
        blocks.append(Title("Searched ranges", [_ranges(searched)], "the largest range without a failure"))
    blocks += _not_run(report)
    if report.entry:
        blocks.append(Caution(f"entry conditions are broken, so that there are no points: {', '.join(report.entry)}"))
    if report.points is not None:
        blocks.append(Note(("points of these cells: ", Value(significant(report.points, 4), "title", report.points))))
    blocks += [Caution(remark) for remark in report.remarks]
    if report.timed:
        blocks.append(Note(f"the number of runs depends on the machine: --budget {report.budget}", "quiet"))
    blocks.append(Note(Value(report.headline, "good" if report.passed else "bad"), apart=True))
    return Title(report.title, blocks)


def _is_fragile(cell: CellResult) -> bool:
    return cell.outcome is Outcome.PASS and (cell.deviation is not None or cell.failures > 0)


def _groups(report: SuiteReport) -> Table:
    """Return counts and points of each group."""
    columns = Column("group"), Column("cells", numbers=True), *(Column(each, numbers=True) for each in Outcome)
    rows = [(group.name, f"{len(group.cells):,}", *_counts(group)) for group in report.groups]
    if report.points is None:
        return Table(columns, rows, name="groups")
    scored = [(*row, *_points(group)) for row, group in zip(rows, report.groups, strict=True)]
    ranges = Column("standard", numbers=True, rank=2), Column("extended", numbers=True, rank=1)
    return Table((*columns, *ranges), scored, name="groups")


def _counts(group: GroupResult) -> Iterator[Value]:
    for outcome in Outcome:
        count = sum(cell.outcome is outcome for cell in group.cells)
        yield Value(f"{count:,}" if count else "", STYLES[outcome], count)


def _points(group: GroupResult) -> Iterator[Words]:
    """Yield the points of both ranges; none where no cell is run."""
    runs = any(cell.outcome is not Outcome.NOT_RUN for cell in group.cells)
    for range_ in (STANDARD, EXTENDED):
        score = group.score(range_) if runs else None
        yield "" if score is None else f"{significant(score, 3)} of {significant(group.points[range_], 3)}"


def _cells(cells: Sequence[CellResult], shown: int | None) -> Iterator[Block]:
    columns = (
        Column("cell"),
        Column("colour"),
        Column("impact\nkm/h", numbers=True),
        Column("fails", numbers=True),
        Column("95 %", rank=2),
        Column("least\ndeviation", numbers=True),
        Column("careful\ndriver", rank=1, wrap=True),
    )
    kept = [cell for cell in cells[:shown] if cell.outcome is not Outcome.ERROR]
    if kept:
        rows = [_row(cell) for cell in kept]
        if shown is None:
            columns = (*columns, Column("case"))
            rows = [(*row, cell.deviation.case if cell.deviation else "") for row, cell in zip(rows, kept, strict=True)]
        yield Table(columns, rows, name="cells")
    for cell in cells[:shown]:
        if cell.outcome is Outcome.ERROR:
            yield Note((Value(cell.id, "title"), f": {cell.reason}"), "bad")
    replays = [cell.deviation.replay for cell in kept if cell.deviation is not None and cell.deviation.replay]
    yield from map(Code, replays[:1])
    if shown is not None and len(cells) > shown:
        yield Note(f"and {counted(len(cells) - shown, 'cell')} more", "quiet")


def _row(cell: CellResult) -> Sequence[Words]:
    colour = cell.colour or ""
    impact = ABSENT if not cell.contact else significant(cell.impact, 3)
    share = f"{significant(100.0 * cell.probability, 3)} %" if cell.runs else ""
    ends = f"{significant(100.0 * cell.low, 3)} to {significant(100.0 * cell.high, 3)} %" if cell.runs else ""
    least = "" if cell.deviation is None else significant(cell.deviation.size, 2)
    name: Words = cell.id if cell.status == VERIFIED else (cell.id, Value(" (?)", "warn"))
    careful = cell.said.get("careful", "")
    return name, Value(colour, COLOUR_STYLES.get(colour, "warn")), impact, share, ends, least, careful


def _ranges(cells: Sequence[CellResult]) -> Table:
    rows = []
    for cell in cells:
        searched = cell.searched
        assert searched is not None
        ends = [
            f"{name} {significant(low, 4)} to {significant(high, 4)} {searched.units[name]}".rstrip()
            for name, (low, high) in searched.ranges.items()
            if low == low
        ]
        rows.append((cell.id, f"{searched.runs:,}", f"{searched.failures:,}", ", ".join(ends) or "no part of it"))
    heads = (
        Column("cell"),
        Column("runs", numbers=True),
        Column("failures", numbers=True),
        Column("no failure in", wrap=True),
    )
    return Table(heads, rows, name="ranges")


def _not_run(report: SuiteReport) -> Iterator[Block]:
    """Yield the cells that are not run, counted by their reason."""
    left = [cell for cell in report.cells if cell.outcome is Outcome.NOT_RUN]
    if not left:
        return
    counts = Counter(cell.reason for cell in left)
    groups = {reason: dict.fromkeys(cell.group for cell in left if cell.reason == reason) for reason in counts}
    rows = [(", ".join(groups[reason]), f"{count:,}", reason) for reason, count in counts.items()]
    columns = Column("groups", wrap=True), Column("cells", numbers=True), Column("reason", wrap=True)
    yield Title(
        "Not run", [Table(columns, rows, name="not run")], f"{counted(len(left), 'cell')}, none of which passes"
    )


def group_view(group: GroupResult) -> Title:
    """Return all cells of a group, for a page."""
    cells = [cell for cell in group.cells if cell.outcome is not Outcome.NOT_RUN]
    facts = [("scenario", group.file), ("program", group.digest)] if group.file else []
    sources = dict.fromkeys((cell.source, cell.status) for cell in group.cells)
    facts += [("source", f"{source} ({status})") for source, status in sources]
    blocks: list[Block] = [Facts(facts), *_cells(cells, None)]
    return Title(group.name, blocks, counted(len(group.cells), "cell"), folded=True)
