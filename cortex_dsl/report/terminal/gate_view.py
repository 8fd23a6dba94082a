"""The result of `cortexc test` in the terminal: a line for each file, its failures below, and the progress."""

import time
from collections.abc import Generator, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from threading import Event, Thread
from types import TracebackType
from typing import Self

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.padding import Padding
from rich.text import Text

from cortex_dsl.plain_text import visible
from cortex_dsl.report.findings.gate_report import CURED, Check, FileResult, GateReport, Status
from cortex_dsl.report.findings.readable import duration, short_names
from engine.display import counted

STYLES = {
    Status.PASS: "good",
    Status.KNOWN: "warn",
    Status.UNDECIDED: "warn",
    Status.FAIL: "bad",
    Status.ERROR: "bad",
}
WORD = max(map(len, Status)) + 2
"""Columns of the status."""
INTERVAL = 5.0
"""Time between two lines of progress where stderr is no terminal [s]."""


# -- results -----------------------------------------------------------------------------------------------------------


def file_view(file: FileResult, width: int) -> Group:
    """Return the line of a file, and below it what is to be said about its checks."""
    head = Text.assemble((f"{file.status:<{WORD}}", STYLES[file.status]), no_wrap=True)
    note = f"{counted(file.runs, 'run')}  {duration(file.seconds):>6}"
    room = max(10, width - WORD - len(note) - 2)
    (path,) = short_names([visible(file.path)], room)
    head.append(f"{path:<{room}}", "")
    head.append(f"  {note}", "quiet")
    parts: list[RenderableType] = [head, *(_indented(Text(f"note: {text}", "quiet")) for text in file.remarks)]
    if file.trouble and file.error is None:
        parts.append(_indented(Text(visible(file.trouble))))
    for check in file.checks:
        parts += _check_lines(check)
    return Group(*parts)


def _check_lines(check: Check) -> Iterator[RenderableType]:
    """Yield the lines of a check that did not simply pass."""
    if check.cured:
        yield _indented(Text.assemble((visible(check.name), "title"), f": cured, kept in {counted(check.runs, 'run')}"))
    if check.status is Status.PASS and check.rate is None:
        return
    status = f"{check.status}, " if check.status in (Status.KNOWN, Status.UNDECIDED) else ""
    name = (visible(check.name), "title")
    yield _indented(Text.assemble(name, ": ", (status, STYLES[check.status]), check.text))
    if check.first is not None and check.broken:
        yield _indented(Text(visible(check.first.text)), 2)
        yield Command(check.replay)


def _indented(text: Text, more: int = 0) -> RenderableType:
    return Padding(text, (0, 0, 0, WORD + more))


@dataclass
class Command:
    """A command on a line of its own, never broken, so that it can be copied."""

    words: str
    indent: int = WORD + 2
    """Columns before it."""

    def __rich__(self) -> Text:
        return Text(f"{'':<{self.indent}}{visible(self.words)}", "bar", no_wrap=True, overflow="ignore")


def end_view(report: GateReport) -> Group:
    """Return the last lines: remarks, and the counts."""
    style = "good" if report.passed else "bad"
    lines = [Text(f"note: {text}", "quiet") for text in report.remarks]
    if report.strict and report.cured:
        lines.append(Text(CURED, "bad"))
    if report.timed:
        lines.append(Text(f"the number of runs depends on the machine: --budget {report.budget}", "quiet"))
    lines.append(Text.assemble((report.headline, style), (f"  {duration(report.seconds)}", "quiet")))
    return Group(Text(), *lines)


# -- progress ----------------------------------------------------------------------------------------------------------


@dataclass
class GateProgress:
    """Files and runs that are done, and the time left: redrawn on a terminal, elsewhere a line now and then."""

    console: Console
    files: int
    noun: str = "file"
    """Name of what is counted."""
    interval: float = INTERVAL
    done: int = 0
    """Files that are done."""
    runs: int = 0
    """Runs of these files."""
    current: tuple[int, int] = (0, 1)
    """Runs of the current file that are done, and its budget."""
    started: float = field(default_factory=time.monotonic)
    _live: Live | None = None
    _ended: Event = field(default_factory=Event)
    _silent: Event = field(default_factory=Event)

    def __enter__(self) -> Self:
        if self.console.is_terminal:
            self._start()
        else:
            Thread(target=self._print_lines, daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        if self._live is not None:
            self._live.stop()

    def _start(self) -> None:
        self._live = Live(console=self.console, transient=True, refresh_per_second=4, get_renderable=self._line)
        self._live.start()

    @contextmanager
    def paused(self) -> Generator[None]:
        """Take the line away while the block writes to the terminal; its time does not count in the estimate."""
        begun = time.monotonic()
        if self._live is None:
            self._silent.set()
            yield
            self._silent.clear()
            self.started += time.monotonic() - begun
            return
        self._live.stop()
        try:
            yield
        finally:
            self.started += time.monotonic() - begun
            self._start()

    def on_runs(self, runs: int, budget: int) -> None:
        """Take the runs of the current file."""
        self.current = (runs, budget)

    def file_done(self, runs: int) -> None:
        """Take the runs of a finished file."""
        self.done, self.runs, self.current = self.done + 1, self.runs + runs, (0, 1)

    def _print_lines(self) -> None:
        while not self._ended.wait(self.interval):
            if self._silent.is_set():
                continue
            with suppress(OSError):
                self.console.print(self._line(), soft_wrap=True)

    def _line(self) -> Text:
        runs, budget = self.current
        share = (self.done + runs / max(1, budget)) / max(1, self.files)
        seconds = time.monotonic() - self.started
        left = f", {duration(seconds / share * (1.0 - share))} left" if share > 0.0 else ""
        return Text(
            f"{self.done:,} of {counted(self.files, self.noun)}, {counted(self.runs + runs, 'run')}{left}", "quiet"
        )
