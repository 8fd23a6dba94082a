"""A search or a study while it runs: a few calm lines that are redrawn in place, and vanish when it is over. Where the
output is no terminal, a line now and then.
"""

import math
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from threading import Event, Thread
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from cortex_dsl.report.findings.readable import duration, fixed, whole
from cortex_dsl.report.findings.run_report import HIGHEST
from cortex_dsl.report.findings.search_report import method_style
from cortex_dsl.report.terminal.theme import columns, left, right, sparkline

if TYPE_CHECKING:
    from engine.scenes import Scenes
    from engine.search.evaluations import Figures
    from engine.study.plan import Plan
    from engine.study.run_records import RunRecord

BAR = 20
CURVE = 36
INTERVAL = 30.0
"""Time between two lines about a search where the output is no terminal [s]."""


@dataclass
class SearchProgress:
    """Shows one search. On a terminal it redraws; elsewhere it prints a line every `interval` seconds."""

    console: Console
    method: str
    total: int
    """Number of generations in all."""
    figures: "list[Figures]" = field(default_factory=list)
    """Figures of the generations so far, including those before a resume."""
    spent: float = 0.0
    """Time that these generations took [s]."""
    simulations: int = 0
    best: float = math.nan
    interval: float = INTERVAL
    started: float = field(default_factory=time.monotonic)
    _live: Live | None = None
    _ended: Event = field(default_factory=Event)
    thread: Thread = field(init=False)
    """Prints the lines."""

    def __post_init__(self) -> None:
        self.thread = Thread(target=self._print_lines, daemon=True)

    def __enter__(self) -> "SearchProgress":
        if self.console.is_terminal:
            self._live = Live(console=self.console, transient=True, refresh_per_second=8, get_renderable=self._render)
            self._live.start()
        else:
            self.thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        if self._live is not None:
            self._live.stop()

    def generation_done(self, figures: "Figures", simulations: int, best: float) -> None:
        """One more generation; `simulations` counts all so far, `best` is the highest risk so far."""
        self.figures.append(figures)
        self.simulations = simulations
        self.best = best

    def _print_lines(self) -> None:
        """Print a line at each interval until the search ends; a generation may last longer than that."""
        while not self._ended.wait(self.interval):
            seconds = self.spent + time.monotonic() - self.started
            line = progress_line(self.method, len(self.figures), self.total, self.simulations, seconds)
            with suppress(OSError):
                self.console.print(line, soft_wrap=True)

    def _render(self) -> RenderableType:
        seconds = self.spent + time.monotonic() - self.started
        return progress_view(self.method, self.figures, self.total, self.simulations, seconds, self.best)


def with_progress(console: Console, total: int, blocks: Iterable["Scenes"]) -> Iterator["Scenes"]:
    """Pass blocks of scenes on. On a terminal a line says how many of all are drawn; elsewhere nothing does."""
    if not console.is_terminal:
        yield from blocks
        return
    done, started = 0, time.monotonic()

    def line() -> RenderableType:
        seconds = time.monotonic() - started
        left_over = seconds / done * (total - done) if done else math.nan
        togo = f", {duration(left_over)} left" if done else ""
        return Text(f"{done:,} of {total:,} scenes drawn{togo}; Ctrl-C shows what there is", "quiet")

    with Live(console=console, transient=True, refresh_per_second=4, get_renderable=line):
        for block in blocks:
            yield block
            done += len(block)


def progress_line(method: str, done: int, total: int, simulations: int, seconds: float) -> Text:
    """Return the content of `progress_view` as one line of plain text."""
    if not done:
        return Text(f"{method}: generation 1 of {total}, {duration(seconds)} so far")
    runs = f", {whole(simulations)} runs" if simulations else ""
    return Text(f"{method}: {done} of {total} generations{runs}, {duration(seconds / done * (total - done))} left")


def progress_view(
    method: str, figures: "list[Figures]", total: int, simulations: int, seconds: float, best: float
) -> RenderableType:
    """Return the progress so far: generations, speed, and results."""
    done = len(figures)
    rate = simulations / seconds if seconds > 0 else 0.0
    left_over = seconds / done * (total - done) if done else math.nan
    filled = BAR * done // total
    top = Text.assemble(
        (f"{method:<6}", method_style(method)),
        f" generation {done} of {total}  ",
        ("━" * filled, "bar"),
        ("─" * (BAR - filled), "quiet"),
        f"  {whole(rate)} sim/s",
        (f"  {duration(left_over)} left" if done else "", "quiet"),
    )
    if not figures:
        return top
    last = figures[-1]
    cells = (
        fixed(last.rl, 2),
        whole(last.nc),
        fixed(last.mdg, 2),
        fixed(last.mdec, 2),
        whole(last.nis),
        whole(best),
    )
    head = (right("RL"), right("NC"), right("MDG m"), right("MDEC m"), right("NIS"), right("best"))
    table = columns(*head, rows=[[Text(cell) for cell in cells]], header=True)
    course = columns(left(), left(), rows=[(Text("RL", "quiet"), Text(_course(figures), method_style(method)))])
    return Group(top, table, course)


