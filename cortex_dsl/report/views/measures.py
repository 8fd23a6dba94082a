"""Details of one run: its course, its metrics, the risk with its parts, further pairs, records, params and choices."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cortex_dsl.report.blocks import (
    Block,
    Column,
    Curve,
    Gauge,
    Line,
    Note,
    Place,
    Spark,
    Table,
    Title,
    Value,
    Words,
    actor_style,
)
from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.report.findings.objectives import Weighed
from cortex_dsl.report.findings.readable import (
    ABSENT,
    KM_H,
    M_S,
    NOT_LEVEL,
    SpeedUnit,
    column_decimals,
    fixed,
    format_gene,
    significant,
)
from cortex_dsl.report.findings.run_report import HIGHEST, PARTS, RunReport
from cortex_dsl.report.views.run import objectives_table, records_table, timeline
from cortex_dsl.semantics.names.linking import FixedParam
from engine.metrics import Metric, apart_in_height, never_on_one_level
from engine.outcomes import PAIRS, Outcomes
from engine.program import ParamSpace, Program
from engine.risk import BANDS, PROFILES, Edges, RiskProfile
from engine.scenes import Scenes, Trajectory
from engine.tables import Floats
from engine.vocabulary import GeneKind, Sense, State

NUMBER, WRAPS = Column(numbers=True), Column(wrap=True)


def run_details(report: RunReport) -> list[Title]:
    """Return the details of a run for `--metrics`."""
    program, end = report.program, float(report.outcomes.end_time[0])
    genome, held = report.scenes.genomes[0], report.held
    views = [
        Title("All events", [timeline(report.story, program.actors)]),
        course(report.trajectory, program.actors, end, report.pair, report.unit),
    ]
    if found := report.objective_results:
        views.append(Title("All objectives", [objectives_table(found)], "above 0 an expectation is kept"))
    if report.records:
        views.append(Title("All records", [records_table(report.records, drawn=True)], "up to contact or the end"))
    views += _judgement(report) if report.valid else []
    if len(program.space) or held:
        views.append(Title("All params", [params_table(program.space, genome, held)]))
    return [*views, *choices_views(program, report.scenes)]


def _judgement(report: RunReport) -> Iterator[Title]:
    """Yield metrics and risk, of the deciding pair if there is one."""
    actors = report.program.actors
    if report.outcomes.min_distance.shape[1]:
        names = f"{actors[0]} and {actors[report.pair + 1]}"
        table = metrics_table(report.outcomes, report.pair, report.unit, report.trajectory)
        yield Title("Metrics", [table], names)
        yield risk_view(report.score, report.parts, report.profile)
        yield from further_pairs(report.outcomes, actors, report.pair, report.unit, report.trajectory)
    measures = measures_blocks(report.metrics, actors, report.pair, report.unit)
    yield Title("Other measures", measures, "not part of the risk")


# -- the course of speeds and distance ---------------------------------------------------------------------------------


def course(
    trajectory: Trajectory, actors: Sequence[str], end: float, pair: int, unit: SpeedUnit = KM_H, *, paired: bool = True
) -> Title:
    """Return the speed of each actor, and the distance between the centres of the deciding pair, up to `end` [s]."""
    scored = trajectory.time <= end + 1e-9
    lines = [
        _line(Value(name, actor_style(k)), trajectory, k, unit.per_si * trajectory.states[:, k, State.SPEED], unit.name)
        for k, name in enumerate(actors[: len(trajectory.outlines)])
    ]
    if len(actors) > 1:
        between = trajectory.states[:, pair + 1, : State.HEADING] - trajectory.states[:, 0, : State.HEADING]
        apart = np.where(apart_in_height(trajectory, pair + 1), np.nan, np.hypot(between[:, 0], between[:, 1]))
        lines.append(_line(Value("apart", "warn"), trajectory, pair + 1, apart, "m"))
    both = len(actors) > 1 and paired
    note = f"speeds, and the distance between the centres of {actors[0]} and {actors[pair + 1]}" if both else "speed"
    shown = [Line(label, values[scored].tolist(), _range(values[scored], unit)) for label, values, unit in lines]
    if len(actors) > 1 and never_on_one_level(trajectory, pair + 1):
        shown[-1] = replace(shown[-1], extent=NOT_LEVEL)
    return Title("Over time", [Curve(shown, end)], note)


def _line(label: Value, trajectory: Trajectory, actor: int, values: Floats, unit: str) -> tuple[Value, Floats, str]:
    """Return a line of a curve; NaN where the actor is absent."""
    return label, np.where(trajectory.states[:, actor, State.PRESENT] > 0.5, values, np.nan), unit


def _range(values: Floats, unit: str) -> str:
    known = values[np.isfinite(values)]
    return f"{fixed(float(known.min()), 1)} .. {fixed(float(known.max()), 1)} {unit}" if len(known) else ""


# -- the metrics of the risk, and its parts ----------------------------------------------------------------------------

MEANINGS: Mapping[str, str] = {
    "MD": "least distance between outlines",
    "MS": "fastest closing speed",
    "D_MS": "distance between outlines at MS",
    "TTC_MS": "time to collision at MS: D_MS / MS",
}
"""Meanings of the metrics behind the score."""
IN_RISK = frozenset(row.symbol for row in PAIRS if row.of_risk)


def metrics_table(outcomes: Outcomes, pair: int, unit: SpeedUnit = KM_H, trajectory: Trajectory | None = None) -> Table:
    """Return the metrics of a pair of the first run, with the time of each; `unit`: that of speeds."""
    rows = []
    apart = trajectory is not None and never_on_one_level(trajectory, pair + 1)
    for metric in (each for each in PAIRS if each.of_risk):
        number, when = (float(getattr(outcomes, name)[0, pair]) for name in (metric.name, metric.when))
        speed = metric.unit == M_S.name
        text, name = (unit.number(number, 2), unit.name) if speed else (fixed(number, 2), metric.unit)
        value = Value(text, "", number), Value(f" {name:<4}", "unit")
        at = Value(f"at {fixed(when, 2)} s", "quiet", when)
        if apart:
            value, at = (Value(NOT_LEVEL, "quiet", number),), Value("", "quiet", when)
        rows.append((Value(metric.symbol, "title"), value, MEANINGS[metric.symbol], at))
    return Table((Column(), NUMBER, WRAPS, NUMBER), rows, header=False, name="params")


def risk_view(score: int, parts: Sequence[float], profile: str) -> Title:
    """Return the score, its bar, and each part with the band of the metric that gives these points."""
    points = [round(each) for each in parts]
    bars = [
        Gauge(style=f"part.{row[0]}", share=1.0, length=each) for row, each in zip(PARTS, points, strict=True) if each
    ]
    total = Value(f"{score:>2}", "title", score), Value(f" of {HIGHEST}  ", "quiet")
    rest = Value("·" * (HIGHEST - sum(points)), "quiet")
    return Title("Risk", [Note((*total, *bars, rest)), risk_table(parts, PROFILES[profile])], f"profile {profile}")


def risk_table(parts: Sequence[float], profile: RiskProfile) -> Table:
    """Return a row per part of the risk: points, bar, and band."""
    edges = (None, profile.min_distance, profile.distance_at_ms, profile.ttc_at_ms)
    rows = [
        (
            Value(name, f"part.{name}"),
            Value(fixed(points, 0), "", points),
            Value(f"of {most}", "quiet"),
            Gauge(style=f"part.{name}", share=points / most, length=most, rest="·"),
            Value(_band(ends, round(points), unit) if ends else "contact" if points else "no contact", "quiet"),
        )
        for (name, most, unit), points, ends in zip(PARTS, parts, edges, strict=True)
    ]
    return Table((Column(), NUMBER, Column(), Column(), Column()), rows, header=False, name="risk")


def _band(edges: Edges, points: int, unit: str) -> str:
    """Return the range of a metric that scores this number of points, e.g. `8.2 to 11 m`."""
    if points >= BANDS:
        return f"below {edges[0]:g} {unit}"
    if points <= 0:
        return f"not below {edges[-1]:g} {unit}"
    return f"{edges[BANDS - points - 1]:g} to {edges[BANDS - points]:g} {unit}"


# -- measures outside the risk -----------------------------------------------------------------------------------------

SECOND, METRE = "s", "m"
"""Units of metrics for which less is worse; for all other units, which measure a need, more is worse."""


def measures_blocks(metrics: Sequence[Metric], actors: Sequence[str], pair: int, unit: SpeedUnit = KM_H) -> list[Block]:
    """Return the metrics of the deciding pair with their meaning, then those of its two actors side by side.

    Below them are the meanings of infinite and missing values. Speeds are in `unit`.
    """
    known = [_in_unit(metric, unit) for metric in metrics]
    of_pair = [metric for metric in known if metric.actors == (0, pair + 1) and metric.name not in IN_RISK]
    of_actors = [metric for metric in known if metric.actors in ((0,), (pair + 1,))]
    widest = max((len(metric.unit) for metric in of_pair), default=0)
    pairs = [
        (Value(m.name, "title"), (_number(m), Value(f" {m.unit:<{widest}}" * bool(widest), "unit")), m.meaning)
        for m in of_pair
    ]
    both = [
        (Value(name, "title"), _side_by_side([m for m in of_actors if m.name == name], actors))
        for name in dict.fromkeys(metric.name for metric in of_actors)
    ]
    tables = ((Column(), NUMBER, WRAPS), pairs), ((Column(), WRAPS), both)
    shown: list[Block] = [Table(head, rows, header=False, name="params") for head, rows in tables if rows]
    return [*shown, Note(_signs([*of_pair, *of_actors]), "quiet")]


def _number(metric: Metric) -> Value:
    return Value(fixed(metric.value, 2), "", metric.value)


def _signs(metrics: Sequence[Metric]) -> str:
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


def _in_unit(metric: Metric, unit: SpeedUnit) -> Metric:
    return replace(metric, value=unit.per_si * metric.value, unit=unit.name) if metric.unit == M_S.name else metric


def _side_by_side(metrics: Sequence[Metric], actors: Sequence[str]) -> Words:
    """Return each actor with its value, and the unit once."""
    words: list[str | Value] = []
    for metric in metrics:
        for actor in metric.actors:
            words += [", "] * bool(words) + [Value(actors[actor], actor_style(actor)), " ", _number(metric)]
    return [*words, Value(f" {metrics[0].unit}", "unit")]


# -- distances of the ego to the actors that did not decide the risk ---------------------------------------------------

MOST = 12


def further_pairs(
    outcomes: Outcomes, actors: Sequence[str], pair: int, unit: SpeedUnit, trajectory: Trajectory | None = None
) -> list[Title]:
    """Return a view with a line for each pair except the deciding one, the nearest first; empty without any."""
    nearest = [k for k in np.argsort(outcomes.min_distance[0], kind="stable").tolist() if k != pair]
    if not nearest:
        return []
    rows = [_pair_row(outcomes, actors, k, unit, trajectory) for k in nearest[:MOST]]
    numbers = [Column(head, numbers=True) for head in ("MS", "D_MS", "TTC_MS")]
    columns = WRAPS, Column("MD", numbers=True), Column(), *numbers
    more = "" if len(nearest) <= MOST else f", the nearest {MOST} of {len(nearest):,}"
    return [Title("Further pairs", [Table(columns, rows, name="pairs")], f"{actors[0]} and …{more}")]


def _pair_row(
    outcomes: Outcomes, actors: Sequence[str], pair: int, unit: SpeedUnit, trajectory: Trajectory | None
) -> Sequence[Words]:
    name = Value(actors[pair + 1], actor_style(pair + 1))
    distance, time, speed, at_ms, ttc = (
        float(values[0, pair])
        for values in (
            outcomes.min_distance,
            outcomes.min_distance_time,
            outcomes.max_closing_speed,
            outcomes.distance_at_ms,
            outcomes.ttc_at_ms,
        )
    )
    if not math.isfinite(distance):
        apart = trajectory is not None and never_on_one_level(trajectory, pair + 1)
        words = NOT_LEVEL if apart else "never met"
        return name, Value(words, "quiet"), "", "", "", ""
    at = Value(f"at {fixed(time, 2)} s", "quiet")
    return name, f"{fixed(distance, 2)} m", at, unit.text(speed), f"{fixed(at_ms, 2)} m", f"{fixed(ttc, 2)} s"


# -- objectives and requirements over many runs ------------------------------------------------------------------------

KEPT_BAR = HISTOGRAM = 15


def weighed_table(found: Sequence[Weighed], unit: SpeedUnit) -> Table:
    """Return a line for each objective and requirement: the share of runs that keep it, and its margin."""
    return Table((Column(), Column(), WRAPS), [_weighed_row(each, unit) for each in found], header=False)


def _weighed_row(each: Weighed, unit: SpeedUnit) -> Sequence[Words]:
    name = Value(each.name, "title")
    if not each.runs:
        return name, "", Value("no valid run to try it on", "warn")
    if each.sense in (Sense.MAXIMIZE, Sense.MINIMIZE):
        return name, histogram(each.values, "bar"), _number_line(each, unit)
    style = "good" if each.kept == each.runs else "bar"
    return name, Gauge(style=style, share=each.kept / each.runs, length=KEPT_BAR, rest=" "), _kept_line(each)


def _kept_line(each: Weighed) -> Words:
    """Return a line like `kept in 312 of 400 runs; least robustness -1.2`."""
    word = "met" if each.sense is None else "kept"
    if each.kept == each.runs:
        text = Value(f"{word} in all {each.runs:,} runs", "good")
    elif not each.kept:
        text = Value(f"broken in all {each.runs:,} runs", "bad")
    else:
        text = Value(f"{word} in {each.kept:,} of {each.runs:,} runs")
    if each.sense is None:
        return text, Value("" if each.kept == each.runs else "; the others are thrown away", "quiet")
    return text, Value(f"; least robustness {significant(float(each.values.min()))}", "quiet")


def histogram(values: Floats, style: str) -> Words:
    """Return how often values occur over their range; nothing where all are equal."""
    known = values[np.isfinite(values)]
    if not len(known) or known.min() == known.max():
        return ""
    counts, _ = np.histogram(known, HISTOGRAM)
    return Spark(style=style, values=[count or math.nan for count in counts.tolist()], length=HISTOGRAM, low=0.0)


def _number_line(each: Weighed, unit: SpeedUnit) -> Words:
    speed = each.unit == M_S.name
    values, shown = (each.values * unit.per_si, unit.name) if speed else (each.values, each.unit)
    ends = [float(np.quantile(values, q, method="nearest")) for q in (0.0, 0.5, 1.0)]
    low, middle, high = (fixed(end, column_decimals(ends[0], ends[2])) for end in ends)
    return f"{low} .. {high}", Value(f" {shown}" if shown else "", "unit"), Value(f", median {middle}", "quiet")


# -- params and choices ------------------------------------------------------------------------------------------------


def params_table(space: ParamSpace, genome: Sequence[float] | Floats, held: Sequence[FixedParam] = ()) -> Table:
    """Return every param with its value, its unit, and its place in its range; those held fixed at the end."""
    rows: list[Sequence[Words]] = [
        (
            space.names[gene],
            Value(format_gene(space, gene, float(value)), "", float(value)),
            Value(space.units[gene], "unit"),
            _place(space, gene, float(value)),
        )
        for gene, value in enumerate(genome)
    ]
    rows += [(one.name, one.text, Value(one.unit, "unit"), Value("held", "quiet")) for one in held]
    return Table((Column(), NUMBER, Column(), Column()), rows, header=False, name="params")


def _place(space: ParamSpace, gene: int, value: float) -> Value:
    if space.kinds[gene] == GeneKind.INDEX:
        return Value(f"of {', '.join(space.options[gene])}", "quiet")
    low, high = float(space.low[gene]), float(space.high[gene])
    share = (value - low) / (high - low) if high > low else 0.5
    return Place(share=share, ends=(significant(low), significant(high)))


def choices_views(program: Program, scenes: Scenes) -> list[Title]:
    """Return the random finite choices of the first scene; empty without any."""
    rows = [(name, option) for name, option in made_choices(program, scenes)]
    return [Title("Choices", [Table((Column(), WRAPS), rows, header=False, name="params")])] if rows else []
