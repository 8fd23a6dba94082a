"""A search or a study while it runs: a few calm lines that are redrawn in place, and vanish when it is over. Where the
output is no terminal, a line every 30 seconds. The first runs give an estimate of the whole.
"""

import math
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from threading import Event, Thread
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from cortex_dsl.report.findings.readable import duration, fixed, percent, whole
from cortex_dsl.report.findings.run_report import HIGHEST
from cortex_dsl.report.findings.search_report import method_style
from cortex_dsl.report.terminal.theme import columns, left, right, sparkline
from engine.run_count import counting
from engine.search.probability.estimates import NOT_KNOWN
from engine.search.statistics import Interval

if TYPE_CHECKING:
    from engine.scenes import Scenes
    from engine.search.evaluations import Figures
    from engine.study.plan import Plan
    from engine.study.run_records import RunRecord

BAR = 20
CURVE = 36
INTERVAL = 30.0
"""Time between two lines about a search where the output is no terminal [s]."""


FIRST_RUNS = 50
"""Runs after the first results from which the cost of a run is estimated; fewer, if they take longer than `WARM`."""
WARM = 5.0
"""[s]"""
LONG = 10.0
"""Least time left for which an estimate is shown [s]."""


@dataclass
class Estimate:
    """Prints once, after the first runs, the cost of a run and the time of the whole, if much of it is left."""

    console: Console
    of: str = "run"
    """Name of the counted unit."""
    whole: str = "in all"
    started: float = field(default_factory=time.monotonic)
    _measured_from: tuple[float, int] | None = None
    _shown: bool = False

    def update(self, done: int, left: float) -> None:
        """Take into account that `done` runs have ended since the start and `left` runs remain."""
        now = time.monotonic()
        if self._shown or not done:
            return
        if self._measured_from is None:  # the first results include loading and compiling
            self._measured_from = now, done
            return
        since, before = self._measured_from
        runs, seconds = done - before, now - since
        if not runs or (runs < FIRST_RUNS and seconds < WARM):
            return
        each = seconds / runs
        total = now - self.started + each * left
        if each * left >= LONG:
            self._shown = True
            cost = duration(each) if each >= 1.0 else f"{float(f'{1000.0 * each:.2g}'):g} ms"
            text = f"about {cost} a {self.of}, about {duration(total)} {self.whole}"
            with suppress(OSError):
                self.console.print(text, style="quiet", soft_wrap=True)


class Ticker:
    """Prints a line at each interval where the output is no terminal, from the start of a block to its end."""

    def __init__(self, console: Console, line: Callable[[], Text], interval: float = INTERVAL) -> None:
        self._console, self._line, self._interval, self._ended = console, line, interval, Event()
        self.thread = Thread(target=self._print_lines, daemon=True)

    def __enter__(self) -> "Ticker":
        if not self._console.is_terminal:
            self.thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()

    def _print_lines(self) -> None:
        while not self._ended.wait(self._interval):
            with suppress(OSError):
                self._console.print(self._line(), soft_wrap=True)


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
    rate: Interval = NOT_KNOWN
    """Probability of a collision from independent draws, 95 % at every look; NaN: unknown."""
    interval: float = INTERVAL
    started: float = field(default_factory=time.monotonic)
    _live: Live | None = None
    ticker: Ticker = field(init=False)
    estimate: Estimate = field(init=False)

    def __post_init__(self) -> None:
        self.ticker = Ticker(self.console, self._line, self.interval)
        self.estimate = Estimate(self.console, whole="in all" if not self.figures else "for the rest")
        self._before = len(self.figures)

    def __enter__(self) -> "SearchProgress":
        self.ticker.__enter__()
        if self.console.is_terminal:
            self._live = Live(console=self.console, transient=True, refresh_per_second=8, get_renderable=self._render)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.ticker.__exit__(kind, value, trace)
        if self._live is not None:
            self._live.stop()

    def generation_done(self, figures: "Figures", simulations: int, best: float) -> None:
        """One more generation; `simulations` counts all so far, `best` is the highest risk so far."""
        if len(self.figures) == self._before > 0:
            self.estimate.started = time.monotonic()  # what came before was no run, but those of the journal again
        self.figures.append(figures)
        self.simulations = simulations
        self.best = best
        done = sum(each.individuals for each in self.figures[self._before :])
        self.estimate.update(done, figures.individuals * (self.total - len(self.figures)))

    def _line(self) -> Text:
        seconds = self.spent + time.monotonic() - self.started
        return progress_line(self.method, len(self.figures), self.total, self.simulations, seconds).append(self._rate())

    def _rate(self) -> str:
        low, high = self.rate
        return f", {percent(low)} to {percent(high)} of valid draws collide" if math.isfinite(low) else ""

    def _render(self) -> RenderableType:
        seconds = self.spent + time.monotonic() - self.started
        view = progress_view(self.method, self.figures, self.total, self.simulations, seconds, self.best)
        rate = self._rate().removeprefix(", ")
        return Group(view, Text(rate, "quiet")) if rate else view