def _course(figures: "list[Figures]") -> str:
    return sparkline([f.rl for f in figures], CURVE, low=0.0, high=HIGHEST)


# -- a study: a bar for every scenario and method, its results so far, the pace and the remaining time -----------------

WIDEST = 14
"""Characters of a bar."""
CELL_MARGIN = 8
"""Characters of a cell in addition to its bar."""
FEW = 4
"""Number of methods up to which methods are in columns."""
LINES = 10
"""Lines of progress that a study prints in all where the output is no terminal."""


@dataclass
class StudyProgress:
    """On a terminal it redraws in place, and vanishes at the end; elsewhere it says a line now and then."""

    console: Console
    plan: "Plan"
    jobs: int
    earlier: "Sequence[RunRecord]" = ()
    """Runs that were finished before this process began."""
    quiet: bool = False
    found: dict[tuple[int, str], list[int]] = field(default_factory=lambda: defaultdict(list))
    """Colliding genomes of each finished run of a cell."""
    new: int = 0
    """Number of runs that this process finished."""
    simulations: int = 0
    """Number of simulations in these runs."""
    started: float = field(default_factory=time.monotonic)
    _live: Live | None = None

    def __post_init__(self) -> None:
        for record in self.earlier:
            self._keep(record)

    def _keep(self, record: "RunRecord") -> None:
        self.found[record.address.scenario, record.address.method].append(record.figures.distinct_collisions)

    def __enter__(self) -> "StudyProgress":
        if self.console.is_terminal and not self.quiet:
            self._live = Live(console=self.console, transient=True, refresh_per_second=6, get_renderable=self._render)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def run_done(self, record: "RunRecord") -> None:
        """Record one finished run."""
        self._keep(record)
        self.new += 1
        self.simulations += record.figures.simulations.runs
        if self._live is None and not self.quiet and self._is_milestone():
            self.console.print(self._headline())

    @property
    def total(self) -> int:
        return self.plan.runs * len(self.plan.subjects) * len(self.plan.methods)

    @property
    def done(self) -> int:
        return len(self.earlier) + self.new

    def _is_milestone(self) -> bool:
        return self.done * LINES // self.total > (self.done - 1) * LINES // self.total

    def _headline(self) -> Text:
        seconds = time.monotonic() - self.started
        left_over = seconds / self.new * (self.total - self.done) if self.new else math.nan
        pace = f"{whole(self.simulations / seconds)} simulations a second" if seconds > 0 and self.new else "starting"
        return Text.assemble(
            ("study", "title"),
            f" {self.done:,} of {self.total:,} runs  {pace}",
            (f"  {duration(left_over)} left" if self.new else "", "quiet"),
            (f"  {self.jobs} {'process' if self.jobs == 1 else 'processes'}", "quiet"),
        )

    def _render(self) -> RenderableType:
        """The fewer of methods and scenarios are the columns."""
        scenarios, methods = [subject.name for subject in self.plan.subjects], list(self.plan.methods)
        turned = len(methods) > max(len(scenarios), FEW)
        across, down = (scenarios, methods) if turned else (methods, scenarios)
        room = (self.console.width - max(map(len, down))) // len(across) - CELL_MARGIN
        width = max(2, min(WIDEST, room))
        rows = []
        for i, name in enumerate(down):
            places = [(j, name) if turned else (i, method) for j, method in enumerate(across)]
            rows.append([Text(name, "quiet"), *(self._cell(place, width) for place in places)])
        head = [left(), *(left(name[: width + CELL_MARGIN - 2]) for name in across)]
        note = Text("runs finished, and median of colliding genomes; Ctrl-C keeps what is finished", "quiet")
        return Group(self._headline(), columns(*head, rows=rows, header=True), note)

    def _cell(self, place: tuple[int, str], width: int) -> Text:
        """Return a bar of the finished runs, and the median of their results."""
        found = self.found[place]
        filled = width * len(found) // self.plan.runs
        number = whole(float(np.median(found))) if found else ""
        return Text.assemble(("━" * filled, method_style(place[1])), ("─" * (width - filled), "quiet"), f" {number:>5}")
