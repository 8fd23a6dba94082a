"""Params as the file writes them: in its own units, options by their names."""

from collections.abc import Sequence

from rich.console import RenderableType
from rich.text import Text

from cortex_dsl.holding import Held
from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import format_gene, significant
from engine.program import ParamSpace
from engine.vocabulary import GeneKind

GAUGE = 21
"""Characters of the gauge that shows where in its range a param lies; odd, so that it has a middle."""


def params_view(space: ParamSpace, genome: Sequence[float], held: Sequence[Held] = ()) -> RenderableType:
    """Every param with its value, its unit, and where in its range it lies; those held fixed at the end."""
    rows = []
    for gene, value in enumerate(genome):
        rows.append(
            (
                Text(space.names[gene]),
                Text(format_gene(space, gene, float(value))),
                Text(space.units[gene], "unit"),
                _gauge(space, gene, float(value)),
            )
        )
    rows += [(Text(one.name), Text(one.text), Text(one.unit, "unit"), Text("held", "quiet")) for one in held]
    return columns(left(), right(), left(), left(), rows=rows)


def _gauge(space: ParamSpace, gene: int, value: float) -> Text:
    if space.kinds[gene] == GeneKind.INDEX:
        return Text(f"of {', '.join(space.options[gene])}", "quiet")
    low, high = float(space.low[gene]), float(space.high[gene])
    share = (value - low) / (high - low) if high > low else 0.5
    at = max(0, min(GAUGE - 1, round(share * (GAUGE - 1))))
    return Text.assemble(
        (f"{significant(low):>6} ├" + "─" * at, "quiet"),
        ("●", "bar"),
        ("─" * (GAUGE - 1 - at) + f"┤ {significant(high)}", "quiet"),
    )
