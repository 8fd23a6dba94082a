"""The accepted values of one param, drawn over those that were drawn."""

from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right, section
from cortex_dsl.report.numbers import counted, format_gene, percent
from cortex_dsl.report.sparkline import EIGHTHS, LEVELS, bar
from engine.vocabulary import GeneKind

if TYPE_CHECKING:
    from engine.blame import Weighing
    from engine.tables import Floats

ROWS = 8
WIDEST = 60
FEWEST_COLUMNS = 10
DRAWS_IN_A_COLUMN = 100
"""Accepted draws that a column should hold, so that what is seen is not chance."""
OPTIONS_BAR = 30


def distribution_view(weighing: "Weighing", gene: int, width: int, *, ascii_only: bool = False) -> RenderableType:
    """A histogram of what is accepted; dots where it would reach if all draws were."""
    space = weighing.program.space
    drawn, accepted = weighing.genomes[:, gene], weighing.genomes[weighing.accepted][:, gene]
    note = f"{len(accepted):,} accepted of {counted(len(drawn), 'draw')}"
    title = f"{space.names[gene]} [{space.units[gene]}]" if space.units[gene] else space.names[gene]
    if not len(accepted):
        return section(title, Text("no draw is accepted; `:relax` tells why", "warn"), note)
    if space.kinds[gene] == GeneKind.INDEX:
        return section(title, _options(weighing, gene, drawn, accepted, ascii_only), note)
    return section(title, _chart(weighing, gene, (drawn, accepted), width, ascii_only), note)


def _options(weighing: "Weighing", gene: int, drawn: "Floats", accepted: "Floats", ascii_only: bool) -> RenderableType:
    names = weighing.program.space.options[gene]
    shares = [np.bincount(values.astype(int), minlength=len(names)) / len(values) for values in (drawn, accepted)]
    rows = []
    for name, before, after in zip(names, *shares, strict=True):
        filled = "#" * round(after * OPTIONS_BAR) if ascii_only else bar(float(after), 1.0, OPTIONS_BAR)
        rows.append((Text(name), Text(percent(before), "quiet"), Text(percent(after)), Text(filled, "bar")))
    return columns(left(), right("drawn"), right("accepted"), left(), rows=rows, header=True)


def _chart(
    weighing: "Weighing", gene: int, values: "tuple[Floats, Floats]", width: int, ascii_only: bool
) -> RenderableType:
    space, (_, accepted) = weighing.program.space, values
    low, high = float(space.low[gene]), float(space.high[gene])
    room = min(WIDEST, width - 8)
    bins = max(FEWEST_COLUMNS, min(room, len(accepted) // DRAWS_IN_A_COLUMN))
    edges = _edges(low, high, bins, whole=space.kinds[gene] == GeneKind.INTEGER)
    before, after = (np.histogram(each, bins=edges)[0] / len(each) for each in values)
    heights = np.stack((after, before)) / max(float(before.max()), float(after.max())) * ROWS
    heights = np.repeat(heights, max(1, room // len(before)), axis=1)
    lines = [_line(heights[0], heights[1], row, ascii_only) for row in reversed(range(ROWS))]
    ends = [format_gene(space, gene, end) for end in (low, high)]
    axis = Text(("-" if ascii_only else "─") * len(heights[0]), "quiet")
    scale = Text(f"{ends[0]}{ends[1]:>{max(1, len(heights[0]) - len(ends[0]))}}", "quiet")
    return Group(*lines, axis, scale, _middle(weighing, gene, accepted, ascii_only))


def _middle(weighing: "Weighing", gene: int, accepted: "Floats", ascii_only: bool) -> Text:
    """Median and the bulk of the accepted values, and what the dots are."""
    space = weighing.program.space
    values = [format_gene(space, gene, float(np.quantile(accepted, q))) for q in (0.05, 0.5, 0.95)]
    return Text.assemble(
        ("accepted: ", "quiet"),
        f"median {values[1]}, nine tenths in {values[0]} .. {values[2]}",
        ("   . " if ascii_only else "   · ", "warn"),
        ("as drawn", "quiet"),
    )


def _edges(low: float, high: float, most: int, *, whole: bool) -> "Floats":
    """Ends of the columns; of whole numbers each column holds equally many."""
    if not whole:
        return np.linspace(low, high, most + 1)
    step = int((high - low) // most) + 1
    return np.arange(low - 0.5, high + 0.5 + step, step)


def _line(after: "Floats", before: "Floats", row: int, ascii_only: bool) -> Text:
    """One row of characters; the columns are filled up to their heights."""
    line = Text()
    for height, prior in zip(after.tolist(), before.tolist(), strict=True):
        part = height - row
        if part >= 1 - 1 / 16:
            line.append("#" if ascii_only else EIGHTHS[8], "bar")
        elif row <= prior < row + 1 and part < 0.5:
            line.append("." if ascii_only else "·", "warn")
        elif part > 1 / 16:
            line.append(":" if ascii_only else LEVELS[min(7, int(part * 8))], "bar")
        else:
            line.append(" ")
    return line
