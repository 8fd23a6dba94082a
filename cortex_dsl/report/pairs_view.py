"""How near the ego came to everybody else: a line for each pair that did not decide the risk."""

from collections.abc import Sequence

import numpy as np
from rich.console import RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right, section
from cortex_dsl.report.numbers import fixed
from cortex_dsl.report.speeds import SpeedUnit
from cortex_dsl.report.theme import actor_style
from engine.outcomes import Outcomes

MOST = 12


def further_pairs(outcomes: Outcomes, actors: Sequence[str], pair: int, unit: SpeedUnit) -> list[RenderableType]:
    """A section with a line for each pair beside the deciding one, the nearest first; nothing where there is none."""
    nearest = [k for k in np.argsort(outcomes.min_distance[0], kind="stable").tolist() if k != pair]
    if not nearest:
        return []
    rows = [_row(outcomes, actors, k, unit) for k in nearest[:MOST]]
    head = (left(wrap=True), right("MD"), left(), right("MS"), right("D_MS"), right("TTC_MS"))
    more = "" if len(nearest) <= MOST else f", the nearest {MOST} of {len(nearest):,}"
    return [section("Further pairs", columns(*head, rows=rows, header=True), f"{actors[0]} and …{more}")]


def _row(outcomes: Outcomes, actors: Sequence[str], pair: int, unit: SpeedUnit) -> tuple[Text, ...]:
    def value(array: object) -> float:
        return float(array[0, pair])  # type: ignore[index]

    who = Text(actors[pair + 1], actor_style(pair + 1))
    if not np.isfinite(value(outcomes.min_distance)):
        return who, Text("never met", "quiet"), *map(Text, ("", "", "", ""))
    return (
        who,
        Text(f"{fixed(value(outcomes.min_distance), 2)} m"),
        Text(f"at {fixed(value(outcomes.min_distance_time), 2)} s", "quiet"),
        Text(unit.text(value(outcomes.max_closing_speed))),
        Text(f"{fixed(value(outcomes.distance_at_ms), 2)} m"),
        Text(f"{fixed(value(outcomes.ttc_at_ms), 2)} s"),
    )
