"""Output of `:plot`: a histogram of one expression over many scenes, or two expressions against each other.

The same picture shows collisions: as part of a column, or as a mark.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.plotted import Plotted, Shown
from cortex_dsl.report.findings.readable import (
    column_decimals,
    counted,
    fixed,
    format_gene,
    percent,
    ratio,
    significant,
)
from cortex_dsl.report.terminal.canvas import Canvas, Window
from cortex_dsl.report.terminal.theme import EIGHTHS, LEVELS, bar, columns, left, right, section
from engine.search.statistics import spearman
from engine.vocabulary import GeneKind

if TYPE_CHECKING:
    from engine.acceptance import AcceptanceStatistics
    from engine.tables import Bools, Floats

ROWS = 8
WIDEST = 60
FEWEST_COLUMNS = 10
IN_A_COLUMN = 100
"""Accepted draws per column, so that the shape is not due to chance."""
RUNS_IN_A_COLUMN = 15
"""The same of runs, of which there are fewer."""
OPTIONS_BAR = 30


@dataclass(frozen=True)
class Scale:
    """The ends of an axis, and how a value on it is written."""

    low: float
    high: float
    text: Callable[[float], str]
    whole: bool = False
    """Whether there are whole numbers only."""


def _title(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


# -- the accepted values of one param, drawn over those that were drawn ------------------------------------------------


def distribution_view(
    weighing: "AcceptanceStatistics", gene: int, width: int, *, ascii_only: bool = False
) -> RenderableType:
    """Return a histogram of accepted values; dots show its height if all draws were accepted."""
    space = weighing.program.space
    drawn, accepted = weighing.genomes[:, gene], weighing.genomes[weighing.accepted][:, gene]
    note = f"{len(accepted):,} accepted of {counted(len(drawn), 'draw')}"
    title = _title(space.names[gene], space.units[gene])
    if not len(accepted):
        return section(title, Text("no draw is accepted; `:relax` shows why", "warn"), note)
    if space.kinds[gene] == GeneKind.INDEX:
        return section(title, _options(weighing, gene, drawn, accepted, ascii_only), note)
    ends = float(space.low[gene]), float(space.high[gene])
    scale = Scale(*ends, lambda value: format_gene(space, gene, value), space.kinds[gene] == GeneKind.INTEGER)
    before, after = _heights(scale, (drawn, accepted), _room(width), IN_A_COLUMN)
    below = Text.assemble(
        ("accepted: ", "quiet"),
        _middle(scale, accepted),
        ("   . " if ascii_only else "   · ", "warn"),
        ("as drawn", "quiet"),
    )
    columns_of = Columns(after, before=before)
    return section(title, Group(*_chart(columns_of, scale, ascii_only=ascii_only), below), note)


def _options(
    weighing: "AcceptanceStatistics", gene: int, drawn: "Floats", accepted: "Floats", ascii_only: bool
) -> RenderableType:
    names = weighing.program.space.options[gene]
    shares = [np.bincount(values.astype(int), minlength=len(names)) / len(values) for values in (drawn, accepted)]
    rows = []
    for name, before, after in zip(names, *shares, strict=True):
        filled = "#" * round(after * OPTIONS_BAR) if ascii_only else bar(float(after), 1.0, OPTIONS_BAR)
        rows.append((Text(name), Text(percent(before), "quiet"), Text(percent(after)), Text(filled, "bar")))
    return columns(left(), right("drawn"), right("accepted"), left(), rows=rows, header=True)


# -- one expression over scenes, or runs -------------------------------------------------------------------------------


def values_view(shown: Shown, width: int, *, ascii_only: bool = False) -> RenderableType:
    """Return a histogram of a number, or shares of a truth or choice; collisions are marked."""
    (thing,) = shown.things
    if not len(shown.collided):
        return section(thing.name, Text("no scene is accepted; `:relax` shows why", "warn"), shown.note)
    if thing.options:
        return section(thing.name, _shares(thing, shown, ascii_only), shown.note)
    here = np.isfinite(thing.values)
    values, collided = thing.values[here], shown.collided[here]
    missing = [] if here.all() else [Text(f"{counted(int((~here).sum()), shown.noun)} without such a number", "quiet")]
    title = _title(thing.name, thing.unit)
    if not len(values):
        return section(title, Group(*missing), shown.note)
    kept = [] if thing.kept is None else [_kept(thing.kept)]
    if values.min() == values.max():
        always = Text(f"always {significant(float(values[0]))} {thing.unit}".rstrip())
        return section(title, Group(always, *kept, *missing), shown.note)
    scale = _scale(values)
    every, those = _heights(scale, (values, values[collided]), _room(width), RUNS_IN_A_COLUMN, of=len(values))
    chart = _chart(Columns(every, those), scale, ascii_only=ascii_only)
    below = Text.assemble(_middle(scale, values), *_legend(shown, ascii_only))
    return section(title, Group(*chart, below, *kept, *missing), shown.note)


def _scale(values: "Floats") -> Scale:
    low, high = float(values.min()), float(values.max())
    if np.all(values == np.round(values)) and high - low < WIDEST:
        return Scale(low, high, lambda value: fixed(value, 0), whole=True)
    decimals = column_decimals(low, high)
    return Scale(low, high, lambda value: fixed(value, decimals))


def _kept(kept: "Bools") -> Text:
    """Return a line on the Boolean verdict of a formula, which also decides at robustness 0."""
    if kept.all():
        return Text("it holds in every run", "good")
    return Text.assemble("it holds in ", f"{int(kept.sum()):,} of {len(kept):,} runs", "; below 0 it does not")


def _legend(shown: Shown, ascii_only: bool) -> Iterator[tuple[str, str]]:
    """Yield the legend for the marked part of a column."""
    if shown.ran:
        mark = ("x" if ascii_only else "▓") if shown.collided.any() else ""
        yield f"   {mark} " if mark else "   ", "bad"
        yield _collided(shown), "quiet"


def _collided(shown: Shown) -> str:
    hit, runs = int(shown.collided.sum()), len(shown.collided)
    return f"{hit:,} of {runs:,} collided" if hit else f"none of {counted(runs, 'run')} collided"


def _shares(thing: Plotted, shown: Shown, ascii_only: bool) -> RenderableType:
    """Return the frequency of each option, and of collisions with it."""
    rows = []
    for number, option in enumerate(thing.options):
        chosen = thing.values == number
        share, hit = float(chosen.mean()), ratio(int(shown.collided[chosen].sum()), int(chosen.sum()))
        filled = "#" * round(share * OPTIONS_BAR) if ascii_only else bar(share, 1.0, OPTIONS_BAR)
        last = [Text(percent(hit).replace("–", "-") if ascii_only else percent(hit), "bad" if hit else "quiet")]
        row = (Text(option), Text(f"{int(chosen.sum()):,}"), Text(percent(share)), Text(filled, "bar"))
        rows.append((*row, *(last if shown.ran else [])))
    head = (left(), right(f"{shown.noun}s"), right(), left(), *([right("of them collide")] if shown.ran else []))
    return columns(*head, rows=rows, header=True)


# -- columns made of characters ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Columns:
    """Heights of the columns of a histogram, in rows of characters; the highest is `ROWS`."""

    heights: "Floats"
    marked: "Floats | None" = None
    """Marked part of each column, from its foot."""
    before: "Floats | None" = None
    """Earlier heights; a dot marks a column that was higher."""


def _room(width: int) -> int:
    return min(WIDEST, width - 8)


def _heights(
    scale: Scale, values: "Sequence[Floats]", room: int, in_a_column: int, of: int | None = None
) -> "list[Floats]":
    """Return the bar heights of several histograms: shares of `of` values, or of the values of each histogram."""
    fewest = min(len(each) for each in values) if of is None else of
    bins = max(FEWEST_COLUMNS, min(room, fewest // in_a_column))
    edges = _edges(scale.low, scale.high, bins, whole=scale.whole)
    shares = [np.histogram(each, bins=edges)[0] / (len(each) if of is None else of) for each in values]
    highest = max(float(each.max()) for each in shares)
    return [np.repeat(each / highest * ROWS, max(1, room // len(each))) for each in shares]


def _edges(low: float, high: float, most: int, *, whole: bool) -> "Floats":
    """Ends of the columns; of whole numbers each column holds equally many."""
    if not whole:
        return np.linspace(low, high, most + 1)
    step = int((high - low) // most) + 1
    return np.arange(low - 0.5, high + 0.5 + step, step)


def _chart(drawn: Columns, scale: Scale, *, ascii_only: bool) -> Iterator[Text]:
    """The columns, and below them the ends of their scale."""
    for row in reversed(range(ROWS)):
        yield _line(drawn, row, ascii_only)
    yield from _axis(scale, len(drawn.heights), ascii_only)


def _axis(scale: Scale, width: int, ascii_only: bool) -> Iterator[Text]:
    low, high = (scale.text(end) for end in (scale.low, scale.high))
    yield Text(("-" if ascii_only else "─") * width, "quiet")
    yield Text(f"{low}{high:>{max(1, width - len(low))}}", "quiet")


def _middle(scale: Scale, values: "Floats") -> str:
    """Median and the bulk of the values."""
    at = [scale.text(float(np.quantile(values, q))) for q in (0.05, 0.5, 0.95)]
    return f"median {at[1]}, nine tenths in {at[0]} .. {at[2]}"


def _line(drawn: Columns, row: int, ascii_only: bool) -> Text:
    """One row of characters; the columns are filled up to their heights."""
    line = Text()
    nothing = np.zeros_like(drawn.heights)
    marked, before = (nothing if each is None else each for each in (drawn.marked, drawn.before))
    for height, reported, prior in zip(drawn.heights.tolist(), marked.tolist(), before.tolist(), strict=True):
        part = height - row
        if reported > row and reported - row >= min(0.5, part / 2):
            line.append("x" if ascii_only else "▓", "bad")
        elif part >= 1 - 1 / 16:
            line.append("#" if ascii_only else EIGHTHS[8], "bar")
        elif drawn.before is not None and row <= prior < row + 1 and part < 0.5:
            line.append("." if ascii_only else "·", "warn")
        elif part > 1 / 16:
            line.append(":" if ascii_only else LEVELS[min(7, int(part * 8))], "bar")
        else:
            line.append(" ")
    return line


# -- two expressions against each other --------------------------------------------------------------------------------

HIGH = 16
"""Rows of characters."""


def scatter_view(shown: Shown, width: int, *, ascii_only: bool = False) -> RenderableType:
    """A dot for each scene, a cross for each that collided; the first thing to the right, the second upwards."""
    across, up = shown.things
    title = f"{_title(up.name, up.unit)} over {_title(across.name, across.unit)}"
    here = np.isfinite(across.values) & np.isfinite(up.values)
    if not here.any():
        return section(title, Text("no scene has both", "warn"), shown.note)
    points, collided = np.stack([across.values, up.values], axis=1)[here], shown.collided[here]
    scales = [_scale_of(across, points[:, 0]), _scale_of(up, points[:, 1])]
    labels = [scales[1].text(end) for end in (scales[1].high, scales[1].low)]
    beside = max(map(len, labels))
    room = max(FEWEST_COLUMNS, min(WIDEST, width - 8 - beside))
    spread = np.stack([_apart(thing, points[:, place]) for place, thing in enumerate(shown.things)], axis=1)
    canvas = _dots(spread, collided, scales, room, ascii_only=ascii_only)
    lines = [
        Text.assemble((f"{label:>{beside}} ", "quiet"), ("|" if ascii_only else "│", "quiet"), line)
        for label, line in zip(
            [labels[0], *[""] * (HIGH - 2), labels[1]], canvas.lines(ascii_only=ascii_only), strict=True
        )
    ]
    axis = [Text.assemble(" " * (beside + 2), line) for line in _axis(scales[0], room, ascii_only)]
    rho = spearman(points[:, 0], points[:, 1])
    below = Text.assemble(("rank correlation ", "quiet"), f"{rho:+.2f}" if np.isfinite(rho) else "none")
    if shown.ran:
        below.append("   x " if ascii_only else "   × ", "bad").append(_collided(shown), "quiet")
    return section(title, Group(*lines, *axis, below), shown.note)


def _scale_of(thing: Plotted, values: "Floats") -> Scale:
    """Return the scale of the numbers, or one place for each option, with names at the ends."""
    if not thing.options:
        return _scale(values)
    last = len(thing.options) - 1
    return Scale(-0.5, last + 0.5, lambda value: thing.options[0 if value < 0 else last])


def _apart(thing: Plotted, values: "Floats") -> "Floats":
    """Spread equal options by the golden ratio, without randomness, so that they do not overlap on one line."""
    return values + ((np.arange(len(values)) * 0.618034) % 1.0 - 0.5) * 0.7 if thing.options else values


def _dots(points: "Floats", collided: "Bools", scales: Sequence[Scale], room: int, *, ascii_only: bool) -> Canvas:
    """The drawing; a character holds two dots across and four up."""
    canvas = Canvas(room, HIGH, Window(0.0, 0.0, 1.0))
    low = np.array([scale.low for scale in scales])
    width = np.array([max(scale.high - scale.low, 1e-300) for scale in scales])
    most = np.array([2 * room - 1, 4 * HIGH - 1])
    places = (points - low) / width * most - np.array([room, 2 * HIGH - 1])
    for (x, y), hit in zip(places.tolist(), collided.tolist(), strict=True):
        if hit:
            canvas.mark((x, y), "x" if ascii_only else "×", "bad")
        else:
            canvas.line([(x, y), (x + 1.0, y)], "bar")
    return canvas
