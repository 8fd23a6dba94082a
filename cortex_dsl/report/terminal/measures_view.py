"""The measured side of a run: the risk with its parts, its metrics, other measures, further pairs, and records."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.objectives import ObjectiveResult, Weighed
from cortex_dsl.report.findings.readable import ABSENT, KM_H, M_S, SpeedUnit, column_decimals, fixed, significant
from cortex_dsl.report.findings.run_report import HIGHEST, PARTS
from cortex_dsl.report.terminal.theme import actor_style, bar, columns, left, quantity, right, section, sparkline
from engine.metrics import Metric, Recorded
from engine.outcomes import PAIRS, Outcomes
from engine.risk import BANDS, Edges, RiskProfile
from engine.vocabulary import Sense

# -- measures outside the risk, and the use of wheel and pedals --------------------------------------------------------

SECOND, METRE = "s", "m"
"""Units of metrics for which less is worse; for all other units, which measure a need, more is worse."""
IN_RISK = frozenset(row.symbol for row in PAIRS if row.of_risk)


def measures_view(
    metrics: Sequence[Metric], actors: Sequence[str], pair: int, unit: SpeedUnit = KM_H
) -> RenderableType:
    """Return the metrics of the deciding pair with their meaning, then those of its two actors side by side.

    Below them are the meanings of infinite and missing values. Speeds are in `unit`.
    """
    of_pair, of_actors = _shown([_in_unit(metric, unit) for metric in metrics], pair)
    parts: list[RenderableType] = []
    if of_pair:
        widest = max(len(metric.unit) for metric in of_pair)
        rows = [
            (Text(m.name, "title"), quantity(fixed(m.value, 2), m.unit.ljust(widest)), Text(m.meaning)) for m in of_pair
        ]
        parts.append(columns(left(), right(), left(wrap=True), rows=rows))
    names = dict.fromkeys(metric.name for metric in of_actors)
    rows = [(Text(name, "title"), _side_by_side([m for m in of_actors if m.name == name], actors)) for name in names]
    parts.append(columns(left(), left(wrap=True), rows=rows))
    return Group(*parts, Text(_note([*of_pair, *of_actors]), "quiet"))


def _note(metrics: Sequence[Metric]) -> str:
    """Return the meanings of the signs that occur among the values."""
    endless = [metric for metric in metrics if metric.value == math.inf]
    needs = dict.fromkeys(metric.name for metric in endless if metric.unit not in (SECOND, METRE))
    signs = (
        (any(metric.unit in (SECOND, METRE) for metric in endless), "∞: no such conflict"),
        (bool(needs), f"∞ of {', '.join(needs)}: no value is enough"),
        (any(metric.value == -math.inf for metric in metrics), "-∞: too late for it"),
        (any(math.isnan(metric.value) for metric in metrics), f"{ABSENT}: does not apply here"),
    )
    return "; ".join(words for there, words in signs if there)


def _shown(metrics: Sequence[Metric], pair: int) -> tuple[list[Metric], list[Metric]]:
    """Those of the deciding pair that the risk does not have, and those of its two actors."""
    of_pair = [metric for metric in metrics if metric.actors == (0, pair + 1) and metric.name not in IN_RISK]
    return of_pair, [metric for metric in metrics if metric.actors in ((0,), (pair + 1,))]


def _in_unit(metric: Metric, unit: SpeedUnit) -> Metric:
    return replace(metric, value=unit.per_si * metric.value, unit=unit.name) if metric.unit == M_S.name else metric


def _side_by_side(metrics: Sequence[Metric], actors: Sequence[str]) -> Text:
    """Each actor with its value, and the unit once."""
    text = Text(", ").join(
        Text.assemble((actors[actor], actor_style(actor)), f" {fixed(metric.value, 2)}")
        for metric in metrics
        for actor in metric.actors
    )
    return text.append(f" {metrics[0].unit}", "unit")


# -- the risk score with its parts, and the metrics it comes from ------------------------------------------------------


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
    """Return the range of a metric that scores this number of points, e.g. `8.2 to 11 m`."""
    if points >= BANDS:
        return f"below {edges[0]:g} {unit}"
    if points <= 0:
        return f"not below {edges[-1]:g} {unit}"
    return f"{edges[BANDS - points - 1]:g} to {edges[BANDS - points]:g} {unit}"


MEANINGS: Mapping[str, str] = {
    "MD": "least distance between outlines",
    "MS": "fastest closing speed",
    "D_MS": "distance between outlines at MS",
    "TTC_MS": "time to collision at MS: D_MS / MS",
}
"""Meanings of the metrics behind the score."""


def metrics_view(outcomes: Outcomes, row: int, pair: int, unit: SpeedUnit = KM_H) -> RenderableType:
    """The metrics of one pair with units, and when they were taken; `unit`: that of speeds."""

    def value(name: str) -> float:
        return float(getattr(outcomes, name)[row, pair])

    rows = []
    for metric in (each for each in PAIRS if each.of_risk):
        is_speed = metric.unit == M_S.name
        number = unit.number(value(metric.name), 2) if is_speed else fixed(value(metric.name), 2)
        shown_unit = unit.name if is_speed else metric.unit
        rows.append(_metric(metric.symbol, number, shown_unit, MEANINGS[metric.symbol], value(metric.when)))
    return columns(left(), right(), left(wrap=True), right(), rows=rows)


def _metric(name: str, number: str, unit: str, meaning: str, time: float) -> tuple[Text, Text, Text, Text]:
    return Text(name, "title"), quantity(number, f"{unit:<4}"), Text(meaning), Text(f"at {fixed(time, 2)} s", "quiet")


# -- distances of the ego to all other actors: a line for each pair that did not decide the risk -----------------------

MOST = 12


def further_pairs(outcomes: Outcomes, actors: Sequence[str], pair: int, unit: SpeedUnit) -> list[RenderableType]:
    """Return a section with a line for each pair except the deciding one, the nearest first; empty without any."""
    nearest = [k for k in np.argsort(outcomes.min_distance[0], kind="stable").tolist() if k != pair]
    if not nearest:
        return []
    rows = [_pair_row(outcomes, actors, k, unit) for k in nearest[:MOST]]
    head = (left(wrap=True), right("MD"), left(), right("MS"), right("D_MS"), right("TTC_MS"))
    more = "" if len(nearest) <= MOST else f", the nearest {MOST} of {len(nearest):,}"
    return [section("Further pairs", columns(*head, rows=rows, header=True), f"{actors[0]} and …{more}")]


def _pair_row(outcomes: Outcomes, actors: Sequence[str], pair: int, unit: SpeedUnit) -> tuple[Text, ...]:
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


# -- expectations of the file, and objectives of a search --------------------------------------------------------------


def objectives_view(found: Sequence[ObjectiveResult]) -> RenderableType:
    """Return name, verdict and margin of each expectation; the value of a number."""
    return columns(left(wrap=True), left(), right(), rows=[_objective_row(each) for each in found])


def _objective_row(each: ObjectiveResult) -> tuple[RenderableType, RenderableType, RenderableType]:
    if each.broken is None:
        return (
            Text(each.name, "title"),
            Text(each.sense.name.lower(), "quiet"),
            quantity(significant(each.value), each.unit),
        )
    verdict = Text("broken", "bad") if each.broken else Text("kept", "good")
    return Text(each.name, "title"), verdict, Text(f"robustness {significant(each.value)}", "quiet")


KEPT_BAR = 15
HISTOGRAM = 15


def weighed_view(found: Sequence[Weighed], unit: SpeedUnit, *, ascii_only: bool = False) -> RenderableType:
    """One line for each objective and requirement: in how many runs it holds, and how nearly; speeds in `unit`."""
    rows = [_weighed_row(each, unit, ascii_only) for each in found]
    return columns(left(), left(), left(wrap=True), rows=rows)


def _weighed_row(each: Weighed, unit: SpeedUnit, ascii_only: bool) -> tuple[RenderableType, ...]:
    if not each.runs:
        return Text(each.name, "title"), Text(), Text("no valid run to try it on", "warn")
    if each.sense in (Sense.MAXIMIZE, Sense.MINIMIZE):
        return Text(each.name, "title"), Text(_counts(each, ascii_only), "bar"), _number_line(each, unit)
    filled = round(each.kept / each.runs * KEPT_BAR)
    gauge = "#" * filled if ascii_only else bar(each.kept, each.runs, KEPT_BAR)
    gauge = f"{gauge:<{KEPT_BAR}}"
    return Text(each.name, "title"), Text(gauge, "good" if each.kept == each.runs else "bar"), _kept_line(each)


def _kept_line(each: Weighed) -> Text:
    """Return a line like `kept in 312 of 400 runs; least robustness -1.2`."""
    word = "met" if each.sense is None else "kept"
    if each.kept == each.runs:
        text = Text(f"{word} in all {each.runs:,} runs", "good")
    elif not each.kept:
        text = Text(f"broken in all {each.runs:,} runs", "bad")
    else:
        text = Text(f"{word} in {each.kept:,} of {each.runs:,} runs")
    if each.sense is None:
        return text.append("" if each.kept == each.runs else "; the others are thrown away", "quiet")
    return text.append(f"; least robustness {significant(float(each.values.min()))}", "quiet")


def _counts(each: Weighed, ascii_only: bool) -> str:
    """A histogram in one line."""
    values = each.values[np.isfinite(each.values)]
    if ascii_only or not len(values) or values.min() == values.max():
        return ""
    counts, _ = np.histogram(values, HISTOGRAM)
    return sparkline([count or float("nan") for count in counts.tolist()], HISTOGRAM, low=0.0)


def _number_line(each: Weighed, unit: SpeedUnit) -> Text:
    is_speed = each.unit == M_S.name
    values = each.values * (unit.per_si if is_speed else 1.0)
    shown = unit.name if is_speed else each.unit
    ends = [float(np.quantile(values, q, method="nearest")) for q in (0.0, 0.5, 1.0)]
    low, middle, high = (fixed(end, column_decimals(ends[0], ends[2])) for end in ends)
    return Text.assemble(f"{low} .. {high}", (f" {shown}" if shown else "", "unit"), (f", median {middle}", "quiet"))


# -- records of the file: one line a record, a curve if it was recorded over time --------------------------------------

WHEN = {"initial": "at the start", "final": "at the end"}
LONGEST_CURVE = 40
BESIDE_CURVE = 60
"""Columns that the rest of a line needs."""


def records_view(records: Sequence[Recorded], width: int) -> RenderableType:
    """Name, curve or moment, and the value or the range of the values."""
    room = max(8, min(LONGEST_CURVE, width - BESIDE_CURVE))
    rows = [
        (Text(record.name, "title"), _record_course(record, room), quantity(_extent(record), record.unit))
        for record in records
    ]
    return columns(left(wrap=True), left(), right(), rows=rows)


def _record_course(record: Recorded, width: int) -> Text:
    if record.when in WHEN:
        return Text(WHEN[record.when], "quiet")
    return Text(sparkline(record.values.tolist(), width), "bar")


def _extent(record: Recorded) -> str:
    """The value, or the range of the values that are numbers."""
    known = record.values[~np.isnan(record.values)]
    if len(known) == 0:
        return ABSENT
    low, high = significant(float(known.min())), significant(float(known.max()))
    return low if low == high else f"{low} .. {high}"
