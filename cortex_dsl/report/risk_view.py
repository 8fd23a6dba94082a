"""The risk score with its parts, and the metrics it comes from."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, quantity, right
from cortex_dsl.report.numbers import fixed
from cortex_dsl.report.run_document import HIGHEST, PARTS
from cortex_dsl.report.speeds import KM_H, SpeedUnit
from engine.risk import BANDS, Edges, RiskProfile
from engine.scenes import Outcomes


def risk_bar(parts: Sequence[float], *, ascii_only: bool = False) -> Text:
    """One character a point, each part in its colour, the rest of the 22 as dots."""
    text = Text()
    for (name, _, _), points in zip(PARTS, parts, strict=True):
        text.append(("#" if ascii_only else "█") * round(points), f"part.{name}")
    text.append("·" * (HIGHEST - len(text)), "quiet")
    return text


def risk_view(score: int, parts: Sequence[float], profile: RiskProfile, *, ascii_only: bool = False) -> RenderableType:
    """The score, its bar, and a line per part with the band of the metric that gives these points."""
    total = Text.assemble(
        (f"{score:>2}", "title"), (f" of {HIGHEST}  ", "quiet"), risk_bar(parts, ascii_only=ascii_only)
    )
    rows = []
    edges = (None, profile.min_distance, profile.distance_at_ms, profile.ttc_at_ms)
    for (name, most, unit), points, ends in zip(PARTS, parts, edges, strict=True):
        block = "#" if ascii_only else "█"
        gauge = Text.assemble((block * round(points), f"part.{name}"), ("·" * (most - round(points)), "quiet"))
        rows.append(
            (
                Text(name, f"part.{name}"),
                Text(fixed(points, 0)),
                Text(f"of {most}", "quiet"),
                gauge,
                Text(_band(ends, round(points), unit) if ends else "contact" if points else "no contact", "quiet"),
            )
        )
    return Group(total, columns(left(), right(), left(), left(), left(), rows=rows))


def _band(edges: Edges, points: int, unit: str) -> str:
    """Where a metric lies that scores so many points, e.g. `8.2 to 11 m`."""
    if points >= BANDS:
        return f"below {edges[0]:g} {unit}"
    if points <= 0:
        return f"not below {edges[-1]:g} {unit}"
    return f"{edges[BANDS - points - 1]:g} to {edges[BANDS - points]:g} {unit}"


def metrics_view(outcomes: Outcomes, row: int, pair: int, unit: SpeedUnit = KM_H) -> RenderableType:
    """The metrics of one pair with units, and when they were taken; `unit`: that of speeds."""

    def value(array: object) -> float:
        return float(array[row, pair])  # type: ignore[index]

    at_closest, at_fastest = value(outcomes.min_distance_time), value(outcomes.max_closing_time)
    fastest = unit.number(value(outcomes.max_closing_speed), 2)
    rows = [
        _metric("MD", fixed(value(outcomes.min_distance), 2), "m", "least distance between outlines", at_closest),
        _metric("MS", fastest, unit.name, "fastest closing speed", at_fastest),
        _metric("D_MS", fixed(value(outcomes.distance_at_ms), 2), "m", "distance between outlines then", at_fastest),
        _metric("TTC_MS", fixed(value(outcomes.ttc_at_ms), 2), "s", "time to collision then: D_MS / MS", at_fastest),
    ]
    return columns(left(), right(), left(wrap=True), right(), rows=rows)


def _metric(name: str, number: str, unit: str, meaning: str, time: float) -> tuple[Text, Text, Text, Text]:
    return Text(name, "title"), quantity(number, f"{unit:<4}"), Text(meaning), Text(f"at {fixed(time, 2)} s", "quiet")
