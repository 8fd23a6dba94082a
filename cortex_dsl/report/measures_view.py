"""Measures of safety that do not enter the risk, and what the actors did with wheel and pedals."""

from collections.abc import Sequence
from dataclasses import replace

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, quantity, right
from cortex_dsl.report.numbers import fixed
from cortex_dsl.report.speeds import KM_H, M_S, SpeedUnit
from cortex_dsl.report.theme import actor_style
from engine.metrics import Metric
from engine.outcomes import PAIRS

IN_RISK = frozenset(row.symbol for row in PAIRS if row.of_risk)


def measures_view(
    metrics: Sequence[Metric], actors: Sequence[str], pair: int, unit: SpeedUnit = KM_H
) -> RenderableType:
    """Those of the deciding pair with their meaning, then those of its two actors side by side.

    An infinite one says that the danger it measures was not there. Speeds are told in `unit`.
    """
    metrics = [_told(metric, unit) for metric in metrics]
    of_pair = [metric for metric in metrics if metric.actors == (0, pair + 1) and metric.name not in IN_RISK]
    of_actors = [metric for metric in metrics if metric.actors in ((0,), (pair + 1,))]
    parts: list[RenderableType] = []
    if of_pair:
        widest = max(len(metric.unit) for metric in of_pair)
        rows = [
            (Text(m.name, "title"), quantity(fixed(m.value, 2), m.unit.ljust(widest)), Text(m.meaning)) for m in of_pair
        ]
        parts.append(columns(left(), right(), left(wrap=True), rows=rows))
    names = dict.fromkeys(metric.name for metric in of_actors)
    rows = [(Text(name, "title"), _side_by_side([m for m in of_actors if m.name == name], actors)) for name in names]
    return Group(*parts, columns(left(), left(wrap=True), rows=rows))


def _told(metric: Metric, unit: SpeedUnit) -> Metric:
    return replace(metric, value=unit.per_si * metric.value, unit=unit.name) if metric.unit == M_S.name else metric


def _side_by_side(metrics: Sequence[Metric], actors: Sequence[str]) -> Text:
    """Each actor with its value, and the unit once."""
    text = Text(", ").join(
        Text.assemble((actors[actor], actor_style(actor)), f" {fixed(metric.value, 2)}")
        for metric in metrics
        for actor in metric.actors
    )
    return text.append(f" {metrics[0].unit}", "unit")
