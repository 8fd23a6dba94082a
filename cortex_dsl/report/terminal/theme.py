"""How every view looks: colours by name, headings and columns without boxes, curves and bars made of characters.

Only the terminal's own sixteen colours are used, so that its theme decides the shades.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Column, Table
from rich.text import Text
from rich.theme import Theme

from cortex_dsl.report.findings.readable import first_line, name_of
from engine.program import Program

THEME = Theme(
    {
        "title": "bold",
        "quiet": "bright_black",
        "unit": "bright_black",
        "road": "bright_black",
        "good": "green",
        "bad": "bold red",
        "warn": "yellow",
        "bar": "blue",
        "part.C": "red",
        "part.MD": "yellow",
        "part.D_MS": "magenta",
        "part.TTC_MS": "blue",
        "actor.0": "bold cyan",
        "actor.1": "bold magenta",
        "actor.2": "bold yellow",
        "actor.3": "bold green",
        "actor.4": "bold blue",
        "actor.5": "bold white",
        # the marks that rich.progress uses
        "bar.complete": "blue",
        "bar.finished": "blue",
        "bar.back": "bright_black",
    }
)

# -- layout: quiet headings, columns without boxes, two spaces of margin -----------------------------------------------

MARGIN = 2


def heading(title: str, note: str = "") -> Text:
    """A section's title, with a remark in a quiet voice."""
    return Text.assemble((title, "title"), ("  " + note if note else "", "quiet"))


def section(title: str, body: RenderableType, note: str = "") -> Group:
    """A titled block, set apart by an empty line."""
    return Group(Text(), heading(title, note), indented(body))


def indented(body: RenderableType) -> Padding:
    return Padding(body, (0, 0, 0, MARGIN))


def columns(*specification: Column, rows: Iterable[Iterable[RenderableType]] = (), header: bool = False) -> Table:
    """Return a table without lines. Columns of numbers should be right-aligned."""
    table = Table(
        *specification,
        box=None,
        show_header=header,
        header_style="quiet",
        padding=(0, 2, 0, 0),
        pad_edge=False,
        collapse_padding=True,
    )
    for row in rows:
        table.add_row(*row)
    return table


def left(title: str = "", style: str = "", *, wrap: bool = False) -> Column:
    return Column(title, style=style, no_wrap=not wrap, overflow="fold" if wrap else "ellipsis")


def right(title: str = "", style: str = "") -> Column:
    return Column(title, style=style, justify="right", no_wrap=True)


def quantity(number: str, unit: str) -> Text:
    """A number and its unit in a quiet voice."""
    return Text.assemble(number, (" " + unit if unit else "", "unit"))


# -- a curve in one line of block characters, and bars of eighths of a character ---------------------------------------

LEVELS = "▁▂▃▄▅▆▇█"
EIGHTHS = " ▏▎▍▌▋▊▉█"


def sparkline(values: Sequence[float], width: int, low: float | None = None, high: float | None = None) -> str:
    """The values in `width` characters; a gap where there is none (NaN). Longer series are averaged into columns.

    `low` and `high` are the values of the lowest and the highest character, by default those of the series itself.
    """
    columns = _columns(values, width)
    finite = [v for v in columns if math.isfinite(v)]
    if not finite:
        return " " * len(columns)
    bottom = min(finite) if low is None else low
    top = max(finite) if high is None else high
    return "".join(_level(v, bottom, top) for v in columns)


def bar(value: float, full: float, width: int) -> str:
    """A bar for value / full, exact to an eighth of a character; something is shown for everything above zero."""
    share = value / full if full > 0 else 0.0
    if not math.isfinite(share) or share <= 0:
        return ""
    eighths = max(1, round(min(share, 1.0) * width * 8))
    return EIGHTHS[8] * (eighths // 8) + (EIGHTHS[eighths % 8] if eighths % 8 else "")


def _columns(values: Sequence[float], width: int) -> list[float]:
    if len(values) <= width:
        return [float(v) for v in values]
    edges = [round(i * len(values) / width) for i in range(width + 1)]
    return [_mean(values[a:b]) for a, b in pairwise(edges)]


def _mean(values: Sequence[float]) -> float:
    finite = [float(v) for v in values if math.isfinite(v)]
    return sum(finite) / len(finite) if finite else math.nan


def _level(value: float, bottom: float, top: float) -> str:
    if not math.isfinite(value):
        return " "
    half = top / 2 - bottom / 2  # halves, since a whole span may overflow
    share = (value / 2 - bottom / 2) / half if half > 0 else 0.0
    return LEVELS[max(0, min(7, int(share * 8)))]


# -- title of a scenario's report --------------------------------------------------------------------------------------


def title_of(program: Program) -> Text:
    """The name of a scenario and the first line of its docstring."""
    return heading(name_of(program), first_line(program.description))