@contextmanager
def measured(console: Console, total: int | None) -> Iterator[None]:
    """Show the runs that hosts of this process report, with an estimate; `total` is their number, None if unknown."""
    with _shown_count(console, total, "run", "runs") as count, counting(count):
        yield


def with_progress(console: Console, total: int, blocks: Iterable["Scenes"]) -> Iterator["Scenes"]:
    """Pass blocks of scenes on, and show how many of all are drawn, and for how long the others take."""
    hint = "; Ctrl-C shows what there is" if console.is_terminal else ""
    with _shown_count(console, total, "scene", "scenes drawn", hint) as count:
        for block in blocks:
            yield block
            count(len(block))


@contextmanager
def _shown_count(
    console: Console, total: int | None, unit: str, units: str, hint: str = ""
) -> Iterator[Callable[[int], None]]:
    """Show how many of `total` units are done, and give the function that counts more of them."""
    done, started = 0, time.monotonic()
    estimate = Estimate(console, unit, started=started)

    def line() -> Text:
        return count_line(done, total, units, time.monotonic() - started).append(hint, "quiet")

    def count(more: int) -> None:
        nonlocal done
        done += more
        if total is not None:
            estimate.update(done, max(0, total - done))

    live = Live(console=console, transient=True, refresh_per_second=4, get_renderable=line)
    with Ticker(console, line), live if console.is_terminal else nullcontext():
        yield count


def count_line(done: int, total: int | None, of: str, seconds: float) -> Text:
    """Return how many of all are done, and the time left at the pace so far, or the time so far."""
    if total is None:
        return Text(f"{done:,} {of}, {duration(seconds)} so far", "quiet")
    if not done:
        return Text(f"0 of {total:,} {of}, {duration(seconds)} so far", "quiet")
    left_over = f", {duration(seconds / done * (total - done))} left" if done < total else ""
    return Text(f"{done:,} of {total:,} {of}{left_over}", "quiet")


def progress_line(method: str, done: int, total: int, simulations: int, seconds: float) -> Text:
    """Return the content of `progress_view` as one line of plain text."""
    if not done:
        least = f", at least {duration(seconds * total)} in all" if total > 1 else ""
        return Text(f"{method}: generation 1 of {total}, {duration(seconds)} so far{least}")
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


@dataclass
class StudyProgress:
    """Shows a study. On a terminal it redraws in place, and vanishes at the end; elsewhere it prints lines."""

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
    interval: float = INTERVAL
    _live: Live | None = None
    ticker: Ticker = field(init=False)
    estimate: Estimate = field(init=False)

    def __post_init__(self) -> None:
        self.ticker = Ticker(self.console, self._headline, self.interval)
        self.estimate = Estimate(self.console, "simulation", "in all" if not self.earlier else "for the rest")
        for record in self.earlier:
            self._keep(record)

    def _keep(self, record: "RunRecord") -> None:
        self.found[record.address.scenario, record.address.method].append(record.figures.distinct_collisions)

    def __enter__(self) -> "StudyProgress":
        if self.console.is_terminal and not self.quiet:
            self._live = Live(console=self.console, transient=True, refresh_per_second=6, get_renderable=self._render)
            self._live.start()
        elif not self.quiet:
            self.ticker.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.ticker.__exit__(kind, value, trace)
        if self._live is not None:
            self._live.stop()

    def run_done(self, record: "RunRecord") -> None:
        """Record one finished run."""
        self._keep(record)
        self.new += 1
        self.simulations += record.figures.simulations.runs
        if not self.quiet:
            self.estimate.update(self.simulations, self.simulations / self.new * (self.total - self.done))

    @property
    def total(self) -> int:
        return self.plan.runs * len(self.plan.subjects) * len(self.plan.methods)

    @property
    def done(self) -> int:
        return len(self.earlier) + self.new

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
