"""A search while it runs: a few calm lines that are redrawn in place, and vanish when it is over."""

import math
import time
from dataclasses import dataclass, field
from types import TracebackType

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import duration, fixed, whole
from cortex_dsl.report.run_document import HIGHEST
from cortex_dsl.report.sparkline import sparkline
from cortex_dsl.report.theme import method_style
from engine.search.figures import Figures

BAR = 20
CURVE = 36


@dataclass
class SearchProgress:
    """Shows one search. On a terminal it redraws; elsewhere it is silent, as nobody watches."""

    console: Console
    method: str
    total: int
    """Generations to come in all."""
    figures: list[Figures] = field(default_factory=list)
    """Of the generations so far; of a run that goes on, those that it had too."""
    spent: float = 0.0
    """What they took [s]."""
    simulations: int = 0
    best: float = math.nan
    started: float = field(default_factory=time.monotonic)
    _live: Live | None = None

    def __enter__(self) -> "SearchProgress":
        if self.console.is_terminal:
            self._live = Live(console=self.console, transient=True, refresh_per_second=8, get_renderable=self._render)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def generation_done(self, figures: Figures, simulations: int, best: float) -> None:
        """One more generation; `simulations` counts all so far, `best` is the highest risk so far."""
        self.figures.append(figures)
        self.simulations = simulations
        self.best = best

    def _render(self) -> RenderableType:
        seconds = self.spent + time.monotonic() - self.started
        return progress_view(self.method, self.figures, self.total, self.simulations, seconds, self.best)


def progress_view(
    method: str, figures: list[Figures], total: int, simulations: int, seconds: float, best: float
) -> RenderableType:
    """What is known so far: how far, how fast, how good."""
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


def _course(figures: list[Figures]) -> str:
    return sparkline([f.rl for f in figures], CURVE, low=0.0, high=HIGHEST)
