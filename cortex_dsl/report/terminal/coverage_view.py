"""The result of `cortexc coverage` in the terminal: counts of the states, failures, and cells that are not covered."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from cortex_dsl.plain_text import visible
from cortex_dsl.report.findings.coverage_report import INDEPENDENT, PROVED, CellResult, CoverageReport, State, percent
from cortex_dsl.report.findings.readable import duration
from cortex_dsl.report.terminal.gate_view import Command, GateProgress
from engine.display import counted

STYLES = {
    State.COVERED: "good",
    State.RARE: "good",
    State.BLOCKED: "warn",
    State.UNTRIED: "warn",
    State.EXCLUDED: "quiet",
    State.IMPOSSIBLE: "quiet",
}
WORD = max(map(len, State)) + 2
"""Columns of a state."""
LISTED = 12
"""Maximum number of cells that are listed under one heading."""


def coverage_view(report: CoverageReport, require: float | None = None) -> Group:
    """Return the whole report."""
    ways = f"{report.ways}-way product of " if report.ways > 1 else ""
    head = f"{len(report.cells):,} cells: {ways}{counted(len(report.domains), 'domain')}"
    lines: list[RenderableType] = [Text.assemble((head, "title"), (f"  {_effort(report)}", "quiet")), Text()]
    for state, count in report.counts.items():
        if count:
            lines.append(Text.assemble((f"{state:<{WORD}}", STYLES[state]), f"{count:>8,}"))
    failing = [cell for cell in report.cells if cell.failures]
    failing.sort(key=lambda cell: (-(cell.low or 0.0), -cell.failures))
    order = "the highest lower end first" if report.method == INDEPENDENT else "the most first"
    lines += _section(f"failures ({report.failure}), {order}", failing, report)
    for state in (State.RARE, State.BLOCKED, State.UNTRIED, State.EXCLUDED, State.IMPOSSIBLE):
        lines += _section(state.value, [cell for cell in report.cells if cell.state is state], report)
    lines.append(Text())
    lines += (Text(f"note: {text}", "quiet") for text in _notes(report))
    lines.append(_end(report, require))
    return Group(*lines)


def _effort(report: CoverageReport) -> str:
    lost = f", {report.lost:,} more do not count" if report.lost else ""
    return f"{counted(report.draws, 'run')} of seed {report.seed}{lost}  {duration(report.seconds)}"


def _section(title: str, cells: Sequence[CellResult], report: CoverageReport) -> Iterator[RenderableType]:
    """Yield cells under a heading; nothing for none."""
    if not cells:
        return
    yield Text()
    yield Text(title, "title")
    for cell in cells[:LISTED]:
        line = Text.assemble((visible(report.name_of(cell)), "bar"), ": ", visible(report.reason(cell)))
        yield Padding(line, (0, 0, 0, 2), expand=False)
        if cell.worst is not None and cell.worst.replay:
            yield Command(cell.worst.replay, 4)
    if len(cells) > LISTED:
        yield Padding(Text(f"and {counted(len(cells) - LISTED, 'cell')} more: --json, --out", "quiet"), (0, 0, 0, 2))


def _notes(report: CoverageReport) -> Iterator[str]:
    """Yield remarks on all numbers."""
    yield report.multiplicity
    if report.method != INDEPENDENT and not report.files:
        yield "--out DIR writes the scenes as files, with the commands that repeat them"
    if report.valueless:
        yield f"{counted(report.valueless, 'run')} without a number for some domain: in no cell"
    if report.timed:
        yield f"the number of runs depends on the machine: --budget {report.budget}"
    if report.verdicts is not None:
        found = ", ".join(f"{count:,} {name}" for name, count in report.verdicts.items())
        yield f"runs by the operational design domain: {found}"
    yield from report.remarks


def _end(report: CoverageReport, require: float | None) -> Text:
    proved = sum(report.counts[state] for state in PROVED)
    parts = [report.headline, f"{proved:,} proved empty"]
    if require is not None:
        parts.append(f"required: {percent(require)}")
    return Text(", ".join(parts), "bad" if require is not None and report.share < require else "good")


@dataclass
class CoverageProgress(GateProgress):
    """The parts of the current work that are done, and the time left for it."""

    work: str = "runs"
    """Work that is done."""

    def on_step(self, work: str, done: int, count: int) -> None:
        """Take the finished parts of the current work."""
        if work != self.work:
            self.work, self.started = work, time.monotonic()
        self.current = (done, count)

    def _line(self) -> Text:
        done, count = self.current
        share, seconds = done / max(1, count), time.monotonic() - self.started
        left = f", {duration(seconds / share * (1.0 - share))} left" if share > 0.0 else ""
        return Text(f"{self.work}: {done:,} of {count:,}{left}", "quiet")
