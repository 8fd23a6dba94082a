"""What one more requirement does: acceptance before and after, a bar for each, and what is left of the params."""

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.blame_view import blame_view
from cortex_dsl.report.layout import columns, indented, left, right
from cortex_dsl.report.numbers import column_decimals, fixed, percent
from cortex_dsl.report.sparkline import bar
from engine.vocabulary import GeneKind

if TYPE_CHECKING:
    from engine.acceptance import Account, Blame, Weighing
    from engine.tables import Floats

BAR = 16
LEAST_SHRINK = 0.05
"""Share of a range that must be gone before it is told."""
FEWEST = 40
"""Accepted draws below which their range says little."""
MOST_ROWS = 8


def weighing_view(
    before: "Weighing | None", account: "Account", fresh: Collection[int], *, ascii_only: bool = False
) -> RenderableType:
    """`fresh`: the requirements that were entered just now."""
    after = account.weighing
    parts: list[RenderableType] = [_headline(before, after, ascii_only=ascii_only)]
    if not after.accepted.any():
        return Group(*parts, indented(blame_view(account)))
    failing = [b for b in account.blames if b.alone < 1.0 or b.requirement in fresh]
    shown = [b for b in failing if b.requirement in fresh] + [b for b in failing if b.requirement not in fresh]
    if shown:
        kept = sorted(shown[:MOST_ROWS], key=failing.index)
        parts.append(indented(_table(account, kept, fresh, ascii_only=ascii_only)))
    if remains := list(_remains(before, after)):
        parts.append(indented(Text.assemble(("left of ", "quiet"), Text(", ").join(remains))))
    return Group(*parts)


def _headline(before: "Weighing | None", after: "Weighing", *, ascii_only: bool) -> Text:
    new = percent(after.acceptance, 2 if after.acceptance < 0.1 else 1)
    style = "bad" if after.acceptance == 0 else "warn" if after.acceptance < 0.01 else "good"
    if before is None or before.acceptance == after.acceptance:
        return Text.assemble((new, style), " of draws accepted", ("" if before is None else ", as before", "quiet"))
    old = percent(before.acceptance, 2 if before.acceptance < 0.1 else 1)
    arrow = "->" if ascii_only else "→"
    return Text.assemble((f"{old} {arrow} ", "quiet"), (new, style), " of draws accepted")


def _table(account: "Account", blames: "list[Blame]", fresh: Collection[int], *, ascii_only: bool) -> RenderableType:
    rows = []
    for blame in blames:
        style = "title" if blame.requirement in fresh else ""
        filled = "#" * round(blame.alone * BAR) if ascii_only else bar(blame.alone, 1.0, BAR)
        name = account.weighing.program.requirements[blame.requirement].name
        rows.append(
            (
                Text(name, style),
                Text(filled, "bar"),
                Text(percent(blame.alone)),
                Text(percent(blame.given_earlier)),
            )
        )
    head = (left("", wrap=True), left("holds"), right("alone"), right("after earlier"))
    return columns(*head, rows=rows, header=True)


def _remains(before: "Weighing | None", after: "Weighing") -> Iterator[Text]:
    """For each param whose range shrank clearly, what remains of it."""
    space = after.program.space
    rows = after.genomes[after.accepted]
    if len(rows) < FEWEST:
        return
    least = max(LEAST_SHRINK, 8.0 / len(rows))
    same = before is not None and before.program.space.names == space.names and before.accepted.any()
    old = before.genomes[before.accepted] if same and before is not None else after.genomes
    for gene, name in enumerate(space.names):
        if space.kinds[gene] == GeneKind.INDEX:
            continue
        (low, high), (old_low, old_high) = _range(rows[:, gene]), _range(old[:, gene])
        if (old_high - old_low) - (high - low) > least * float(space.high[gene] - space.low[gene]):
            decimals = max(0, column_decimals(float(space.low[gene]), float(space.high[gene])) - 1)
            ends = " .. ".join(fixed(value, decimals) for value in (low, high))
            yield Text.assemble((name, "title"), f" {ends}", (f" {space.units[gene]}".rstrip(), "unit"))


def _range(values: "Floats") -> tuple[float, float]:
    return float(values.min()), float(values.max())
